"""Sums of closure nodes against brute-force integrals of the fits that they approximate."""

import numpy as np
import pytest

import fitter
from fitter.arrays import unit_vectors
from fitter.cycles import direction_grid, node_lobes, node_mixture
from fitter.cycles.node_lobes import Pairs, Shape
from fitter.shader_constants import LEAST_FOLLOWED
from support.anisotropic import ANISOTROPIC, brushed_fit
from support.cases import quick

CONSTANT = [("diffuse", 1.0, 0.0, 0.0), ("GGX", 0.5, 0.1, 0.4), ("Beckmann", 0.25, 0.0, 0.0), ("sheen", 0.3, 0.0, 0.0)]


class Lobes:
    """A reflectance that is a sum of the first lobes of CONSTANT, the same for all viewers."""

    isotropic = True

    def __init__(self, count=4, scale=1.0):
        colours = np.array([[0.2, 0.1, 0.05], [0.05, 0.1, 0.2], [0.1, 0.1, 0.1], [0.02, 0.03, 0.02]])
        self.colours = scale * colours[:count]

    def evaluate(self, theta_i, phi_i, theta_o, phi_o):
        given = np.broadcast_arrays(theta_i, phi_i - phi_o, theta_o)
        theta_i, phi, theta_o = (each.ravel() for each in given)
        shape = theta_i.shape
        wi, wo = unit_vectors(theta_i, phi), unit_vectors(theta_o, 0.0)
        pairs = Pairs.make(wo, wi[:, None], np.broadcast_to([1.0, 0, 0], wo.shape))
        total = np.zeros((*shape, 3))
        for (kind, *form), colour in zip(CONSTANT, self.colours, strict=False):
            lobe = node_lobes.evaluate(kind, Shape(*(np.full(shape, number) for number in form)), pairs)[:, 0]
            total += lobe[:, None] * colour
        return (total / np.maximum(wi[:, 2:], 1e-6)).reshape(*given[0].shape, 3)


class Called:
    """A fit that is said to be isotropic, or not."""

    def __init__(self, fit, isotropic):
        self.evaluate, self.isotropic = fit.evaluate, isotropic


def spiral(count):
    """Directions above the horizon, as even by solid angle as a sunflower's seeds: (count, 3)."""
    z, azimuth = (np.arange(count) + 0.5) / count, np.pi * (1 + 5 ** 0.5) * np.arange(count)
    return np.stack([np.sqrt(1 - z * z) * np.cos(azimuth), np.sqrt(1 - z * z) * np.sin(azimuth), z], axis=1)


def seen_from(fit, mixture, theta_o, phi_o, wi):
    """Reflected radiance of a fit and of a mixture: (n, channels) each."""
    truth = fit.evaluate(np.arccos(wi[:, 2]), np.arctan2(wi[:, 1], wi[:, 0]), theta_o, phi_o)
    return np.maximum(truth, 0) * wi[:, 2:], node_mixture.evaluate(mixture, unit_vectors(theta_o, phi_o), wi)


@pytest.mark.parametrize(("count", "within"), [(1, 0.01), (2, 0.02), (4, 0.13)])
def test_a_sum_of_such_lobes_is_found(count, within):
    """One or two nearly; of four, which hide one another, no worse than about what is found."""
    fit = Lobes(count)
    mixture = node_mixture.node_mixtures(fit).cycles
    assert mixture.error < within
    wi = spiral(20_000)
    for theta_o in (0.03, 0.5, 1.1):
        truth, found = seen_from(fit, mixture, theta_o, 0.7, wi)
        assert np.abs(found - truth).sum() / truth.sum() < 1.3 * within


def test_the_error_that_is_told_is_that_of_brute_force(glossy):
    fit = fitter.fit(glossy, **fitter.PRESETS["Draft"])
    wi = spiral(40_000)
    for mixture in node_mixture.node_mixtures(fit)[:2]:
        angles = np.linspace(0, 1, 24) * np.radians(87)
        each = [seen_from(fit, mixture, angle, 0.0, wi) for angle in angles]
        errors = [np.abs(found - truth).sum() / truth.sum() for truth, found in each]
        assert np.mean(errors) == pytest.approx(mixture.error, rel=0.3)
        assert max(errors) < 1.5 * mixture.worst + 0.02


