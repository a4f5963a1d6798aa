"""The tests here import from the extension: it is loaded before they are. The fixture `extension` registers it."""

from support import checkout

checkout.extension()
