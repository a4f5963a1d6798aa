"""What the commands for folders refuse and say, and what Convert Folder asks of them."""

import math
import os
from dataclasses import replace
from types import SimpleNamespace

import pytest

from support import checkout, command
from support.operators import methods

CRASHES_AT_EXIT = """
import ctypes, runpy, sys
libc = ctypes.CDLL(None)
libc.__cxa_atexit(libc.abort, None, None)
runpy.run_path(sys.argv.pop(1), run_name="__main__")
"""


@pytest.mark.parametrize(("given", "code", "said"), [
    (("convert", "{}/data", "-o", "{}/a.blend"), 1, "a.blend: 0 done, 1 failed"),
    (("convert",), 2, "PATH"), (("--help",), 0, "convert")])
def test_a_process_of_its_own_ends_with_its_exit_code_however_blender_would_end(tmp_path, given, code, said):
    """Blender 4.2 as a module crashes in what is called at the end of a process, and 4.5 waits there forever."""
    for name in ("data", "temporary"):
        (tmp_path / name).mkdir()
    (tmp_path / "data" / "a.astm").write_text("nonsense")
    done = checkout.run_python("-c", CRASHES_AT_EXIT, checkout.ROOT / "__main__.py", *(
        each.format(tmp_path) for each in given), env=os.environ | {"TMPDIR": str(tmp_path / "temporary")}, timeout=60)
    assert (done.returncode, said in done.stdout + done.stderr) == (code, True), done.stdout + done.stderr
    assert not [*(tmp_path / "temporary").iterdir()]


@pytest.mark.parametrize(("given", "said"), [
    (("--processes", "0"), "0: expected at least 1"),
    (("--shard", "0/2"), "0/2: expected I/N with I from 1 to N"),
    (("--shard", "3/2"), "3/2: expected I/N with I from 1 to N")])
def test_counts_and_shards_out_of_range_are_refused(extension, tmp_path, capsys, given, said):
    with pytest.raises(SystemExit):
        extension.addon.work.command.build_parser().parse_args(["convert", "a", "-o", "a.blend", *given])
    assert said in capsys.readouterr().err


@pytest.mark.parametrize("reason", ["", "This Blender has no OSL"])
@pytest.mark.parametrize(("name", "out"), [("convert", "a.blend"), ("render", "pictures")])
def test_a_blender_without_osl_is_noted(extension, tmp_path, monkeypatch, name, out, reason):
    monkeypatch.setattr(extension.addon.library.command.osl_support, "reason_unavailable", lambda: reason)
    (tmp_path / "data").mkdir()
    said = command.run(name, tmp_path / "data", "-o", tmp_path / out)
    assert [line for line in said.stderr.splitlines() if line.startswith("note:")] == [f"note: {reason}"] * bool(reason)


@pytest.mark.parametrize("use_tolerance", [False, True])
def test_the_tolerance_is_given_where_it_is_used(extension, monkeypatch, tmp_path, use_tolerance):
    module = extension.addon.library.operators
    monkeypatch.setattr(module, "load_arguments", lambda _: {"illuminant": "A", "columns": None})
    monkeypatch.setattr(module, "Command", lambda *arguments: [str(each) for each in arguments])
    made = SimpleNamespace(
        preset="Draft", rendering="AUTO", diffuse_level=1, specular_level=module.NO_SPECULAR_LEVEL, compression=90,
        use_tolerance=use_tolerance, tolerance=0.125, checked_folder=lambda: tmp_path, check_replaceable=lambda _: None,
        _path=lambda _: tmp_path / "a.blend", force_option=lambda: ["--force"])
    given = methods(module.MEASUREDBRDF_OT_convert_folder)["work"](made, None)
    asked = extension.addon.work.command.build_parser().parse_args(given)
    assert asked.tolerance == (0.125 if use_tolerance else None)
    assert (asked.specular_level, asked.illuminant, asked.columns, asked.force) == (None, "A", None, True)


