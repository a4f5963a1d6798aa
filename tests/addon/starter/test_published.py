"""Published fits in Blender: imported, refitted and searched like files."""

import bpy
import pytest

from support.blend_state import state


@pytest.fixture
def cube(blender, quick):
    bpy.ops.mesh.primitive_cube_add()
    return bpy.context.object


def test_a_virtual_path_is_imported_like_a_file(cube):
    assert bpy.ops.measured_brdf.import_data(filepath="published:red-fabric", preset="Draft") == {"FINISHED"}
    item = cube.active_material
    assert item.name == "Red fabric (published fit)"
    settings = item.measured_brdf
    assert (settings.filepath, settings.sample, settings.preset) == ("published:red-fabric", "", "Draft")
    assert settings.coefficients > 0
    assert bpy.ops.measured_brdf.fit() == {"FINISHED"}


def test_an_unknown_name_is_refused_and_nothing_changes(cube):
    before = state()
    with pytest.raises(RuntimeError, match="did you mean chrome"):
        bpy.ops.measured_brdf.import_data(filepath="published:chrom")
    with pytest.raises(RuntimeError, match="did you mean chrome"):
        bpy.ops.measured_brdf.use_published(name="chrom")
    assert state() == before


@pytest.mark.parametrize("use", ["use_published", "search_published"])
def test_a_published_fit_is_used_with_the_preset_of_the_preferences(cube, use):
    assert getattr(bpy.ops.measured_brdf, use)(name="pink-felt") == {"FINISHED"}
    settings = cube.active_material.measured_brdf
    assert settings.name_of_data == "Pink felt (published fit)"
    assert (settings.preset, settings.diffuse_level, settings.specular_level) == ("Standard", 4, 5)
    assert settings.coefficients > 0


def test_a_virtual_path_stays_as_it_is_in_a_saved_file(cube, tmp_path):
    from measured_brdf.addon.core.reading import has_file

    item = bpy.data.materials.new("Mine")
    item.use_fake_user = True
    item.measured_brdf.filepath = "published:chrome"
    assert bpy.path.abspath(item.measured_brdf.filepath) == "published:chrome"
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "a.blend"), relative_remap=True)
    bpy.ops.file.make_paths_relative()
    (tmp_path / "b").mkdir()
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "b" / "b.blend"), relative_remap=True)
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "b" / "b.blend"))
    item = bpy.data.materials["Mine"]
    assert item.measured_brdf.filepath == "published:chrome"
    assert has_file(item)
    item.measured_brdf.filepath = "published:nothing"
    assert not has_file(item)


def test_an_asset_of_a_published_fit_says_what_it_is(cube):
    from measured_brdf.addon.core import assets

    assert bpy.ops.measured_brdf.import_data(filepath="published:red-fabric", preset="Draft") == {"FINISHED"}
    item = cube.active_material
    assets.mark(item)
    assert "not a measurement" in item.asset_data.description
    assert "measured reflectance" not in item.asset_data.description
    assert "published fit" in [tag.name for tag in item.asset_data.tags]
    assert "measured" not in [tag.name for tag in item.asset_data.tags]


def test_search_finds_by_words_in_name_label_and_tags(extension):
    from measured_brdf.addon.starter import shelf

    def found(search, tag=shelf.ALL):
        return [each.name for each in shelf.offered(search, tag)]

    assert len(found("")) == 100
    assert found("STEEL chrome") == ["chrome-steel"]
    assert "color-changing-paint1" in found("colour")
    assert set(found("gold", "metal")) == set()
    assert {"brass", "chrome"} <= set(found("", "metal"))
    assert found("", "foam") == ["polyurethane-foam"]
    assert found("unobtainium") == []


def test_the_panel_asks_for_the_folder_and_its_pictures_in_the_background(extension, tmp_path, glossy, write_astm,
                                                                       monkeypatch):
    from measured_brdf.addon.starter import shelf
    from measured_brdf.addon.work import queue

    queue.unregister()                  # what panels have asked for before
    shelf._icon_ids.clear()
    monkeypatch.setattr(shelf, "user_folder", lambda name: tmp_path / "user" / name)
    folder = tmp_path / "data"
    folder.mkdir()
    write_astm(folder / "a.astm", glossy, "a")
    job = shelf.watched(str(folder))
    assert job.finished is None
    queue.answer_all()
    found, = shelf.watched(str(folder)).result
    assert found.label == "a.astm"
    kept = []
    monkeypatch.setattr(shelf, "_keep", lambda key, picture: kept.append(picture.shape))
    assert shelf.measurement_icon(found, {"colours": "Rec.709"}) == (0, None)
    assert shelf.swatch_icon("chrome") == 0
    queue.answer_all()
    assert kept == [(128, 128, 4)] * 2
    assert len(list((tmp_path / "user" / "thumbnails").iterdir())) == 2


def test_a_folder_is_looked_at_for_as_long_as_it_is_drawn(extension, tmp_path, monkeypatch):
    from measured_brdf.addon.starter import shelf

    redrawn = []
    monkeypatch.setattr(shelf.queue, "redraw", lambda: redrawn.append(True))
    shelf.watched(str(tmp_path))
    assert bpy.app.timers.is_registered(shelf._tick)
    assert shelf._tick() == shelf._TICK
    assert redrawn == [True]
    assert shelf._tick() is None            # it was not drawn since
    shelf.watched(str(tmp_path))
    assert shelf._tick() == shelf._TICK
    bpy.app.timers.unregister(shelf._tick)


def test_the_user_folder_of_a_checkout_is_in_blenders_own(extension):
    from measured_brdf.addon.starter import shelf

    assert str(bpy.utils.user_resource("DATAFILES")) in str(shelf.user_folder("thumbnails"))
