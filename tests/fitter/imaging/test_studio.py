"""Thumbnails: what a sphere shows of the studio, against random directions, and how bright they are."""

import numpy as np
import pytest

from fitter.imaging import studio
from fitter.imaging.pictures import draw_sphere, lit_cloth, lit_sphere, sphere, thumbnail
from fitter.model import is_isotropic, published
from support.cases import quick

BLACK = {"black-fabric", "black-obsidian", "black-phenolic", "black-soft-plastic", "silicon-nitrade",
         "specular-black-phenolic", "special-walnut-224"}


def by_random_directions(model, normal, random, count=200_000, sky=studio.radiance):
    """Half of the directions about the normal by their cosine, half by a lobe of half vectors: one estimate of both."""
    tangent = np.cross([0, 1, 0], normal)
    tangent /= np.linalg.norm(tangent)
    frame = np.stack([tangent, np.cross(normal, tangent), normal])
    view = frame @ np.array([0, 0, 1.0])
    z, azimuth = np.sqrt(random.random(count)), random.random(count) * 2 * np.pi
    even = np.stack([np.sqrt(1 - z ** 2) * np.cos(azimuth), np.sqrt(1 - z ** 2) * np.sin(azimuth), z], axis=-1)
    u, width = random.random(count), 0.15
    slope = width * np.sqrt(u / (1 - u))
    h = np.stack([slope * np.cos(azimuth), slope * np.sin(azimuth), np.ones(count)], axis=-1)
    h /= np.linalg.norm(h, axis=1)[:, None]
    mirrored = 2 * (h @ view)[:, None] * h - view
    light = np.concatenate([even, mirrored])
    light = light[light[:, 2] > 1e-6]
    h = light + view
    h /= np.linalg.norm(h, axis=1)[:, None]
    slope2 = (1 - h[:, 2] ** 2) / h[:, 2] ** 2
    density = (light[:, 2] / np.pi + 1 / (np.pi * width ** 2 * h[:, 2] ** 3 * (1 + slope2 / width ** 2) ** 2)
               / (4 * h @ view)) / 2
    value = model.evaluate(np.arccos(np.minimum(light[:, 2], 1)), np.arctan2(light[:, 1], light[:, 0]),
                           np.arccos(view[2]), np.arctan2(view[1], view[0]))
    return (value * (light[:, 2] * sky(light @ frame) / density)[:, None]).sum(axis=0) / (2 * count)


@pytest.mark.parametrize("name", ["white-paint", "red-fabric", "copper-satin", "gold-brushed"])
def test_a_sphere_shows_the_integral_over_the_studio(name, random):
    model = published.find(name).model
    normals = np.array([[0.05, 0.02, 1], [0.4, -0.5, 0.7], [-0.3, 0.3, 0.9], [0.7, 0.2, 0.5], [-0.2, 0.8, 0.4]])
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    expected = np.stack([by_random_directions(model, normal, random) for normal in normals])
    found = studio.on_sphere(model, normals)
    assert found == pytest.approx(expected, rel=0.04 if is_isotropic(model) else 0.12, abs=0.004)


def test_a_polished_metal_shows_the_window():
    picture = lit_sphere(published.find("gold-polished").model, 96)[::-1]       # the top row first
    at = np.unravel_index(picture[..., 1].argmax(), picture.shape[:2])
    half = np.array([-0.5, 0.6, 0.62]) / np.linalg.norm([-0.5, 0.6, 0.62]) + [0, 0, 1]      # where it is mirrored
    half /= np.linalg.norm(half)
    place = np.array([48 - 48 * half[1], 48 + 48 * half[0]])
    assert np.abs(place - at).max() < 10
    assert picture[tuple(place.round().astype(int))][0] == pytest.approx(1, abs=0.1)
    assert picture[72, 48, 0] > picture[58, 48, 0]          # light from below


@pytest.mark.parametrize("name", quick([each.name for each in published.list_offered()], "gold-polished",
                                       "silver-rough", "white-paint", "black-obsidian", "dark-blue-paint",
                                       "red-fabric"))
def test_pictures_of_the_library_are_neither_black_nor_white(name):
    """The mean of the displayed values within the sphere."""
    picture = thumbnail(published.find(name), 48)
    mean = (picture[..., :3].mean(axis=-1) * picture[..., 3]).sum() / picture[..., 3].sum()
    assert (0.06 if name in BLACK else 0.15) < mean < 0.6


def test_a_cloth_shows_its_folds_and_its_colour():
    model = published.find("red-fabric").model
    picture = lit_cloth(model, 96)
    assert picture[0, 0, 3] == 0
    assert picture[48, 48, 3] == 1
    cloth, ball = (each[each[..., 3] == 1][:, :3].astype(float) ** 2.2 for each in (picture, lit_sphere(model, 96)))
    hue, expected = (each.mean(axis=0) / each.mean() for each in (cloth, ball))
    assert hue == pytest.approx(expected, rel=0.1)
    row = picture[48, 10:86, 0]
    assert ((row[1:-1] > row[:-2]) & (row[1:-1] > row[2:])).sum() >= 2     # lit folds
    assert np.ptp(row) > 0.1


@pytest.mark.parametrize("size", [16, 64, 256])
def test_the_edge_of_a_sphere_has_its_colour_and_not_that_of_nothing(size):
    """All that is covered has the one colour, also pixels that are covered by a tenth."""
    normal, _, _ = sphere(size)
    picture = draw_sphere(np.full((len(normal), 3), 0.7), size)
    np.testing.assert_allclose(picture[picture[..., 3] > 0, :3], 0.7, rtol=1e-6)
