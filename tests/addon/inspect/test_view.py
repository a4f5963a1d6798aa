"""Points, pixels and rays of a view against a camera worked out by hand; dragging against what is seen."""

import math

import numpy as np
import pytest
from mathutils import Matrix, Vector
from measured_brdf.addon.inspect.view import View, drag_direction


@pytest.fixture
def view(extension):
    def made(orthographic=False, width=900, height=600):
        """A camera at (3, -6, 4) that looks at (0, 0, 1); 50 degrees across, or 5 units."""
        eye = Vector((3, -6, 4))
        turned = (Vector((0, 0, 1)) - eye).to_track_quat("-Z", "Y")
        to_camera = np.array((Matrix.Translation(eye) @ turned.to_matrix().to_4x4()).inverted())
        near, far, aspect = 0.1, 100.0, height / width
        if orthographic:
            lens = np.diag([2 / 5, 2 / (5 * aspect), -2 / (far - near), 1.0])
            lens[2, 3] = -(far + near) / (far - near)
        else:
            x = 1 / math.tan(math.radians(25))
            lens = np.array([[x, 0, 0, 0], [0, x / aspect, 0, 0],
                             [0, 0, -(far + near) / (far - near), -2 * far * near / (far - near)], [0, 0, -1, 0]])
        return View(lens @ to_camera, width, height)
    return made


@pytest.fixture
def frame():
    normal = np.array([0.2, -0.6, 0.7])
    normal /= np.linalg.norm(normal)
    tangent = np.cross(normal, (0, 0, 1.0))
    tangent /= np.linalg.norm(tangent)
    whole = np.eye(4)
    whole[:3] = np.stack([tangent, np.cross(normal, tangent), normal, (0.3, 0.1, 1.2)], axis=-1)
    return whole


@pytest.mark.parametrize("orthographic", [False, True])
def test_what_the_camera_looks_at_is_in_the_middle_and_what_is_above_it_is_above(view, orthographic):
    seen = view(orthographic)
    np.testing.assert_allclose(seen.project((0, 0, 1)), (450, 300), atol=1e-3)
    x, y = seen.project((0, 0, 1.5))
    assert x == pytest.approx(450, abs=1e-3)
    assert y > 310


@pytest.mark.parametrize("orthographic", [False, True])
def test_a_ray_goes_through_what_is_seen_at_its_pixel(view, orthographic):
    seen = view(orthographic)
    for point in np.random.default_rng(4).uniform(-1, 1, (20, 3)):
        origin, direction = seen.ray(seen.project(point))
        np.testing.assert_allclose(np.cross(point - origin, direction), 0, atol=1e-6)
        assert (point - origin) @ direction > 0, "away from the viewer"
        np.testing.assert_allclose(seen.direction_to_viewer(point), -direction, atol=1e-9)


def test_a_point_behind_the_viewer_is_nowhere(view):
    assert np.isnan(view().project((6, -13, 7))).all()
    assert view().pixel((6, -13, 7)) == 0


@pytest.mark.parametrize("orthographic", [False, True])
def test_a_pixel_is_as_long_as_two_points_a_pixel_apart_are_apart(view, orthographic):
    seen, point = view(orthographic), np.array([0.2, 0.3, 1.1])
    right = np.array((6, 3, 0)) / math.hypot(6, 3)          # of the camera
    length = seen.pixel(point)
    moved = seen.project(point + length * right) - seen.project(point)
    np.testing.assert_allclose(moved, (1, 0), atol=0.02)
    if orthographic:
        assert length == pytest.approx(5 / 900)


@pytest.mark.parametrize("orthographic", [False, True])
def test_dragging_finds_the_direction_whose_point_is_under_the_mouse(view, frame, orthographic):
    seen, radius = view(orthographic), 0.8
    for theta, phi in ((0.1, 2.0), (0.5, -1.0), (0.9, 0.4), (0.3, 3.0)):
        point = np.array([math.sin(theta) * math.cos(phi), math.sin(theta) * math.sin(phi), math.cos(theta)])
        at = seen.project(frame[:3, 3] + radius * frame[:3, :3] @ point)
        angles = drag_direction(seen, at, frame, radius)
        assert angles == pytest.approx((theta, phi), abs=1e-5)


@pytest.fixture
def upright():
    whole = np.eye(4)
    whole[:3, 3] = 0, 0, 1
    return whole


def test_dragging_below_the_horizon_stays_above_it(view, upright):
    seen = view()
    to_camera = np.array([3, -6, 0]) / math.hypot(3, 6)
    at = seen.project(upright[:3, 3] + 0.8 * (0.6 * to_camera - (0, 0, 0.8)))
    theta, phi = drag_direction(seen, at, upright, 0.8)
    assert theta == pytest.approx(math.radians(89))
    assert phi == pytest.approx(math.atan2(-6, 3), abs=1e-4)


def test_dragging_beside_the_hemisphere_keeps_to_its_outline(view, upright):
    seen, center = view(), upright[:3, 3]
    away = np.array([250.0, 300.0])
    theta, phi = drag_direction(seen, seen.project(center) + away, upright, 0.8)
    point = np.array([math.sin(theta) * math.cos(phi), math.sin(theta) * math.sin(phi), math.cos(theta)])
    _, direction = seen.ray(seen.project(center) + away)
    assert abs(point @ direction) < 1e-6, "at a right angle to the ray"
    shown = seen.project(center + 0.8 * point) - seen.project(center)
    assert shown @ away / np.linalg.norm(shown) / np.linalg.norm(away) > 0.97, "on the side of the mouse"
