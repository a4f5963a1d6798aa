"""How measurements are read in Blender: by options that stay with the material, into the colour space of the file."""

import math
import time
from functools import partial
from types import SimpleNamespace
from unittest.mock import MagicMock

import numpy as np
import pytest
from measured_brdf.addon.core import checks
from measured_brdf.addon.core.storage.reading import scene_colours
from measured_brdf.addon.work import command

import fitter
from fitter.colours import conversion
from support.cases import release
from support.stage import add_lamp, black_scene, render

CHEAP = {"diffuse_level": 2, "specular_level": -1}
COLOR = np.array([0.6, 0.2, 0.1])
HAVE_SPACES = pytest.mark.skipif("not __import__('bpy').app.version >= (5, 0, 0)",
                                 reason="before 5.0 the OpenColorIO configuration has one space for all files")


def table(path, values, names="R,G,B"):
    """A table of a Lambertian that does not say its units: radians, and values times the cosine of theta_o."""
    angles = np.random.default_rng(0).random((400, 3)) * [1.5, 1.5, math.pi]
    rows = [",".join(f"{number:.7f}" for number in (i, o, phi, *np.multiply(values, np.cos(o) / math.pi)))
            for i, o, phi in angles]
    path.write_text("\n".join([f"theta_i,theta_o,phi,{names}", *rows]))
    return str(path)


@pytest.fixture
def file(tmp_path):
    return table(tmp_path / "paint.csv", COLOR)


@pytest.fixture
def grey(tmp_path):
    return table(tmp_path / "grey.csv", [0.5], "BRDF")


HOW = {"angles": "radians", "quantity": "brdf_cos"}


@pytest.fixture
def cube(blender):
    black_scene(8, 8, samples=16, span=1)
    blender.ops.mesh.primitive_plane_add(size=4)
    return blender.context.object


def use_space(bpy, name):
    bpy.ops.wm.set_working_color_space(working_space=name, convert_colors=True)


def findings(bpy):
    return [finding for finding in checks.check(bpy.context.scene) if finding.key.startswith("colours")]


def test_a_file_without_units_is_refused_with_the_option_that_reads_it(blender, cube, file):
    with pytest.raises(RuntimeError, match=r"paint\.csv:1: .*import, Angles"):
        blender.ops.measured_brdf.import_data(filepath=file, **CHEAP)
    assert cube.active_material is None
    assert blender.ops.measured_brdf.import_data(filepath=file, **CHEAP, **HOW) == {"FINISHED"}
    settings = cube.active_material.measured_brdf
    assert (settings.angles, settings.quantity, settings.illuminant) == ("radians", "brdf_cos", "D65")
    samples = fitter.load(file, **HOW)
    expected = fitter.fit(samples, 2, None)
    errors = fitter.error_metrics(samples.values, expected.evaluate(*samples.directions))
    assert settings.rmse == pytest.approx(errors.rmse, rel=1e-4)
    np.testing.assert_allclose(np.pi * samples.values, np.tile(COLOR, (400, 1)), rtol=1e-4)


def test_refit_and_panel_read_as_the_import_did(blender, cube, file, extension, monkeypatch):
    jobs, asked = extension.addon.work, []
    blender.ops.measured_brdf.import_data(filepath=file, illuminant="A", **CHEAP, **HOW)
    settings = cube.active_material.measured_brdf
    before = settings.digest
    assert blender.ops.measured_brdf.fit() == {"FINISHED"}
    assert (settings.digest, settings.illuminant, settings.angles) == (before, "A", "radians")
    monkeypatch.setattr(jobs.queue, "ask", lambda key, function, *more, **options: asked.append((key, function)))
    jobs.queries.data(cube.active_material)
    settings.quantity = "brdf"
    jobs.queries.data(cube.active_material)
    (key, function), (other, _) = asked
    assert key != other                     # another answer is another question
    assert function().digest == before