# the share of the light in wrong directions, at most and in the mean over polar angles
MISPLACED = {"felt": (0.05, 0.035), "aluminum foil": (0.045, 0.03), "velvet": (0.1, 0.055),
             "krylon_blue_RGB": (0.08, 0.05), "garnet_red_RGB": (0.05, 0.04), "cayman": (0.1, 0.07)}
CORNELL = "krylon_blue_RGB", "garnet_red_RGB", "cayman"


def standard(material, curet, cornell):
    samples = cornell(material) if material in CORNELL else curet(material)
    return fitter.fit(samples, **fitter.PRESETS["Standard"])


@pytest.mark.parametrize("material", quick(MISPLACED, "velvet", "krylon_blue_RGB"))
def test_little_of_the_light_of_measured_materials_is_misplaced(curet, cornell, material):
    """Over directions that are not those of the fit, from where nodes have no stop."""
    fit = standard(material, curet, cornell)
    mixture, wi, shares = node_mixture.cycles_mixture(fit), spiral(60_000), []
    for theta_o in np.radians((0, 10, 25, 35, 45, 55, 65, 75, 80)):
        truth, found = seen_from(fit, mixture, theta_o, 0.7, wi)
        shares.append(np.abs(found - truth).sum() / truth.sum())
        if theta_o < np.radians(70):
            np.testing.assert_allclose(found.mean(axis=0), truth.mean(axis=0), atol=0.01 * truth.mean())
    worst, mean = MISPLACED[material]
    assert max(shares) < worst
    assert np.mean(shares) < mean


def seen_in_grid(fit, mixture, degrees):
    """Of viewing angles the incident directions of the grid, the fit's radiance and the mixture's below it."""
    for theta_o in np.radians(degrees):
        to = direction_grid.mirror_grid(theta_o)
        yield theta_o, to, *seen_from(fit, below(mixture), theta_o, 0.0, to.unit)


def density(mixture, theta_o, wi):
    """The density of the directions that the shader samples beside closures: (n,)."""
    def at(table):
        return np.stack([np.interp(theta_o, mixture.theta, column) for column in table.T])

    wo, shape = unit_vectors(theta_o, 0.0), [at(each) for each in mixture.shape]
    pairs = Pairs.make(wo[None], wi[None], np.array([[1.0, 0, 0]]))
    lobes = [node_lobes.pdf(kind, Shape(*(each[[number]] for each in shape)), pairs)[0]
             for number, kind in enumerate(mixture.kinds)]
    return at(mixture.sampling.selection_probabilities) @ np.array([*lobes, np.full(len(wi), 0.5 / np.pi)])


def noise(carried, density, solid_angle):
    """The second moment of sampling what is carried, (n,), in that of the best sampling, of a density like it."""
    return solid_angle @ (carried ** 2 / density) / (solid_angle @ carried) ** 2


@pytest.mark.parametrize("material", quick(["krylon_blue_RGB", "garnet_red_RGB", "aluminum foil"], "krylon_blue_RGB"))
def test_sampled_directions_are_where_the_mixture_is_wrong(curet, cornell, material):
    """And, lest they be nowhere where an error was not seen, where there is light at all."""
    fit = standard(material, curet, cornell)
    mixture = node_mixture.cycles_mixture(fit)
    moments = []
    for theta_o, to, truth, found in seen_in_grid(fit, mixture, (0, 10, 25, 40, 55, 70, 80)):
        left, p = np.maximum(truth - found, 0).sum(axis=1), density(mixture, theta_o, to.unit)
        moments.append([noise(carried, p, to.solid_angle) for carried in (left + 0.1 * truth.sum(axis=1), left)])
    moments = np.array(moments)
    assert moments[:, 0].max() < 1.5            # equal shares have 1.6, even directions 47
    assert moments[:, 1].mean() < 2.4


def below(mixture):
    """The mixture as the shader has it where it is exact."""
    return mixture._replace(colour=mixture.sampling.lower_colours)


