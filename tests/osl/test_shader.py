"""The shader's parts, run inside Cycles, against their counterparts in NumPy."""

from dataclasses import replace

import numpy as np
import pytest

import fitter
from fitter.coordinates.nusselt import Nusselt
from fitter.formats import merl
from fitter.lattice import dense
from fitter.model.transform import LogRelative
from fitter.shader_constants import LOBE_EDGE_KNOT, LOBE_MARGIN
from support import merl_files, truths
from support.cases import quick
from support.made_fits import MADE_FITS
from support.osl_probe import probe_osl

COUNT = 10_000


def direction_pairs(random):
    """Unit vectors in single precision, (2, n, 3): most of them anywhere, some grazing, normal or coplanar."""
    z = random.random((2, COUNT))
    phi = random.random((2, COUNT)) * 2 * np.pi
    z[0, :500], z[1, 500:1000] = 1e-4, 1e-4             # grazing
    z[:, 1000:1200] = 0
    z[0, 1200:1500] = 1                                 # normal incidence, where wi has no azimuth
    phi[1, 1500:1600] = phi[0, 1500:1600]               # in the plane of incidence
    phi[1, 1600:1700] = phi[0, 1600:1700] + np.pi
    z[1, 1700:2000], phi[1, 1700:2000] = z[0, 1700:2000], phi[0, 1700:2000]     # retro-reflection, and about it
    z[1, 1800:2000] += np.repeat([1e-6, 1e-4, 1e-3, 1e-2], 50) * (0.5 - z[1, 1800:2000])
    phi[1, 1800:2000] += np.repeat([1e-6, 1e-4, 1e-3, 1e-2], 50) * random.standard_normal(200)
    z[1, 2000:2300], phi[1, 2000:2300] = z[0, 2000:2300], phi[0, 2000:2300] + np.pi     # mirror, and about it
    z[1, 2100:2300] += np.repeat([1e-6, 1e-4, 1e-3, 1e-2], 50) * (0.5 - z[1, 2100:2300])
    phi[1, 2100:2300] += np.repeat([1e-6, 1e-4, 1e-3, 1e-2], 50) * random.standard_normal(200)
    r = np.sqrt(1 - z**2)
    vectors = np.stack([r * np.cos(phi), r * np.sin(phi), z], axis=-1).astype(np.float32)
    vectors[1, 2000:2050] = vectors[0, 2000:2050] * [-1, -1, 1]     # to the last bit: the half vector is the normal
    return vectors


def angles(vectors):
    """Directions of float32 vectors in double precision; where incidence is normal, with the azimuth of wo."""
    incident, outgoing = vectors.astype(float)
    phi_i, phi_o = (np.arctan2(v[:, 1], v[:, 0]) for v in (incident, outgoing))
    sin_i, sin_o = (np.hypot(v[:, 0], v[:, 1]) for v in (incident, outgoing))
    phi_i = np.where(sin_i == 0, phi_o, phi_i)
    return np.arctan2(sin_i, incident[:, 2]), phi_i, np.arctan2(sin_o, outgoing[:, 2]), phi_o


