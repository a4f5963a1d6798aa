"""The baselines: analytic cases, formulas written out by hand, and the errors of an independent implementation."""

from dataclasses import replace

import numpy as np
import pytest

import fitter
from benchmarks.report.baselines import ggx, koenderink, lafortune, neural, thin_plate
from fitter.arrays import unit_vectors
from fitter.coordinates.half_difference import HalfDifference
from fitter.model import published
from fitter.model.low2012 import Low2012
from fitter.quality.cross_validation import cross_validate
from support.cases import release

pytestmark = release        # only benchmarks use them


def directions(random, count=600):
    theta_i, theta_o, phi_o = random.random((3, count)) * np.array([[1.5], [1.5], [np.pi]])
    return theta_i, np.zeros(count), theta_o, phi_o


def grey(samples, values):
    return replace(samples, values=values, channels=("grey",))


def rmse(model, samples):
    return fitter.error_metrics(samples.values, model.evaluate(*samples.directions)).rmse


def test_koenderinks_functions_are_orthogonal_over_both_hemispheres():
    """By quadrature that is exact for them: r dr = sin(theta) dtheta / 2, and even steps of delta_phi."""
    nodes, weights = np.polynomial.legendre.leggauss(12)
    theta, weights = 2 * np.arcsin((nodes + 1) / 2 / np.sqrt(2)), weights * (nodes + 1) / 4
    phi = np.arange(20) * 2 * np.pi / 20
    theta_i, theta_o, delta_phi = (grid.ravel() for grid in np.meshgrid(theta, theta, phi, indexing="ij"))
    values = koenderink.design_matrix(8, theta_i, 0, theta_o, delta_phi)
    gram = (values * np.einsum("i,j,k->ijk", weights, weights, np.full(20, 1 / 20)).ravel()[:, None]).T @ values
    squares = [(4 if n == m else 2) / ((2 * n + 2) * (2 * m + 2)) * (0.5 if l else 1)
               for n, m, l in koenderink.modes(8)]
    np.testing.assert_allclose(gram, np.diag(squares), atol=1e-13)


@pytest.mark.parametrize("lobe", [(-1.03, 0.71, 67.0), (-0.9, 0.9, 12.0), (0.87, 0.8, 21.8)])
def test_one_lafortune_lobe_over_a_lambertian_is_recovered(random, lobe):
    truth = lafortune.Lafortune(np.array([0.3]), np.array(lobe)[None, :, None])
    at = directions(random)
    samples = fitter.Samples(*at, truth.evaluate(*at))
    found = lafortune.fit(samples, lobes=1)
    np.testing.assert_allclose(found.rho, truth.rho, atol=1e-6)
    np.testing.assert_allclose(found.lobes, truth.lobes, rtol=1e-6)


def test_lafortune_evaluates_the_formula_with_vectors(random):
    model = lafortune.Lafortune(np.array([0.3, 0.6]), random.random((3, 3, 2)) * [[[2], [2], [9]]] - [[[1], [1], [0]]])
    theta_i, phi_i, theta_o, phi_o = 0.7, 0.3, 1.1, 2.5
    i, o = unit_vectors(theta_i, phi_i), unit_vectors(theta_o, phi_o)
    expected = [model.rho[c] / np.pi + sum(max(xy * (i[0] * o[0] + i[1] * o[1]) + z * i[2] * o[2], 0) ** n
                                           for xy, z, n in model.lobes[:, :, c]) for c in range(2)]
    np.testing.assert_allclose(model.evaluate(theta_i, phi_i, theta_o, phi_o), expected, rtol=1e-12)


def test_counts_are_the_papers():
    assert lafortune.Lafortune(np.zeros(1), np.zeros((3, 3, 1))).coefficient_count == 10
    assert koenderink.Koenderink(8, np.zeros((55, 3))).nbytes == 4 * 55 * 3
    low = Low2012(np.array([0.1, 0.3]), np.array([20.0, 5.0]), 300.0, 1.4, 1.6)
    assert (low.coefficient_count, low.nbytes) == (5, 4 * 7)


