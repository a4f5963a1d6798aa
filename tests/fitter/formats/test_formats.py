import re

import numpy as np
import pytest

import fitter
from fitter import DatasetError, formats
from fitter.formats import curet as curet_format
from fitter.formats import spectra

FILE = "data.txt"
BANDS = np.arange(400, 701, 10)


def astm_text(rows, channels="R,G,B", end="\n", points=True):
    count = [f"NUM_POINTS {len(rows)}"] if points else []
    lines = ["LAB_NAME Somewhere", "SAMPLE_NAME Grün 7", *count, f"VARS theta_i,phi_i,theta_s,phi_s,{channels}", "",
             *(",".join(map(str, row)) for row in rows)]
    return end.join(lines)


def write(tmp_path, text, name="data.txt"):
    path = tmp_path / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


ROWS = [[0.5, 0, 0.3, -3.141593, 0.1, 0.2, 0.3], [1.2, 0, 0.7, 3.141593, -0.01, 0.25, 0.35]]


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
@pytest.mark.parametrize("last", ["", "\n"])
def test_astm_with_any_line_end(load, end, last):
    samples = load(astm_text(ROWS, end=end) + last)
    np.testing.assert_array_equal(np.column_stack([*samples.directions, samples.values]), ROWS)
    assert (samples.name, samples.channels) == ("Grün 7", ("R", "G", "B"))


def test_astm_in_latin_1(load):
    assert load(astm_text(ROWS).encode("latin-1")).name == "Grün 7"


TURNED = np.array(ROWS)[:, [6, 1, 3, 4, 0, 2, 5]]         # B, phi_i, phi_o, R, theta_i, theta_o, G


@pytest.mark.parametrize(("names", "columns"), [
    ("theta_i,phi_i,theta_r,phi_r,R,G,B", ROWS), ("theta_i,phi_i,theta_o,phi_o,R,G,B", ROWS),
    ("Theta_in, Phi_in, Theta_out, Phi_out, r, g, b", ROWS), ("thetai\tphii\tthetav\tphiv\tR\tG\tB", ROWS),
    ("theta_i[rad] phi_i(radians) theta_s_rad phi_s_rad R G B".replace(" ", "\t"), ROWS),
    ("B,phi_i,phi_s,R,theta_i,theta_s,G", TURNED), ("B\tphi_i\tphi_s\tR\ttheta_i\ttheta_s\tG", TURNED)])
@pytest.mark.parametrize("separator", [",", "\t", "   ", " , "])
def test_astm_with_other_names_orders_and_separators(load, names, columns, separator):
    rows = "\n".join(separator.join(map(str, row)) for row in columns)
    samples = load(f"SAMPLE_NAME\tPaint\nNUM_POINTS\t2\nVARS\t{names}\n{rows}\n")
    np.testing.assert_array_equal(np.column_stack([*samples.directions, samples.values]), ROWS)
    assert (samples.name, samples.channels) == ("Paint", ("R", "G", "B"))


DEGREES = [[30, 0, 15, -180, 0.1, 0.2, 0.3], [0, 0, 2, 180, 0.01, 0.25, 0.35], [90, 0, 45, 90, 0, 0, 0]]


@pytest.mark.parametrize("names", [
    "theta_i,phi_i,theta_s,phi_s", "theta_i[deg],phi_i[deg],theta_s[deg],phi_s[deg]",
    "theta_i (degrees),phi_i (degrees),theta_s (degrees),phi_s (degrees)"])
def test_degrees_are_told_by_the_names_or_by_their_size(load, names):
    rows = "\n".join(",".join(map(str, row)) for row in DEGREES)
    samples = load(f"VARS {names},R,G,B\n{rows}")
    np.testing.assert_allclose(samples.directions, np.array(DEGREES)[:, :4].T * np.pi / 180, rtol=1e-12)


def test_small_angles_are_radians_unless_the_names_say_degrees(load):
    row = "1,2,0.5,3,0.1,0.2,0.3\n"
    assert load(f"VARS theta_i,phi_i,theta_s,phi_s,R,G,B\n{row}").theta_i[0] == 1
    names = "theta_i[deg],phi_i[deg],theta_s[deg],phi_s[deg]"
    assert load(f"VARS {names},R,G,B\n{row}").phi_o[0] == pytest.approx(np.pi / 60)


