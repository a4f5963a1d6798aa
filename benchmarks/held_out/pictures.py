"""Spheres of a few telling sets: the truth, Standard and the rivals, with their errors at samples held out.

Where there is no truth, the first sphere is of Standard fitted to all samples.
"""

import re

import numpy as np

from fitter.imaging.pictures import sphere
from fitter.storage.files import replace_file
from support.spheres import LAMPS, lamp_sphere, reflected_by_lamps

from ..report.methods import METHODS
from ..report.plots import pyplot, save

OWN = "Standard"
NAME = "held_out_spheres.png"
_HEADLAMP = ((0.02, 0.0, 1.0), 0.5)         # a degree from the viewer, whom retro-reflection reaches
TELLING = {"retro b, Cornell": (LAMPS[0], _HEADLAMP)} | dict.fromkeys((
    "interference b, Cornell", "brushed b, Cornell", "Cornell cayman", "Cornell garnet_red_RGB", "CURET 46 cotton",
    "MERL color-changing-paint2, goniometer", "RGL net cc_green_malachite_rgb, goniometer"), LAMPS)
SIZE = 112                  # pixels of a sphere
_MIDDLE = 0.2               # radiance that half of the sphere is below
_EXPOSURES = 0.02, 8.0
_BACKGROUND, _INK = "0.16", "0.9"


def path(out, name):
    return out / f"{re.sub(r'[^a-z0-9]+', '_', name.lower()).strip('_')}.npz"


def write(found, models, out):
    """Compute and write the spheres of a telling set, of the models of `judging.judge`."""
    samples, truth = found.open()
    reference, name = (truth, "truth") if truth else (METHODS[OWN](samples), f"{OWN}, all samples")
    shown = {name: reference, **({OWN: models[OWN]} if OWN in models else {}), **models}
    lights = exposed(reference, TELLING[found.name])
    spheres = np.stack([lamp_sphere(model, SIZE, lights) for model in shown.values()])
    with replace_file(path(out, found.name)) as stream:
        np.savez_compressed(stream, names=list(shown), spheres=np.round(255 * spheres).astype(np.uint8))


def exposed(reference, lights):
    """The lights, all made stronger or weaker, so that a sphere of the reference is neither black nor white."""
    brightest = reflected_by_lamps(reference, sphere(32)[0], lights).max(axis=1)
    middle = np.median(brightest[brightest > 0]) if brightest.any() else _MIDDLE
    exposure = np.clip(_MIDDLE / middle, *_EXPOSURES)
    return tuple((direction, exposure * strength) for direction, strength in lights)


def draw(results, out):
    shown = [record for record in results["sets"] if record["name"] in TELLING]
    if not shown:
        return
    methods = list(dict.fromkeys(name for record in shown for name in record["methods"]))
    figure, axes = pyplot.subplots(len(shown), 1 + len(methods), squeeze=False, layout="constrained",
                                   figsize=(1.5 * (1 + len(methods)), 1.75 * len(shown) + 0.6))
    figure.set_facecolor(_BACKGROUND)
    figure.suptitle("The truth, or where there is none Standard fitted to all samples; and fits to 80 % of the "
                    "samples, with their\nRMSE of the cube root at samples held out, the smallest of which is framed",
                    color=_INK)
    for line, record in zip(axes, shown, strict=True):
        with np.load(path(out, record["name"])) as file:
            spheres = dict(zip(map(str, file["names"]), file["spheres"], strict=True))
        _row(line, record, spheres, methods)
    save(figure, out / NAME)


def _row(line, record, spheres, methods):
    errors = {name: row["held_out_cube_root_rmse"] for name, row in record["methods"].items()}
    least = min((error for error in errors.values() if error is not None), default=None)
    for axis, name in zip(line, (next(iter(spheres)), *methods), strict=True):
        axis.set(xticks=[], yticks=[], facecolor=_BACKGROUND)
        framed = name in errors and errors[name] is not None and errors[name] == least
        for spine in axis.spines.values():
            spine.set(visible=framed, color="tab:orange", linewidth=2)
        if name in spheres:
            axis.imshow(spheres[name], origin="lower")
        axis.set_title(name, color=_INK, fontsize=8, pad=2)
        if name in errors:
            axis.set_xlabel("failed" if errors[name] is None else f"{errors[name]:.3g}", color=_INK, fontsize=9,
                            labelpad=2, weight="bold" if framed else "normal")
    line[0].set_ylabel(record["name"].replace(", ", "\n"), color=_INK, fontsize=8)