FITS = {
    "leather (4,6,95)": lambda curet, cornell: fitter.fit(curet("leather")),
    "foil (1,6,90)": lambda curet, cornell: fitter.fit(curet("aluminum foil"), 1, 6, 90),
    "felt, level 6": lambda curet, cornell: fitter.fit(curet("felt"), 6, None),
    "krylon (4,6,95)": lambda curet, cornell: fitter.fit(cornell("krylon_blue_RGB")),
    "krylon (0,7,99)": lambda curet, cornell: fitter.fit(cornell("krylon_blue_RGB"), 0, 7, 99),
    "garnet (4,6,95)": lambda curet, cornell: fitter.fit(cornell("garnet_red")),
    "cayman (4,6,95)": lambda curet, cornell: fitter.fit(cornell("cayman")),
    "leather, Standard": lambda curet, cornell: fitter.fit(curet("leather"), **fitter.PRESETS["Standard"]),
    "krylon, Draft": lambda curet, cornell: fitter.fit(cornell("krylon_blue_RGB"), **fitter.PRESETS["Draft"]),
    "krylon, Standard": lambda curet, cornell: fitter.fit(cornell("krylon_blue_RGB"), **fitter.PRESETS["Standard"]),
    "garnet, Reference": lambda curet, cornell: fitter.fit(cornell("garnet_red"), **fitter.PRESETS["Reference"]),
    "cayman, Standard": lambda curet, cornell: fitter.fit(cornell("cayman"), **fitter.PRESETS["Standard"]),
    "leather as three equal channels": lambda curet, cornell: fitter.fit(
        replace(curet("leather"), values=np.repeat(curet("leather").values, 3, axis=1), channels=("R", "G", "B")),
        **fitter.PRESETS["Standard"]),
}


def _chrome(_curet, cornell):
    """A peak of a degree, of 1e5 / sr, in coordinates that are stretched as far as they can be."""
    cornell("cayman")           # skips where no measurements are at hand
    content = merl_files.of_model(truths.neural("merl", "chrome"), 45)
    return fitter.fit(merl.read(content), **fitter.PRESETS["Standard"])


FITS["chrome, Standard"] = _chrome

VECTORS = """
  vector wi = vector(WI[3 * pixel], WI[3 * pixel + 1], WI[3 * pixel + 2]);
  vector wo = vector(WO[3 * pixel], WO[3 * pixel + 1], WO[3 * pixel + 2]);
"""


def evaluated(fit, vectors):
    """A fit at pairs of directions, (2, n, 3), by the shader: (n, 3)."""
    code = f"if (pixel < {COUNT}) {{ {VECTORS} out = eval_fit(FIT, wi, wo); }}"
    return probe_osl(fit, code, COUNT, WI=vectors[0], WO=vectors[1])


@pytest.mark.parametrize("name", quick(FITS, "leather (4,6,95)", "felt, level 6", "krylon, Standard"))
def test_the_shader_evaluates_the_fit(blender, curet, cornell, random, name):
    fit = FITS[name](curet, cornell)
    vectors = direction_pairs(random)
    rendered, directions = evaluated(fit, vectors), angles(vectors)
    expected = np.maximum(fit.evaluate(*directions), 0)
    bound = 1e-5 * expected + 1e-6
    if isinstance(fit.transform, LogRelative):
        # rounding of the coordinates is an error relative to f + offset, as large as the field is steep, and steepest
        # at cayman's peak of 600 / sr and chrome's
        size, grey = expected, fit.transform.desaturation
        if grey:        # one of the mean of the channels, which is undone
            size = np.maximum(expected, expected.mean(axis=1)[:, None]) / (1 - grey)
        bound += (4e-4 if name.startswith(("cayman", "chrome")) else 3e-5) * (size + fit.transform.offset)
    if name == "cayman (4,6,95)":
        x = Nusselt().encode(*directions)
        # beside a peak of 600 / sr terms of opposite sign cancel, and single precision shows: 13 directions of 10,000
        # miss the bound, by up to 4 times; they are bounded by the terms instead
        assert np.count_nonzero((np.abs(rendered - expected) > bound).any(axis=1)) < 30
        terms = (dense.evaluate(np.abs(fit.diffuse.control_points), fit.diffuse_level, x)
                 + dense.evaluate(np.abs(fit.specular.dense), fit.specular_level, x))
        bound += 1e-6 * terms
    assert (np.abs(rendered - expected) / bound).max() <= 1


@pytest.mark.parametrize("name", quick(
    MADE_FITS, "half and difference, stretched by 2, all lobes, two columns, damped",
    "half and difference, softened by 0.3, stretched by 12", "half angle, stretched by 300, all lobes, damped",
    "half angle, stretched by 12 and about retro-reflection by 33, retro",
    "Rusinkiewicz, stretched by 33, all lobes, damped",
    "anisotropic Rusinkiewicz, all lobes, two columns, damped", "anisotropic Rusinkiewicz, stretched by 5, fibres",
    "anisotropic Nusselt, mirror"))
