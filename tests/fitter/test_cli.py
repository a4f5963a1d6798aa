import subprocess
import sys

import numpy as np
import pytest

import fitter
from fitter import cli
from fitter.formats import saved_samples
from support import anisotropic as instruments
from support.checkout import ROOT


def run(*arguments, **options):
    return subprocess.run([sys.executable, "-m", "fitter", *map(str, arguments)], cwd=ROOT, capture_output=True,
                          text=True, check=False, timeout=120, **options)


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    """An ASTM file of a Lambertian."""
    path = tmp_path_factory.mktemp("cli") / "white.astm"
    angles = np.random.default_rng(0).random((300, 3)) * [1.5, 1.5, 3.1]
    rows = [f"{i:.6f},0,{o:.6f},{phi:.6f},0.1,0.2,0.3" for i, o, phi in angles]
    path.write_text("\n".join(["SAMPLE_NAME White", "VARS theta_i,phi_i,theta_s,phi_s,R,G,B", *rows]))
    return path


def test_fit_then_info_then_bake(file, tmp_path):
    fit, shader = tmp_path / "fit.npz", tmp_path / "fit.osl"
    done = run("fit", file, "--preset", "Paper", "--diffuse-level", 2, "--specular-level", "none", "-o", fit)
    assert done.returncode == 0, done.stderr
    assert ("White: level 2, identity in nusselt coordinates, channels R G B, 175 coefficients, 2,100 bytes"
            in done.stdout)
    np.testing.assert_allclose(fitter.Fit.load(fit).evaluate(0.4, 0, 0.6, 2), [0.1, 0.2, 0.3], atol=0.02)
    assert "White" in run("info", file).stdout
    assert run("info", fit).stdout.splitlines()[0] in done.stdout
    assert run("bake", fit, "-o", shader).returncode == 0
    assert "shader measured_brdf" in shader.read_text()


def test_info_lists_curet_samples_and_describes_one(data):
    listing = run("info", data / "curet" / "abrdf.dat").stdout
    assert len(listing.splitlines()) == 62
    assert "  15  aluminum foil" in listing
    assert "205 direction pairs" in run("info", data / "curet" / "abrdf.dat", "--sample", "aluminum foil").stdout


def test_info_says_whether_a_material_is_isotropic(tmp_path):
    table = tmp_path / "brushed.csv"
    directions = instruments.grid([20, 50], range(0, 91, 15), range(10, 81, 10), range(0, 360, 30))
    numbers = np.column_stack([*np.degrees(directions), instruments.ggx()(*directions)])
    table.write_text("\n".join(["theta_i,phi_i,theta_o,phi_o,R,G,B", *(",".join(map(str, row)) for row in numbers)]))
    described = run("info", table).stdout
    assert "Material     anisotropic, given at 7 rotations from 0° to 90°" in described
    assert "Read         Anisotropic, measured at 7 rotations from 0 to 90 degrees" in described
    assert "Symmetry, half turn and mirror: " in run("info", table, "--symmetry", "half_turn_and_mirror").stdout
    asked = run("info", table, "--isotropic", "yes").stdout
    assert "Material     isotropic" in asked
    assert "Taken as isotropic, as asked" in asked
    assert "expected yes or no" in run("info", table, "--isotropic", "maybe").stderr
    assert "--encoding" in run("info", table, "--encoding", "gamma").stderr


def test_a_table_that_says_too_little_is_read_by_options(tmp_path):
    table, fit = tmp_path / "table.csv", tmp_path / "fit.npz"
    angles = np.random.default_rng(0).random((300, 3)) * [1.5, 1.5, 3.1]
    table.write_text("\n".join(["theta_i,theta_o,phi,R,G,B",
                                *(f"{i:.6f},{o:.6f},{phi:.6f},{np.cos(o) / 2:.6f},0,0" for i, o, phi in angles)]))
    assert "(the option angles of reading" in run("info", table).stderr
    how = ["--angles", "radians", "--quantity", "brdf_cos", "--colours", "ACEScg"]
    described = run("info", table, *how).stdout
    assert "Angles in radians, as asked" in described
    assert "Colours in ACEScg" in described
    assert run("fit", table, *how, "-o", fit).returncode == 0
    values = fitter.Fit.load(fit).evaluate(0.4, 0, 0.6, 2).ravel()
    np.testing.assert_allclose(values, [0.3066, 0.0351, 0.0103], atol=0.005)
    assert "invalid choice: 'turns'" in run("info", table, "--angles", "turns").stderr


def test_a_fit_is_recognised_whatever_its_name(file, tmp_path):
    assert run("fit", file, "--preset", "Draft", "-o", tmp_path / "fit.out").returncode == 0
    assert run("info", tmp_path / "fit.out").stdout.startswith("White: (3,5,99), log-relative in ")


def test_a_link_is_written_through(file, tmp_path):
    (tmp_path / "link.npz").symlink_to(tmp_path / "target.npz")
    assert run("fit", file, "-o", tmp_path / "link.npz").returncode == 0
    assert (tmp_path / "link.npz").is_symlink()
    assert (tmp_path / "target.npz").is_file()


