"""What an import asks in a window, before it begins and where it fails."""

from types import SimpleNamespace
from unittest.mock import MagicMock

import pytest
from measured_brdf.addon.importing.asking import AsksAboutFile
from measured_brdf.addon.work import modal

from support.operators import methods


@pytest.fixture
def asking(blender, extension, monkeypatch):
    """asking(module, class, bases, **given): an operator that is invoked in a window, and what is `asked` of that."""
    def make(module, name, bases=(), **given):
        def note(what, answer):
            return lambda *_, **options: asked.append((what, options)) or answer

        asked = []
        operators = {each: note(each, {"FINISHED"}) for each in ("import_data", "name_columns", "choose_sample")}
        fake = SimpleNamespace(ops=SimpleNamespace(measured_brdf=SimpleNamespace(**operators)), path=blender.path,
                               types=blender.types, app=SimpleNamespace(background=False))
        for each in (module, modal):
            monkeypatch.setattr(each, "bpy", fake)
        own = methods(getattr(module, name)) | {
            "report": lambda _, kind, text: asked.append((kind, text)), "poll_message_set": lambda _text: None,
            "start": note("start", {"RUNNING_MODAL"})}
        made = type("Asking", bases or (AsksAboutFile,), own)()
        choices = extension.addon.core.storage.properties.CHOICES
        values = dict.fromkeys((*choices, "directory", "others", "complaint"), "")
        values |= {"files": [], "target": 7, "slot": 0, "is_checked": False, "for_material": False,
                   "options": SimpleNamespace(is_invoke=True), "properties": MagicMock()}
        for key, value in (values | given).items():
            setattr(made, key, value)
        manager = SimpleNamespace(fileselect_add=note("browser", None), invoke_search_popup=note("popup", None),
                                  invoke_props_dialog=note("dialog", {"RUNNING_MODAL"}))
        context = SimpleNamespace(window_manager=manager, preferences=blender.context.preferences, object=None,
                                  material=None)
        return SimpleNamespace(made=made, asked=asked, fitter=extension.fitter,
                               invoke=lambda: made.invoke(context, None), execute=lambda: made.execute(context))
    return make


@pytest.fixture
def window(asking, extension, monkeypatch):
    """An import."""
    module = extension.addon.importing.import_data
    monkeypatch.setattr(module.preferences, "get", lambda _: SimpleNamespace(data_folder="/measurements",
                                                                             preset="Standard"))
    return asking(module, "MEASUREDBRDF_OT_import_data", (extension.addon.work.making.MakesMaterials,))


def test_without_a_file_it_opens_the_browser_in_the_folder_of_the_preferences(window):
    assert window.invoke() == {"RUNNING_MODAL"}
    assert window.asked == [("browser", {})]
    assert window.made.filepath == "/measurements/"


@pytest.mark.parametrize("given", ["filepath", "files"])
def test_a_file_is_read_at_once(window, tmp_path, glossy, write_astm, given):
    path = write_astm(tmp_path / "glossy.astm", glossy)
    if given == "files":
        window.made.directory, window.made.files = str(tmp_path), [SimpleNamespace(name=path.name)]
    else:
        window.made.filepath = str(path)
    assert window.invoke() == {"RUNNING_MODAL"}
    assert window.asked == [("start", {})]


def test_a_file_whose_numbers_it_does_not_know_is_asked_about(window, tmp_path):
    window.made.filepath, window.made.complaint = str(tmp_path / "a.csv"), "degrees or radians?"
    assert window.invoke() == {"RUNNING_MODAL"}
    (name, options), = window.asked
    assert name == "dialog"
    assert options["title"] == "What Are These Numbers?"


def test_of_a_file_of_several_samples_it_asks_which_unless_one_is_named(window, data):
    window.made.filepath = str(data / "curet" / "abrdf.dat")
    assert window.invoke() == {"CANCELLED"}
    (name, options), = window.asked
    assert (name, options["filepath"], options["target"]) == ("choose_sample", window.made.filepath, 7)
    window.asked.clear()
    window.made.sample = "3"
    assert window.invoke() == {"RUNNING_MODAL"}
    assert window.asked == [("start", {})]


def test_a_table_whose_columns_have_unknown_names_is_asked_about(window, tmp_path):
    path = tmp_path / "own.csv"
    path.write_text("tilt,swing,much\n" + "0.1,0.2,0.3\n" * 20)
    window.made.filepath = str(path)
    with pytest.raises(window.fitter.ColumnsUnknownError):
        window.fitter.load(path)
    assert window.invoke() == {"CANCELLED"}
    assert [name for name, _ in window.asked] == ["name_columns"]


def test_a_file_that_is_not_there_is_an_error(window, tmp_path):
    window.made.filepath = str(tmp_path / "gone.dat")
    assert window.invoke() == {"CANCELLED"}
    (kind, text), = window.asked
    assert kind == {"ERROR"}
    assert "gone.dat" in text


