"""What pixels of a photograph of a ball measure, beside synthetic photographs by another renderer."""

from dataclasses import replace

import numpy as np
import pytest

import fitter
from fitter.photographs.ball.photograph import measure_pixels, visible_pixels
from fitter.photographs.rig import camera
from fitter.photographs.rig.photograph import STEEPEST
from support import ball_scene

SMALL = {"size": (60, 60)}


def photographed(scene, model, noise=0.0, **more):
    picture = ball_scene.photograph(model, scene, noise=noise)
    return fitter.BallPhotograph(picture, scene.rays(), scene.camera, scene.centre, scene.radius, scene.lamp,
                                 scene.intensity, scene.lamp_radius, **more)


@pytest.fixture(scope="module")
def satin():
    return ball_scene.satin()


@pytest.mark.parametrize("settings", [
    {}, {"lamp_radius": 0.03}, {"distance": 0.3}, {"camera": (0.0, -0.3, 0.0), "angle": 24.0},
    {"centre": (0.02, 0.1, -0.01), "target": (0.0, 0.0, 0.01), "angle": 6.0, "size": (60, 90)}], ids=str)
def test_each_pixel_has_the_reflectance_of_its_directions(satin, settings):
    """With perspective, a near lamp, a lamp of known size, and a ball beside the middle of the picture."""
    scene = ball_scene.at_phase(55, 30, **{**SMALL, **settings})
    pixels = measure_pixels(photographed(scene, satin))
    truth = satin.evaluate(*pixels.seen.directions)
    assert len(truth) > 500
    np.testing.assert_allclose(pixels.reflectance, truth, rtol=0.03)
    assert np.median(np.abs(pixels.reflectance / truth - 1)) < 0.004


def test_directions_are_those_of_vectors_worked_out_by_hand():
    """The ball's nearest point to the camera has its normal, and the lamp stands 60 degrees to the right of it."""
    rays = camera.rays(41, 41, np.radians(6), [[1, 0, 0], [0, 0, -1], [0, 1, 0]])
    lamp = np.array([0, -0.05, 0]) + 0.5 * np.array([np.sin(np.pi / 3), -np.cos(np.pi / 3), 0])
    pixels = 1 + 1e-6 * np.random.default_rng(0).standard_normal((41, 41, 1))       # equal ones would be saturated
    shot = fitter.BallPhotograph(pixels, rays, (0, -1, 0), (0, 0, 0), 0.05, lamp, (2.0,))
    found = visible_pixels(shot)
    middle = np.flatnonzero(found.pixel == 20 * 41 + 20)[0]
    theta_i, _, theta_o, _ = (angle[middle] for angle in found.directions)
    assert (theta_i, theta_o) == (pytest.approx(np.pi / 3, abs=1e-9), pytest.approx(0, abs=1e-7))
    assert found.irradiance[middle] == pytest.approx(0.5 / 0.25)
    # f = L d^2 / (I cos theta)
    exact = measure_pixels(replace(shot, noise=np.zeros((41, 41, 1))))
    assert exact.reflectance[middle, 0] == pytest.approx(1 / (2 * 2))


def test_grazing_pixels_and_those_at_the_outline_are_left_out(satin):
    shot = photographed(ball_scene.at_phase(90, 0, **SMALL), satin)
    pixels = visible_pixels(shot)
    assert max(pixels.directions[0].max(), pixels.directions[2].max()) < STEEPEST
    axis = np.array([0, 1, 0])
    off = np.arccos(shot.rays.reshape(-1, 3)[pixels.pixel] @ axis)
    step = np.arccos(shot.rays[30, 30] @ shot.rays[30, 31])
    assert off.max() < np.arcsin(0.05 / 1.5) - 1.4 * step
    large = replace(shot, lamp_radius=0.3)         # 14 degrees wide: none of it may be below the horizon
    assert visible_pixels(large).directions[0].max() < np.radians(67)


