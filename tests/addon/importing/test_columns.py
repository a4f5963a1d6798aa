"""Tables whose columns mean nothing, and numbers that no surface has: what users are asked, and what becomes of it."""

from types import SimpleNamespace
from unittest.mock import MagicMock

import numpy as np
import pytest
from measured_brdf.addon.importing import asking

import fitter

CHEAP = {"diffuse_level": 1, "specular_level": -1}
MEANT = "theta_i[deg],theta_o[deg],phi[deg],BRDF"


def rows(value=0.25):
    return "".join(f"{i};{o};180;{value}\n" for i in (0, 30, 60) for o in range(0, 81, 20))


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "scan.csv"
    path.write_text(f"incoming tilt;Angle of scatter;Azimuth;x\n{rows()}")
    return str(path)


def test_a_script_names_the_columns_and_the_material_keeps_them(blender, cube, file):
    with pytest.raises(RuntimeError, match=r"scan\.csv:1: columns incoming tilt, .* the option columns says"):
        blender.ops.measured_brdf.import_data(filepath=file, **CHEAP)
    assert cube.active_material is None
    assert blender.ops.measured_brdf.import_data(filepath=file, columns=MEANT, **CHEAP) == {"FINISHED"}
    settings = cube.active_material.measured_brdf
    assert settings.columns == MEANT
    before = settings.digest
    assert blender.ops.measured_brdf.fit() == {"FINISHED"}          # reads the file in the same way
    assert settings.digest == before


def test_a_folder_of_such_tables_is_imported(blender, cube, file, tmp_path):
    (tmp_path / "other.txt").write_text(rows(0.1))
    assert blender.ops.measured_brdf.import_folder(directory=str(tmp_path), columns=MEANT, **CHEAP) == {"FINISHED"}
    assert {item.name for item in blender.data.materials} == {"scan", "other"}


def operator(file, **given):
    items = []
    table = SimpleNamespace(add=lambda: items.append(SimpleNamespace(meaning="SKIP")) or items[-1], clear=items.clear)
    return SimpleNamespace(table=table, filepath=file, **given), items


def test_the_dialog_shows_the_first_rows_and_what_names_say(extension, file):
    asked, items = operator(file)
    asking.fill(asked, file)
    assert [item.label for item in items] == ["incoming tilt", "Angle of scatter", "Azimuth", "x"]
    assert [item.meaning for item in items] == ["SKIP", "theta_o", "phi", "SKIP"]
    assert items[1].numbers == "0, 20, 40, 60"
    items[0].meaning, items[3].meaning = "theta_i", "BRDF"
    assert asking.stated_columns(items) == "theta_i,theta_o,phi,BRDF"
    samples = fitter.load(file, columns=asking.stated_columns(items), angles="degrees")
    assert np.unique(samples.theta_i) == pytest.approx(np.radians([0, 30, 60]))


def test_columns_without_names_and_names_with_commas(extension, tmp_path):
    path = tmp_path / "bare.txt"
    path.write_text(rows())
    asked, items = operator(str(path))
    asking.fill(asked, str(path))
    assert [item.label for item in items] == ["Column 1", "Column 2", "Column 3", "Column 4"]
    named = SimpleNamespace(label='550 nm, "left"', meaning="NAMED")
    assert asking.stated_columns([named, SimpleNamespace(label="a", meaning="SKIP")]) == "\"550 nm, 'left'\",-"


def test_the_dialog_is_drawn_with_a_choice_for_each_column(extension, file):
    asked, items = operator(file, layout=MagicMock(), complaint="columns incoming tilt mean nothing here")
    asking.fill(asked, file)
    asked.table = items
    column = asked.layout.column.return_value
    asking.MEASUREDBRDF_OT_name_columns.draw(asked, None)
    drawn = [call.args for call in column.split.return_value.split.return_value.prop.call_args_list]
    assert [name for _, name in drawn] == ["meaning"] * 4
    assert [call.args[1] for call in asked.layout.prop.call_args_list] == ["angles", "quantity"]


def test_numbers_that_no_surface_has_are_imported_by_scripts_with_a_warning(extension, tmp_path):
    tasks = extension.addon.work.tasks
    path = tmp_path / "white.csv"
    path.write_text(f"theta_i[deg];theta_o[deg];phi[deg];BRDF\n{rows(97)}")
    arguments = {"diffuse_level": 1, "specular_level": None}
    (_, _, made), = tasks.outcomes([(str(path), "")], arguments)
    (question,) = made.questions
    assert question.startswith("white reflects 305 times the light that arrives: reflectance factors in percent?")
    (_, _, refused), = tasks.outcomes([(str(path), "")], arguments, ask=True)
    assert isinstance(refused, extension.fitter.ImplausibleError)
    assert "Choose what the numbers are, or import them as they are" in str(refused)
    (_, _, mended), = tasks.outcomes([(str(path), "")], arguments, how={"quantity": "reflectance_percent"}, ask=True)
    assert mended.questions == ()
