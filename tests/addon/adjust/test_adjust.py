"""Adjustments of a material, as a script makes them."""

from functools import partial
from types import SimpleNamespace

import bpy
import numpy as np
import pytest
from measured_brdf.addon.adjust import operators as adjust
from measured_brdf.addon.core import versions
from measured_brdf.addon.core.shading import material as materials
from measured_brdf.addon.core.shading import node_group
from measured_brdf.addon.core.storage import edits
from measured_brdf.addon.core.storage.properties import quality_summary

import fitter
from fitter.library.variations import variation
from support.cases import quick, release


@pytest.fixture
def material(blender, cube, curet):
    """A material of felt, Draft, on a cube; its measurements are in the file."""
    path = curet("felt").source
    assert blender.ops.measured_brdf.import_data(filepath=path, sample="felt", preset="Draft") == {"FINISHED"}
    return cube.active_material


def shown(material):
    """The fit that a material keeps."""
    return fitter.Fit.from_bytes(node_group.kept_fit(materials.group_node(material).node_tree))


def expected(curet, **edit):
    fit = fitter.fit(curet("felt"), **fitter.PRESETS["Draft"])
    return fitter.edited(fit, **edit)


def directions(random):
    return random.uniform(0, 1.4, 200), np.zeros(200), random.uniform(0, 1.4, 200), random.uniform(0, 3.1, 200)


def test_the_shader_gets_the_edited_fit_without_the_measurements(blender, curet, material, random):
    settings = material.measured_brdf_adjustments
    results = material.measured_brdf
    results.filepath = "/nowhere/felt.dat"
    settings.diffuse_gain, settings.diffuse_tint = 0.5, (1.0, 0.5, 0.25)
    settings.highlight_width, settings.coat, settings.coat_roughness = 2.0, 0.5, 0.5
    sphere = results.sphere
    assert blender.ops.measured_brdf.adjust() == {"FINISHED"}
    at = directions(random)
    want = expected(curet, diffuse=(0.5, 0.25, 0.125), width=2.0, coat=0.5, coat_width=0.25).evaluate(*at)
    np.testing.assert_allclose(shown(material).evaluate(*at), want, rtol=1e-4, atol=1e-6)
    assert results.sphere != sphere
    assert [tree.name for tree in blender.data.node_groups if "fit" in tree] == ["felt"], "the former shader is gone"


@pytest.mark.parametrize(("name", "told"), [
    ("coat", "coat is nan"), ("diffuse_gain", "diffuse is"), ("highlight_gain", "highlight is"),
    ("highlight_width", "width is nan"), ("coat_roughness", "coat_width is nan")])
def test_what_is_not_a_number_is_refused(blender, material, name, told):
    settings = material.measured_brdf_adjustments
    settings.coat = 0.5
    setattr(settings, name, float("nan"))
    before = shown(material).to_bytes()
    with pytest.raises(RuntimeError, match=told):
        blender.ops.measured_brdf.adjust()
    assert shown(material).to_bytes() == before


def test_as_measured_takes_everything_back(blender, curet, material, random):
    settings = material.measured_brdf_adjustments
    praise = quality_summary(material.measured_brdf)
    settings.highlight_gain = 3.0
    blender.ops.measured_brdf.adjust()
    adjusted = quality_summary(material.measured_brdf)
    assert praise.line.startswith("Matches the measurements: ")
    assert adjusted.line == f"Match before adjusting: {praise.line.split(': ')[1].split('.')[0]}"
    assert (adjusted.whole, adjusted.is_well) == (f"Before it was adjusted: {praise.whole}", False)
    assert blender.ops.measured_brdf.adjust(reset=True) == {"FINISHED"}
    assert quality_summary(material.measured_brdf) == praise
    assert settings.highlight_gain == 1
    at = directions(random)
    np.testing.assert_allclose(shown(material).evaluate(*at)[:, :1], np.maximum(expected(curet).evaluate(*at), 0),
                               rtol=1e-4, atol=1e-6)


@release
def test_a_refit_and_an_update_keep_the_adjustments(blender, curet, material, random):
    settings = material.measured_brdf_adjustments
    settings.highlight_gain = 2.0
    blender.ops.measured_brdf.adjust()
    at = directions(random)
    want = expected(curet, highlight=2.0).evaluate(*at)
    assert blender.ops.measured_brdf.fit() == {"FINISHED"}
    np.testing.assert_allclose(shown(material).evaluate(*at), want, rtol=1e-4, atol=1e-6)
    materials.group_node(material).node_tree["shader_version"] = 1
    assert blender.ops.measured_brdf.update_materials() == {"FINISHED"}
    np.testing.assert_allclose(shown(material).evaluate(*at), want, rtol=1e-4, atol=1e-6)


