"""Checks a built site: links, anchors and pictures are there, and no page asks another host for anything."""

import re
from collections.abc import Iterator
from functools import cache
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

# what a browser fetches by itself; a link is followed only by those who click on it
_FETCHED = {"img": ("src", "srcset"), "script": ("src",), "link": ("href",), "iframe": ("src",),
            "source": ("src", "srcset"), "video": ("src", "poster"), "audio": ("src",), "embed": ("src",),
            "object": ("data",), "use": ("href",)}
_NAMES_ONLY = {"canonical", "next", "prev", "index", "search", "genindex"}      # <link rel=...> that fetches nothing
_CSS_URL = re.compile(r"url\(\s*['\"]?([^'\")]+)|@import\s+['\"]([^'\"]+)")


class _Page(HTMLParser):
    """The anchors of a page, what it links to, and what it makes a browser fetch."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.anchors: set[str] = set()
        self.links: list[str] = []
        self.fetched: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        found = dict(attrs)
        self.anchors |= {value for name, value in attrs if value and (name == "id" or (tag, name) == ("a", "name"))}
        if tag == "a" and found.get("href"):
            self.links.append(found["href"] or "")
        if tag == "meta" and (found.get("http-equiv") or "").lower() == "refresh":
            self.links.append((found.get("content") or "").partition("url=")[2])
        if tag == "link" and set((found.get("rel") or "").split()) & _NAMES_ONLY:
            return
        self.fetched += [found[name] or "" for name in _FETCHED.get(tag, ()) if found.get(name)]
        self.fetched += [a or b for a, b in _CSS_URL.findall(found.get("style") or "")]


@cache
def _page(path: Path) -> _Page:
    return _Page(path.read_text("utf-8"))


def problems(site: Path) -> Iterator[str]:
    """What is wrong with a built site, a line each."""
    for path in sorted(site.rglob("*.html")):
        page, name = _page(path), path.relative_to(site)
        for target in page.fetched:
            yield from (f"{name}: {problem}" for problem in _missing(path, target, fetched=True))
        for target in page.links:
            yield from (f"{name}: {problem}" for problem in _missing(path, target, fetched=False))
    for path in sorted(site.rglob("*.css")):
        for found in _CSS_URL.findall(path.read_text("utf-8")):
            target = found[0] or found[1]
            yield from (f"{path.relative_to(site)}: {problem}" for problem in _missing(path, target, fetched=True))


def _missing(path: Path, target: str, fetched: bool) -> Iterator[str]:
    """What is wrong with one target of a file."""
    url = urlsplit(target)
    if url.scheme == "data":
        return
    if url.scheme or url.netloc:
        if fetched:
            yield f"fetches {target}"
        return
    file = (path.parent / unquote(url.path)).resolve() if url.path else path
    if file.is_dir():
        file /= "index.html"
    if not file.is_file():
        yield f"{target} is not there"
    elif url.fragment and file.suffix == ".html" and unquote(url.fragment) not in _page(file).anchors:
        yield f"{target}: no such anchor"


def anchors(path: Path) -> set[str]:
    """The anchors of a built page."""
    return _page(path).anchors
