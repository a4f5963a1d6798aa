"""``make evidence``: every table, number and picture that README.md and docs/ state, made again, where it stands.

A table, or a number in a sentence, stands in a page between marks with its name and the digest of the files that it
measures, which tells whether it is older than they are; docs/pictures.md has the same for pictures. `ENTRIES` says what
is made by which command. A command prints its tables by `support.evidence.show`.

    python -m tools.evidence                    # all of it: within an hour on two idle cores
    python -m tools.evidence report engines     # some entries
    python -m tools.evidence --stale            # those that are older than the code
    python -m tools.evidence --check            # exit code 1, and the name of each table and picture that is older
"""

import argparse
import re
import shutil
import subprocess
import sys
import time
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from fitter.storage.files import replace_file
from support.checkout import ROOT
from support.evidence import END, FITS, SHADER, digest

PAGES = sorted([ROOT / "README.md", *(ROOT / "docs").glob("*.md"), *(ROOT / "docs" / "manual").glob("*.md")])
PICTURES = ROOT / "docs" / "pictures.md"
_BLOCK = re.compile(rf"<!-- evidence: ([\w-]+)(?: (\w+))? -->(.*?){re.escape(END)}", re.DOTALL)
_ROW = re.compile(r"^\| `([^`]+)` \| `([^`]+)` \| *(\w*) \|$", re.MULTILINE)
_SCENES = "demo_scenes", "support/stage.py", "support/sheet.py"
_WINDOW = "addon", "tools/window"
_OF_BALLS = (*FITS, *(f"fitter/photographs/{room}" for room in ("ball", "description", "pictures.py", "rig")),
             "fitter/imaging/picture_files.py",
             "benchmarks/photographs.py", "benchmarks/report/baselines/ggx.py", "support/ball_scene.py")
_BLENDER = "/tmp/gui/usr/bin/blender"       # with a window: where `tools.window` looks for it


@dataclass(frozen=True)
class Entry:
    """What one command makes."""

    command: str                        # of this repository, as a shell would take it; `python` is this interpreter
    tables: tuple[str, ...] = ()        # the names that it prints
    measured: tuple[str, ...] = ()      # files and folders, from the root, that the numbers and pictures depend on
    pictures: tuple[str, ...] = ()      # below docs/, or patterns of them
    made_in: str = "docs"               # the folder in which the command makes them; from there they are copied
    needs: str = ""                     # a file without which it cannot be made


ENTRIES = {
    "stability": Entry("python -m tools.stability", ("stability",), (*FITS, "support/hard_cases.py")),
    "weight": Entry("python -m benchmarks.weight", ("weight",), (
        *SHADER, "benchmarks/weight.py", "addon/core/shading/compiler.py")),
    "starts": Entry("python -m benchmarks.starts", ("starts", "starts-animation"), (*SHADER, "benchmarks/starts.py")),
    "black-pixels": Entry("python -m benchmarks.black_pixels", ("black-pixels", "black-pixels-most"),
                          (*SHADER, "benchmarks/black_pixels.py")),
    "ordinary": Entry("python -m benchmarks.ordinary", ("ordinary", "ordinary-exact"),
                      (*SHADER, "benchmarks/ordinary.py")),
    "engines": Entry("python -m benchmarks.engines --out build/engines", ("engines-integrals", "engines-spheres"),
                     (*SHADER, "benchmarks/engines.py"), ("engines.png",), "build/engines"),
    "rims": Entry("python -m benchmarks.rims", ("rims-rgl", "rims-others"), (
        *FITS, "benchmarks/rims.py", "support/faults.py")),
    "library": Entry("python -m benchmarks.library --picture docs/library_balls.png", ("library",), (
        *FITS, "fitter/model/published.py", "fitter/library/ready.py", "benchmarks/library.py", "support/faults.py",
        "support/spheres.py"),
        ("library_balls.png",)),
    "rings": Entry("python -m benchmarks.rings", ("rings",), (
        *FITS, "benchmarks/rings.py", "benchmarks/held_out/sets.py", "support/faults.py")),
    "mirrors": Entry("python -m benchmarks.mirrors", ("mirrors",), (
        *FITS, "benchmarks/mirrors.py", "support/faults.py")),
    "photographs": Entry("python -m benchmarks.photographs", ("photographs",), _OF_BALLS),
    "gray-ball": Entry("python -m benchmarks.photographs gray", ("gray-ball",), _OF_BALLS),
    "flat": Entry("python -m benchmarks.flat", ("flat", "flat-real"), (
        *FITS, "fitter/photographs", "fitter/imaging/picture_files.py", "fitter/quality/coverage.py",
        "benchmarks/flat.py", "benchmarks/flat_methods.py", "benchmarks/flat_real.py", "benchmarks/photographs.py",
        "support/flat_files.py", "support/flat_scene.py")),
    "scale": Entry("python -m benchmarks.scale", ("scale-convert", "scale-scene"), (
        *SHADER, "addon/library", "addon/work", "benchmarks/scale.py")),
    "dense": Entry("python -m benchmarks.dense --resume --out build/dense",
                   ("dense-rivals", "dense-medians", "dense-bytes"),
                   (*FITS, "benchmarks/dense", "benchmarks/harness", "benchmarks/report/baselines"),
                   ("dense_spheres.png",), "build/dense"),
    "held-out": Entry("python -m benchmarks.held_out --resume --out build/held_out",
                      ("held-out-held-out", "held-out-truth", "held-out-share"),
                      (*FITS, "benchmarks/held_out", "benchmarks/harness", "benchmarks/report/baselines",
                       "support/spheres.py"),
                      ("held_out_spheres.png",), "build/held_out"),
    "report": Entry("python -m benchmarks.report --out build/report", (
        "report-claim", "report-errors", "report-times", "report-storage", "report-methods", "report-pictures",
        "report-beats-baselines", "report-beats-all", "report-krylon", "report-bytes"),
        (*FITS, "benchmarks/report", "benchmarks/dense/image_errors.py"),
        ("figure_1_errors.png", "figure_2_times.png", "figure_5_storage.png", "figure_8_compression.png"),
        "build/report"),
    "title": Entry("python -m demo_scenes.title --out docs/title", measured=(*SHADER, *_SCENES),
                   pictures=("title.jpg", "title_principled.jpg")),
    "gallery": Entry("python -m demo_scenes.gallery docs/gallery", measured=(*SHADER, *_SCENES),
                     pictures=("gallery/*.jpg",)),
    **{name: Entry(f"python -m demo_scenes.{name} docs/manual/{picture}.png", measured=(*SHADER, *_SCENES),
                   pictures=(f"manual/{picture}.png",))
       for name, picture in (("adjusted", "adjusted"), ("anisotropic", "anisotropic"), ("ball", "measured_ball"),
                             ("card", "measured_card"), ("studio", "studio"), ("translucent", "translucent"))},
    "loops": Entry("python -m tools.window docs/loops drop adjust compare_drag inspect --size 1100x840",
                   measured=_WINDOW, pictures=("loops/*.webp",), needs=_BLENDER),
    "window": Entry("python -m tools.window docs/manual", measured=_WINDOW, pictures=("manual/*.png",),
                    needs=_BLENDER)}


