"""Materials of photographs beside the reflectances that were photographed."""

import numpy as np
import pytest

import fitter
from benchmarks import photographs as bench
from fitter.photographs.ball.coverage import are_covered
from support import ball_scene
from support.cases import quick, release
from support.checkout import measurements

AT = tuple(angle[::10] for angle in bench.directions())


def made(shots):
    samples = fitter.samples_from_ball(shots)
    return samples, fitter.fit(samples, **fitter.PRESETS["Draft"])


def error(model, fit, where):
    at = tuple(angle[where] for angle in AT)
    return bench.difference(at[2], np.broadcast_to(model.evaluate(*at), (len(at[0]), 3)), fit.evaluate(*at))


@pytest.fixture(scope="module")
def shots():
    return bench.photographs(ball_scene.glossy())


@pytest.fixture(scope="module")
def glossy_ball(shots):
    return made(shots)


@pytest.mark.parametrize("make", quick(bench.SYNTHETIC, ball_scene.glossy), ids=lambda make: make.__name__)
def test_the_material_is_that_of_the_ball(make, glossy_ball):
    """Of eight lamps, 120 x 120 pixels and 1 % of noise."""
    model = make()
    samples, fit = glossy_ball if make is ball_scene.glossy else made(bench.photographs(model))
    assert error(model, fit, are_covered(samples, AT)) < 0.05
    assert error(model, fit, slice(None)) < 0.10


@pytest.mark.parametrize(("fault", "most"), quick([(bench.shift_balls, 0.01), (bench.turn_lamps, 0.04)],
                                                  (bench.shift_balls, 0.01)))
def test_an_error_of_a_pixel_or_a_degree_changes_little(shots, glossy_ball, fault, most):
    samples, fit = glossy_ball
    assert error(fit, made(fault(shots))[1], are_covered(samples, AT)) < most


@release
@pytest.mark.parametrize(("name", "most"), [*{**dict.fromkeys(bench.REAL, 0.05), "krylon blue": 0.065,
                                              "silk blue": 0.27}.items()])
def test_the_material_is_that_of_a_real_fit(name, most):
    file, _ = bench.REAL[name]
    if not (measurements() / file).is_file():
        pytest.skip(f"{measurements() / file} is absent")
    model = dict(bench.materials([name]))[name]()
    samples, fit = made(bench.photographs(model))
    assert error(model, fit, are_covered(samples, AT)) < most


def test_grey_photographs_make_grey_samples():
    shots = [bench.replace(shot, radiance=shot.radiance[..., :1], intensity=shot.intensity[:1])
             for shot in bench.photographs(ball_scene.matte(), (30, 80), size=(50, 50))]
    assert fitter.samples_from_ball(shots).channels == ("grey",)


def test_photographs_must_belong_together():
    first, second = bench.photographs(ball_scene.matte(), (30, 80), size=(50, 50))
    other, = bench.photographs(ball_scene.matte(), (30,), size=(50, 60), angle=5.0)
    with pytest.raises(fitter.DatasetError, match=r"60 x 50 pixels with 3 channels found, expected 50 x 50 pixels"):
        fitter.samples_from_ball([first, second, other])
    with pytest.raises(fitter.DatasetError, match="no photographs found"):
        fitter.samples_from_ball([])
