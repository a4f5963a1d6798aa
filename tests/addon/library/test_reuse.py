"""Measured materials kept, copied, taken to other files, fitted again; folders made into asset libraries."""

import os
import re
import signal
import subprocess
import sys
import time
import uuid
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from bpy_extras.io_utils import ImportHelper
from measured_brdf.addon.core.storage import paths
from measured_brdf.addon.importing import asking
from measured_brdf.addon.work import tasks
from measured_brdf.fitter import PRESETS
from measured_brdf.fitter.formats import list_samples
from measured_brdf.fitter.samples import subset

from support import command
from support.cases import quick, release
from support.checkout import ROOT
from support.stage import black_scene

CHEAP = {"preset": "Paper", "diffuse_level": 2, "specular_level": 3, "compression": 80.0}


@pytest.fixture
def material(blender, cube, file):
    assert blender.ops.measured_brdf.import_data(filepath=str(file), **CHEAP) == {"FINISHED"}
    return cube.active_material


def settings_of(material):
    settings = material.measured_brdf
    return {"filepath": paths.absolute(material)} | {name: getattr(settings, name) for name in (
        "sample", "preset", "diffuse_level", "specular_level", "compression", "use_tolerance", "digest",
        "coefficients", "bytes", "rmse", "fitted_levels", "name_of_data")}


def renders(material):
    script = next(node for node in material.node_tree.nodes if node.type == "GROUP").node_tree.nodes[
        "Measured BRDF Shader"]
    return bool(script.bytecode)


def test_several_files_dropped_become_materials_and_the_first_is_assigned(blender, cube, glossy, write_astm, tmp_path):
    names = ["a", "b", "c"]
    for name in names:
        write_astm(tmp_path / f"{name}.astm", glossy, name)
    (tmp_path / "broken.astm").write_text("nonsense")
    handler = blender.types.FileHandler.bl_rna_get_subclass_py("MEASUREDBRDF_FH_measurements")
    assert set(handler.bl_file_extensions.split(";")) == {
        ".dat", ".astm", ".brdf", ".mat", ".bsdf", ".bin", ".binary", ".mbsdf", ".csv", ".npz", ".tsv", ".txt",
        ".anisotropicbsdf"}
    assert handler.bl_import_operator == "measured_brdf.import_data"
    # as Blender calls it for files that are dropped
    blender.ops.measured_brdf.import_data("INVOKE_DEFAULT", directory=str(tmp_path), **CHEAP, files=[
        {"name": f"{name}.astm"} for name in ["a", "broken", "b", "c"]])
    assert sorted(item.name for item in blender.data.materials) == names
    assert blender.context.object.active_material.name == "a"
    assert [item.use_fake_user for item in map(blender.data.materials.get, names)] == [False, True, True]
    assert {item.measured_brdf.filepath for item in blender.data.materials} == {
        str(tmp_path / f"{name}.astm") for name in names}


def test_a_folder_becomes_materials_and_a_curet_file_one_a_sample(blender, data, glossy, write_astm, tmp_path):
    black_scene(16, 16, samples=1, span=1)
    rows = (data / "curet" / "abrdf.dat").read_text().splitlines()[:2]
    (tmp_path / "abrdf.dat").write_text("\n".join(rows))
    write_astm(tmp_path / "glossy.astm", glossy)
    astm = (tmp_path / "glossy.astm").read_text()
    (tmp_path / "mine.txt").write_text("# angles: radians\n# name: mine\n" + astm[astm.index("theta_i"):])
    (tmp_path / "README.txt").write_text("Measured on Monday.\n")
    assert blender.ops.measured_brdf.import_folder(directory=str(tmp_path), **CHEAP) == {"FINISHED"}
    assert sorted(item.name for item in blender.data.materials) == ["felt", "glossy", "mine", "polyester"]
    assert blender.data.materials["polyester"].measured_brdf.sample == "polyester"


def test_no_folder_is_not_the_current_one(blender, tmp_path, monkeypatch, write_astm, glossy):
    write_astm(tmp_path / "glossy.astm", glossy)
    monkeypatch.chdir(tmp_path)
    for name in ("import_folder", "convert_folder"):
        with pytest.raises(RuntimeError, match="no folder is named: the path is empty"):
            getattr(blender.ops.measured_brdf, name)()


def test_a_folder_without_measurements_is_an_error_that_says_what_to_do(blender, tmp_path):
    with pytest.raises(RuntimeError, match=r"no files of measurements .*choose a folder"):
        blender.ops.measured_brdf.import_folder(directory=str(tmp_path))


