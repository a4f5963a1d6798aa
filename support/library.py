"""How far fits of the starter library are from their own models, which are known everywhere."""

import numpy as np

from fitter.arrays import select_directions
from fitter.methods.energy import reflected_light
from fitter.model import published
from fitter.quality.cross_validation import cube_root

DEGREES = 5, 15, 30, 45, 60, 75
_CELLS = 64, 24
_STEEPEST = np.radians(80)


def albedo_error(name, fit):
    """By how much the albedo of a fit is off its model's, of light that leaves or arrives at `DEGREES`: the ratio of
    the channel and the angle where it is largest, either way, less 1."""
    found, wanted = (reflected_light(each, np.radians(DEGREES), _CELLS).sum(axis=2)
                     for each in (fit, published.find(name).model))
    return float(np.exp(np.abs(np.log(found / wanted)).max()) - 1)


def swapped_error(name, fit):
    """The root mean square of differences of the cube roots of f cos theta_o, of which a white Lambertian's is 1, where
    the light comes from the direction from which samples up to `_STEEPEST` are seen, and is seen from that of their
    light: nobody sampled those."""
    theta_i, phi_i, theta_o, phi_o = select_directions(at := published.directions(published.find(name).model),
                                                       np.maximum(at[0], at[2]) < _STEEPEST)
    found, wanted = (cube_root(theta_i, np.pi * each.evaluate(theta_o, phi_o, theta_i, phi_i))
                     for each in (fit, published.find(name).model))
    return float(np.sqrt(((found - wanted) ** 2).mean()))
