"""The denoiser's albedo and the passes of a render, of a plane seen at 45 degrees.

And measured materials as holdouts, as shadow catchers and in instances.
"""

import math

import bpy
import numpy as np
import pytest

import fitter
from support import stage
from support.cases import quick, release

SEEN_AT = math.radians(45)


def passes(scene, path):
    """The passes of a scene, by the name of each: (height, width, channels)."""
    import OpenImageIO

    layer = scene.view_layers[0]
    scene.cycles.use_denoising = layer.cycles.denoising_store_passes = True
    layer.use_pass_diffuse_direct = layer.use_pass_glossy_direct = True
    settings = scene.render.image_settings
    if hasattr(settings, "media_type"):             # Blender 5
        settings.media_type = "MULTI_LAYER_IMAGE"
    settings.file_format, settings.color_depth = "OPEN_EXR_MULTILAYER", "32"
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    file, found, part = OpenImageIO.ImageInput.open(str(path)), {}, 0
    while file.seek_subimage(part, 0):
        spec = file.spec()
        values = file.read_image(part, 0, 0, spec.nchannels, OpenImageIO.FLOAT)
        for channel, name in enumerate(spec.channelnames):
            found.setdefault(name.split(".")[1], []).append(values[..., channel])
        part += 1
    return {name: np.stack(channels, axis=-1) for name, channels in found.items()}


def plane(fit, light):
    scene = stage.black_scene(16, 16, 128, span=1)
    scene.cycles.max_bounces = 0
    scene.camera.location = 0, -10 * math.sin(SEEN_AT), 10 * math.cos(SEEN_AT)
    scene.camera.rotation_euler = SEEN_AT, 0, 0
    bpy.ops.mesh.primitive_plane_add(size=8)
    material = stage.osl_material_for(fit)
    stage.set_input(material, "Tint", (0.5, 1, 1, 1))
    bpy.context.object.data.materials.append(material)
    if light == "world":
        stage.background(scene, 1)
    elif light == "point":
        stage.add_lamp("POINT", 100, (-2, 2, 3), shadow_soft_size=0.15)
    else:
        stage.add_lamp("AREA", 300, (0, 3, 3.5), (-math.atan2(3, 3.5), 0, 0), shape="SQUARE", size=2)
    return scene


def albedo(fit):
    """The reflected share of even light, by a sum over the hemisphere: (channels,)."""
    theta, phi = np.meshgrid((np.arange(180) + 0.5) * math.pi / 360, (np.arange(120) + 0.5) * math.pi / 60)
    value = np.maximum(fit.evaluate(theta.ravel(), phi.ravel(), SEEN_AT, 0.0), 0)
    return (value * (np.cos(theta) * np.sin(theta)).ravel()[:, None]).sum(axis=0) * (math.pi / 360) * (math.pi / 60)


@pytest.mark.parametrize("light", ["world", pytest.param("point", marks=release), "area"])
def test_the_denoiser_is_told_the_albedo_and_no_pass_is_negative(blender, curet, tmp_path, light):
    fit = fitter.fit(curet("aluminum foil"))
    found = passes(plane(fit, light), tmp_path / "passes.exr")
    guide = found["Denoising Albedo"].mean(axis=(0, 1))
    np.testing.assert_allclose(guide, albedo(fit) * [0.5, 1, 1], rtol=0.05)
    normal = found["Denoising Normal"].mean(axis=(0, 1))
    away = normal @ [0, math.sin(SEEN_AT), -math.cos(SEEN_AT)] / np.linalg.norm(normal)
    # in even light all is in sampled directions, whose normals are half vectors
    assert math.degrees(math.acos(away)) < (17 if light == "world" else 4)
    names = {"Diffuse Direct", "Glossy Direct", "DiffDir", "GlossDir"}         # of Blender 5, and of 4
    direct = [values for name, values in found.items() if name in names]
    assert len(direct) == 2, list(found)
    assert min(values.min() for values in direct) >= 0


