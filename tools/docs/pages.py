"""The sources of the site: the Markdown of the repository, gathered in one folder, with a table of contents.

Links between pages stay; those to files at the root of the repository become links to their pages of the site.
"""

import re
import shutil
from pathlib import Path

from support.checkout import ROOT

DOCS = ROOT / "docs"
ROOT_PAGES = {"CHANGELOG.md": "changelog.md", "CONTRIBUTING.md": "contributing.md", "README.md": "index.md"}
REFERENCE = ("reference/python", "reference/operators", "reference/command_line")
MANUAL = ("start", "formats", "manual/*")       # below manual.md; what the extension holds
CONTENTS = (
    ("Use", ("start", "Manual <manual>", "formats", "layouts", "farm")),
    ("Method", ("fitting", "rendering", "Engines <engines>", "devices")),
    ("Evidence", ("results", "robustness", "stability")),
    ("Reference", REFERENCE),
    ("Project", ("changelog", "contributing", "architecture", "publishing", "pictures")),
)
_CODE = re.compile(r"(^```.*?^```$)", re.DOTALL | re.MULTILINE)
_LINK = re.compile(r"(!?)\[((?:[^\[\]]|\[[^\]]*\])*)\]\(([^)\s]+)\)")


def gather(folder: Path, only_manual: bool = False, website: str = "") -> None:
    """Fill a folder with the sources of the site, or of the manual alone, but for the generated pages.

    In the manual alone, links to other pages lead to the website; where there is none, their text stays. Its pictures
    are WebP, a quarter as large.
    """
    shutil.rmtree(folder, ignore_errors=True)
    pages = manual_pages() if only_manual else {path.relative_to(DOCS).as_posix(): path for path in DOCS.rglob("*.md")}
    if not only_manual:
        pages |= {name: ROOT / source for source, name in ROOT_PAGES.items() if name != "index.md"}
    for name, source in pages.items():
        text = _relinked(source, name, set(pages), website if only_manual else None)
        if name == "index.md":
            text += "".join(_toctree(caption, entries) for caption, entries in CONTENTS)
        elif name == "manual.md":
            text += _toctree("Manual", MANUAL if only_manual else ("manual/*",))
        _write(folder / name, text)
        for picture in pictures_of(source):
            if not (source.parent / picture).is_file():
                continue        # Sphinx says where it is shown
            target = folder / Path(name).parent / picture if source.is_relative_to(DOCS) else folder / picture
            target.parent.mkdir(parents=True, exist_ok=True)
            if only_manual:
                _as_webp(source.parent / picture, target.with_suffix(".webp"))
            else:
                shutil.copy(source.parent / picture, target)


def manual_pages() -> dict[str, Path]:
    """The pages that the extension holds, by their names in `docs/`."""
    found = [path for name in ("manual", *MANUAL) for path in sorted(DOCS.glob(f"{name}.md"))]
    return {path.relative_to(DOCS).as_posix(): path for path in found}


def pictures_of(page: Path) -> list[str]:
    """The pictures that a page shows, as it names them."""
    return [target for mark, _, target in _LINK.findall(_CODE.sub("", page.read_text("utf-8"))) if mark]


def _relinked(source: Path, name: str, pages: set[str], website: str | None) -> str:
    """The text of a page, its links as the site has them."""
    def relink(match: re.Match[str]) -> str:
        mark, text, target = match.groups()
        path, _, heading = target.partition("#")
        if not path or re.match(r"[a-z]+:", target):
            return match[0]
        if mark:
            return match[0] if website is None else f"![{text}]({Path(path).with_suffix('.webp').as_posix()})"
        linked = (source.parent / path).resolve().relative_to(ROOT).as_posix()
        page = ROOT_PAGES.get(linked, linked.removeprefix("docs/"))
        anchor = f"#{heading}" if heading else ""
        if page in pages or website is None:
            return f"[{text}]({'../' * name.count('/')}{page}{anchor})"
        return f"[{text}]({website}/{page.removesuffix('.md')}.html{anchor})" if website else text

    return "".join(part if part.startswith("```") else _LINK.sub(relink, part)
                   for part in _CODE.split(source.read_text("utf-8")))


def _as_webp(picture: Path, target: Path) -> None:
    import bpy

    image = bpy.data.images.load(str(picture))
    image.pixels[0]         # reads the file
    image.file_format, image.filepath_raw = "WEBP", str(target)
    image.save(quality=90)
    bpy.data.images.remove(image)


def _toctree(caption: str, entries: tuple[str, ...]) -> str:
    listed = "\n".join(entries)
    return f"\n```{{toctree}}\n:hidden:\n:glob:\n:caption: {caption}\n\n{listed}\n```\n"


def _write(path: Path, text: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, "utf-8")
