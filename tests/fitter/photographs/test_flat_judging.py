"""What photographs of a flat sample say against what is given of them."""

from dataclasses import replace

import numpy as np
import pytest

import fitter
from fitter.photographs.flat import judging
from fitter.photographs.flat.maps import evenly, sample_frame, texel_points
from fitter.photographs.flat.photograph import observe
from fitter.photographs.report import report_sample
from support import flat_scene
from tests.fitter.photographs.test_flat import photographed

SHAPE, CORNERS = (24, 24), flat_scene.corners()


def surface(u, v):
    """The slopes of a height that waves along u and v."""
    return 0.2 * np.column_stack([np.cos(9 * u) * np.sin(8 * v + 1),
                                  np.sin(9 * u) * np.cos(8 * v + 1) * 8 / 9 / 0.8])


@pytest.fixture(scope="module")
def sample(cornell, curet):
    fits = tuple(fitter.fit(samples, **fitter.PRESETS["Standard"]) for samples in (cornell("garnet_red_RGB"), curet(5)))
    return flat_scene.Sample(fits, flat_scene.smooth_weights(2), surface)


@pytest.fixture(scope="module")
def shots(sample):
    return photographed(sample, flat_scene.lamps(12))


def doubts(shots, sample):
    frame = sample_frame(CORNERS, shots)
    some = texel_points(CORNERS, SHAPE).reshape(*SHAPE, 3)[evenly(*SHAPE, 100)].reshape(-1, 3)
    names = [each.name for each in shots]
    return judging.contradictions(sample.fits, observe(shots, some, frame[2]), frame, names)


def test_photographs_that_are_right_are_not_doubted(shots, sample):
    assert doubts(shots, sample) == []


def test_exchanged_lamps_are_named(shots, sample):
    changed = list(shots)
    changed[2], changed[5] = replace(shots[2], lamp=shots[5].lamp), replace(shots[5], lamp=shots[2].lamp)
    found = doubts(changed, sample)
    assert found[0].startswith("The others do not predict 2.exr (")
    assert "5.exr (" in found[0]
    assert found[1] == "The lamps of 2.exr and 5.exr look as if they were exchanged"
    assert len(found) == 2


def test_a_room_that_was_not_dark_is_told(shots, sample):
    room = 0.1 * np.median([each.radiance[45, 50] for each in shots])
    found = doubts([replace(each, radiance=each.radiance + room) for each in shots], sample)
    assert any("the room may not have been dark" in line for line in found)


@pytest.mark.parametrize(("matrix", "told"), [
    (np.diag([1.0, 1, 1]), ""), (np.diag([-1.0, 1, 1]), "mirrored"),
    (np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]]), "turned by 90 degrees")])
def test_normals_of_no_surface_tell_that_lamps_are_mirrored_or_corners_turned(random, matrix, told):
    """A wavy surface whose lamps, and with them its normals, were read in other axes."""
    v, u = (np.mgrid[:40, :50] + 0.5) / 50
    p = np.cos(9 * u) * np.sin(8 * v) + 0.3 * np.cos(11 * u + 4 * v)
    q = 8 / 9 * np.sin(9 * u) * np.cos(8 * v) + 0.3 * 4 / 11 * np.cos(11 * u + 4 * v)
    normals = np.stack([0.2 * p, 0.2 * q, np.ones_like(p)], axis=2) + 0.002 * random.standard_normal((40, 50, 3))
    normals = normals / np.linalg.norm(normals, axis=2, keepdims=True) @ matrix.T
    found = judging.turned_lamps(normals, np.eye(3), np.ones((40, 50), bool), np.array([0.05, 0.04]))
    assert bool(found) == bool(told)
    assert all(f"directions were {told}:" in line for line in found)


def test_more_light_than_arrives_is_told(shots, sample):
    dim = [replace(each, intensity=each.intensity / 20) for each in shots]
    for each, is_told in ((shots, False), (dim, True)):
        maps = fitter.maps_from_flat(each, CORNERS, (8, 8), sample.fits)
        assert any("More light leaves than arrives" in line for line in report_sample(maps, each).doubts) == is_told
