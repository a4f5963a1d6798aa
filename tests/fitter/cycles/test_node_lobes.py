"""Lobes of closure nodes against integrals. `tests/osl/test_nodes_rendering.py` compares them with Cycles."""

import numpy as np
import pytest

from fitter.arrays import unit_vectors
from fitter.cycles import node_lobes
from fitter.cycles.node_lobes import Pairs, Shape


def shape(roughness, tilt=0.0, anisotropy=0.0):
    return Shape(*(np.array([value]) for value in (roughness, tilt, anisotropy)))


def direction(theta, phi=0.0):
    return unit_vectors(theta, phi)


def hemisphere(random, count):
    """Directions above the horizon, evenly by solid angle: (count, 3)."""
    return unit_vectors(np.arccos(random.random(count)), 2 * np.pi * random.random(count))


def value(kind, form, wo, wi, tangent=(1.0, 0, 0)):
    return node_lobes.evaluate(kind, form, Pairs.make(wo[None], wi[None], np.array([tangent])))[0]


@pytest.mark.parametrize("kind", node_lobes.FACETS)
@pytest.mark.parametrize("anisotropy", [0.0, 0.6, -0.6])
@pytest.mark.parametrize("theta_o", [0.0, 0.9])
def test_masking_is_what_the_distribution_of_microfacets_implies(random, kind, anisotropy, theta_o):
    """Smith's masking of a direction w is cos_w over the visible area of the microfacets, an integral of D (Heitz 2014,
    equation 14). The value is D G2 / (4 cos_o) with 1 / G2 = 1 / G1(o) + 1 / G1(i) - 1; from it and from the integral
    for o follows G1(i), which must be the integral for i.
    """
    form = shape(0.6, anisotropy=anisotropy)
    wo = direction(theta_o, 0.4)
    half = hemisphere(random, 400_000)
    alpha = 0.36
    along, across = (alpha * (1 - anisotropy), alpha / (1 - anisotropy)) if anisotropy >= 0 else (
        alpha / (1 + anisotropy), alpha * (1 + anisotropy))
    slopes = ((half[:, 0] / along) ** 2 + (half[:, 1] / across) ** 2) / half[:, 2] ** 2
    density = np.exp(-slopes) if kind == "Beckmann" else 1 / (1 + slopes) ** 2
    density = density / (np.pi * along * across * half[:, 2] ** 4)
    assert 2 * np.pi * (density * half[:, 2]).mean() == pytest.approx(1, rel=0.02), "D is a density of microfacets"
    seen = 2 * np.pi * (density * np.maximum(half @ wo, 0)).mean()
    masking_o = wo[2] / seen                                # G1, by the visible area of the microfacets
    wi = 2 * (half @ wo)[:, None] * half - wo
    above = (wi[:, 2] > 0.1) & (half @ wo > 0) & (density > 1e-3)
    values = value(kind, form, wo, wi[above])
    masking = values * 4 * wo[2] / density[above]
    masking_i = 1 / (1 / masking - 1 / masking_o + 1)
    for number in np.linspace(0, len(masking_i) - 1, 5).astype(int):
        light = wi[above][number]
        brute = light[2] / (2 * np.pi * (density * np.maximum(half @ light, 0)).mean())
        assert masking_i[number] == pytest.approx(brute, rel=0.04)


def test_a_diffuse_lobe_stands_on_its_tilted_normal(random):
    wo, wi = direction(0.8), hemisphere(random, 1000)
    normal = 0.6 * np.array([0, 0, 1]) + 0.4 * wo
    normal /= np.linalg.norm(normal)
    np.testing.assert_allclose(value("diffuse", shape(1, tilt=0.4), wo, wi), np.maximum(wi @ normal, 0) / np.pi)


@pytest.mark.parametrize("kind", node_lobes.FACETS)
def test_a_lobe_that_is_tilted_to_the_viewer_looks_back(random, kind):
    wo, wi = direction(0.8), hemisphere(random, 20_000)
    values = value(kind, shape(0.4, tilt=1.0), wo, wi)
    assert wi[values.argmax()] @ wo > 0.99


def test_anisotropy_turns_with_the_tangent(random):
    wo, wi = direction(0.5), hemisphere(random, 500)
    quarter = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]])
    one = value("GGX", shape(0.5, anisotropy=0.5), wo, wi)
    other = value("GGX", shape(0.5, anisotropy=0.5), quarter @ wo, wi @ quarter.T, tangent=(0.0, 1, 0))
    np.testing.assert_allclose(one, other)


@pytest.mark.parametrize("sigma", [0.1, 0.4, 1.0])
def test_sheen_is_that_of_its_formula(random, sigma):
    wo, wi = direction(1.0), hemisphere(random, 200)
    values = value("sheen", shape(sigma), wo, wi)
    for light, each in zip(wi, values, strict=True):
        half = (light + wo) / np.linalg.norm(light + wo)
        cotangent2 = half[2] ** 2 / (1 - half[2] ** 2)
        density = np.exp(-cotangent2 / sigma ** 2) / (np.pi * sigma ** 2 * (1 - half[2] ** 2) ** 2)
        masking = min(1, 2 * half[2] * wo[2] / (half @ light), 2 * half[2] * light[2] / (half @ light))
        assert each == pytest.approx(density * masking / (4 * wo[2]), rel=1e-9, abs=1e-20)


