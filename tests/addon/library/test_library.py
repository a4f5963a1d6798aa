"""Libraries on disk: which files may be replaced, what users added to them, who may write."""

import contextlib
import itertools
import json
import subprocess
import sys
import tomllib
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import bpy
import pytest
from bpy.app.handlers import persistent
from measured_brdf.addon.core.libraries import library_file
from measured_brdf.addon.core.libraries import library_file as libraries
from measured_brdf.addon.core.shading import material as materials
from measured_brdf.addon.core.shading import mixing
from measured_brdf.addon.work import process, tasks
from measured_brdf.fitter import load

import fitter
from fitter import cli
from fitter.formats import saved_samples
from support import command
from support.blend_state import state
from support.cases import quick, release
from support.checkout import ROOT
from support.command import CHEAP, convert
from support.damaged_npz import with_header
from support.stage import black_scene

SETTINGS = {"preset": "Paper", "diffuse_level": 2, "specular_level": 4, "compression": 80.0}


@pytest.fixture
def folder(tmp_path, glossy, write_astm):
    path = tmp_path / "measurements"
    path.mkdir()
    for name in ("a", "b"):
        write_astm(path / f"{name}.astm", glossy, name)
    return path


@pytest.fixture
def library(blender, tmp_path):
    return tmp_path / "out" / "library.blend"


def names(path, kind="materials"):
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)        # the open file cannot be looked into
    with bpy.data.libraries.load(str(path)) as (source, _):
        return sorted(getattr(source, kind))


def make_scene(path):
    """A user's scene."""
    black_scene(8, 8, samples=1, span=1)
    bpy.ops.mesh.primitive_monkey_add()
    path.parent.mkdir(exist_ok=True)
    bpy.ops.wm.save_as_mainfile(filepath=str(path))


