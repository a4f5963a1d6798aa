"""How Sphinx builds the site; ``python -m tools.docs`` runs it, with the tag `manual` for the part in the extension."""

import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT))
_only_manual = tags.has("manual")           # noqa: F821 (Sphinx defines it)

project = "Measured BRDF"
version = release = tomllib.loads((ROOT / "blender_manifest.toml").read_text("utf-8"))["version"]
html_title = f"{project} {version}"
root_doc = "manual" if _only_manual else "index"
extensions = ["myst_parser"] if _only_manual else ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]

myst_heading_anchors = 4
suppress_warnings = ["misc.highlighting_failure", "myst.header"]     # pages take parts of reports, with their headings

default_role = "py:obj"
autodoc_member_order = "bysource"
autodoc_typehints = "none"                  # the docstrings say them, with shapes and units
napoleon_google_docstring = False
napoleon_use_ivar = True
napoleon_use_rtype = False

html_theme = "furo"
html_static_path = ["static"]
html_css_files = ["style.css"]
html_copy_source = html_show_sourcelink = False
html_use_index = not _only_manual
html_show_sphinx = html_show_copyright = False
html_show_search_summary = False            # they are fetched, which browsers refuse from local files
pygments_style = "friendly"
pygments_dark_style = "native"
