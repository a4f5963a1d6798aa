"""``python -m tools.window FOLDER [NAME ...]``: pictures of Blender's window for the manual, and films of it.

Each opens a real Blender on a screen of its own (Xvfb), installs the extension's zip into an empty profile, and runs
`driver.py` inside of it. The scripts that do this, and a folder with such a Blender, are not part of the repository.
CURET's measurements are needed, the photographs of a lion, and the synthetic tables and photographs of `make demo`.
"""

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import bpy
import numpy as np

from support.checkout import ROOT, measurements

BALL = ROOT / "build" / "demo" / "ball"
DRIVER = Path(__file__).with_name("driver.py")
_POINTER = (0, 0), (0, 17), (4, 13), (7, 20), (10, 19), (7, 12), (12, 12)
_FRAME, _LAST, _QUALITY = 120, 1500, 60         # ms of a frame, and of the last; of a WebP
_MARK = 'PICTURE = "panel"'


def names(table="PICTURES"):
    """The pictures that the driver knows, or its OTHERS: films, and what docs/start.md has the times of."""
    table = DRIVER.read_text("utf-8").partition(f"{table} = {{")[2].partition("}")[0]
    return [line.split('"')[1] for line in table.splitlines() if '"' in line]


def main():
    """Take the named pictures, or all. The exit code is 1 where one fails."""
    parser = argparse.ArgumentParser(prog="python -m tools.window", description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path, help="where to write NAME.png, or NAME.webp of a film")
    parser.add_argument("names", nargs="*", help=f"of {', '.join(names())}, by default all of these; "
                                                       f"{', '.join(names('OTHERS'))}")
    parser.add_argument("--zip", type=Path, help="the extension; by default what `make zip` wrote")
    parser.add_argument("--scripts", type=Path, default=ROOT.parent / "shared" / "tools" / "blender_gui")
    parser.add_argument("--root", type=Path, default=Path("/tmp/gui"), help="the folder that holds a Blender")
    parser.add_argument("--size", default="1400x900", help="of the window, default: %(default)s")
    options = parser.parse_args()
    options.zip = options.zip or next((ROOT / "build").glob("measured_brdf-*.zip"), None)
    if options.zip is None:
        parser.error("no zip: run `make zip`")
    copy_data(options.root / "data")
    failed = [name for name in options.names or names() if not take(name, options)]
    if failed:
        print(f"not taken: {', '.join(failed)}", file=sys.stderr)
    return bool(failed)


def copy_data(folder):
    """Put the measurements where the driver finds them."""
    folder.mkdir(exist_ok=True)
    for path in (measurements() / "curet" / "abrdf.dat", *(measurements() / "cornell").glob("*.astm"),
                 ROOT / "build" / "synthetic" / "brushed_steel.csv"):
        if path.is_file() and not (folder / path.name).exists():
            shutil.copy(path, folder)
    for source in (BALL, measurements() / "photographs" / "lion"):
        if source.is_dir() and not (folder / source.name).exists():
            shutil.copytree(source, folder / source.name)


def take(name, options):
    """Take one picture or film; whether it could be taken."""
    with tempfile.TemporaryDirectory() as folder:
        driver, picture = Path(folder) / "driver.py", Path(folder) / "picture.png"
        driver.write_text(DRIVER.read_text("utf-8").replace(_MARK, f'PICTURE = "{name}"'), "utf-8")
        done = subprocess.run(["bash", options.scripts / "shot.sh", options.root, options.zip, driver, picture,
                               options.size], capture_output=True, text=True, check=False,
                              env={"SHOT_TIMEOUT": "280", **os.environ})
        if done.returncode or not picture.is_file():
            print(done.stdout[-3000:], done.stderr[-1000:], file=sys.stderr)
            return False
        for line in done.stdout.splitlines():
            if line.startswith("TIME|"):
                print(*line.split("|")[1:], sep=": ")
        frames = sorted(picture.parent.glob("picture-frame-*.png"))
        if frames:
            animate(frames, options.folder / f"{name}.webp")
            return True
        popup = picture.with_name("picture-popup.png")
        trim(popup if popup.is_file() else picture, options.folder / f"{name}.png")
    print(options.folder / f"{name}.png")
    return True


def animate(frames, out):
    """Write frames as an animated WebP, without those that are like the one before, and with the pointer."""
    try:
        from PIL import Image, ImageDraw
    except ImportError:
        raise SystemExit("an animation needs Pillow: pip install pillow") from None
    shown = []
    for path in frames:
        x, y = map(int, path.stem.split("-")[-2:])
        image = Image.open(path).convert("RGB")
        ImageDraw.Draw(image).polygon([(x + a, y + b) for a, b in _POINTER], fill="white", outline="black")
        if not shown or image.tobytes() != shown[-1].tobytes():
            shown.append(image)
    times = [_FRAME] * (len(shown) - 1) + [_LAST]
    out.parent.mkdir(parents=True, exist_ok=True)
    shown[0].save(out, save_all=True, append_images=shown[1:], duration=times, loop=0, quality=_QUALITY, method=6)
    print(f"{out}: {len(shown)} frames, {out.stat().st_size / 1000:.0f} KB")


def trim(picture, out):
    """Write a picture without the empty rows at its bottom and the transparency that Blender's editors do not have."""
    image = bpy.data.images.load(str(picture))
    width, height = image.size
    pixels = np.empty(width * height * 4, dtype=np.float32)
    image.pixels.foreach_get(pixels)
    rows = pixels.reshape(height, width, 4)             # the lowest first
    inner = rows[:, 8:-24, :3]                          # without the edge and the scroll bar
    filled = np.flatnonzero(np.ptp(inner, axis=(1, 2)) > 0.05)
    kept = rows[max(0, (filled[0] if len(filled) else 0) - 12):]
    cut = bpy.data.images.new(out.stem, width, len(kept))
    cut.pixels.foreach_set(np.ascontiguousarray(kept).ravel())
    cut.file_format, cut.filepath_raw = "PNG", str(out)
    out.parent.mkdir(parents=True, exist_ok=True)
    cut.save()


if __name__ == "__main__":
    sys.exit(main())
