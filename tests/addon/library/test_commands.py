"""What the commands for folders refuse and say, and what Convert Folder asks of them."""

from types import SimpleNamespace

import pytest

from support import command
from support.operators import methods


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
    monkeypatch.setattr(extension.addon.library.command.osl_support, "missing", lambda: reason)
    (tmp_path / "data").mkdir()
    said = command.run(name, tmp_path / "data", "-o", tmp_path / out)
    assert [line for line in said.stderr.splitlines() if line.startswith("note:")] == [f"note: {reason}"] * bool(reason)


@pytest.mark.parametrize("use_tolerance", [False, True])
def test_the_tolerance_is_given_where_it_is_used(extension, monkeypatch, tmp_path, use_tolerance):
    module = extension.addon.library.folders
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
