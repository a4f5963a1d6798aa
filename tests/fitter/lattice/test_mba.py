from functools import reduce
from itertools import pairwise

import numpy as np
import pytest

import fitter
from fitter.coordinates.nusselt import Nusselt
from fitter.lattice import dense, mba
from tests.fitter.lattice.test_dense import random_points


def brute_force_ba(images, z, level):
    """The basis approximation as Lee, Wolberg and Shin write it, equations 3 and 5, one sample and one control point at
    a time, on the full lattice, of the samples and their mirror images."""
    m, axes = dense.cells(level), images.shape[1]
    delta, omega = np.zeros((2, *[m + 3] * axes))
    for point, value in zip(images, z, strict=True):
        cell = [min(max(int(np.floor(c * m)), 0), m - 1) for c in point]
        basis = []
        for c, i in zip(point, cell, strict=True):
            s = c * m - i
            basis.append([(1 - s) ** 3 / 6, (3 * s**3 - 6 * s**2 + 4) / 6, (-3 * s**3 + 3 * s**2 + 3 * s + 1) / 6,
                          s**3 / 6])
        w = reduce(np.multiply.outer, basis)
        for k in np.ndindex(w.shape):
            at = tuple(i + j for i, j in zip(cell, k, strict=True))
            delta[at] += w[k] ** 2 * (w[k] * value / (w**2).sum())
            omega[at] += w[k] ** 2
    full = np.divide(delta, omega, out=np.zeros_like(delta), where=omega > 0)
    return full[tuple(slice(first + 1, None) for first in dense.origin(level, axes))], full


@pytest.fixture
def scattered(random):
    theta_i, theta_o, delta_phi = random.random((3, 60)) * np.array([[1.5], [1.5], [3.1]])
    return Nusselt().encode(theta_i, 0, theta_o, delta_phi), random.standard_normal(60)


@pytest.mark.parametrize("level", [0, 1, 2, 3])
def test_basis_approximation_agrees_with_the_loop_over_samples(scattered, level):
    x, z = scattered
    images = np.concatenate([x, x * [1, 1, -1] + [0, 0, 1], x * [-1, -1, 1] + [1, 1, 0], 1 - x])
    expected, full = brute_force_ba(images, np.tile(z, 4), level)
    np.testing.assert_allclose(mba.basis_approximation(x, z[:, None], level)[..., 0], expected, atol=1e-12)
    # and the full lattice has the symmetries that let a quarter stand for it
    np.testing.assert_allclose(full, full[:, :, ::-1], atol=1e-12)
    np.testing.assert_allclose(full, full[::-1, ::-1, :], atol=1e-12)


@pytest.mark.parametrize("level", [0, 1, 2, 3])
def test_of_four_axes_it_is_that_of_the_samples_and_the_exchanged_ones(random, level):
    x, z = random_points(random, 25, 4), random.standard_normal(25)
    images = np.concatenate([x, x * [1, 1, -1, -1] + [0, 0, 1, 1]])
    np.testing.assert_allclose(mba.basis_approximation(x, z[:, None], level)[..., 0],
                               brute_force_ba(images, np.tile(z, 2), level)[0], atol=1e-12)


def test_channels_are_fitted_independently(scattered):
    x, z = scattered
    together, _ = mba.approximate(x, np.stack([z, -3 * z, z**2], axis=1), 4)
    for channel, values in enumerate((z, -3 * z, z**2)):
        alone, _ = mba.approximate(x, values[:, None], 4)
        np.testing.assert_allclose(together[..., channel], alone[..., 0], atol=1e-12)


@pytest.mark.parametrize("level", [0, 2, 5])
def test_the_refined_hierarchy_and_the_residual_add_up_to_the_data(scattered, level):
    x, z = scattered
    points, residual = mba.approximate(x, z[:, None], level)
    np.testing.assert_allclose(dense.evaluate(points, level, x) + residual, z[:, None], atol=1e-13)


def test_a_direction_may_pass_through_the_normal_without_a_crease(scattered):
    x, z = scattered
    points, _ = mba.approximate(x, z[:, None], 4)
    h = 1e-4
    outgoing = np.array([[0.5, 0.2, 0.7], [0.5, 0.4, 0.6]])
    # an incident direction beyond the normal is one before it, with everything turned by half a turn
    turned = outgoing * [1, -1, 1] + [0, 1, 0]
    before = dense.evaluate(points, 4, outgoing + [h, 0, 0]) - dense.evaluate(points, 4, outgoing)
    after = dense.evaluate(points, 4, outgoing) - dense.evaluate(points, 4, turned + [h, 0, 0])
    np.testing.assert_allclose(dense.evaluate(points, 4, outgoing), dense.evaluate(points, 4, turned), atol=1e-12)
    np.testing.assert_allclose(before, after, atol=20 * h * h * np.abs(points).max() * 16**2)
    assert np.abs(before).max() > 100 * np.abs(before - after).max() / 3


# design.md, section 5: an independent implementation on the whole domain, without folding
@pytest.mark.parametrize(("sample", "channel", "level_4", "level_6"), [
    (1, 0, 0.0189, 0.00059), (5, 0, 0.0410, 0.00084), (15, 0, 0.0253, 0.00123), ("krylon_blue_RGB", 2, 0.468, 0.0740),
    ("garnet_red_RGB", 0, 0.202, 0.0275), ("cayman", None, 13.0, 2.14)])
def test_errors_are_those_of_the_reference(curet, cornell, data, sample, channel, level_4, level_6):
    samples = curet(sample) if isinstance(sample, int) else cornell(sample)
    if channel is None:         # the mean of the file's bands
        path = data / "cornell" / f"{sample}.astm"
        bands = np.loadtxt(path.read_text("latin-1").split("\nVARS")[1].splitlines()[1:], delimiter=",")[:, 4:]
        assert bands.shape[1] == 31
        values = bands.mean(axis=1, keepdims=True)
    else:
        values = samples.values[:, [channel]]
    for level, expected in ((4, level_4), (6, level_6)):
        _, residual = mba.approximate(Nusselt().encode(*samples.directions), values, level)
        assert np.sqrt(np.mean(residual ** 2)) == pytest.approx(expected, rel=0.2)


def test_error_falls_with_every_level_on_all_samples_of_curet_and_files_of_cornell(curet, data):
    """RMSE at levels 0 to 7, all channels."""
    for samples in (*map(curet, range(1, 62)), *map(fitter.load, sorted((data / "cornell").iterdir()))):
        x, residual, errors = Nusselt().encode(*samples.directions), samples.values, []
        for level in range(8):
            residual = residual - dense.evaluate(mba.basis_approximation(x, residual, level), level, x)
            errors.append(float(np.sqrt(np.mean(residual ** 2))))
        assert all(fine < coarse for coarse, fine in pairwise(errors)), (samples.name, errors)
