"""Tables of one's own: the same measurements, written as people write them, are read as the same numbers."""

import itertools

import numpy as np
import pytest

import fitter
from fitter import DatasetError
from fitter.quality.describe import describe

FILE = "table.csv"
DIRECTIONS = np.array([[30, 0, 10, 180], [30, 0, 45, 170], [60, 20, 20, 200], [0, 0, 70, 90], [15, 350, 85, 10]], float)
VALUES = np.array([[0.21, 0.18, 0.11], [0.09, 0.08, 0.05], [0.3, 0.25, 0.2], [0.02, 0.01, 0.04], [1.5, 1.25, 1]])


def write(names, columns, separator=",", number="{:.10g}".format, before=""):
    rows = [separator.join(number(cell) for cell in row) for row in np.column_stack(columns)]
    return before + "\n".join([separator.join(names), *rows]) + "\n"


def assert_is(samples, directions=DIRECTIONS, values=VALUES, channels=("R", "G", "B")):
    np.testing.assert_allclose(np.column_stack(samples.directions), np.radians(directions), atol=1e-8)
    np.testing.assert_allclose(samples.values, values, rtol=1e-8)
    assert samples.channels == channels


NAMES = ["theta_i", "phi_i", "theta_o", "phi_o", "R", "G", "B"]


def test_the_sign_of_percent_behind_numbers_tells_what_a_reflectance_is(load):
    rows = "30,10,180,50{0}\n30,20,180,40{0}\n30,30,180,45{0}\n"
    head = "theta_i[deg],theta_o[deg],phi[deg],reflectance\n"
    np.testing.assert_allclose(load(head + rows.format("%")).values[:, 0], np.array([0.5, 0.4, 0.45]) / np.pi)
    with pytest.raises(fitter.UnitsUnknownError, match="may be the BRDF or a reflectance factor"):
        load(head + rows.format(""))
    with pytest.raises(DatasetError, match="angles must all be in degrees"):
        load(head.replace("[deg]", "") + rows.format("%").replace("30,20", "30%,20"))


@pytest.mark.parametrize(("separator", "number"), [
    (",", "{:.10g}".format), (", ", "{:.10g}".format), ("\t", "{:.10g}".format), ("  ", "{:.10g}".format),
    (";", "{:.10g}".format), (";", lambda x: f"{x:.10g}".replace(".", ",")),
    ("\t", lambda x: f"{x:.10g}".replace(".", ",")), (",", '"{:.10g}"'.format), ("|", "{:.10g}".format),
    (" | ", "{:.10g}".format), (":", "{:.10g}".format), (":", lambda x: f"{x:.10g}".replace(".", ",")),
    ("|", lambda x: f"{x:.10g}".replace(".", ",")), (",", lambda x: f'"{x:.10g}"'.replace(".", ",")),
    (";", lambda x: f'"{x:.10g}"'.replace(".", ","))])
def test_any_separator_and_decimal_commas(load, separator, number):
    assert_is(load(write(NAMES, [DIRECTIONS, VALUES], separator, number)))


@pytest.mark.parametrize("names", [
    ["theta_in", "phi_in", "theta_r", "phi_r", "red", "green", "blue"],
    ["ThetaI", "PhiI", "ThetaV", "PhiV", "r", "g", "b"],
    ["theta_i[deg]", "phi_i[deg]", "theta_s[deg]", "phi_s[deg]", "BRDF_R", "BRDF_G", "BRDF_B"],
    ["zenith_in (degrees)", "azimuth_in (degrees)", "zenith_out (degrees)", "azimuth_out (degrees)", "R", "G", "B"]])
def test_the_columns_by_other_names_and_in_another_order(load, names):
    assert_is(load(write(names, [DIRECTIONS, VALUES])))
    order = [5, 2, 0, 6, 1, 3, 4]
    table = np.column_stack([DIRECTIONS, VALUES])
    assert_is(load(write([names[k] for k in order], [table[:, order]])))


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "latin-1"])
@pytest.mark.parametrize("unit", ["[°]", " (°)", "_°", "\u00a0[°]"])
def test_a_sign_of_degrees_is_a_unit(load, unit, encoding):
    small = DIRECTIONS / 1000                   # would be radians
    text = write([name + unit for name in NAMES[:4]] + NAMES[4:], [small, VALUES])
    assert_is(load(text.encode(encoding)), small)
    assert_is(load(write(NAMES, [small, VALUES], before="# angles: °\n").encode(encoding)), small)


@pytest.mark.parametrize(("said", "separator"), [("sep=;", ";"), ('"sep=;"', ";"), ("sep=,", ","), ("sep=|", "|"),
                                                 ("sep=\t", "\t"), ("sep=&", "&")])
