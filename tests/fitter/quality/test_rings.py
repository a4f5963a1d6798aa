"""Rings about the highlight of iridescent flakes: a fit has no spokes across them that the measurements have not."""

import numpy as np
import pytest

import fitter
from fitter.arrays import unit_vectors
from fitter.formats import rgl
from support import checkout
from support.cases import release

PATH = checkout.measurements() / "rgl" / "irid_flake_paint1_rgb.bsdf"
COUNT, FIRST = 180, 7       # directions on a circle, and the first wave on it that is a ripple
LEAST = 0.021               # of the mean of the cube roots, which nobody sees


def ripple(surface, theta_i, theta_h):
    """How much the cube root of a BRDF varies, in waves of less than a seventh of a turn, on the circle of half vectors
    at an angle to the normal: standard deviation over the mean, of the worst channel."""
    azimuth = np.linspace(0, 2 * np.pi, COUNT, endpoint=False)
    half, light = unit_vectors(theta_h, azimuth), unit_vectors(theta_i, 0.0)
    view = 2 * (half @ light)[:, None] * half - light
    values = np.cbrt(np.maximum(surface.evaluate(np.full(COUNT, theta_i), np.zeros(COUNT), np.arccos(view[:, 2]),
                                                 np.arctan2(view[:, 1], view[:, 0])), 0))
    waves = np.fft.rfft(values, axis=0)
    waves[:FIRST] = 0
    return np.fft.irfft(waves, COUNT, axis=0).std(axis=0).max() / values.mean()


@release
@pytest.mark.skipif(not PATH.is_file(), reason="no measurements of RGL")
@pytest.mark.parametrize("preset", ["Standard", "Reference"])
def test_rings_about_a_highlight_have_no_spokes_that_the_measurements_have_not(preset):
    fit = fitter.fit(fitter.load(PATH), **fitter.PRESETS[preset])
    table = rgl.read_table(PATH.read_bytes())
    for theta_i in np.radians([20, 40, 60]):
        for theta_h in np.radians([3, 6, 10]):
            assert ripple(fit, theta_i, theta_h) < max(1.5 * ripple(table, theta_i, theta_h), LEAST)
