"""Normal equations, compared with a design matrix that is written out, and solved by NumPy's least squares."""

import math

import numpy as np
import pytest

from fitter.lattice import dense
from fitter.lattice.normal_equations import NormalEquations, gains
from tests.fitter.lattice.test_dense import random_points


@pytest.fixture
def x(random):
    """Some in clusters, some on the faces of cells and in the planes of symmetry, some in the corners."""
    scattered = random.uniform([0.5, 0, 0.5], 1, (400, 3))
    clustered = np.clip([0.7, 0.3, 0.6] + 0.02 * random.standard_normal((300, 3)), [0.5, 0, 0.5], 1)
    on_faces = np.round(random.uniform([0.5, 0, 0.5], 1, (100, 3)) * 8) / 8
    return np.concatenate([scattered, clustered, on_faces])


def images(level, axes=3):
    """The control points of the box that are images of each other: a list of arrays."""
    representative = dense.representative(level, axes).ravel()
    return [np.flatnonzero(representative == one) for one in np.unique(representative)]


def column(x, level, points):
    """The spline at x whose control points are 1 at some, and otherwise 0."""
    shape = dense.shape(level, x.shape[1])
    box = np.zeros((math.prod(shape), 1))
    box[points] = 1
    return dense.evaluate(box.reshape(*shape, 1), level, x)[:, 0]


@pytest.fixture
def keys(random):
    """Some control points of level 3."""
    return some_keys(random, 3)


def some_keys(random, level, axes=3):
    """Some control points of a level with all of their images."""
    groups = images(level, axes)
    return np.sort(np.concatenate([groups[k] for k in random.choice(len(groups), 60, replace=False)]))


@pytest.mark.parametrize(("axes", "low", "high", "within"), [(3, 2, 3, 1e-6), (4, 1, 2, 1e-5)])
def test_the_control_points_are_those_of_least_squares(x, random, axes, low, high, within):
    x, keys = x if axes == 3 else random_points(random, 3000, 4), some_keys(random, high, axes)
    z, weights = random.standard_normal((len(x), 2)), random.uniform(0.1, 3, len(x))
    size = math.prod(dense.shape(low, axes))
    roots = random.standard_normal((size, size)), 0.5 * random.standard_normal((len(keys), len(keys)))
    norms = [root.T @ root for root in roots]
    control_points = NormalEquations(x, [(low, None), (high, keys)]).solve(weights, z, norms)

    # one row for a sample and for each of a norm, one column for each unknown
    groups = [*((low, group) for group in images(low, axes)),
              *((high, group) for group in images(high, axes) if np.isin(group, keys).any())]
    rows = [np.stack([weights * column(x, level, group) for level, group in groups], axis=1)]
    for root, of in zip(roots, (low, high), strict=True):
        rows.append(np.stack([root[:, group if of == low else np.isin(keys, group)].sum(axis=1) if level == of
                              else np.zeros(len(root)) for level, group in groups], axis=1))
    wanted = np.concatenate([weights[:, None] * z, np.zeros((len(roots[0]) + len(roots[1]), 2))])
    expected = np.linalg.lstsq(np.concatenate(rows), wanted, rcond=None)[0]
    for (level, group), value in zip(groups, expected, strict=True):
        mine = control_points[0][group] if level == low else control_points[1][np.isin(keys, group)]
        assert mine == pytest.approx(np.broadcast_to(value, mine.shape), abs=within)


def test_the_order_of_the_lattices_does_not_matter(x, keys, random):
    """A lattice that is coarser than the one before it: samples in one of its cells lie in several of the other's."""
    z, weights = random.standard_normal((len(x), 1)), np.ones(len(x))
    every = np.arange(math.prod(dense.shape(2)))
    norms = [0.1 * np.eye(len(each)) for each in (every, keys)]
    one = NormalEquations(x, [(2, every), (3, keys)]).solve(weights, z, norms)
    other = NormalEquations(x, [(3, keys), (2, every)]).solve(weights, z, norms[::-1])
    for mine, theirs in zip(one, other[::-1], strict=True):
        np.testing.assert_allclose(mine, theirs, atol=1e-9)


@pytest.mark.parametrize(("axes", "level", "within"), [(3, 3, 0.02), (4, 2, 0.05)])
def test_a_gain_is_what_one_control_point_can_do(x, random, axes, level, within):
    x = x if axes == 3 else random_points(random, 3000, 4)
    z, weights = random.standard_normal((len(x), 2)), random.uniform(0.1, 3, len(x))
    gain = gains(x, level, weights, z)
    whole = ((weights[:, None] * z) ** 2).sum()
    compared = 0
    for group in images(level, axes):
        design = weights * column(x, level, group)
        # of a control point in a plane of symmetry, whose images share samples, and of one that few samples reach, the
        # gain is less than it could be
        alone = sum((weights * column(x, level, one)) ** 2 for one in group).sum()
        if (design ** 2).sum() < 1 or not math.isclose(alone, (design ** 2).sum(), rel_tol=1e-9):
            continue
        best = np.linalg.lstsq(design[:, None], weights[:, None] * z, rcond=None)[0]
        left = ((weights[:, None] * z - design[:, None] * best) ** 2).sum()
        assert gain[group] == pytest.approx(whole - left, rel=within)
        compared += 1
    assert compared > 20
