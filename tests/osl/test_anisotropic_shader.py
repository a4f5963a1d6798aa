"""The parts of the shader of an anisotropic fit, run inside Cycles, against their counterparts in NumPy."""

import numpy as np
import pytest

from fitter.cycles import anisotropic_mixture, half_vector_grid
from fitter.cycles.closure_mixture import closure_mixture
from fitter.shader_constants import AZIMUTH_VIEWS, GGX, HALF_RINGS, HALF_SECTORS, NUMBERS, PHONG, POLAR_VIEWS
from support.anisotropic import ANISOTROPIC, brushed_fit
from support.cases import quick, release
from support.osl_probe import probe_osl
from tests.fitter.cycles.test_anisotropic_mixture import Slanted

# a polar angle, and an azimuth; where half a turn changes nothing, the last is half a turn from where it is stored
VIEWS = [(0, 0), (2, 3), (6, 9), (POLAR_VIEWS - 1, 0), (4, AZIMUTH_VIEWS - 1), (4, AZIMUTH_VIEWS + 5)]
SOME_VIEWS = [view if number in (1, 5) else pytest.param(view, marks=release) for number, view in enumerate(VIEWS)]
REFLECTANCES = {"brushed": brushed_fit, "slanted": Slanted, "woven": lambda: ANISOTROPIC[-1]}


@pytest.fixture(scope="module", params=quick(REFLECTANCES, "brushed", "slanted"))
def reflectance(request):
    """An anisotropic reflectance, and its mixture."""
    found = REFLECTANCES[request.param]()
    return found, anisotropic_mixture.anisotropic_mixture(found)


@pytest.fixture
def probe(blender, reflectance):
    """OSL code with the mixture of the reflectance, in a shader of some fit."""
    from measured_brdf.addon.materials import osl_support

    assert not osl_support.missing()
    return lambda code, count, **tables: probe_osl(brushed_fit(), code, count, mixture=reflectance[1], **tables)


def azimuths(mixture):
    """How many there are in the whole turn."""
    return 2 * AZIMUTH_VIEWS if mixture.principal.half_turn else AZIMUTH_VIEWS


def seen(mixture, polar, azimuth, beside=0.01):
    """The number of a view, its polar angle and its azimuth, or those of a direction beside it."""
    count = azimuths(mixture)
    view = 0 if polar == 0 else 1 + (polar - 1) * count + azimuth % count
    return view, half_vector_grid.polar_angles()[polar] + beside, azimuth % count * 2 * np.pi / count + beside


def stored(mixture, polar, azimuth):
    """Where a view is stored, and what multiplies directions there: half a turn, or none."""
    half_turn = polar > 0 and mixture.principal.half_turn and azimuth >= AZIMUTH_VIEWS
    view = 0 if polar == 0 else 1 + (polar - 1) * AZIMUTH_VIEWS + azimuth % AZIMUTH_VIEWS
    return view, np.array([-1.0, -1, 1]) if half_turn else np.ones(3)


READ = "vector wi = vector(WI[3 * pixel], WI[3 * pixel + 1], WI[3 * pixel + 2]);"


def code_of(view, theta_o, wo):
    return f"""if (pixel < 2000) {{ {READ}
      vector wo = vector({wo[0]}, {wo[1]}, {wo[2]});
      MixtureView view;
      mixture_view(MIXTURE_NUMBERS, {view}, {theta_o}, wo, view);"""


