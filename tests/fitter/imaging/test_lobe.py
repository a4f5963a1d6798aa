"""The lobe of a reflectance as a mesh, against formulas, quadrature and a search."""

import numpy as np
import pytest

from fitter.arrays import unit_vectors
from fitter.imaging import lobe
from fitter.model.microfacet import Microfacet
from support.anisotropic import brushed_fit

INCIDENCES = [0.0, 1e-4, 0.3, np.radians(40), np.radians(75), np.radians(89)]


def one_lobe(alpha):
    """A Lambertian of albedo .2 and a mirror lobe of this roughness."""
    return Microfacet(np.array([0.2 / np.pi]), np.array([[0.1 / alpha ** 2]]), np.array([alpha]), np.array([2.0]),
                      np.array([0.9]))


class Tilted:
    """f = (1 + sin theta_o cos(phi_o - 1)) / 2, in two channels: (2, 4) f."""

    def evaluate(self, theta_i, phi_i, theta_o, phi_o):
        f = (1 + np.sin(theta_o) * np.cos(phi_o - 1)) / 2
        return f[..., None] * [2.0, 4.0]


def angles(directions):
    return np.arccos(np.clip(directions[:, 2], -1, 1)), np.arctan2(directions[:, 1], directions[:, 0])


def solid_angles(directions, faces):
    """A. van Oosterom, J. Strackee: The Solid Angle of a Plane Triangle, 1983."""
    a, b, c = (directions[faces[:, k]] for k in range(3))
    volume = np.einsum("ij,ij->i", a, np.cross(b, c))
    dots = [np.einsum("ij,ij->i", u, v) for u, v in ((a, b), (b, c), (c, a))]
    return 2 * np.arctan2(volume, 1 + sum(dots))


@pytest.mark.parametrize("theta_i", INCIDENCES)
def test_the_mesh_covers_the_hemisphere_once(theta_i):
    surface = lobe.lobe_surface(Tilted(), theta_i, 0.7)
    np.testing.assert_allclose(np.linalg.norm(surface.directions, axis=1), 1)
    sizes = solid_angles(surface.directions, surface.faces)
    assert sizes.min() > -1e-9, "no face is turned over"
    assert sizes.sum() == pytest.approx(2 * np.pi, rel=1e-2), "the horizon is a polygon"
    assert surface.directions[0].tolist() == [0, 0, 1]
    np.testing.assert_allclose(surface.directions[-128:, 2], 0, atol=1e-15)
    gaps = solid_angles(surface.directions, surface.faces).max()
    assert gaps < 0.01, "nowhere more than six degrees apart"


@pytest.mark.parametrize(("radius", "root"), [("cube root", 1 / 3), ("linear", 1.0)])
def test_a_vertex_is_as_far_out_as_the_mean_of_its_channels_says(radius, root):
    surface = lobe.lobe_surface(Tilted(), 0.5, 0.2, radius=radius)
    theta, phi = angles(surface.directions)
    expected = 1.5 * (1 + np.sin(theta) * np.cos(phi - 1))
    np.testing.assert_allclose(surface.values[:, 1], 2 * surface.values[:, 0])
    np.testing.assert_allclose(np.linalg.norm(surface.vertices, axis=1), expected ** root, rtol=1e-6)


def test_values_below_zero_have_no_radius():
    class Negative:
        def evaluate(self, theta_i, phi_i, theta_o, phi_o):
            return np.cos(2 * theta_o)[..., None]

    surface = lobe.lobe_surface(Negative(), 0.5)
    low = surface.directions[:, 2] < 0.7
    assert np.abs(surface.vertices[low]).max() == 0
    np.testing.assert_allclose(surface.normals[-1], surface.directions[-1])
    assert np.isfinite(surface.normals).all()


