"""What an import asks in a window, before it begins and where it fails."""

from types import SimpleNamespace
from unittest.mock import MagicMock

import pytest


@pytest.fixture
def window(blender, extension, monkeypatch):
    """What a window would be asked for, in `asked`, and an operator that is invoked in it: `made`."""
    module, asked = extension.addon.importing.import_data, []

    def note(name, answer):
        return lambda *given, **options: asked.append((name, options)) or answer

    manager = SimpleNamespace(fileselect_add=note("browser", None),
                              invoke_props_dialog=note("dialog", {"RUNNING_MODAL"}))
    operators = SimpleNamespace(**{name: note(name, {"FINISHED"}) for name in (
        "import_data", "name_columns", "choose_sample")})
    monkeypatch.setattr(module, "bpy", SimpleNamespace(ops=SimpleNamespace(measured_brdf=operators), path=blender.path,
                                                       app=SimpleNamespace(background=False), types=blender.types))
    monkeypatch.setattr(module.preferences, "get", lambda _: SimpleNamespace(data_folder="/measurements",
                                                                             preset="Standard"))
    own = {name: value for name, value in vars(module.MEASUREDBRDF_OT_import_data).items()
           if callable(value) and not name.startswith("bl_")}
    own |= {"start": note("start", {"RUNNING_MODAL"}), "report": lambda _, kind, text: asked.append((kind, text))}
    made = type("Invoked", (extension.addon.work.making.MakesMaterials,), own)()
    choices = dict.fromkeys(extension.addon.core.properties.CHOICES, "")
    for name, value in (choices | {"files": [], "directory": "", "target": 7, "slot": 0, "others": "", "complaint": "",
                                   "is_checked": False, "options": SimpleNamespace(is_invoke=True),
                                   "properties": MagicMock()}).items():
        setattr(made, name, value)
    context = SimpleNamespace(window_manager=manager, object=blender.context.object)
    return SimpleNamespace(asked=asked, made=made, invoke=lambda: made.invoke(context, None), fitter=extension.fitter)


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
    ("ColumnsUnknownError", ["a.csv", "b.csv"], None), ("DatasetError", ["a.csv"], None)])
def test_where_it_fails_it_asks_only_what_one_file_can_answer(window, kind, files, expected):
    window.made.filepath, window.made.directory = "", "/data"
    window.made.files = [SimpleNamespace(name=name) for name in files]
    error = getattr(window.fitter, kind)("is not understood", "a")
    assert window.made._failed(error) == {"CANCELLED"}
    (said, more), = window.asked
    if expected is None:
        assert (said, more) == ({"ERROR"}, str(error))
    else:
        assert said == expected
        assert more["filepath"] == f"/data/{files[0]}"


def test_repeated_it_is_for_the_object_that_is_active_now(blender, extension):
    ran = []
    repeated = SimpleNamespace(options=SimpleNamespace(is_repeat_last=True), target=7)
    repeated.run = lambda context: ran.append(repeated.target) or {"FINISHED"}
    operator = extension.addon.importing.import_data.MEASUREDBRDF_OT_import_data
    assert operator.execute(repeated, blender.context) == {"FINISHED"}
    assert ran == [0]