@pytest.mark.parametrize("at", SOME_VIEWS)
def test_the_mixture_and_what_it_misses_are_the_same_in_osl(probe, reflectance, random, at):
    fit, mixture = reflectance
    cosine, phi = 1 - 0.98 * random.random(2000), 2 * np.pi * random.random(2000)
    wi = half_vector_grid.outgoing(np.arccos(cosine), phi)
    view, theta_o, phi_o = seen(mixture, *at)
    wo = half_vector_grid.outgoing(theta_o, phi_o)
    row, half_turn = stored(mixture, *at)
    expected = anisotropic_mixture.evaluate(mixture, row, wo * half_turn, wi * half_turn)
    found = probe(code_of(view, theta_o, wo) + "out = eval_mixture(MIXTURE, view, wi) + 10.0; }", 2000, WI=wi) - 10
    np.testing.assert_allclose(found, expected, rtol=2e-3, atol=1e-4 * expected.max())

    view, theta_o, phi_o = seen(mixture, *at, beside=0)
    wo = half_vector_grid.outgoing(theta_o, phi_o)
    turn = mixture.principal.turn
    value = np.maximum(fit.evaluate(np.arccos(cosine), phi + turn, theta_o, phi_o + turn), 0) * cosine[:, None]
    missing = value - anisotropic_mixture.evaluate(mixture, row, wo * half_turn, wi * half_turn)
    found = probe(code_of(view, theta_o, wo) + "out = eval_missing(MISSING, view, wi) + 20.0; }", 2000, WI=wi) - 20
    # between the middles of cells the table is linear, and the fit is not; the threads of a cloth are sharp
    assert np.abs(found - missing).mean() < (0.2 if mixture.error > 0.2 else 0.05) * value.mean()


def place(mixture, view, wo, wi):
    """Where directions (n, 3) are in the tables of a view: rings and sectors, (n,)."""
    stretch, (_, half_turn) = mixture.principal.stretch, stored(mixture, *view)
    g = (wi + wo) * half_turn / [stretch, 1 / stretch, 1]
    largest = (np.pi / 2 + np.arccos(wo[2])) / 2
    farthest = np.arctan2(stretch * np.sin(largest), np.cos(largest))
    ring = np.sqrt(np.arctan2(np.hypot(g[:, 0], g[:, 1]), g[:, 2]) / farthest) * HALF_RINGS
    return ring, np.arctan2(g[:, 1], g[:, 0]) / (2 * np.pi) % 1 * HALF_SECTORS