# design.md, section 5; a baseline may be better, and must not be made worse than it is
@pytest.mark.parametrize(("sample", "koenderink_8", "lafortune_3"), [(1, 0.0112, 0.0191), (5, 0.0395, 0.0475),
                                                                     (15, 0.0361, 0.0809)])
def test_errors_on_curet_are_those_of_the_reference_or_better(curet, sample, koenderink_8, lafortune_3):
    samples = curet(sample)
    assert rmse(koenderink.fit(samples), samples) == pytest.approx(koenderink_8, rel=0.01)
    assert rmse(lafortune.fit(samples), samples) < 1.01 * lafortune_3


@pytest.mark.parametrize(("stem", "channel", "koenderink_8", "lafortune_3"),
                         [("krylon_blue_RGB", 2, 0.444, 0.0674), ("garnet_red_RGB", 0, 0.213, 0.0732)])
def test_errors_on_cornell_are_those_of_the_reference_or_better(cornell, stem, channel, koenderink_8, lafortune_3):
    samples = cornell(stem)
    samples = grey(samples, samples.values[:, [channel]])
    assert rmse(koenderink.fit(samples), samples) == pytest.approx(koenderink_8, rel=0.01)
    assert rmse(lafortune.fit(samples), samples) < 1.01 * lafortune_3


def test_three_lobes_fit_cayman_at_least_as_well_as_the_reference(data, cornell):
    path = data / "cornell" / "cayman.astm"
    bands = np.loadtxt(path.read_text("latin-1").split("\nVARS")[1].splitlines()[1:], delimiter=",")[:, 4:]
    samples = grey(cornell("cayman"), bands.mean(axis=1, keepdims=True))
    assert rmse(koenderink.fit(samples), samples) == pytest.approx(11.5, rel=0.01)
    assert rmse(lafortune.fit(samples), samples) < 0.103


def ggx_with_vectors(kd, f0, alpha, theta_i, theta_o, delta):
    """The model of one channel at one pair of directions, with Heitz's Lambda in the place of the visibility."""
    i, o = unit_vectors(theta_i, 0), unit_vectors(theta_o, delta)
    h = (i + o) / np.linalg.norm(i + o)
    d = alpha**2 / (np.pi * ((alpha**2 - 1) * h[2]**2 + 1)**2)
    shadow_i, shadow_o = (-0.5 + 0.5 * np.sqrt(1 + (alpha * np.tan(theta))**2) for theta in (theta_i, theta_o))
    fresnel = f0 + (1 - f0) * (1 - i @ h)**5
    return kd + d * fresnel / (1 + shadow_i + shadow_o) / (4 * i[2] * o[2])


def test_ggx_evaluates_the_formula_with_vectors(random):
    model = ggx.GGX(np.array([0.3, 0.6]), np.array([0.04, 0.9]), 0.3)
    theta_i, _, theta_o, delta = directions(random, 20)
    expected = [[ggx_with_vectors(model.kd[c], model.f0[c], 0.3, *angles) for c in range(2)]
                for angles in zip(theta_i, theta_o, delta, strict=True)]
    np.testing.assert_allclose(model.evaluate(theta_i, 0.7, theta_o, delta + 0.7), expected, rtol=1e-6)


@pytest.mark.parametrize(("alpha", "f0"), [(0.05, (0.04, 0.06)), (0.2, (0.5, 0.9)), (0.7, (0.2, 0.04))])
def test_a_ggx_lobe_over_a_lambertian_is_recovered(random, alpha, f0):
    theta_i, phi_i, theta_o, delta = directions(random)
    kd = 0.1, 0.02
    values = [[ggx_with_vectors(kd[c], f0[c], alpha, *angles) for c in range(2)]
              for angles in zip(theta_i, theta_o, delta, strict=True)]
    found = ggx.fit(fitter.Samples(theta_i, phi_i, theta_o, delta, values, ("a", "b")))
    np.testing.assert_allclose([*found.kd, *found.f0, found.alpha], [*kd, *f0, alpha], rtol=1e-4)


