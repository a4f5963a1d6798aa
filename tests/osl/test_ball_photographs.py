"""Photographs of a ball that Cycles has rendered: the fit that they measure is the one that was rendered."""

import numpy as np

import fitter
from support import ball_stage
from support.stage import osl_material_for, render


def test_what_is_measured_of_a_rendered_ball_is_its_material(blender, glossy):
    fit = fitter.fit(glossy, **fitter.PRESETS["Draft"])
    shots = []
    for phase, turn in ((30, 0), (100, 120)):
        scene = ball_stage.scene(phase, turn)
        blender.context.object.data.materials.append(osl_material_for(fit))
        shots.append(ball_stage.photograph(scene, render(scene)))
    samples = fitter.samples_from_ball(shots)
    assert len(samples) > 3000
    off = np.abs(samples.values / fit.evaluate(*samples.directions) - 1)
    assert np.median(off) < 0.01
    assert np.quantile(off, 0.95) < 0.06