def test_the_line_in_which_excel_says_the_separator(load, said, separator):
    assert_is(load(write(NAMES, [DIRECTIONS, VALUES], separator, before=f"{said}\r\n")))
    with pytest.raises(DatasetError, match=r"table\.csv:4: 'x' found"):
        load(f"{said}\n{separator.join(NAMES)}\n" + "".join(f"{separator.join(row)}\n" for row in (
            ["30", "0", "10", "180", "1", "1", "1"], ["30", "0", "10", "180", "1", "1", "x"])))


@pytest.mark.parametrize("encoding", ["utf-8", "latin-1"])
@pytest.mark.parametrize("separator", [";", "\t", "  "])
def test_no_break_spaces_group_the_digits_of_numbers(load, separator, encoding):
    """As French and Swiss spreadsheets write thousands, and as browsers copy cells."""
    large = VALUES * [1e4, 1e5, 1e6]

    def grouped(number):
        return f"{number:,.3f}".replace(",", "\u00a0").replace(".", ",") + "\u00a0"

    text = write(NAMES, [DIRECTIONS, large], separator, grouped)
    assert "\u00a0" in text
    assert_is(load(text.encode(encoding)), values=large)
    if encoding == "utf-8":
        assert_is(load(text.replace("\u00a0", "\u202f")), values=large)


def test_radians_are_declared_in_the_names_or_in_a_comment(load):
    columns = [np.radians(DIRECTIONS), VALUES]
    assert_is(load(write(["theta_i_rad", "phi_i_rad", "theta_o_rad", "phi_o_rad", "R", "G", "B"], columns)))
    assert_is(load(write(NAMES, columns, before="# angles: radians\n")))


def test_degrees_that_could_be_radians_are_asked_for(load):
    columns = [DIRECTIONS[:1] / [30, 1, 10, 180], VALUES[:1]]
    with pytest.raises(DatasetError, match=r"table\.csv:2: .*degrees or radians.*\[deg\]"):
        load(write(NAMES, columns, before="# mine\n"))
    assert_is(load(write(NAMES, columns, before="# angles: degrees\n")), DIRECTIONS[:1] / [30, 1, 10, 180], VALUES[:1])


@pytest.mark.parametrize(("of", "column"), [("i", 0), ("o", 2)])
@pytest.mark.parametrize("way", ["{0}*cos_{1}", "{0} * cos(theta_{1})", "comment"])
def test_a_cosine_in_the_values_is_divided_out(load, of, column, way):
    values = VALUES * np.cos(np.radians(DIRECTIONS[:, column]))[:, None]
    names = [*NAMES[:4], *("RGB" if way == "comment" else [way.format(channel, of) for channel in "RGB"])]
    before = f"# values: BRDF * cos_{of}\n" if way == "comment" else ""
    samples = load(write(names, [DIRECTIONS, values], before=before))
    assert_is(samples)
    assert f"Divided by the cosine of theta_{of}" in samples.notes


@pytest.mark.parametrize(("before", "reflected"), [("", 1), ("# standard: 0.98\n", 0.98)])
def test_values_are_divided_by_a_standard(load, before, reflected):
    standard = np.array([100, 90, 80, 120, 60.0])
    counts = VALUES * np.pi / reflected * standard[:, None]
    samples = load(write([*NAMES, "standard"], [DIRECTIONS, counts, standard], before=before))
    assert_is(samples)
    assert f"standard of reflectance {reflected:g}" in " ".join(samples.notes)


def test_rows_with_empty_cells_are_left_out_and_told(load):
    cells = ["", " ", "NaN", "NA", "n/a", "-", '""', "#N/A", "#DIV/0!", "#VALUE!", "#REF!", "#NUM!", "1.#QNAN"]
    for empty, separator, column in itertools.product(cells, ",;\t", [0, 4, 6]):
        table = np.column_stack([DIRECTIONS, VALUES]).astype(str).tolist()
        table[1][column] = empty
        samples = load("\n".join(separator.join(row) for row in [NAMES, *table]))
        assert_is(samples, np.delete(DIRECTIONS, 1, 0), np.delete(VALUES, 1, 0))
        assert "1 of 5 rows have empty cells and are left out" in samples.notes, (empty, separator, column)


def test_what_was_measured_again_is_averaged_and_its_scatter_told(load):
    again = DIRECTIONS[2] + [0, 360, 0, 0]
    directions = np.vstack([DIRECTIONS, again, again])
    values = np.vstack([VALUES, VALUES[2] * 1.1, VALUES[2] * 0.9])
    samples = load(write(NAMES, [directions, values]))
    assert_is(samples)
    note = next(note for note in samples.notes if "more than once" in note)
    assert note.startswith("1 pair of directions measured")
    assert note.endswith("a scatter of 10 %")
    # one of them is the mean of three; all are taken to scatter like it
    expected = np.full(len(DIRECTIONS), 0.1)
    expected[2] /= np.sqrt(3)
    np.testing.assert_allclose(samples.deviation, expected, rtol=1e-9)
    assert ("Read", note, False) in describe(samples).rows()