@pytest.mark.parametrize("alpha", [0.004, 0.02, 0.3])
@pytest.mark.parametrize("theta_i", INCIDENCES[:-1])
def test_a_narrow_highlight_is_met_and_has_its_energy(alpha, theta_i):
    model = one_lobe(alpha)
    surface = lobe.lobe_surface(model, theta_i, 2.0)
    near = theta_i + np.linspace(-5, 5, 4001) * alpha
    near = near[(near >= 0) & (near < np.pi / 2)]
    peak = model.evaluate(np.full(len(near), theta_i), 0 * near, near, np.full(len(near), np.pi)).max()
    assert surface.values.max() > 0.98 * peak
    # the same integral, over half vectors: theta_h on a grid that knows the roughness
    sizes = solid_angles(surface.directions, surface.faces)
    there = (surface.values[:, 0] * surface.directions[:, 2])[surface.faces].mean(axis=1)
    assert there @ sizes == pytest.approx(albedo_by_half_vectors(model, alpha, theta_i), rel=0.06)


def albedo_by_half_vectors(model, alpha, theta_i):
    """The integral of f cos theta_o by half vectors: d w_o = 4 (w_i h) d h."""
    edges = np.arctan(alpha * np.tan(np.linspace(0, np.arctan(np.tan(1.57) / alpha), 1201)))
    theta_h = (edges[1:] + edges[:-1]) / 2
    phi_h = (np.arange(720) + 0.5) * np.pi / 360
    theta, phi = np.meshgrid(theta_h, phi_h, indexing="ij")
    h, wi = unit_vectors(theta, phi), unit_vectors(theta_i, 0.0)
    cosine = h @ wi
    wo = 2 * cosine[..., None] * h - wi
    up = (wo[..., 2] > 0) & (cosine > 0)
    wo, cosine = wo[up], cosine[up]
    f = model.evaluate(np.full(len(wo), theta_i), np.zeros(len(wo)), *angles(wo))[:, 0]
    size = (np.broadcast_to((np.cos(edges[:-1]) - np.cos(edges[1:]))[:, None], theta.shape) * np.pi / 360)[up]
    return (f * wo[:, 2] * 4 * cosine * size).sum()


@pytest.mark.parametrize("theta_i", [0.0, 0.6, 1.4])
def test_normals_are_those_of_the_faces_and_point_outward(theta_i):
    surface = lobe.lobe_surface(one_lobe(0.3), theta_i, -1.0)
    a, b, c = (surface.vertices[surface.faces[:, k]] for k in range(3))
    faces = np.cross(b - a, c - a)
    area = np.linalg.norm(faces, axis=1)
    large = area > 1e-3 * area.max()
    faces = faces[large] / area[large, None]
    corners = surface.normals[surface.faces[large]]
    np.testing.assert_allclose(np.linalg.norm(surface.normals, axis=1), 1)
    assert np.einsum("ij,ikj->ik", faces, corners).min() > 0.8
    assert np.einsum("ij,ij->i", surface.normals, surface.directions).min() > 0


def test_the_plane_of_incidence_has_the_light_on_its_negative_side():
    fit = brushed_fit()
    theta, values = lobe.plane_curve(fit, 0.6, 0.4)
    assert theta[0] == -np.pi / 2
    assert theta[-1] == np.pi / 2
    assert (np.diff(theta) >= 0).all()
    assert np.abs(theta - 0.6).min() < 1e-12
    for number in (3, 60, 120, 180, 230):
        towards = 0.4 if theta[number] < 0 else 0.4 + np.pi
        np.testing.assert_allclose(values[number], fit.evaluate(0.6, 0.4, abs(theta[number]), towards), rtol=1e-9)


def test_the_plane_of_incidence_meets_a_narrow_highlight():
    model = one_lobe(0.004)
    theta, values = lobe.plane_curve(model, 0.9)
    dense = np.linspace(0.8, 1.0, 200001)
    sought = model.evaluate(np.full(len(dense), 0.9), 0 * dense, dense, np.full(len(dense), np.pi))
    assert values.max() == pytest.approx(sought.max(), rel=0.02)
    assert (np.abs(theta - 0.9) < 0.01).sum() > 10
