"""Directions that are counted in another way are asked about, and those of real measurements are not."""

from dataclasses import replace

import numpy as np
import pytest

import fitter
from fitter import Samples, cli
from fitter.formats import list_samples, saved_samples
from fitter.quality.conventions import questions
from support.checkout import measurements

MIRROR, ELEVATION = "is phi counted from the mirror's side?", "are these elevations, in the place of angles"
GLOSSY = ("cornell/garnet_red_RGB.astm", "cornell/krylon_blue_RGB.astm", "goniometer/lighttec_C9_Gold.astm",
          "rgl/aurora_white_rgb.bsdf", "rgl/cm_military_green_rgb.bsdf")


def from_mirror(samples):
    return replace(samples, phi_o=samples.phi_o + np.pi)


def as_elevations(samples):
    return replace(samples, theta_i=np.pi / 2 - samples.theta_i, theta_o=np.pi / 2 - samples.theta_o)


def real(name):
    path = measurements() / name
    if not path.is_file():
        pytest.skip(f"{path} is not there")
    return fitter.load(path)


@pytest.mark.parametrize("name", GLOSSY)
def test_what_a_glossy_surface_betrays(name):
    samples = real(name)
    assert questions(samples) == ()
    (question,) = questions(from_mirror(samples))
    assert question.endswith(MIRROR)
    (question,) = questions(as_elevations(samples))
    assert ELEVATION in question


@pytest.mark.parametrize(("change", "asked"), [(from_mirror, MIRROR), (as_elevations, ELEVATION)])
def test_what_is_asked_of_directions_is_asked_of_a_fit_that_matches_them(cornell, tmp_path, capsys, change, asked):
    path = tmp_path / "turned.npz"
    saved_samples.write(change(cornell("garnet_red_RGB")), path)
    assert cli.main(["fit", str(path), "-o", str(tmp_path / "fit.npz"), "--preset", "Draft"]) == cli.BAD
    told = capsys.readouterr().out
    assert "Matches the measurements: poor" not in told
    (line,) = [line for line in told.splitlines() if line.endswith("(!)")]
    assert asked in line
    assert line.startswith("  Garnet Red: ")


@pytest.mark.parametrize("folder", ["cornell", "goniometer", "rgl"])
def test_nothing_is_asked_of_real_measurements(folder):
    files = [path for path in sorted((measurements() / folder).glob("*"))
             if path.suffix in (".astm", ".brdf", ".bsdf", ".mbsdf", ".anisotropicbsdf", ".txt")]
    if not files:
        pytest.skip(f"{folder} is absent")
    assert {path.name: questions(fitter.load(path)) for path in files} == {path.name: () for path in files}


def test_nothing_is_asked_of_the_samples_of_curet(data):
    """Plaster, velvet and stones shine back more than forward."""
    path = data / "curet" / "abrdf.dat"
    asked = {name: found for number, name in list_samples(path) if (found := questions(fitter.load(path, number)))}
    assert asked == {}


def lit(value, theta_i=(10, 20, 30, 40, 50, 60), theta_o=range(0, 81, 10), phi=range(0, 181, 15)):
    """Samples of a function of the cosines of both angles and of the angles from the mirror direction and the light."""
    i, o, turn = np.radians(np.stack(np.meshgrid(theta_i, theta_o, phi)).reshape(3, -1))
    up, along = np.cos(i) * np.cos(o), np.sin(i) * np.sin(o) * np.cos(turn)
    mirror, light = (np.degrees(np.arccos(np.clip(up + sign * along, -1, 1))) for sign in (-1, 1))
    return Samples(i, 0 * i, o, turn, value(np.cos(i), np.cos(o), mirror, light)[:, None])


@pytest.mark.parametrize("width", [3, 12])
def test_nothing_is_asked_of_a_retro_reflector(width):
    """Glass beads: of the light that falls on them less returns the more it grazes (ASTM D4956, type I: 70 at 4 degrees
    from the normal, 30 at 30)."""
    def beads(cos_i, cos_o, _, light):
        return 0.05 + 20 * np.exp(-(light / width) ** 2) * cos_i ** 5.9 / cos_o
    samples = lit(beads)
    backward = samples.values[(samples.theta_i == samples.theta_o) & (samples.phi_o == 0), 0]
    assert backward.max() > 50 * np.median(samples.values)
    assert questions(samples) == ()


