"""The zip, as a user gets it: built and checked by Blender's own tools, installed into a clean profile, and used."""

import ast
import json
import os
import re
import sys
import tomllib
import zipfile

import pytest

from fitter.model import published
from support.cases import release
from support.checkout import ROOT, run_python
from support.stage import EXITS

TOOL = ROOT / "tools" / "blender_extension.py"


USE_IT = """
import math, sys
from pathlib import Path
import bpy

package, measurements, picture = sys.argv[1:]
bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
assert bpy.ops.extensions.package_install_files(
    filepath=package, repo="user_default", enable_on_install=True) == {"FINISHED"}
assert "bl_ext.user_default.measured_brdf" in bpy.context.preferences.addons
installed = Path(bpy.utils.user_resource("EXTENSIONS", path="user_default/measured_brdf"))
before, path = {*installed.rglob("*")}, [*sys.path]
assert installed / "LICENSE" in before
scene = bpy.context.scene
bpy.ops.measured_brdf.enable_osl()
bpy.ops.mesh.primitive_uv_sphere_add(segments=64, ring_count=32)
assert bpy.ops.measured_brdf.import_data(filepath=measurements, diffuse_level=3, specular_level=5) == {"FINISHED"}
material = bpy.context.object.active_material
print("COEFFICIENTS", material.measured_brdf.coefficients)
light = bpy.data.objects.new("Sun", bpy.data.lights.new("Sun", "SUN"))
light.data.energy = 3
camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
camera.data.type, camera.data.ortho_scale, camera.location = "ORTHO", 2, (0, 0, 5)
scene.collection.objects.link(light), scene.collection.objects.link(camera)
scene.camera = camera
scene.cycles.samples = 8
scene.cycles.use_denoising = False          # it guesses, in a picture this small
scene.render.resolution_x = scene.render.resolution_y = 16
scene.render.film_transparent = True
scene.render.image_settings.file_format = "OPEN_EXR"
scene.render.filepath = picture
bpy.ops.render.render(write_still=True)
image = bpy.data.images.load(picture)
middle = 4 * (8 * 16 + 8)
added = [each for each in {*installed.rglob("*")} - before if "__pycache__" not in each.parts]
assert not added and sys.path == path, (added, sys.path)
print("MIDDLE", image.pixels[middle], image.pixels[middle + 3])
bpy.ops.preferences.addon_disable(module="bl_ext.user_default.measured_brdf")
assert not hasattr(bpy.types.Material, "measured_brdf")
bpy.ops.preferences.addon_enable(module="bl_ext.user_default.measured_brdf")
assert hasattr(bpy.types.Material, "measured_brdf")
assert bpy.ops.extensions.package_uninstall(repo_index=next(
    i for i, repo in enumerate(bpy.context.preferences.extensions.repos) if repo.module == "user_default"),
    pkg_id="measured_brdf") == {"FINISHED"}
assert not hasattr(bpy.types.Material, "measured_brdf")
print("UNINSTALLED")
"""


@pytest.fixture(scope="module")
def package(tmp_path_factory):
    path = tmp_path_factory.mktemp("zip") / "measured_brdf.zip"
    run_python(TOOL, "build", "--source-dir", ROOT, "--output-filepath", path, check=True)
    return path


def test_blender_finds_the_package_valid(package):
    done = run_python(TOOL, "validate", package)
    assert done.returncode == 0, done.stdout + done.stderr


def test_the_package_holds_the_extension_and_nothing_else(package):
    names = zipfile.ZipFile(package).namelist()
    assert {name.split("/")[0] for name in names} - {"docs", "starter_library"} == {
        "__init__.py", "__main__.py", "LICENSE", "addon", "blender_manifest.toml", "fitter", "osl"}
    assert not [name for name in names if name.startswith("docs/") and not name.startswith("docs/html/")]
    assert {"fitter/cli.py", "fitter/cycles/bake.py", "fitter/formats/data/cie_1931_d65.csv",
            "fitter/data/low2012.csv"} <= set(names)
    assert not [name for name in names if name.endswith((".pyc", ".oso", ".zip"))]
    assert package.stat().st_size < 10e6


