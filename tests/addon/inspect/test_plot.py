"""The plot's arithmetic against geometry, and the colours and shades of the lobe."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from measured_brdf.addon.inspect import drawing, plot
from measured_brdf.addon.inspect.overlay import lobe_colors, shading

from fitter.imaging import plane_plot


@pytest.mark.parametrize("scale", [1.0, 1.25, 2.0])
@pytest.mark.parametrize("side", ["LEFT", "RIGHT"])
def test_a_plot_is_large_and_inside_of_its_region(side, scale):
    made = plot.place_plot((40, 0, 1400 * scale, 800 * scale), side, scale)
    assert 400 * scale <= made.width
    assert 300 * scale <= made.height
    assert made.x >= 40
    assert made.x + made.width <= 40 + 1400 * scale
    assert made.y >= 0
    assert made.y + made.height <= 800 * scale
    assert (made.x - 40 < 100) == (side == "LEFT")
    top = made.disc.points(0.0, 1.0)[1]
    assert top < made.line(1)[1] - 5 * scale, "the disc is below the titles"
    assert made.line(-1)[1] < made.line(-2)[1] < made.center[1] < made.line(1)[1] < made.line(0)[1]


def test_a_small_region_has_a_smaller_plot():
    made = plot.place_plot((0, 0, 420, 360), "LEFT", 1.0)
    assert made.width <= 420 - 20
    assert made.height <= 360
    assert plot.place_plot((0, 0, 50, 20), "LEFT", 1.0).radius > 0


def test_angles_of_points_are_those_they_were_made_of():
    made = plot.place_plot((0, 0, 900, 700), "RIGHT", 1.0)
    for theta in (-1.5, -0.4, 0.0, 0.9, 1.5):
        for length in (0.2, 1.0):
            at = made.disc.points(theta, length)
            assert made.angle(at) == pytest.approx(theta)
            assert made.is_read(at)
            assert made.holds(at)
    assert made.disc.points(-0.5, 1.0)[0] < made.center[0], "the light is left"
    below = made.center - (30, 60)
    assert made.angle(below) == pytest.approx(-math.pi / 2)
    assert not made.is_read(made.disc.points(0.3, 1.2))
    assert not made.holds((made.x - 1, made.y))


def test_sidebars_and_headers_are_left_free():
    region = (100, 50, 1000, 600)
    tools, sidebar = (100, 50, 60, 550), (900, 50, 200, 550)
    header, other = (100, 600, 1000, 50), (2000, 0, 300, 900)
    assert plot.free_part(region, [tools, sidebar, header, other]) == (60, 0, 740, 550)
    assert plot.free_part(region, []) == (0, 0, 1000, 600)
    assert plot.free_part(region, [(100, 50, 1000, 40)]) == (0, 40, 1000, 560)


@pytest.mark.parametrize(("panel", "free"), [
    ((168, 58, 300, 34), (60, 42, 940, 508)),           # Adjust Last Operation: closed
    ((168, 58, 300, 320), (368, 0, 632, 550)),          # open
    ((168, 58, 700, 320), (60, 328, 940, 222)),
])
def test_a_panel_that_floats_in_a_corner_leaves_the_larger_part_beside_it(panel, free):
    tools, header = (100, 50, 60, 550), (100, 600, 1000, 50)
    assert plot.free_part((100, 50, 1000, 600), [tools, header, panel]) == free
    assert plot.free_part((100, 50, 1000, 600), [panel, header, tools])[3] >= free[3]


def test_what_is_covered_as_a_whole_has_no_free_part():
    _, _, width, height = plot.free_part((100, 50, 300, 200), [(0, 0, 900, 900)])
    assert max(width, 0) * max(height, 0) == 0
    assert plot.place_plot(plot.free_part((100, 50, 300, 200), [(0, 0, 900, 900)]), "LEFT", 1.0).radius > 0


@pytest.mark.parametrize(("radius", "root"), [("cube root", 3), ("linear", 1)])
@pytest.mark.parametrize("largest", [0.0313, 0.9999, 1.0, 47.3, 8123.0])
def test_rings_have_values_of_one_digit_and_lie_where_such_values_do(radius, root, largest):
    circles = plane_plot.rings(largest, radius)
    assert len(circles) >= 2
    for value, length in circles:
        digits = value / 10 ** math.floor(math.log10(value) + 1e-9)
        assert digits == pytest.approx(round(digits))
        assert value <= largest * (1 + 1e-9)
        assert length ** root == pytest.approx(value / largest)
    assert circles[0][1] <= 1 + 1e-9
    assert max(np.diff([length for _, length in circles])) < -0.1, "their labels do not overlap"


@pytest.mark.parametrize(("value", "shown"), [
    (0.0, "0"), (0.001234, "0.00123"), (0.1, "0.1"), (12.345, "12.3"), (1234.5, "1230"), (-0.02, "-0.02"),
    (1.2345e-9, "1.2e-09")])
def test_values_are_shown_with_three_digits(value, shown):
    assert plane_plot.shown_value(value) == shown


def test_the_lobe_has_the_hue_of_its_values_and_is_brighter_where_they_are_larger(extension):
    values = np.array([[8.0, 4.0, 2.0], [0.08, 0.04, 0.02], [0.0, 0.0, 0.0]])
    colours = lobe_colors(values, "Rec.709")
    np.testing.assert_allclose(colours[0], (1, 0.5, 0.25))
    np.testing.assert_allclose(colours[1] / colours[1].max(), (1, 0.5, 0.25))
    assert colours[0].max() > colours[1].max() > colours[2].max() > 0
    grey = lobe_colors(np.array([[3.0]]), "ACEScg")
    np.testing.assert_allclose(grey, np.ones((1, 3)), atol=1e-6)
    assert np.isfinite(lobe_colors(np.zeros((4, 3)), "Rec.709")).all()


def test_what_faces_the_key_light_is_brightest_and_all_is_lit_a_little(extension):
    axes = np.array([[0, 1, 0], [0, 0, 1], [1, 0, 0]], dtype=float)     # the viewer is on the x axis
    toward_key = np.array([[0.7, -0.42, 0.58]])
    away = -toward_key
    sideways = np.array([[1.0, 0, 0]])
    bright, dim, middle = (shading(each / np.linalg.norm(each), axes)[0] for each in (toward_key, away, sideways))
    assert bright > middle > dim > 0
    assert bright <= 1


def test_dashes_lie_on_a_line_and_have_gaps_of_their_length():
    ends = plane_plot.dashes(np.array([[0.0, 0], [30, 0], [30, 40]]), 10.0).reshape(-1, 2, 2)
    expected = [[[0, 0], [10, 0]], [[20, 0], [30, 0]], [[30, 10], [30, 20]], [[30, 30], [30, 40]]]
    np.testing.assert_allclose(ends, expected)


@pytest.mark.parametrize("room", [150.0, 291.0, 299.5])
def test_text_that_is_too_wide_is_drawn_in_its_room_also_where_letters_are_hinted(extension, monkeypatch, room):
    """A font whose letters are whole pixels wide: half of its size makes them more than half as wide."""
    state, drawn = {}, []
    font = SimpleNamespace(
        size=lambda _font, size: state.update(size=size), color=lambda *_: None, position=lambda *_: None,
        dimensions=lambda _font, text: (len(text) * math.ceil(0.5 * state["size"]), 10.0),
        draw=lambda _font, text: drawn.append(font.dimensions(0, text)[0]))
    monkeypatch.setattr(drawing, "blf", font)
    assert drawing.text(50 * "a", (0, 0), 11.0, (1, 1, 1, 1), room=room) == drawn[-1] <= room
    assert drawing.text(50 * "a", (0, 0), 11.0, (1, 1, 1, 1)) == drawn[-1] == 300