@pytest.mark.parametrize("light", ["world", "area"])
@pytest.mark.parametrize("material", ["gold-satin", "aluminium-brushed", "krylon"])
def test_the_denoiser_has_the_albedo_of_metals_and_of_what_shines(blender, cornell, tmp_path, material, light):
    """Krylon's gloss is so narrow that Cycles leaves its closures out."""
    samples = cornell("krylon_blue_RGB") if material == "krylon" else fitter.load_published(material)
    fit = fitter.fit(samples, **fitter.PRESETS["Standard"])
    guide = passes(plane(fit, light), tmp_path / "passes.exr")["Denoising Albedo"].mean(axis=(0, 1))
    ratio = guide / (albedo(fit) * [0.5, 1, 1])
    print(f"{material}, {light}: denoiser's albedo / albedo = {ratio}")
    assert ratio == pytest.approx([1, 1, 1], abs=0.05)


@pytest.mark.parametrize("rendering", quick(["EXACT", "NODES"], "EXACT"))
def test_a_holdout_leaves_a_hole(blender, fit, rendering):
    scene, item = sphere(fit, rendering)
    stage.background(scene, 1)
    assert stage.render(scene)[6:10, 6:10, 3].min() == 1
    item.is_holdout = True
    assert stage.render(scene)[6:10, 6:10].max() == 0


@pytest.mark.parametrize("rendering", quick(["EXACT", "NODES"], "EXACT"))
def test_a_shadow_catcher_catches_the_shadow_that_a_diffuse_one_does(blender, fit, rendering):
    pictures = []
    for measured in (True, False):
        scene = stage.black_scene(16, 16, 64, span=3)
        stage.add_lamp("SUN", 3, rotation=(0, -0.6, 0), angle=0.1)
        bpy.ops.mesh.primitive_plane_add(size=8)
        plane = bpy.context.object
        if measured:
            plane.data.materials.append(stage.osl_material_for(fit))
            stage.set_input(plane.data.materials[0], "Nodes", rendering == "NODES")
        else:
            plane.data.materials.append(stage.simple_material("diffuse", "ShaderNodeBsdfDiffuse"))
        plane.is_shadow_catcher = True
        bpy.ops.mesh.primitive_cube_add(size=1, location=(0, 0, 0.8))
        pictures.append(stage.render(scene)[..., 3])
    assert pictures[1].min() == 0
    assert pictures[1][8, 11:14].min() > 0.9
    np.testing.assert_allclose(pictures[0], pictures[1], atol=0.1)


@pytest.mark.parametrize("rendering", quick(["EXACT", "NODES"], "EXACT"))
def test_an_instance_looks_as_its_object(blender, fit, rendering):
    pictures = []
    for instanced in (False, True):
        scene, item = sphere(fit, rendering)
        stage.add_lamp("POINT", 100, (2, 1, 3), shadow_soft_size=0)
        if instanced:
            collection = bpy.data.collections.new("Instanced")
            collection.objects.link(item)
            scene.collection.objects.unlink(item)
            holder = bpy.data.objects.new("Instance", None)
            holder.instance_type, holder.instance_collection = "COLLECTION", collection
            scene.collection.objects.link(holder)
        pictures.append(stage.render(scene))
    assert pictures[0].max() > 0.01
    np.testing.assert_allclose(pictures[1], pictures[0], atol=1e-4 * pictures[0].max())


def sphere(fit, rendering):
    """A sphere of a fit in the dark: (scene, object)."""
    scene = stage.black_scene(16, 16, 16, span=2)
    item = stage.add_sphere()
    item.data.materials.append(stage.osl_material_for(fit))
    stage.set_input(item.data.materials[0], "Nodes", rendering == "NODES")
    return scene, item


@pytest.fixture(scope="module")
def fit(curet):
    return fitter.fit(curet("felt"), **fitter.PRESETS["Draft"])