@pytest.mark.parametrize("at", SOME_VIEWS)
def test_every_direction_has_its_place_in_the_tables(probe, reflectance, random, at):
    """Also on their edges: the half vector on the normal and about it, on the axes, and as far from it as it may be."""
    _, mixture = reflectance
    view, theta_o, phi_o = seen(mixture, *at)
    wo = half_vector_grid.outgoing(theta_o, phi_o)
    azimuth = np.linspace(0, 2 * np.pi, 72, endpoint=False)
    turned = np.concatenate([azimuth + off for off in (0, 1e-5, -1e-5)])
    near = half_vector_grid.outgoing(np.repeat([0.0, 0.003, 0.02, 0.2], len(turned)), np.tile(turned, 4))
    mirrored = 2 * (near @ wo)[:, None] * near - wo
    behind = half_vector_grid.outgoing(np.pi / 2 - np.repeat([1e-7, 1e-3, 0.05], 9),
                                       phi_o + np.tile(np.linspace(-0.2, 0.2, 9), 3))
    anywhere = half_vector_grid.outgoing(np.arccos(random.random(800)), 2 * np.pi * random.random(800))
    wi = np.concatenate([mirrored[mirrored[:, 2] > 1e-3], behind, anywhere]).astype(np.float32)[:2000]
    found = probe(code_of(view, theta_o, wo) + """
        out = eval_missing(MISSING, view, wi) + 20.0;
        out[2] = pdf_table(SAMPLING_REFLECTED, view.view, wo, wi); }""", 2000, WI=np.resize(wi, (2000, 3)))[:len(wi)]
    row, _ = stored(mixture, *at)
    ring, sector = place(mixture, at, wo, wi.astype(float))
    table = mixture.missing[row].reshape(HALF_RINGS, HALF_SECTORS, -1)
    x, y = np.clip(ring - 0.5, 0, HALF_RINGS - 1), sector - 0.5
    first = np.minimum(x.astype(int), HALF_RINGS - 2)
    before = np.floor(y).astype(int) % HALF_SECTORS
    s, t, after = (x - first)[:, None], (y - np.floor(y))[:, None], (before + 1) % HALF_SECTORS
    inner, outer = ((1 - t) * table[first + k, before] + t * table[first + k, after] for k in (0, 1))
    expected = (1 - s) * inner + s * outer
    turned = ring > 1e-2            # a half vector on the normal has no azimuth
    assert (np.abs(found[:, :2] - 20) <= 1.001 * np.abs(table).max() + 1e-5).all()
    np.testing.assert_allclose(found[turned, :2] - 20, expected[turned, :2], atol=2e-3 * np.abs(table).max() + 2e-5)
    assert (found[:, 2] > 0).all()
    # the density times the solid angle of a cell is its probability, unless the direction is on the edge of a cell
    inside = (np.abs(ring % 1 - 0.5) < 0.49) & (np.abs(sector % 1 - 0.5) < 0.49) & (ring > 1)
    cell = np.minimum(ring.astype(int), HALF_RINGS - 1) * HALF_SECTORS + sector.astype(int) % HALF_SECTORS
    share = np.diff(mixture.reflected[row].astype(float), prepend=0)[cell]
    density = found[:, 2] * solid_angle(mixture, wo, wi.astype(float), cell // HALF_SECTORS)
    np.testing.assert_allclose(density[inside], share[inside], rtol=5e-3, atol=3e-7)


def solid_angle(mixture, wo, wi, ring):
    """Of directions in a cell of a ring, if all were like these."""
    stretch = mixture.principal.stretch
    h = (wi + wo) / np.linalg.norm(wi + wo, axis=1)[:, None]
    largest = (np.pi / 2 + np.arccos(wo[2])) / 2
    farthest = np.arctan2(stretch * np.sin(largest), np.cos(largest))
    low, high = (np.cos(farthest * ((ring + k) / HALF_RINGS) ** 2) for k in (0, 1))
    factor = 4 * (h @ wo) * np.linalg.norm(h / [stretch, 1 / stretch, 1], axis=1) ** 3
    return 2 * np.pi / HALF_SECTORS * (low - high) * factor


def test_lobes_of_every_kind_are_the_same_in_osl(blender, random):
    """Also near the horizon, at which the axes of phong_ramps stay."""
    mixture = anisotropic_mixture.anisotropic_mixture(brushed_fit())
    row = len(mixture.table) - 3
    table, numbers = mixture.table.copy(), mixture.numbers.copy()
    table[row] = 0.1 + random.random(table[row].shape)
    table[row, 0] = 0               # of the diffuse_ramp at the horizon
    kinds = [(PHONG, 12.0, 0.1), (GGX, 0.3, 0.1), (PHONG, 40.0, -0.3)]
    more = [(0, 0, 0), (0.1, 0.2, -0.3), (0, 0, 0)]
    numbers[row, :9], numbers[row, NUMBERS:] = np.ravel(kinds), np.ravel(more)
    mixture = mixture._replace(table=table, numbers=numbers)
    at = POLAR_VIEWS - 1, AZIMUTH_VIEWS - 3
    assert stored(mixture, *at)[0] == row
    view, theta_o, phi_o = seen(mixture, *at)
    wo = half_vector_grid.outgoing(theta_o, phi_o)
    wi = half_vector_grid.outgoing(np.arccos(1 - 0.98 * random.random(2000)), 2 * np.pi * random.random(2000))
    found = probe_osl(brushed_fit(), code_of(view, theta_o, wo) + "out = eval_mixture(MIXTURE, view, wi); }", 2000,
                      mixture=mixture, WI=wi)[:2000]
    expected = anisotropic_mixture.evaluate(mixture, row, wo, wi)
    np.testing.assert_allclose(found, expected, rtol=2e-3, atol=1e-4 * expected.max())


@pytest.mark.parametrize("at", SOME_VIEWS)
def test_drawn_directions_follow_the_density_that_is_reported(probe, reflectance, at):
    """Monte Carlo integrals over the hemisphere, against known ones."""
    view, *angles = seen(reflectance[1], *at)
    wo = half_vector_grid.outgoing(*angles)
    draw = f"""vector wo = vector({wo[0]}, {wo[1]}, {wo[2]});
               vector wi = sample_table(SAMPLING_REMAINDER, {view}, wo, point(pixel, 0.5, 0.25));"""
    count = 90_000
    drawn = probe(draw + "out = wi + 1.0;", count) - 1
    density = probe(draw + f"out = pdf_table(SAMPLING_REMAINDER, {view}, wo, wi);", count)[:, 0]
    np.testing.assert_allclose(np.linalg.norm(drawn, axis=1), 1, atol=1e-5)
    above = drawn[:, 2] > 1e-4
    assert above.mean() > 0.9
    integrands = {"1": (lambda x, y, z: np.ones_like(x), 2 * np.pi), "x^2": (lambda x, y, z: x**2, 2 * np.pi / 3),
                  "x": (lambda x, y, z: x, 0), "y": (lambda x, y, z: y, 0), "z": (lambda x, y, z: z, np.pi),
                  "x > 0": (lambda x, y, z: x > 0, np.pi), "y > x": (lambda x, y, z: y > x, np.pi)}
    for name, (function, integral) in integrands.items():
        weighted = function(*drawn[above].T) / density[above]
        mean, squared = weighted.sum() / count, (weighted ** 2).sum() / count
        assert mean == pytest.approx(integral, abs=float(5 * (squared / count) ** 0.5)), name


def test_from_anywhere_every_direction_may_be_drawn(probe, reflectance, random):
    """With one of the views that is taken there; at least about as often as one in a thousand is."""
    theta, phi = np.pi / 2 * random.random((2, 40_000)) * [[1], [4]]
    wo = half_vector_grid.outgoing(theta, phi)
    cosine = 1e-4 + (1 - 1e-4) * random.random(40_000)
    wi = half_vector_grid.outgoing(np.arccos(cosine), random.random(40_000) * 2 * np.pi)
    code = f"""if (pixel < 40000) {{ {READ}
      vector wo = vector(WO[3 * pixel], WO[3 * pixel + 1], WO[3 * pixel + 2]);
      MixtureView view;
      sample_view(MIXTURE_NUMBERS, wo, point(pixel, 0.25, 0.75), view);
      out = color(pdf_table(SAMPLING_REMAINDER, view.view, wo, wi), pdf_table(SAMPLING_REFLECTED, view.view, wo, wi),
                  view.view); }}"""
    found = probe(code, 40_000, WI=wi, WO=wo)[:40_000]
    assert found[:, :2].min() > 1e-6
    assert np.quantile(found[:, :2], 1e-3) > 1e-4
    assert found[:, 2].min() == 0
    assert found[:, 2].max() == azimuths(reflectance[1]) * (POLAR_VIEWS - 1)


def test_views_are_taken_around_the_viewing_direction(probe, reflectance, random):
    """Of the four around it, so that its angles are right in the mean."""
    polar, count = half_vector_grid.polar_angles(), azimuths(reflectance[1])
    theta_o = 0.5 * (polar[4] + polar[5])
    wo = half_vector_grid.outgoing(theta_o, 7.3 * 2 * np.pi / count)
    code = f"""MixtureView view;
      sample_view(MIXTURE_NUMBERS, vector({wo[0]}, {wo[1]}, {wo[2]}), point(pixel, 0.25, 0.75), view);
      out = view.view;"""
    view = probe(code, 40_000)[:, 0].round().astype(int) - 1
    assert set(view // count) == {3, 4}
    assert set(view % count) == {7, 8}
    assert polar[view // count + 1].mean() == pytest.approx(theta_o, abs=2e-3)
    assert (view % count).mean() == pytest.approx(7.3, abs=0.01)


def test_the_error_that_is_baked_is_the_mixtures():
    from fitter.cycles.bake import bake, fast_error

    fit = brushed_fit()
    mixture = closure_mixture(fit)
    assert fast_error(bake(fit, mixture=mixture)) == pytest.approx((mixture.error, mixture.worst), rel=1e-5)