def test_the_shader_evaluates_every_part_of_a_fit(blender, random, name):
    fit, vectors = MADE_FITS[name], direction_pairs(random)
    expected = np.maximum(fit.evaluate(*angles(vectors)), 0)
    assert (np.abs(evaluated(fit, vectors) - expected) <= 3e-5 * (expected + fit.transform.offset)).all()


def test_values_below_zero_are_not_rendered(probe, glossy):
    fit = fitter.fit(replace(glossy, values=glossy.values - 0.2), 4, None)
    rendered = probe(fit, "out = eval_fit(FIT, vector(0.6, 0.0, 0.8), vector(0.0, 0.6, 0.8));", 4)
    assert (fit.evaluate(np.arcsin(0.6), 0, np.arcsin(0.6), np.pi / 2) < -0.05).any()
    np.testing.assert_array_equal(rendered, 0)


@pytest.mark.parametrize(("level", "compression"), quick(
    [(6, 95), (6, 90), (5, 0), (3, 99.5), (0, 90)], (6, 95), (0, 90)))
def test_every_lattice_index_has_the_same_slot_in_osl_as_in_numpy(probe, curet, level, compression):
    fit = fitter.fit(curet("leather"), 2, level, compression)
    count = int(np.prod(dense.shape(level)))
    find = "if (stored_keys(OCCUPANCY, pixel) & 1) { out = find_slot(DISPLACEMENT, pixel) + 1; }"
    rendered = probe(fit, f"if (pixel < {count}) {{ {find} }}", count)
    slots = fit.specular.index.slots(np.arange(count))
    np.testing.assert_array_equal(rendered[:, 0] - 1, slots)
    assert (np.sort(slots[slots >= 0]) == np.arange(fit.specular.count)).all()


def test_directions_about_lamps_follow_the_density_that_is_reported(probe, curet):
    """Of three lamps the small one is left alone; the density is that of the other two together."""
    fit = fitter.fit(curet("felt"), 2, None)
    lamps = """
      LampList lamps;
      lamps.count = 3;
      lamps.direction[0] = normalize(vector(0.4, -0.3, 0.6)); lamps.radius[0] = 0.3; lamps.light[0] = 1.0;
      lamps.direction[1] = vector(0.0, 0.6, 0.8); lamps.radius[1] = 0.001; lamps.light[1] = 5.0;
      lamps.direction[2] = vector(0.0, -0.6, 0.8); lamps.radius[2] = 0.1; lamps.light[2] = 3.0;
      point seed = point(pixel, 0.5, 0.25);
      int chosen = sample_lamp(lamps, seed);
      vector w = sample_cone(lamps.direction[chosen], lamps.radius[chosen], seed);"""
    count = 40_000
    drawn = probe(fit, lamps + "out = w + 1.0;", count) - 1
    chosen = probe(fit, lamps + "out = color(chosen, pdf_lamps(lamps, w), largest_radius(lamps));", count)
    np.testing.assert_allclose(np.linalg.norm(drawn, axis=1), 1, atol=1e-5)
    assert set(chosen[:, 0]) == {0, 2}
    assert (chosen[:, 0] == 2).mean() == pytest.approx(0.75, abs=0.01)
    assert chosen[0, 2] == pytest.approx(0.3)
    axes = np.array([[0.4, -0.3, 0.6], [0, -0.6, 0.8]])
    axes[0] /= np.linalg.norm(axes[0])
    for axis, radius in zip(axes, (0.3, 0.1), strict=True):
        within = drawn @ axis > np.cos(radius)
        # the solid angle of the lamp, by sampling it
        assert (within / chosen[:, 1]).mean() == pytest.approx(2 * np.pi * (1 - np.cos(radius)), rel=0.02)
        assert (within & (chosen[:, 0] == (0 if radius == 0.3 else 2))).sum() / (
            chosen[:, 0] == (0 if radius == 0.3 else 2)).sum() > 0.7