def test_the_samples_of_a_file_can_be_chosen_by_name(blender, material, data):
    asking._items[:] = [(name, name, "") for _, name in list_samples(data / "curet" / "abrdf.dat")]
    assert blender.ops.measured_brdf.choose_sample(item="aluminum foil", for_material=True) == {"FINISHED"}
    assert material.measured_brdf.sample == "aluminum foil"
    assert blender.ops.measured_brdf.choose_sample(
        item="leather", filepath=str(data / "curet" / "abrdf.dat")) == {"FINISHED"}
    assert blender.context.object.active_material.name == "leather"


@pytest.mark.parametrize("how", quick(["append", "link", "override"], "override"))
def test_in_another_file_the_settings_are_the_same(blender, material, from_library, how):
    before = settings_of(material)
    taken = from_library(material.name, link=how != "append")
    if how == "override":
        taken = blender.context.object.active_material = taken.override_create()
    assert settings_of(taken) == before
    assert renders(taken)
    assert blender.ops.measured_brdf.fit.poll() == (how == "append")


def test_a_copy_is_fitted_by_itself(blender, material):
    copy = material.copy()
    before = settings_of(copy)
    assert settings_of(material) == before
    material.measured_brdf.diffuse_level = 3
    assert blender.ops.measured_brdf.fit() == {"FINISHED"}
    assert settings_of(copy) == before
    assert material.measured_brdf.coefficients > before["coefficients"]
    assert renders(copy)
    assert renders(material)
    assert len([tree for tree in blender.data.node_groups if "fit" in tree]) == 2


def test_a_file_that_has_moved_is_found_again(blender, material, file, tmp_path, monkeypatch):
    before = settings_of(material)
    moved = tmp_path / "elsewhere" / "glossy.astm"
    moved.parent.mkdir()
    file.rename(moved)
    with pytest.raises(RuntimeError, match="No such file"):
        blender.ops.measured_brdf.fit()
    assert settings_of(material) == before
    monkeypatch.setattr(tasks, "outcome", None)         # which fits
    assert blender.ops.measured_brdf.find_file(filepath=str(moved)) == {"FINISHED"}
    assert settings_of(material) == before | {"filepath": str(moved)}
    monkeypatch.undo()
    material.measured_brdf.filepath, material.measured_brdf.diffuse_level = str(file), 1
    assert blender.ops.measured_brdf.find_file(filepath=str(moved), refit=True) == {"FINISHED"}
    assert material.measured_brdf.fitted_levels.startswith("(1,")


@pytest.mark.parametrize("is_there", [True, False])
def test_the_file_browser_proposes_the_name_of_the_missing_file(blender, material, extension, tmp_path, is_there):
    """In its folder, or where that is gone, in that of the .blend."""
    shown = []
    folder = tmp_path / "scene" if not is_there else tmp_path / "data"
    for name in ("scene", "data") if is_there else ("scene",):
        (tmp_path / name).mkdir()
    blender.ops.wm.save_as_mainfile(filepath=str(tmp_path / "scene" / "scene.blend"))
    material = blender.context.object.active_material
    material.measured_brdf.filepath = str(tmp_path / "data" / "felt.astm")
    find = extension.addon.importing.relink.MEASUREDBRDF_OT_find_file
    operator = type("Driven", (ImportHelper,), {"invoke": find.invoke})()
    context = SimpleNamespace(material=material, object=None, window_manager=SimpleNamespace(
        fileselect_add=lambda operator: shown.append(operator.filepath)))
    operator.invoke(context, None)
    assert shown == [str(folder / "felt.astm")]


def test_missing_files_of_all_materials_are_found_by_name_below_a_folder(blender, material, file, glossy, write_astm,
                                                                         tmp_path, capfd):
    """Of files of one name, the one with the measurements that the material was fitted to."""
    copy, lost, published = material.copy(), material.copy(), material.copy()
    lost.measured_brdf.filepath, published.measured_brdf.filepath = str(tmp_path / "nowhere.astm"), "published:chrome"
    other, right = tmp_path / "a" / "glossy.astm", tmp_path / "b" / "c" / "glossy.astm"
    other.parent.mkdir()
    right.parent.mkdir(parents=True)
    write_astm(other, replace(glossy, values=2 * glossy.values), "glossy")
    file.rename(right)
    (tmp_path / "b" / "loop").symlink_to(tmp_path, target_is_directory=True)
    before = settings_of(material)
    assert blender.ops.measured_brdf.find_missing(directory=str(tmp_path)) == {"FINISHED"}
    assert settings_of(material) == settings_of(copy) == before | {"filepath": str(right)}
    assert published.measured_brdf.filepath == "published:chrome"
    told = capfd.readouterr().out
    assert "2 of 3 materials relinked" in told
    assert "nowhere.astm is not in" in told
    lost.measured_brdf.filepath = str(right)
    with pytest.raises(RuntimeError, match="No measurements"):
        blender.ops.measured_brdf.find_missing(directory=str(tmp_path))