def smooth(theta_i, _, theta_o, delta):
    """A reflectance whose logarithm is a smooth function of the two directions' product."""
    xy = np.sin(theta_i) * np.sin(theta_o) * np.cos(delta)
    return np.exp(-1 - xy + 0.5 * np.cos(theta_i) * np.cos(theta_o))[:, None]


def test_a_thin_plate_spline_is_the_sum_of_its_kernels(random):
    """Solved with NumPy's own linear algebra."""
    at = directions(random, 60)
    samples = fitter.Samples(*at, smooth(*at))
    model = thin_plate.fit_smoothed(samples, 0.01)
    mu = 2 * HalfDifference().encode(*at) - 1

    def kernel(r):
        return r**2 * np.log(np.maximum(r, 1e-300))

    polynomial = np.column_stack([np.ones(60), mu])
    apart = np.linalg.norm(mu[:, None] - mu, axis=-1)
    system = np.block([[kernel(apart) + 0.01 * np.eye(60), polynomial], [polynomial.T, np.zeros((4, 4))]])
    offset = thin_plate.OFFSET * np.median(samples.values)
    solution = np.linalg.solve(system, np.append(np.log(samples.values[:, 0] + offset), np.zeros(4)))
    other = directions(random, 20)
    nu = 2 * HalfDifference().encode(*other) - 1
    field = kernel(np.linalg.norm(nu[:, None] - mu, axis=-1)) @ solution[:60] + solution[60] + nu @ solution[61:]
    np.testing.assert_allclose(model.evaluate(*other)[:, 0], np.exp(field) - offset, rtol=1e-6)
    assert (model.coefficient_count, model.nbytes) == (64, 4 * (64 + 180))


def neural_by_hand(model, theta_i, phi_i, theta_o, phi_o):
    """The network at one pair of directions: rotations as matrices, and sums as loops."""
    i, o = unit_vectors(theta_i, phi_i), unit_vectors(theta_o, phi_o)
    h = (i + o) / np.linalg.norm(i + o)
    theta_h, phi_h = np.arccos(h[2]), np.arctan2(h[1], h[0])
    about_z = np.array([[np.cos(phi_h), np.sin(phi_h), 0], [-np.sin(phi_h), np.cos(phi_h), 0], [0, 0, 1]])
    about_y = np.array([[np.cos(theta_h), 0, -np.sin(theta_h)], [0, 1, 0], [np.sin(theta_h), 0, np.cos(theta_h)]])
    h, d = about_y @ about_z @ h, about_y @ about_z @ i
    np.testing.assert_allclose(h, [0, 0, 1], atol=1e-12)
    x = [np.sin(theta_h), 0, np.cos(theta_h), d[0], abs(d[1]), d[2]]
    for layer, (weight, bias) in enumerate(zip(model.weights, model.biases, strict=True)):
        x = [sum(x[j] * weight[j, k] for j in range(len(x))) + bias[k] for k in range(len(bias))]
        x = [max(value, 0) for value in x] if layer < 2 else [max(np.exp(value) - 1, 0) for value in x]
    return x


def random_network(random):
    shapes = (6, 21), (21, 21), (21, 3)
    return neural.Neural(tuple(random.normal(0, 0.4, shape) for shape in shapes),
                         tuple(random.normal(0, 0.4, columns) for _, columns in shapes))


def test_the_neural_brdf_evaluates_the_formula_with_matrices(random):
    model = random_network(random)
    assert model.coefficient_count == 675
    theta_i, _, theta_o, phi_o = directions(random, 10)
    phi_i = random.random(10) * 6
    expected = [neural_by_hand(model, *angles) for angles in zip(theta_i, phi_i, theta_o, phi_o, strict=True)]
    assert np.ptp(expected) > 1
    np.testing.assert_allclose(model.evaluate(theta_i, phi_i, theta_o, phi_o), expected, rtol=1e-9, atol=1e-12)