def test_a_pair_that_scatters_more_than_others_is_trusted_less(load, random):
    """Of 40 measurements each the deviation is that of their mean."""
    noise = np.array([0.01, 0.01, 0.2, 0.01, 0.01])
    many = np.vstack([VALUES * (1 + noise[:, None] * random.standard_normal((len(VALUES), 1))) for _ in range(40)])
    samples = load(write(NAMES, [np.vstack([DIRECTIONS] * 40), many]))
    np.testing.assert_allclose(samples.deviation[2], 0.2 / np.sqrt(40), rtol=0.3)
    assert (samples.deviation[[0, 1, 3, 4]] < 0.3 * samples.deviation[2]).all()


def test_what_an_instrument_adds_to_dark_directions_is_no_noise_of_bright_ones(load, random):
    """400 pairs, three times each: .1 % of their value, and .0003 / sr that is most of what the darkest tenth has."""
    directions = np.column_stack([70 * random.random(400), np.zeros(400), 70 * random.random(400), np.full(400, 90.0)])
    values = np.where(np.arange(400) % 10 == 0, 1e-4, 0.5)[:, None] * np.ones(3)
    again = [values * (1 + 1e-3 * random.standard_normal((400, 1))) + 3e-4 * random.standard_normal((400, 1))
             for _ in range(3)]
    samples = load(write(NAMES, [np.vstack([directions] * 3), np.vstack(again)]))
    expected = np.hypot(1e-3, 3e-4 / 0.5) / np.sqrt(3)
    bright = samples.values[:, 0] > 0.1
    assert bright.sum() == 360
    assert np.median(samples.deviation[bright]) == pytest.approx(expected, rel=0.3)
    assert np.median(samples.deviation[~bright]) > 0.3


@pytest.mark.parametrize(("said", "name"), [("cosine-corrected BRDF", "R"), ("BRDF * cos", "R"), ("cos_o * BRDF", "R"),
                                            ("", "BRDF*cos")])
def test_a_cosine_that_is_not_understood_is_not_passed_over(load, said, name):
    with pytest.raises(DatasetError, match=r"values with a cosine must name it.* BRDF\*cos_i or BRDF\*cos_o"):
        load(write([*NAMES[:4], name], [DIRECTIONS, VALUES[:, :1]], before=f"# values: {said}\n"))


def test_comments_byte_order_marks_and_line_ends(load):
    text = write(NAMES, [DIRECTIONS, VALUES], before="# name: Gold foil\n\n# measured on Monday\n")
    lines = text.splitlines()
    samples = load(b"\xef\xbb\xbf" + "\r\n".join([*lines[:6], "# a break", *lines[6:]]).encode() + b"\r\n\r\n")
    assert_is(samples)
    assert samples.name == "Gold foil"


def test_trailing_separators_do_not_count(load):
    text = write(NAMES, [DIRECTIONS, VALUES], ";")
    assert_is(load("\n".join(line + ";;" for line in text.splitlines())))


@pytest.mark.parametrize(("names", "rows", "expected"), [
    ("theta_i,phi_i,R,G,B", "30,0,1,1,1", r":1: .*expected also theta_o, phi_o or phi"),
    ("theta_i,theta_o,phi", "30,0,1", r":1: .*expected also values"),
    ("theta_i,theta_o,theta_r,phi,R", "30,30,30,180,1", r":1: 'theta_r' is the second"),
    ("theta_i,theta_o,phi,R,humidity", "30,30,180,1,40",
     r":1: columns theta_i, .*, of which humidity means nothing here; .*option columns"),
    ("theta_i,theta_o,phi,BRDF", "30,30,180,1\n30,x,180,1", r":3: 'x' found, expected a number"),
    ("theta_i,theta_o,phi,BRDF", "30,30,180,1\n30,40,180,1,2", r":3: more than 4 cells found, expected one for each"),
    ("theta_i,theta_o,phi,BRDF", "30,30,180,1\n\n30,95,180,1", r":4: a polar angle of 95 found"),
    ("theta_i,theta_o,phi,BRDF", "30,30,180,1e999", r":2: '1e999' found, expected a finite number"),
    ("theta_i,theta_o,phi,BRDF", "30,30,180,", r":1: 1 rows found, none of them complete"),
    ("theta_i,theta_o,phi,BRDF", "", r":1: 0 rows found, none of them complete"),
    ("theta_i,theta_o,phi,R;G;B", "30,30,180,1;2;3", r"expected"),
    ("theta_i,theta_o,phi,BRDF,standard", "30,30,180,1,0", r":2: the standard reads 0"),
    ("theta_i[deg],theta_o[rad],phi,BRDF", "30,1,180,1", r"all be in degrees, or all in radians")])
