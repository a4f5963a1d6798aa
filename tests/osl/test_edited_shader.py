"""The shader of an edited fit, run inside Cycles, against NumPy; and its pictures against integrals."""

import itertools

import numpy as np
import pytest

import fitter
from fitter.methods.editing import edited
from support.cases import quick
from support.made_fits import MADE_FITS

from .test_shader import angles, direction_pairs, evaluated

EDITS = {
    "gains": {"diffuse": (0.5, 1.0, 2.0), "highlight": (3.0, 0.0, 1.0)},
    "widened": {"width": 2.5},
    "sharpened": {"width": 0.4, "highlight": 0.7},
    "coated": {"coat": 0.8, "coat_width": 0.05},
    "all": {"diffuse": 0.3, "highlight": 1.5, "width": 1.7, "coat": 1.0, "coat_width": 0.2},
}
FITS = {
    "krylon, Standard": lambda curet, cornell: fitter.fit(cornell("krylon_blue_RGB"), **fitter.PRESETS["Standard"]),
    "leather, Standard": lambda curet, cornell: fitter.fit(curet("leather"), **fitter.PRESETS["Standard"]),
    "leather (4,6,95)": lambda curet, cornell: fitter.fit(curet("leather")),
    "lobes of all kinds": lambda curet, cornell: MADE_FITS["Rusinkiewicz, stretched by 33, all lobes, damped"],
}


@pytest.mark.parametrize(("name", "edit"), quick(
    itertools.product(FITS, EDITS), ("krylon, Standard", "all"), ("krylon, Standard", "sharpened"),
    ("lobes of all kinds", "sharpened"), ("leather (4,6,95)", "coated")))
def test_the_shader_evaluates_the_edited_fit(blender, curet, cornell, random, name, edit):
    measured = FITS[name](curet, cornell)
    fit = edited(measured, **EDITS[edit])
    vectors = direction_pairs(random)
    rendered = evaluated(fit, vectors)
    directions = angles(vectors)
    expected = fit.evaluate(*directions)
    assert np.mean(np.abs(expected - np.maximum(measured.evaluate(*directions), 0))) > 1e-3       # the edit is one
    error = np.abs(rendered - expected) / (expected + 1e-2)
    # single precision of directions that nearly graze, or whose half vector nearly does
    assert np.quantile(error, 0.99) < 1e-4
    steady = (vectors[:, :, 2] > 0.05).all(axis=0)
    assert error[steady].max() < 2e-3
