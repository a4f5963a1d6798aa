"""``make demo``: imports measurements through the add-on and renders the paper's figures, anisotropic and
translucent materials, a photographed ball and a photographed card, and a carving in real photographs.

Two processes draw small pictures with few samples; ``--full`` draws the same ones as the pages have
them.
"""

import argparse
import math
import os
import pickle
import subprocess
import sys
import tempfile
import time
from collections import deque
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from itertools import repeat
from pathlib import Path

import bpy

from fitter.imaging.pictures import srgb
from fitter.model.fit import notation
from support import sheet, synthetic
from support.checkout import ROOT, extension
from support.stage import lit_sphere, render, suzanne

from . import anisotropic, ball, card, carving, translucent

PROCESSES = 2
PAPER = {"preset": "Paper"}
FIGURE_4 = {"aluminum foil": 15, "felt": 1, "leather": 5}
_FEWEST_SAMPLES = 8
_OURS = "demo: "            # begins the lines of a part that are shown
_LINES = 20                 # of what Blender printed before an error


@dataclass(frozen=True)
class Quality:
    """Where pictures are written, and their size and samples as shares of those of the pages."""

    folder: Path
    size: float = 1.0
    samples: float = 1.0

    def of(self, scene):
        """A scene with this quality. Scenes that need it are denoised in both; a sphere under a sun has no noise."""
        if self.samples < 1:
            scene.cycles.samples = max(_FEWEST_SAMPLES, round(self.samples * scene.cycles.samples))
        scene.render.resolution_x = round(self.size * scene.render.resolution_x)
        scene.render.resolution_y = round(self.size * scene.render.resolution_y)
        return scene


DEMO = Quality(ROOT / "build" / "demo", size=0.5, samples=1 / 8)
FULL = Quality(ROOT / "build" / "figures")


class Demo:
    """The data, whether they are real, how to render, and the table of what was rendered."""

    def __init__(self, quality, say=print):
        self.data, self.synthetic = synthetic.measurements_or_synthetic()
        self.quality, self.say, self.rows = quality, say, []

    def named(self, name):
        """The name of a material as pictures and the table show it."""
        return f"{name} (synthetic)" if self.synthetic else name

    def fit(self, name, path, **choices):
        """Import measurements for the active object."""
        self.say(f"fitting {name}")
        bpy.ops.measured_brdf.import_data(filepath=str(self.data / path), **choices)

    def render(self, scene, name, caption):
        """Render the active object, and enter a row in the table."""
        self.say(f"rendering {caption}")
        result = bpy.context.object.active_material.measured_brdf
        start = time.perf_counter()
        picture = render(scene)
        seconds = time.perf_counter() - start
        levels = (result.diffuse_level, None) if result.specular_level < 0 else (
            result.diffuse_level, result.specular_level, result.compression)
        self.rows.append((self.named(name), notation(*levels), result.bytes, result.rmse, result.seconds, seconds))
        return picture

    def write(self, name, rows):
        """Write rows of pictures, each with its caption."""
        sheet.write(self.quality.folder / name, [[sheet.tile(picture, self.named(caption)) for picture, caption in row]
                                                 for row in rows])


def figure_3(demo):
    """Foil at levels 1 to 6, lit from 60 degrees to the left of the viewer."""
    tiles = []
    for level in range(1, 7):
        scene = demo.quality.of(lit_sphere(60))
        caption = f"foil, level {level}"
        demo.fit(caption, "curet/abrdf.dat", sample="15", diffuse_level=level, specular_level=-1)
        tiles.append((demo.render(scene, "aluminum foil", caption), caption))
    demo.write("figure_3_levels.png", [tiles[:3], tiles[3:]])


def figure_4(demo):
    """Foil, felt and leather under a light 0, 30, 60 and 90 degrees to the left of the viewer."""
    rows = []
    for name, number in FIGURE_4.items():
        scene, row = demo.quality.of(lit_sphere(0)), []
        demo.fit(name, "curet/abrdf.dat", sample=str(number), **PAPER)
        for angle in (0, 30, 60, 90):
            bpy.data.objects["Sun"].rotation_euler.y = -math.radians(angle)
            caption = f"{name}, {angle}°"
            row.append((demo.render(scene, name, caption), caption))
        rows.append(row)
    demo.write("figure_4_materials.png", rows)


def figure_8(demo):
    """Suzanne in krylon blue under an area lamp and a world, compressed and not."""
    tiles = []
    for label, choices in {"(4,6,95)": PAPER, "Standard": {"preset": "Standard"},
                           "level 6": {"diffuse_level": 6, "specular_level": -1}}.items():
        scene = demo.quality.of(suzanne())
        caption = f"krylon blue, {label}"
        demo.fit(caption, "cornell/krylon_blue.astm", **choices)
        tiles.append((demo.render(scene, "krylon blue", caption), caption))
    demo.write("figure_8_compression.png", [tiles])