def test_what_is_known_of_the_material_reaches_the_reader(blender, cube, tmp_path, extension):
    """Options of anisotropic measurements, from the operator and from the command line: as `fitter.load` takes them."""
    reading = extension.addon.core.storage.reading
    choices = SimpleNamespace(angles="auto", quantity="auto", illuminant="D65", isotropic="anisotropic",
                              symmetry="half_turn", encoding="srgb", keep_unmeasured=True, columns="")
    asked = reading.load_arguments(choices)
    assert (asked["isotropic"], asked["symmetry"], asked["encoding"]) == (False, "half_turn", "srgb")
    assert asked["keep_unmeasured"]
    for isotropic in (None, True, False):
        reading.use_reading(choices, {"isotropic": isotropic})
        asked = reading.load_arguments(choices)
        assert (asked["isotropic"], asked["symmetry"], asked["encoding"]) == (isotropic, None, "raw")
    path = tmp_path / "turned.csv"
    rows = [f"30,{turn},{theta},{turn + 180},{1 + turn / 100}" for turn in range(0, 180, 20)
            for theta in range(0, 80, 5)]
    path.write_text("\n".join(["theta_i,phi_i,theta_o,phi_o,BRDF", *rows]))
    assert not fitter.load(path).isotropic
    blender.ops.measured_brdf.import_data(filepath=str(path), isotropic="isotropic", **CHEAP)
    settings = cube.active_material.measured_brdf
    assert (settings.isotropic, settings.symmetry, settings.encoding) == ("isotropic", "auto", "raw")


def test_the_dialogs_draw_the_options(extension):
    module = extension.addon.importing.import_data
    for complaint, expected in (("", {"angles", "quantity", "illuminant", "isotropic", "symmetry", "encoding",
                                      "keep_unmeasured", "columns", "sample",
                                      "diffuse_level", "specular_level", "compression", "use_tolerance", "tolerance"}),
                                ("the angles may be degrees or radians " * 5, {"angles", "quantity"})):
        layout, body = MagicMock(), MagicMock()
        layout.panel.return_value = (MagicMock(), body)
        operator = SimpleNamespace(layout=layout, use_tolerance=False, filepath="", files=[],
                                   complaint=complaint)
        module.MEASUREDBRDF_OT_import_data.draw(operator, SimpleNamespace(area=SimpleNamespace(type="FILE_BROWSER")))
        drawn = [call.args[1] for part in (layout, body, body.row.return_value) for call in part.prop.call_args_list]
        assert expected <= set(drawn)
        assert len(drawn) == len(set(drawn))
        choices = layout.split.return_value.row.return_value.prop_enum
        offered = [call.args[1:] for call in choices.call_args_list]
        assert offered == [("preset", "Standard"), ("preset", "Reference"), ("rendering", "AUTO"),
                           ("rendering", "EXACT"), ("rendering", "NODES")][:5 * ("sample" in expected)]


@HAVE_SPACES
@pytest.mark.parametrize(("space", "name"), [("Linear Rec.709", "Rec.709"), ("Linear Rec.2020", "Rec.2020"),
                                             ("ACEScg", "ACEScg")])
def test_the_space_of_the_file_is_that_of_the_picture(blender, cube, file, space, name):
    use_space(blender, space)
    assert scene_colours() == name
    blender.ops.measured_brdf.import_data(filepath=file, diffuse_level=4, specular_level=6, **HOW)
    material = cube.active_material
    assert material.measured_brdf.colours == name
    add_lamp("SUN", math.pi, angle=0)
    expected = conversion("Rec.709", name) @ COLOR
    assert render(blender.context.scene)[..., :3].mean(axis=(0, 1)) == pytest.approx(expected, rel=0.01)
    assert material.diffuse_color[:3] == pytest.approx(expected, abs=0.02)
    assert material.node_tree.nodes["Measured BRDF Export"].inputs["Base Color"].default_value[:3] == pytest.approx(
        expected, abs=0.02)


