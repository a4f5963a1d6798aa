"""A mix is inspected, compared and rendered as one material is: as the sum of its parts' reflectances."""

import math
from types import SimpleNamespace

import bpy
import numpy as np
import pytest
from measured_brdf.addon.compare import curves, operators
from measured_brdf.addon.core.shading import comparison
from measured_brdf.addon.core.shading import material as materials
from measured_brdf.addon.inspect import session, surface
from measured_brdf.addon.work import queries
from scipy import ndimage

import fitter
from support.anisotropic import brushed_fit
from support.drawn import draw
from support.stage import material_for
from tests.addon.answers import answer_all

DARK, BRIGHT = np.array([0.1, 0.2, 0.3]) / np.pi, np.array([0.8, 0.6, 0.4]) / np.pi
SHARE = 0.2
BOTH = 0.8 * DARK + 0.2 * BRIGHT
NEAR = 2e-3                 # relative: fits of a constant are not constant to the last digit


def lambertian(values):
    """A fit of samples that all have these values."""
    random = np.random.default_rng(2)
    theta_i, theta_o = np.arcsin(np.sqrt(0.98 * random.random((2, 150))))
    samples = fitter.Samples(theta_i, np.zeros(150), theta_o, 2 * np.pi * random.random(150),
                             np.broadcast_to(values, (150, 3)), ("R", "G", "B"), "even")
    return fitter.fit(samples, **fitter.PRESETS["Draft"])


@pytest.fixture
def mix(blender):
    """A plane whose material mixes a dark Lambertian with a bright one; the plane has a UV map of its width."""
    for name, values in (("dark", DARK), ("bright", BRIGHT)):
        material_for(lambertian(values)).name = name
    blender.ops.mesh.primitive_plane_add(size=2)
    assert blender.ops.measured_brdf.mix(first="dark", second="bright", factor=SHARE) == {"FINISHED"}
    return blender.context.object.active_material


def masked(mix, pixels, colorspace="Non-Color"):
    """Connect an image, (height, width) from the bottom, to the factor of a mix: its node."""
    image = bpy.data.images.new("mask", *pixels.shape[::-1])
    image.colorspace_settings.name = colorspace
    grey = np.repeat(pixels[..., None], 4, axis=-1).astype(np.float32)
    grey[..., 3] = 1
    image.pixels.foreach_set(grey.ravel())
    node = mix.node_tree.nodes.new("ShaderNodeTexImage")
    node.image = image
    group = next(each for each in mix.node_tree.nodes if each.type == "GROUP")
    mix.node_tree.links.new(node.outputs["Color"], group.inputs["Factor"])
    return node


def spot_at(x, y):
    """What is inspected of the plane at a place."""
    item, depsgraph = bpy.context.object, bpy.context.evaluated_depsgraph_get()
    return surface.find_spot(item, depsgraph, np.array([x, y, 5.0]), np.array([0, 0, -1.0]))


def inspected(spot):
    """The inspection of a spot, when workers have answered."""
    made = session.Session(session.Inspection(spot, 1.0, 0.4, 0.0), SimpleNamespace(as_pointer=lambda: 0))
    made.refresh()
    answer_all()
    made.refresh()
    return made.inspection


def draw_panel(panel, material):
    """A panel when all that it asks for has been answered."""
    for _ in range(3):
        draw(panel, material=material)
        answer_all()
    return draw(panel, material=material)


def test_the_reflectance_of_a_mix_is_the_sum_of_its_parts(mix):
    job = queries.fit_job(mix)
    answer_all()
    np.testing.assert_allclose(job.result.evaluate(0.3, 0, 0.9, 2), BOTH, rtol=NEAR)
    assert queries.fit_job(bpy.data.materials.new("plain")) is None
    assert {part.name for part in materials.measured_parts(mix)} == {"dark", "bright"}
    dark = bpy.data.materials["dark"]
    assert materials.measured_parts(dark) == [dark]


def test_a_mix_has_a_lobe_and_its_values_are_read(mix):
    spot = spot_at(0.2, 0.1)
    assert spot.material == mix.session_uid
    made = inspected(spot)
    np.testing.assert_allclose([value for _, value in made.plane.read(0.7)], BOTH, rtol=NEAR)
    np.testing.assert_allclose(np.linalg.norm(made.lobe.vertices, axis=1), np.cbrt(BOTH.mean()), rtol=NEAR)
    assert made.shown.note == ""


def test_under_a_mask_the_lobe_is_that_of_the_spot(mix):
    masked(mix, np.array([[0.0, 1.0]])).interpolation = "Closest"
    for x, expected, note in ((-0.5, DARK, "mask here: 0%"), (0.5, BRIGHT, "mask here: 100%")):
        made = inspected(spot_at(x, 0.3))
        np.testing.assert_allclose([value for _, value in made.plane.read(0.2)], expected, rtol=NEAR)
        assert made.shown.note == note