def sphere(pole):
    """Directions all over the sphere, dense at both poles, and the solid angle of each: (n, 3) and (n,)."""
    polar, azimuth = (np.arange(600) + 0.5) / 600 * np.pi, (np.arange(360) + 0.5) / 180 * np.pi
    x = np.cross(pole, [0, 1, 0])
    x /= np.linalg.norm(x)
    theta, phi = (each.ravel() for each in np.meshgrid(polar, azimuth, indexing="ij"))
    around = np.cos(phi)[:, None] * x + np.sin(phi)[:, None] * np.cross(pole, x)
    return np.cos(theta)[:, None] * pole + np.sin(theta)[:, None] * around, np.sin(theta) * np.pi / 600 * np.pi / 180


def density(kind, form, wo, wi):
    return node_lobes.pdf(kind, form, Pairs.make(wo[None], wi[None], np.array([[1.0, 0, 0]])))[0]


@pytest.mark.parametrize("kind", ["diffuse", *node_lobes.FACETS])
@pytest.mark.parametrize("form", [(0.5,), (0.95,), (0.7, 0.6), (0.7, -0.3), (0.7, 0.2, 0.6), (0.8, -0.2, -0.6)],
                         ids=str)
@pytest.mark.parametrize("theta_o", [0.0, 0.9, 1.4])
def test_a_density_integrates_to_1(kind, form, theta_o):
    """Over all directions, also those below the surface, which are sampled too."""
    wo = direction(theta_o, 0.4)
    wi, solid_angle = sphere(wo)
    assert density(kind, shape(*form), wo, wi) @ solid_angle == pytest.approx(1, abs=2e-3)


def test_the_density_of_sheen_is_even_over_the_hemisphere(random):
    np.testing.assert_allclose(density("sheen", shape(0.4), direction(0.9), hemisphere(random, 100)), 0.5 / np.pi)


@pytest.mark.parametrize("kind", node_lobes.FACETS)
@pytest.mark.parametrize("form", [(0.6,), (0.9, -0.4), (0.8, 0.5, 0.5)], ids=str)
def test_directions_reflected_by_sampled_half_vectors_have_the_density(random, kind, form):
    """Slopes of a microfacet are sampled by inversion; what is counted in caps of the sphere is the density there."""
    form, wo = shape(*form), direction(1.0)
    normal = node_lobes.normals(form.normal_offset, wo[None])[0]
    y = np.cross(normal, [1.0, 0, 0]) / np.linalg.norm(np.cross(normal, [1.0, 0, 0]))
    u, turn = random.random(200_000), 2 * np.pi * random.random(200_000)
    slope = np.sqrt(-np.log(1 - u) if kind == "Beckmann" else u / (1 - u))
    along, across = (float(width[0]) for width in node_lobes.widths(form))
    half = (normal + (slope * along * np.cos(turn))[:, None] * np.cross(y, normal)
            + (slope * across * np.sin(turn))[:, None] * y)
    half /= np.linalg.norm(half, axis=1)[:, None]
    sampled = 2 * (half @ wo)[:, None] * half - wo
    wi, solid_angle = sphere(wo)
    found = density(kind, form, wo, wi) * solid_angle
    for axis in (*np.eye(3), *-np.eye(3), wo, normal):
        expected = found[wi @ axis > 0.7].sum()
        error = np.sqrt(expected * (1 - expected) / len(u))
        assert (sampled @ axis > 0.7).mean() == pytest.approx(expected, abs=5 * error + 1e-3)


@pytest.mark.parametrize("kind", ["diffuse", *node_lobes.FACETS, "sheen"])
@pytest.mark.parametrize("form", [(0.5,), (0.3, 0.4), (0.7, -0.2, 0.5), (0.6, 0.7, -0.5), (0.95, 0.1, 0.6)], ids=str)
@pytest.mark.parametrize("theta_o", [0.1, 0.9, 1.4])
def test_the_gradient_is_that_of_small_steps(random, kind, form, theta_o):
    """Differences to both sides, where no direction crosses the horizon of the lobe in between."""
    def variables_moved(axis, step):
        rough, tilt, anisotropy = (*form, 0.0, 0.0)[:3]
        moved = np.array([np.log(rough), tilt, -np.sign(anisotropy) * np.log(1 - abs(anisotropy))])
        moved[axis] += step
        return shape(np.exp(moved[0]), moved[1], np.sign(moved[2]) * (1 - np.exp(-abs(moved[2]))))

    pairs = Pairs.make(direction(theta_o, 0.4)[None], hemisphere(random, 2000)[None], np.array([[1.0, 0, 0]]))
    found, step = node_lobes.gradient(kind, shape(*form), pairs)[:, 0], 1e-5
    for axis, slope in enumerate(found):
        before, after = (node_lobes.evaluate(kind, variables_moved(axis, side * step), pairs)[0] for side in (-1, 1))
        smooth = (before > 0) & (after > 0)
        expected = (after - before)[smooth] / (2 * step)
        np.testing.assert_allclose(slope[smooth], expected, rtol=1e-4, atol=1e-6 * np.abs(after).max())
        assert smooth.sum() > 500
