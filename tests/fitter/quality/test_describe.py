"""Descriptions and pictures of measurements, against values computed in other ways."""

import math
import re
import tracemalloc
from dataclasses import replace

import numpy as np
import pytest

import fitter
from fitter.arrays import unit_vectors
from fitter.cycles.principled import albedo
from fitter.imaging import pictures, plane_plot, studio
from fitter.imaging.plane_plot import Plotted
from fitter.methods import prior
from fitter.quality.describe import describe, open_questions

LAMBERTIAN = prior.lambertian(np.array([[0.5 / np.pi]]))


def angle(u, v):
    return math.degrees(math.acos(np.clip(u @ v, -1, 1)))


def nearest(samples, theta_i, theta_o, azimuth):
    """Distance of a pair of directions from the nearest sample or mirror image of one: degrees."""
    wi, wo = unit_vectors(theta_i, 0), unit_vectors(theta_o, azimuth)
    found = []
    for ti, pi, to, po in zip(*samples.directions, strict=True):
        for a, b in ((ti, to), (to, ti)):
            for side in (1, -1):
                found.append(max(angle(unit_vectors(a, 0), wi), angle(unit_vectors(b, side * (po - pi)), wo)))
    return min(found)


def every_distance(samples):
    """The widest hole of many samples, degrees, by spherical trigonometry: every probe against every sample."""
    probe_i, probe_o, probe_azimuth = (grid.ravel()[:, None] for grid in np.radians(
        np.meshgrid(range(10, 81, 10), range(10, 81, 10), range(0, 181, 15))))
    theta = np.concatenate([[samples.theta_i, samples.theta_o], [samples.theta_o, samples.theta_i]], axis=1)
    across = np.tile(samples.phi_o - samples.phi_i, 2)
    apart = np.full(len(probe_i), np.inf)
    for side in (1, -1):
        cosine = (np.cos(probe_o) * np.cos(theta[1])
                  + np.sin(probe_o) * np.sin(theta[1]) * np.cos(probe_azimuth - side * across))
        distance = np.maximum(np.abs(probe_i - theta[0]), np.arccos(np.clip(cosine, -1, 1)))
        apart = np.minimum(apart, distance.min(axis=1))
    return np.degrees(apart.max())


def crowds(random, kind, count):
    """Samples that mislead the shortcuts of the search."""
    angles = random.random((4, count)) * [[1.57], [9], [1.57], [9]]
    probes = np.radians([grid.ravel() for grid in np.meshgrid(range(10, 81, 10), 0, range(10, 81, 10),
                                                              range(0, 181, 15))])
    if kind == "all the same":
        angles[:] = 0.7
    elif kind == "one crowd":
        angles = 1 + 0.3 * angles / 9
    elif kind == "a crowd, and one sample at each probe but some":
        angles = np.concatenate([1 + 0.2 * angles / 9, probes[:, 40:]], axis=1)
    elif kind == "a crowd beside each probe":
        angles = probes[:, random.integers(probes.shape[1], size=count)] + random.normal(0.03, 0.01, (4, count))
    elif kind == "on the edges of a grid":
        angles = np.radians(6) * np.floor(random.random((4, count)) * [[16], [60], [16], [60]])
    angles[::2] = np.clip(angles[::2], 0, np.pi / 2)
    return fitter.Samples(*angles, np.ones((angles.shape[1], 1)))


@pytest.mark.parametrize("count", [1, 3, 500, 5000])
@pytest.mark.parametrize("kind", ["anywhere", "all the same", "one crowd", "a crowd beside each probe",
                                  "a crowd, and one sample at each probe but some", "on the edges of a grid"])
def test_the_widest_hole_is_found_among_any_samples(random, kind, count):
    samples = crowds(random, kind, count)
    description = describe(samples)
    assert description.gap == pytest.approx(every_distance(samples), abs=1e-5)
    if len(samples) < 500:
        assert nearest(samples, *np.radians(description.gap_at)) == pytest.approx(description.gap, abs=1e-5)


def every_distance_of_anisotropic(samples):
    """The widest hole, degrees, by every probe against every sample and its reciprocal."""
    probes = np.array([unit_vectors(theta, phi) for theta in np.radians(range(10, 81, 10))
                       for phi in np.radians(range(0, 360, 30))])
    sides = [np.array([unit_vectors(*angles) for angles in zip(theta, phi, strict=True)])
             for theta, phi in ((samples.theta_i, samples.phi_i), (samples.theta_o, samples.phi_o))]
    nearest = np.full((len(probes), len(probes)), 180.0)
    for incident, outgoing in (sides, sides[::-1]):
        for wi, wo in zip(incident, outgoing, strict=True):
            away = [np.degrees(np.arccos(np.clip(probes @ w, -1, 1))) for w in (wi, wo)]
            nearest = np.minimum(nearest, np.maximum(away[0][:, None], away[1][None, :]))
    return nearest.max()


