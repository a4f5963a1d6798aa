"""What pictures show of a few telling sets, computed beside their errors from the same fits: arrays in an .npz file.

The reference is the truth, or where there is none Standard fitted to all samples.
"""

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fitter.files import replacing
from fitter.pictures import LIGHTS, lit_sphere, reflected, sphere

from ..report.methods import METHODS
from . import lamps, ridge
from .summary import OWN

_HEADLAMP = ((0.02, 0.0, 1.0), 0.5)         # a degree from the viewer, whom retro-reflection reaches
SIZE = 144                  # pixels of a sphere
_MIDDLE = 0.2               # radiance that half of the sphere is below
_EXPOSURES = 0.02, 8.0


@dataclass(frozen=True)
class Telling:
    """What to compute of a set, beside its sphere."""

    lights: tuple = LIGHTS
    with_ridge: bool = False
    with_lamps: bool = False


TELLING = {
    "retro b, Cornell": Telling(lights=(LIGHTS[0], _HEADLAMP)),
    "two-coat b, Cornell": Telling(with_ridge=True),
    "interference b, Cornell": Telling(with_ridge=True, with_lamps=True),
    "brushed b, Cornell": Telling(with_ridge=True),
    "velvet b, Cornell": Telling(),
    "matte b, Cornell": Telling(),
    "Cornell cayman": Telling(with_ridge=True, with_lamps=True),
    "Cornell garnet_red_RGB": Telling(with_ridge=True),
    "CURET 4 rough plastic": Telling(),
    "CURET 46 cotton": Telling(),
    "MERL color-changing-paint2, goniometer": Telling(with_ridge=True),
    "RGL net cc_green_malachite_rgb, goniometer": Telling(),
}


@dataclass(frozen=True)
class View:
    """What `write` computed.

    Attributes
    ----------
    names : tuple of str
        Of the spheres: the reference, Standard and the other methods.
    spheres : (names, SIZE, SIZE, 4) uint8
    ridge : (names, incidences, channels), or empty
        Of `ridge.energy` at `ridge.INCIDENCES`.
    measured : (n,)
        Measured angles of incidence, radians.
    lamp_names : tuple of str
        Of the pictures: the reference, Standard and the best of the others.
    lamps : (lamp_names, lamps.SIZE, lamps.SIZE, 3) float32, or empty
        Of `lamps.row_of_lamps`.
    """

    names: tuple
    spheres: np.ndarray
    ridge: np.ndarray
    measured: np.ndarray
    lamp_names: tuple
    lamps: np.ndarray


def path(out, name):
    """The file of a set's view."""
    return Path(out) / "views" / f"{re.sub(r'[^a-z0-9]+', '_', name.lower()).strip('_')}.npz"


def write(found, record, models, out):
    """Compute and write the view of a telling set, of the record and the models of `judging.judge`."""
    wanted = TELLING[found.name]
    samples, truth = found.open()
    reference, name = (truth, "truth") if truth else (METHODS[OWN](samples), f"{OWN}, all samples")
    shown = {name: reference, **({OWN: models[OWN]} if OWN in models else {}), **models}
    lights = exposed(reference, wanted.lights)
    spheres = np.stack([lit_sphere(model, SIZE, lights) for model in shown.values()])
    lit = {}
    if wanted.with_lamps:
        others = [other for other in models if other != OWN]
        best = min(others, key=lambda other: record["methods"][other]["held_out_cube_root_rmse"], default=None)
        lit = {key: shown[key] for key in (name, OWN, best) if key in shown}
    arrays = {
        "names": list(shown), "spheres": np.round(255 * spheres).astype(np.uint8),
        "ridge": [ridge.energy(model, ridge.INCIDENCES) for model in shown.values()] if wanted.with_ridge else [],
        "measured": ridge.measured(samples), "lamp_names": np.array(list(lit), dtype=str),
        "lamps": [lamps.row_of_lamps(model) for model in lit.values()]}
    place = path(out, found.name)
    place.parent.mkdir(parents=True, exist_ok=True)
    with replacing(place) as stream:
        np.savez_compressed(stream, **arrays)


def read(out, name):
    """The view of a set, or None if it was not computed."""
    if not path(out, name).is_file():
        return None
    with np.load(path(out, name)) as file:
        arrays = dict(file)
    for key in ("names", "lamp_names"):
        arrays[key] = tuple(map(str, arrays[key]))
    return View(**arrays)


def exposed(reference, lights):
    """The lights, all made stronger or weaker, so that a sphere of the reference is neither black nor white."""
    normal, _, _ = sphere(32)
    radiance = sum(np.pi * strength * reflected(reference, normal, direction) for direction, strength in lights)
    brightest = radiance.max(axis=1)
    middle = np.median(brightest[brightest > 0]) if brightest.any() else _MIDDLE
    exposure = np.clip(_MIDDLE / middle, *_EXPOSURES)
    return tuple((direction, exposure * strength) for direction, strength in lights)
