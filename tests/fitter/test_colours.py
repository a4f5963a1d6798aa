"""Spectra and RGB in each colour space: against sums over the CIE's table, and matrices of published chromaticities."""

import csv

import numpy as np
import pytest

import fitter
from fitter import DatasetError, colours
from fitter.formats import spectra
from fitter.imaging import pictures
from support import tensor_files
from support.checkout import ROOT

# ITU-R BT.709-6, ITU-R BT.2020-2, S-2014-004
CHROMATICITIES = {"Rec.709": ((0.64, 0.33), (0.30, 0.60), (0.15, 0.06), (0.3127, 0.3290)),
                  "Rec.2020": ((0.708, 0.292), (0.170, 0.797), (0.131, 0.046), (0.3127, 0.3290)),
                  "ACEScg": ((0.713, 0.293), (0.165, 0.830), (0.128, 0.044), (0.32168, 0.33767))}
# CIE 15:2018; E by definition
WHITES = {"D65": (0.31272, 0.32903), "D50": (0.34567, 0.35850), "A": (0.44758, 0.40745), "E": (1 / 3, 1 / 3)}
BANDS = np.arange(380, 781, 5)
CONES = np.array([[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]])    # Bradford


def xyz_of(x, y):
    return np.array([x / y, 1, (1 - x - y) / y])


def to_xyz(space):
    """RP 177: columns are the primaries, scaled so that (1, 1, 1) is white."""
    *primaries, white = CHROMATICITIES[space]
    columns = np.array([xyz_of(*primary) for primary in primaries]).T
    return columns @ np.diag(np.linalg.inv(columns) @ xyz_of(*white))


def adapted(xyz, white, other):
    return np.linalg.inv(CONES) @ ((CONES @ xyz) * (CONES @ other) / (CONES @ white))


def cie():
    with open(ROOT / "fitter" / "formats" / "data" / "cie_1931_d65.csv") as file:
        return [[float(cell) for cell in row] for row in list(csv.reader(file))[3:]]


def sums(spectrum, light):
    """XYZ of a reflectance, and of white, seen under a light: loops over the rows of the table."""
    seen, white = [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]
    for (_, *bars, _), reflectance, power in zip(cie(), spectrum, light, strict=True):
        for k, bar in enumerate(bars):
            seen[k] += bar * power * reflectance
            white[k] += bar * power
    return np.array(seen) / white[1], np.array(white) / white[1]


SPECTRA = {"flat": np.full(81, 0.4), "red": np.where(BANDS > 600, 0.8, 0.03), "ramp": np.linspace(0.1, 0.9, 81),
           "cyan": 0.1 + 0.8 * np.exp(-((BANDS - 500) / 50.0) ** 2)}


@pytest.fixture
def load(tmp_path):
    """Read a spectrum of one sample, from a table."""
    def load(spectrum, **options):
        path = tmp_path / "spectrum.csv"
        path.write_text(",".join(["theta_i[deg]", "theta_o[deg]", "phi[deg]", *map(str, BANDS)]) + "\n"
                        + ",".join(map(repr, [30.0, 40.0, 180.0, *map(float, spectrum)])) + "\n")
        return fitter.load(path, **options)
    return load


@pytest.mark.parametrize("space", CHROMATICITIES)
@pytest.mark.parametrize("name", SPECTRA)
def test_a_spectrum_is_what_the_cie_sums_say(load, name, space):
    xyz, white = sums(SPECTRA[name], [row[4] for row in cie()])
    expected = np.linalg.inv(to_xyz(space)) @ adapted(xyz, white, xyz_of(*CHROMATICITIES[space][3]))
    samples = load(SPECTRA[name], colours=space)
    np.testing.assert_allclose(samples.values[0], expected, atol=3e-4)
    assert samples.colours == space


@pytest.mark.parametrize("space", CHROMATICITIES)
@pytest.mark.parametrize("illuminant", WHITES)
def test_a_flat_spectrum_is_grey_in_every_space_and_light(load, space, illuminant):
    values = load(SPECTRA["flat"], colours=space, illuminant=illuminant).values
    np.testing.assert_allclose(values, 0.4, rtol=1e-14)


@pytest.mark.parametrize("illuminant", WHITES)
def test_illuminants_have_their_published_white(illuminant):
    x, y = WHITES[illuminant]
    np.testing.assert_allclose(spectra.white(illuminant), xyz_of(x, y), atol=2e-4)


def test_d50_is_the_table_of_the_cie():
    """Some of its rows: CIE 15:2018."""
    table = {380: 24.49, 400: 49.31, 430: 57.82, 450: 87.25, 500: 95.72, 530: 102.10, 550: 102.32, 600: 97.69}
    assert spectra.power("D50")[np.isin(BANDS, [*table])] == pytest.approx([*table.values()], abs=0.006)


