"""Scans as people have them: one surface, written with names, units and signs of instruments and spreadsheets.

Each table must give the surface's own formula at the directions that were meant.
"""

import numpy as np
import pytest

from fitter import ColumnsUnknownError, DatasetError, UnitsUnknownError
from fitter.formats.names import parse, role, value

FILE = "scan.csv"
INCIDENCES = 0.0, 20.0, 50.0
SCAN = np.arange(-80.0, 81, 10)


def truth(theta_i, theta_o, between):
    """A BRDF with a highlight across from the light, 1/sr; degrees, 180 between to the mirror direction."""
    i, o, apart = np.radians(theta_i), np.radians(theta_o), np.radians(between)
    cosine = np.cos(i) * np.cos(o) - np.sin(i) * np.sin(o) * np.cos(apart)
    return 0.1 + 0.8 * np.maximum(cosine, 0) ** 40


def scan(sign=1):
    """Incidence, signed outgoing angle and value; `sign` of the angle is the mirror's side."""
    i, o = (grid.ravel() for grid in np.meshgrid(INCIDENCES, SCAN, indexing="ij"))
    return i, o, truth(i, np.abs(o), np.where(o * sign >= 0, 180, 0))


def hemisphere():
    """Incidence, outgoing angle, azimuth between and value."""
    i, o, apart = (grid.ravel() for grid in np.meshgrid(INCIDENCES, SCAN[8:], np.arange(0.0, 181, 45), indexing="ij"))
    return i, o, apart, truth(i, o, apart)


def rows(columns, separator=",", form="{:.10g}".format):
    return "".join(separator.join(map(form, row)) + "\n" for row in np.column_stack(columns))


def assert_is_truth(samples, times=1.0, rtol=1e-6):
    between = np.degrees(samples.phi_o - samples.phi_i)
    expected = truth(np.degrees(samples.theta_i), np.degrees(samples.theta_o), between)
    expected_of_all = np.repeat(times * expected[:, None], samples.values.shape[1], axis=1)
    np.testing.assert_allclose(samples.values, expected_of_all, rtol=rtol)
    assert np.ptp(expected) > 0.5


@pytest.mark.parametrize("names", [
    "theta_i,phi,theta_r,BSDF [1/sr]", "AOI,raa,AOS,BRDF [sr^-1]", "Incident Angle,Azimuth,Scatter Angle,BRDF (1/sr)",
    "sza,raa,vza,BRDF", "Solar Zenith,Relative Azimuth,View Zenith,BRDF", "θ_i,φ,θ_r,BRDF [sr⁻¹]",
    "θᵢ (°),Δφ (°),θₒ (°),fr",
    '"theta_i, deg","phi, deg","theta_r, deg","BRDF, 1/sr"',
    "Angle of incidence [deg],phi [deg],Angle of scatter [deg],f_r",
    "Incidence angle (deg),delta_phi (deg),Viewing angle (deg),brdf", "AOI (deg.),Phi,AOE (deg.),Value",
    "theta_s,phi,theta_v,BRDF", "ThetaIn,Phi,ThetaOut,BSDF", "zenith incident,azimuth difference,zenith reflected,grey",
    "polar_i,phi,polar_o,R", "Theta-In,Phi,Theta-Out,550 nm", "Detector angle,phi,Source angle,BRDF"])
def test_the_names_that_people_give(load, names):
    i, o, apart, values = hemisphere()
    columns = [o, apart, i, values] if names.startswith("Detector") else [i, apart, o, values]
    if names.endswith(",R"):
        names, columns = f"{names},G,B", [*columns, values, values]
    assert_is_truth(load(f"{names}\n{rows(columns)}"))


@pytest.mark.parametrize("names", ["theta_i,theta_r,BRDF", "AOI,AOS,BSDF", "Incident Angle,Scatter Angle,BRDF",
                                   "AOI;Angle;BRDF", "θi\tθs\tBRDF", "Incident Angle  Scatter Angle  BRDF"])
@pytest.mark.parametrize("sign", [1, -1])
def test_signed_angles_in_the_plane_of_incidence(load, names, sign):
    """The highlight tells which sign is its side."""
    separator = next((each for each in ",;\t" if each in names), " ")
    samples = load(f"{names}\n{rows(scan(sign), separator)}")
    assert_is_truth(samples)
    side = "positive" if sign > 0 else "negative"
    assert f"In the plane of incidence: theta_o is {side} on the side of the highlight" in samples.notes


def test_a_light_that_moves_past_the_normal(load):
    i, o, values = scan()
    samples = load(f"theta_i,theta_o,BRDF\n{rows([np.r_[i, -i], np.r_[o, -o], np.r_[values, values]])}")
    assert_is_truth(samples)


