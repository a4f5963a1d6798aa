"""Lattices of four axes, against SciPy's tensor-product splines and loops over samples and control points."""

import itertools
import math

import numpy as np
import pytest
from scipy.interpolate import NdBSpline

from fitter.coordinates.anisotropic_nusselt import AnisotropicNusselt
from fitter.lattice import dense, mba, perfect_hash, sparse
from fitter.lattice.normal_equations import NormalEquations, gains


def pairs(random, count):
    return (np.arccos(random.random(count)), 2 * np.pi * random.random(count), np.arccos(random.random(count)),
            2 * np.pi * random.random(count))


def random_points(random, count):
    return AnisotropicNusselt().encode(*pairs(random, count))


@pytest.mark.parametrize("level", range(4))
def test_evaluate_is_the_tensor_product_spline_of_scipy(random, level):
    points = random.standard_normal((*dense.shape(level, 4), 2))
    x, m = random_points(random, 200), dense.cells(level)
    knots = tuple((first - 2 + np.arange(count + 4)) / m
                  for first, count in zip(dense.origin(level, 4), dense.shape(level, 4), strict=True))
    np.testing.assert_allclose(dense.evaluate(points, level, x), NdBSpline(knots, points, k=3)(x), atol=1e-12)


@pytest.mark.parametrize("level", range(4))
def test_refinement_changes_nothing_but_the_lattice(random, level):
    points = random.standard_normal((*dense.shape(level, 4), 1))
    x, fine = random_points(random, 200), dense.refine(points, level)
    assert fine.shape[:4] == dense.shape(level + 1, 4)
    np.testing.assert_allclose(dense.evaluate(fine, level + 1, x), dense.evaluate(points, level, x), atol=1e-13)


@pytest.mark.parametrize("level", range(5))
def test_every_control_point_that_directions_read_is_reachable_and_few_others(random, level):
    x = random_points(random, 400_000 if level == 3 else 50_000)
    first, _ = dense.locate(x, level)
    assert first.min() >= 0
    read = np.zeros(dense.shape(level, 4), dtype=bool)
    for offset in np.ndindex(4, 4, 4, 4):
        read[tuple((first + offset).T)] = True
    reachable = dense.reachable(level, 4)
    assert not (read & ~reachable).any()
    if level <= 3:                      # enough points to touch nearly every cell
        assert reachable.sum() <= 1.15 * read.sum()


def test_symmetric_control_points_make_a_symmetric_function(random):
    """On either side of the plane between the stored half and the other, and smoothly across it."""
    same = dense.representative(3, 4)
    points = random.standard_normal(same.size)[same][..., None]
    x = random_points(random, 300)
    x[:, 3] = 0.5
    mirrored = np.where([True, True, False, False], x, 1 - x)
    np.testing.assert_allclose(dense.evaluate(points, 3, x), dense.evaluate(points, 3, mirrored), atol=1e-12)
    step = 1e-4
    up, down = (dense.evaluate(points, 3, each + [0, 0, 0, step]) - dense.evaluate(points, 3, each)
                for each in (x, mirrored))
    np.testing.assert_allclose(up, -down, atol=1000 * step ** 2)
    assert np.abs(up).max() > 1e-4


def brute_force_ba(x, z, level):
    """Lee, Wolberg and Shin 1997, equations 3 and 5, one sample and one control point at a time, on the full lattice,
    of the samples and the exchanged ones."""
    m = dense.cells(level)
    delta, omega = np.zeros((2, *[m + 3] * 4))
    for point, value in zip(np.concatenate([x, np.where([1, 1, 0, 0], x, 1 - x)]), np.tile(z, 2), strict=True):
        cell = [min(max(math.floor(c * m), 0), m - 1) for c in point]
        basis = []
        for c, i in zip(point, cell, strict=True):
            s = c * m - i
            basis.append([(1 - s) ** 3 / 6, (3 * s**3 - 6 * s**2 + 4) / 6, (-3 * s**3 + 3 * s**2 + 3 * s + 1) / 6,
                          s**3 / 6])
        w = np.einsum("a,b,c,d->abcd", *basis)
        for k in np.ndindex(4, 4, 4, 4):
            at = tuple(i + j for i, j in zip(cell, k, strict=True))
            delta[at] += w[k] ** 2 * (w[k] * value / (w**2).sum())
            omega[at] += w[k] ** 2
    full = np.divide(delta, omega, out=np.zeros_like(delta), where=omega > 0)
    return full[tuple(slice(first + 1, None) for first in dense.origin(level, 4))]