@release
@HAVE_SPACES
def test_a_material_of_another_space_is_told_and_mended(blender, cube, file, grey):
    blender.ops.measured_brdf.import_data(filepath=file, **CHEAP, **HOW)
    material = cube.active_material
    assert not findings(blender)
    use_space(blender, "ACEScg")
    (finding,) = findings(blender)
    assert "was fitted for colours in Rec.709; those of this file are in ACEScg" in finding.message
    assert blender.ops.measured_brdf.fix_setting(key=finding.key) == {"FINISHED"}
    assert material.measured_brdf.colours == "ACEScg"
    assert not findings(blender)
    material.measured_brdf.filepath = "gone.csv"
    use_space(blender, "Linear Rec.709")
    (finding,) = findings(blender)
    assert (finding.fix, "its measurements are" in finding.message) == (None, True)
    blender.data.materials.remove(material)
    blender.ops.measured_brdf.import_data(filepath=grey, **CHEAP, **HOW)
    assert cube.active_material.measured_brdf.colours == "grey"
    use_space(blender, "ACEScg")
    assert not findings(blender)


def test_a_file_of_a_space_that_nobody_knows_is_told(blender, cube, file, extension, monkeypatch):
    reading = extension.addon.core.storage.reading
    blender.ops.measured_brdf.import_data(filepath=file, **CHEAP, **HOW)
    monkeypatch.setattr(reading, "Color", lambda axis: SimpleNamespace(
        from_scene_linear_to_xyz_d65=lambda: SimpleNamespace(r=axis[0], g=axis[1], b=axis[2])))
    assert reading.scene_colours() == ""
    (finding,) = findings(blender)
    assert "none of Rec.709, Rec.2020, ACEScg" in finding.message
    assert blender.ops.measured_brdf.fit() == {"FINISHED"}
    assert cube.active_material.measured_brdf.colours == "Rec.709"


@HAVE_SPACES
def test_a_library_may_be_of_another_space_than_its_blend(blender, file, tmp_path, capfd):
    """What is linked from it into a file of that space has the right colours there, those of the stand-in too."""
    out = tmp_path / "out" / "library.blend"
    given = ["convert", file, "-o", str(out), "--preset", "Paper", "--diffuse-level", "2", "--specular-level", "none",
             "--processes", "1", "--angles", "radians", "--quantity", "brdf_cos", "--colours", "ACEScg"]
    assert command.main(given) == 0, capfd.readouterr()
    assert command.main(given) == 0
    assert "up to date" in capfd.readouterr().out
    blender.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    use_space(blender, "ACEScg")
    with blender.data.libraries.load(str(out), link=True) as (source, target):
        target.materials = source.materials
    (material,) = target.materials
    assert (material.measured_brdf.colours, material.measured_brdf.quantity) == ("ACEScg", "brdf_cos")
    assert not findings(blender)
    assert material.diffuse_color[:3] == pytest.approx(conversion("Rec.709", "ACEScg") @ COLOR, abs=0.02)


def test_a_file_without_units_is_known_by_its_error_across_processes(blender, file, extension):
    jobs = extension.addon.work
    work = partial(jobs.tasks.outcomes, [(file, "")], {"diffuse_level": 1, "specular_level": None})
    job = jobs.process.Calculation(work).start()
    until = time.monotonic() + 60
    while not job.poll() and time.monotonic() < until:
        time.sleep(0.01)
    ((_, _, error),) = job.result
    assert isinstance(error, extension.fitter.UnitsUnknownError)


def test_a_folder_is_imported_by_the_options(blender, cube, file, tmp_path):
    assert blender.ops.measured_brdf.import_folder(directory=str(tmp_path), **CHEAP, **HOW) == {"FINISHED"}
    assert cube.active_material.measured_brdf.angles == "radians"


@HAVE_SPACES
def test_a_folder_becomes_a_library_by_the_options_for_the_open_file(blender, file, tmp_path):
    use_space(blender, "ACEScg")
    out = tmp_path / "library.blend"
    assert blender.ops.measured_brdf.convert_folder(directory=str(tmp_path), library=str(out), illuminant="A",
                                                    rendering="NODES", **CHEAP, **HOW) == {"FINISHED"}
    with blender.data.libraries.load(str(out), link=True) as (source, target):
        target.materials = source.materials
    settings = target.materials[0].measured_brdf
    assert (settings.colours, settings.angles, settings.quantity, settings.illuminant, settings.rendering) == (
        "ACEScg", "radians", "brdf_cos", "A", "NODES")
