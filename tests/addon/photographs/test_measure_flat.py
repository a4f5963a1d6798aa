"""Photographs of a flat sample become a plane with its material, which Cycles shows as the sample itself looks."""

import contextlib
import math
from pathlib import Path

import bpy
import numpy as np
import pytest

import fitter
from fitter.formats import saved_samples
from support import flat_files, flat_scene, stage
from support.blend_state import state
from support.cases import quick, release
from tests.addon.work.test_failing_operators import _Injection as Injection

SIZE = flat_files.SIZE
SIDE = np.array([0.3, -0.25, 0.25])         # 57 degrees from the normal
NAMES = "garnet", "krylon", "leather"


@pytest.fixture(scope="module")
def sample(cornell, curet):
    fits = tuple(fitter.fit(samples, **fitter.PRESETS["Draft"])
                 for samples in (cornell("garnet_red_RGB"), cornell("krylon_blue_RGB"), curet("leather")))
    return flat_scene.Sample(fits, flat_scene.smooth_weights(3), flat_scene.bumps)


@pytest.fixture(scope="module")
def written(openimageio, sample, tmp_path_factory):
    """The description of the sample, whose materials are saved beside it."""
    folder = tmp_path_factory.mktemp("flat")
    for fit, name in zip(sample.fits, NAMES, strict=True):
        fit.save(folder / f"{name}.npz")
    top = f"texels = 24\nmaterials = {[f'{name}.npz' for name in NAMES]}"
    return flat_files.write(folder, sample, flat_scene.lamps(10), top=top)


@pytest.fixture
def scene(blender):
    """An empty black scene, as large as the photographs."""
    made = stage.black_scene(*SIZE[::-1], samples=64, span=1)
    made.cycles.max_bounces, made.cycles.pixel_filter_type = 0, "BOX"
    return made


@pytest.fixture(autouse=True)
def measured_once(extension, monkeypatch):
    """What the same description says is measured once for all tests."""
    work = extension.addon.photographs.work
    flat = work.flat

    def once(path, *arguments):
        key = Path(path).name, Path(path).read_text("utf-8"), repr(arguments)
        if key not in _measured:
            _measured[key] = flat(path, *arguments)
        return _measured[key]
    monkeypatch.setattr(work, "flat", once)


_measured = {}


def measure(path, **options):
    assert bpy.ops.measured_brdf.measure_flat(filepath=str(path), **options) == {"FINISHED"}
    return bpy.context.object


def changed(path, *pairs, name="other.toml"):
    """A description like another, but for some of its text."""
    text = path.read_text("utf-8")
    for old, new in pairs:
        assert old in text
        text = text.replace(old, new)
    other = path.with_name(name)
    other.write_text(text, "utf-8")
    return other


def rendered_apart(scene, sample, camera, block=10):
    """How far a render under a lamp that was not used is from the sample's photograph, of its root mean square: in the
    means of blocks of pixels, since samples of three materials are of one of them each."""
    truth = flat_scene.photograph(sample, flat_scene.UNUSED, noise=0, camera=camera)
    stage.look(tuple(camera), tuple(flat_scene.TARGET), lens=36 / 0.25)
    scene.camera.data.sensor_width = 36
    if not any(item.type == "LIGHT" for item in scene.objects):
        most = flat_scene.INTENSITY.max()
        lamp = stage.add_lamp("POINT", 4 * math.pi * most, tuple(flat_scene.UNUSED), shadow_soft_size=0.0,
                              color=flat_scene.INTENSITY / most)
        lamp.data.use_soft_falloff = False
    picture = stage.render(scene)
    inside = (truth.max(axis=2) > 0) & (picture[..., 3] > 1 - 1e-6)
    assert inside.mean() > 0.2
    blocks = SIZE[0] // block, block, SIZE[1] // block, block, 3
    off, there = (np.where(inside[..., None], each, 0).reshape(blocks).mean(axis=(1, 3))
                  for each in (picture[..., :3] - truth, truth))
    return float(np.linalg.norm(off) / np.linalg.norm(there))