@pytest.mark.parametrize("level", range(4))
def test_basis_approximation_agrees_with_the_loop_over_samples(random, level):
    x, z = random_points(random, 25), random.standard_normal(25)
    np.testing.assert_allclose(mba.basis_approximation(x, z[:, None], level)[..., 0], brute_force_ba(x, z, level),
                               atol=1e-12)


def test_a_lattice_too_large_for_memory_is_evaluated_by_its_keys(random):
    level, keys = 6, random.choice(math.prod(dense.shape(6, 4)), 4000, replace=False)
    index = perfect_hash.build(keys)
    lattice = sparse.SparseLattice(level, index, random.standard_normal((4000, 2)).astype(np.float32), 4)
    # near the stored control points, or nothing would be read
    at = np.stack(np.unravel_index(keys[:200], dense.shape(level, 4)), axis=1) + np.array(dense.origin(level, 4))
    x = np.clip((at + random.uniform(-1, 1, at.shape)) / dense.cells(level), [0, 0, 0, 0.5], 1)
    stored = dict(zip(index.keys.tolist(), lattice.coefficients.astype(float), strict=True))
    first, along = dense.locate(x, level)
    expected = np.zeros((len(x), 2))
    for row, corner in enumerate(first):
        for k in itertools.product(range(4), repeat=4):
            key = int(np.ravel_multi_index(tuple(corner + k), dense.shape(level, 4)))
            if key in stored:
                expected[row] += stored[key] * math.prod(w[row, each] for w, each in zip(along, k, strict=True))
    assert np.abs(expected).max() > 0.05
    np.testing.assert_allclose(lattice.evaluate(x), expected, atol=1e-12)


def test_the_step_is_that_of_least_squares(random):
    x = random_points(random, 3000)
    z, weights = random.standard_normal((len(x), 2)), random.uniform(0.1, 3, len(x))
    size = math.prod(dense.shape(1, 4))
    same = dense.representative(1, 4).ravel()
    root = random.standard_normal((size, size))
    control_points, = NormalEquations(x, [(1, None)]).solve(weights, z, [root.T @ root])

    unknowns = np.unique(same)
    design = np.stack([dense.evaluate((same == one).astype(float).reshape(*dense.shape(1, 4), 1), 1, x)[:, 0]
                       for one in unknowns], axis=1)
    spread = np.array([[float(one == same[k]) for one in unknowns] for k in range(size)])
    rows, wanted = [weights[:, None] * design, root @ spread], [weights[:, None] * z, np.zeros((size, 2))]
    best = np.linalg.lstsq(np.concatenate(rows), np.concatenate(wanted), rcond=None)[0]
    np.testing.assert_allclose(control_points, spread @ best, atol=1e-3 * np.abs(best).max())


def test_gains_are_those_of_one_control_point_alone(random):
    x, z = random_points(random, 500), random.standard_normal((500, 2))
    weights = random.uniform(0.1, 3, len(x))
    same = dense.representative(1, 4).ravel()
    gain = gains(x, 1, weights, z)
    single, counts = np.unique(same, return_counts=True)
    for one in random.choice(single[counts == 1], 20, replace=False):
        column = weights * dense.evaluate((same == one).astype(float).reshape(*dense.shape(1, 4), 1), 1, x)[:, 0]
        expected = ((column @ (weights[:, None] * z)) ** 2).sum() / (column @ column)
        assert gain[one] <= expected * (1 + 1e-9)
        if column @ column > 1:                 # at the rim it is held back
            assert gain[one] == pytest.approx(expected, rel=0.05)
