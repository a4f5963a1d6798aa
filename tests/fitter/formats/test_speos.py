"""Speos' anisotropic BSDF: scaled to its percentages, and the same sample as in Zemax's format."""

import numpy as np
import pytest
from scipy.integrate import dblquad
from scipy.interpolate import griddata

import fitter
from fitter import DatasetError
from support.speos_files import made

FILE = "paint.anisotropicbsdf"
POLAR, AZIMUTHS = np.arange(0, 91, 5), np.arange(0, 361, 10)


@pytest.mark.parametrize("angle", [15, 30, 45, 60, 75])
def test_it_is_what_the_file_that_it_was_converted_from_is(goniometer, projected, angle):
    """One factor aside: the converter normalised each incidence by its TIS, and by an integral of its own."""
    speos = fitter.load(goniometer("ansys_planesymmetric.anisotropicbsdf"))
    zemax = fitter.load(goniometer("ansys_planesymmetric_brdf_zemax.bsdf"))
    mine, theirs = (fitter.samples.subset(each, np.isclose(each.theta_i, np.radians(angle)) & (each.theta_o < 1.2))
                    for each in (speos, zemax))
    scatter = []
    for turn in (0, np.pi):
        expected = griddata(projected(theirs), theirs.values[:, 0], projected(mine, turn))
        ratio = mine.values[:, 0] / expected
        scatter.append(np.nanstd(np.log(ratio)))
        if turn == 0:
            factor = np.nanmedian(ratio)
    assert scatter[0] < 0.013
    assert scatter[1] > 0.05
    assert factor == pytest.approx({15: 1.034, 30: 1.082, 45: 1.142, 60: 1.198, 75: 1.118}[angle], abs=0.005)
    if angle == 15:                                     # where the percentage was measured
        total = float(next(line for line in goniometer("ansys_planesymmetric_brdf_zemax.bsdf").read_text().splitlines()
                           if line.startswith("TIS")).split()[1])
        assert factor == pytest.approx(total / 0.130, rel=0.01)         # .130: the integral of f cos theta_o


def lobe(theta, phi):
    """A BSDF with its highlight at 40 degrees on the mirror's side, azimuth 0 in Speos."""
    near = np.cos(theta) * np.cos(0.7) + np.sin(theta) * np.sin(0.7) * np.cos(phi)
    return 0.2 + 2 * np.maximum(near, 0) ** 20


@pytest.mark.parametrize("is_bsdf", [True, False])
@pytest.mark.parametrize("last", [360, 350, 180])
def test_the_percentage_is_the_integral_of_the_bsdf_and_the_cosine(load, is_bsdf, last):
    polar, around = np.radians(np.arange(0, 91, 2)), np.radians(np.arange(0, last + 1, 5))
    values = lobe(polar[:, None], around) * 123 * (1 if is_bsdf else np.cos(polar)[:, None])
    samples = load(made(values[None], (40,), polar=np.arange(0, 91, 2), azimuths=np.arange(0, last + 1, 5),
                                  at=(40, 0), bands=((350, 30), (850, 30)), is_bsdf=is_bsdf))
    total, _ = dblquad(lambda theta, phi: lobe(theta, phi) * np.cos(theta) * np.sin(theta), 0, 2 * np.pi, 0, np.pi / 2,
                       epsabs=1e-6)
    expected = 0.3 * lobe(samples.theta_o, samples.phi_o - np.pi) / total
    well = samples.theta_o < 1.55
    np.testing.assert_allclose(samples.values[well, 0], expected[well], rtol=3e-3)
    assert np.degrees(samples.theta_o[samples.values[:, 0].argmax()]) == pytest.approx(40)
    assert abs(samples.phi_o[samples.values[:, 0].argmax()]) == pytest.approx(np.pi)        # across from the light


def test_between_two_incidences_both_are_weighted(load):
    values = np.stack([np.full((5, 7), 1.0), np.full((5, 7), 3.0)])
    samples = load(made(values, (10, 30), polar=(0, 22.5, 45, 67.5, 90), at=(15, 0),
                                  bands=((350, 60), (850, 60))))
    assert samples.values[:, 0].min() == pytest.approx(0.6 / np.pi / 1.5, rel=1e-3)
    assert samples.values[:, 0].max() == pytest.approx(3 * 0.6 / np.pi / 1.5, rel=1e-3)


def test_a_spectrum_becomes_a_colour(load):
    flat = np.ones((1, 5, 7))
    kinds = {"incidences": (0,), "at": (0, 0), "polar": (0, 22.5, 45, 67.5, 90)}
    red = load(made(flat, bands=((400, 10), (550, 10), (600, 60), (700, 60)), **kinds))
    nm = np.arange(400, 701, 10)
    spectrum = np.interp(nm, [400, 550, 600, 700], [0.1, 0.1, 0.6, 0.6]) / np.pi
    same = load(f"theta_i[deg],theta_o[deg],phi[deg],{','.join(map(str, nm))}\n0,0,0,{','.join(map(str, spectrum))}\n",
                "same.csv")
    assert red.channels == ("R", "G", "B")
    np.testing.assert_allclose(red.values, np.repeat(same.values, len(red), axis=0), rtol=1e-3)
    assert red.values[0, 0] > 2 * red.values[0, 1]
    assert load(made(flat, **kinds)).channels == ("grey",)


def test_rotations_turn_the_light_about_the_tangent(load):
    samples = load(made(rotations=(0, 30), incidences=(20,)))
    assert set(np.degrees(samples.phi_i).round(6)) == {0, -30}
    assert len(samples) == 2 * (4 * 6 + 1)


def test_reflection_is_read_where_there_is_transmission_as_well(load):
    both = np.ones((4, 5, 7)) * np.array([1, 1, 9, 9])[:, None, None]
    samples = load(made(both, flags=(1, 1)))
    assert np.ptp(samples.values) == 0


@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_a_description_of_several_lines(load, end):
    assert len(load(made(description="one\ntwo, and\n3", end=end).replace("\r\n", "\n"))) > 0


@pytest.mark.parametrize(("change", "expected"), [
    (("v8.0", "v5.0"), r":1: an older version found, expected 7 or later: save it again"),
    (("v8.0\n0\n", "v8.0\n1\n"), r":2: a binary file of Speos, expected text"),
    (("\n1\t0\n", "\n0\t1\n"), r":7: transmission alone found"), (("\n15\n", "\n9000\n"), r":4: 9000 characters"),
    (("5 7\n", "5 8\n"), r"7 entries found, expected 8"), (("5 7\n", "0 7\n"), r"0 x 7 values found"),
    (("\n80\t", "\n95\t"), r":\d+: a polar angle of 95"), (("\n15\t40\n", "\n15\t140\n"), r"incidence from 15 to 140"),
    (("\n15\t0\n", "\n15\n"), r"1 entries found, expected 2: theta_i and rotation")])
def test_a_damaged_file_is_refused_with_its_line(load, change, expected):
    text = made()
    assert change[0] in text
    with pytest.raises(DatasetError, match=r"paint\.anisotropicbsdf.*" + expected):
        load(text.replace(*change))