def test_a_file_that_has_changed_is_recognised(blender, material, file, glossy, write_astm, capfd):
    before = material.measured_brdf.digest
    assert blender.ops.measured_brdf.fit() == {"FINISHED"}
    assert material.measured_brdf.digest == before
    assert "measurements differ" not in capfd.readouterr().out
    write_astm(file, replace(glossy, values=glossy.values * 1.1))
    assert blender.ops.measured_brdf.fit() == {"FINISHED"}
    assert material.measured_brdf.digest != before
    assert "the measurements differ from those of the previous fit" in capfd.readouterr().out


def test_a_preset_sets_its_levels_and_nothing_else(blender, material):
    fitted = settings_of(material)["coefficients"]
    assert blender.ops.measured_brdf.use_preset(preset="Reference") == {"FINISHED"}
    settings = material.measured_brdf
    assert settings.preset == "Reference"
    assert settings.diffuse_level == PRESETS["Reference"]["diffuse_level"]
    assert settings.coefficients == fitted


@release
def test_auto_finds_a_fit_within_the_tolerance(blender, glossy, write_astm, tmp_path):
    black_scene(16, 16, samples=1, span=1)
    few = write_astm(tmp_path / "few.astm", subset(glossy, slice(40)))
    assert blender.ops.measured_brdf.import_data(filepath=str(few), use_tolerance=True, tolerance=0.05) == {"FINISHED"}
    settings = blender.data.materials["glossy"].measured_brdf
    assert settings.rmse <= 0.05
    assert settings.use_tolerance


def albedo_of_glossy():
    """Of conftest's synthetic measurement, in even light, by random directions: (3,)."""
    random = np.random.default_rng(3)
    theta_i, theta_o = np.arcsin(np.sqrt(random.random((2, 200_000))))
    phi = random.random(200_000) * 2 * np.pi
    cosine = -np.sin(theta_i) * np.sin(theta_o) * np.cos(phi) + np.cos(theta_i) * np.cos(theta_o)
    lobe = np.maximum(cosine, 0)[:, None] ** [20.0, 18.0, 15.0]
    return np.array([0.05, 0.08, 0.2]) + np.pi * (np.array([0.5, 0.5, 0.4]) * lobe).mean(axis=0)


def test_eevee_and_the_viewport_show_what_is_near(blender, material, glossy):
    tree = material.node_tree
    for engine, socket in (("CYCLES", "BSDF"), ("EEVEE", "EEVEE")):
        assert tree.get_output_node(engine).inputs["Surface"].links[0].from_socket.name == socket
    exported = tree.get_output_node("ALL").inputs["Surface"].links[0].from_node
    color = np.array(exported.inputs["Base Color"].default_value[:3])
    np.testing.assert_allclose(color, albedo_of_glossy(), atol=0.07)     # a rough metal is darker
    np.testing.assert_allclose(material.diffuse_color[:3], albedo_of_glossy(), atol=0.02)
    assert blender.ops.measured_brdf.fit() == {"FINISHED"}
    assert sum(node.type == "OUTPUT_MATERIAL" for node in tree.nodes) == 3


def test_an_output_for_eevee_of_ones_own_is_left_alone(blender, file):
    black_scene(16, 16, samples=1, span=1)
    blender.ops.mesh.primitive_cube_add()
    mine = blender.data.materials.new("Mine")
    if not mine.node_tree:
        mine.use_nodes = True
    blender.context.object.data.materials.append(mine)
    emission = mine.node_tree.nodes.new("ShaderNodeEmission")
    output = mine.node_tree.nodes.new("ShaderNodeOutputMaterial")
    output.target = "EEVEE"
    mine.node_tree.links.new(emission.outputs[0], output.inputs["Surface"])
    mine.measured_brdf.filepath = str(file)
    assert blender.ops.measured_brdf.fit() == {"FINISHED"}
    assert mine.node_tree.get_output_node("EEVEE").inputs["Surface"].links[0].from_node == emission
    mine.node_tree.links.remove(output.inputs["Surface"].links[0])
    assert blender.ops.measured_brdf.fit() == {"FINISHED"}
    assert output.inputs["Surface"].links[0].from_socket.name == "EEVEE", "an output of nothing is not of one's own"