@pytest.mark.parametrize("name", ["650nm", "650 nm", "BRDF", "brdf", "fr"])
def test_a_single_channel_is_grey(load, name):
    samples = load(astm_text([row[:5] for row in ROWS], name))
    assert samples.channels == ("grey",)
    np.testing.assert_array_equal(samples.values, [[0.1], [-0.01]])


def test_light_tec_leaves_out_the_name_of_phi_s(load):
    text = astm_text([[0.5, 3.141593, 0.3, 1.5, 0.1, 0.2, 0.3]], "465nm,525nm,630nm").replace(",phi_s", "")
    samples = load(text)
    np.testing.assert_array_equal(samples.directions, [[0.5], [3.141593], [0.3], [1.5]])
    assert samples.channels == ("R", "G", "B")
    np.testing.assert_array_equal(samples.values, [[0.3, 0.2, 0.1]])


@pytest.mark.parametrize("stem", ["C1_White", "C9_Gold"])
def test_light_tecs_own_files(goniometer, stem):
    """Light mirrors to where phi_s is 0, half a turn from phi_i, or above that, as off rough metal."""
    samples = fitter.load(goniometer(f"lighttec_{stem}.astm"), keep_unmeasured=True)
    assert (len(samples), samples.channels) == (12964, ("R", "G", "B"))
    np.testing.assert_allclose(np.unique(samples.theta_i.round(6)), np.radians([0, 20, 40, 60]), atol=1e-6)
    assert len(np.unique(samples.phi_o.round(6))) == 36
    oblique = fitter.samples.subset(samples, samples.theta_i > 0.3)
    brightest = np.argmax(oblique.values[:, 0])
    assert np.cos(oblique.phi_o - oblique.phi_i)[brightest] == pytest.approx(-1)
    assert 0 <= (oblique.theta_o - oblique.theta_i)[brightest] < np.radians(16)
    assert -3e-4 < samples.values.min() < 0


def test_srgb_of_a_step_spectrum_is_that_of_the_cie_sums():
    """Equation by equation, from the table and IEC 61966-2-1's white point, without the code under test."""
    table = np.loadtxt(spectra.__file__.replace("spectra.py", "data/cie_1931_d65.csv"), delimiter=",", skiprows=3)
    rows = {row[0]: row[1:] for row in table}
    spectrum = np.where(BANDS > 590, 0.8, 0.02)
    xyz = sum(rows[band][:3] * rows[band][3] * value * (0.5 if band in (400, 700) else 1)
              for band, value in zip(BANDS, spectrum, strict=True))
    white = sum(rows[band][:3] * rows[band][3] * (0.5 if band in (400, 700) else 1) for band in BANDS)
    to_xyz = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
    expected = np.linalg.solve(to_xyz, xyz) / np.linalg.solve(to_xyz, white)
    np.testing.assert_allclose(spectra.to_linear_srgb(BANDS, spectrum[None])[0], expected, atol=1e-4)


def test_bands_that_nobody_sees_do_not_count():
    beyond = np.append(BANDS, [1200, 2000])
    spectrum = np.linspace(0.1, 0.9, len(BANDS))
    with_them = spectra.to_linear_srgb(beyond, np.append(spectrum, [50, 90])[None])
    np.testing.assert_allclose(with_them, spectra.to_linear_srgb(BANDS, spectrum[None]), rtol=1e-12)


def test_three_bands_side_by_side_are_no_colour():
    with pytest.raises(DatasetError, match="span 200 nm"):
        spectra.to_linear_srgb([460, 461, 462], [[1, 2, 3]])


def test_pbrt_and_astm_of_one_measurement_are_equal(data, cornell):
    pbrt = fitter.load(data / "cornell" / "garnet_red.brdf")
    np.testing.assert_array_equal(pbrt.values, cornell("garnet_red").values)
    np.testing.assert_array_equal(pbrt.directions, cornell("garnet_red").directions)


