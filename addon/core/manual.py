"""Opens the manual, which is part of the extension: from a button, and with F1 over a control.

It is HTML that `make zip` builds (``python -m tools.docs``), or on the web, where the manifest names a website and
Blender may go online. A checkout without either has the Markdown.
"""

import tomllib
from pathlib import Path

import bpy

_ROOT = Path(__file__).parents[2]
HTML = _ROOT / "docs" / "html"
MARKDOWN = _ROOT / "docs" / "manual.md"
REDIRECTS = "f1"            # pages that lead to an anchor: what opens a file in a browser drops `#...`
WEBSITE: str = tomllib.loads((_ROOT / "blender_manifest.toml").read_text("utf-8")).get("website", "").rstrip("/")

_OPERATORS = "bpy.ops.measured_brdf."
_MATERIAL = "bpy.types.measuredmaterial."
_PREFERENCES = "bpy.types.measuredpreferences."
_READING = ("angles", "quantity", "illuminant", "isotropic", "symmetry", "encoding")
# what F1 is pressed over, and the page and heading that treats it; the first that fits is taken
TOPICS: tuple[tuple[str, str], ...] = (
    *((f"{_OPERATORS}{name}", "manual#get-data-in") for name in
      ("browse", "import_data", "import_folder", "choose_sample")),
    (f"{_OPERATORS}say_units", "formats#if-the-file-does-not-say"),
    *((f"{_OPERATORS}{name}", "manual#fit") for name in ("fit", "cancel")),
    *((f"{_OPERATORS}{name}", "manual#compare") for name in ("pin", "render_look", "large_view")),
    (f"{_OPERATORS}adjust", "manual/adjusting#adjust-and-mix"),
    *((f"{_OPERATORS}{name}", "manual/adjusting#mix-measured-materials") for name in ("mix", "add_node")),
    (f"{_OPERATORS}use_preset", "manual#choose-what-it-may-cost"),
    *((f"{_OPERATORS}{name}", "manual/engines#choose") for name in ("enable_osl", "use_method")),
    *((f"{_OPERATORS}{name}", "manual#render") for name in ("check_scene", "fix_setting")),
    *((f"{_OPERATORS}{name}", "manual#keep-and-reuse") for name in ("find_file", "save_asset", "make_local")),
    *((f"{_OPERATORS}{name}", "manual#start-from-the-library") for name in
      ("use_published", "search_published", "add_starter_library")),
    (f"{_OPERATORS}inspect", "manual#look-at-the-lobe"),
    (f"{_OPERATORS}convert_folder", "manual#a-folder-into-an-asset-library"),
    (f"{_OPERATORS}update_materials", "manual#files-of-an-older-version"),
    *((f"{_MATERIAL}{name}", "formats#if-the-file-does-not-say") for name in _READING),
    *((f"{_MATERIAL}{name}", "manual#get-data-in") for name in ("filepath", "sample")),
    (f"{_MATERIAL}shown_*", "manual#look-before-you-fit"),
    (f"{_MATERIAL}rendering", "manual/engines#choose"),
    *((f"{_MATERIAL}{name}", "manual/adjusting#adjust-and-mix") for name in
      ("diffuse_gain", "diffuse_tint", "highlight_*", "coat*")),
    (f"{_MATERIAL}*", "manual#choose-what-it-may-cost"),
    ("bpy.types.measuredcomparison.*", "manual#compare"),
    (f"{_PREFERENCES}*", "manual#preferences"),
    ("bpy.types.measuredshelf.data_search", "manual#your-data-folder"),
    ("bpy.types.measuredshelf.*", "manual#start-from-the-library"),
    (f"{_OPERATORS}*", "manual"),
    ("bpy.types.scene.measured_brdf_comparison*", "manual#compare"),
    ("bpy.types.material.measured_brdf*", "manual"),
)


def topics() -> list[str]:
    """The headings that F1 leads to, as ``page#anchor``, each once."""
    return sorted({topic for _, topic in TOPICS if "#" in topic})


def file_name(topic: str) -> str:
    """The name of the page that leads to a topic, without its extension."""
    return topic.replace("/", "-").replace("#", "--")


def url(topic: str = "manual") -> str:
    """Where a topic of the manual is opened: on the web, from the extension, or as Markdown."""
    page, _, anchor = topic.partition("#")
    if WEBSITE and bpy.app.online_access:
        return f"{WEBSITE}/{page}.html" + (f"#{anchor}" if anchor else "")
    if not HTML.is_dir():
        return MARKDOWN.as_uri()
    return (HTML / REDIRECTS / f"{file_name(topic)}.html" if anchor else HTML / f"{page}.html").as_uri()


def draw_link(layout: bpy.types.UILayout) -> None:
    """Draw a button that opens the manual."""
    layout.operator("wm.url_open", text="Manual", icon="HELP").url = url()


def manual_map() -> tuple[str, tuple[tuple[str, str], ...]]:
    """What F1 opens over operators and settings of the add-on, as `bpy.utils.register_manual_map` takes it."""
    return "", tuple((pattern, url(topic)) for pattern, topic in TOPICS)


def register() -> None:
    bpy.utils.register_manual_map(manual_map)


def unregister() -> None:
    bpy.utils.unregister_manual_map(manual_map)
