"""Options of reading: what a user says of a file's numbers, where the file does not say it or says something else."""

import json
from pathlib import Path

import numpy as np
import pytest

import fitter
from fitter import DatasetError, UnitsUnknownError, cli, formats
from fitter.formats import FORMATS, reading, spectra, utia
from fitter.formats import text as text_of_files
from fitter.samples import SYMMETRIES
from tools import fuzz

ROWS = np.array([[0.5, 0.0, 0.25, 3.0, 0.2], [1.0, 0.5, 0.75, 2.0, 0.4]])
ASTM, TABLE = "VARS theta_i,phi_i,theta_s,phi_s,BRDF\n", "theta_i,phi_i,theta_o,phi_o,BRDF\n"
KINDS = pytest.mark.parametrize("head", [ASTM, TABLE], ids=["astm", "table"])


@pytest.fixture
def load(tmp_path):
    def load(head, rows=ROWS, before="", **options):
        path = tmp_path / "measured.txt"
        path.write_text(before + head + "".join(",".join(map(repr, row)) + "\n" for row in np.asarray(rows).tolist()))
        return fitter.load(path, **options)
    return load


@KINDS
@pytest.mark.parametrize(("angles", "factor"), [("degrees", np.pi / 180), ("radians", 1)])
def test_angles_are_in_the_unit_that_is_asked_for(load, head, angles, factor):
    samples = load(head, angles=angles)
    np.testing.assert_allclose(np.column_stack(samples.directions), ROWS[:, :4] * factor, rtol=1e-12)
    assert samples.notes == (f"Angles in {angles}, as asked",)


@KINDS
@pytest.mark.parametrize(("quantity", "column"), [("brdf_cos", 2), ("brdf_cos_i", 0)])
def test_a_cosine_that_is_asked_for_is_divided_out(load, head, quantity, column):
    samples = load(head, angles="radians", quantity=quantity)
    np.testing.assert_allclose(samples.values[:, 0], ROWS[:, 4] / np.cos(ROWS[:, column]), rtol=1e-12)
    assert samples.notes[1:] == (f"Divided by the cosine of theta_{'o' if column else 'i'}, as asked",)


def test_options_win_over_the_file_and_the_notes_say_so(load):
    head = TABLE.replace("theta_i", "theta_i[rad]").replace("BRDF", "BRDF*cos_o")
    plain = load(head)
    np.testing.assert_allclose(plain.values[:, 0], ROWS[:, 4] / np.cos(ROWS[:, 2]))
    asked = load(head, angles="degrees", quantity="brdf")
    np.testing.assert_allclose(np.column_stack(asked.directions), np.radians(ROWS[:, :4]))
    np.testing.assert_array_equal(asked.values[:, 0], ROWS[:, 4])
    assert asked.notes == ("Angles in degrees, as asked; the file says rad",
                           "Values are the BRDF, as asked; the file says otherwise")
    names = "VARS theta_i[deg],phi_i[deg],theta_s[deg],phi_s[deg],BRDF\n"
    assert load(names, angles="radians").notes == ("Angles in radians, as asked; the file says deg",)


def test_a_wrong_option_is_noticed_where_it_makes_no_direction(load):
    with pytest.raises(DatasetError, match="polar angle of 45 found"):
        load(TABLE, [[45, 0, 45, 180, 0.2]], angles="radians")


def test_a_table_without_units_asks_for_the_option(load):
    with pytest.raises(UnitsUnknownError, match=r"txt:1: .*option angles .*import, Angles.*theta_i\[deg\]"):
        load(TABLE)
    with pytest.raises(UnitsUnknownError, match=r"option quantity .*import, Values"):
        load(TABLE.replace("BRDF", "BRDF*cos"), angles="radians")
    assert load(TABLE.replace("BRDF", "BRDF*cos"), angles="radians", quantity="brdf_cos").notes[-1] == (
        "Divided by the cosine of theta_o, as asked")


def test_units_that_contradict_one_another_are_settled_by_the_option(load):
    head = TABLE.replace("theta_i", "theta_i[rad]")
    with pytest.raises(DatasetError, match="all in radians") as raised:
        load(head, before="# angles: degrees\n")
    assert not isinstance(raised.value, UnitsUnknownError)
    assert load(head, before="# angles: degrees\n", angles="radians").notes == (
        "Angles in radians, as asked; the file says deg and rad",)


@pytest.mark.parametrize(("option", "value", "expected"), [
    ("angles", "grad", "angles 'grad' found, expected degrees or radians"), ("angles", "", "angles '' found"),
    ("quantity", "btdf", "quantity 'btdf' found, expected brdf, brdf_cos, brdf_cos_i, reflectance_factor, "
                            "reflectance_percent or brdf_percent"),
    ("quantity", 3, "quantity 3 found")])