@pytest.mark.parametrize("beyond", ["REPEAT", "EXTEND"])
def test_a_mask_is_looked_up_as_renderers_do(mix, beyond):
    pixels = np.random.default_rng(3).integers(0, 256, (3, 5)) / 255
    node = masked(mix, pixels)
    node.extension = beyond
    group = next(each for each in mix.node_tree.nodes if each.type == "GROUP")
    for at in ((0.03, 0.98), (0.41, 0.52), (1.3, -0.4)):
        place = np.array(at)[::-1, None] * np.array([[3], [5]]) - 0.5
        mode = {"REPEAT": "grid-wrap", "EXTEND": "nearest"}[beyond]
        expected = ndimage.map_coordinates(pixels, place, order=1, mode=mode)[0]
        assert surface.image_value(group.inputs["Factor"], {"": np.array(at)}) == pytest.approx(expected, abs=1e-6)


def test_a_mask_in_srgb_is_decoded(mix):
    masked(mix, np.full((2, 2), 188 / 255), "sRGB")
    assert spot_at(0.1, 0.1).masked == pytest.approx(0.5, abs=0.005)


def test_what_is_not_an_image_on_a_uv_map_is_not_guessed(mix):
    node = masked(mix, np.ones((2, 2)))
    assert spot_at(0.1, 0.1).masked == pytest.approx(1)
    for kind, output in (("ShaderNodeTexCoord", "Generated"), ("ShaderNodeNewGeometry", "Position")):
        mix.node_tree.links.new(mix.node_tree.nodes.new(kind).outputs[output], node.inputs["Vector"])
        assert spot_at(0.1, 0.1).masked is None
    named = mix.node_tree.nodes.new("ShaderNodeUVMap")
    mix.node_tree.links.new(named.outputs["UV"], node.inputs["Vector"])
    named.uv_map = bpy.context.object.data.uv_layers[0].name
    assert spot_at(0.1, 0.1).masked == pytest.approx(1)
    named.uv_map = "nowhere"
    assert spot_at(0.1, 0.1).masked is None


def test_curves_of_a_mix_are_drawn_without_reading_a_file(mix, monkeypatch):
    panel = curves.MEASUREDBRDF_PT_pictures
    assert panel.poll(SimpleNamespace(material=mix))
    monkeypatch.setattr(queries, "data", lambda _material: pytest.fail("a mix has no file"))
    drawn, icon = {}, queries.icons.icon
    monkeypatch.setattr(queries.icons, "icon", lambda key, *rest, **more: (
        0, drawn.setdefault(key[0], icon(key, *rest, **more)[1])))
    assert "Mask" not in draw_panel(panel, mix).texts
    assert {name: (job.error, job.result is None) for name, job in drawn.items()} == {
        "sphere": (None, False), "polar": (None, False)}
    middle = drawn["sphere"].result[128, 100:156, :3].mean(axis=0)
    assert middle[0] < middle[1] < middle[2], "dark is blue, bright is red, and there is more of dark"
    masked(mix, np.ones((2, 2)))
    assert "Mask: half of each" in draw_panel(panel, mix).texts


def test_a_mix_is_compared_by_its_own_albedo(mix):
    dark, bright = (bpy.data.materials[name] for name in ("dark", "bright"))
    scene = bpy.context.scene
    with bpy.context.temp_override(material=mix):
        assert bpy.ops.measured_brdf.pin() == {"FINISHED"}
    for each, grades in ((dark, (0.4, 3.0)), (bright, (4.0, 3.0))):
        each.measured_brdf.match, each.measured_brdf.between = grades
    panel = curves.MEASUREDBRDF_PT_pictures
    assert panel.poll(SimpleNamespace(material=mix))
    texts = [entry[2] for entry in draw_panel(panel, dark).drawn if entry[0] == "text"]
    albedo = [" ".join(f"{100 * math.pi * each:.0f}" for each in values) for values in (DARK, BOTH)]
    for name, *expected in (("Albedo %", *albedo), ("Match", "excellent", "fair"),
                            ("Between Measured Angles", "good", "good")):
        place = texts.index(name)
        assert [text[3:] for text in texts[place + 1:place + 3]] == expected
    assert comparison.find_pinned(scene, dark) == mix


def test_a_mix_can_be_rendered_to_look_at_and_a_plain_material_cannot(mix):
    operator = operators.MEASUREDBRDF_OT_render_look
    assert operator.poll(SimpleNamespace(material=mix, object=None))
    assert curves.MEASUREDBRDF_PT_look.poll(SimpleNamespace(material=mix))
    assert not curves.MEASUREDBRDF_PT_look.poll(SimpleNamespace(material=bpy.data.materials.new("plain")))


def test_a_mix_with_brushed_metal_has_its_tangent(mix):
    brushed = material_for(brushed_fit())
    brushed.name = "brushed"
    bpy.ops.measured_brdf.mix(first="dark", second="brushed", factor=0.5)
    made = bpy.context.object.active_material
    assert materials.tangent_input(made) is not None
    assert materials.tangent_input(mix) is None
    group = materials.surface_node(made)
    group.inputs["Rotation"].default_value = 0.25
    assert spot_at(0.3, 0.4).turn == pytest.approx(math.pi / 2)
