"""Zemax's .bsdf: directions worked out by hand, and files of two instruments, one at a time of transmission."""

import re

import numpy as np
import pytest
from scipy.integrate import dblquad

import fitter
from fitter import DatasetError
from support import anisotropic as instruments
from support.zemax_files import made

FILE = "paint.bsdf"


@pytest.mark.parametrize("gap", ["\t", "  "])
@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_directions_are_about_the_mirrored_ray(load, gap, end):
    """Azimuth 0 goes to the normal and past it, 180 to the horizon and below it, 90 sideways."""
    samples = load(made(gap=gap, end=end))
    assert (samples.channels, samples.name) == (("grey",), "paint")
    sideways = np.degrees(np.arccos(np.cos(np.radians(30)) * np.cos(np.radians(30))))
    expected = {                                    # value: theta_i, theta_o, phi_o
        1 + 3: (30, 30, 180), 2: (30, 0, None), 3: (30, 10, 0), 5: (30, sideways, None), 8: (30, 60, 180),
        9: (30, 70, 180), 9 + 4: (60, 60, 180), 9 + 2: (60, 30, 180), 9 + 3: (60, 20, 180)}
    found = {round(value): index for index, value in enumerate(samples.values[:, 0])}
    for value, (theta_i, theta_o, phi_o) in expected.items():
        index = found[value]
        assert np.degrees(samples.theta_i[index]) == pytest.approx(theta_i)
        assert np.degrees(samples.theta_o[index]) == pytest.approx(theta_o, abs=1e-6)
        if phi_o is not None:
            assert abs(np.degrees(samples.phi_o[index])) == pytest.approx(phi_o, abs=1e-6)
    assert 9 + 9 not in found                       # 60 + 40 degrees: below the horizon
    assert 9 + 8 not in found                       # 60 + 30 degrees: on it
    assert len(samples) == 2 * 7 - 2


def test_zeros_are_not_measurements_and_the_mirrored_ray_is_one(load):
    values = np.ones((1, 1, 3, 3))
    values[0, 0, :, 0] = 4, 0, 2
    values[0, 0, 1, 1] = 0
    samples = load(made(values, incidences=(20,)))
    assert len(samples) == 1 + 5
    mirrored = np.isclose(samples.theta_o, np.radians(20)) & np.isclose(abs(samples.phi_o), np.pi)
    assert samples.values[mirrored].tolist() == [[3]]


def test_tristimulus_values_become_srgb(load):
    """The white of D65 is white, and a colour is that of the matrix of IEC 61966-2-1."""
    white, red = np.array([0.9505, 1, 1.089]), np.array([0.4124, 0.2126, 0.0193])
    values = np.stack([np.full((1, 1, 3), channel) for channel in white])
    values[:, :, :, 2] = red[:, None, None]
    samples = load(made(values, (0,), (0,), (0, 30, 40), SpectralContent="XYZ"))
    assert samples.channels == ("R", "G", "B")
    np.testing.assert_allclose(samples.values, [[1, 1, 1], [1, 1, 1], [1, 0, 0]], atol=1e-3)


@pytest.mark.parametrize(("name", "count", "incidences", "most"), [
    ("AnoBlackEC1onAlum.zemax.bsdf", 647, [10, 30, 50, 70], 80.001),
    ("ansys_planesymmetric_brdf_zemax.bsdf", 2043, list(range(15, 80, 5)), 86)])
def test_real_files(goniometer, name, count, incidences, most):
    path = goniometer(name)
    samples = fitter.load(path)
    assert (len(samples), samples.channels) == (count, ("grey",))
    np.testing.assert_allclose(np.unique(samples.theta_i.round(9)), np.radians(incidences), atol=1e-8)
    assert np.degrees(samples.theta_o.max()) < most         # the instruments see no more
    # nothing but repetitions at radial 0 is lost: no value that was measured comes out below the horizon
    rows = [line.split() for line in path.read_text().split("DataBegin")[1].splitlines()
            if line[:1].isdigit()]
    numbers = np.array(rows, dtype=float)
    assert np.count_nonzero(numbers[:, 1:]) + len(incidences) == count