@pytest.mark.parametrize("incidences", [1, 7, 400])
def test_the_widest_hole_of_an_anisotropic_material_is_where_brute_force_finds_it(random, incidences):
    which = random.integers(0, incidences, 400)
    theta_i, phi_i = random.random((2, incidences)) * [[1.4], [6.2]]
    samples = fitter.Samples(theta_i[which], phi_i[which], 1.4 * random.random(400), 6.2 * random.random(400),
                             np.ones((400, 1)), isotropic=False)
    description = describe(samples)
    assert description.gap == pytest.approx(every_distance_of_anisotropic(samples), abs=1e-5)
    theta_i, theta_o, apart, phi_i = np.radians(description.gap_at)
    wi, wo = unit_vectors(theta_i, phi_i), unit_vectors(theta_o, phi_i + apart)
    distances = [max(angle(unit_vectors(*i), wi), angle(unit_vectors(*o), wo)) for ti, pi, to, po in
                 zip(*samples.directions, strict=True) for i, o in (((ti, pi), (to, po)), ((to, po), (ti, pi)))]
    assert min(distances) == pytest.approx(description.gap, abs=1e-5)


def test_very_many_directions_of_incidence_are_told_apart_to_three_degrees(random):
    angles = random.random((4, 3000)) * [[1.4], [6.3], [1.4], [6.3]]
    samples = fitter.Samples(*angles, np.ones((3000, 1)), isotropic=False)
    assert describe(samples).gap == pytest.approx(every_distance_of_anisotropic(samples), abs=3)


def test_it_says_whether_a_material_is_isotropic_and_at_how_many_rotations():
    turned = fitter.Samples([0.5] * 3, np.radians([0, 45, 90]), [0.5] * 3, [1.0] * 3, np.ones((3, 1)), isotropic=False)
    rows = {label: text for label, text, _ in describe(turned).rows()}
    assert rows["Material"] == "anisotropic, given at 3 rotations from 0° to 90°"
    assert re.fullmatch(r"\d+° at 80° in, 80° out, \d+° around, turned by \d+°", rows["Widest hole"])
    rows = {label: text for label, text, _ in describe(replace(turned, isotropic=True)).rows()}
    assert rows["Material"] == "isotropic"
    assert "turned" not in rows["Widest hole"]


def test_a_description_takes_a_few_times_the_memory_of_its_samples(random):
    angles = random.random((4, 300_000)) * [[1.57], [6], [1.57], [6]]
    samples = fitter.Samples(*angles, random.random((300_000, 3)), ("R", "G", "B"))
    tracemalloc.start()
    describe(samples)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 2 * (angles.nbytes + samples.values.nbytes)


def test_azimuths_may_be_of_many_turns():
    samples = fitter.Samples([1.0], [-1e6], [1.0], [1e6], [[1.0]])
    assert 0 <= describe(samples).gap <= 180


def test_negative_and_saturated_values_are_counted(glossy):
    values = glossy.values.copy()
    values[:7, 0] = -0.01
    values[:3, 1] = values.max() + 1
    description = describe(replace(glossy, values=values))
    assert (description.negative, description.saturated) == (7, 3)
    assert describe(glossy).saturated == 0
    assert describe(replace(glossy, saturated=np.arange(len(glossy)) < 5)).saturated == 15
    assert description.count == len(glossy)
    assert description.highest[1] == pytest.approx(values.max())
    worrying = {label for label, _, worry in description.rows() if worry}
    assert worrying == {"Negative", "Saturated"}


def test_overflowed_pixels_are_known_from_the_files_beside(data, tmp_path):
    row = (data / "curet" / "abrdf.dat").read_text().splitlines()[0]
    (tmp_path / "abrdf.dat").write_text(row)
    assert fitter.load(tmp_path / "abrdf.dat").saturated is None
    shares = np.zeros(205)
    shares[[3, 77]] = 0.2
    (tmp_path / "gover.dat").write_text("1 " + " ".join(map(str, shares)))
    samples = fitter.load(tmp_path / "abrdf.dat")
    assert np.flatnonzero(samples.saturated).tolist() == [3, 77]
    assert describe(samples).saturated >= 2