def test_cornell_files_hold_what_their_owners_say(cornell):
    for stem in ("krylon_blue", "krylon_blue_RGB", "garnet_red", "garnet_red_RGB", "cayman"):
        samples = cornell(stem)
        assert samples.values.shape == (1439, 3)
        assert set(np.degrees(samples.theta_i).round().astype(int)) == set(range(10, 81, 10))
    assert np.count_nonzero(cornell("krylon_blue_RGB").values[:, 0] < 0) == 943
    assert cornell("krylon_blue_RGB").name == "Krylon Blue"


def test_curet_samples_by_number_and_by_name(data, curet):
    raw = np.loadtxt(data / "curet" / "abrdf.dat")
    for sample in (5, "5", "leather", " Leather "):
        samples = curet(sample)
        np.testing.assert_array_equal(samples.values[:, 0], raw[4, 1:])
        assert (samples.name, samples.channels) == ("leather", ("grey",))
    theta_v, phi_v, theta_i, phi_i = np.loadtxt(data / "curet" / "table.txt")[:, 1:].T
    np.testing.assert_allclose(samples.directions, (theta_i, phi_i, theta_v, phi_v), atol=5e-7)
    assert curet(None).name == "felt"
    assert len(formats.list_samples(data / "curet" / "abrdf.dat")) == 61


def test_every_curet_sample_has_a_name_of_its_own():
    assert len(set(curet_format.SAMPLE_NAMES)) == 61


@pytest.mark.parametrize(("sample", "hint"), [("lether", "did you mean leather"), (62, "from 1 to 61"), ("", None),
                                              ("xyzzy", "no sample named 'xyzzy'$"), (1.5, "no sample 1.5")])
def test_a_wrong_sample_is_named_with_what_there_is(curet, sample, hint):
    if hint is None:
        assert curet(sample).name == "felt"
        return
    with pytest.raises(DatasetError, match=hint):
        curet(sample)


def curet_text(scale, numbers=(1, 2, 3)):
    return "\n".join(" ".join([str(n), *(f"{scale * n + k / 1000:.3f}" for k in range(205))]) for n in numbers)


def test_red_green_and_blue_curet_files_make_one_set(tmp_path):
    for scale, name in enumerate(("rbrdf.dat", "gbrdf.dat", "bbrdf.dat"), 1):
        write(tmp_path, curet_text(scale), name)
    for name in ("rbrdf.dat", "bbrdf.dat"):
        samples = fitter.load(tmp_path / name, "polyester")
        assert samples.channels == ("R", "G", "B")
        np.testing.assert_allclose(samples.values[7], [2.007, 4.007, 6.007])


def test_curet_files_of_fewer_than_three_colours_are_grey_and_files_of_their_own(tmp_path):
    red, green = (write(tmp_path, curet_text(1), f"{letter}brdf.dat") for letter in "rg")
    assert fitter.load(red).channels == fitter.load(green).channels == ("grey",)
    assert not formats.is_read_with_another(green, [red])
    blue = write(tmp_path, curet_text(1), "bbrdf.dat")
    assert [formats.is_read_with_another(each, [red]) for each in (red, green, blue)] == [False, True, True]
    assert not formats.is_read_with_another(green, [blue])


def test_a_sample_missing_from_one_colour_is_reported(tmp_path):
    for name, numbers in (("rbrdf.dat", (1, 2)), ("gbrdf.dat", (1, 2)), ("bbrdf.dat", (1,))):
        write(tmp_path, curet_text(1, numbers), name)
    with pytest.raises(DatasetError, match=r"bbrdf\.dat: no sample 2"):
        fitter.load(tmp_path / "rbrdf.dat", 2)


def paint_arrays(random, count=40):
    vectors = random.standard_normal((2, count, 3))
    vectors[..., 2] = np.abs(vectors[..., 2])
    wavelength = np.linspace(380, 700, 65)
    return {"dir_in": vectors[0], "dir_out": vectors[1], "fr": random.random((count, 1)) * np.ones(65),
            "wavelength": wavelength}