@cache
def now(name):
    """The digest of what an entry measures, as it is."""
    return digest(ENTRIES[name].measured)


def printed(text):
    """The tables in what a command printed, by name."""
    return {name: body for name, _, body in _BLOCK.findall(text)}


def states(page):
    """The marks of a page: pairs of a name and a digest, which is empty where nothing was made yet."""
    return [(name, known) for name, known, _ in _BLOCK.findall(page)]


def written(page, bodies, known):
    """A page with new tables, and the digest of what they measure, between the marks with their names."""
    def put(match):
        name = match[1]
        return f"<!-- evidence: {name} {known} -->{bodies[name]}{END}" if name in bodies else match[0]

    return _BLOCK.sub(put, page)


def stale():
    """The tables and pictures older than what they measure, with the names of their entries; and of how many."""
    stated = [(name, known) for page in PAGES for name, known in states(page.read_text("utf-8"))]
    stated += [(name, known) for name, _, known in _ROW.findall(PICTURES.read_text("utf-8"))]
    entries = {each: name for name, entry in ENTRIES.items() for each in (*entry.tables, *entry.pictures)}
    old = {each: entries[each] for each, known in stated if known != now(entries[each])}
    return old, len({each for each, _ in stated})


def make(name):
    """Run the command of an entry, and write what it made where it stands."""
    entry, known = ENTRIES[name], now(name)
    if entry.needs and not Path(entry.needs).exists():
        raise RuntimeError(f"not made, there is no {entry.needs}")
    command = [sys.executable if word == "python" else word for word in entry.command.split()]
    done = subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, text=True, check=False)
    if done.returncode:
        raise RuntimeError(f"{entry.command} ended with code {done.returncode}\n{done.stdout[-2000:]}")
    bodies = printed(done.stdout)
    if missing := set(entry.tables) - bodies.keys():
        raise RuntimeError(f"{entry.command} did not print {', '.join(sorted(missing))}")
    if entry.made_in != "docs":
        for picture in entry.pictures:
            shutil.copy(ROOT / entry.made_in / Path(picture).name, ROOT / "docs" / picture)
    for page in PAGES:
        text = page.read_text("utf-8")
        new = written(text, bodies, known)
        if page == PICTURES:
            new = _ROW.sub(lambda row: f"| `{row[1]}` | `{row[2]}` | {known} |" if row[1] in entry.pictures else row[0],
                           new)
        if new != text:
            with replace_file(page, "w") as stream:
                stream.write(new)


def main():
    """Make entries, or check all. The exit code is 1 where one fails, or is older than the code."""
    parser = argparse.ArgumentParser(prog="python -m tools.evidence", description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", choices=[*ENTRIES, []], metavar="NAME", help=", ".join(ENTRIES))
    parser.add_argument("--stale", action="store_true", help="only what is older than the code")
    parser.add_argument("--check", action="store_true", help="make nothing; name what is older than the code")
    options = parser.parse_args()
    old, count = stale()
    if options.check:
        for each, name in old.items():
            print(f"{each}: older than what it measures (python -m tools.evidence {name})")
        print(f"{len(old)} of {count} tables and pictures are older than the code that they measure")
        return 1 if old else 0
    wanted = options.names or ([name for name in ENTRIES if name in old.values()] if options.stale else [*ENTRIES])
    begun, failed = time.perf_counter(), []
    for name in wanted:
        start = time.perf_counter()
        try:
            make(name)
        except RuntimeError as error:
            failed.append(name)
            print(f"{name}: {error}", flush=True)
        print(f"{name}: {(time.perf_counter() - start) / 60:.1f} minutes", flush=True)
    print(f"{(time.perf_counter() - begun) / 60:.0f} minutes" + (f"; not made: {', '.join(failed)}" if failed else ""))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