@pytest.mark.parametrize(("kind", "files", "expected"), [
    ("SampleUnknownError", ["a.dat"], "choose_sample"), ("ColumnsUnknownError", ["a.csv"], "name_columns"),
    ("UnitsUnknownError", ["a.csv"], "import_data"), ("ImplausibleError", ["a.csv"], "import_data"),
    ("ColumnsUnknownError", ["a.csv", "b.csv"], None), ("DatasetError", ["a.csv"], None)])
@pytest.mark.parametrize("is_invoke", [True, False])
def test_where_it_fails_it_asks_a_user_what_one_file_can_answer(window, kind, files, expected, is_invoke):
    window.made.filepath, window.made.directory = "", "/data"
    window.made.files = [SimpleNamespace(name=name) for name in files]
    window.made.options.is_invoke = is_invoke
    window.made.property_values = lambda: {"filepath": f"/data/{files[0]}", "target": 7}
    error = getattr(window.fitter, kind)("is not understood", "a")
    assert window.made._report_failure(error) == {"CANCELLED"}
    (said, more), = window.asked
    if expected is None or not is_invoke:
        assert (said, more) == ({"ERROR"}, str(error))
        return
    assert (said, more["filepath"], more["target"]) == (expected, f"/data/{files[0]}", 7)
    assert more.get("complaint") == (None if expected == "choose_sample" else str(error))
    assert more.get("is_checked") == {"UnitsUnknownError": False, "ImplausibleError": True}.get(kind)


def test_repeated_it_is_for_the_object_that_is_active_now(blender, extension):
    ran = []
    repeated = SimpleNamespace(options=SimpleNamespace(is_repeat_last=True), target=7)
    repeated.run = lambda context: ran.append(repeated.target) or {"FINISHED"}
    operator = extension.addon.importing.import_data.MEASUREDBRDF_OT_import_data
    assert operator.execute(repeated, blender.context) == {"FINISHED"}
    assert ran == [0]


def test_a_sample_is_chosen_from_the_list_of_its_file_and_imported(asking, extension, data):
    module = extension.addon.importing.asking
    window = asking(module, "MEASUREDBRDF_OT_choose_sample", filepath=str(data / "curet" / "abrdf.dat"), item="felt")
    assert window.invoke() == {"RUNNING_MODAL"}
    assert [name for name, _ in window.asked] == ["popup"]
    assert len(module._list(None, None)) == 61
    assert module._list(None, None)[0][:2] == ("felt", "felt  (1)")
    assert window.execute() == {"FINISHED"}
    (name, options), = window.asked[1:]
    assert (name, options["sample"], options["filepath"]) == ("import_data", "felt", window.made.filepath)


@pytest.mark.parametrize(("file", "said"), [("cornell/krylon_blue.astm", "only one sample"), ("none.dat", "none.dat")])
def test_where_there_is_no_sample_to_choose_it_says_so(asking, extension, data, file, said):
    window = asking(extension.addon.importing.asking, "MEASUREDBRDF_OT_choose_sample", filepath=str(data / file))
    assert window.invoke() == {"CANCELLED"}
    (_, text), = window.asked
    assert said in text


def test_a_sample_of_no_material_is_refused(asking, extension, data):
    window = asking(extension.addon.importing.asking, "MEASUREDBRDF_OT_choose_sample", for_material=True, filepath="")
    assert window.invoke() == window.execute() == {"CANCELLED"}
    assert [kind for kind, _ in window.asked] == [{"ERROR"}] * 2


class Table(list):
    """A collection of columns, as Blender has it."""

    def add(self):
        self.append(SimpleNamespace(meaning="SKIP"))
        return self[-1]


def test_columns_are_named_in_a_dialog_and_the_file_is_imported_with_them(asking, extension, tmp_path):
    path = tmp_path / "own.csv"
    path.write_text("tilt;swing;much\n" + "".join(f"{tilt};20;0.3\n" for tilt in range(20)))
    window = asking(extension.addon.importing.asking, "MEASUREDBRDF_OT_name_columns", filepath=str(path),
                    table=Table())
    assert window.invoke() == {"RUNNING_MODAL"}
    for column, meaning in zip(window.made.table, ("theta_i", "theta_o", "BRDF"), strict=True):
        column.meaning = meaning
    assert window.execute() == {"FINISHED"}
    assert [name for name, _ in window.asked] == ["dialog", "import_data"]
    assert window.asked[1][1]["columns"] == "theta_i,theta_o,BRDF"


@pytest.mark.parametrize(("given", "said"), [({"filepath": "/none.csv"}, "none.csv"),
                                             ({"filepath": "", "for_material": True}, "no active material")])
def test_columns_of_what_is_not_there_are_refused(asking, extension, given, said):
    window = asking(extension.addon.importing.asking, "MEASUREDBRDF_OT_name_columns", table=Table(), **given)
    assert window.invoke() == {"CANCELLED"}
    (kind, text), = window.asked
    assert kind == {"ERROR"}
    assert said in text
