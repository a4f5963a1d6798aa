"""What panels ask about a material: its shader answers, without measurements and without a fit."""

import numpy as np
import pytest
from measured_brdf.addon.core.shading import material
from measured_brdf.addon.core.shading import material as materials
from measured_brdf.addon.work import icons, queries, queue, tasks

import fitter
from fitter.imaging import pictures, plane_plot
from fitter.imaging.plane_plot import Plotted
from tests.addon.answers import answer_all

CHEAP = {"diffuse_level": 2, "specular_level": 4, "compression": 80.0}


@pytest.fixture
def imported(blender, glossy, file):
    """A material, whose measurements are gone, and the fit that it was made of."""
    blender.ops.mesh.primitive_cube_add()
    blender.ops.measured_brdf.import_data(filepath=str(file), **CHEAP)
    file.unlink()
    return blender.context.object.active_material, fitter.fit(glossy, 2, 4, 80.0)


@pytest.fixture
def shown_pictures(monkeypatch):
    """The pictures that have icons, by number: without a window, Blender numbers none."""
    pictures_shown = {}

    def add(key, picture):
        pictures_shown[len(pictures_shown) + 1] = picture
        icons._icons._ids[key] = len(pictures_shown)

    monkeypatch.setattr(icons._icons, "_ids", {})
    monkeypatch.setattr(icons._icons, "add", add)
    return pictures_shown


@pytest.fixture
def no_fits(monkeypatch):
    """Fits cannot be made any more."""

    def fail(*_arguments, **_options):
        raise AssertionError("fitted again")

    for module, name in ((tasks, "fit"), (tasks, "fit_once"), (tasks.fitter, "load")):
        monkeypatch.setattr(module, name, fail)


def answered(question, *arguments):
    question(*arguments)
    answer_all()
    return question(*arguments)


def test_the_fit_of_a_material_comes_out_of_its_shader(imported, glossy, no_fits):
    material, expected = imported
    fit = answered(queries.fit_job, material).result
    np.testing.assert_allclose(fit.evaluate(*glossy.directions), expected.evaluate(*glossy.directions), rtol=1e-5,
                               atol=1e-7)
    assert (fit.name, fit.compression, fit.notation) == ("glossy", 80.0, "(2,4,80)")


@pytest.mark.parametrize("link", [False, True])
def test_pictures_of_a_saved_material_are_those_of_the_fit(imported, from_library, no_fits, link):
    expected, material = imported[1], from_library(imported[0].name, link)
    assert material.is_editable != link
    _, sphere = answered(queries.material_sphere, material)
    np.testing.assert_allclose(sphere.result, pictures.lit_sphere(expected), atol=1e-3)
    _, polar = answered(queries.polar_plot, "", ((queries.embedded_fit(material), ()),), None, 0.6)
    picture, shown = polar.result
    assert np.isnan(shown)                                          # no samples, and so none of their dots
    np.testing.assert_allclose(picture, plane_plot.polar_plot([Plotted(expected)], None, 0.6)[0], atol=0.01)


def test_before_any_worker_answers_the_small_picture_of_the_material_shows(imported, tmp_path, blender, shown_pictures):
    expected = pictures.lit_sphere(imported[1], 128)
    file = str(tmp_path / "saved.blend")
    blender.ops.wm.save_as_mainfile(filepath=file)
    blender.ops.wm.open_mainfile(filepath=file)
    material = next(item for item in blender.data.materials if item.measured_brdf.coefficients)
    icon, job = queries.material_sphere(material)
    assert job.finished is None
    np.testing.assert_allclose(shown_pictures[icon], expected, atol=0.6 / 255)


def test_a_refit_is_another_fit_and_shows_the_old_one_until_it_is_drawn(blender, glossy, file, shown_pictures):
    blender.ops.mesh.primitive_cube_add()
    blender.ops.measured_brdf.import_data(filepath=str(file), **CHEAP)
    material = blender.context.object.active_material
    icon, before = answered(queries.material_sphere, material)
    material.measured_brdf.specular_level = -1
    assert queries.material_sphere(material)[1] is before      # settings are not the fit
    blender.ops.measured_brdf.fit()
    drawn, after = queries.material_sphere(material)
    assert drawn == icon
    assert shown_pictures[icon] is before.result
    assert after is not before
    answer_all()
    np.testing.assert_allclose(after.result, pictures.lit_sphere(fitter.fit(glossy, 2, None)), atol=1e-3)


def test_materials_without_measured_reflectance_have_no_fit(blender):
    assert queries.fit_job(blender.data.materials.new("plain")) is None


def test_a_fit_that_is_damaged_or_missing_is_an_error(imported):
    tree = material.group_node(imported[0]).node_tree
    tree["fit"] = tree["fit"][:-1]
    for _ in range(2):
        queries.fit_job(imported[0])
        with pytest.raises(ValueError, match="not a fit"):
            answer_all()
        tree.pop("fit", None)


def test_while_a_material_is_adjusted_its_picture_is_that_of_the_adjusted_fit(imported, shown_pictures):
    material, _ = imported
    icon, before = answered(queries.material_sphere, material)
    material.measured_brdf_adjustments.diffuse_gain = 0.5
    for gain in (0.6, 0.7):                 # a slider that is dragged: only the last value is wanted
        assert queries.material_sphere(material)[0] == icon, "the former picture, until there is another"
        material.measured_brdf_adjustments.diffuse_gain = gain
    _, job = queries.material_sphere(material)
    assert [question.job for lane in queue._lanes.values() for question in lane.queue] == [job]
    answer_all()
    adjusted = fitter.edited(fitter.Fit.from_bytes(queries.embedded_fit(material).fit), diffuse=0.7)
    np.testing.assert_allclose(job.result, pictures.lit_sphere(adjusted), atol=1e-3)
    assert np.abs(job.result - before.result).max() > 0.05
    material.measured_brdf_adjustments.diffuse_gain = 1
    assert queries.material_sphere(material)[1] is before


def test_the_picture_of_a_mix_is_that_of_the_mixed_fits_and_with_a_mask_half_of_each(blender, imported):
    first, fit = imported
    second = first.copy()
    second.name = "red"
    second.measured_brdf_adjustments.diffuse_tint = (1, 0.2, 0.1)
    with blender.context.temp_override(material=second):
        assert blender.ops.measured_brdf.adjust() == {"FINISHED"}
    red = fitter.edited(fit, diffuse=(1, 0.2, 0.1))
    assert blender.ops.measured_brdf.mix(first=first.name, second="red", factor=0.25) == {"FINISHED"}
    mix = blender.data.materials[f"{first.name} + red"]
    _, job = answered(queries.material_sphere, mix)
    np.testing.assert_allclose(job.result, pictures.lit_sphere(fitter.Mix(fit, red, 0.25)), atol=2e-3)
    node = materials.mix_node(mix)
    mask = mix.node_tree.nodes.new("ShaderNodeTexImage")
    mix.node_tree.links.new(mask.outputs["Color"], node.inputs["Factor"])
    _, job = answered(queries.material_sphere, mix)
    left, right = (pictures.lit_sphere(each) for each in (fit, red))
    half = left.shape[1] // 2
    np.testing.assert_allclose(job.result[:, :half - 2], left[:, :half - 2], atol=2e-3)
    np.testing.assert_allclose(job.result[:, half + 2:], right[:, half + 2:], atol=2e-3)