def test_saturated_dark_and_masked_pixels_are_left_out(satin):
    scene = ball_scene.at_phase(50, 0, **SMALL)
    shot = photographed(scene, satin)
    whole = len(measure_pixels(shot).reflectance)
    white = np.quantile(shot.radiance[shot.radiance > 0], 0.95)
    clipped = measure_pixels(replace(shot, radiance=np.minimum(shot.radiance, white)))
    assert clipped.left_out == whole - len(clipped.reflectance) > 50
    lit = np.zeros(len(shot.radiance.reshape(-1, 3)), bool)
    lit[clipped.seen.pixel] = True
    assert (shot.radiance.reshape(-1, 3)[lit] < white).all()
    covered = shot.radiance.copy()
    covered[20:40, 30:34] = 0              # something that is dark before the ball
    inside = np.zeros((60, 60), bool)
    inside[21:39, 31:33] = True
    assert not inside.ravel()[measure_pixels(replace(shot, radiance=covered)).seen.pixel].any()
    mask = np.ones((60, 60), bool)
    mask[:, :30] = False
    assert (measure_pixels(replace(shot, mask=mask)).seen.pixel % 60 >= 30).all()


def test_the_noise_that_is_estimated_is_that_of_the_pixels():
    scene = ball_scene.at_phase(20, 0, size=(120, 120))
    for noise in (0.01, 0.05):
        pixels = measure_pixels(photographed(scene, ball_scene.matte(), noise=noise))
        upright = (pixels.seen.directions[0] < 0.3) & (pixels.seen.directions[2] < 0.3)
        # over three channels, of which each has it
        assert np.median(pixels.deviation[upright]) == pytest.approx(noise, rel=0.35)


def test_grazing_light_counts_less(satin):
    pixels = measure_pixels(photographed(ball_scene.at_phase(40, 0, **SMALL), satin))
    steep = pixels.seen.directions[0] > np.radians(70)
    assert np.median(pixels.deviation[steep]) > 3 * np.median(pixels.deviation[~steep])


@pytest.mark.parametrize(("change", "message"), [
    ({"rays": np.ones((4, 4, 3))}, r"rays has the shape \(4, 4, 3\), expected \(60, 60, 3\)"),
    ({"rays": np.ones((60, 60, 3))}, "expected unit vectors"),
    ({"radiance": np.ones((60, 60))}, "expected \\(height, width, 1 or 3\\)"),
    ({"radiance": np.full((60, 60, 3), np.nan)}, "not finite"),
    ({"intensity": (1, 1)}, "expected 3 numbers above 0"),
    ({"intensity": (1, 1, 0)}, "expected 3 numbers above 0"),
    ({"radius": 0.0}, "radius 0 found"),
    ({"noise": -np.ones((60, 60, 3))}, "noise below 0"),
    ({"mask": np.ones((3, 3))}, "the mask has the shape"),
    ({"lamp_radius": -1.0}, "a lamp with the radius -1"),
    ({"camera": (0, -0.01, 0)}, "the camera is inside the ball"),
    ({"lamp": (0, 0.04, 0)}, "the lamp is inside the ball"),
    ({"lamp": (0, -3, 0)}, "behind the camera, whose shadow"),
])
def test_what_cannot_be_is_refused(satin, change, message):
    shot = photographed(ball_scene.at_phase(50, 0, **SMALL), satin, name="shot.exr")
    with pytest.raises(fitter.DatasetError, match=f"^shot.exr: .*{message}"):
        replace(shot, **change)


@pytest.mark.parametrize(("change", "message"), [
    ({"lamp": (0, 2, 0)}, "the lamp is behind the ball"),
    ({"centre": (1, 0, 0)}, "no pixel sees the ball"),
    ({"centre": (0, -3, 0)}, "no pixel sees the ball"),
    ({"radiance": np.zeros((60, 60, 3))}, "nothing of the ball is lit"),
])
def test_photographs_that_show_nothing_say_why(satin, change, message):
    shot = photographed(ball_scene.at_phase(50, 0, **SMALL), satin, name="shot.exr")
    with pytest.raises(fitter.DatasetError, match=f"^shot.exr: .*{message}"):
        fitter.samples_from_ball([replace(shot, **change)])