@pytest.mark.parametrize(("said", "sign"), [("# positive: mirror side", 1), ("positive: light's side", -1),
                                            ("Negative: specular", -1)])
def test_what_the_table_says_of_the_sides_is_true(load, said, sign):
    """Even of a Lambertian, whose values cannot tell."""
    i, o, _ = scan()
    samples = load(f"{said}\ntheta_i,theta_o,BRDF\n{rows([i, o, 0.2 + 0 * o])}")
    mirrored = np.cos(samples.phi_o - samples.phi_i) < 0
    oblique = (samples.theta_i > 0) & (samples.theta_o > 0)
    assert mirrored[oblique].sum() == np.count_nonzero((i > 0) & (o * sign > 0))
    assert "as the table says" in " ".join(samples.notes)


def test_angles_without_signs_are_on_the_mirrors_side_and_the_notes_say_so(load):
    i, o, values = (column[scan()[1] >= 0] for column in scan())
    samples = load(f"AOI,AOE,BRDF\n{rows([i, o, values])}")
    assert_is_truth(samples)
    assert "In the plane of incidence, without an azimuth: taken as on the mirror's side" in samples.notes


def test_polar_angles_below_0_beside_azimuths_are_across_the_normal(load):
    i, o, values = scan()
    samples = load(f"theta_i,phi_i,theta_o,phi_o,BRDF\n{rows([i, 0 * i, o, 180 + 0 * i, values])}")
    assert_is_truth(samples)


@pytest.mark.parametrize("before", ["Goniometer 7\nSample: red paint\nAOI,30,deg\n", "AOI: 30\n\nmeasured on Monday\n",
                                    "# Angle of incidence (deg) = 30\n", "theta_i;30°\n", "incidence angle\t30\n"])
def test_an_angle_that_is_said_once_before_the_names(load, before):
    o = SCAN
    text = before + "theta_o [deg],BRDF\n" + rows([o, truth(30, np.abs(o), np.where(o >= 0, 180, 0))])
    samples = load(text)
    assert_is_truth(samples)
    assert np.unique(samples.theta_i) == pytest.approx(np.radians(30))


@pytest.mark.parametrize("before", [
    "Goniometer report\nOperator;Smith\nDate;2024-05-01 10:30\n\n", "sep=;\n",
    "# a comment\nScan of paint, 30 degrees\n",
    "Sample: gold, theta_i and theta_r in degrees\n", '"Name";"Gold foil"\n'])
@pytest.mark.parametrize("units", ["", "deg;deg;deg;1/sr\n", "[°];[°];[°];\n", "(deg);(deg);(deg);(sr^-1)\n"])
def test_title_lines_and_a_line_of_units(load, before, units):
    small = [column / (100 if units else 1) for column in hemisphere()[:3]]
    samples = load(f"{before}theta_i;theta_o;phi;BRDF\n{units}{rows([*small, truth(*small)], ';')}")
    if units:                                   # the angles are too small to be told from radians
        assert np.degrees(samples.theta_o).max() == pytest.approx(0.8)
        expected = truth(*(np.degrees(each) for each in (samples.theta_i, samples.theta_o, samples.phi_o)))
        np.testing.assert_allclose(samples.values[:, 0], expected, rtol=1e-6)
    else:
        assert_is_truth(samples)
    assert samples.name == ("Gold foil" if "foil" in before else "gold, theta_i and theta_r in degrees"
                            if "gold" in before else "scan")


@pytest.mark.parametrize("encoding", ["utf-8", "latin-1", "utf-16", "utf-16-le", "utf-16-be", "utf-8-sig"])
def test_the_sign_of_degrees_behind_numbers_in_any_encoding(load, encoding):
    i, o, apart = (column / 100 for column in hemisphere()[:3])
    text = "theta_i;theta_o;phi;BRDF\r\n" + "".join(
        f"{a:.6g}°;{b:.6g} °;{c:.6g};{d:.8g}\r\n" for a, b, c, d in zip(i, o, apart, truth(i, o, apart), strict=True))
    if encoding in ("utf-16-le", "utf-16-be"):      # told by its zeros
        text = text.replace("°", "")
        text = text.replace("theta_i;", "theta_i[deg];").replace("theta_o;", "theta_o[deg];")
    samples = load(text.encode(encoding))
    assert np.degrees(samples.theta_o).max() == pytest.approx(0.8)
    np.testing.assert_allclose(samples.values[:, 0], truth(*(np.degrees(each) for each in (
        samples.theta_i, samples.theta_o, samples.phi_o))), rtol=1e-6)


