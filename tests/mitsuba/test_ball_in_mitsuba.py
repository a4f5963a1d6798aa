"""Photographs of a ball, and of a flat sample, that Mitsuba 3 has rendered: what they measure is what was rendered."""

import numpy as np
import pytest

import fitter
from support import ball_stage, flat_scene, stage

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


def test_what_is_measured_of_a_rendered_flat_sample_is_the_sample(cornell):
    """Issue: 5 %, .05 and 2 degrees. Reached: .7 %, .002 and .06 degrees."""
    from support import mitsuba_scene

    fits = tuple(fitter.fit(cornell(name), **fitter.PRESETS["Draft"]) for name in ("garnet_red_RGB", "krylon_blue_RGB"))
    sample, size, texels = flat_scene.Sample(fits, flat_scene.smooth_weights(2), flat_scene.bumps), (90, 100), (24, 30)

    def photographed(lamp):
        return mitsuba_scene.flat_photograph(sample, lamp, size, (96, 120)).astype(float)

    shots = [fitter.FlatPhotograph(photographed(lamp), flat_scene.rays(size), flat_scene.CAMERA, lamp,
                                   flat_scene.INTENSITY) for lamp in flat_scene.lamps()]
    maps = fitter.maps_from_flat(shots, flat_scene.corners(), texels, fits)
    u, v = flat_scene.texels(texels)
    wrong = np.abs(maps.weights.reshape(-1, 2) - sample.weights(u, v)).mean(axis=0)
    cosine = (maps.normals.reshape(-1, 3) * sample.normals(u, v)).sum(axis=1)
    turned = np.degrees(np.median(np.arccos(np.clip(cosine, -1, 1))))
    there = flat_scene.shown(photographed(flat_scene.UNUSED), texels)
    found = maps.radiance(flat_scene.CAMERA, flat_scene.UNUSED, flat_scene.INTENSITY)
    # the photograph has the dark beside the card in the pixels of its edge
    off = np.linalg.norm((found - there)[1:-1, 1:-1]) / np.linalg.norm(there[1:-1, 1:-1])
    print(f"unseen lamp {off:.2%}, masks {wrong.max():.4f}, normals {turned:.3f} degrees")
    assert off < 0.05
    assert wrong.max() < 0.05
    assert turned < 2