def test_the_manifest_is_as_the_platform_wants_it(package):
    """Blender's own validation sees to lengths and punctuation, not to what the terms of service say."""
    manifest = tomllib.loads(zipfile.ZipFile(package).read("blender_manifest.toml").decode())
    assert (manifest["id"], manifest["license"]) == ("measured_brdf", ["SPDX:GPL-3.0-or-later"])
    assert not [manifest[field] for field in ("name", "tagline") if "blender" in manifest[field].lower()]
    assert {*manifest["permissions"]} == {"files"}
    assert f"## {manifest['version']}" in (ROOT / "CHANGELOG.md").read_text("utf-8")


def test_no_module_runs_text_changes_the_path_uses_the_network_or_starts_processes_but_one(package):
    with zipfile.ZipFile(package) as file:
        for name in file.namelist():
            if name.endswith(".py"):
                found = set(_forbidden(ast.parse(file.read(name))))
                assert found == ({"subprocess"} if name == "addon/work/process.py" else set()), name


@pytest.mark.parametrize(("source", "found"), [
    ("eval('1')", "eval"), ("exec('x = 1')", "exec"), ("import sys\nsys.path.append('.')", "sys.path"),
    ("from sys import path", "sys.path"), ("import urllib.request", "urllib"), ("from os import system", "os.system"),
    ("import os\nos.popen('ls')", "os.popen"), ("from subprocess import run", "subprocess")])
def test_what_the_platform_forbids_is_noticed(source, found):
    assert found in _forbidden(ast.parse(source))


def _forbidden(tree):
    """What a module does that reviewers refuse, or look at closely."""
    modules = {"subprocess", "multiprocessing", "socket", "ssl", "urllib", "http", "ftplib", "smtplib", "requests",
               "webbrowser", "ctypes", "pip", "ensurepip"}
    attributes = {"sys.path", "os.system", "os.popen", "os.startfile", "os.fork", "os.execv", "os.spawnv",
                  "site.addsitedir"}
    for node in ast.walk(tree):
        names = []
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and not node.level:
            names = [node.module, *(f"{node.module}.{alias.name}" for alias in node.names)]
        elif isinstance(node, ast.Attribute):
            names = [ast.unparse(node)]
        elif isinstance(node, ast.Call) and ast.unparse(node.func) in {"eval", "exec", "compile", "__import__"}:
            yield ast.unparse(node.func)
        for name in names:
            if name in attributes:
                yield name
            elif name.split(".")[0] in modules and not isinstance(node, ast.Attribute):
                yield name.split(".")[0]


def test_the_library_in_the_package_holds_its_fits_and_no_compiled_shader(blender, package, tmp_path):
    with zipfile.ZipFile(package) as file:
        names = {name for name in file.namelist() if name.startswith("starter_library/")}
        if not names:
            pytest.skip("there is no starter library in this checkout; make zip builds it")
        file.extract("starter_library/starter.blend", tmp_path)
        written = json.loads(file.read("starter_library/version.json"))["blender"]
    fits = {name for name in names if name.startswith("starter_library/fits/")}
    assert fits <= {f"starter_library/fits/{each.name}.npz" for each in published.list_offered()}
    assert names - fits == {f"starter_library/{name}" for name in ("starter.blend", "version.json",
                                                                   "blender_assets.cats.txt")}
    if tuple(written) > blender.app.version[:2]:
        pytest.skip(f"Blender {written} wrote the library of this checkout; an older one makes its own of the fits")
    blender.ops.wm.open_mainfile(filepath=str(tmp_path / "starter_library" / "starter.blend"))
    scripts = [node for tree in blender.data.node_groups for node in tree.nodes if node.type == "SCRIPT"]
    assert len(scripts) == len(fits)
    assert not any(node.bytecode or node.filepath or node.script for node in scripts)
    plain = tmp_path / "plain.blend"
    blender.ops.wm.save_as_mainfile(filepath=str(plain), compress=False, copy=True)
    assert b"OpenShadingLanguage" not in plain.read_bytes()