@pytest.mark.parametrize("value", [
    lambda cos_i, *_: np.full(len(cos_i), 0.3), lambda cos_i, cos_o, *_: 0.1 + 0.05 / (cos_i + cos_o),
    lambda cos_i, *_: np.zeros(len(cos_i)), lambda cos_i, *_: np.full(len(cos_i), -0.1)],
    ids=["matte", "dusty", "black", "below 0"])
def test_nothing_is_asked_of_what_has_no_highlight(value):
    assert questions(lit(value)) == ()


@pytest.mark.parametrize("count", [1, 2, 5])
def test_few_samples_say_nothing(count):
    angles = np.linspace(0.1, 1.2, count)
    assert questions(Samples(angles, 0 * angles, angles, 0 * angles, np.full((count, 1), 0.3))) == ()


def table(folder, rows, names="theta_i[deg],theta_o[deg],phi[deg],BRDF"):
    """A table of polar angles, the azimuth between the directions, and a value."""
    path = folder / "table.csv"
    path.write_text(f"{names}\n" + "".join(",".join(f"{x:.6f}" for x in row) + "\n" for row in rows))
    return path


@pytest.mark.parametrize(("change", "expected"), [(from_mirror, MIRROR), (as_elevations, ELEVATION)])
def test_info_marks_the_question(tmp_path, capsys, change, expected):
    """A table of a highlight over a Lambertian, which is the brighter, the more the light grazes."""
    def paint(cos_i, cos_o, mirror, _):
        return 0.05 + 0.4 * np.exp(-(mirror / 15) ** 2) / (cos_i * cos_o + 0.01)
    samples = lit(paint)
    for shown, asked in ((samples, False), (change(samples), True)):
        rows = np.column_stack([*np.degrees([shown.theta_i, shown.theta_o, shown.phi_o]), shown.values])
        assert cli.main(["info", str(table(tmp_path, rows))]) == 0
        marked = [line for line in capsys.readouterr().out.splitlines() if expected in line]
        assert len(marked) == asked
        assert all(line.startswith("  Angles") and line.endswith("(!)") for line in marked)


@pytest.mark.parametrize(("again", "asked"), [(1.0, 0), (1.3, 0), (2.9, 0), (3.1, 1), (100.0, 1)])
def test_values_of_one_direction_that_differ_threefold_are_asked_about(tmp_path, capsys, again, asked):
    rows = [(i, o, p, 0.1 + 0.001 * p) for i in (10, 40) for o in (0, 30, 60) for p in (0, 180)]
    path = table(tmp_path, [*rows, (10, 30, 180, 0.28 * again)])
    assert cli.main(["info", str(path)]) == 0
    marked = [line for line in capsys.readouterr().out.splitlines() if "differ by a factor" in line]
    assert len(marked) == asked
    assert all("1 pair of directions" in line and line.endswith("?  (!)") for line in marked)


def test_noise_of_dark_directions_is_no_factor_of_three(tmp_path, random):
    """Repeated three times, with noise as large as the dark values are."""
    rows = [(i, o, p, 1.0 / (1 + (180 - p) ** 2) + 1e-3 * random.normal()) for i in (10, 40) for o in (0, 30, 60)
            for p in range(150, 181, 5) for _ in range(3)]
    notes = fitter.load(table(tmp_path, rows)).notes
    assert any("measured more than once" in note for note in notes)
    assert not any("factor" in note for note in notes)


@pytest.mark.parametrize(("other", "asked"), [(1.2, 0), (2.5, 1)])
def test_two_samples_in_one_table_are_asked_about(tmp_path, other, asked):
    """Also where they differ by less than any threefold."""
    rows = [(i, o, p, each) for i in (10, 40) for o in (0, 30, 60) for p in (0, 90, 180) for each in (0.1, 0.1 * other)]
    notes = fitter.load(table(tmp_path, rows)).notes
    assert len([note for note in notes if note.endswith("several samples in one table?")]) == asked