# what a column of values, and the others, prove: the cells as they are written, and what they mean
PROOFS = {
    "a point with one digit": (["987.5", "1,234", "12,345.5", "2"], [987.5, 1234, 12345.5, 2]),
    "a point, and thousands alone": (["0.5", "1,234"], [0.5, 1234]),
    "a comma that no thousands begin with": (["0,5", "1,234"], [0.5, 1.234]),
    "a comma, and points that group": (["1.234,5", "12.345"], [1234.5, 12345]),
    "two commas": (["1,234,567", "1,234"], [1234567, 1234]),
    "an exponent": (["1,5e2", "1,234"], [150, 1.234]),
    "apostrophes": (["1'234.5", "987.25"], [1234.5, 987.25])}


@pytest.mark.parametrize(("cells", "numbers"), PROOFS.values(), ids=PROOFS)
@pytest.mark.parametrize("quote", ['"', ""])
def test_a_column_proves_its_own_decimal_sign(load, cells, numbers, quote):
    separator = "," if quote else ";"
    directions = [(10 + k, 20, 180) for k in range(len(cells))]
    samples = load(separator.join(["theta_i", "theta_o", "phi", "BRDF"]) + "\n" + "".join(
        separator.join([*map(str, row), f"{quote}{cell}{quote}"]) + "\n"
        for row, cell in zip(directions, cells, strict=True)))
    np.testing.assert_allclose(samples.values[:, 0], numbers)


def test_a_column_that_proves_nothing_is_written_as_the_others(load):
    assert load("theta_i;theta_o;phi;BRDF\n30.5;20;180;1,234\n").values[0, 0] == 1234
    assert load("theta_i;theta_o;phi;BRDF\n30,5;20;180;1,234\n").values[0, 0] == pytest.approx(1.234)
    alone = load("theta_i;theta_o;phi;BRDF\n30;20;180;1,234\n40;20;180;2\n")
    assert alone.values[0, 0] == pytest.approx(1.234)
    assert "BRDF: 1,234 is read as 1.234, since no number proves the comma to group thousands" in alone.notes


def test_a_column_that_proves_both_signs_is_refused(load):
    with pytest.raises(DatasetError, match=r"scan\.csv:3: '0\.5' found in the column 'BRDF', whose numbers above have "
                                           "another decimal sign"):
        load("theta_i;theta_o;phi;BRDF\n30;20;180;0,25\n40;20;180;0.5\n")


@pytest.mark.parametrize(("name", "times"), [
    ("reflectance_factor", np.pi), ("BRF", np.pi), ("Reflectance factor (%)", 100 * np.pi), ("R [%]", 100 * np.pi),
    ("550 nm (%)", 100 * np.pi), ("BRDF [%/sr]", 100), ("Reflectance [%]", 100 * np.pi), ("HDRF", np.pi)])
def test_reflectance_factors_and_percent_are_converted(load, name, times):
    *angles, values = hemisphere()
    names, columns = [name], [values * times]
    if name.startswith("R ["):
        names, columns = [name, "G [%]", "B [%]"], [values * times] * 3
    assert_is_truth(load(f"theta_i,theta_o,phi,{','.join(names)}\n{rows([*angles, *columns])}"))


def test_percent_behind_numbers_and_in_a_comment(load):
    *angles, values = hemisphere()
    text = "theta_i,theta_o,phi,Reflectance factor\n" + "".join(
        f"{i},{o},{apart},{100 * np.pi * each:.9g}%\n" for i, o, apart, each in zip(*angles, values, strict=True))
    assert_is_truth(load(text))
    assert_is_truth(load(f"# values: reflectance factor\ntheta_i,theta_o,phi,value\n{rows([*angles, np.pi * values])}"))


@pytest.mark.parametrize("name", ["reflectance", "BRDF [%]"])
def test_values_that_may_be_several_things_are_asked_for(load, name):
    *angles, values = hemisphere()
    text = f"theta_i,theta_o,phi,{name}\n{rows([*angles, 100 * np.pi * values])}"
    with pytest.raises(UnitsUnknownError, match="the BRDF or a reflectance factor, which is pi times as much"):
        load(text)
    assert_is_truth(load(text, quantity="reflectance_percent"))
    assert_is_truth(load(text, quantity="brdf_percent"), times=np.pi)


@pytest.mark.parametrize("names", [
    "700nm,600nm,500nm,400nm", "0.7 µm,0.6 µm,0.5 µm,0.4 µm", "0.7,0.6,0.5,0.4",
    "BRDF_700nm,BRDF_600nm,BRDF_500nm,BRDF_400nm",
    "R700,R600,R500,R400", "700 [nm],600 [nm],500 [nm],400 [nm]", "0.70um,0.60um,0.50um,0.40um"])
