"""What the panels Curves, Compare Presets and Test Render show, drawn without a window."""

from types import SimpleNamespace

import bpy
import numpy as np
import pytest
from measured_brdf.addon.compare import curves, operators, presets
from measured_brdf.addon.core.shading import comparison
from measured_brdf.addon.work import queries, queue, tasks

import fitter
from fitter import PRESETS
from support.drawn import draw
from tests.addon.answers import answer_all

CHEAP = {"diffuse_level": 2, "specular_level": 4, "compression": 80.0}
ORDER = ["Standard", "Reference", "Original 2002 Method"]


@pytest.fixture
def material(blender, quick, file):
    blender.ops.mesh.primitive_cube_add()
    blender.ops.measured_brdf.import_data(filepath=str(file), **CHEAP)
    return blender.context.object.active_material


@pytest.fixture
def other(material, tmp_path, glossy, write_astm):
    dull = fitter.Samples(*glossy.directions, 0.2 + 0.1 * glossy.values, glossy.channels, "dull")
    bpy.ops.mesh.primitive_cube_add()
    bpy.ops.measured_brdf.import_data(filepath=str(write_astm(tmp_path / "dull.astm", dull)), **CHEAP)
    return bpy.context.object.active_material


@pytest.fixture(scope="module")
def fits(glossy, write_astm, tmp_path_factory):
    """What each preset makes of the samples in the file, worked out apart from the extension."""
    samples = fitter.load(write_astm(tmp_path_factory.mktemp("fits") / "glossy.astm", glossy))
    made = {name: fitter.fit(samples, **preset) for name, preset in PRESETS.items()}
    return {name.replace("Paper", ORDER[-1]): (
        f"{fit.coefficient_count:,} coefficients", f"{fit.nbytes / 1000:,.0f} KB of the fit",
        f"RMSE {fitter.error_metrics(samples.values, fit.evaluate(*samples.directions)).rmse:.3g}")
            for name, fit in made.items()}


def drawn(panel, material, rounds=3):
    """A panel, when its questions, and those that follow from the answers, have been answered."""
    for _ in range(rounds):
        draw(panel, material=material)
        answer_all()
    return draw(panel, material=material)


def quick_held_out(monkeypatch):
    monkeypatch.setattr(tasks, "held_out", lambda *_arguments: 0.25)


def test_each_preset_has_its_own_numbers_whatever_the_settings_are(material, fits, monkeypatch):
    quick_held_out(monkeypatch)
    material.measured_brdf.diffuse_level = 1
    material.measured_brdf.preset = "Reference"
    shown = drawn(presets.MEASUREDBRDF_PT_compare, material)
    assert [entry[2] for entry in shown.drawn if entry[0] == "button"] == ORDER
    for name in ORDER:
        place = shown.button(name).place
        texts = [entry[2] for entry in shown.drawn[place + 1:place + 5]]
        assert texts == [*fits[name], "Unseen Angles 0.25"]
    button = shown.button("Original 2002 Method")
    assert (button.operator, button.options["preset"], button.enabled) == ("measured_brdf.fit", "Paper", True)


def test_a_sphere_is_a_button_and_the_method_of_2002_none_before_its_error_is_known(material, monkeypatch):
    monkeypatch.setattr(presets.queries, "lit_sphere", lambda _about, _shown: (5, SimpleNamespace(error=None)))
    draw(presets.MEASUREDBRDF_PT_compare, material=material)
    answer_all()                   # the file is read
    shown = draw(presets.MEASUREDBRDF_PT_compare, material=material)
    assert not shown.button("Original 2002 Method").enabled
    assert shown.button("Standard").enabled
    names = [(entry[0], entry[2], getattr(entry[-1], "preset", "")) for entry in shown.drawn
             if entry[0] in ("picture", "button")]
    for place, (kind, *_) in enumerate(names):
        if kind == "picture":
            over, below = names[place + 1:place + 3]
            assert over[2] == below[2] != ""


def test_a_linked_material_has_the_numbers_of_each_preset_and_no_button(material, fits, from_library, monkeypatch):
    quick_held_out(monkeypatch)
    shown = drawn(presets.MEASUREDBRDF_PT_compare, from_library("glossy"))
    assert "button" not in shown.kinds
    texts = [entry[2] for entry in shown.drawn if entry[0] == "text"]
    for name in ORDER:
        place = texts.index(name)
        assert texts[place + 1:place + 5] == [*fits[name], "Unseen Angles 0.25"]


def test_the_fit_that_the_material_has_is_marked_and_not_made_again(material, fits, monkeypatch):
    quick_held_out(monkeypatch)
    assert bpy.ops.measured_brdf.fit(preset="Paper") == {"FINISHED"}
    asked, fit_data = [], tasks.fit_data
    monkeypatch.setattr(tasks, "fit_data", lambda data, arguments: (
        asked.append(arguments["method"]), fit_data(data, arguments))[1])
    marked = {}
    monkeypatch.setattr("support.drawn.Layout.operator", lambda layout, name, text="", **options: (
        marked.update({text: options["depress"]}), SimpleNamespace())[1])
    drawn(presets.MEASUREDBRDF_PT_compare, material)
    assert marked == {name: name == "Original 2002 Method" for name in ORDER}
    assert "mba" not in asked
    assert "kriging" in asked


