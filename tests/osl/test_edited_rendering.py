"""Edited fits as Cycles renders them, against integrals of what `Fit.evaluate` says they are."""

import numpy as np
import pytest

from fitter.cycles import node_mixture
from fitter.methods.editing import edited
from support.cases import quick
from support.stage import material_for

from .test_edited_shader import EDITS
from .test_rendering import LIGHTS, mean_colour, sphere_scene


@pytest.fixture(scope="module")
def fits(standard):
    return {"felt": standard("felt"), "krylon": standard("krylon_blue_RGB")}


@pytest.mark.parametrize(("material", "edit", "light"), quick([
    ("krylon", "widened", "point lamp"), ("krylon", "sharpened", "point lamp"), ("krylon", "all", "world"),
    ("krylon", "all", "sun"), ("felt", "coated", "area lamp"), ("felt", "gains", "sun without a size")],
    ("krylon", "all", "sun")))
def test_exact_converges_to_the_edited_function(blender, fits, material, edit, light):
    set_up, integrate, samples, tolerance = LIGHTS[light]
    fit = edited(fits[material], **EDITS[edit])
    # narrow highlights at grazing angles, all that a dark channel has, take more samples
    scene = sphere_scene(fit, 256 if edit == "sharpened" else samples)
    set_up()
    assert mean_colour(scene) / integrate(fit) == pytest.approx([1, 1, 1], abs=tolerance)


@pytest.mark.parametrize("edit", quick(
    [EDITS["widened"], EDITS["all"], {"coat": 0.8, "coat_width": 0.3}], EDITS["all"]))
def test_closure_nodes_have_the_light_of_the_edited_function(blender, fits, edit):
    fit = edited(fits["krylon"], **edit)
    set_up, integrate, samples, _ = LIGHTS["world"]
    scene = sphere_scene(fit, samples, material_for)
    scene.cycles.shading_system = False
    set_up()
    light = integrate(fit)
    assert np.abs(mean_colour(scene) - light).max() < 0.03 * light.max()
    assert node_mixture.node_mixtures(fit).cycles.error < 0.2
