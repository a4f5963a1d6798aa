"""Metals by their optical constants: the formula against integrals of its own, and fits against the formula."""

import csv
from functools import cache

import numpy as np
import pytest

from fitter.formats.spectra import srgb_weights
from fitter.library import ready
from fitter.model import published
from fitter.model.conductor import Conductor
from support.cases import quick

# normal reflectance as handbooks have it (G. W. C. Kaye, T. H. Laby: Tables of Physical and Chemical Constants, and the
# sources of metals.csv), in red and blue light, to the first digit that measurements agree on
KNOWN = {"gold": (1.0, 0.36), "silver": (0.98, 0.97), "copper": (0.94, 0.52), "aluminium": (0.91, 0.92),
         "chromium": (0.65, 0.67), "iron": (0.54, 0.5), "nickel": (0.68, 0.57), "tungsten": (0.51, 0.48),
         "zinc": (0.74, 0.74), "platinum": (0.68, 0.59), "titanium": (0.61, 0.55), "brass": (0.91, 0.42)}
METALS = [f"{name}-polished" for name in KNOWN]
OTHERS = ["gold-satin", "gold-rough", "copper-rough", "tungsten-rough", "aluminium-satin"]


def table():
    with open(published._DATA / "metals_nk.csv", encoding="utf-8", newline="") as stream:
        rows = [*csv.reader(line for line in stream if not line.startswith("#"))]
    wavelengths = np.array(rows[0][2:], float)
    return wavelengths, {tuple(row[:2]): np.array(row[2:], float) for row in rows[1:]}


def reflectance(n, k, cosine):
    """Fresnel's equations without complex numbers (M. Born, E. Wolf: Principles of Optics, section 13.4)."""
    sine2 = 1 - cosine ** 2
    inner = n ** 2 - k ** 2 - sine2
    both = np.sqrt(inner ** 2 + 4 * n ** 2 * k ** 2)
    a = np.sqrt((both + inner) / 2)
    s = (both - 2 * a * cosine + cosine ** 2) / (both + 2 * a * cosine + cosine ** 2)
    tangent = np.sqrt(sine2) * np.sqrt(sine2) / cosine
    p = s * (both - 2 * a * tangent + tangent ** 2) / (both + 2 * a * tangent + tangent ** 2)
    return (s + p) / 2


def integrated(value, alpha, across, theta, phi=0.0, steps=400):
    """The reflected share of light from (theta, phi): over microfacets, whose density GGX has, toward grazing finer.

    `value` is the BRDF of (wi, wo), (..., 3) each.
    """
    t, v = np.meshgrid((np.arange(steps) + 0.5) / steps, 2 * np.pi * (np.arange(steps) + 0.5) / steps)
    u = 1 - (1 - t) ** 3
    slope = np.sqrt(u / (1 - u))
    h = np.stack([-alpha * slope * np.cos(v), -across * slope * np.sin(v), np.ones_like(v)], axis=-1)
    h /= np.linalg.norm(h, axis=-1, keepdims=True)
    wo = np.array([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])
    cos_d = h @ wo
    wi = 2 * cos_d[..., None] * h - wo
    seen = (cos_d > 1e-9) & (wi[..., 2] > 1e-9)
    density = 1 / (np.pi * alpha * across * h[..., 2] ** 3 * (1 + slope ** 2) ** 2)
    weight = 3 * (1 - t) ** 2 * 4 * cos_d / density
    f = value(wi[seen], np.broadcast_to(wo, wi[seen].shape), h[seen], cos_d[seen])
    return (f * (wi[..., 2] * weight)[seen][:, None]).sum(axis=0) / steps ** 2


def of_angles(model):
    """A model or a fit as a function of vectors."""
    def value(wi, wo, _h, _cos_d):
        return model.evaluate(np.arccos(np.minimum(wi[:, 2], 1)), np.arctan2(wi[:, 1], wi[:, 0]),
                              np.arccos(np.minimum(wo[:, 2], 1)), np.arctan2(wo[:, 1], wo[:, 0]))
    return value


def colour(name, cosines):
    """Fresnel's equations at each wavelength, made linear Rec.709: (n, 3)."""
    wavelengths, numbers = table()
    n, k = (numbers[name.rsplit("-", 1)[0], quantity] for quantity in "nk")
    return np.clip(reflectance(n, k, cosines[:, None]) @ srgb_weights(wavelengths).T, None, 1)


def test_weights_in_the_table_are_those_of_spectra():
    wavelengths, numbers = table()
    weights = np.array([numbers["weight", channel] for channel in "rgb"])
    np.testing.assert_allclose(weights, srgb_weights(wavelengths), rtol=1e-5, atol=1e-8)


