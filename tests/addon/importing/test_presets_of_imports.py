"""The preset of an import: what a dialog shows is what is made, whatever was chosen in which order."""

from pathlib import Path
from types import SimpleNamespace

import pytest
from measured_brdf.addon.core import preferences
from measured_brdf.addon.work import making, modal, tasks

import fitter
from fitter import PRESETS

LEVELS = ("diffuse_level", "specular_level", "compression")


@pytest.fixture
def file(tmp_path, glossy, write_astm):
    return str(write_astm(tmp_path / "glossy.astm", fitter.samples.subset(glossy, slice(40))))


@pytest.fixture
def asked(extension, monkeypatch):
    """The arguments of every fit that is asked for; each is made as the quickest one."""
    seen = []
    fitted = tasks.fit_once

    def quickly_fitted(samples, digest, arguments, *more):
        seen.append(dict(arguments))
        return fitted(samples, digest, {"diffuse_level": 1, "specular_level": None})

    monkeypatch.setattr(tasks, "fit_once", quickly_fitted)
    return seen


@pytest.mark.parametrize("name", PRESETS)
def test_every_preset_is_fitted_as_it_is_defined(blender, cube, file, asked, name):
    blender.ops.measured_brdf.import_data(filepath=file, preset=name)
    assert asked == [pytest.approx(PRESETS[name])]
    settings = cube.active_material.measured_brdf
    assert (settings.preset, settings.use_tolerance) == (name, False)
    assert [getattr(settings, level) for level in LEVELS] == pytest.approx([PRESETS[name][level] for level in LEVELS])


@pytest.mark.parametrize("name", PRESETS)
def test_a_level_that_is_given_beside_a_preset_changes_that_level_only(blender, cube, file, asked, name):
    blender.ops.measured_brdf.import_data(filepath=file, diffuse_level=2, preset=name)
    blender.ops.measured_brdf.import_data(filepath=file, preset=name, specular_level=-1)
    assert asked == [pytest.approx(PRESETS[name] | {"diffuse_level": 2}),
                     pytest.approx({**PRESETS[name], "specular_level": None})]


def test_a_script_that_says_nothing_gets_standard(blender, cube, file, asked):
    """Not the method of 2002, which was made for dense samples: its highlights ripple."""
    blender.ops.measured_brdf.import_data(filepath=file)
    blender.ops.measured_brdf.import_folder(directory=str(Path(file).parent))
    assert asked == [pytest.approx(PRESETS["Standard"])] * 2
    assert cube.active_material.measured_brdf.preset == "Standard"


@pytest.mark.parametrize("given", [{"diffuse_level": 2}, {"specular_level": 5}, {"compression": 80}])
def test_a_script_that_gives_levels_alone_gets_the_method_of_2002(blender, cube, file, asked, given):
    blender.ops.measured_brdf.import_data(filepath=file, **given)
    assert asked == [pytest.approx(PRESETS["Paper"] | given)]


def test_a_tolerance_beside_a_preset_is_followed(blender, cube, file, asked):
    blender.ops.measured_brdf.import_data(filepath=file, use_tolerance=True, tolerance=0.25, preset="Draft")
    assert asked == [{"tolerance": 0.25}]


def test_a_preset_that_is_chosen_in_a_dialog_shows_its_levels_and_ends_auto(blender, extension):
    """What the buttons of a dialog do: they assign to the properties of its operator, one after the other."""
    dialog = blender.context.window_manager.operator_properties_last("measured_brdf.import_data")
    for name, preset in PRESETS.items():
        dialog.use_tolerance, dialog.diffuse_level = True, 7
        dialog.preset = name
        assert not dialog.use_tolerance
        assert [getattr(dialog, level) for level in LEVELS] == pytest.approx([preset[level] for level in LEVELS])
        dialog.compression = 12
        assert (dialog.preset, dialog.diffuse_level, dialog.compression) == (name, preset["diffuse_level"], 12)


def test_a_dialog_begins_with_the_preference_and_not_with_the_last_use(blender, extension, monkeypatch):
    monkeypatch.setattr(preferences, "get", lambda context: SimpleNamespace(preset="Draft"))
    last = blender.context.window_manager.operator_properties_last("measured_brdf.import_data")
    last.preset, last.use_tolerance, last.sample, last.angles = "Reference", True, "felt", "radians"

    class Ghost:
        """As Blender shows the values of the last use to the next one: they are there, and not set."""

        def is_property_set(self, name):
            return name in ("filepath",)

        def property_unset(self, name):
            last.property_unset(name)

    class Operator:
        properties = Ghost()

        def __getattr__(self, name):
            return getattr(last, name)

        def __setattr__(self, name, value):
            setattr(last, name, value)

    making.begin_with_preference(Operator(), blender.context)
    assert (last.preset, last.use_tolerance, last.sample, last.angles) == ("Draft", False, "", "auto")
    assert [getattr(last, level) for level in LEVELS] == pytest.approx([PRESETS["Draft"][level] for level in LEVELS])


def test_a_fit_that_asks_for_its_lost_file_goes_on_with_its_preset(blender, extension, cube, file, asked, monkeypatch):
    module, given = extension.addon.importing.fit, []
    blender.ops.measured_brdf.import_data(filepath=file, preset="Paper")
    cube.active_material.measured_brdf.filepath = "/lost.astm"
    asks = SimpleNamespace(find_file=lambda how, **options: given.append(options))
    fake = SimpleNamespace(path=blender.path, app=SimpleNamespace(background=False),
                           ops=SimpleNamespace(measured_brdf=asks))
    with monkeypatch.context() as patched:
        for each in (module, modal):
            patched.setattr(each, "bpy", fake)
        operator = SimpleNamespace(filepath="", preset="Draft")
        assert module.MEASUREDBRDF_OT_fit.invoke(operator, blender.context, None) == {"CANCELLED"}
    blender.ops.measured_brdf.find_file(filepath=file, **given[0])
    assert asked == [pytest.approx(PRESETS["Paper"]), pytest.approx(PRESETS["Draft"])]


def test_the_preset_of_a_material_leaves_its_levels_alone(blender, extension):
    """A script may give a material its preset and its levels in any order."""
    settings = blender.data.materials.new("mine").measured_brdf
    settings.diffuse_level = 2
    settings.preset = "Reference"
    assert settings.diffuse_level == 2


def test_presets_and_samples_are_not_offered_for_materials_of_other_files(blender, cube, file, asked, from_library):
    blender.ops.measured_brdf.import_data(filepath=file)
    cube.active_material.name = "theirs"
    from_library("theirs")
    for name in ("use_preset", "fit", "find_file"):
        assert not getattr(blender.ops.measured_brdf, name).poll(), name
    with pytest.raises(RuntimeError, match="another file"):
        blender.ops.measured_brdf.choose_sample("INVOKE_DEFAULT", for_material=True)
