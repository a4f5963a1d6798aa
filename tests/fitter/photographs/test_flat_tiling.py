"""A tile of a flat sample, beside brute force and beside a sample cut out without care."""

import itertools

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

import fitter
from fitter.photographs.flat.tiling import cheapest_path, cut_tile
from support import flat_scene


@pytest.fixture(scope="module")
def paints(cornell):
    return tuple(fitter.fit(cornell(name), **fitter.PRESETS["Draft"]) for name in ("garnet_red_RGB", "krylon_blue_RGB"))


def sample(paints, share, slopes):
    """Maps of two paints: the share of the second, (h, w), and slopes (h, w, 2)."""
    normals = np.concatenate([slopes, np.ones((*share.shape, 1))], axis=2)
    return fitter.Maps(paints, np.stack([1 - share, share], axis=2),
                       normals / np.linalg.norm(normals, axis=2)[..., None], flat_scene.corners(),
                       np.zeros((*share.shape, 2)), np.full(share.shape, 8))


def blobs(shape, seed):
    """Noise of which neighbours are alike, 0 to 1."""
    made = gaussian_filter(np.random.default_rng(seed).standard_normal(shape), 3)
    return np.clip(0.5 + made / made.std() / 4, 0, 1)


def worst_steps(values):
    """The largest mean step from a row, and from a column, to the next, and from the last to the first, over the median
    one."""
    steps = [np.abs(values - np.roll(values, 1, axis=axis)).mean(axis=1 - axis) for axis in (0, 1)]
    return [float(each.max() / np.median(each)) for each in steps]


@pytest.mark.parametrize("is_closed", [False, True])
@pytest.mark.parametrize("seed", range(5))
def test_the_path_is_the_cheapest_of_all(is_closed, seed):
    cost = np.random.default_rng(seed).random((6, 4))
    steps = [each for each in itertools.product(range(4), repeat=6)
             if np.abs(np.diff(each)).max() <= 1 and (not is_closed or abs(each[0] - each[-1]) <= 1)]
    found = cheapest_path(cost, is_closed)
    assert tuple(found) in steps
    assert cost[range(6), found].sum() == pytest.approx(min(cost[range(6), each].sum() for each in steps))


def test_a_pattern_that_repeats_is_cut_at_its_period(paints):
    """Stripes of 13 texels across and of 11 upward, in the masks across and in the normals upward."""
    y, x = np.mgrid[:80, :96]
    slopes = np.stack([np.zeros(x.shape), 0.2 * np.sin(2 * np.pi * y / 11)], axis=2)
    made = cut_tile(sample(paints, 0.5 + 0.5 * np.sin(2 * np.pi * x / 13), slopes))
    height, width = made.used.shape
    assert (height % 11, width % 13) == (0, 0)
    assert (height >= 40, width >= 48) == (True, True)
    np.testing.assert_allclose(made.weights, np.roll(made.weights, 13, axis=1), atol=1e-9)
    np.testing.assert_allclose(made.normals, np.roll(made.normals, 11, axis=0), atol=1e-9)


@pytest.mark.parametrize("seed", range(3))
def test_a_tile_goes_on_beyond_its_edges_as_within(paints, seed):
    """In masks and normals. Reached: 2.6; what is cut out without care steps 4.5 to 12 times as far at its edges."""
    share, *slopes = (blobs((70, 90), 10 * number + seed) for number in range(3))
    whole = sample(paints, share, np.stack(slopes, axis=2) / 3)
    made = cut_tile(whole)
    height, width = made.used.shape
    careless = whole.weights[:height, :width, 1]
    print(made.used.shape, worst_steps(careless), worst_steps(made.weights[..., 1]), worst_steps(made.normals[..., 0]))
    assert min(worst_steps(careless)) > 4
    for values in (made.weights[..., 1], made.normals[..., 0]):
        assert max(worst_steps(values)) < 3
    np.testing.assert_allclose(np.linalg.norm(made.normals, axis=2), 1)
    np.testing.assert_allclose(made.weights.sum(axis=2), 1)


def test_a_tile_has_the_corners_of_the_place_where_it_was_cut(paints):
    """As far apart as its texels. There, but for its seams, at its left and its lower side, it is as the whole."""
    whole = sample(paints, blobs((70, 90), 3), np.zeros((70, 90, 2)))
    made = cut_tile(whole)
    height, width = made.used.shape
    texel = flat_scene.SIZE * np.array([1 / 90, 0.8 / 70])
    np.testing.assert_allclose(np.linalg.norm(np.diff(made.corners[:3], axis=0), axis=1) / (width, height), texel)
    column, row = ((made.corners[0] - whole.corners[0])[:2] / texel).round()
    there = whole.weights[int(row):int(row) + height, int(column):int(column) + width]
    np.testing.assert_allclose(made.weights[70 // 8:, 90 // 8:], there[70 // 8:, 90 // 8:])


def test_a_few_texels_are_no_tile(paints):
    with pytest.raises(ValueError, match="15 x 70 texels, a tile is cut from 16 or more"):
        cut_tile(sample(paints, blobs((70, 15), 3), np.zeros((70, 15, 2))))
