"""The mixture of closures, run inside Cycles, against `node_mixture.evaluate`, and the directions sampled by it."""

import bpy
import numpy as np
import pytest

import fitter
from fitter.arrays import unit_vectors
from fitter.cycles import node_mixture
from fitter.cycles.bake import bake
from support.anisotropic import ANISOTROPIC, brushed_fit
from support.cases import quick
from support.made_fits import MADE_FITS
from support.mixtures import density, made_mixture
from support.stage import add_lamp, black_scene, blank_material, render, rotation_toward

ANGLES = np.radians([0.0, 1.0, 23.0, 45.5, 61.0, 78.0, 86.0, 89.0])     # some of them beyond the last stop
AZIMUTHS = np.radians([0.0, 17.0, 90.0, 130.0, 200.0, 271.0, 305.0, 45.0])
PER_VIEW = 500
ARC_COSINE = 7e-5               # radians, the error of that of OSL; it matters where shapes change with the angle
MIXTURES = {
    "lobes of all kinds": lambda curet, cornell: made_mixture(),
    "lobes of all kinds, anisotropic": lambda curet, cornell: made_mixture(0.0),
    "krylon": lambda curet, cornell: node_mixture.cycles_mixture(
        fitter.fit(cornell("krylon_blue_RGB"), **fitter.PRESETS["Standard"])),
    "velvet": lambda curet, cornell: node_mixture.cycles_mixture(
        fitter.fit(curet("velvet"), **fitter.PRESETS["Draft"])),
    "cayman": lambda curet, cornell: node_mixture.cycles_mixture(
        fitter.fit(cornell("cayman"), **fitter.PRESETS["Standard"])),
    "brushed": lambda curet, cornell: node_mixture.cycles_mixture(brushed_fit()),
    "woven": lambda curet, cornell: node_mixture.cycles_mixture(ANISOTROPIC[-1])}
MADE = "lobes of all kinds", "lobes of all kinds, anisotropic"


@pytest.fixture
def probe(probe):
    """OSL code with a mixture, in a shader of some fit."""
    fit = MADE_FITS["half and difference"]
    return lambda mixture, code, count, **tables: probe(fit, code, count, mixture=mixture, **tables)


def interpolate_mixture(name, curet, cornell):
    """In the frame of the shader, whose x is the first principal axis."""
    made = MIXTURES[name](curet, cornell)
    return made if made.turn is None else made._replace(turn=0.0)


def viewers(mixture):
    """Viewing directions: of an isotropic fit in the plane of x, and of others beside the normal, which has none."""
    isotropic = mixture.turn is None
    theta, phi = (ANGLES, 0 * ANGLES) if isotropic else (np.maximum(ANGLES, 1e-3), AZIMUTHS)
    return unit_vectors(theta, phi)


def lowered(wo, angle):
    """A viewing direction farther from the normal by an angle."""
    return unit_vectors(np.arccos(wo[2]) + angle, np.arctan2(wo[1], wo[0]))


def anywhere(random, count):
    """Unit vectors above the horizon, evenly spread."""
    z, phi = 1 - 0.999 * random.random(count), 2 * np.pi * random.random(count)
    return np.stack([np.sqrt(1 - z**2) * np.cos(phi), np.sqrt(1 - z**2) * np.sin(phi), z], axis=1)


