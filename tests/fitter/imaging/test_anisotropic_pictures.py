"""Pictures and albedos of anisotropic materials, against loops over pixels and integrals."""

import numpy as np

from fitter.cycles.principled import albedo as albedo_of
from fitter.imaging import pictures, plane_plot
from fitter.imaging.plane_plot import Plotted
from fitter.quality import physics
from fitter.samples import RGB, Samples
from support.anisotropic import brushed_fit, rotations
from support.spheres import reflected_by_lamps

FIT = brushed_fit()


def test_a_sphere_under_a_lamp_has_its_tangent_about_the_vertical_axis():
    """One pixel at a time, with angles from vectors."""
    light = np.array([0.3, 0.5, 0.8]) / np.linalg.norm([0.3, 0.5, 0.8])
    random = np.random.default_rng(3)
    normals = random.standard_normal((40, 3))
    normals[:, 2] = np.abs(normals[:, 2])
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    radiance = reflected_by_lamps(FIT, normals, [(light, 1 / np.pi)])
    for n, value in zip(normals, radiance, strict=True):
        t = np.cross([0, 1, 0], n)
        t /= np.linalg.norm(t)
        b = np.cross(n, t)
        angles = [(np.arccos(w @ n), np.arctan2(w @ b, w @ t)) for w in (light, np.array([0, 0, 1.0]))]
        expected = FIT.evaluate(*angles[0], *angles[1]) * max(light @ n, 0) if light @ n > 0 else np.zeros(3)
        np.testing.assert_allclose(value, expected, rtol=1e-6)


def test_the_tangent_is_drawn_on_anisotropic_spheres_alone():
    plain, drawn = (pictures.lit_sphere(FIT, 64, with_tangent=with_tangent) for with_tangent in (False, True))
    assert (plain != drawn).any()
    isotropic = brushed_fit(0.2, 0.2)
    np.testing.assert_array_equal(pictures.lit_sphere(isotropic, 64), pictures.lit_sphere(isotropic, 64,
                                                                                          with_tangent=True))


def test_the_turned_plane_shows_the_light_from_every_azimuth():
    size, theta_i = 36, 0.6
    picture = plane_plot.turned_plane(FIT, theta_i, size)
    expected = np.empty((size, size, 3))
    for row in range(size):
        for column in range(size):
            theta, phi = np.pi * ((row + 0.5) / size - 0.5), 2 * np.pi * (column + 0.5) / size
            phi_o = phi + (0 if theta < 0 else np.pi)
            expected[row, column] = FIT.evaluate(theta_i, phi, abs(theta), phi_o) * np.cos(theta)
    np.testing.assert_allclose(picture[..., :3], np.cbrt(expected) / np.cbrt(expected).max(), rtol=1e-5)
    assert np.ptp(picture[:, :, 0], axis=1).max() > 0.2


def test_the_polar_plot_shows_the_samples_of_its_azimuth():
    directions = rotations(4)
    samples = Samples(*directions, FIT.evaluate(*directions), RGB, isotropic=False)
    ways = [plane_plot.polar_plot([Plotted(FIT)], samples, np.radians(30), 96, phi_i)[0] for phi_i in (0.0, np.pi / 2)]
    assert np.abs(ways[0] - ways[1]).max() > 0.3


def test_directional_albedo_depends_on_the_azimuth_and_integrates_the_whole_turn():
    found = [physics.directional_albedo(FIT, 1.0, phi_o=phi_o)[0] for phi_o in (0.3, 1.9)]
    random = np.random.default_rng(8)
    u, turn = random.random((2, 400_000))
    theta = np.arcsin(np.sqrt(u))
    for phi_o, albedo in zip((0.3, 1.9), found, strict=True):
        expected = np.pi * FIT.evaluate(theta, 2 * np.pi * turn, 1.0, phi_o).mean(axis=0)
        np.testing.assert_allclose(albedo, expected, rtol=0.004)
    assert np.abs(found[0] / found[1] - 1).max() > 0.005


def test_the_albedo_is_over_all_azimuths():
    random = np.random.default_rng(9)
    u_i, u_o, turn_i, turn_o = random.random((4, 1_000_000))
    value = FIT.evaluate(np.arcsin(np.sqrt(u_i)), 2 * np.pi * turn_i, np.arcsin(np.sqrt(u_o)), 2 * np.pi * turn_o)
    np.testing.assert_allclose(albedo_of(FIT), np.pi * value.mean(axis=0), rtol=0.02)