def test_an_option_with_another_value_is_refused(load, option, value, expected):
    with pytest.raises(DatasetError, match=expected):
        load(ASTM, **{option: value})


@pytest.mark.parametrize("name", sorted(fuzz.seeds()))
def test_formats_that_define_their_units_ignore_the_options(tmp_path, name):
    path = tmp_path / "measured"
    path.write_bytes(fuzz.seeds()[name])
    try:
        plain = fitter.load(path)
    except DatasetError:
        pytest.skip("a seed that is refused")
    known = next(known for known in FORMATS if known.recognises(path.read_bytes()))
    asked = fitter.load(path, quantity="brdf_cos_i")
    follows = "quantity" in known.options
    assert np.array_equal(plain.values, asked.values) != follows
    assert ("Divided by the cosine of theta_i, as asked" in " ".join(asked.notes)) == follows


def test_a_file_is_read_once(load, monkeypatch):
    times = []
    monkeypatch.setattr(formats, "read_bytes",
                        lambda *arguments: times.append(1) or text_of_files.read_bytes(*arguments))
    load(ASTM, angles="radians", quantity="brdf_cos", colours="ACEScg", illuminant="A")
    assert times == [1]


def test_spectra_of_every_text_format_follow_the_illuminant(tmp_path):
    bands, ramp = np.arange(400, 701, 50), np.linspace(0.1, 0.7, 7)
    numbers, names = ",".join(map(repr, ramp.tolist())), ",".join(f"{band}nm" for band in bands)
    texts = {"VARS": f"VARS theta_i,phi_i,theta_s,phi_s,{names}\n0.5,0,0.5,3,{numbers}",
             "table": f"theta_i[rad],theta_o[rad],phi[rad],{names}\n0.5,0.5,3,{numbers}",
             "pbrt": f"7\n{' '.join(map(str, bands))}\n0.5 0 0.5 3 {numbers.replace(',', ' ')}"}
    for kind, text in texts.items():
        path = tmp_path / kind
        path.write_text(text)
        expected = spectra.srgb_weights(bands.astype(float), "A") @ ramp
        np.testing.assert_allclose(fitter.load(path, illuminant="A").values[0], expected, rtol=1e-12, err_msg=kind)
        assert fitter.load(path, illuminant="A").notes[-1] == "Spectra seen under the illuminant A"


def test_a_note_names_the_options_that_a_format_does_not_have(tmp_path):
    path = tmp_path / "paint.brdf"
    path.write_text("3\n400 550 700\n0.5 0 0.5 3 0.1 0.2 0.3")
    options = {"angles": "degrees", "quantity": "brdf", "illuminant": "A", "symmetry": "mirror", "isotropic": True}
    assert "Without effect on pbrt-v2 files: angles, quantity, symmetry" in fitter.load(path, **options).notes
    assert ("Without effect on published fits: angles, quantity, illuminant, symmetry"
            in fitter.load("published:chrome", **options).notes)
    for each in (path, "published:chrome"):
        assert not any("Without effect" in note for note in fitter.load(each, isotropic=True).notes)


def test_the_choices_of_an_option_are_what_readers_know():
    known = {"angles": ("degrees", "radians"), "quantity": tuple(reading.QUANTITIES), "symmetry": SYMMETRIES,
             "illuminant": spectra.ILLUMINANTS, "encoding": tuple(utia._NOTES), "isotropic": (True, False),
             "keep_unmeasured": (True, False), "columns": ()}
    assert {name: option.values for name, option in reading.OPTIONS.items()} == known


@pytest.mark.parametrize("name", reading.OPTIONS)
def test_what_blender_stores_of_an_option_is_what_load_takes(name):
    option = reading.OPTIONS[name]
    for value in (*option.values, option.default, *(() if option.values else ("theta_i,-,BRDF",))):
        assert option.value(option.to_stored(value)) == value
        assert isinstance(option.to_stored(value), bool if isinstance(option.default, bool) else str)
    assert option.value("") == option.default           # an identifier that is not known any more


def test_command_line_and_page_have_every_option_and_what_it_may_be(capsys):
    with pytest.raises(SystemExit):
        cli.main(["info", "--help"])
    said = " ".join(capsys.readouterr().out.split())
    page = (Path(fitter.__file__).parents[1] / "docs" / "formats.md").read_text("utf-8")
    for name, option in reading.OPTIONS.items():
        flag = f"--{name.replace('_', '-')}"
        assert flag in said
        assert flag in page
        for value in option.values if option.choices else ():
            assert {True: "yes:", False: "no:"}.get(value, f"{value}:") in said
            assert (str if isinstance(value, bool) else json.dumps)(value) in page


def test_an_option_that_is_not_there_is_no_option(load):
    with pytest.raises(TypeError, match="angle"):
        load(ASTM, angle="degrees")