def test_folders_in_a_folder_are_passed_over_with_a_note_and_taken_where_they_are_given(extension, tmp_path, glossy,
                                                                                       write_astm):
    folder, out = tmp_path / "data", tmp_path / "library.blend"
    for place in ("metals/old", "paints", ".hidden"):
        (folder / place).mkdir(parents=True)
    (folder / "paints" / "README.txt").write_text("Measured on Monday.")
    for name in ("red", "metals/gold", "metals/old/tin", "paints/blue", ".hidden/grey"):
        write_astm(folder / f"{name}.astm", glossy, name)
    given = [folder, "-o", out, "--preset", "Paper", "--diffuse-level", "2", "--specular-level", "none"]
    done = command.run("convert", *given)
    assert f"note: {folder}: folders in it are not read, though 3 of their files" in done.stderr
    assert "give them too (metals, paints, metals/old)" in done.stderr
    assert "1 done, 0 failed" in done.stdout
    done = command.run("convert", folder / "metals", folder / "paints", folder / "metals" / "old", *given)
    assert "note: " not in done.stderr
    assert "4 done, 0 failed" in done.stdout


def test_importing_or_converting_a_folder_warns_of_what_is_bad_and_of_what_is_asked(blender, tmp_path, cornell,
                                                                                     write_astm, capfd):
    """Of all measurements in it, and so does fitting them again."""
    garnet = cornell("garnet_red_RGB")
    turned = replace(garnet, phi_o=garnet.phi_o + math.pi, values=garnet.values / 1000)
    for name, samples in (("red", garnet), ("turned", turned)):
        write_astm(tmp_path / f"{name}.astm", samples, name)
    poor = {"diffuse_level": 1, "specular_level": -1}
    asked = ["turned reflects 5.8e-05 of the light that arrives, less than the blackest paints: in which units?",
             "turned: 22 times as bright toward the light as in the mirror direction: is phi counted from the mirror's "
             "side?"]
    ops, warnings = blender.ops.measured_brdf, []
    for run in (lambda: ops.import_folder(directory=str(tmp_path), **poor),
                lambda: ops.convert_folder(directory=str(tmp_path), library=str(tmp_path / "out" / "a.blend"), **poor)):
        assert run() == {"FINISHED"}
        warnings.append([line.removeprefix("Warning: ") for line in capfd.readouterr().out.splitlines()
                         if line.startswith("Warning: ") and "is not assigned" not in line])
    imported, converted = warnings
    assert [each for each in imported if each.startswith("red: Matches the measurements: poor")] == imported[:1]
    assert imported[1:] == asked
    assert converted[0].startswith("red: Matches the measurements: poor")
    assert converted[1:] == [f"turned: {'. '.join(asked)}"]
    blender.ops.mesh.primitive_cube_add()
    assert ops.import_data(filepath=str(tmp_path / "turned.astm"), **poor) == {"FINISHED"}
    capfd.readouterr()
    assert ops.fit() == {"FINISHED"}
    told = capfd.readouterr().out
    assert all(f"Warning: {each}" in told for each in asked)


def test_importing_a_folder_says_which_folders_in_it_it_passes_over(blender, tmp_path, glossy, write_astm, capfd):
    (tmp_path / "metals").mkdir()
    write_astm(tmp_path / "metals" / "gold.astm", glossy)
    with pytest.raises(RuntimeError, match=r"no files of measurements .*: give them too \(metals\)"):
        blender.ops.measured_brdf.import_folder(directory=str(tmp_path))
    write_astm(tmp_path / "red.astm", glossy)
    how = {"diffuse_level": 2, "specular_level": -1}
    assert blender.ops.measured_brdf.import_folder(directory=str(tmp_path), **how) == {"FINISHED"}
    assert "though 1 of their files may hold measurements: give them too (metals)" in capfd.readouterr().out
