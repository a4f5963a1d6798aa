"""A .blend names its measurements by relative paths, which stay right where it goes, or by no folder at all."""

import shutil
from pathlib import Path

import bpy
import pytest
from measured_brdf.addon.core.storage import paths

CHEAP = {"preset": "Paper", "diffuse_level": 2, "specular_level": -1}


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A user's folder, beside that of another one."""
    monkeypatch.setenv("HOME", str(tmp_path / "home" / "anna.example"))
    monkeypatch.setenv("USERPROFILE", str(tmp_path / "home" / "anna.example"))
    for name in ("work/data", "work/scenes", "elsewhere"):
        (tmp_path / "home" / "anna.example" / name).mkdir(parents=True)
    return tmp_path / "home" / "anna.example"


@pytest.fixture
def material(blender, folder, glossy, write_astm):
    file = write_astm(folder / "work" / "data" / "glossy.astm", glossy)
    assert bpy.ops.measured_brdf.import_data(filepath=str(file), **CHEAP) == {"FINISHED"}
    made = next(item for item in bpy.data.materials if item.measured_brdf.coefficients)
    made.use_fake_user = True
    return made


def save(path, **options):
    bpy.ops.wm.save_as_mainfile(filepath=str(path), compress=False, **options)


def opened(path):
    bpy.ops.wm.open_mainfile(filepath=str(path))
    return next(item for item in bpy.data.materials if item.measured_brdf.coefficients)


@pytest.mark.parametrize(("path", "expected"), [
    ("{home}/work/data/a.astm", "//../data/a.astm"), ("{home}/work/scenes/a.astm", "//a.astm"),
    ("{home}/elsewhere/a.astm", "//../../elsewhere/a.astm"), ("{home}/../berta/a.astm", None),
    ("/nowhere/a.astm", None), ("//a.astm", None), ("a.astm", None), ("published:chrome", None), ("", None)])
def test_paths_are_relative_within_a_folder_that_is_not_that_of_all_users(folder, path, expected):
    path = path.replace("{home}/..", str(folder.parent)).format(home=folder)
    assert paths.relative(path, str(folder / "work" / "scenes")) == (path if expected is None else expected)


def test_a_file_keeps_relative_paths_wherever_it_is_saved(material, folder):
    file, scenes = str(folder / "work" / "data" / "glossy.astm"), folder / "work" / "scenes"
    missing = material.copy()
    missing.measured_brdf.filepath = missing_file = str(folder / "work" / "gone" / "a.astm")
    missing.use_fake_user = True
    with pytest.raises(RuntimeError, match="nowhere"):
        save("/nowhere/a.blend")
    save(folder / "copy.blend", copy=True)
    assert (material.measured_brdf.filepath, missing.measured_brdf.filepath) == (file, missing_file)
    save(scenes / "a.blend")
    assert material.measured_brdf.filepath == "//../data/glossy.astm"
    paths._on_saving("")                    # as Blender calls it for its startup file
    assert material.measured_brdf.filepath == file
    paths._on_saved("")
    save(folder / "elsewhere" / "copy.blend", copy=True)
    assert material.measured_brdf.filepath == "//../data/glossy.astm"
    for saved, expected in ((folder / "copy.blend", "//work/data/glossy.astm"), (scenes / "a.blend", None),
                            (folder / "elsewhere" / "copy.blend", "//../work/data/glossy.astm")):
        copied = opened(saved)
        assert copied.measured_brdf.filepath == (expected or "//../data/glossy.astm")
        assert paths.absolute(copied) == file
        assert sorted(map(paths.absolute, bpy.data.materials)) == [file, missing_file]
    save(folder / "b.blend")
    assert {item.measured_brdf.filepath for item in bpy.data.materials} == {
        "//work/data/glossy.astm", "//work/gone/a.astm"}
    # both folders moved together
    shutil.move(folder / "work", folder / "moved")
    assert paths.absolute(opened(folder / "moved" / "scenes" / "a.blend")) == file.replace("work", "moved")


@pytest.mark.parametrize("how", ["append", "link", "override"])
def test_measurements_of_materials_of_other_files_are_found_also_once_they_are_local(material, folder, how):
    if how == "append" and not hasattr(bpy.app.handlers, "blend_import_post"):
        pytest.skip("this Blender does not tell of imports")
    file, library = str(folder / "work" / "data" / "glossy.astm"), folder / "work" / "scenes" / "a.blend"
    name = material.name
    save(library)
    bpy.ops.wm.read_homefile(use_empty=True)
    with bpy.data.libraries.load(str(library), link=how != "append") as (_, target):
        target.materials = [name]
    item, = target.materials
    item = item.override_create() if how == "override" else item
    bpy.ops.mesh.primitive_cube_add()
    bpy.context.object.data.materials.append(item)
    assert paths.absolute(item) == file
    if how != "append":
        save(folder / "elsewhere" / "b.blend")      # and nothing is written to it
        assert item.measured_brdf.filepath == "//../data/glossy.astm"
        with bpy.context.temp_override(material=item):
            assert bpy.ops.measured_brdf.make_local() == {"FINISHED"}
    local, = (each for each in bpy.data.materials if each.library is None)
    assert paths.absolute(local) == file


def test_forgotten_folders_are_nowhere_in_the_file(material, folder, tmp_path):
    """Not even where it is saved elsewhere since; names of files stay, and find them again."""
    data = str(folder / "work" / "data")
    published, windows = material.copy(), material.copy()
    published.measured_brdf.filepath, windows.measured_brdf.filepath = "published:chrome", "C:\\anna.example\\a.dat"
    published.use_fake_user = windows.use_fake_user = True
    out = tmp_path / "out"
    out.mkdir()
    save(out / "before.blend")
    # where only the folder of all users is shared, the path is whole
    assert b"anna.example/work/data" in (out / "before.blend").read_bytes()
    before = material.measured_brdf.coefficients
    assert bpy.ops.measured_brdf.forget_paths() == {"FINISHED"}
    for path in (out / "a.blend", tmp_path / "b.blend"):
        save(path)
        assert b"anna.example" not in path.read_bytes()
        assert {item.measured_brdf.filepath for item in bpy.data.materials} == {
            "//glossy.astm", "published:chrome", "//a.dat"}
    material = opened(tmp_path / "b.blend")
    assert material.measured_brdf.coefficients == before
    assert bpy.ops.measured_brdf.find_missing(directory=data) == {"FINISHED"}
    assert sum(Path(paths.absolute(item)).is_file() for item in bpy.data.materials) == 1