@pytest.mark.parametrize("name", KNOWN)
def test_the_colour_of_a_metal_is_that_of_handbooks(name):
    model = published.find(f"{name}-polished").model
    red, _, blue = model.fresnel(np.ones(1))[0]
    assert (red, blue) == pytest.approx(KNOWN[name], abs=0.02)


@pytest.mark.parametrize(("alpha", "across"), [(0.04, 0.04), (0.15, 0.15), (0.35, 0.35), (0.08, 0.3)])
def test_a_metal_without_losses_reflects_all_light(alpha, across):
    white = Conductor(np.array([1e-9]), np.array([1e6]), np.ones((3, 1)), alpha, across)
    for theta in np.radians((0, 45, 70, 80)):
        for phi in (0.0, 1.0, np.pi / 2):
            assert integrated(of_angles(white), alpha, across, theta, phi) == pytest.approx(np.ones(3), abs=3e-3)


def grey(widths, wi, wo, h, _cos_d):
    """GGX where F is 1."""
    alpha, across = widths
    stretch = np.array([alpha, across, 1])
    density = 1 / (np.pi * alpha * across * ((h / stretch) ** 2).sum(axis=1) ** 2)
    long_i, long_o = (np.linalg.norm(w * stretch, axis=1) for w in (wi, wo))
    return np.broadcast_to((density * 0.5 / (wi[:, 2] * long_o + wo[:, 2] * long_i))[:, None], (len(wi), 3))


def albedo_of_one(widths, theta, phi):
    """The directional albedo of single reflection by a white metal."""
    return integrated(lambda *each: grey(widths, *each), *widths, theta, phi)[0]


@cache
def mean_albedo(widths):
    """`albedo_of_one` over the hemisphere, by Gauss-Legendre quadrature."""
    nodes, weights = (np.polynomial.legendre.leggauss(12)[0] + 1) / 2, np.polynomial.legendre.leggauss(12)[1] / 2
    azimuths = (0.0,) if widths[0] == widths[1] else (np.arange(4) + 0.5) * np.pi / 8
    return sum(2 * x * w * np.mean([albedo_of_one(widths, np.arccos(x), azimuth) for azimuth in azimuths])
               for x, w in zip(nodes, weights, strict=True))


def truth(name, theta, phi=0.0):
    """What is reflected in all: light of one reflection, integrated, and what that loses times the colour of further
    bounces (Kulla and Conty 2017), of means over the hemisphere, integrated too."""
    widths, cosines = published.FINISHES[name.rsplit("-", 1)[1]], (np.arange(4000) + 0.5) / 4000
    colours = colour(name, cosines)

    def single(wi, wo, h, cos_d):
        fresnel = np.stack([np.interp(cos_d, cosines, each) for each in colours.T], axis=-1)
        return grey(widths, wi, wo, h, cos_d) * fresnel

    mean_e, mean_f = mean_albedo(widths), (2 * cosines) @ colours / 4000
    more = mean_f ** 2 * mean_e / (1 - mean_f * (1 - mean_e))
    return integrated(single, *widths, theta, phi) + (1 - albedo_of_one(widths, theta, phi)) * more


@pytest.mark.parametrize("name", ["gold-satin", "iron-rough", "brass-brushed"])
def test_a_metal_reflects_one_bounce_and_what_that_loses_times_the_colour_of_more(name):
    model = published.find(name).model
    for theta in np.radians((0, 50, 80)):
        found = integrated(of_angles(model), model.alpha, model.across, theta, 0.4)
        assert found == pytest.approx(truth(name, theta, 0.4), rel=4e-3)


@pytest.mark.parametrize("name", quick(METALS + OTHERS, "gold-polished"))
def test_the_fit_of_a_metal_reflects_what_the_formula_does_within_1_percent(name):
    """At normal incidence and at 80 degrees."""
    fit, model = ready.make(name).fit, published.find(name).model
    for theta in np.radians((0, 80)):
        fitted = integrated(of_angles(fit), model.alpha, model.across, theta)
        assert fitted == pytest.approx(truth(name, theta), rel=0.01 if name in METALS else 0.012)
    assert (fit.evaluate(*published.directions(model)) >= 0).all()


def test_metals_are_offered_by_common_names_with_their_source():
    offered = {each.name: each for each in published.list_offered()}
    for words, name in (("chrome", "chromium-polished"), ("steel", "stainless-steel-satin"), ("gold", "gold-brushed"),
                        ("aluminum", "aluminium-rough")):
        assert words in f"{offered[name].label} {offered[name].words}".lower()
    for metal in KNOWN:
        for finish in ("polished", "satin", "rough"):
            each = offered[f"{metal}-{finish}"]
            assert each.brief == "Computed from measured optical constants"
            assert each.source.split(":")[-1] in each.description
            assert not published.load_published(each.name).notes[0].startswith("Published fit")
