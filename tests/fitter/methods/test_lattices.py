"""Lattices of a Gaussian process, against SciPy's densities and brute-force least squares over all control points."""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from fitter import Samples
from fitter.arrays import concatenate_directions
from fitter.coordinates.half_difference import HalfDifference
from fitter.lattice import dense
from fitter.methods import lattices, prior
from fitter.methods.gaussian_process import Kernel, krige
from fitter.methods.levels import Levels
from fitter.model.transform import LogRelative

KERNEL = Kernel(0.8, 1e-2)


@pytest.fixture
def samples(random):
    theta_i, theta_o = np.arcsin(np.sqrt(random.random((2, 90)) * 0.98))
    theta_i[0] = theta_o[1] = np.radians(89.6)       # nothing is beyond them
    values = 0.2 + 0.3 * random.random((90, 2)) * np.cos(theta_i)[:, None]
    return Samples(theta_i, np.zeros(90), theta_o, random.random(90) * np.pi, values, ("a", "b"))


@pytest.fixture
def transform(samples):
    return LogRelative(prior.lambertian(samples.values), 0.2, np.ones(2))


def basis(x, level):
    """The sum of basis functions of each control point and its mirror images, at x: (n, unknowns)."""
    same = dense.representative(level).ravel()
    first = np.unique(same)
    return np.stack([dense.evaluate((same == each).astype(float).reshape(*dense.shape(level), 1), level, x)[:, 0]
                     for each in first], axis=1), first


def places(level):
    at = np.stack(np.unravel_index(basis(np.full((1, 3), 0.75), level)[1], dense.shape(level)), axis=1)
    return 2 * (at + np.array(dense.origin(level))) / dense.cells(level) - 1


def weights(samples, transform):
    found = ((samples.values.mean(axis=1) / transform.offset + 1) * np.cos(samples.theta_o)) ** (1 / 3)
    return found / np.sqrt(np.mean(found ** 2))


def norm_root(mu):
    """The root of the norm of control points at places: by the inverse of their covariance."""
    covariance = KERNEL.covariance(mu, mu) + 1e-4 * np.eye(len(mu))
    return np.linalg.cholesky(np.linalg.inv(covariance)).T * np.sqrt(KERNEL.noise)


def regularised(design, weight, root, z):
    """NumPy's least squares of the weighted errors and a norm."""
    return np.linalg.lstsq(np.concatenate([design * weight, root]),
                           np.concatenate([z * weight, np.zeros((len(root), 2))]), rcond=None)[0]


def test_the_norm_is_the_inverse_of_the_covariance_of_the_control_points_places():
    mu = places(2)
    matrix = lattices.precision(2, 3, KERNEL)
    first = np.unique(dense.representative(2))
    covariance = KERNEL.covariance(mu, mu) + 1e-4 * np.eye(len(mu))
    np.testing.assert_allclose(matrix[np.ix_(first, first)] @ covariance, np.eye(len(mu)), atol=1e-4)
    others = np.setdiff1d(np.arange(len(matrix)), first)
    assert not matrix[others].any()


def test_the_likelihood_of_many_samples_is_scipys(monkeypatch, samples, transform):
    """Differences between kernels, and those between coordinates, are those of the samples' joint densities."""
    monkeypatch.setitem(lattices._TRIED, 3, 1)

    def scipys(coordinates, kernel):
        design, _ = basis(coordinates.encode(*samples.directions), 1)
        mu = places(1)
        prior_covariance = kernel.covariance(mu, mu) + 1e-4 * np.eye(len(mu))
        matrix = design @ prior_covariance @ design.T + kernel.noise * np.diag(weights(samples, transform) ** -2.0)
        z = transform.field(samples.values, *samples.directions)
        variances = [values @ np.linalg.solve(matrix, values) / len(z) for values in z.T]
        return np.mean([stats.multivariate_normal(cov=matrix * variance).logpdf(values)
                        for variance, values in zip(variances, z.T, strict=True)]) / len(z)

    tried = [(HalfDifference(stretch=stretch), Kernel(0.5, noise)) for stretch in (0.0, 5.0) for noise in (1e-3, 1e-1)]
    found = [lattices.likelihoods(samples, [coordinates], [transform], kernel)[0, 0] for coordinates, kernel in tried]
    expected = [scipys(*each) for each in tried]
    np.testing.assert_allclose(np.subtract(found, found[0]), np.subtract(expected, expected[0]), atol=1e-5)


