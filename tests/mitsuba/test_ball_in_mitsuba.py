"""Photographs of a ball that Mitsuba 3 has rendered: the fit that they measure is the one that was rendered."""

import numpy as np
import pytest

import fitter
from support import ball_stage, stage

pytest.importorskip("mitsuba", reason="Mitsuba is absent; `make test-mitsuba` installs it")


def test_what_is_measured_of_a_rendered_ball_is_its_material(extension, glossy):
    from support import mitsuba_scene

    fit = fitter.fit(glossy, **fitter.PRESETS["Draft"])
    shots = []
    for phase, turn in ((30, 0), (100, 120)):
        scene = ball_stage.scene(phase, turn)
        material, _, _ = stage.blank_material("ball", "ShaderNodeBsdfDiffuse")
        next(item for item in scene.objects if item.type == "MESH").data.materials.append(material)
        shots.append(ball_stage.photograph(scene, mitsuba_scene.render(scene, {"ball": fit}, 64, 0)))
    samples = fitter.samples_from_ball(shots)
    off = np.abs(samples.values / fit.evaluate(*samples.directions) - 1)
    assert np.median(off) < 0.02