def test_the_plane_looks_like_the_sample_from_above_and_from_the_side(scene, sample, written):
    """Of three materials: a mask is inside of a mix. Reached: 1.3 % and 1.0 %; by nodes 1.8 % and 1.6 %."""
    item = measure(written)
    np.testing.assert_allclose(item.dimensions, [flat_scene.SIZE, 0.8 * flat_scene.SIZE, 0], atol=1e-7)
    images = [image for image in bpy.data.images if image.packed_file is not None and "flat sample" in image.name]
    assert sorted(image.depth for image in images) == [32, 32, 32, 96], "masks, brightness and normals"
    assert all(image.colorspace_settings.is_data and tuple(image.size) == (24, 19) for image in images)
    apart = {}
    for osl in (True, False):
        scene.cycles.shading_system = osl
        for name, camera in (("above", flat_scene.CAMERA), ("side", SIDE)):
            apart[name, osl] = rendered_apart(scene, sample, camera, 10 if osl else 1)
    print({key: f"{value:.2%}" for key, value in apart.items()})
    assert max(apart["above", True], apart["side", True]) < 0.02
    assert max(apart["above", False], apart["side", False]) < 0.05


def test_it_is_all_in_the_file_and_undo_takes_it_back(scene, sample, written, tmp_path):
    bpy.ops.ed.undo_push(message="before")
    before = state()
    measure(written)
    bpy.ops.ed.undo_push(message="measured")
    bpy.ops.ed.undo()
    assert state() == before
    bpy.ops.ed.redo()
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "flat.blend"))
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "flat.blend"))
    assert rendered_apart(bpy.context.scene, sample, flat_scene.CAMERA) < 0.02


@release
def test_materials_that_are_found_make_a_plane_like_the_sample(scene, sample, written):
    """Issue: 8 %."""
    materials = f"materials = {[f'{name}.npz' for name in NAMES]}"
    measure(changed(written, (materials, "")))
    assert rendered_apart(scene, sample, flat_scene.CAMERA) < 0.08


def test_materials_of_the_file_are_mixed_and_stay_as_they_are(scene, sample, written):
    from measured_brdf.addon.core.shading import material as materials

    for fit, name in zip(sample.fits, NAMES, strict=True):
        stage.material_for(fit).name = name
    before = {name: state()[name]["leather"] for name in ("nodes", "settings")}
    made = measure(written, first="garnet", second="krylon", third="leather").active_material
    assert [each.name for each in materials.measured_parts(made)] == list(NAMES)
    assert {name: state()[name]["leather"] for name in before} == before
    assert rendered_apart(scene, sample, SIDE) < 0.02
    # alone it is copied, and its brightness and normals are those of the sample
    alone = measure(written, first="leather").active_material
    assert alone != bpy.data.materials["leather"]
    assert state()["nodes"]["leather"] == before["nodes"]
    assert all(materials.surface_node(alone).inputs[name].is_linked for name in ("Strength", "Normal"))


def draw(places):
    """A mask of points, in Blender's coordinates: both go from 0 to 1 over the longer side, the middle is at .5."""
    mask = bpy.data.masks.new("Corners")
    points = mask.layers.new().splines.new().points
    points.add(len(places) - len(points))
    for point, (x, y) in zip(points, places, strict=True):
        point.co = 0.5 + (x - SIZE[1] / 2) / max(SIZE), 0.5 - (y - SIZE[0] / 2) / max(SIZE)
    return mask.name


def test_corners_drawn_as_a_mask_are_those_of_the_sample(scene, sample, written):
    places = flat_files.corners()
    text = f"corners = {[[round(float(x), 3) for x in place] for place in places]}"
    measure(changed(written, (text, "corners = [[20, 80], [60, 80], [60, 40], [20, 40]]")), mask=draw(places))
    assert rendered_apart(scene, sample, flat_scene.CAMERA) < 0.02


def test_a_tile_is_smaller_and_repeats(scene, sample, written):
    item = measure(written, tile=True)
    textures = [node for tree in (item.active_material.node_tree, *bpy.data.node_groups) for node in tree.nodes
                if node.type == "TEX_IMAGE"]
    assert len(textures) == 6, "two masks, brightness, normals, and the two that are exported"
    assert {node.extension for node in textures} == {"REPEAT"}
    width, height = textures[0].image.size
    assert {tuple(node.image.size) for node in textures} == {(width, height)}
    assert 12 <= width < 24
    np.testing.assert_allclose(item.dimensions[:2], flat_scene.SIZE * np.array([width / 24, 0.8 * height / 19]),
                               rtol=1e-5)


@pytest.mark.parametrize("count", [3, 5])
def test_a_mask_of_other_than_four_points_is_refused(scene, written, count):
    name, before = draw(np.ones((count, 2))), state()
    with pytest.raises(RuntimeError, match="'Corners' is not a mask of one spline with four points"):
        bpy.ops.measured_brdf.measure_flat(filepath=str(written), mask=name)
    assert state() == before