def test_the_axes_are_perpendicular_however_near_the_viewer_is_to_the_normal(probe):
    """Of others, a lamp's lobe beyond its axis is infinite: its exponent is 11,000."""
    code = """
      vector z = normalize(vector(sin(pixel), cos(2.3 * pixel), sin(5.1 * pixel) + 1.2));
      vector aside = normalize(cross(z, vector(cos(1.7 * pixel), sin(0.9 * pixel), 0.3)));
      vector viewer = normalize(z + pow(10.0, -7.0 + 0.002 * pixel) * aside);
      ShadingFrame frame = shading_frame(z, z, viewer);
      out = 1.0 + vector(dot(frame.x, frame.z), dot(frame.y, frame.z), dot(frame.x, frame.y));
      out[0] += abs(length(frame.x) - 1.0) + abs(length(frame.y) - 1.0);"""
    np.testing.assert_allclose(probe(MADE_FITS["half and difference"], code, 2000), 1, atol=1e-6)


@pytest.mark.parametrize("radius", quick([0.0, 0.0185, 0.05], 0.05))
def test_a_lobe_is_flat_over_its_lamp_in_the_mean(probe, curet, radius):
    """The mean of what Cycles makes of a lobe, over the lamp's disk, is the lobe's value on the axis."""
    fit = fitter.fit(curet("felt"), 2, None)
    count, edge = 40_000, max(radius + LOBE_MARGIN, 0.0185)
    code = f"""
      vector axis = normalize(vector(0.3, 0.2, 0.8)), wo = normalize(vector(0.5, 0.0, 0.7));
      vector across = normalize(cross(axis, vector(0.0, 0.0, 1.0))), up = cross(axis, across);
      float angle = {edge} * sqrt((pixel % 200 + 0.5) / 200.0), turn = (pixel / 200 + 0.5) * (M_2PI / 200.0);
      vector w = normalize(axis + tan(angle) * (cos(turn) * across + sin(turn) * up));
      LightLobes lobes;
      lobes.axis[0] = axis; lobes.exponent[0] = lobe_exponent({radius}); lobes.height[0] = 1.0; lobes.count = 1;
      lobes.present[0] = 1;
      out = eval_lobes(FLAT_RAMP, lobes, wo, w);
      out[1] = lobe_falloff(axis, lobes.exponent[0], w);"""
    value, falloff = probe(fit, code, count)[:, :2].T
    assert value.mean() == pytest.approx(1, abs=1e-3)
    assert np.abs(value - 1).max() < 0.025
    assert falloff.min() == pytest.approx(LOBE_EDGE_KNOT / 7, abs=2e-3)


def test_what_a_lobe_reflects_is_what_its_height_is_bounded_by(probe, curet):
    """LOBE_SOLID_ANGLE over the exponent, to 10 %, by a sum over rings."""
    fit = fitter.fit(curet("felt"), 2, None)
    code = """
      LightLobes lobes;
      vector up = vector(0.0, 0.0, 1.0);
      lobes.axis[0] = up; lobes.exponent[0] = lobe_exponent(0.05); lobes.height[0] = 1.0; lobes.count = 1;
      lobes.present[0] = 1;
      float angle = (pixel + 0.5) * 0.0002;
      out = eval_lobes(FLAT_RAMP, lobes, up, vector(sin(angle), 0.0, cos(angle)));
      out[1] = LOBE_SOLID_ANGLE / lobes.exponent[0];"""
    value, weight = probe(fit, code, 5000)[:, :2].T
    angle = (np.arange(5000) + 0.5) * 0.0002
    assert (value * 2 * np.pi * np.sin(angle)).sum() * 0.0002 == pytest.approx(weight[0], rel=0.1)
