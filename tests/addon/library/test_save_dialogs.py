"""What saving an asset asks in a window, and what is left of it where it fails."""

from types import SimpleNamespace

import bpy
import pytest

from support.blend_state import state
from support.operators import methods


@pytest.fixture
def material(cube, tmp_path, glossy, write_astm):
    bpy.ops.measured_brdf.import_data(filepath=str(write_astm(tmp_path / "a.astm", glossy, "a")), preset="Paper",
                                      diffuse_level=1, specular_level=-1)
    return bpy.context.object.active_material


@pytest.fixture
def window(blender, extension, monkeypatch, tmp_path):
    """What a window would be asked for, in `asked`, and an operator that is invoked in it: `made`."""
    module, asked = extension.addon.library.operators, []

    def note(name, answer):
        return lambda *given, **options: asked.append((name, options)) or answer

    manager = SimpleNamespace(invoke_props_dialog=note("dialog", {"RUNNING_MODAL"}),
                              invoke_confirm=note("confirm", {"INTERFACE"}))
    context = SimpleNamespace(window_manager=manager)
    fake = SimpleNamespace(ops=SimpleNamespace(measured_brdf=SimpleNamespace(save_asset=note("save_asset", None))),
                           path=bpy.path, app=SimpleNamespace(background=False), context=context)
    for each in (module, extension.addon.work.modal):
        monkeypatch.setattr(each, "bpy", fake)
    own = methods(module.MEASUREDBRDF_OT_save_asset) | {"_path": lambda self, _: self.path}
    own |= {name: note(name, {"FINISHED"}) for name in ("start", "run", "_mark_here")}
    made = type("Invoked", (module.ReplacesFile, extension.addon.work.modal.InBackground), own)()
    for name, value in {"directory": str(tmp_path), "library": "", "force": False, "path": tmp_path / "a.blend",
                        "options": SimpleNamespace(is_invoke=True, is_repeat=False)}.items():
        setattr(made, name, value)
    return SimpleNamespace(asked=asked, made=made, app=module.bpy.app, invoke=lambda: made.invoke(context, None),
                           execute=lambda: made.execute(context))


def test_it_asks_for_the_library_unless_it_is_named(window):
    window.made.directory = ""
    assert window.invoke() == {"RUNNING_MODAL"}
    assert [name for name, _ in window.asked] == ["dialog"]


def test_it_starts_where_there_is_nothing_to_replace(window):
    assert window.invoke() == {"FINISHED"}
    assert [name for name, _ in window.asked] == ["start"]


@pytest.mark.parametrize(("force", "background"), [(False, False), (True, False), (False, True)])
def test_a_file_that_is_no_library_is_replaced_when_the_user_has_agreed(window, force, background):
    window.made.path.write_bytes(b"something else")
    window.made.force, window.app.background = force, background
    if force or background:
        assert window.invoke() == {"FINISHED"}
        assert [name for name, _ in window.asked] == ["start"]
    else:
        assert window.invoke() == {"INTERFACE"}
        (name, options), = window.asked
        assert name == "confirm"
        assert "a.blend exists and is not a .blend file" in options["message"]
        assert "It will be kept as a.blend.kept1" in options["message"]
    assert window.made.force == (not background)


def test_without_a_library_the_material_is_marked_in_the_open_file(window):
    window.made.path, window.app.background, window.made.options.is_invoke = None, True, False
    assert window.invoke() == {"FINISHED"}
    assert [name for name, _ in window.asked] == ["_mark_here"]


@pytest.mark.parametrize(("library", "expected"), [("LOCAL", "_mark_here"), ("/library", "save_asset")])
def test_what_the_dialog_answers_is_done(window, library, expected):
    window.made.directory, window.made.library = "", library
    window.execute()
    (name, options), = window.asked
    assert name == expected
    assert options == ({} if library == "LOCAL" else {"directory": "/library", "force": False})


@pytest.mark.parametrize(("is_invoke", "is_repeat", "background"), [
    (False, False, False), (True, True, False), (True, False, True)])
def test_scripts_and_repetitions_save_at_once(window, is_invoke, is_repeat, background):
    window.made.options.is_invoke, window.made.options.is_repeat = is_invoke, is_repeat
    window.app.background = background
    window.execute()
    assert [name for name, _ in window.asked] == ["run"]


@pytest.mark.parametrize("failing", ["renew", "write_catalogue"])
def test_a_material_that_cannot_be_made_an_asset_of_the_open_file_is_none(material, extension, tmp_path, monkeypatch,
                                                                          failing):
    def fail(*_):
        raise OSError("no space left")

    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "scene.blend"))
    material = bpy.context.object.active_material
    before = state()
    monkeypatch.setattr(extension.addon.core.libraries.assets, failing, fail)
    with pytest.raises(RuntimeError, match=r"^Error: no space left\s*$"):        # without a traceback
        bpy.ops.measured_brdf.save_asset()
    assert material.asset_data is None
    assert state() == before


def test_an_asset_that_cannot_be_written_leaves_the_material_and_its_name(material, extension, tmp_path, monkeypatch):
    def fail(*_):
        raise OSError("no space left")

    before = state()
    monkeypatch.setattr(extension.addon.core.libraries.assets, "renew", fail)
    with pytest.raises(RuntimeError, match="no space left"):
        bpy.ops.measured_brdf.save_asset(directory=str(tmp_path / "assets"))
    assert state() == before


def test_a_material_whose_shader_is_damaged_is_saved_with_the_preview_of_blender(material, extension, monkeypatch):
    def fail(*_):
        raise ValueError("damaged")

    monkeypatch.setattr(extension.addon.work.tasks, "lit_sphere", fail)
    assert bpy.ops.measured_brdf.save_asset() == {"FINISHED"}
    assert material.asset_data is not None