def test_the_command_line_works_in_the_package(package, glossy, write_astm, tmp_path):
    with zipfile.ZipFile(package) as file:
        file.extractall(tmp_path / "unpacked")
    write_astm(tmp_path / "glossy.astm", glossy)

    def run(*arguments):
        done = run_python("-m", "fitter", *arguments, cwd=tmp_path / "unpacked")
        assert done.returncode == 0, done.stderr
        return done.stdout

    assert "direction pairs" in run("info", tmp_path / "glossy.astm")
    run("fit", tmp_path / "glossy.astm", "--preset", "Draft", "-o", tmp_path / "fit.npz")
    run("bake", tmp_path / "fit.npz", "-o", tmp_path / "fit.osl")
    assert "shader measured_brdf" in (tmp_path / "fit.osl").read_text()


@pytest.mark.parametrize("module", ["fitter", "fitter.cli"])
def test_the_command_line_imports_no_report_and_nothing_that_only_reports_need(module):
    loaded = set(run_python("-c", f"import sys, {module}; print(*sys.modules)").stdout.split())
    assert module in loaded
    assert not [name for name in loaded if name.split(".")[0] in {"scipy", "matplotlib"}
                or name.startswith("benchmarks")]


def test_inside_the_extension_only_what_blender_has_is_imported_and_only_relatively():
    allowed = {"blf", "bmesh", "bpy", "bpy_extras", "gpu", "gpu_extras", "mathutils", "numpy", "cycles", "_cycles",
               *sys.stdlib_module_names}
    for path in [*ROOT.glob("addon/**/*.py"), *ROOT.glob("fitter/**/*.py")]:
        for node in ast.walk(ast.parse(path.read_text("utf-8"))):
            names = []
            if isinstance(node, ast.Import):
                names = [alias.name for alias in node.names]
            elif isinstance(node, ast.ImportFrom) and not node.level:
                names = [node.module]
            for module in (name.split(".")[0] for name in names):
                lazy = module in {"scipy", "matplotlib", "OpenImageIO"} and node.col_offset > 0
                assert module in allowed or lazy, f"{path}:{node.lineno}: {module}"
                assert "addon" in path.parts or module != "bpy", f"{path}:{node.lineno}: {module}"


def complaints(done):
    """The lines of a Blender's console that report an error, or a warning of Python."""
    return [line for line in (done.stdout + done.stderr).splitlines()
            if re.search(r"Traceback|Error|Warning|Exception", line)]


def in_clean_profile(folder, *arguments):
    return run_python(*arguments, cwd=folder, env=os.environ | {"BLENDER_USER_RESOURCES": str(folder / "profile")})


def test_installed_from_the_zip_into_a_clean_profile_it_works_and_goes_again(package, tmp_path):
    measurements = tmp_path / "white.astm"
    rows = [f"{i / 10},0,{o / 10},{p / 3},0.25,0.25,0.25" for i in range(1, 15) for o in range(15) for p in range(10)]
    measurements.write_text("\n".join(["VARS theta_i,phi_i,theta_s,phi_s,R,G,B", *rows]))
    done = in_clean_profile(tmp_path, "-c", USE_IT, package, measurements, tmp_path / "picture.exr")
    assert done.returncode in EXITS, done.stdout + done.stderr
    assert not complaints(done)
    assert "UNINSTALLED" in done.stdout
    radiance, alpha = map(float, done.stdout.split("MIDDLE ")[1].split()[:2])
    assert alpha == pytest.approx(1)
    assert radiance == pytest.approx(3 * 0.25, rel=0.02)
    assert not (ROOT / "profile").exists()


@release
def test_a_day_with_the_installed_extension(package, glossy, write_astm, tmp_path):
    """Drop, cancel, undo, redo, save, reload, and a batch with one broken file of ten."""
    folder = tmp_path / "data"
    folder.mkdir()
    for number in range(9):
        write_astm(folder / f"{number}.astm", glossy, f"paint {number}")
    (folder / "9.astm").write_text("nonsense")
    done = in_clean_profile(tmp_path, ROOT / "tests" / "project" / "habits.py", package, folder)
    assert "DONE" in done.stdout, done.stdout + done.stderr
    assert done.returncode in EXITS, done.stdout + done.stderr
    assert not [line for line in complaints(done) if "nonsense" not in line and "9.astm" not in line]
