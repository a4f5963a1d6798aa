"""The figures of the bench of ordinary scenes, of pictures whose noise is known."""

import numpy as np
import pytest

pytest.importorskip("bpy")

from benchmarks import ordinary
from support.cases import release

pytestmark = release        # benchmarks are run for releases


def pictures(random, deviation):
    """Of 16, 64 and 256 samples of a grey of 0.5, with noise of a standard deviation at 64: (few, noisy, many)."""
    def of(samples, *shape):
        return 0.5 + deviation * np.sqrt(ordinary.SAMPLES / samples) * random.standard_normal((*shape, 60, 80, 3))

    return of(16), of(64, ordinary.SEEDS), of(256)


def test_noise_is_the_standard_deviation_over_the_mean(random):
    found = ordinary.figures(*pictures(random, 0.02))
    assert found.noise == pytest.approx(0.04, rel=0.02)
    assert found.median == pytest.approx(0.04, rel=0.05)
    assert found.below == (0, 0, 0)


def test_the_median_is_blind_to_a_few_noisy_pixels_and_the_root_mean_square_is_not(random):
    few, noisy, many = pictures(random, 0.02)
    noisy[:, :6] += 0.3 * random.standard_normal((ordinary.SEEDS, 6, 80, 3))
    found = ordinary.figures(few, noisy, many)
    assert found.median == pytest.approx(0.04, rel=0.1)
    assert found.noise == pytest.approx(np.sqrt(0.1) * 0.6, rel=0.05)


def test_specks_and_fireflies_are_counted_in_one_picture(random):
    few, noisy, many = pictures(random, 1e-3)
    few[1, 2, 0] = few[3, 4, 1] = -1
    noisy[0, 5, 6] = -0.25
    noisy[0, 20, 30] = 5
    found = ordinary.figures(few, noisy, many)
    assert found.below == (2, 1, 0)
    assert found.least == pytest.approx(-0.5, rel=0.01)
    # the mean of all samples has a part of the firefly itself: 64 of the samples of all pictures
    share = ordinary.SAMPLES / (ordinary.SEEDS * ordinary.SAMPLES + 256)
    assert found.largest == pytest.approx(5 / (0.5 + 4.5 * share), rel=0.02)


def test_outliers_are_counted_where_the_converged_picture_has_none(random):
    few, noisy, many = pictures(random, 1e-3)
    noisy[0, 10, 10], noisy[0, 20, 20], noisy[0, 30, 30:32] = 0.1, 2.0, 1.7
    # a dark line and a bright dot that all pictures have
    for each in (noisy[:, 40], many[40], noisy[:, 50, 50], many[50, 50]):
        each *= 0.1
    found = ordinary.figures(few, noisy, many)
    assert (found.dark, found.bright) == (1, 3)


@pytest.mark.parametrize("scene", ordinary.SCENES)
def test_each_scene_is_lit_and_seen(blender, scene):
    """A few samples of it in a white diffuse: most of the picture has light, and not all the same."""
    from support import stage

    def white(name):
        material, shader, surface = stage.blank_material(name, "ShaderNodeBsdfDiffuse")
        material.node_tree.links.new(shader.outputs[0], surface)
        return material

    opened = ordinary.build(scene, white)
    opened.render.resolution_percentage, opened.cycles.samples = 25, 8
    picture = stage.render(opened)[..., :3]
    assert (picture.max(axis=-1) > 1e-3).mean() > 0.7
    assert picture.std() > 0.1 * picture.mean()