def test_adjusting_a_copy_leaves_the_original(blender, curet, material, random):
    copy = material.copy()
    copy.measured_brdf_adjustments.diffuse_gain = 0.1
    with blender.context.temp_override(material=copy):
        blender.ops.measured_brdf.adjust()
    at = directions(random)
    np.testing.assert_allclose(shown(material).evaluate(*at), np.maximum(expected(curet).evaluate(*at), 0), rtol=1e-4,
                               atol=1e-6)
    np.testing.assert_allclose(shown(copy).evaluate(*at), expected(curet, diffuse=0.1).evaluate(*at), rtol=1e-4,
                               atol=1e-6)


@pytest.mark.parametrize("change", ["import", "adjust", "fit", "update"])
def test_the_group_has_the_name_of_its_material(blender, material, change):
    if change == "adjust":
        material.measured_brdf_adjustments.diffuse_gain = 0.5
        blender.ops.measured_brdf.adjust()
    elif change == "fit":
        blender.ops.measured_brdf.fit(preset="Draft")
    elif change == "update":
        material.measured_brdf.version = "0.0.0"
        materials.group_node(material).node_tree["shader_version"] = 1
        assert blender.ops.measured_brdf.update_materials() == {"FINISHED"}
        assert material.measured_brdf.version == versions.CURRENT
    assert materials.group_node(material).node_tree.name == material.name == "felt"


class _Window:
    """Stands for Blender with a window, in which timers run and operators begin."""

    def __init__(self, bpy):
        self.data, self.context, self.begun, self.timers, self.now = bpy.data, bpy.context, [], [], 100.0
        self.app = SimpleNamespace(background=False, timers=SimpleNamespace(
            is_registered=lambda function: function in self.timers,
            register=lambda function, first_interval: self.timers.append(function),
            unregister=self.timers.remove))
        self.ops = SimpleNamespace(measured_brdf=SimpleNamespace(adjust=self._adjust),
                                   ed=SimpleNamespace(undo=lambda: self.begun.append("undo"),
                                                      redo=lambda: self.begun.append("redo")))

    def _adjust(self, how):
        self.begun.append((how, self.context.material.name))


@pytest.fixture
def window(blender, monkeypatch):
    made = _Window(blender)
    monkeypatch.setattr(adjust, "bpy", made)
    monkeypatch.setattr(adjust.time, "monotonic", lambda: made.now)
    return made


def test_a_changed_slider_is_applied_by_itself_once_it_rests(material, window, monkeypatch):
    settings = material.measured_brdf_adjustments
    settings.diffuse_gain = 0.9
    window.now += 0.3
    settings.diffuse_gain = 0.5             # still moving
    assert window.timers == [adjust._apply]
    window.now += 0.3
    assert adjust._apply() is not None
    assert window.begun == []
    monkeypatch.setattr(adjust.modal, "running", object())
    window.now += 1
    assert adjust._apply() is not None      # after what runs
    monkeypatch.setattr(adjust.modal, "running", None)
    assert adjust._apply() is None
    assert window.begun == [("INVOKE_DEFAULT", material.name)]


def test_what_was_saved_before_it_was_applied_is_applied_when_the_file_is_opened(blender, material, monkeypatch,
                                                                                 tmp_path):
    asked = []
    monkeypatch.setattr(adjust, "apply_soon", lambda material: asked.append(material.name))
    path = str(tmp_path / "saved.blend")
    for gain, expected in ((1, []), (0.5, ["felt"])):
        asked.clear()
        material.measured_brdf_adjustments.diffuse_gain = gain
        blender.ops.wm.save_as_mainfile(filepath=path)
        blender.ops.wm.open_mainfile(filepath=path)
        assert asked == expected
        material = blender.data.materials["felt"]