def make_assets(path):
    """An asset library of somebody else's: materials, no scene, written as libraries are."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    item = bpy.data.materials.new("Mine")
    item.asset_mark()
    path.parent.mkdir(exist_ok=True)
    bpy.data.libraries.write(str(path), {item}, fake_user=True)


def make_nonsense(path):
    path.parent.mkdir(exist_ok=True)
    path.write_bytes(b"not a .blend at all")


def make_scene_with_library_material(path, folder):
    """A scene into which a user appended a material that `convert` had made."""
    assert convert(folder, path.with_name("other.blend")).returncode == 0
    black_scene(8, 8, samples=1, span=1)
    bpy.ops.mesh.primitive_monkey_add()
    with bpy.data.libraries.load(str(path.with_name("other.blend"))) as (_, target):
        target.materials = ["a"]
    bpy.context.object.data.materials.append(target.materials[0])
    bpy.ops.wm.save_as_mainfile(filepath=str(path))


@pytest.mark.parametrize("make", quick(
    [make_scene, make_assets, make_nonsense, make_scene_with_library_material], make_nonsense,
    make_scene_with_library_material))
def test_what_is_not_a_library_of_ours_is_refused_and_with_force_put_aside(blender, folder, library, make):
    make(library, folder) if make is make_scene_with_library_material else make(library)
    before = {path.name: path.read_bytes() for path in library.parent.iterdir() if path.is_file()}
    done = convert(folder, library)
    assert done.returncode == 1
    assert f"error: {library} exists and is not a" in done.stderr
    assert "--force" in done.stderr
    assert {path.name: path.read_bytes() for path in library.parent.iterdir() if path.is_file()} == before
    assert not library.with_suffix(".fits").exists()

    done = convert(folder, library, "--force")
    assert done.returncode == 0, done.stderr
    assert names(library) == ["a", "b"]
    assert library.with_name("library.blend.kept1").read_bytes() == before["library.blend"]
    make_nonsense(library)
    assert convert(folder, library, "--force").returncode == 0
    assert library.with_name("library.blend.kept1").read_bytes() == before["library.blend"]
    assert library.with_name("library.blend.kept2").read_bytes() == b"not a .blend at all"


def errors(path):
    """The RMSE of each material of a library, and how it is rendered."""
    bpy.ops.wm.open_mainfile(filepath=str(path))
    return {item.name: (item.measured_brdf.rmse, item.measured_brdf.rendering) for item in bpy.data.materials
            if item.measured_brdf.rmse}


def test_measurements_that_are_a_multiple_and_other_options_are_not_up_to_date(blender, folder, library, glossy,
                                                                               write_astm):
    assert convert(folder, library).returncode == 0
    (before, _), same = errors(library)["a"], errors(library)["b"]
    write_astm(folder / "a.astm", replace(glossy, values=7 * glossy.values), "a")
    done = convert(folder, library)
    assert (done.returncode, done.stdout.count("(!)")) == (cli.BAD, 1)
    assert "  a reflects 2.22 times the light that arrives: " in done.stdout
    assert errors(library) == {"a": (pytest.approx(7 * before, rel=1e-5), "AUTO"), "b": same}
    options = "--quantity", "brdf_percent", "--rendering", "NODES"
    assert "up to date" not in convert(folder, library, *options).stdout
    assert errors(library)["a"] == (pytest.approx(7 * before / 100, rel=1e-5), "NODES")
    assert "fitted" not in convert(folder, library, *options).stdout


def test_a_rendering_that_a_user_chose_in_a_library_stays(blender, folder, library, glossy, write_astm):
    assert convert(folder, library).returncode == 0
    bpy.ops.wm.open_mainfile(filepath=str(library))
    materials.use_rendering(bpy.data.materials["a"], "NODES")
    bpy.ops.wm.save_mainfile()
    write_astm(folder / "a.astm", replace(glossy, values=1.5 * glossy.values), "a")
    assert "fitted" in convert(folder, library).stdout
    assert {name: rendering for name, (_, rendering) in errors(library).items()} == {"a": "NODES", "b": "AUTO"}


def test_what_users_add_to_a_library_survives_a_rerun(blender, folder, library, glossy, write_astm):
    assert convert(folder, library).returncode == 0
    bpy.ops.wm.open_mainfile(filepath=str(library))
    mine = bpy.data.materials.new("Mine")
    mine.use_fake_user = True
    bpy.ops.mesh.primitive_monkey_add()
    bpy.context.object.data.materials.append(bpy.data.materials["b"])
    measured = bpy.data.materials["a"]
    measured.asset_data.tags.new("kitchen")
    measured.asset_data.author = "A. User"
    measured.asset_data.catalog_id = "11111111-2222-3333-4444-555555555555"
    measured.name = "Worktop"
    group = next(node for node in measured.node_tree.nodes if node.type == "GROUP")
    group.inputs["Strength"].default_value = 0.5
    bpy.ops.wm.save_as_mainfile(filepath=str(library))
    catalogues = library.parent / "blender_assets.cats.txt"
    catalogues.write_text(catalogues.read_text() + "11111111-2222-3333-4444-555555555555:Kitchen:Kitchen\n")

    write_astm(folder / "a.astm", replace(glossy, values=glossy.values * 1.1), "a")     # measured anew
    (folder / "b.astm").unlink()
    write_astm(folder / "c.astm", glossy, "c")
    done = convert(folder, library)
    assert done.returncode == 0, done.stderr

    bpy.ops.wm.open_mainfile(filepath=str(library))
    assert sorted(item.name for item in bpy.data.materials) == ["Mine", "Worktop", "b", "c"]     # b is in use there
    item = bpy.data.materials["Worktop"]
    assert {"kitchen", "measured", "a"} <= {tag.name for tag in item.asset_data.tags}
    assert (item.asset_data.author, item.asset_data.catalog_id) == ("A. User", "11111111-2222-3333-4444-555555555555")
    node = next(node for node in item.node_tree.nodes if node.type == "GROUP")
    assert node.inputs["Strength"].default_value == 0.5
    assert node.node_tree.nodes["Measured BRDF Shader"].bytecode
    assert bpy.data.objects["Suzanne"].active_material.name == "b"
    assert "Kitchen" in catalogues.read_text()
    assert catalogues.read_text().count("Measured BRDF:") == 1
    assert convert(folder, library).stdout.count("up to date") == 2


def test_a_file_that_cannot_be_read_this_time_keeps_its_material(blender, folder, library):
    assert convert(folder, library).returncode == 0
    whole = (folder / "a.astm").read_bytes()
    (folder / "a.astm").write_text("half a fil")
    done = convert(folder, library)
    assert done.returncode == 1
    assert names(library) == ["a", "b"]
    (folder / "a.astm").write_bytes(whole)
    assert convert(folder, library).stdout.count("up to date") == 2


def test_materials_whose_measurements_are_not_given_are_kept_unless_they_are_to_be_removed(blender, folder, library):
    assert convert(folder, library).returncode == 0
    (folder / "a.astm").unlink()
    done = convert(folder, library)
    assert done.returncode == 0
    assert "kept: its measurements are not among the files given" in done.stdout
    assert names(library) == ["a", "b"]
    done = convert(folder, library, "--prune")
    assert done.returncode == 0
    assert "removed: its measurements are not among the files given" in done.stdout
    assert names(library) == ["b"]


@pytest.mark.parametrize("given", quick(["nowhere", "empty"], "empty"))
def test_a_wrong_or_empty_folder_takes_nothing_out_of_a_library(folder, library, tmp_path, given):
    (tmp_path / "empty").mkdir()
    assert convert(folder, library).returncode == 0
    before = library.read_bytes()
    convert(tmp_path / given, library)
    assert library.read_bytes() == before


def test_a_users_copy_of_a_material_of_a_library_stays_what_it_is(blender, folder, library):
    assert convert(folder, library).returncode == 0
    for name in ("A copy", "z copy"):           # before and behind the original in the order of names
        bpy.ops.wm.open_mainfile(filepath=str(library))
        copy = bpy.data.materials["a"].copy()
        copy.name, copy.use_fake_user = name, True
        copy.node_tree.nodes.new("ShaderNodeBump")
        bpy.ops.wm.save_as_mainfile(filepath=str(library))
    assert convert(folder, library).stdout.count("up to date") == 2
    done = convert(folder, library, "--prune", "--diffuse-level", "3")
    assert done.returncode == 0, done.stderr
    bpy.ops.wm.open_mainfile(filepath=str(library))
    assert sorted(item.name for item in bpy.data.materials) == ["A copy", "a", "b", "z copy"]
    level = {item.name: item.measured_brdf.diffuse_level for item in bpy.data.materials}
    assert level == {"A copy": 2, "a": 3, "b": 3, "z copy": 2}
    assert "Bump" in bpy.data.materials["A copy"].node_tree.nodes


def test_what_is_saved_into_a_library_meanwhile_is_not_lost(blender, folder, library):
    assert convert(folder, library).returncode == 0
    opened = libraries.open_part(library)
    other = library.read_bytes() + b" "         # as another Blender saves it
    library.write_bytes(other)
    with pytest.raises(OSError, match="another process has saved it meanwhile"):
        libraries.save_part(library, opened)
    assert library.read_bytes() == other
    assert not list(library.parent.glob(".*"))


def test_what_a_killed_writer_left_is_removed_and_what_another_library_is_writing_is_not(folder, library):
    library.parent.mkdir()
    left = [library.parent / name for name in (".library.part.blend", ".library.part.blend@")]
    others = [library.parent / name for name in (".library2.part.blend", ".library-1of4.part.blend@")]
    for path in (*left, *others):
        path.write_bytes(b"half")
    assert convert(folder, library).returncode == 0
    assert not any(path.exists() for path in left)
    assert all(path.exists() for path in others)


def test_a_file_of_a_newer_blender_is_not_rewritten(blender, folder, library, monkeypatch):
    assert convert(folder, library).returncode == 0

    class Older:
        version, version_string = (4, 1, 0), "4.1.0"

    monkeypatch.setattr(libraries, "bpy", type("Bpy", (), {"app": Older, "data": bpy.data, "ops": bpy.ops}))
    with pytest.raises(libraries.LibraryError, match=r"was saved by Blender .*4\.1\.0"):
        libraries.open_part(library)


def test_a_write_protected_library_is_an_error_and_modes_are_kept(blender, folder, library, glossy, write_astm):
    assert convert(folder, library).returncode == 0
    library.chmod(0o640)
    write_astm(folder / "c.astm", glossy, "c")
    assert convert(folder, library).returncode == 0
    assert library.stat().st_mode & 0o777 == 0o640
    library.chmod(0o444)
    write_astm(folder / "d.astm", glossy, "d")
    done = convert(folder, library)
    assert done.returncode == 1
    assert f"{library}: write-protected" in done.stderr
    assert names(library) == ["a", "b", "c"]


@contextlib.contextmanager
def full_disk(size, begins, ends):
    """While Blender writes a file, between two of its handlers, the file gets no larger than so many bytes."""
    resource = pytest.importorskip("resource")
    before = resource.getrlimit(resource.RLIMIT_FSIZE)

    @persistent
    def on_begin(*_):
        resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))

    @persistent
    def on_end(*_):
        resource.setrlimit(resource.RLIMIT_FSIZE, before)

    begins.append(on_begin)
    ends.append(on_end)
    try:
        yield
    finally:
        on_end()
        begins.remove(on_begin)
        ends.remove(on_end)


def test_a_library_that_does_not_fit_onto_the_disk_is_an_error_and_the_former_one_stays(blender, folder, library,
                                                                                        glossy, write_astm):
    """Blender saves a file without its end without an error."""
    convert(folder, library)
    before = library.read_bytes()
    write_astm(folder / "c.astm", replace(glossy, values=2 * glossy.values), "c")
    convert(folder, library)
    size = library.stat().st_size
    library.write_bytes(before)
    with full_disk(size - 4000, bpy.app.handlers.save_pre, bpy.app.handlers.save_post):
        failed = convert(folder, library)
    assert failed.returncode == 1
    assert "the disk may be full" in failed.stderr
    assert library.read_bytes() == before
    assert convert(folder, library).returncode == 0
    assert names(library) == ["a", "b", "c"]


def test_what_blender_says_where_it_cannot_save_is_an_error_that_names_the_library(blender, extension, tmp_path):
    path = tmp_path / "not there" / "library.blend"
    with pytest.raises(OSError, match="annot open file") as raised:
        extension.addon.core.libraries.library_file.save_part(path, None)
    assert raised.value.filename == str(path)


def test_a_picture_that_does_not_fit_onto_the_disk_is_an_error(blender, folder, tmp_path):
    with full_disk(1000, bpy.app.handlers.render_pre, bpy.app.handlers.render_write):
        failed = command.run("render", folder, "-o", tmp_path / "out", "--size", "64", "--samples", "1", *CHEAP)
    assert failed.returncode == 1
    assert "the disk may be full" in failed.stderr


@pytest.mark.parametrize(("out", "message"), [("library", "expected a name that ends in .blend"),
                                              ("folder.blend", "is not a file")])
def test_other_names_are_refused(folder, tmp_path, out, message):
    (tmp_path / "folder.blend").mkdir()
    done = convert(folder, tmp_path / out, "--force")
    assert done.returncode == 1
    assert message in done.stderr
    assert (tmp_path / "folder.blend").is_dir()


def test_with_force_nothing_is_put_aside_where_nothing_is_written(library, tmp_path):
    make_scene(library)
    before = library.read_bytes()
    (tmp_path / "empty").mkdir()
    assert convert(tmp_path / "empty", library, "--force").returncode == 1
    assert library.read_bytes() == before


HOLD = """
import sys
from fitter.storage.files import hold_lock
with hold_lock(sys.argv[1]):
    print("held", flush=True)
    sys.stdin.read()
