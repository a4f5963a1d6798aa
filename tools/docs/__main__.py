"""``make docs``: the documentation as a site, in build/site; ``--manual``: the part that the extension holds.

Sphinx runs in an environment of its own (``--python``), and the pages of reference are written by this one, which has
Blender. A warning of Sphinx, a dead link or a request to another host is an error. The site is written anew, whole.
"""

import argparse
import shutil
import subprocess
import sys
import tempfile
import time
import tomllib
from pathlib import Path

from support.checkout import ROOT, extension

from . import check, pages

_NOT_OFFLINE = ("*.map", "objects.inv", ".buildinfo", "skeleton.css", "debug.css")


def main() -> int:
    """Build and check. The exit code is 1 where anything is wrong."""
    parser = argparse.ArgumentParser(prog="python -m tools.docs", description=__doc__.splitlines()[0])
    parser.add_argument("out", type=Path, help="the folder of the site")
    parser.add_argument("--python", default=sys.executable, help="an interpreter that has Sphinx")
    parser.add_argument("--manual", action="store_true", help="only what the extension holds")
    options = parser.parse_args()
    start = time.perf_counter()
    built = build(options.out, options.python, options.manual)
    found = list(check.problems(options.out)) if built else ["Sphinx found the above"]
    for problem in found:
        print(problem, file=sys.stderr)
    size = sum(path.stat().st_size for path in options.out.rglob("*") if path.is_file())
    print(f"{options.out}: {len(list(options.out.rglob('*.html')))} pages, {size / 1e6:.1f} MB, "
          f"{time.perf_counter() - start:.0f} s")
    return bool(found)


def build(out: Path, python: str, only_manual: bool) -> bool:
    """Whether Sphinx had nothing to complain of."""
    manifest = tomllib.loads((ROOT / "blender_manifest.toml").read_text("utf-8"))
    with tempfile.TemporaryDirectory(prefix="docs-") as folder:
        source = Path(folder) / "docs"
        pages.gather(source, only_manual, manifest.get("website", "").rstrip("/"))
        if not only_manual:
            from . import reference

            for name, text in reference.pages().items():
                (source / name).parent.mkdir(exist_ok=True)
                (source / name).write_text(text, "utf-8")
        shutil.rmtree(out, ignore_errors=True)
        done = subprocess.run([python, "-m", "sphinx", "--quiet", "--fail-on-warning", "--jobs", "2", "--builder",
                               "html", "--conf-dir", Path(__file__).parent, "--doctree-dir", Path(folder) / "doctrees",
                               *(["--tag", "manual"] if only_manual else []), source, out], cwd=ROOT, check=False)
    if only_manual and done.returncode == 0:
        for path in [path for pattern in _NOT_OFFLINE for path in out.rglob(pattern)]:
            path.unlink()
        write_redirects(out)
    return done.returncode == 0


def write_redirects(out: Path) -> None:
    """For each topic of F1 a page that leads to its anchor: systems open files by their path alone."""
    package = extension()
    package.register()
    from measured_brdf.addon.core import manual

    topics = manual.topics()
    package.unregister()
    for topic in topics:
        target = out / manual.REDIRECTS / f"{manual.file_name(topic)}.html"
        target.parent.mkdir(exist_ok=True)
        page, _, anchor = topic.partition("#")
        target.write_text(f'<!doctype html><meta charset="utf-8"><title>{page}</title>'
                          f'<meta http-equiv="refresh" content="0; url=../{page}.html#{anchor}">'
                          f'<a href="../{page}.html#{anchor}">{page}</a>\n', "utf-8")


if __name__ == "__main__":
    sys.exit(main())
