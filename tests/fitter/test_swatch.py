"""Pictures of published materials: what the sphere shows is the integral of the model over the surroundings."""

import numpy as np
import pytest

from fitter import published, swatch
from fitter.model.low2012 import Low2012
from support.cases import quick


def white(direction):
    return np.ones(direction.shape[:-1])


def reflected(model, tilt, light, steps=1500):
    """The radiance of a surface tilted by an angle to the view, by the midpoint rule over half vectors' angles."""
    cos_i = (np.arange(steps) + 0.5) / steps
    phi = (np.arange(steps) + 0.5) / steps * 2 * np.pi
    theta_i, phi_i = np.meshgrid(np.arccos(cos_i), phi, indexing="ij")
    f = model.evaluate(theta_i, phi_i, np.full_like(theta_i, tilt), np.zeros_like(theta_i))
    # the surface's frame, with the view in its x-z plane; light is asked for in the view's frame
    x, z = np.sin(theta_i) * np.cos(phi_i), np.cos(theta_i)
    y = np.sin(theta_i) * np.sin(phi_i)
    seen = np.stack([x * np.cos(tilt) - z * np.sin(tilt), y, x * np.sin(tilt) + z * np.cos(tilt)], axis=-1)
    return (f * (cos_i[:, None] * light(seen))[..., None]).mean(axis=(0, 1)) * 2 * np.pi


@pytest.mark.parametrize("name", quick(
    ["red-plastic", "nickel", "light-red-paint", "silver-paint"], "red-plastic"))
@pytest.mark.parametrize("tilt", [0.2, 0.7, 1.1])
def test_light_from_everywhere_gives_the_albedo(name, tilt):
    model = published.find(name).model
    normal = np.array([[-np.sin(tilt), 0, np.cos(tilt)]])
    found = swatch.radiance(model, normal, white)[0]
    np.testing.assert_allclose(found, reflected(model, tilt, white), rtol=0.04)


def test_a_lambertian_shows_the_irradiance_of_a_light_from_one_half():
    model = Low2012(np.array([0.5, 0.4, 0.3]), np.zeros(3), 100.0, 1.5, 1.5)
    radiance = swatch.radiance(model, np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]), lambda way: (way[..., 1] > 0) * 2.0)
    np.testing.assert_allclose(radiance, np.outer([2.0, 1.0], model.kd), rtol=0.02)


def test_a_narrow_lobe_mirrors_the_surroundings():
    model = Low2012(np.zeros(3), np.full(3, 1e6), 1e6, 3.0, 99.0)
    half = np.radians(20)
    normal = np.array([[0.0, np.sin(half), np.cos(half)]])          # mirrors what is 40 degrees up
    light = lambda way: (np.arcsin(np.clip(way[..., 1], -1, 1)) > np.radians(41)) * 1.0      # noqa: E731
    assert swatch.radiance(model, normal, light).max() < 1e-3
    assert swatch.radiance(model, normal, lambda way: 1 - light(way)).min() > 0.5


def test_a_swatch_is_a_sphere_on_a_transparent_background():
    picture = swatch.swatch(published.find("gold-paint").model, 48)
    assert picture.shape == (48, 48, 4)
    assert picture.dtype == np.float32
    assert picture[0, 0, 3] == 0
    assert picture[24, 24, 3] == 1
    red, green, blue = picture[24, 24, :3]
    assert red > green > blue