class Glossy:
    """A reflectance in closed form, with the `evaluate` of a fit."""

    def evaluate(self, theta_i, phi_i, theta_o, phi_o):
        cosine = np.cos(theta_i) * np.cos(theta_o) - np.sin(theta_i) * np.sin(theta_o) * np.cos(phi_o - phi_i)
        return (0.1 + np.maximum(cosine, 0) ** 6)[..., None] * np.array([1.0, 0.5, 0.25]) / np.pi


def test_albedo_is_the_integral_over_both_hemispheres(random):
    n = 400_000
    theta_i, theta_o = np.arcsin(np.sqrt(random.random((2, n))))        # cosine-weighted
    brute = np.pi * Glossy().evaluate(theta_i, np.zeros(n), theta_o, random.random(n) * 2 * np.pi).mean(axis=0)
    np.testing.assert_allclose(albedo(Glossy()), brute, rtol=0.01)


def test_the_lit_sphere_of_a_lambertian_follows_the_cosine():
    picture = pictures.lit_sphere(LAMBERTIAN, 101)
    assert picture[0, 0, 3] == 0                                        # around the sphere
    assert picture[50, 50, 3] == 1
    n = 400_000
    z, azimuth = np.sqrt((np.arange(n) + 0.5) / n), np.arange(n) * math.pi * (3 - math.sqrt(5))     # cosine-weighted
    toward = np.stack([np.sqrt(1 - z ** 2) * np.cos(azimuth), np.sqrt(1 - z ** 2) * np.sin(azimuth), z], axis=-1)
    expected = studio.tone_map(np.full((1, 3), studio.radiance(toward).mean() / 2))[0, 0]
    assert picture[50, 50, 0] == pytest.approx(pictures.srgb(np.array(expected)), abs=0.01)
    assert picture[70, 30, 0] > picture[30, 30, 0]                      # the key light is at the upper left


def test_the_polar_plot_of_a_lambertian_is_a_half_circle_with_the_samples_on_it():
    theta = np.radians([10, 40, 70])
    samples = fitter.Samples(np.full(3, 0.7), np.zeros(3), theta, np.full(3, np.pi), np.full((3, 1), 0.5 / np.pi))
    picture, shown = plane_plot.polar_plot([Plotted(LAMBERTIAN)], samples, 0.6, 200)
    assert shown == pytest.approx(0.7)
    disc = plane_plot.picture_disc(200)
    for angle_from_normal in np.radians([-80, -45, 0, 45, 80]):
        x, y = disc.points(angle_from_normal, 1.0).astype(int)
        assert picture[y - 1:y + 2, x - 1:x + 2, 0].max() > 0.7
    assert np.all(picture[..., 3] == 1)


def test_without_samples_near_the_plane_the_plot_shows_none():
    samples = fitter.Samples([0.7], [0.0], [0.7], [np.pi / 2], [[1.0]])
    assert math.isnan(plane_plot.polar_plot([Plotted(LAMBERTIAN)], samples, 0.6, 64)[1])


@pytest.mark.parametrize(("degrees", "guessed"), [(80, "beyond 80°, where nothing was measured"), (89.5, None)])
def test_it_says_from_which_angle_on_a_fit_is_a_guess(degrees, guessed):
    theta = np.radians(np.linspace(0, degrees, 20))
    description = describe(fitter.Samples(0.5 * theta, 0 * theta, theta, 0 * theta, np.ones((20, 1))))
    assert {label: text for label, text, _ in description.rows()}.get("Guessed") == guessed


@pytest.mark.parametrize(("values", "asked"), [
    (np.array([[0.0, 0.1, 0.2], [0.0, 0.2, 0.1]]), "No value of R is above 0: was it measured?"),
    (np.array([[-999.0, 0.1, 0.2], [0.1, 0.2, 0.1]]), "Values down to -999 / sr, farther below 0 than any is above: do "
                                                      "they mark what was not measured?"),
    (np.array([[-0.05, 0.1, 0.2], [0.1, 0.2, 0.1]]), None)], ids=["dead channel", "mark", "noise"])
def test_values_that_were_not_measured_are_asked_about_before_and_after_a_fit(values, asked):
    samples = fitter.Samples([0.1, 0.6], [0, 0], [0.5, 0.2], [0, 3], values, ("R", "G", "B"), "scan")
    assert [row for row in describe(samples).rows() if row[0] == "Values"] == [("Values", asked, True)] * bool(asked)
    assert open_questions(samples) == (f"scan: {asked}",) * bool(asked)
