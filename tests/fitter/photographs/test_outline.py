"""The outline of a ball: found in pictures, and compared with where the ball is said to be."""

from dataclasses import replace

import numpy as np
import pytest

import fitter
from fitter.photographs.ball.placing import check_outline, place_ball
from fitter.photographs.rig.ball_finding import brightest, find_ball
from support import ball_scene
from tests.fitter.photographs.test_ball import photographed

PIXEL = 1.5 * 2 * np.tan(np.radians(2.1)) / 120         # of the default scene, metres at the ball
ROUND = 15, 55, 95, 135


@pytest.fixture(scope="module")
def taken():
    return [photographed(scene, ball_scene.matte(), noise=0.01) for scene in ball_scene.scenes(ROUND)]


def moved(shot, across, up=0.0):
    return replace(shot, centre=shot.centre + PIXEL * np.array([across, 0, up]))


def bright(shots):
    return brightest([each.radiance for each in shots])


@pytest.mark.parametrize("settings", [{}, {"camera": (0.0, -0.4, 0.0), "angle": 30.0, "target": (0.04, 0.0, 0.03)}],
                         ids=["far", "near, aside"])
def test_a_ball_is_found_where_it_is(settings):
    """Seen from near and beside the axis its picture is an ellipse."""
    shots = [photographed(scene, ball_scene.satin(), noise=0.01) for scene in ball_scene.scenes(ROUND, **settings)]
    scene = ball_scene.Scene(**settings)
    outline = find_ball(bright(shots), shots[0].rays)
    off = outline.centre(scene.camera, scene.radius) - scene.centre
    pixel = np.linalg.norm(np.subtract(scene.camera, scene.centre)) * np.arccos(
        shots[0].rays[60, 60] @ shots[0].rays[60, 61])
    assert np.linalg.norm(off[[0, 2]]) < 0.3 * pixel
    assert np.sin(outline.half_angle) == pytest.approx(scene.radius / np.linalg.norm(scene.camera), rel=0.01)
    assert outline.residual < 0.3


def test_no_ball_two_balls_and_a_ball_cut_by_the_frame_are_refused(taken):
    picture, rays = bright(taken), taken[0].rays
    random = np.random.default_rng(0)
    with pytest.raises(fitter.DatasetError, match=r"^dark.exr: no ball found"):
        find_ball(1e-3 * random.standard_normal(picture.shape), rays, "dark.exr")
    wide = ball_scene.Scene(angle=12.0)
    pictures = [ball_scene.photograph(ball_scene.matte(), ball_scene.at_phase(40, 0, angle=12.0, centre=(x, 0.0, 0.0)))
                for x in (-0.07, 0.07)]
    with pytest.raises(fitter.DatasetError, match="two bright things"):
        find_ball(sum(pictures), wide.rays())
    aside = ball_scene.at_phase(40, 0, target=(0.04, 0.0, 0.0))
    with pytest.raises(fitter.DatasetError, match="cut by the frame"):
        find_ball(ball_scene.photograph(ball_scene.matte(), aside), aside.rays())
    square = np.zeros_like(picture)
    square[30:90, 20:100] = 1
    with pytest.raises(fitter.DatasetError, match="no disc"):
        find_ball(square, rays)


def test_a_moved_camera_is_noticed_and_a_pixel_is_not(taken):
    for shot in taken:
        check_outline(shot)
        check_outline(moved(shot, 1.2))
    for across, up in ((4, 0), (0, -5), (12, 0), (-40, 10)):
        with pytest.raises(fitter.DatasetError, match="outline is not where it is said to be"):
            fitter.samples_from_ball([taken[0], taken[1], moved(taken[2], across, up)])


def test_only_the_highlight_of_a_black_ball_need_be_seen():
    black = ball_scene.truths.Truth("black", "", ball_scene.truths._sum(
        ball_scene.truths.Truth("", "", ball_scene.truths._matte([0.002] * 3, 0.3)),
        ball_scene.truths._lobe(30.0, 0.05, f0=0.05)))
    for scene in ball_scene.scenes((30, 90)):
        check_outline(photographed(scene, black, noise=0.01))


def test_a_ball_is_moved_to_its_outline(taken):
    found = place_ball([moved(shot, 0.8, -0.7) for shot in taken])
    for shot in found:
        assert np.linalg.norm((shot.centre - taken[0].centre)[[0, 2]]) < 0.1 * PIXEL
    # of one crescent too little is seen
    assert place_ball([moved(taken[3], 0.8)])[0].centre[0] == pytest.approx(0.8 * PIXEL)