@pytest.mark.parametrize(("symmetry", "last"), [("PlaneSymmetrical", 180), ("Asymmetrical", 350)])
@pytest.mark.parametrize("times", [1, 0.93, 1.25, 0.8])
def test_the_tis_stands_beside_the_integral_where_they_differ_by_more_than_a_tenth(load, symmetry, last, times):
    """The integral is SciPy's, about the normal; the file's values are about the mirrored ray."""
    theta_i = np.radians(40)

    def lobe(cosine):
        return 0.1 + 3 * np.maximum(cosine, 0) ** 30

    def integrand(theta, phi):
        mirrored = np.cos(theta) * np.cos(theta_i) + np.sin(theta) * np.sin(theta_i) * np.cos(phi)
        return lobe(mirrored) * np.cos(theta) * np.sin(theta)

    truth = 2 * dblquad(integrand, 0, np.pi, 0, np.pi / 2, epsabs=1e-6)[0]
    azimuths, radials = np.arange(0, last + 1, 10), np.arange(0, 136, 3)
    values = np.broadcast_to(lobe(np.cos(np.radians(radials))), (1, 1, len(azimuths), len(radials)))
    text = made(values, (40,), tuple(azimuths), tuple(radials), Symmetry=symmetry)
    samples = load(text.replace("TIS 0.5", f"TIS {truth * times:.6f}"))
    told = [note for note in samples.notes if note.startswith("TIS")]
    assert bool(told) == (times in (1.25, 0.8))
    if told:
        found = float(re.search(r"integrate to ([\d.]+);", told[0])[1])
        assert found == pytest.approx(truth, rel=5e-3)
        assert f"at 40 degrees of incidence the file says {truth * times:.4g}" in told[0]


def test_the_tis_of_real_files_is_told_where_it_is_another(goniometer):
    """Arizona's are weighted otherwise; those of the imaging sphere count the horizon, which it did not see."""
    told = [fitter.load(goniometer(f"{name}.bsdf")).notes[0] for name in (
        "AnoBlackEC1onAlum.zemax", "ansys_planesymmetric_brdf_zemax")]
    assert told[0].startswith("TIS: at 10 degrees of incidence the file says 0.03866, its values integrate to 0.05069; "
                              "3 of 4 differ by more than a tenth")
    assert told[1].endswith("8 of 13 differ by more than a tenth")


def test_rotations_turn_both_directions_backwards(load):
    """A sample that is turned by r sees the light at -r: on the truth's grid every value is the truth's."""
    truth, rotations = instruments.ggx(turn=0.3), range(0, 360, 30)
    grid = {"incidences": (20, 50), "azimuths": tuple(range(0, 360, 20)), "radials": (0, 10, 25, 40)}
    expected = []
    for rotation in rotations:
        for incidence in grid["incidences"]:
            turn, theta = np.radians([-rotation, incidence])
            light, normal = instruments.unit(theta, turn), np.array([0, 0, 1])
            mirrored = 2 * light[2] * normal - light
            level = np.cross(np.cross(mirrored, normal), mirrored) / np.sin(theta)      # from it towards the normal
            for azimuth in np.radians(grid["azimuths"]):
                for radial in np.radians(grid["radials"]):
                    out = (np.cos(radial) * mirrored + np.sin(radial)
                           * (np.cos(azimuth) * level + np.sin(azimuth) * np.cross(mirrored, level)))
                    value = 0.0 if out[2] < 0.01 else truth(*np.array(
                        [[theta], [turn], [np.arccos(out[2])], [np.arctan2(out[1], out[0])]]))[0, 0]
                    expected.append(float(value))
    values = np.reshape(expected, (1, -1, 18, 4))
    samples = load(made(values, rotations=rotations, Symmetry="Asymmetrical4D", **grid))
    assert not samples.isotropic
    assert samples.notes[-1:] == ("Anisotropic, measured at 12 rotations from 0 to 330 degrees",)
    assert len(samples) == np.count_nonzero(values[..., 1:]) + 24
    np.testing.assert_allclose(truth(*samples.directions)[:, 0], samples.values[:, 0], rtol=1e-9)


def test_the_other_side_of_a_plane_symmetrical_file_is_read_too(load):
    """PlaneSymmetrical4D has azimuths to 180 degrees at each rotation."""
    values = np.arange(1.0, 1 + 4 * 3 * 4 * 3).reshape(1, 12, 4, 3) ** 2
    grid = {"incidences": (10, 30, 40), "azimuths": (0, 60, 120, 180), "radials": (0, 20, 30)}
    samples = load(made(values, rotations=(0, 45, 90, 135), Symmetry="PlaneSymmetrical4D", **grid))
    assert not samples.isotropic
    count = 12 * (1 + 4 * 2)
    assert len(samples) == count + 12 * 2 * 2
    assert samples.notes[-1] == f"Symmetrical about the plane of incidence: {count} samples stand for {len(samples)}"
    for index in range(count, len(samples)):
        here = [k for k in range(count) if samples.values[k] == samples.values[index]]
        assert len(here) == 1
        for name in ("theta_i", "phi_i", "theta_o"):
            assert getattr(samples, name)[here[0]] == getattr(samples, name)[index]
        apart = (samples.phi_o - samples.phi_i)[[index, here[0]]]
        assert apart[0] == pytest.approx(-apart[1])


