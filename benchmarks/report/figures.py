"""Suzanne, rendered by Cycles with fits side by side: the paper's Figure 8."""

import bpy
import numpy as np

import fitter
from fitter.imaging.pictures import srgb
from support import sheet
from support.stage import material_for, render, suzanne

from ..dense.image_errors import flip

SUN = 0.02                  # radians across


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
    first, rows = _suzanne(reference, seed=0), []
    shown, tiles = srgb(first[..., :3]), [sheet.tile(first, "level 6")]
    for seed, (name, fit) in enumerate(others.items()):
        picture = _suzanne(fit, seed=int(seed == 0))
        rows.append({"fit": name, "relative_rmse": relative_rmse(first, picture),
                     "flip": flip(shown, srgb(picture[..., :3]), np.ones(picture.shape[:2], bool))})
        if name in ("(4,6,95)", "Standard"):
            tiles.append(sheet.tile(picture, name))
    sheet.write(out / "figure_8_compression.png", [tiles])
    return rows


def relative_rmse(reference, picture):
    """Root mean square difference over the mean of the reference, scene-linear (height, width, 3 or 4)."""
    a, b = reference[..., :3].astype(float), picture[..., :3].astype(float)
    return float(np.sqrt(np.mean((a - b) ** 2)) / a.mean())


def _suzanne(fit, seed):
    """Suzanne under a sun, whose noise is less than an area lamp's: so that differences are those of the fits."""
    scene = suzanne()
    scene.render.resolution_percentage = 60
    scene.cycles.use_denoising, scene.cycles.seed, scene.cycles.samples = False, seed, 96
    lamp = next(item for item in scene.objects if item.type == "LIGHT")
    lamp.data.type = "SUN"
    lamp.data.energy, lamp.data.angle = 4, SUN
    bpy.context.object.data.materials.append(material_for(fit))
    return render(scene)
