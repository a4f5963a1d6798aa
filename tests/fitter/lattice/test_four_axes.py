"""Symmetric lattices, and those of four axes, against loops over samples and control points."""

import itertools
import math

import numpy as np
import pytest

from fitter.lattice import dense, perfect_hash, sparse
from tests.fitter.lattice.test_dense import random_points


@pytest.mark.parametrize("signs", [(1, 1, -1, -1), (1, 1, -1), (-1, -1, 1)], ids=str)
def test_symmetric_control_points_make_a_symmetric_function(random, signs):
    """On either side of the plane between the stored half and the other, and smoothly across it."""
    axes, signs = len(signs), np.array(signs)
    plane = 0 if signs[0] < 0 else axes - 1
    same = dense.representative(3, axes)
    points = random.standard_normal(same.size)[same][..., None]
    x = random_points(random, 300, axes)
    x[:, plane] = 0.5
    mirrored = np.where(signs > 0, x, 1 - x)
    np.testing.assert_allclose(dense.evaluate(points, 3, x), dense.evaluate(points, 3, mirrored), atol=1e-12)
    step = 1e-4 * np.eye(axes)[plane]
    up, down = (dense.evaluate(points, 3, each + step) - dense.evaluate(points, 3, each) for each in (x, mirrored))
    np.testing.assert_allclose(up, -down, atol=1e-5)
    assert (np.abs(up).max() > 1e-4) == ((signs < 0).sum() > 1)         # by one axis alone, the slope is 0


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