def test_undo_and_redo_do_not_stop_between_a_slider_and_its_effect(material, window):
    settings = material.measured_brdf_adjustments
    settings.diffuse_gain = 0.5
    adjust._on_undo(None)
    assert window.timers == [adjust._apply], "it is still to be applied"
    window.now += 1
    adjust._apply()
    for handler, timer, step in ((adjust._on_undo, adjust._undo, "undo"), (adjust._on_redo, adjust._redo, "redo")):
        window.begun.clear()
        handler(None)                       # the slider is where it was moved to, the shader as before
        assert window.timers[-1] == timer
        timer()
        assert window.begun == [step]
    settings["diffuse_gain"] = 1.0          # as undo leaves it: no listener is told
    window.begun.clear()
    window.timers.clear()
    adjust._on_undo(None)
    adjust._undo()
    assert window.begun == window.timers == []


def test_a_slider_that_is_back_where_it_was_and_a_deleted_material_begin_nothing(blender, material, window):
    material.measured_brdf_adjustments.coat = 0.5
    material.measured_brdf_adjustments.coat = 0.0
    window.now += 1
    assert adjust._apply() is None
    material.measured_brdf_adjustments.coat = 0.5
    blender.data.materials.remove(material)
    window.now += 1
    assert adjust._apply() is None
    assert window.begun == []


@pytest.mark.parametrize("name", quick(["satin", "aged", "lacquered", "wet", "dusty"], "satin", "wet"))
def test_a_variation_is_one_step_from_what_was_measured_and_its_sliders_show_it(blender, material, name):
    measured = shown(material)
    settings = material.measured_brdf_adjustments
    settings.diffuse_gain = 0.3                         # what was there before goes
    assert blender.ops.measured_brdf.adjust(variation=name.upper()) == {"FINISHED"}
    at = np.full(20, 0.5), np.zeros(20), np.linspace(0, 1.3, 20), np.full(20, 3.0)
    wanted = fitter.edited(measured, **variation(name, measured))
    first, second = np.broadcast_arrays(shown(material).evaluate(*at), wanted.evaluate(*at))
    np.testing.assert_allclose(first, second, rtol=1e-4, atol=1e-6)
    assert edits.is_as_wanted(material), "nothing is left to apply"
    assert blender.ops.measured_brdf.adjust(reset=True) == {"FINISHED"}
    np.testing.assert_array_equal(*np.broadcast_arrays(shown(material).evaluate(*at), measured.evaluate(*at)))


def click(material, reset=False, variation="NONE"):
    """As a button in a window does."""
    operator = SimpleNamespace(reset=reset, variation=variation)
    operator._chosen = partial(adjust.MEASUREDBRDF_OT_adjust._chosen, operator)
    with bpy.context.temp_override(material=material):
        assert adjust.MEASUREDBRDF_OT_adjust.invoke(operator, bpy.context, None) == {"FINISHED"}


def test_a_click_moves_the_sliders_at_once_and_the_fit_follows(blender, material, window):
    settings = material.measured_brdf_adjustments
    blender.ops.ed.undo_push(message="before")
    before = material.measured_brdf.sphere
    click(material, variation="SATIN")
    blender.ops.ed.undo_push(message="clicked")
    assert settings.highlight_width == 2
    assert not edits.is_as_wanted(material), "the sphere is drawn as it will be"
    assert material.measured_brdf.sphere == before
    window.now += 1
    adjust._apply()
    assert window.begun == [("INVOKE_DEFAULT", material.name)]
    window.begun.clear()
    blender.ops.ed.undo()                               # while the fit is made
    adjust._on_undo(None)
    adjust._undo()
    material = blender.data.materials["felt"]
    assert material.measured_brdf_adjustments.highlight_width == 1
    assert edits.is_as_wanted(material)
    assert window.begun == [], "no other step is taken back"
    click(material, variation="DUSTY")
    click(material, reset=True)
    assert edits.is_as_wanted(material)


def test_a_fit_that_is_not_wanted_any_more_is_given_up(material, window):
    ended = []
    operator = SimpleNamespace(_target=material.session_uid, _edit={"width": 2.0}, _end=ended.append)
    tick = SimpleNamespace(type="TIMER")
    assert adjust.MEASUREDBRDF_OT_adjust.modal(operator, "context", tick) == {"CANCELLED"}
    assert ended == ["context"]
    assert window.timers == [adjust._apply], "what is wanted now is applied, if it is not there"


def refuse():
    raise RuntimeError("there is nothing to redo")


def test_a_redo_that_ends_before_the_effect_has_it_applied(material, window):
    material.measured_brdf_adjustments.coat = 0.5
    window.now += 1
    adjust._apply()
    window.timers.clear()
    window.ops.ed.redo = refuse
    adjust._redo()
    assert adjust._apply in window.timers
