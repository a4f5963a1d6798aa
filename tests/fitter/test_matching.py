"""Matching a photograph: balls by random directions, under a window that the matching does not know."""

import numpy as np
import pytest

from fitter import DatasetError, published
from fitter.matching import nearest
from support.cases import quick
from tests.fitter.test_studio import by_random_directions

SIZE = 32
ROUND = {"left": (-0.8, 0.35, 0.5), "right": (0.8, 0.2, 0.55), "above": (0.1, 0.85, 0.5)}


def sky(window):
    """A round window, and walls that are lighter above."""
    toward = np.array(ROUND[window]) / np.linalg.norm(ROUND[window])
    return lambda direction: 6.0 * (direction @ toward > 0.88) + 0.25 + 0.1 * direction[..., 1]


def photograph(model, window, random, exposure=0.7, count=1500):
    """A picture of a ball that touches its edges."""
    y, x = (1 - (np.mgrid[:SIZE, :SIZE] + 0.5) * 2 / SIZE) * np.array([1, -1])[:, None, None]
    picture = np.full((SIZE, SIZE, 3), 0.1)
    for row, column in np.argwhere(x ** 2 + y ** 2 < 0.98):
        normal = np.array([x[row, column], y[row, column],
                           np.sqrt(1 - x[row, column] ** 2 - y[row, column] ** 2)])
        picture[row, column] = exposure * by_random_directions(model, normal, random, count, sky(window))
    return picture


class Tinted:
    """A material of which all is multiplied."""

    isotropic = True

    def __init__(self, model, tint):
        self.model, self.tint = model, np.array(tint)

    def evaluate(self, *angles):
        return self.model.evaluate(*angles) * self.tint


@pytest.mark.parametrize(("name", "window"), quick([
    ("copper-satin", "left"), ("specular-blue-phenolic", "right"), ("green-latex", "above"), ("gold-paint", "left"),
    ("yellow-paint", "right")], ("copper-satin", "left")))
def test_a_material_of_the_library_is_among_the_five_nearest_and_its_window_is_found(name, window, random):
    found, matches = nearest(photograph(published.find(name).model, window, random))
    assert found == window
    assert name in [each.material.name for each in matches]
    assert matches[0].error < 0.3                # the sky is another one
    assert [each.error for each in matches] == sorted(each.error for each in matches)
    assert all(each.adjusted <= each.error + 1e-9 for each in matches)


def test_what_is_not_in_the_library_is_brought_nearer_by_its_factors(random):
    tint = 0.5, 1.0, 0.4
    _, matches = nearest(photograph(Tinted(published.find("white-paint").model, tint), "left", random), "left", 200)
    white = next(each for each in matches if each.material.name == "white-paint")
    assert white.adjusted < white.error / 2
    factors = np.array(white.diffuse)
    assert factors / factors[1] == pytest.approx(tint, rel=0.1)


@pytest.mark.parametrize(("picture", "told"), [
    (np.ones((8, 8, 3)), "at least 32 x 32"), (np.ones((64, 64)), "three channels"),
    (np.zeros((64, 64, 3)), "dark"), (np.ones((64, 64, 3)), "too bright")])
def test_a_picture_that_shows_no_ball_is_refused(picture, told):
    with pytest.raises(DatasetError, match=told):
        nearest(picture)


def test_an_unknown_window_is_refused():
    with pytest.raises(DatasetError, match="left, right, above, front"):
        nearest(np.full((64, 64, 3), 0.5), "below")