def test_questions_are_asked_cheapest_first(material, monkeypatch):
    quick_held_out(monkeypatch)
    draw(presets.MEASUREDBRDF_PT_compare, material=material)
    answer_all()                       # the measurements
    draw(presets.MEASUREDBRDF_PT_compare, material=material)
    answer_all()                       # the fit in the shader
    asked, cost = [], queries.cost
    monkeypatch.setattr(queries, "cost", lambda data, arguments: (asked.append(arguments), cost(data, arguments))[1])
    draw(presets.MEASUREDBRDF_PT_compare, material=material)
    assert asked == [PRESETS[name] for name in ("Paper", "Standard", "Reference")]


def test_a_hint_tells_how_to_pin(material, other):
    panel = curves.MEASUREDBRDF_PT_pictures
    shown = drawn(panel, material)
    assert "pinned" in shown.fields
    assert shown.button("Pin Measured Material").operator == "measured_brdf.pin"
    comparison.get(bpy.context.scene).pinned = material
    assert "This is the pinned material" in drawn(panel, material).texts


def test_numbers_stand_side_by_side_without_measurements_and_without_fitting(material, other, file, monkeypatch):
    counts = [f"{each.measured_brdf.coefficients:,}" for each in (material, other)]
    file.unlink()
    for each in (material, other):
        each.measured_brdf.filepath = ""
    for name in ("read", "fit_data", "outcome"):
        monkeypatch.setattr(tasks, name, lambda *_: pytest.fail("nothing is read or fitted"))
    comparison.get(bpy.context.scene).pinned = other
    shown = drawn(curves.MEASUREDBRDF_PT_pictures, material)
    texts = [entry[2] for entry in shown.drawn if entry[0] == "text"]
    assert texts[:3] == ["Compare With", "A: glossy", "B: dull"]
    assert values_of(texts, "Coefficients") == counts
    for each, albedo in zip((material, other), values_of(texts, "Albedo %"), strict=True):
        expected = 100 * tasks.normal_albedo(queries.embedded_fit(each))        # test_comparisons.py integrates it
        np.testing.assert_allclose([float(part) for part in albedo.split()], expected, atol=0.6)
    assert {"divide", "shown_theta", "pinned"} <= set(shown.fields)


def values_of(texts, name):
    place = texts.index(name)
    return [text.removeprefix(letter) for letter, text in zip(("A: ", "B: "), texts[place + 1:place + 3], strict=True)]


def test_a_damaged_fit_is_said_and_the_other_is_still_shown(material, other):
    group = next(node.node_tree for node in other.node_tree.nodes if node.type == "GROUP")
    group["fit"] = b"void"
    comparison.get(bpy.context.scene).pinned = other
    panel = curves.MEASUREDBRDF_PT_pictures
    draw(panel, material=material)
    lanes = queue._lanes
    for lane in lanes.values():                 # as workers do: an error is an answer
        while lane.queue:
            question = lane.queue.pop(0)
            try:
                question.job.result = question.job.function()
            except ValueError as error:
                question.job.error = error
            question.job.finished = 1.0
    shown = draw(panel, material=material)
    assert "not a fit saved by Measured BRDF" in shown.texts
    assert f"{material.measured_brdf.coefficients:,}" in shown.texts


def test_the_panels_are_shown_where_a_material_is_measured(material):
    plain = bpy.data.materials.new("plain")
    material.measured_brdf.filepath = ""
    for each in curves.classes:
        assert each.poll(SimpleNamespace(material=material))
        assert not each.poll(SimpleNamespace(material=plain))
        assert not each.poll(SimpleNamespace(material=None))


def test_a_test_render_is_shown_when_it_is_there(material, other, monkeypatch):
    look, scene = curves.MEASUREDBRDF_PT_look, bpy.context.scene
    assert "picture" not in draw(look, material=material).kinds
    key = operators.render_key(scene, material)
    operators.renders[key] = np.ones((256, 256, 4), np.float32), 1
    shown = draw(look, material=material)
    assert "picture" in shown.kinds
    assert shown.button("Render").operator == "measured_brdf.render_look"
    comparison.get(scene).pinned = other
    shown = draw(look, material=material)
    assert "picture" not in shown.kinds, "the pinned one has not been rendered"
    assert shown.button("Render Both") is not None
    operators.renders[operators.render_key(scene, other)] = np.zeros((256, 256, 4), np.float32), 2
    given = []
    monkeypatch.setattr(curves.icons, "draw_at_once", lambda key, draw: key[0] == "swatch" or given.append(draw()) or 1)
    draw(look, material=material)
    assert given[-1][:, :120].min() == given[-1][:, :120].max() == 1
    assert given[-1][:, 140:].min() == given[-1][:, 140:].max() == 0