def assert_is_asset(item, tag):
    about = item.asset_data
    assert "measured reflectance" in about.description
    assert {"measured", "BRDF", tag} <= {each.name for each in about.tags}
    assert tuple(item.preview.image_size) == (256, 256)
    pixels = np.array(item.preview.image_pixels_float[:]).reshape(256, 256, 4)
    assert pixels[0, 0, 3] == 0
    assert pixels[128, 128, 3] == 1
    return uuid.UUID(about.catalog_id)


def test_saved_to_an_asset_library_it_is_found_there(blender, material, tmp_path):
    library = tmp_path / "assets"
    assert blender.ops.measured_brdf.save_asset(directory=str(library)) == {"FINISHED"}
    assert material.asset_data is None
    blender.ops.wm.open_mainfile(filepath=str(library / "glossy.blend"))
    catalogue = assert_is_asset(blender.data.materials["glossy"], "glossy")
    assert f"{catalogue}:Measured BRDF:" in (library / "blender_assets.cats.txt").read_text()
    assert renders(blender.data.materials["glossy"])


def test_without_a_library_it_becomes_an_asset_of_the_file(blender, material):
    assert blender.ops.measured_brdf.save_asset() == {"FINISHED"}
    assert_is_asset(material, "glossy")


@pytest.fixture
def ten(tmp_path, glossy, write_astm):
    """Nine files of measurements and a broken one."""
    folder = tmp_path / "ten"
    folder.mkdir()
    for number in range(9):
        write_astm(folder / f"{number}.astm", glossy, f"paint {number}")
    (folder / "9.astm").write_text("nonsense")
    return folder


@pytest.fixture
def three(ten):
    """Two files of measurements and a broken one."""
    for number in range(2, 9):
        (ten / f"{number}.astm").unlink()
    return ten


def test_shards_share_the_work(extension, three, tmp_path):
    (three / "9.astm").unlink()
    killed = tmp_path / "library-1of2.fits" / "key.npz.0123abcd.part"
    killed.parent.mkdir()
    killed.write_text("half")
    for part in (1, 2):
        done = command.convert(three, tmp_path / "library.blend", "--shard", f"{part}/2", "--processes", "1")
        assert done.returncode == 0, done.stderr
        assert "1 done, 0 failed" in done.stdout
        assert f"paint {part - 1}" in done.stdout
    assert {path.name for path in tmp_path.glob("*.blend")} == {"library-1of2.blend", "library-2of2.blend"}
    assert not killed.exists()
    kept, = killed.parent.iterdir()
    assert re.fullmatch(r"\w+\.astm", extension.fitter.Fit.load(kept).source), "without its folder"


@release
def test_a_conversion_that_is_killed_leaves_the_old_library_and_a_rerun_goes_on_where_it_was(blender, ten, tmp_path):
    folder, out = tmp_path / "old", tmp_path / "library.blend"
    folder.mkdir()
    (ten / "0.astm").rename(folder / "0.astm")
    assert command.convert(folder, out).returncode == 0
    old, fits = out.read_bytes(), out.with_suffix(".fits")
    converting = [sys.executable, ROOT, "convert", ten, "-o", out, *command.CHEAP, "--processes", "1"]
    process = subprocess.Popen(converting, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True)
    while len(list(fits.glob("*.npz"))) < 4:
        assert process.poll() is None
        time.sleep(0.01)
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    assert out.read_bytes() == old
    done = {path: path.stat().st_mtime_ns for path in fits.glob("*.npz")}
    assert len(done) < 9
    (folder / "0.astm").rename(ten / "0.astm")
    again = command.convert(ten, out)
    assert "9 done, 1 failed" in again.stdout
    assert again.stdout.count("up to date") == 1
    assert {path: path.stat().st_mtime_ns for path in done} == done
    with blender.data.libraries.load(str(out)) as (source, _):
        assert len(source.materials) == 9


@release
def test_the_command_renders(three, tmp_path):
    done = subprocess.run([sys.executable, ROOT, "render", three / "1.astm", "-o", tmp_path / "png", "--size", "32",
                           "--samples", "4", "--preset", "Paper"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "png" / "paint_1.png").read_bytes().startswith(b"\x89PNG")


def test_errors_of_the_command_are_one_line(tmp_path):
    done = subprocess.run([sys.executable, ROOT, "convert", tmp_path / "none", "-o", tmp_path / "a.blend"],
                          capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert "cannot be read: No such file" in done.stdout