def test_a_bad_table_is_refused_with_its_line(load, names, rows, expected):
    with pytest.raises(DatasetError, match=r"table\.csv.*" + expected):
        load(f"{names}\n{rows}\n")


def test_real_measurements_written_as_a_table_are_the_same(load, cornell):
    samples = cornell("garnet_red_RGB")
    table = load(write(["theta_i[rad]", "phi_i[rad]", "theta_o[rad]", "phi_o[rad]", "R", "G", "B"],
                       [*samples.directions, samples.values], ";", lambda x: repr(float(x)).replace(".", ",")))
    unique = np.unique(np.round(np.column_stack(samples.directions), 6), axis=0)
    assert len(table) == len(unique)
    if len(unique) == len(samples):
        np.testing.assert_array_equal(table.values, samples.values)


@pytest.mark.parametrize(("text", "says"), [
    ("alpha;beta;gamma\n1;2;3\n", "columns alpha, beta, gamma found; expected theta_i, theta_o, phi"),
    ("# mine\nangle,BRDF\n0.1,0.2\n0.3,0.4\n",
     "columns angle, BRDF found, expected also theta_i, theta_o; .*option columns"),
    ("0.5 0.0 0.5 3.14 0.2\n0.5 0.0 0.6 3.14 0.1\n", "5 columns of numbers without names found; .*option columns"),
    ("30;0;45,5;180;0,2\r\n", "5 columns of numbers without names found"),
    ("1,2\n3,4\n", "in no known format"), ("alpha beta\ngamma delta\n", "in no known format"),
    ("Tuesday: measured\nthe blue one: again\n", "in no known format")])
def test_a_table_whose_columns_mean_nothing_is_told_which_are_needed(load, text, says):
    with pytest.raises(DatasetError, match=says):
        load(text)


ON_ITS_SIDE = [",".join([name, *(f"{x:g}" for x in column)]) for name, column in zip(
    ["Incidence", "Azimuth in", "Receive", "Azimuth out", "R", "G", "B"], np.column_stack([DIRECTIONS, VALUES]).T,
    strict=True)]


@pytest.mark.parametrize("lines", [
    ON_ITS_SIDE, ["A report", "Operator,Ann", *ON_ITS_SIDE, "", "End of report"],
    [line.replace(",", ";").replace(".", ",") for line in ON_ITS_SIDE], [line + ",," for line in ON_ITS_SIDE],
    [*ON_ITS_SIDE[:4], "Filter,green,green,green,blue,blue", *ON_ITS_SIDE[4:]],
    [line.replace(",", f",{unit},", 1) for line, unit in zip(ON_ITS_SIDE, ["deg"] * 4 + ["1/sr"] * 3, strict=True)],
    [",".join(line.split(",")[:1] + line.split(",")[k:k + 2 + (k == 3)]) for k in (1, 3) for line in ON_ITS_SIDE]],
    ids=["plain", "titles", "semicolons", "empty cells", "text", "units", "parts"])
def test_a_table_that_lies_on_its_side_is_read(load, lines):
    samples = load("\n".join(lines) + "\n")
    assert_is(samples)
    assert samples.notes[0] == "The table lies on its side: a line for each name"
    assert ("Columns of text are not read: Filter" in samples.notes) == any("Filter" in line for line in lines)


@pytest.mark.parametrize(("lines", "expected"), [
    ([*ON_ITS_SIDE[:4], "R,1,2,x,4,5"], r"in a table that lies on its side \(column 4\): 'x' found, expected a number"),
    (ON_ITS_SIDE[:4], r"on its side: .*expected also values"),
    (ON_ITS_SIDE[:2] + ON_ITS_SIDE[4:], r"on its side: .*expected also theta_o"),
    ([*ON_ITS_SIDE, "humidity,1,2,3,4,5"], r"on its side: .*of which humidity means nothing")])
def test_a_bad_table_on_its_side_is_refused(load, lines, expected):
    with pytest.raises(DatasetError, match=r"table\.csv: .*" + expected):
        load("\n".join(lines) + "\n")


def test_columns_of_text_that_mean_nothing_are_left_out(load):
    text = write(NAMES, [DIRECTIONS, VALUES])
    lines = [f"{line},{'Filter' if number == 0 else 'green'}" for number, line in enumerate(text.splitlines())]
    samples = load("\n".join(lines))
    assert_is(samples)
    assert "Columns of text are not read: Filter" in samples.notes