def test_one_rotation_tells_nothing_and_the_notes_say_so(load):
    values = np.ones((1, 2, 5, 3))
    samples = load(made(values, azimuths=(0, 90, 180, 225, 270), Symmetry="Asymmetrical"))
    assert samples.isotropic
    assert samples.notes[-1:] == ("Measured at 1 rotation: taken as isotropic",)
    assert not samples.phi_i.any()


def test_tristimulus_values_of_several_rotations(load):
    values = np.stack([np.full((6, 3, 3), channel) for channel in (0.9505, 1, 1.089)])
    values[:, :2, 1] *= 5
    samples = load(made(values, rotations=(0, 40, 80), SpectralContent="XYZ", Symmetry="Asymmetrical4D"))
    assert samples.channels == ("R", "G", "B")
    np.testing.assert_allclose(samples.values, np.repeat(samples.values[:, :1], 3, axis=1), atol=1e-2)
    assert set(np.degrees(samples.phi_i).round(6)) == {0, -40, -80}


def test_a_real_anisotropic_file(goniometer):
    path = goniometer("IMX455.bsdf")
    samples = fitter.load(path)
    assert not samples.isotropic
    assert samples.notes[1:] == ("Anisotropic, measured at 36 rotations from 0 to 350 degrees",)
    rows = [line.split() for line in path.read_text().split("DataBegin")[1].splitlines() if line[:1].isdigit()]
    numbers = np.array(rows, dtype=float)
    assert np.count_nonzero(numbers[:, 1:]) + 37 * 4 == len(samples) == 50_875
    assert samples.values.min() > 0
    np.testing.assert_allclose(np.unique(samples.phi_i.round(9)), np.radians(np.arange(-360, 1, 10)), atol=1e-8)
    assert fitter.load(path, isotropic=True).isotropic


@pytest.mark.parametrize(("text", "line", "expected"), [
    (made(ScatterType="BTDF"), None, "ScatterType BTDF found, expected BRDF"),
    (made(Symmetry="Symmetrical"), None, "Symmetry Symmetrical found, expected PlaneSymmetrical or Asymmetrical"),
    (made().replace("SampleRotation\t1\n0", "SampleRotation\t2\n0\t90"), 16, "2 lines TIS found, expected 4"),
    (made().replace("SampleRotation\t1\n0", "SampleRotation\t2\n0\t400"), 7, "SampleRotation from 0 to 400 found"),
    (made(SpectralContent="XYZ"), None, "1 tables found, expected 3"),
    (made(SpectralContent="RGB"), None, "SpectralContent RGB found, expected Monochrome or XYZ"),
    (made().replace("Symmetry\tPlaneSymmetrical\n", ""), None, "no line Symmetry before DataBegin"),
    (made().replace("DataBegin", ""), None, "no line DataBegin"),
    (made().replace("DataEnd", ""), 16, "no line DataEnd"),
    (made() + "DataBegin\nDataEnd\n", 26, "0 lines TIS found, expected 2"),
    (made().replace("ScatterRadial\t3", "ScatterRadial\t4"), 13, "3 entries found, expected 4"),
    (made().replace("ScatterRadial\t3", "ScatterRadial\tx"), 12, "'x' found, expected a number"),
    (made().replace("ScatterRadial\t3", "ScatterRadial\t-1"), 12, "expected a number of angles"),
    (made(incidences=(30, 95)), 9, "AngleOfIncidence from 30 to 95 found, expected 0 to 90 degrees"),
    (made().replace("TIS 0.5", "", 1), 16, "1 lines TIS found, expected 2"),
    (made().replace("TIS 0.5", "1 2 3\nTIS 0.5", 1), 16, "expected a line TIS"),
    (made().replace("4.0\t5.0\t6.0\n", ""), 17, "2 rows found, expected 3"),
    (made().replace("5.0", "5.O"), 19, "'5.O' found, expected a number"),
    (made().replace("\t5.0", ""), 19, "2 entries found, expected 3"),
    (made(np.zeros((1, 2, 3, 3))), None, "all values are 0"),
])
def test_a_malformed_file_is_refused(load, text, line, expected):
    where = f"bad.bsdf:{line}: " if line else "bad.bsdf: "
    with pytest.raises(DatasetError, match=re.escape(where) + ".*" + re.escape(expected)):
        load(text, "bad.bsdf")