def test_the_gradient_of_the_neural_loss_is_that_of_finite_differences(random):
    parameters = [random.normal(0, 0.4, shape) for shape in ((2, 6, 21), (2, 1, 21), (2, 21, 21), (2, 1, 21),
                                                             (2, 21, 3), (2, 1, 3))]
    theta_i, *others = directions(random, 12)
    x, cos_i = neural.half_and_difference(theta_i, *others), np.cos(theta_i)[:, None]
    target = random.random((12, 3))

    def loss(parameters):
        weights, biases = parameters[::2], parameters[1::2]
        inner = np.maximum(x @ weights[0] + biases[0], 0)
        inner = np.maximum(inner @ weights[1] + biases[1], 0)
        f = np.exp(inner @ weights[2] + biases[2]) - 1
        return np.abs(np.log(np.maximum(1 + f * cos_i, 1e-3)) - target).mean(axis=(1, 2)).sum()

    found = neural.gradient(parameters, x, cos_i, target)
    for array, slopes in zip(parameters, found, strict=True):
        assert array.shape == slopes.shape
        for index in random.choice(array.size, 6, replace=False):
            at, before = np.unravel_index(index, array.shape), array.flat[index]
            ends = []
            for step in (1e-6, -1e-6):
                array[at] = before + step
                ends.append(loss(parameters))
            array[at] = before
            assert slopes[at] == pytest.approx((ends[0] - ends[1]) / 2e-6, rel=1e-4, abs=1e-7)


# five folds; a rival may be better, and must not be made worse than it is
@pytest.mark.parametrize(("baseline", "sample", "limit"), [
    (lafortune, 4, 0.05), (ggx, 12, 0.011), (ggx, 4, 0.047), (thin_plate, 1, 0.0055), (thin_plate, 15, 0.010)])
def test_rivals_predict_what_is_held_out_of_curet_as_well_as_they_did(curet, baseline, sample, limit):
    assert cross_validate(curet(sample), baseline.fit).cube_root_rmse < limit


def test_a_published_network_is_the_authors_and_unknown_names_are_told(data):
    path, tool = data / "merl" / "nbrdf_nets.npz", data.parent / "tools" / "merl_binary.py"
    if not path.is_file():
        pytest.skip(f"the published networks are absent from {path.parent}")
    model = neural.published(path, "alum-bronze")
    assert (model.coefficient_count, model.nbytes) == (675, 2700)
    with pytest.raises(ValueError, match=r"no network 'bronze'.*expected one of alum-bronze"):
        neural.published(path, "bronze")
    if not tool.is_file():
        pytest.skip(f"{tool} is absent")
    import runpy

    weights = dict(zip(*(np.load(path)[key] for key in ("names", "weights")), strict=True))["alum-bronze"]
    # the light at 40 degrees, the viewer at 20 degrees, both over the plane of incidence: theta_h 30, theta_d 10
    expected = runpy.run_path(str(tool))["evaluate"](weights.astype(float), *np.radians([[30.0], [10.0], [0.0]]))
    np.testing.assert_allclose(model.evaluate(*np.radians([[40.0], [0], [20], [0]])), expected, rtol=1e-5)


def test_the_published_microfacet_fits_come_close_to_the_networks(data):
    nets = data / "merl" / "nbrdf_nets.npz"
    if not nets.is_file():
        pytest.skip(f"the published networks are absent from {nets.parent}")
    random = np.random.default_rng(1)
    at = directions(random, 300)
    for name in ("alum-bronze", "white-paint", "blue-acrylic"):
        values = [of.evaluate(*at) for of in (published.find(name).model, neural.published(nets, name))]
        first, second = np.cbrt(values)
        assert np.median(np.abs(first - second) / np.maximum(second, 1e-3)) < 0.15, name