def independent(level, keys):
    """The roots of the squared size of independent control points: of each unknown among keys, over all its images."""
    same = dense.representative(level).ravel()[keys]
    return np.diag(np.sqrt(KERNEL.noise / lattices._VARIANCE * np.unique(same, return_counts=True)[1]))


def test_a_finer_dense_lattice_adds_what_lowers_the_errors(monkeypatch, samples, transform):
    """Its control points beside the coarser spline are independent: by NumPy's least squares over all of them."""
    monkeypatch.setitem(lattices._FINEST, 3, 1)
    coordinates = HalfDifference(stretch=5.0)
    coarse, fine = (lattices.fit_to_samples(samples, coordinates, transform, KERNEL, Levels(level, None, 0.0))[0]
                    for level in (1, 2))
    x, z = coordinates.encode(*samples.directions), transform.field(samples.values, *samples.directions)
    design, weight = basis(x, 2)[0], weights(samples, transform)[:, None]
    root = independent(2, np.arange(np.prod(dense.shape(2))))
    added = regularised(design, weight, root, z - coarse.evaluate(x))
    np.testing.assert_allclose(fine.evaluate(x), coarse.evaluate(x) + design @ added, atol=2e-4)


def test_the_dense_lattice_of_a_field_moves_to_what_its_nodes_do_not_say(samples, transform):
    """From the spline that interpolates at the nodes, by NumPy's least squares over all control points."""
    coordinates = HalfDifference(stretch=5.0)
    x, z = coordinates.encode(*samples.directions), transform.field(samples.values, *samples.directions)
    field, _ = krige(2 * x - 1, z, KERNEL, np.zeros(len(x)))
    fitted, _ = lattices.fit_to_field(samples, coordinates, transform, field, Levels(2, None, 0.0))

    nodes = dense.nodes(2)
    values = field.predict(2 * nodes.reshape(-1, 3) - 1).reshape(*nodes.shape[:-1], 2)
    values[0] = lattices._mean_over_azimuths(field, 2 * nodes[0] - 1)
    box = dense.interpolate(values, 2)
    directions = concatenate_directions([samples.directions, lattices._random_directions(samples)])
    x = coordinates.encode(*directions)
    wanted = field.predict(2 * x - 1)
    wanted[:len(samples)] = field.at_samples
    bright = transform.reflectance(wanted, *directions).mean(axis=1) + transform.offset
    share = np.where(np.arange(len(x)) < len(samples), 1, np.sqrt(len(samples) / (len(x) - len(samples))))
    weight = share * bright ** (1 / 3)
    weight = (weight / np.sqrt(np.mean(weight ** 2)))[:, None]
    design, same = basis(x, 2)[0], dense.representative(2).ravel()
    root = np.diag(np.sqrt(lattices._PRIOR_PRECISION * np.unique(same, return_counts=True)[1]))
    before = dense.evaluate(box, 2, x)
    moved = regularised(design, weight, root, wanted - before)
    np.testing.assert_allclose(fitted.evaluate(x), before + design @ moved, atol=2e-4)
    assert np.sqrt(np.mean((design @ moved) ** 2)) > 0.01


def test_both_lattices_of_many_samples_have_the_least_errors_and_norm_together(samples, transform):
    """By NumPy's least squares over every unknown of the dense lattice and those of the sparse one that were kept."""
    coordinates = HalfDifference(stretch=5.0)
    fitted, sparse = lattices.fit_to_samples(samples, coordinates, transform, KERNEL, Levels(1, 3, 80.0))
    keys = np.sort(sparse.index.keys)
    assert 200 < len(keys) <= Levels(1, 3, 80.0).kept_count(3)
    x, z = coordinates.encode(*samples.directions), transform.field(samples.values, *samples.directions)
    every, first = basis(x, 3)
    kept = every[:, np.isin(first, dense.representative(3).ravel()[keys])]
    norm, weight, more = norm_root(places(1)), weights(samples, transform)[:, None], independent(3, keys)
    design = np.concatenate([basis(x, 1)[0], kept], axis=1)
    root = np.block([[norm, np.zeros((len(norm), len(more)))], [np.zeros((len(more), len(norm))), more]])
    expected = regularised(design, weight, root, z)
    np.testing.assert_allclose(fitted.evaluate(x) + sparse.evaluate(x), design @ expected, atol=2e-4)