def test_falling_wavelengths_and_micrometres(load, names):
    """As the same spectrum with rising nanometres."""
    *angles, values = hemisphere()
    spectrum = [values * share for share in (1, 0.5, 0.3, 0.2)]
    falling = load(f"theta_i,theta_o,phi,{names}\n{rows([*angles, *spectrum])}")
    rising = load(f"theta_i,theta_o,phi,400nm,500nm,600nm,700nm\n{rows([*angles, *spectrum[::-1]])}")
    np.testing.assert_allclose(falling.values, rising.values, rtol=1e-9)
    assert falling.values[0, 0] > 1.5 * falling.values[0, 2]


@pytest.mark.parametrize("micrometres", [False, True])
def test_a_row_for_each_wavelength(load, micrometres):
    *angles, values = hemisphere()
    bands = np.repeat([700, 500, 600, 400], len(values)) / (1000 if micrometres else 1)
    table = [*(np.tile(angle, 4) for angle in angles), bands, np.tile(values, 4)]
    samples = load(f"theta_i,theta_o,phi,wavelength,BRDF\n{rows(table)}")
    assert_is_truth(samples)
    assert samples.channels == ("R", "G", "B")
    assert len(samples) == len(values)


@pytest.mark.parametrize(("table", "expected"), [
    ("10,20,0,500,1\n30,20,0,600,1\n", "no pair of directions has all wavelengths"),
    ("10,20,0,500,1\n30,20,0,600,1\n50,20,0,700,1\n", "3 wavelengths at 3 pairs of directions in 3 rows")])
def test_rows_whose_directions_share_no_wavelengths_are_refused(load, table, expected):
    with pytest.raises(DatasetError, match=rf"scan\.csv:1: {expected}"):
        load(f"theta_i,theta_o,phi,wavelength,BRDF\n{table}")


def test_columns_beside_the_measurement_are_passed_over(load):
    i, o, apart, values = hemisphere()
    text = "No.,time,theta_i,theta_o,phi,BRDF,comment\n" + "".join(
        f"{k},10:{k % 60:02},{a},{b},{c},{d:.9g},fine\n"
        for k, (a, b, c, d) in enumerate(zip(i, o, apart, values, strict=True)))
    assert_is_truth(load(text))


@pytest.mark.parametrize("head", ["", "alpha;beta;gamma;delta;intensity\n", "a report\nwithout names\n",
                                  "theta_i;x;y;z;f\n"])
def test_columns_are_what_a_user_says(load, head):
    i, o, apart, values = hemisphere()
    text = head + rows([i, 7 + 0 * i, o, apart, values], ";")
    with pytest.raises(ColumnsUnknownError, match="option columns"):
        load(text)
    samples = load(text, columns="theta_i[deg],-,theta_o[deg],phi[deg],BRDF")
    assert_is_truth(samples)
    assert_is_truth(load(text, columns="AOI[deg], ,AOS[deg],phi[deg],BRDF*cos_o", quantity="brdf"))


@pytest.mark.parametrize(("columns", "expected"), [
    ("theta_i,theta_o", "expected also values"), ("theta_i,theta_o,humidity,BRDF", "of which humidity means nothing"),
    ("theta_i,theta_i,theta_o,BRDF", "'theta_i' is the second column of its kind"),
    (",".join(["theta_i"] * 9), "no row of numbers for the columns"), ("", "columns '' found, expected names")])
def test_columns_that_a_user_says_wrongly(load, columns, expected):
    with pytest.raises(DatasetError, match=expected):
        load("1;2;3;4;5\n", columns=columns)


def test_columns_of_a_file_that_says_them_itself_have_no_effect(load):
    samples = load("VARS theta_i,phi_i,theta_s,phi_s,R,G,B\n0.5,0,0.5,3.1,0.1,0.2,0.6\n", columns="theta_i,theta_o")
    assert "Without effect on Cornell files: columns" in samples.notes


@pytest.mark.parametrize(("name", "meant"), [
    ("theta", "theta"), ("azimuthal angle", "phi"), ("phase angle", None), ("theta_h", None), ("theta_d", None),
    ("gold", None), ("", None), ("Incidence", "theta_i"), ("phi_R", "phi_s"), ("elevation", None)])
def test_what_names_mean_and_what_they_do_not(name, meant):
    assert role(name) == meant


@pytest.mark.parametrize("name", ["intensity", "humidity", "theta_i", "BRDF_s", "30", "2", "1e5", "nm", "", "R G",
                                  "12,5"])
def test_names_that_are_no_values(name):
    assert value(name) is None
    assert parse(name).text == name