@pytest.mark.parametrize("name", quick(MIXTURES, *MADE, "krylon", "brushed"))
def test_the_mixture_and_the_density_of_directions_are_those_of_numpy(probe, curet, cornell, random, name):
    mixture = interpolate_mixture(name, curet, cornell)
    wo = viewers(mixture)
    wi = anywhere(random, PER_VIEW * len(wo)).reshape(len(wo), PER_VIEW, 3)
    near = slice(0, PER_VIEW // 2)          # near the mirror direction, where lobes are narrow
    wi[:, near] = wo[:, None] * [-1, -1, 1] + 0.3 * random.random((len(wo), PER_VIEW // 2, 1)) * wi[:, near]
    wi /= np.linalg.norm(wi, axis=-1, keepdims=True)
    code = """
      vector wi = vector(WI[3 * pixel], WI[3 * pixel + 1], WI[3 * pixel + 2]);
      vector wo = vector(WO[3 * pixel], WO[3 * pixel + 1], WO[3 * pixel + 2]);
      Mixture mixture;
      interpolate_mixture(MIXTURE, wo, 0, mixture);
      prepare_facets(mixture);
      float density;
      color value = eval_mixture(mixture, wi, density);"""
    count = PER_VIEW * len(wo)
    inputs = {"WI": wi.reshape(-1, 3), "WO": np.repeat(wo, PER_VIEW, axis=0)}
    found, densities = (probe(mixture, f"if (pixel < {count}) {{ {code} out = {result}; }}", count, **inputs).reshape(
        len(wo), PER_VIEW, 3) for result in ("value", "density"))
    off = []
    for number, viewer in enumerate(wo):
        for function, here in ((node_mixture.evaluate, found[number]), (density, densities[number])):
            there, *others = (function(mixture, each, wi[number]).reshape(PER_VIEW, -1)
                              for each in (viewer, *(lowered(viewer, angle) for angle in (ARC_COSINE, -ARC_COSINE))))
            allowed = 2e-3 * there + 1e-4 * there.max() + np.abs(np.subtract(*others))
            off.append((np.abs(here - there) > allowed).any(axis=1))
    # on the horizon of a tilted lobe rounding decides
    assert np.count_nonzero(off) <= 2, np.count_nonzero(off, axis=1)


@pytest.mark.parametrize(("name", "view"), quick(
    [(name, view) for name in MIXTURES for view in range(len(ANGLES))],
    (MADE[0], 3), (MADE[1], 5), ("krylon", 5), ("brushed", 3)))
def test_sampled_directions_follow_their_density(probe, curet, cornell, name, view):
    """Monte Carlo integrals over the hemisphere, against known ones."""
    mixture = interpolate_mixture(name, curet, cornell)
    wo = viewers(mixture)[view]
    count = 90_000
    drawn = sampled(probe, mixture, wo, count)
    np.testing.assert_allclose(np.linalg.norm(drawn, axis=1), 1, atol=1e-5)
    w = drawn[drawn[:, 2] > 1e-3]
    assert len(w) > 0.5 * count
    x, y, z = w.T
    rest = 1 / density(mixture, wo, w)
    for function, integral in ((1, 2 * np.pi), (x**2, 2 * np.pi / 3), (x, 0), (y, 0), (z, np.pi), (x > 0, np.pi),
                               (y > x, np.pi), (z < 0.25, np.pi / 2)):
        weighted = function * rest
        mean, squared = weighted.sum() / count, (weighted**2).sum() / count
        assert mean == pytest.approx(integral, abs=float(5 * (squared / count) ** 0.5 + 1e-2))


def sampled(probe, mixture, wo, count):
    """Directions that the shader samples: (count, 3)."""
    return probe(mixture, f"""
      Mixture mixture;
      interpolate_mixture(MIXTURE, vector({wo[0]}, {wo[1]}, {wo[2]}), 0, mixture);
      out = sample_mixture(mixture, point(pixel, 0.5, 0.25)) + 1.0;""", count) - 1


@pytest.mark.parametrize(("name", "view"), quick(
    [(name, view) for name in MADE for view in range(len(ANGLES))], (MADE[0], 2), (MADE[1], 6)))
def test_each_part_of_the_hemisphere_is_sampled_as_often_as_its_density_says(probe, name, view):
    mixture = interpolate_mixture(name, None, None)
    wo = viewers(mixture)[view]
    count, bands, sectors, fine = 90_000, 6, 8, 60
    x, y, z = sampled(probe, mixture, wo, count).astype(float).T
    above = z > 0
    found, _, _ = np.histogram2d(z[above], np.arctan2(y, x)[above] % (2 * np.pi), (bands, sectors),
                                 ((0, 1), (0, 2 * np.pi)))
    height, turn = np.meshgrid((np.arange(bands * fine) + 0.5) / (bands * fine),
                               2 * np.pi * (np.arange(sectors * fine) + 0.5) / (sectors * fine), indexing="ij")
    radius = np.sqrt(1 - height**2)
    grid = np.stack([radius * np.cos(turn), radius * np.sin(turn), height], axis=-1).reshape(-1, 3)
    expected = density(mixture, wo, grid).reshape(bands, fine, sectors, fine).mean(axis=(1, 3)) * (
        count * 2 * np.pi / (bands * sectors))
    assert expected.min() > 50
    off = (found - expected) / np.sqrt(expected)
    assert np.abs(off).max() < 5, off.round(1)
    assert (off**2).sum() < bands * sectors + 5 * np.sqrt(2 * bands * sectors)


CLOSURES = """
#include "baked_constants.h"
#include "random.h"
#include "shading_frame.h"
#include "fit.h"
#include "mixture.h"
shader closures(output closure color Result = 0)
{
#include "baked_tables.h"
  ShadingFrame frame;
  frame.x = vector(1.0, 0.0, 0.0);
  frame.y = vector(0.0, 1.0, 0.0);
  frame.z = vector(0.0, 0.0, 1.0);
  frame.wo = I;
  Mixture mixture;
  interpolate_mixture(MIXTURE, I, 0, mixture);
  Result = mixture_closures(mixture, frame, color(1.0));
}
"""


@pytest.mark.parametrize(("angle", "toward"), [
    (0.4, (0.5, 0.2, 0.6)), (1.2, (-0.8, 0.1, 0.3)), (1.2, (0.5, -0.4, 0.5))])
@pytest.mark.parametrize("name", MADE)
def test_cycles_makes_of_the_closures_what_is_evaluated(probe, name, angle, toward):
    """A plane under a sun."""
    mixture = interpolate_mixture(name, None, None)
    scene = black_scene(8, 8, 16, span=0.1)
    scene.cycles.max_bounces = 0
    scene.camera.location, scene.camera.rotation_euler = (10 * np.sin(angle), 0, 10 * np.cos(angle)), (0, angle, 0)
    bpy.ops.mesh.primitive_plane_add(size=4)
    text = bpy.data.texts.new("closures.osl")
    text.from_string(bake(MADE_FITS["half and difference"], CLOSURES, mixture))
    material, script, surface = blank_material("closures", "ShaderNodeScript")
    script.mode, script.script = "INTERNAL", text
    assert "Result" in script.outputs, "it does not compile"
    material.node_tree.links.new(script.outputs["Result"], surface)
    bpy.context.object.data.materials.append(material)
    add_lamp("SUN", 1, rotation=rotation_toward(toward), angle=0)
    wi = np.array([toward]) / np.linalg.norm(toward)
    expected = node_mixture.evaluate(mixture, np.array([np.sin(angle), 0, np.cos(angle)]), wi)[0]
    assert render(scene)[..., :3].mean(axis=(0, 1)) == pytest.approx(expected, rel=3e-3)