def test_the_paint_file_in_matlabs_format(tmp_path, random):
    from scipy.io import savemat

    arrays = paint_arrays(random)
    savemat(tmp_path / "paint.bin", arrays)
    samples = fitter.load(tmp_path / "paint.bin")
    np.testing.assert_allclose(samples.values, arrays["fr"][:, :3], rtol=1e-9)
    x, y, z = (arrays["dir_in"] / np.linalg.norm(arrays["dir_in"], axis=1, keepdims=True)).T
    np.testing.assert_allclose(np.sin(samples.theta_i) * np.exp(1j * samples.phi_i), x + 1j * y, atol=1e-12)
    np.testing.assert_allclose(np.cos(samples.theta_i), z, atol=1e-12)


@pytest.mark.parametrize(("change", "expected"), [
    ({"fr": None}, "no array fr"), ({"dir_in": np.ones((39, 3))}, "dir_in has 39 vectors, expected 40"),
    ({"dir_out": -np.ones((40, 3))}, "expected 0 to pi/2"), ({"dir_in": np.zeros((40, 3))}, "not a direction"),
    ({"fr": np.full((40, 65), np.nan)}, "not finite"), ({"fr": np.ones((40, 65)) * 1j}, "plain array of real"),
    ({"wavelength": "red"}, "plain array of real"),
    ({"dir_in": np.array([["a"], ["b"]], dtype=object)}, "plain array of real"),
    ({"wavelength": np.arange(65)}, "from 400 to 700")])
def test_a_malformed_paint_file_is_refused(tmp_path, random, change, expected):
    from scipy.io import savemat

    arrays = {name: array for name, array in (paint_arrays(random) | change).items() if array is not None}
    savemat(tmp_path / "paint.mat", arrays)
    with pytest.raises(DatasetError, match=expected):
        fitter.load(tmp_path / "paint.mat")


def test_a_damaged_paint_file_is_refused(load):
    with pytest.raises(DatasetError, match="damaged MATLAB"):
        load(b"MATLAB 5.0 MAT-file" + bytes(range(256)) * 3)


PBRT = "# a comment\n3\n400 550\n700 # wavelengths\n0.1 0 0.2 3.1 1 1 1\n0.3 0 0.4 -1 2 2\n2\n"


def test_pbrt_rows_may_break_anywhere(load):
    samples = load(PBRT, "gloss.brdf")
    np.testing.assert_allclose(samples.values, [[1, 1, 1], [2, 2, 2]])
    assert samples.name == "gloss"