@pytest.mark.parametrize(("arguments", "expected"), [
    (["fit", "FILE", "-o", "/dev/null"], "/dev/null: not a file"),
    (["fit", "FILE", "-o", "."], "not a file"),
    (["info", "none.dat"], "none.dat: cannot be read: No such file"),
    (["fit", "FILE", "--diffuse-level", "9", "-o", "OUT"], "diffuse_level is 9"),
    (["fit", "FILE", "-o", "/nowhere/fit.npz"], "/nowhere/fit.npz: No such file"),
    (["bake", "FILE", "-o", "OUT"], "not a fit")])
def test_errors_are_one_line_and_exit_code_1(file, tmp_path, arguments, expected):
    places = {"FILE": str(file), "OUT": str(tmp_path / "out.npz")}
    done = run(*(places.get(argument, argument) for argument in arguments))
    assert done.returncode == 1
    assert expected in done.stderr
    assert len(done.stderr.splitlines()) == 1
    assert not list(tmp_path.iterdir())


def test_info_and_fit_take_the_columns_of_a_table_and_say_what_no_surface_reflects(tmp_path, capsys):
    path = tmp_path / "scan.txt"
    path.write_text("a report\n" + "".join(f"{i};{o};180;{97:.1f}\n" for i in (0, 20, 40) for o in range(0, 81, 10)))
    assert cli.main(["info", str(path)]) == 1
    assert "4 columns of numbers without names found" in capsys.readouterr().err
    columns = ["--columns", "AOI[deg],AOS[deg],phi[deg],value"]
    assert cli.main(["info", str(path), *columns]) == 0
    assert "305 times the light that arrives: reflectance factors in percent? (Values: reflectance_percent)  (!)" in (
        capsys.readouterr().out)
    out = tmp_path / "fit.npz"
    options = [*columns, "--quantity", "reflectance_percent", "--preset", "Draft", "-o", str(out)]
    assert cli.main(["fit", str(path), *options]) == 0
    assert fitter.Fit.load(out).evaluate([0.3], [0], [0.3], [3.1])[0, 0] == pytest.approx(0.97 / np.pi, rel=1e-3)


def test_what_is_written_holds_no_folder_of_the_user(file, tmp_path, monkeypatch):
    """The path of the measurements is given whole."""
    monkeypatch.setattr("fitter.report.PRESETS", {"Draft": fitter.PRESETS["Draft"]})
    assert cli.main(["fit", str(file), "--preset", "Draft", "-o", str(tmp_path / "fit.npz")]) == 0
    assert cli.main(["report", str(file), "--out", str(tmp_path / "report")]) == 0
    saved_samples.write(fitter.load(file), tmp_path / "samples.npz")
    for name, entry in (("fit.npz", "header"), ("samples.npz", "samples")):
        with np.load(tmp_path / name) as archive:
            texts = str(archive[entry])
        assert ('"white.astm"' in texts, str(file.parent) in texts) == (True, False)
    assert str(file.parent) not in (tmp_path / "report" / "results.json").read_text()


def test_a_fit_that_is_judged_bad_is_written_and_exits_with_3(file, tmp_path, capsys, random):
    """Percent, and noise that one level of a lattice cannot follow; what matches exits with 0."""
    out, lines = tmp_path / "fit.npz", file.read_text().splitlines()
    percent, noise = tmp_path / "percent.astm", tmp_path / "noise.astm"
    percent.write_text("\n".join(line.replace(",0.1,0.2,0.3", ",10,20,30") for line in lines))
    noise.write_text("\n".join(line.replace(",0.1,", f",{random.choice([0.001, 0.3])},") for line in lines))
    options = ["--preset", "Paper", "--diffuse-level", "1", "--specular-level", "none", "-o", str(out)]
    for path, code, words in ((file, 0, "Matches the measurements: "),
                              (percent, cli.BAD, "White reflects 94.2 times the light that arrives: "),
                              (noise, cli.BAD, "Matches the measurements: poor")):
        out.unlink(missing_ok=True)
        assert cli.main(["fit", str(path), *options]) == code
        told, = [line for line in capsys.readouterr().out.splitlines() if words in line]
        assert told.endswith("(!)") is (code == cli.BAD)
        assert out.is_file()


@pytest.mark.parametrize(("more", "said"), [((), True), (("--sample", "2"), False)])
def test_a_fit_of_the_first_of_several_samples_says_so(data, tmp_path, capsys, more, said):
    path = data / "curet" / "abrdf.dat"
    assert cli.main(["fit", str(path), "-o", str(tmp_path / "fit.npz"), "--preset", "Draft", *more]) == 0
    assert ("the first of 61 samples in the file; --sample" in capsys.readouterr().out) is said


def test_what_is_read_is_not_written_over(file, tmp_path, capsys):
    """Nor by another name, nor a file that is read with it."""
    beside = tmp_path / "rover.dat"         # what overflowed, of CURET
    beside.write_text("")
    (tmp_path / "link.npz").symlink_to(file)
    saved = tmp_path / "fit.npz"
    fitter.fit(fitter.load(file), 1, None).save(saved)
    for command, read, out, more in (("fit", file, file, ()), ("fit", file, tmp_path / "link.npz", ()),
                                     ("fit", tmp_path / "abrdf.dat", beside, ("--sample", "felt")),
                                     ("bake", saved, saved, ())):
        before = out.read_bytes()
        assert cli.main([command, str(read), "-o", str(out), *more]) == 1
        assert f"{out}: is read, and would be replaced" in capsys.readouterr().err
        assert out.read_bytes() == before
