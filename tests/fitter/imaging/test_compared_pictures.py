"""Two materials in one picture: each side against a picture of its own, curves against values written out by hand."""

import math

import numpy as np
import pytest

from fitter.colours import conversion
from fitter.imaging import pictures, plane_plot
from fitter.imaging.drawing import BACKGROUND, INK, Canvas
from fitter.imaging.plane_plot import PAIR, Plotted
from fitter.methods import prior
from support.anisotropic import brushed_fit


class Lobe:
    """A Lambertian and a lobe toward the mirror direction, in the channels of its colour."""

    def __init__(self, power, *colour):
        self.power, self.colour = power, np.array(colour)

    def evaluate(self, theta_i, phi_i, theta_o, phi_o):
        cosine = np.cos(theta_i) * np.cos(theta_o) - np.sin(theta_i) * np.sin(theta_o) * np.cos(phi_o - phi_i)
        return (0.1 + np.maximum(cosine, 0) ** self.power)[..., None] * self.colour


RED, BLUE = Lobe(9, 0.4, 0.1, 0.1), Lobe(30, 0.1, 0.2, 0.3)


@pytest.mark.parametrize(("at", "line"), [(0.5, 32), (0.25, 16), (0.8, 51)])
def test_each_side_of_a_split_sphere_is_that_of_a_sphere_alone(at, line):
    left, right = pictures.lit_sphere(RED, 64), pictures.lit_sphere(BLUE, 64)
    picture = pictures.split(left, right, at)
    np.testing.assert_array_equal(picture[:, :line], left[:, :line])
    np.testing.assert_array_equal(picture[:, line + 1:], right[:, line + 1:])
    np.testing.assert_allclose(picture[:, line], np.tile(INK, (64, 1)), atol=1e-6)
    assert np.abs(left - right).max() > 0.2


@pytest.mark.parametrize("at", [0.0, 1.0])
def test_a_line_at_the_edge_leaves_one_picture(at):
    left, right = np.zeros((40, 40, 4), np.float32), np.ones((40, 40, 4), np.float32)
    picture = pictures.split(left, right, at)
    np.testing.assert_array_equal(picture[:, 1:-1], (right if at == 0 else left)[:, 1:-1])
    assert left.max() == 0, "the pictures themselves stay as they were"


def test_pictures_of_two_sizes_are_not_joined():
    with pytest.raises(ValueError, match=r"\(4, 4, 4\) and \(8, 8, 4\), expected the same shape"):
        pictures.split(np.zeros((4, 4, 4), np.float32), np.zeros((8, 8, 4), np.float32))


def compared(first, second, theta_i, size, phi_i=0.0, space="Rec.709"):
    """The plot of two materials."""
    return plane_plot.polar_plot([Plotted(first), Plotted(second, space)], None, theta_i, size, phi_i)[0]


def drawn(picture, x, y, color):
    """Whether a colour is at a place, (x, y) in pixels from the bottom left."""
    part = picture[int(y) - 1:int(y) + 2, int(x) - 1:int(x) + 2, :3]
    return np.abs(part - color).max(axis=-1).min() < 0.12


def luminance(colour):
    return 0.2126 * colour[0] + 0.7152 * colour[1] + 0.0722 * colour[2]


def test_both_curves_are_cube_roots_of_luminance_from_one_origin_and_to_one_scale():
    size, theta_i = 400, math.radians(35)
    picture, disc = compared(RED, BLUE, theta_i, size), plane_plot.picture_disc(size)

    def value(material, theta):                     # theta beyond the normal, seen from the light
        lobe = max(math.cos(theta - theta_i), 0) ** material.power
        return (0.1 + lobe) * luminance(material.colour)

    largest = max(value(RED, theta_i), value(BLUE, theta_i))
    for theta in np.radians([-70, -30, 0, 20, 35, 50, 80]):
        for material, color in ((RED, PAIR[0][:3]), (BLUE, PAIR[1][:3])):
            length = (value(material, theta) / largest) ** (1 / 3)
            x, y = disc.points(theta, length)
            other = value(BLUE if material is RED else RED, theta)
            if abs((other / largest) ** (1 / 3) - length) * disc.radius > 6:        # else the curves cover each other
                assert drawn(picture, x, y, color), (math.degrees(theta), color)


def test_a_curve_follows_the_lights_azimuth_on_an_anisotropic_material():
    fit = brushed_fit()
    assert np.abs(compared(fit, RED, 0.5, 96, 0.0) - compared(fit, RED, 0.5, 96, 1.2)).max() > 0.3


def test_a_wider_space_has_its_own_luminance():
    """The same stimulus in two spaces: one curve, so B covers A everywhere."""
    wide = Lobe(9, *(conversion("Rec.709", "Rec.2020") @ RED.colour))
    picture = compared(RED, wide, 0.5, 200, space="Rec.2020")
    orange, blue = (np.abs(picture[..., :3] - color[:3]).max(axis=-1) < 0.1 for color in PAIR)
    assert not orange.any()
    assert blue.sum() > 100


@pytest.mark.parametrize("string", ["0123456789", "-1.2e+09/", "90\u00b0", "1/sr"])
def test_text_is_as_wide_as_it_says_and_stands_on_its_base_line(string):
    canvas = Canvas(np.full((128, 128, 4), BACKGROUND, np.float32))
    width = canvas.text(string, (64.0, 40.0), 12.0, INK, 0.5)
    inked = np.argwhere(np.abs(canvas.picture[..., 0] - BACKGROUND[0]) > 0.15)
    (low, left), (high, right) = inked.min(axis=0), inked.max(axis=0)
    assert (left, right) == pytest.approx((64 - width / 2, 64 + width / 2), abs=1.6)
    assert low == pytest.approx(40, abs=1.1)
    assert high - low <= 12 * 0.8


def test_grey_and_coloured_materials_are_compared():
    picture = compared(prior.lambertian(np.array([[0.2]])), Lobe(0, 0.2 / 1.1, 0.2 / 1.1, 0.2 / 1.1), 0.5, 200)
    orange = np.abs(picture[..., :3] - PAIR[0][:3]).max(axis=-1) < 0.1
    assert not orange.any()                         # covered by B, which is equal