@pytest.mark.parametrize(("text", "line", "expected"), [
    (astm_text(ROWS).replace("0.25", "O.25"), 7, "'O.25' found, expected a number"),
    (astm_text(ROWS).replace("0.25", "nan"), 7, "expected a finite number"),
    (astm_text(ROWS).replace("0.25", "1_0"), 7, "expected a number"),
    (astm_text(ROWS).replace("0.25,", ""), 7, "6 entries found, expected 7"),
    (astm_text(ROWS).replace("1.2,", "2.2,"), 7, "polar angle of 2.2"),
    (astm_text(ROWS).replace("POINTS 2", "POINTS 3"), 3, "2 rows found, expected 3"),
    (astm_text([], points=False), 3, "no rows after VARS"),
    (astm_text(ROWS, "X,Y,Z"), 4, "expected R,G,B, or wavelengths"),
    (astm_text(ROWS, "700nm,600nm,600nm"), 4, "wavelengths must differ"),
    (astm_text(ROWS).replace("theta_i", "angle"), 4, "VARS must name theta_i, phi_i"),
    (astm_text(ROWS).replace("theta_s", "theta_r,theta_o"), 4, "once each"),
    (astm_text(ROWS).replace("theta_i", "theta_i[deg]"), 4, "in one unit"),
    (astm_text(ROWS).replace("phi_i,", ""), 4, "VARS must name"),
    (astm_text(ROWS).replace(",R,G,B", ""), 4, "and channels"),
    (astm_text([row[:6] for row in ROWS], "R,G"), 4, "channels R,G found"),
    (astm_text([row[:5] for row in ROWS], "BRDF*cos"), 4, "channels BRDF*cos found"),
    (astm_text(ROWS, "R,G"), 6, "more than 6 entries found, expected 6"),
    (astm_text(DEGREES).replace("\n30,", "\n95,"), 6, "a polar angle of 95 found, expected 0 to 90 degrees"),
    (astm_text(ROWS).replace(",", "\t").replace("0.25", ""), 7, "6 entries found, expected 7"),
    (astm_text(ROWS).replace("0.3,-3", "0.3 -3"), 6, "6 entries found, expected 7"),
    (PBRT + "1 2", 8, "rows of 7"),
    (PBRT.replace("0.3", "-0.3"), 6, "polar angle of -0.3"),
    (PBRT.replace("-1", "x"), 6, "'x' found"),
    (curet_text(1) + "\n2 " + "0.1 " * 205, 4, "sample 2 a second time, first on line 2"),
    (curet_text(1) + "\n62 " + "0.1 " * 205, 4, "sample number from 1 to 61"),
    (curet_text(1).replace("1.003", "1.0.3"), 1, "'1.0.3' found"),
    (curet_text(1).replace("1.003", "1" * 5000), 1, "expected a finite number"),
    (curet_text(1) + "\n0000000019999 " + "0.1 " * 205, 4, "sample number from 1 to 61"),
    (curet_text(1) + "\n00000000155 " + "0.1 " * 205, 4, "sample number from 1 to 61"),
    ("1 " + "0.1 " * 204, 1, "205 entries found, expected 206"),
])
def test_malformed_text_is_refused_with_file_line_and_expectation(load, tmp_path, text, line, expected):
    with pytest.raises(DatasetError, match=f"^{re.escape(str(tmp_path))}/bad.dat:{line}: .*{re.escape(expected)}"):
        load(text, "bad.dat")


@pytest.mark.parametrize("content", [
    b"hello", b"\x89PNG\r\n\x1a\n\0\0", b"1 2 3\n4 5 6", b"31\n", b"[1, 2]", b"   \n ", b"",
    "VARS theta_i".encode("utf-16"), b"0" * 10000, b"#\n#\n", b"\xef\xbb\xbf", b"\x1c\x1d", b"\xa0",
    "\u2028".encode(), "1\u0663 ".encode() * 300, b"\n \t\r\n", b"\0", b"#", b"-", b"VARS"])
def test_anything_else_is_refused(load, content):
    with pytest.raises(DatasetError, match=r"data\.txt"):
        load(content)


def test_a_missing_file_and_a_folder_are_refused(tmp_path):
    with pytest.raises(DatasetError, match="No such file"):
        fitter.load(tmp_path / "none.dat")
    with pytest.raises(DatasetError, match="not a file"):
        fitter.load(tmp_path)


def test_a_sample_of_a_file_that_holds_one_is_refused(load):
    with pytest.raises(DatasetError, match="single sample"):
        load(astm_text(ROWS), sample=3)


@pytest.mark.parametrize("change", [{"theta_i": np.zeros(3)}, {"values": np.zeros(2)}, {"theta_o": [0.1, 1.7]},
                                    {"phi_i": [0, np.inf]}, {"values": np.zeros((0, 1))}, {"channels": ("a", "b")},
                                    {"values": [[1e31], [0]]}])
def test_samples_that_make_no_sense_are_refused(change):
    arrays = {"theta_i": [0.1, 0.2], "phi_i": [0, 0], "theta_o": [0.1, 0.2], "phi_o": [0, 0],
              "values": np.ones((2, 1))}
    fitter.Samples(**arrays)
    with pytest.raises(DatasetError):
        fitter.Samples(**(arrays | change))


def test_samples_cannot_be_changed_by_accident(curet):
    with pytest.raises(ValueError, match="read-only"):
        curet("felt").values[0] = 0


def test_read_only_arrays_are_not_copied_and_others_are():
    values, angle = np.ones((3, 1)), np.zeros(3)
    values.flags.writeable = False
    samples = fitter.Samples(angle, angle, angle, angle, values)
    assert samples.values is values
    angle[:] = 1
    assert not samples.theta_i.any()