def test_directions_between_samples_reach_as_far_as_these(samples):
    theta_i, _, theta_o, turn = lattices._random_directions(samples)
    farthest = max(samples.theta_i.max(), samples.theta_o.max())
    assert max(theta_i.max(), theta_o.max()) <= farthest
    assert (np.hypot(theta_o - theta_i, np.pi - turn) < 0.05).mean() > 0.2       # and crowd the mirror direction


def test_whole_incidences_are_left_out_between_the_flattest_and_the_steepest(samples):
    """Of five incidences the three between, each by itself; of a single one, single samples."""
    theta = np.radians(np.arange(len(samples)) % 5 * 15.0)
    lots = lattices._folds(replace(samples, theta_i=theta))
    assert set(lots[np.isin(np.arange(len(samples)) % 5, (0, 4))]) == {-1}
    assert len({*lots}) == 4
    for number in (1, 2, 3):
        assert len({*lots[np.arange(len(samples)) % 5 == number]}) == 1
    assert {*lattices._folds(replace(samples, theta_i=0 * theta))} == {0, 1, 2, 3, 4}


def test_incidences_just_below_a_whole_turn_are_left_out_with_those_at_0(samples):
    """They were taken for those of the next polar angle."""
    number = np.arange(len(samples))
    turned = replace(samples, theta_i=np.radians(number % 4 * 0.5), phi_i=np.where(number % 3, 0.0, 2 * np.pi - 1e-6),
                     isotropic=False)
    folds = lattices._folds(turned)
    for step in (1, 2):
        assert len({*folds[number % 4 == step]}) == 1
    assert len({*folds}) == 3


def test_the_error_at_what_is_left_out_is_that_of_fits_to_the_rest(samples, transform):
    """Each lot by itself, by the basis functions of all control points."""
    system, kernel = HalfDifference(), Kernel(1.0, 1e-3)
    samples = replace(samples, theta_i=np.radians(np.arange(len(samples)) % 5 * 15.0))
    x, z = system.encode(*samples.directions), transform.field(samples.values, *samples.directions)
    found, lots, errors = weights(samples, transform), lattices._folds(samples), []
    level = lattices._TRIED[3]
    matrix, first = basis(x, level)
    norm = kernel.noise * lattices.precision(level, 3, kernel)[first[:, None], first]
    for out in (lots == number for number in {*lots} - {-1}):
        weighted = matrix[~out] * found[~out, None]
        points = np.linalg.solve(weighted.T @ weighted + norm, weighted.T @ (z[~out] * found[~out, None]))
        errors.append(found[out, None] * (matrix[out] @ points - z[out]))
    expected = np.sqrt(np.mean(np.concatenate(errors) ** 2))
    error = lattices.incidence_error(samples, system, transform)
    assert error(kernel) == pytest.approx(expected, rel=1e-5)
    assert lattices.select_kernel([kernel, kernel], error) is kernel


@pytest.mark.parametrize("axes", [3, 4])
def test_of_many_samples_each_cell_keeps_some_which_stand_for_all_of_it(axes, random):
    x = np.concatenate([random.random((80_000, axes)) ** 3, [[0.999] * axes]])     # a crowd, and one by itself
    chosen, stood_for = lattices.stratified_sample(x)
    assert len(np.unique(chosen)) == len(chosen) == lattices.MAX_STRATIFIED
    assert chosen[-1] == len(x) - 1
    side = {3: 16, 4: 8}[axes]
    cells = [tuple(each) for each in (x * side).astype(int)]
    everything, represented = Counter(cells), Counter()
    for which, number in zip(chosen, stood_for, strict=True):
        represented[cells[which]] += number
    assert represented.keys() == everything.keys()
    np.testing.assert_allclose([represented[cell] for cell in everything], list(everything.values()), rtol=1e-9)
    kept = Counter(cells[which] for which in chosen)
    assert all(kept[cell] == count for cell, count in everything.items() if count <= 3)


def test_few_of_many_samples_are_all_kept(random):
    chosen, stood_for = lattices.stratified_sample(random.random((300, 3)))
    assert chosen.tolist() == list(range(300))
    assert (stood_for == 1).all()