@pytest.mark.parametrize("material", quick(["krylon_blue_RGB", "garnet_red_RGB", "aluminum foil"], "krylon_blue_RGB"))
def test_where_the_shader_is_exact_the_mixture_is_hardly_above_the_fit_and_has_most_of_its_light(curet, cornell,
                                                                                                 material):
    fit = standard(material, curet, cornell)
    mixture, shares = node_mixture.cycles_mixture(fit), []
    for _, to, truth, found in seen_in_grid(fit, mixture, (3, 17, 31, 47, 62, 77)):
        above, left = (to.solid_angle @ np.maximum(each, 0) for each in (found - truth, truth - found))
        shares.append([each.sum() / (to.solid_angle @ truth).sum() for each in (above, left)])
    above, left = np.mean(shares, axis=0)
    assert above < 0.008
    assert left < 0.08


@pytest.mark.parametrize("material", quick(["krylon_blue_RGB", "garnet_red_RGB", "cayman"], "krylon_blue_RGB"))
def test_what_is_above_the_fit_is_given_back_by_what_is_left(curet, cornell, material):
    """In the mean over a sphere under even light the mixture and what is carried beside it are its albedo."""
    fit = standard(material, curet, cornell)
    mixture = node_mixture.cycles_mixture(fit)
    angles, made, wanted = direction_grid.outgoing_angles(direction_grid.OUTGOING_COUNT), [], []
    for theta_o, to, truth, found in seen_in_grid(fit, mixture, np.degrees(angles)):
        balance = [np.interp(theta_o, mixture.theta, column) for column in mixture.sampling.balance.T]
        made.append(to.solid_angle @ (found + balance * np.maximum(truth - found, 0)))
        wanted.append(to.solid_angle @ truth)
    facing = np.sin(angles) * np.cos(angles) * np.gradient(angles)
    np.testing.assert_allclose(facing @ np.array(made), facing @ np.array(wanted), rtol=1e-3)
    np.testing.assert_allclose(mixture.sampling.albedo, wanted[::2], rtol=1e-3)


@pytest.mark.parametrize("material", quick(["krylon_blue_RGB", "garnet_red_RGB", "aluminum foil"], "krylon_blue_RGB"))
def test_the_weights_below_the_fit_leave_a_direction_its_part_of_the_albedo(curet, cornell, material):
    mixture = node_mixture.cycles_mixture(standard(material, curet, cornell))
    weights, albedo = mixture.sampling.lower_colours.sum(axis=1).mean(axis=1), mixture.sampling.albedo
    most = np.maximum(np.minimum(1.02 * albedo, 1), albedo)
    assert (weights + LEAST_FOLLOWED * albedo <= most * (1 + 1e-6)).all()


@pytest.mark.parametrize("fit", [Lobes(), Lobes(1), Lobes(scale=0.0), brushed_fit()],
                         ids=["lobes", "a Lambertian", "black", "brushed"])
def test_the_shares_and_probabilities_of_sampling_are_such(fit):
    mixture = node_mixture.cycles_mixture(fit)
    below, shares, probability, albedo, left, balance = mixture.sampling
    assert below.shape == mixture.colour.shape
    assert (below >= 0).all()
    assert shares.shape == (len(mixture.theta), len(mixture.kinds) + 1)
    np.testing.assert_allclose(shares.sum(axis=1), 1)
    assert shares.min() > 0
    assert ((probability > 0) & (probability <= 1)).all()
    assert ((balance >= 0) & (balance <= 1)).all()
    assert (left <= albedo * (1 + 1e-6)).all()


@pytest.mark.parametrize("view", [0.1, 0.7, 1.2])
def test_weights_add_to_about_the_albedo(glossy, view):
    """Cycles' denoising passes use the weights as the albedo; but a lobe reflects less than its weight."""
    fit = fitter.fit(glossy, 4, 6)
    mixture = node_mixture.cycles_mixture(fit)
    truth, _ = seen_from(fit, mixture, view, 0.0, spiral(60_000))
    weights = [np.interp(view, mixture.theta, mixture.colour[:, :, 0, channel].sum(axis=1)) for channel in range(3)]
    ratio = weights / (2 * np.pi * truth.mean(axis=0))
    assert ratio.min() > 0.99
    assert ratio.max() < 1.15


def test_nothing_is_negative_and_black_stays_black():
    black = Lobes(scale=0.0)
    for mixture in (*node_mixture.node_mixtures(black)[:2], node_mixture.cycles_mixture(Called(black, False))):
        assert np.abs(mixture.colour).max() < 1e-9
        assert all(np.isfinite(each).all() for each in (*mixture.shape, *(mixture.sampling or ())))
    for mixture in node_mixture.node_mixtures(Lobes())[:2]:
        assert (mixture.colour >= 0).all()
        assert ((mixture.shape.roughness > 0) & (mixture.shape.roughness <= 1)).all()
        assert (np.abs(mixture.shape.normal_offset) <= 1).all()
        assert (np.abs(mixture.shape.anisotropy) < 1).all()


