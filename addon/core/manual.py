"""Opens the manual, which is part of the extension: from a button, and with F1 over a control.

It is HTML that `make zip` builds (``python -m tools.docs``), or on the web, where the manifest names a website and
Blender may go online. A checkout without either has the Markdown.
"""

import tomllib
from pathlib import Path

import bpy

from ...fitter.formats.reading import OPTIONS

_ROOT = Path(__file__).parents[2]
HTML = _ROOT / "docs" / "html"
MARKDOWN = _ROOT / "docs" / "manual.md"
REDIRECTS = "f1"            # pages that lead to an anchor: what opens a file in a browser drops `#...`
WEBSITE: str = tomllib.loads((_ROOT / "blender_manifest.toml").read_text("utf-8")).get("website", "").rstrip("/")

DATA_PAGE = "manual#where-to-get-data"
_OPERATORS = "bpy.ops.measured_brdf."

Topics = tuple[tuple[str, str], ...]
"""What F1 is pressed over, and the page and heading that treats it; the first that fits is taken."""


def operator_topics(topic: str, *names: str) -> Topics:
    return tuple((f"{_OPERATORS}{name}", topic) for name in names)


def setting_topics(topic: str, group: str, *names: str) -> Topics:
    """The topic of the settings in a property group; names may have wildcards."""
    return tuple((f"bpy.types.{group}.{name}", topic) for name in names)


_TOPICS: Topics = (
    *operator_topics("manual#fit", "cancel"),
    *operator_topics("manual/engines#choose", "enable_osl", "use_method"),
    *operator_topics("manual#render", "check_scene", "fix_setting"),
    *operator_topics("manual/engines#export", "check_export"),
    *operator_topics("start#the-first-material", "add_studio"),
    *operator_topics("manual#keep-and-reuse", "make_local"),
    *operator_topics("manual#files-of-an-older-version", "update_materials"),
    *operator_topics("manual/adjusting#mix-measured-materials", "add_node"),
    *setting_topics("formats#units-and-conventions", "measuredmaterial", *OPTIONS),
    *setting_topics("manual#get-data-in", "measuredmaterial", "filepath", "sample"),
    *setting_topics("manual#curves", "measuredmaterial", "shown_*"),
    *setting_topics("manual/engines#choose", "measuredmaterial", "rendering"),
    *setting_topics("manual#choose-what-it-may-cost", "measuredmaterial", "*"),
    *setting_topics("manual#preferences", "measuredpreferences", "*"),
)
_ANYTHING_ELSE: Topics = ((f"{_OPERATORS}*", "manual"), ("bpy.types.material.measured_brdf*", "manual"))
slice_topics: list[Topics] = []
"""The topics of what slices add."""


def all_topics() -> Topics:
    return (*_TOPICS, *(topic for added in slice_topics for topic in added), *_ANYTHING_ELSE)


def topics() -> list[str]:
    """The headings that F1 and buttons lead to, as ``page#anchor``, each once."""
    return sorted({DATA_PAGE, *(topic for _, topic in all_topics() if "#" in topic)})


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


def manual_map() -> tuple[str, tuple[tuple[str, str], ...]]:
    """What F1 opens over operators and settings of the add-on, as `bpy.utils.register_manual_map` takes it."""
    return "", tuple((pattern, url(topic)) for pattern, topic in all_topics())


def register() -> None:
    bpy.utils.register_manual_map(manual_map)


def unregister() -> None:
    bpy.utils.unregister_manual_map(manual_map)