def anisotropic_half(demo, name):
    """One of the two anisotropic materials: a picture (height, width, 3)."""
    demo.say(f"fitting {name.replace('_', ' ')}")
    scene = demo.quality.of(getattr(anisotropic, name)())
    demo.say(f"rendering {name.replace('_', ' ')}")
    return srgb(render(scene)[..., :3])


def photographed_ball(demo):
    """A ball as synthetic photographs, measured and rendered beside the truth."""
    demo.say("measuring a photographed ball")
    quality = demo.quality
    ball.draw(quality.folder / "measured_ball.png", round(quality.size * ball.SIZE),
              "Draft" if quality.samples < 1 else "Standard")


def module_picture(demo, module, name, text, **settings):
    """The picture of a module, in this quality; settings are those of the full one."""
    demo.say(text)
    quality = demo.quality
    module.draw(quality.folder / name, round(quality.size * module.SIZE),
                **{key: round(quality.samples * value) for key, value in settings.items()})


# the longest first; by a process each
PARTS = {"card": partial(module_picture, module=card, name="measured_card.png", text="measuring a photographed card",
                         samples=card.SAMPLES),
         "pan": partial(anisotropic_half, name="brushed_pan"),
         "cloth": partial(anisotropic_half, name="satin_cloth"), "figure 8": figure_8, "figure 3": figure_3,
         "figure 4": figure_4, "ball": photographed_ball,
         "carving": partial(module_picture, module=carving, name="measured_carving.png",
                            text="measuring a carving in real photographs"),
         "translucent": partial(module_picture, module=translucent, name="translucent.png",
                                text="rendering translucent materials", samples=translucent.SAMPLES)}
IN_THE_TABLE = "figure 4", "figure 3", "figure 8"


def draw(part, quality):
    """Draw one of `PARTS` in a process of its own, without Blender's words: its picture, if it has one, and rows.

    Raises
    ------
    RuntimeError
        With the last of Blender's words.
    """
    with tempfile.TemporaryDirectory() as folder:
        result, said = Path(folder, "drawn"), deque(maxlen=_LINES)
        command = [sys.executable, "-m", __spec__.name, "--part", part, str(result)]
        # idle threads of OpenBLAS spin, and would take the other process's core
        threads = {"OPENBLAS_NUM_THREADS": str(max(1, (os.cpu_count() or 1) // PROCESSES))}
        process = subprocess.Popen([*command, *["--full"] * (quality is FULL)], cwd=ROOT, env=os.environ | threads,
                                   text=True, errors="replace", stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        for line in process.stdout:
            if line.startswith(_OURS):
                print(line.removeprefix(_OURS), end="", flush=True)
            else:
                said.append(line)
        if process.wait():
            raise RuntimeError(f"{part} failed:\n{''.join(said)}")
        return pickle.loads(result.read_bytes())


def draw_here(part, quality, result):
    """Draw one of `PARTS`, and write what `draw` returns."""
    extension().register()
    demo = Demo(quality, lambda text: print(f"\n{_OURS}{text}", flush=True))
    Path(result).write_bytes(pickle.dumps((PARTS[part](demo), demo.rows)))
    extension().unregister()


def print_table(rows):
    """Print the table of what was fitted and rendered."""
    header = ("material", "levels", "bytes", "RMSE [1/sr]", "fit [s]", "render [s]")
    print(f"\n{header[0]:26} {header[1]:>10} {header[2]:>10} {header[3]:>12} {header[4]:>8} {header[5]:>10}")
    for name, levels, size, rmse, fit, seconds in rows:
        print(f"{name:26} {levels:>10} {size:>10,} {rmse:12.5f} {fit:8.3f} {seconds:10.2f}")


def main():
    parser = argparse.ArgumentParser(prog="python -m demo_scenes", description=__doc__.splitlines()[0])
    parser.add_argument("--full", action="store_true", help="pictures as the pages have them, into build/figures")
    parser.add_argument("--part", nargs=2, help=argparse.SUPPRESS)
    options = parser.parse_args()
    quality = FULL if options.full else DEMO
    if options.part is not None:
        draw_here(options.part[0], quality, options.part[1])
        return
    start = time.perf_counter()
    with ThreadPoolExecutor(PROCESSES) as processes:
        drawn = dict(zip(PARTS, processes.map(draw, PARTS, repeat(quality)), strict=True))
    sheet.write(quality.folder / "anisotropic.png", [[drawn["pan"][0], drawn["cloth"][0]]])
    print_table([row for part in IN_THE_TABLE for row in drawn[part][1]])
    for path in sorted(quality.folder.glob("*.png")):
        print(path.relative_to(ROOT))
    print(f"{time.perf_counter() - start:.0f} s in all")


if __name__ == "__main__":
    sys.exit(main())