def test_eevee_gets_only_what_it_renders(glossy):
    mixture = node_mixture.node_mixtures(fitter.fit(glossy, **fitter.PRESETS["Draft"])).eevee
    assert set(mixture.kinds) <= {"diffuse", "GGX"}
    assert not mixture.shape.anisotropy.any()


def test_an_anisotropic_highlight_turns_with_the_viewer():
    fit = brushed_fit()
    mixture = node_mixture.node_mixtures(fit).cycles
    wi = spiral(60_000)
    errors = []
    for theta_o in (0.2, 0.8):
        for phi_o in (0.0, 0.9, 2.2, 4.0):
            truth, found = seen_from(fit, mixture, theta_o, phi_o, wi)
            errors.append(np.abs(found - truth).sum() / truth.sum())
            np.testing.assert_allclose(found.mean(axis=0), truth.mean(axis=0), rtol=0.05)
    assert np.mean(errors) < 0.1
    assert np.mean(errors) == pytest.approx(mixture.error, abs=0.03)


@pytest.mark.parametrize("name", quick(["brushed a", "brushed b", "ward b", "lacquered b"], "lacquered b"))
def test_little_of_the_light_of_anisotropic_materials_is_misplaced(name):
    truth = next(each for each in ANISOTROPIC if each.name == name)
    mixture, wi = node_mixture.cycles_mixture(Called(truth, False)), spiral(100_000)
    for theta_o in (0.1, 0.8, 1.2):
        for phi_o in (0.4, 2.0, 3.6, 5.1):
            wanted, found = seen_from(truth, mixture, theta_o, phi_o, wi)
            assert np.abs(found - wanted).sum() < 0.07 * wanted.sum()


class Leaning:
    """A brushed surface that shines more to one side: half a turn changes it."""

    isotropic = False

    def __init__(self):
        self.brushed = brushed_fit(0.1, 0.4, 0.0)

    def evaluate(self, theta_i, phi_i, theta_o, phi_o):
        side = np.sin(theta_i) * np.cos(phi_i) + np.sin(theta_o) * np.cos(phi_o)
        return self.brushed.evaluate(theta_i, phi_i, theta_o, phi_o) * (1 + 0.3 * side)[..., None]


def test_of_a_surface_that_half_a_turn_changes_the_mixture_is_that_of_the_mean():
    """Its colours are the same after half a turn: what is told is the error over the whole turn."""
    fit = Leaning()
    mixture, wi, shares, light = node_mixture.cycles_mixture(fit), spiral(40_000), [], []
    for theta_o in np.radians((15, 45, 75)):
        for phi_o in np.arange(12) * np.pi / 6:
            truth, found = seen_from(fit, mixture, theta_o, phi_o, wi)
            shares.append(np.abs(found - truth).sum() / truth.sum())
            light.append(found.sum() / truth.sum())
    assert np.mean(shares) == pytest.approx(mixture.error, rel=0.25)
    assert np.mean(light) == pytest.approx(1, abs=0.02)


def test_an_isotropic_reflectance_has_the_same_mixture_for_all_azimuths():
    """A round lobe, looked at as an isotropic reflectance and as an anisotropic one."""
    fit = brushed_fit(0.2, 0.2)
    mixture, isotropic = (node_mixture.cycles_mixture(Called(fit, each)) for each in (False, True))
    assert mixture.turn is not None
    assert isotropic.turn is None
    assert mixture.error < isotropic.error + 0.01
    wi = spiral(20_000)
    for theta_o in (0.3, 1.1):
        alone = node_mixture.evaluate(isotropic, unit_vectors(theta_o, 0.0), wi)
        for phi_o in (0.0, 0.8, 1.6, 2.4):
            c, s = np.cos(phi_o), np.sin(phi_o)
            turned = wi @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
            seen = node_mixture.evaluate(mixture, unit_vectors(theta_o, phi_o), turned)
            assert np.abs(seen - alone).sum() < 0.02 * alone.sum()