"""


@pytest.fixture
def held(library):
    """The library, while another process writes it."""
    library.parent.mkdir(exist_ok=True)
    process = subprocess.Popen([sys.executable, "-c", HOLD, library], cwd=ROOT, stdin=subprocess.PIPE,
                               stdout=subprocess.PIPE)
    assert process.stdout.readline() == b"held\n"
    yield process
    process.communicate()


def test_a_second_writer_is_told_who_is_first(folder, library, held):
    done = convert(folder, library)
    assert done.returncode == 1
    assert f"another process is writing it (process {held.pid} on " in done.stderr
    assert not library.exists()
    held.kill()                             # however it ends, its lock ends with it
    held.wait()
    assert convert(folder, library).returncode == 0
    assert not library.with_name("library.blend.lock").exists()


@pytest.fixture
def convert_to_small_files(library, monkeypatch):
    """Convert with as few as `size` materials a file."""
    def run(size, arguments):
        monkeypatch.setattr(library_file, "MATERIALS_PER_FILE", size)
        return command.run(*arguments)
    return run


def test_a_full_file_whose_material_cannot_be_fitted_again_stays_as_it_is(
        convert_to_small_files, folder, library, glossy, write_astm):
    (folder / "b.astm").rename(folder.parent / "b.astm")
    arguments = ["convert", str(folder), "-o", str(library), *CHEAP]
    assert convert_to_small_files(1, arguments).returncode == 0
    before = library.read_bytes()
    write_astm(folder / "a.astm", replace(glossy, values=glossy.values * 1.1), "a")
    (folder.parent / "b.astm").rename(folder / "b.astm")
    changed = load(folder / "a.astm")
    choices = {"diffuse_level": 2, "specular_level": 4, "compression": 80.0, "method": "mba"}
    fit = library.with_suffix(".fits") / f"{tasks.fit_key(changed.name, tasks.digest(changed), choices)}.npz"
    fit.write_bytes(b"damaged")
    done = convert_to_small_files(1, arguments)
    assert "not a fit saved by Measured BRDF" in done.stdout
    assert "1 done, 1 failed" in done.stdout, done.stdout
    assert library.read_bytes() == before
    assert names(library.with_name("library-002.blend")) == ["b"]
    assert not list(library.parent.glob("*.kept*"))


def test_files_that_stay_as_they_are_are_not_opened_and_no_process_is_left(
        convert_to_small_files, folder, library, glossy, write_astm, monkeypatch):
    arguments = ["convert", str(folder), "-o", str(library), *CHEAP]
    assert convert_to_small_files(1, arguments).returncode == 0
    write_astm(folder / "b.astm", replace(glossy, values=glossy.values * 1.1), "b, repainted")
    opened, workers = [], []
    open_part, worker = library_file.open_part, process.Worker
    monkeypatch.setattr(library_file, "open_part", lambda part: opened.append(part) or open_part(part))
    monkeypatch.setattr(process, "Worker", lambda: workers.append(worker()) or workers[-1])
    assert convert_to_small_files(1, arguments).returncode == 0
    # to be compared, and to be changed
    assert [part.name for part in opened] == ["library.blend", "library-002.blend", "library-002.blend"]
    assert len(workers) > 0
    assert not any(each.is_alive() for each in workers)
    assert names(library.with_name("library-002.blend")) == ["b, repainted"]


@release
def test_a_large_library_is_several_files_of_which_each_is_whole(
        convert_to_small_files, folder, library, glossy, write_astm):
    """With as few as two materials a file; a material stays in its file."""
    def run():
        return convert_to_small_files(2, arguments)

    arguments = ["convert", str(folder), "-o", str(library), *CHEAP]
    for name in "cde":
        write_astm(folder / f"{name}.astm", glossy, name)
    done = run()
    assert done.returncode == 0, done.stderr
    parts = [library, library.with_name("library-002.blend"), library.with_name("library-003.blend")]
    first = [names(part) for part in parts]
    assert [len(part) for part in first] == [2, 2, 1]
    assert sorted(itertools.chain(*first)) == list("abcde")
    written = [part.stat().st_mtime_ns for part in parts]
    assert run().stdout.count("up to date") == 5
    assert [part.stat().st_mtime_ns for part in parts] == written

    gone = first[1][0]
    (folder / f"{gone}.astm").unlink()
    for name in "fg":
        write_astm(folder / f"{name}.astm", glossy, name)
    foreign = library.with_name("library-004.blend")
    foreign.write_bytes(b"a user's")
    arguments.append("--prune")
    done = run()
    assert done.returncode == 0, done.stderr
    assert [len(names(part)) for part in parts] == [2, 2, 2]
    assert parts[0].stat().st_mtime_ns == written[0]
    assert sorted(itertools.chain(*map(names, parts))) == sorted(set("abcdefg") - {gone})
    write_astm(folder / "h.astm", glossy, "h")
    assert run().returncode == 0
    assert foreign.read_bytes() == b"a user's"
    assert names(library.with_name("library-005.blend")) == ["h"]


@pytest.fixture
def material(cube, folder):
    assert bpy.ops.measured_brdf.import_data(filepath=str(folder / "a.astm"), **SETTINGS) == {"FINISHED"}
    return bpy.context.object.active_material


def test_saving_an_asset_replaces_no_unrelated_file_unless_told_to(material, tmp_path):
    path = tmp_path / "assets" / "a.blend"
    path.parent.mkdir()
    path.write_bytes(b"something else")
    before = state()
    with pytest.raises(RuntimeError, match=r"a\.blend exists and is not a \.blend file"):
        bpy.ops.measured_brdf.save_asset(directory=str(path.parent))
    assert path.read_bytes() == b"something else"
    assert state() == before
    assert bpy.ops.measured_brdf.save_asset(directory=str(path.parent), force=True) == {"FINISHED"}
    assert state() == before
    assert names(path) == ["a"]
    assert path.with_name("a.blend.kept1").read_bytes() == b"something else"


def test_only_a_measured_material_can_be_saved(material):
    assert bpy.ops.measured_brdf.save_asset.poll()
    bpy.context.object.active_material = bpy.data.materials.new("Plain")
    assert not bpy.ops.measured_brdf.save_asset.poll()
    bpy.context.object.active_material = None
    assert not bpy.ops.measured_brdf.save_asset.poll()


def test_saved_again_an_asset_keeps_what_users_said_of_it_and_another_material_joins_it(material, tmp_path, folder):
    library = tmp_path / "assets"
    assert bpy.ops.measured_brdf.save_asset(directory=str(library)) == {"FINISHED"}
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "scene.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(library / "a.blend"))
    saved = bpy.data.materials["a"]
    saved.asset_data.tags.new("kitchen")
    saved.asset_data.description = "The worktop"
    bpy.data.materials.new("Mine").use_fake_user = True
    bpy.ops.wm.save_as_mainfile(filepath=str(library / "a.blend"))

    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "scene.blend"))
    material = bpy.context.object.active_material
    material.measured_brdf.diffuse_level = 2
    assert bpy.ops.measured_brdf.fit() == {"FINISHED"}
    coefficients = material.measured_brdf.coefficients
    assert bpy.ops.measured_brdf.save_asset(directory=str(library)) == {"FINISHED"}
    assert bpy.ops.measured_brdf.import_data(filepath=str(folder / "b.astm"), **SETTINGS) == {"FINISHED"}
    bpy.context.object.active_material.name = "a"
    bpy.data.materials["a"].name = "first"
    bpy.context.object.active_material.name = "a"
    assert bpy.ops.measured_brdf.save_asset(directory=str(library)) == {"FINISHED"}

    bpy.ops.wm.open_mainfile(filepath=str(library / "a.blend"))
    held = {item.name: item for item in bpy.data.materials}
    assert sorted(held) == ["Mine", "a", "a.001"]
    assert held["a"].measured_brdf.coefficients == coefficients
    assert held["a"].asset_data.description == "The worktop"
    assert "kitchen" in held["a"].asset_data.tags
    assert held["a.001"].measured_brdf.name_of_data == "b"


def test_a_conversion_in_the_window_leaves_nothing_in_the_open_file(material, folder, library):
    before = state()
    assert bpy.ops.measured_brdf.convert_folder(directory=str(folder), library=str(library), **SETTINGS) == {"FINISHED"}
    assert state() == before
    make_scene(library.with_name("scene.blend"))
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    before = state()
    with pytest.raises(RuntimeError, match=r"is not a library that Measured BRDF wrote: it holds .*1 meshes"):
        bpy.ops.measured_brdf.convert_folder(directory=str(folder), library=str(library.with_name("scene.blend")))
    assert state() == before


def test_the_open_file_is_not_replaced(material, folder, library):
    library.parent.mkdir()
    bpy.ops.wm.save_as_mainfile(filepath=str(library))
    before = library.read_bytes()
    with pytest.raises(RuntimeError, match="is the file that is open"):
        bpy.ops.measured_brdf.convert_folder(directory=str(folder), library=str(library))
    assert library.read_bytes() == before


def test_a_material_that_cannot_be_made_is_a_failed_row_and_ends_nothing(extension, monkeypatch):
    def fails(*_):
        raise ValueError("no compiler")

    batch, made, rows = extension.addon.library.batch, [], []
    monkeypatch.setattr(batch.materials, "create", fails)
    task = SimpleNamespace(path="/data/a.astm", sample="", replaced="", key="a")
    batch._make_material(None, SimpleNamespace(), made, rows, task, SimpleNamespace(error=None, result=(None, None)))
    assert made == []
    assert rows == [batch.Row("a.astm", "failed: no compiler")]


def test_an_open_file_that_was_deleted_refuses_nothing(blender, tmp_path):
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "open.blend"))
    (tmp_path / "open.blend").unlink()
    (tmp_path / "other.blend").write_bytes(b"void")
    assert "is not a .blend file" in library_file.refusal(tmp_path / "other.blend")


def test_a_library_says_which_version_wrote_it(blender, folder, library):
    assert convert(folder, library).returncode == 0
    bpy.ops.wm.open_mainfile(filepath=str(library))
    marker = json.loads(bpy.data.texts["Measured BRDF Library"].as_string())
    version = tomllib.loads((ROOT / "blender_manifest.toml").read_text())["version"]
    assert marker == {"format": "measured-brdf-library", "version": version}
    assert {item.measured_brdf.version for item in bpy.data.materials} == {version}


def test_saving_offers_the_library_of_the_preferences_those_that_blender_has_and_the_open_file(
        blender, extension, tmp_path, monkeypatch):
    module = extension.addon.library.operators
    inside = Path(bpy.utils.user_resource("EXTENSIONS")) / "user_default" / "some" / "starter_library"
    known = [SimpleNamespace(name=name, path=str(path)) for name, path in (
        ("Props", tmp_path / "props"), ("Starter", inside), ("Empty", ""))]
    context = SimpleNamespace(preferences=SimpleNamespace(filepaths=SimpleNamespace(asset_libraries=known), addons={}))
    offered = [(key, name) for key, name, _ in module._libraries(None, context)]
    assert offered == [(str(tmp_path / "props"), "Props"), ("LOCAL", "Current File")]
    monkeypatch.setattr(module.preferences, "get", lambda _context: SimpleNamespace(asset_library="/mine"))
    assert [name for _, name, _ in module._libraries(None, context)] == ["Measured BRDF", "Props", "Current File"]
    assert module._libraries(None, None) == []          # as Blender asks where it has no context


def test_a_mix_is_saved_with_its_parts_and_its_packed_mask_and_replaces_itself(cube, folder, tmp_path):
    for name in "ab":
        bpy.ops.measured_brdf.import_data(filepath=str(folder / f"{name}.astm"), **SETTINGS)
    mask = bpy.data.images.new("mask", 4, 4)
    mask.pixels.foreach_set([0.25] * 64)
    mask.pack()
    assert bpy.ops.measured_brdf.mix(first="a", second="b", mask="mask") == {"FINISHED"}
    library = tmp_path / "library"
    for _ in range(2):
        assert bpy.ops.measured_brdf.save_asset(directory=str(library)) == {"FINISHED"}
    path = library / "a_b.blend"
    assert names(path) == ["a", "a + b", "b"]
    assert sum(name.startswith("a + b") for name in names(path, "node_groups")) == 1
    bpy.ops.wm.read_homefile(use_empty=True)
    with bpy.data.libraries.load(str(path), assets_only=True) as (source, target):
        assert source.materials == ["a + b"]
        target.materials = ["a + b"]
    mix = target.materials[0]
    node = materials.mix_node(mix)
    assert [part.name for part in mixing.mixes.parts(node)[:2]] == ["a", "b"]
    image = node.inputs["Factor"].links[0].from_node.image
    assert image.packed_file is not None
    assert image.pixels[0] == pytest.approx(0.25, abs=0.01)
    assert mix.asset_data.description == "a + b: a mix of measured reflectance"


def test_a_damaged_file_and_a_link_beside_the_library_harm_nothing_else(folder, library, tmp_path):
    damaged = folder / "damaged.npz"
    saved_samples.write(fitter.load(folder / "a.astm"), damaged)
    damaged.write_bytes(with_header(damaged.read_bytes(), lambda header: header.replace(b"(), }", b"((, }")))
    done = convert(folder, library)
    assert done.returncode == 1
    assert "damaged.npz" in done.stdout
    assert names(library) == ["a", "b"]
    thesis = tmp_path / "thesis.txt"
    thesis.write_text("Ten years of work.")
    library.with_name("library.blend.lock").symlink_to(thesis)
    before = library.read_bytes()
    done = convert(folder, library)
    assert done.returncode == 1
    assert "not a lock that Measured BRDF has left" in done.stderr
    assert "Traceback" not in done.stderr
    assert thesis.read_text() == "Ten years of work."
    assert library.read_bytes() == before