@pytest.mark.parametrize(("change", "options", "message"), [
    ([("width = 0.1", "width = 0.3")], {}, "other.toml: sample.corners .*a rectangle of 0.3 x 0.08 m"),
    ([("lamp3.exr", "lamp33.exr")], {}, "lamp33.exr: cannot be read"),
    ([("lamp = [", "lamp = [0, 0, -1] #")], {}, "lamp is behind the sample"),
    ([("krylon.npz", "lamp1.exr")], {}, "lamp1.exr"),
    ([], {"first": "nowhere"}, "'nowhere' is not a measured material"),
    ([], {"mask": "nowhere"}, "'nowhere' is not a mask of one spline"),
    ([], {"first": "plain"}, "'plain' is not a measured material"),
    ([], {"first": "brushed"}, "brushed: anisotropic"),
])
def test_what_cannot_be_is_refused_and_changes_nothing(scene, written, change, options, message):
    from support.anisotropic import brushed_fit

    bpy.data.materials.new("plain")
    if options.get("first") == "brushed":
        stage.material_for(brushed_fit()).name = "brushed"
    path, before = changed(written, *change), state()
    with pytest.raises(RuntimeError, match=message) as error:
        bpy.ops.measured_brdf.measure_flat(filepath=str(path), **options)
    assert len(str(error.value).strip().removeprefix("Error: ").splitlines()) == 1
    assert state() == before


def shuffled(path):
    """A description whose lamps belong to other photographs."""
    lines = path.read_text("utf-8").splitlines()
    places = [line for line in lines if line.startswith("lamp = [")]
    moved = iter(places[3:] + places[:3])
    other = path.with_name("shuffled.toml")
    other.write_text("\n".join(next(moved) if line.startswith("lamp = [") else line for line in lines), "utf-8")
    return other


def test_the_info_line_warns_of_photographs_that_are_not_predicted(scene, written, capfd):
    few = (("texels = 24", "texels = 6"),)
    measure(changed(written, *few))
    assert "is predicted within" in (told := capfd.readouterr().out)
    assert not [line for line in told.splitlines() if line.startswith("Warning:")]
    measure(shuffled(changed(written, *few)))
    warned = [line for line in capfd.readouterr().out.splitlines() if line.startswith("Warning:")]
    assert any("poor. So the photographs are not predicted: lamps, places or the order of the files" in line
               for line in warned)


@pytest.fixture
def few(written):
    """A description of two materials and few texels."""
    return changed(written, ("texels = 24", "texels = 4"), ("'krylon.npz', 'leather.npz'", "'krylon.npz'"))


def test_an_anisotropic_material_is_refused_before_any_is_fitted(extension, written, monkeypatch):
    brushed = fitter.Samples(*np.radians([[30.0, 40], [0, 30], [30, 40], [180, 200]]), np.full((2, 3), 0.2),
                             ("R", "G", "B"), "brushed", isotropic=False)
    saved_samples.write(brushed, written.with_name("brushed.npz"))
    path = changed(written, ("'leather.npz'", "'brushed.npz'"), ("'garnet.npz'", "'again.npz'"))
    saved_samples.write(fitter.Samples(*brushed.directions, brushed.values, brushed.channels),
                        written.with_name("again.npz"))
    work = extension.addon.photographs.work
    monkeypatch.setattr(work.tasks, "outcome", lambda *_, **__: pytest.fail("fitted"))
    with pytest.raises(ValueError, match="brushed: anisotropic, expected materials that are isotropic"):
        work.flat(str(path), None, False, [], {}, {"colours": "Rec.709"})


@pytest.mark.parametrize("step", quick([1, 5], 5))
def test_an_error_anywhere_changes_nothing(scene, few, capfd, step):
    """Of all functions that are called, or of each fifth."""
    measure(few)         # now it is known
    bpy.ops.wm.read_factory_settings(use_empty=True)
    before, places = state(), []
    for at in range(1, 200, step):
        injection, result = Injection(at), None
        with contextlib.suppress(RuntimeError), injection:
            result = bpy.ops.measured_brdf.measure_flat(filepath=str(few))
        if injection.where is None:
            break
        places.append(injection.where)
        assert state() == before, injection.where
    assert result == {"FINISHED"}
    assert state() != before
    assert len(places) > 10
    capfd.readouterr()


def test_without_the_slice_that_mixes_it_says_so(scene, few, monkeypatch):
    from measured_brdf.addon.core.shading import mixing

    monkeypatch.setattr(mixing, "mixes", mixing.Mixes())
    before = state()
    with pytest.raises(RuntimeError, match="that mixes materials is not there"):
        bpy.ops.measured_brdf.measure_flat(filepath=str(few))
    assert state() == before