@pytest.mark.parametrize("illuminant", ["D50", "A", "E"])
@pytest.mark.parametrize("name", ["red", "ramp"])
def test_other_light_shifts_colours_as_the_sums_say(load, name, illuminant):
    light = spectra.power("D50") if illuminant == "D50" else [1.0 if illuminant == "E" else (
        560 / band) ** 5 * (np.exp(1.435e7 / 2848 / 560) - 1) / (np.exp(1.435e7 / 2848 / band) - 1) for band in BANDS]
    xyz, white = sums(SPECTRA[name], light)
    expected = np.linalg.inv(to_xyz("Rec.709")) @ adapted(xyz, white, xyz_of(0.3127, 0.3290))
    samples = load(SPECTRA[name], illuminant=illuminant)
    np.testing.assert_allclose(samples.values[0], expected, atol=1e-3)
    assert np.abs(samples.values - load(SPECTRA[name]).values).max() > 0.002
    assert f"Spectra seen under the illuminant {illuminant}" in samples.notes


def test_a_saturated_colour_is_outside_of_rec709_and_inside_of_acescg(load):
    narrow, wide = load(SPECTRA["cyan"]), load(SPECTRA["cyan"], colours="ACEScg")
    assert narrow.values.min() < -0.05
    assert wide.values.min() > 0
    below = 100 * -narrow.values.min() / (to_xyz("Rec.709")[1] @ narrow.values[0])
    assert narrow.notes[-1] == f"Outside of Rec.709: 1 of 1 samples, by up to {below:.0f} % of the mean luminance"
    assert wide.notes[-1] == "Colours in ACEScg"


def rgb_file(folder):
    path = folder / "rgb.csv"
    path.write_text("theta_i[deg],theta_o[deg],phi[deg],R,G,B\n30,40,180,0.5,0.5,0.5\n40,40,180,0.9,0.1,0.2\n")
    return path


@pytest.mark.parametrize("space", ["Rec.2020", "ACEScg"])
def test_rgb_is_linear_rec709_and_white_stays_white(tmp_path, space):
    plain, samples = fitter.load(rgb_file(tmp_path)), fitter.load(rgb_file(tmp_path), colours=space)
    np.testing.assert_allclose(samples.values[0], 0.5, rtol=1e-14)
    expected = np.linalg.inv(to_xyz(space)) @ adapted(to_xyz("Rec.709") @ [0.9, 0.1, 0.2], xyz_of(0.3127, 0.3290),
                                                      xyz_of(*CHROMATICITIES[space][3]))
    np.testing.assert_allclose(samples.values[1], expected, atol=1e-6)
    assert (plain.colours, plain.notes) == ("Rec.709", ("Angles in degrees",))


def test_grey_measurements_are_the_same_in_every_space(tmp_path):
    path = tmp_path / "grey.csv"
    path.write_text("theta_i[deg],theta_o[deg],phi[deg],BRDF\n30,40,180,0.5\n40,40,180,-0.01\n")
    plain, wide = fitter.load(path), fitter.load(path, colours="ACEScg", illuminant="A")
    assert (plain.values == wide.values).all()
    assert plain.notes == wide.notes == ("Angles in degrees",)


def test_spectra_of_rgl_follow_the_options(tmp_path):
    arrays = tensor_files.material()
    rgb = arrays.pop("rgb")
    wavelengths = np.linspace(400, 700, 7, dtype=np.float32)
    ramp = np.linspace(0.2, 1, 7, dtype=np.float32)
    spectral = rgb[:, :, :1] * ramp[:, None, None]
    path = tmp_path / "paint.bsdf"
    path.write_bytes(tensor_files.pack(arrays | {"wavelengths": wavelengths, "spectra": spectral}))
    plain, other = fitter.load(path), fitter.load(path, illuminant="A", colours="ACEScg")
    weights = spectra.srgb_weights(wavelengths.astype(float), "A")
    ratio = other.values[:, 0] / other.values[:, 2]
    expected = colours.conversion("Rec.709", "ACEScg") @ weights @ ramp
    np.testing.assert_allclose(ratio[np.isfinite(ratio)], expected[0] / expected[2], rtol=1e-5)
    assert "Spectra seen under the illuminant A" in other.notes
    assert not any("illuminant" in note for note in plain.notes)


@pytest.mark.parametrize(("option", "value", "expected"), [
    ("illuminant", "F11", "illuminant 'F11' found, expected D65, D50, A or E"),
    ("colours", "sRGB", r"colours 'sRGB' found, expected Rec\.709, Rec\.2020 or ACEScg")])
def test_unknown_options_are_refused(tmp_path, option, value, expected):
    with pytest.raises(DatasetError, match=expected):
        fitter.load(rgb_file(tmp_path), **{option: value})


def test_samples_refuse_an_unknown_space():
    with pytest.raises(DatasetError, match="colour space 'P3' found"):
        fitter.Samples([0], [0], [0], [0], [[1]], colours="P3")


class Coloured:
    """A Lambertian of a colour that is pure red in Rec.709."""

    def __init__(self, space):
        self.color = np.linalg.inv(to_xyz(space)) @ adapted(
            to_xyz("Rec.709") @ [0.3, 0, 0], xyz_of(0.3127, 0.3290), xyz_of(*CHROMATICITIES[space][3]))

    def evaluate(self, theta_i, phi_i, theta_o, phi_o):
        return np.broadcast_to(self.color, (len(theta_i), 3))


def test_a_picture_shows_the_colour_whatever_the_space():
    plain, wide = (pictures.lit_sphere(Coloured(space), 32, colours=space) for space in ("Rec.709", "ACEScg"))
    np.testing.assert_allclose(wide, plain, atol=2e-3)
    assert wide[16, 16, 0] > 0.5
    assert wide[16, 16, 1] < 0.01
