"""Matching a photograph: balls by random directions, under a window that the matching does not know."""

import numpy as np
import pytest

from fitter import DatasetError
from fitter.imaging import studio
from fitter.imaging.pictures import sphere
from fitter.library.matching import find_nearest
from fitter.model import is_isotropic, published
from support.cases import quick, release
from support.checkout import measurements
from tests.fitter.imaging.test_studio import by_random_directions

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
    found, matches = find_nearest(photograph(published.find(name).model, window, random))
    assert found == window
    assert matches[0].material.name == name
    assert matches[0].error < 0.3                # the sky is another one
    ranks = [each.adjusted + each.error / 2 for each in matches]
    assert ranks == sorted(ranks)
    assert all(each.adjusted <= each.error + 1e-9 for each in matches)


@release
def test_what_is_not_in_the_library_is_brought_nearer_by_its_factors(random):
    tint = 0.5, 1.0, 0.4
    picture = photograph(Tinted(published.find("white-paint").model, tint), "left", random)
    _, matches = find_nearest(picture, "left", 200)
    white = next(each for each in matches if each.material.name == "white-paint")
    assert white.adjusted < white.error / 2
    factors = np.array(white.diffuse)
    assert factors / factors[1] == pytest.approx(tint, rel=0.1)


def test_a_ball_of_another_colour_is_answered_by_what_is_like_it_once_it_is_adjusted(random):
    """A blue ball had green plastic for an answer."""
    red, tint = published.find("red-specular-plastic").model, np.array((0.1, 0.5, 8.0))
    _, matches = find_nearest(photograph(Tinted(red, tint), "left", random), "left")
    best = matches[0]
    assert best.adjusted < 0.25
    at = 0.3, 0.0, 1.0, 1.5                     # off the highlight: what is diffuse
    seen, wanted = best.material.model.evaluate(*at) * np.array(best.diffuse), red.evaluate(*at) * tint
    assert seen / seen.sum() == pytest.approx(wanted / wanted.sum(), abs=0.05)


@pytest.mark.parametrize(("picture", "told"), [
    (np.ones((8, 8, 3)), "at least 32 x 32"), (np.ones((64, 64)), "three channels"),
    (np.zeros((64, 64, 3)), "dark"), (np.ones((64, 64, 3)), "too bright")])
def test_a_picture_that_shows_no_ball_is_refused(picture, told):
    with pytest.raises(DatasetError, match=told):
        find_nearest(picture)


X, Y = np.meshgrid(*[(np.arange(96) + 0.5) * 2 / 96 - 1] * 2)
NO_BALLS = {
    "noise of 64": lambda random: 0.9 * random.random((64, 64, 3)),
    "noise of 400": lambda random: 0.9 * random.random((400, 300, 3)),
    "grey noise": lambda random: 0.9 * np.repeat(random.random((96, 96, 1)), 3, axis=2),
    "bright grains": lambda random: random.exponential(size=(96, 96, 3)),
    "clouds": lambda random: np.kron(random.uniform(0.2, 0.9, (6, 6, 3)), np.ones((16, 16, 1))),
    "a colour": lambda _: np.full((64, 64, 3), (0.6, 0.2, 0.1)),
    "a gradient": lambda _: np.repeat(((X + 1.2) / 2.4)[..., None], 3, axis=2),
    "a gradient upward": lambda _: np.repeat(((1.1 - Y) / 2.2)[..., None], 3, axis=2),
    "a vignette": lambda _: np.repeat(np.maximum(0.9 - 0.6 * np.hypot(X, Y), 0)[..., None], 3, axis=2)}


@pytest.mark.parametrize("name", NO_BALLS)
def test_none_is_near_to_what_shows_no_ball(name, random):
    for _ in range(10):
        with pytest.raises(DatasetError, match="none is near: no outline of a ball"):
            find_nearest(NO_BALLS[name](random))


def noisy_disc(random):
    picture = np.full((SIZE, SIZE, 3), 0.1)
    inside = np.hypot(*((np.mgrid[:SIZE, :SIZE] + 0.5) * 2 / SIZE - 1)) < 1
    picture[inside] = 0.9 * random.random((inside.sum(), 3)) * (random.random((inside.sum(), 1)) > 0.3)
    return picture


@pytest.mark.parametrize("picture", quick([
    noisy_disc, lambda random: 0.1 + 0.7 * np.kron(np.indices((8, 8)).sum(axis=0) % 2, np.ones((12, 12)))[
        ..., None] * np.ones(3)], noisy_disc), ids=["a disc of noise", "checks"])
def test_none_is_near_to_what_no_material_is_like(picture, random):
    with pytest.raises(DatasetError, match=r"none is near: the nearest, .*, differs by (?!\d%|[1-5]\d%)"):
        find_nearest(picture(random), "left")


@pytest.mark.parametrize("name", ["gray", "chrome"])
def test_real_balls_have_an_outline(openimageio, name):
    """Cropped by their masks; the chrome ball under the lamp that it shows best."""
    from fitter.imaging.picture_files import read_picture
    from fitter.library.matching import _has_outline

    folder = measurements() / "photographs" / "gray_ball"
    if not folder.is_dir():
        pytest.skip(f"{folder} is not there")
    rows, columns = np.nonzero(read_picture(folder / f"{name}.mask.png").pixels.mean(axis=2) > 0.5)
    part = np.s_[rows.min():rows.max() + 1, columns.min():columns.max() + 1]
    for number in range(12) if name == "gray" else (1,):
        assert _has_outline(read_picture(folder / f"{name}.{number}.png", "srgb").pixels[part]), number


ISOTROPIC = [each.name for each in published.list_offered() if is_isotropic(each.model)]


@pytest.mark.parametrize("name", ISOTROPIC)
@pytest.mark.parametrize("wall", quick([0.02, 0.05, 0.15], 0.05))
def test_the_librarys_balls_have_an_outline(name, wall):
    """In the studio of thumbnails, before walls."""
    from fitter.library.matching import _has_outline

    normal, inside, _ = sphere(100)
    picture = np.full((100, 100, 3), wall)
    picture[inside] = 0.3 * studio.on_sphere(published.find(name).model, normal)
    assert _has_outline(picture[2:98, 2:98])            # where the ball ends


def test_an_unknown_window_is_refused():
    with pytest.raises(DatasetError, match="left, right, above, front"):
        find_nearest(np.full((64, 64, 3), 0.5), "below")
