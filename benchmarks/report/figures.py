"""Suzanne, rendered by Cycles with fits side by side: the paper's Figure 8."""

import bpy
import numpy as np

import fitter
from fitter.imaging.pictures import srgb
from support import sheet
from support.stage import material_for, render, suzanne

SUN = 0.02                  # radians across
PIXELS_PER_DEGREE = 67      # FLIP's default: a monitor at arm's length


def undetectable(samples, out):
    """Figure 8: Suzanne without and with compression, and how far the pictures differ.

    Returns
    -------
    list of dict
        RMSE over the pixels in scene-linear units, relative to the mean, and mean FLIP of the pictures as displayed;
        each against level 6, first level 6 itself with another seed, the share of noise.
    """
    reference = fitter.fit(samples, 6, None)
    others = {"level 6, another seed": reference, "(4,6,95)": fitter.fit(samples, **fitter.PRESETS["Paper"]),
              "Standard": fitter.fit(samples, **fitter.PRESETS["Standard"]),
              "(1,6,90)": fitter.fit(samples, 1, 6, 90)}
    first, rows = _suzanne(reference), []
    tiles = [sheet.tile(first, "level 6")]
    for seed, (name, fit) in enumerate(others.items()):
        picture = _suzanne(fit, seed=int(seed == 0))
        rows.append({"fit": name, "relative_rmse": relative_rmse(first, picture), "flip": flip(first, picture)})
        if name in ("(4,6,95)", "Standard"):
            tiles.append(sheet.tile(picture, name))
    sheet.write(out / "figure_8_compression.png", [tiles])
    return rows


def relative_rmse(reference, picture):
    """Root mean square difference over the mean of the reference, scene-linear (height, width, 3 or 4)."""
    a, b = reference[..., :3].astype(float), picture[..., :3].astype(float)
    return float(np.sqrt(np.mean((a - b) ** 2)) / a.mean())


def flip(reference, picture):
    """Mean FLIP of two scene-linear pictures as displayed, 0 to 1; None where flip-evaluator is not installed.

    P. Andersson et al.: FLIP: A Difference Evaluator for Alternating Images, HPG 2020.
    """
    try:
        import flip_evaluator
    except ImportError:
        return None
    shown = [np.ascontiguousarray(srgb(of[..., :3]), dtype=np.float32) for of in (reference, picture)]
    _, mean, _ = flip_evaluator.evaluate(*shown, "LDR", applyMagma=False, parameters={"ppd": PIXELS_PER_DEGREE})
    return float(mean)


def _suzanne(fit, seed=0):
    """Suzanne under a sun, whose noise is less than an area lamp's: so that differences are those of the fits."""
    scene = suzanne()
    scene.render.resolution_percentage = 60
    scene.cycles.use_denoising, scene.cycles.seed, scene.cycles.samples = False, seed, 96
    lamp = next(item for item in scene.objects if item.type == "LIGHT")
    lamp.data.type = "SUN"
    lamp.data.energy, lamp.data.angle = 4, SUN
    return _render(scene, fit)


def _render(scene, fit):
    bpy.context.object.data.materials.append(material_for(fit))
    return render(scene)
