"""The contact sheet: the truth beside Standard, Draft, the published model and Paper, drawn with matplotlib."""

import numpy as np

from fitter.imaging.pictures import sphere, srgb

from ..report.plots import pyplot, save
from . import image_errors
from .judging import TRUTH, pictures_of
from .materials import MICROFACET, NEURAL

NAME = "dense_spheres.png"
SHOWN = ("aurora_white_rgb", "irid_flake_paint1_rgb", "chm_mint_rgb", "brass", "blue-metallic-paint", "white-marble")
COLUMNS = (TRUTH, "Standard", "Draft", (NEURAL, MICROFACET), "Paper")
_BACKGROUND, _INK = 0.16, "0.9"


def draw(results, out):
    """Draw `NAME`, of the materials SHOWN, or where none of them is there of the first six, as `Bench.draw` does."""
    records = {record["name"]: record for record in results["materials"]}
    shown = [records[name] for name in SHOWN if name in records] or list(records.values())[:len(SHOWN)]
    if shown:
        save(_figure([(record, np.load(pictures_of(record, out))) for record in shown]), out / NAME)


def _figure(shown):
    figure, axes = pyplot.subplots(len(shown), len(COLUMNS), squeeze=False, layout="constrained",
                                   figsize=(2.3 * len(COLUMNS), 2.55 * len(shown) + 0.6))
    figure.set_facecolor(str(_BACKGROUND))
    figure.suptitle("Spheres under a clear sky, with mean FLIP to the truth, and bytes", color=_INK, fontsize=12)
    for line, (record, pictures) in zip(axes, shown, strict=True):
        _, inside, cover = sphere(len(pictures[TRUTH]))
        scale = image_errors.exposure(pictures[TRUTH][inside])
        for axis, wanted in zip(line, COLUMNS, strict=True):
            axis.set_axis_off()
            name = next((each for each in ([wanted] if isinstance(wanted, str) else wanted) if each in pictures), None)
            if name is None:
                continue
            over = cover[..., None] * inside[..., None]
            axis.imshow(over * srgb(scale * pictures[name]) + (1 - over) * _BACKGROUND, origin="lower")
            row = record["models"].get(name)
            title = (f"{record['name']}\n{name}" if row is None
                     else f"{name}, {row['bytes']:,} bytes\nFLIP {row['flip']:.3f}")
            axis.set_title(title, color=_INK, fontsize=9, pad=2)
    return figure

