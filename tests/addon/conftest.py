"""What the tests of the add-on share: the extension, whose modules they import, and what several of them begin with."""

import pytest

from support import checkout

checkout.extension()


@pytest.fixture(autouse=True)
def nothing_left(extension):
    """After each test no panel asks anything, and no worker runs."""
    yield
    extension.addon.work.queue.unregister()
    extension.addon.work.process.unregister()


@pytest.fixture
def file(tmp_path, glossy, write_astm):
    """A file of the synthetic measurement."""
    return write_astm(tmp_path / "glossy.astm", glossy)
