"""``make demo``: imports measurements through the add-on and renders the paper's figures, and anisotropic ones."""

import sys
import time

import bpy

from fitter.model.fit import notation
from support import sheet, synthetic
from support.checkout import ROOT, extension
from support.stage import lit_sphere, render, suzanne

from . import anisotropic

OUT = ROOT / "build" / "demo"
PAPER = {"preset": "Paper"}
FIGURE_4 = {"aluminum foil": 15, "felt": 1, "leather": 5}


class Demo:
    """The data, whether they are real, and the table of what was rendered."""

    def __init__(self):
        self.data, self.synthetic = synthetic.measurements_or_synthetic()
        self.rows = []

    def named(self, name):
        """The name of a material as pictures and the table show it."""
        return f"{name} (synthetic)" if self.synthetic else name

    def render(self, scene, name, path, **choices):
        """Import measurements for the active object, render, and enter a row in the table."""
        bpy.ops.measured_brdf.import_data(filepath=str(self.data / path), **choices)
        result = bpy.context.object.active_material.measured_brdf
        start = time.perf_counter()
        picture = render(scene)
        seconds = time.perf_counter() - start
        levels = (result.diffuse_level, None) if result.specular_level < 0 else (
            result.diffuse_level, result.specular_level, result.compression)
        self.rows.append((self.named(name), notation(*levels), result.bytes, result.rmse, result.seconds, seconds))
        return picture


def figure_3(demo):
    """Foil at levels 1 to 6, lit from 60 degrees to the left of the viewer."""
    tiles = []
    for level in range(1, 7):
        picture = demo.render(lit_sphere(60), "aluminum foil", "curet/abrdf.dat", sample="15", diffuse_level=level,
                              specular_level=-1)
        tiles.append(sheet.tile(picture, demo.named(f"foil, level {level}")))
    sheet.write(OUT / "figure_3_levels.png", [tiles[:3], tiles[3:]])


def figure_4(demo):
    """Foil, felt and leather under a light 0, 30, 60 and 90 degrees to the left of the viewer."""
    rows = []
    for name, number in FIGURE_4.items():
        row = []
        for angle in (0, 30, 60, 90):
            picture = demo.render(lit_sphere(angle), name, "curet/abrdf.dat", sample=str(number), **PAPER)
            row.append(sheet.tile(picture, demo.named(f"{name}, {angle}°")))
        rows.append(row)
    sheet.write(OUT / "figure_4_materials.png", rows)


def figure_8(demo):
    """Suzanne in krylon blue under an area lamp and a world, compressed and not."""
    tiles = []
    for label, choices in {"(4,6,95)": PAPER, "Standard": {"preset": "Standard"},
                           "level 6": {"diffuse_level": 6, "specular_level": -1}}.items():
        picture = demo.render(suzanne(), "krylon blue", "cornell/krylon_blue.astm", **choices)
        tiles.append(sheet.tile(picture, demo.named(f"krylon blue, {label}")))
    sheet.write(OUT / "figure_8_compression.png", [tiles])


def print_table(rows):
    """Print the table of what was fitted and rendered."""
    header = ("material", "levels", "bytes", "RMSE [1/sr]", "fit [s]", "render [s]")
    print(f"\n{header[0]:26} {header[1]:>10} {header[2]:>10} {header[3]:>12} {header[4]:>8} {header[5]:>10}")
    for name, levels, size, rmse, fit, seconds in rows:
        print(f"{name:26} {levels:>10} {size:>10,} {rmse:12.5f} {fit:8.3f} {seconds:10.2f}")


def main():
    start = time.perf_counter()
    extension().register()
    demo = Demo()
    for figure in (figure_4, figure_3, figure_8):
        figure(demo)
    anisotropic.draw(OUT / "anisotropic.png")
    print_table(demo.rows)
    for path in sorted(OUT.glob("*.png")):
        print(path.relative_to(ROOT))
    print(f"{time.perf_counter() - start:.0f} s in all")


if __name__ == "__main__":
    sys.exit(main())
