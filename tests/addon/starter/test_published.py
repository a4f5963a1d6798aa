"""Published fits in Blender: imported, refitted and searched like files."""

import time
from types import SimpleNamespace

import bpy
import numpy as np
import pytest
from measured_brdf.addon.core.libraries import assets
from measured_brdf.addon.core.shading import material, node_group
from measured_brdf.addon.core.storage.properties import name_of_fit
from measured_brdf.addon.core.storage.reading import has_file
from measured_brdf.addon.panel import main
from measured_brdf.addon.starter import operators, panel, shelf, work
from measured_brdf.addon.work import icons, queue
from measured_brdf.fitter import Fit, fit, load
from measured_brdf.fitter.formats import EXTENSIONS
from measured_brdf.fitter.imaging import pictures
from measured_brdf.fitter.library import ready
from measured_brdf.fitter.methods import presets
from measured_brdf.fitter.model import published

from support.blend_state import state
from support.checkout import ROOT
from support.drawn import Layout, draw
from tests.addon.answers import answer_all

pytestmark = pytest.mark.usefixtures("quick")


def test_a_virtual_path_is_imported_like_a_file(cube):
    assert bpy.ops.measured_brdf.import_data(filepath="published:red-fabric", preset="Draft") == {"FINISHED"}
    item = cube.active_material
    assert item.name == "Red fabric"
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


def test_a_material_of_the_library_is_that_of_an_import_with_its_levels(cube, tmp_path, monkeypatch):
    directions = np.random.default_rng(0).random((4, 200)) * np.array([[1.5], [3], [1.5], [3]])
    monkeypatch.setattr(ready, "FOLDER", tmp_path)      # the fits that were built last may be of other code
    ready.write(ready.make("pink-felt"), tmp_path / "pink-felt.npz")
    assert bpy.ops.measured_brdf.use_published(name="pink-felt") == {"FINISHED"}
    item = cube.active_material
    levels = {name: ready.ARGUMENTS[name] for name in ("diffuse_level", "specular_level", "compression")}
    bpy.ops.measured_brdf.import_data(filepath="published:pink-felt", preset="Standard", **levels)
    other = cube.active_material
    trees = [material.group_node(each).node_tree for each in (item, other)]
    assert item.name == item.measured_brdf.name_of_data == "Pink felt"
    assert name_of_fit(item.measured_brdf) == "Material Library"
    for name in ("filepath", "preset", *levels, "digest", "coefficients", "rmse", "fitted_as", "sphere", "rendering"):
        assert getattr(item.measured_brdf, name) == getattr(other.measured_brdf, name), name
    first, second = (Fit.from_bytes(node_group.kept_fit(tree)).evaluate(*directions) for tree in trees)
    assert first == pytest.approx(second, rel=1e-6)
    for first, second in zip(*(tree.nodes for tree in trees), strict=True):
        assert first.type == second.type
        if first.type == "VALTORGB":
            for one, two in zip(first.color_ramp.elements, second.color_ramp.elements, strict=True):
                assert one.position == pytest.approx(two.position, rel=1e-6)
                assert tuple(one.color) == pytest.approx(tuple(two.color), rel=1e-5, abs=1e-7)
    exported = [each.node_tree.nodes["Measured BRDF Export"].inputs for each in (item, other)]
    for name in ("Base Color", "Roughness", "Coat Weight"):
        assert np.allclose(*(inputs[name].default_value for inputs in exported), atol=1e-6)


def test_a_virtual_path_stays_as_it_is_in_a_saved_file(cube, tmp_path):
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
    assert bpy.ops.measured_brdf.import_data(filepath="published:red-fabric", preset="Draft") == {"FINISHED"}
    item = cube.active_material
    assets.mark(item)
    assert "not a measurement" in item.asset_data.description
    assert "measured reflectance" not in item.asset_data.description
    assert "published fit" in [tag.name for tag in item.asset_data.tags]
    assert "measured" not in [tag.name for tag in item.asset_data.tags]


def test_the_library_begins_with_metals_and_what_is_bright_and_the_pop_up_has_as_much_as_it_has_room_for(extension):
    offered = shelf.find_offered("", shelf.ALL)
    assert [each.name for each in offered[:2]] == ["gold-polished", "silver-polished"]
    assert [each.is_computed for each in offered] == [True] * 75 + [False] * (len(offered) - 75)
    brightest = [max(each.model.kd) for each in offered[75:]]
    assert brightest == sorted(brightest, reverse=True)
    choices = bpy.context.window_manager.measured_brdf_shelf
    choices.tag = shelf.ALL
    drawn = {height: draw(panel.MEASUREDBRDF_PT_library, window=height and SimpleNamespace(height=height))
             for height in (None, 2000, 1080, 100)}
    choices.property_unset("tag")
    pictures = [len(each) for each in shelf.group_finishes(offered)]
    assert [each.kinds.count("picture") for each in drawn.values()] == [sum(pictures[:n]) for n in (28, 28, 21, 7)]
    assert f"{len(pictures) - 21} more materials" in drawn[1080].texts


def test_a_metal_is_one_picture_with_its_finishes_beside_it_and_all_metals_have_room(extension):
    gold = shelf.group_finishes(shelf.find_offered("", "metal"))[0]
    assert [each.name for each in gold] == ["gold-polished", "gold-satin", "gold-rough", "gold-brushed"]
    shown = draw(panel.MEASUREDBRDF_PT_library, window=SimpleNamespace(height=1080))
    used = [vars(entry[4]).get("name") for entry in shown.drawn if entry[0] == "button"]
    assert {each.name for each in shelf.find_offered("", "metal")} <= set(used)
    assert "more materials" not in shown.texts
    assert shown.button("Gold").options == {"name": "gold-polished"}
    choices = bpy.context.window_manager.measured_brdf_shelf
    choices.search = "satin gold"
    shown = draw(panel.MEASUREDBRDF_PT_library, window=SimpleNamespace(height=1080))
    choices.search = ""
    assert shown.button("Satin gold").options == {"name": "gold-satin"}


def test_a_second_click_uses_the_material_that_is_there_unless_it_has_been_changed(cube):
    assert bpy.ops.measured_brdf.use_published(name="red-plastic") == {"FINISHED"}
    first = cube.active_material
    bpy.ops.mesh.primitive_cube_add()
    other = bpy.context.object
    assert bpy.ops.measured_brdf.use_published(name="red-plastic") == {"FINISHED"}
    assert other.active_material == first
    node, = (each for each in first.node_tree.nodes if each.type == "GROUP")
    node.inputs["Tint"].default_value = (0.5, 1, 1, 1)
    assert bpy.ops.measured_brdf.use_published(name="red-plastic") == {"FINISHED"}
    assert other.active_material != first
    bpy.data.materials.remove(other.active_material)
    node.inputs["Tint"].default_value = (1, 1, 1, 1)
    first.measured_brdf_adjustments.coat = 0.5
    assert bpy.ops.measured_brdf.use_published(name="red-plastic") == {"FINISHED"}
    assert other.active_material != first
    assert bpy.ops.measured_brdf.use_published(name="chromium-satin") == {"FINISHED"}
    assert other.active_material.name == "Satin chromium"


@pytest.mark.parametrize("how", ["outdated", "without its node"])
def test_a_second_click_does_not_use_a_material_that_is_outdated_or_has_lost_its_node(cube, monkeypatch, how):
    assert bpy.ops.measured_brdf.use_published(name="red-plastic") == {"FINISHED"}
    first = cube.active_material
    if how == "outdated":
        monkeypatch.setattr(material, "SHADER_VERSION", material.SHADER_VERSION + 1)
    else:
        first.node_tree.nodes.remove(material.group_node(first))
    assert bpy.ops.measured_brdf.use_published(name="red-plastic") == {"FINISHED"}
    assert cube.active_material != first


def test_search_finds_by_words_in_name_label_and_tags(extension):
    def found(search, tag=shelf.ALL):
        return [each.name for each in shelf.find_offered(search, tag)]

    assert len(found("")) == len(published.list_offered())
    assert found("PLASTIC matte yellow") == ["yellow-matte-plastic"]
    assert "color-changing-paint1" in found("colour")
    assert "gold-paint" in found("gold", "metallic")
    assert found("chrome") == ["chromium-polished", "chromium-satin", "chromium-rough", "chromium-brushed"]
    assert "stainless-steel-brushed" in found("steel")
    assert found("gold brushed") == ["gold-brushed"]
    assert {each.tags for each in shelf.find_offered("", "metal")} == {("metal",)}
    assert found("", "foam") == ["polyurethane-foam"]
    assert found("unobtainium") == []


def test_the_panel_asks_for_the_folder_and_its_pictures_in_the_background(extension, tmp_path, glossy, write_astm,
                                                                          monkeypatch):
    queue.unregister()                  # what panels have asked for before
    shelf.unregister()
    shelf.register()
    monkeypatch.setattr(shelf, "user_folder", lambda name: tmp_path / "user" / name)
    folder = tmp_path / "data"
    folder.mkdir()
    write_astm(folder / "a.astm", glossy, "a")
    job = shelf.watch_folder(str(folder))
    assert job.finished is None
    answer_all()
    measurement, = shelf.watch_folder(str(folder)).result
    assert measurement.label == "a.astm"
    assert shelf.measurement_icon(measurement, {"colours": "Rec.709"}) == (0, None)
    answer_all()
    assert [key[:2] for key in shelf._icons._ids] == [("watched", str(folder / "a.astm"))]
    assert len(list((tmp_path / "user" / "thumbnails").iterdir())) == 1


def test_pictures_of_the_library_are_asked_for_when_it_is_opened_and_appear_in_the_open_pop_up(extension, monkeypatch):
    bpy.ops.mesh.primitive_cube_add()
    queue.unregister()
    shelf.unregister()
    shelf.register()

    def picture(name):
        return np.array(shelf._icons._previews[repr(("published", name))].image_pixels_float[:])

    def asked():
        return [question.key for lane in queue._lanes.values() for question in lane.pending()]

    draw(main.MEASUREDBRDF_PT_material)
    assert asked() == []
    choices = bpy.context.window_manager.measured_brdf_shelf
    choices.search = "gold"
    opened = draw(panel.MEASUREDBRDF_PT_library, window=None)
    choices.property_unset("search")
    shown = shelf.find_offered("gold", shelf.ALL)
    assert len(shown) > 1
    assert opened.kinds.count("picture") == len(shown)
    assert shelf.coming() == {each.name for each in shown}
    wanted, disc = asked(), picture("gold-polished")
    queue.unregister()                      # nobody has asked again: the pop-up is laid out once
    draw(main.MEASUREDBRDF_PT_material)
    assert sorted(asked()) == sorted(wanted)
    told, publish = [], bpy.msgbus.publish_rna
    monkeypatch.setattr(bpy.msgbus, "publish_rna", lambda key: (told.append(key.id_data), publish(key=key)))
    answer_all()
    assert not shelf.coming()
    assert np.abs(picture("gold-polished") - disc).max() > 0.5          # the same icon shows another picture
    assert told == [bpy.context.window_manager] * len(wanted)
    draw(main.MEASUREDBRDF_PT_material)
    assert asked() == []


def test_the_list_of_samples_has_an_icon_of_each_that_is_drawn_while_it_is_open(extension, data, tmp_path, monkeypatch):
    queue.unregister()
    shelf.unregister()
    shelf.register()
    monkeypatch.setattr(shelf, "user_folder", lambda name: tmp_path / name)
    path, (icon_of,) = str(data / "curet" / "abrdf.dat"), icons.sample_icons
    for _ in range(2):
        icon_of(path, "velvet")
    key, = shelf._undrawn
    preview = shelf._icons._previews[repr(key)]
    assert tuple(preview.icon_size) == (32, 32)
    lane = queue._lanes["slow"]
    assert [question.key for question in lane.pending()] == [key]
    lane.drop_unwanted(time.monotonic() + 50)           # the list does not ask again
    answer_all()
    small = np.array(preview.icon_pixels_float[:]).reshape(32, 32, 4)
    expected = pictures.lit_sphere(fit(load(path, "velvet"), **presets.PRESETS["Draft"]), 128)[2::4, 2::4]
    assert np.abs(small - expected).max() < 0.01
    assert not shelf._undrawn
    icon_of(path, "velvet")
    assert not lane.pending()
    assert icon_of(str(tmp_path / "gone.dat"), "velvet") == 0


def test_a_folder_is_looked_at_for_as_long_as_it_is_drawn(extension, tmp_path, monkeypatch):
    redrawn = []
    monkeypatch.setattr(shelf.queue, "redraw", lambda: redrawn.append(True))
    shelf.watch_folder(str(tmp_path))
    assert bpy.app.timers.is_registered(shelf._tick)
    assert shelf._tick() == shelf._TICK
    assert redrawn == [True]
    assert shelf._tick() is None            # it was not drawn since
    shelf.watch_folder(str(tmp_path))
    assert shelf._tick() == shelf._TICK
    bpy.app.timers.unregister(shelf._tick)


def test_the_user_folder_of_a_checkout_is_in_blenders_own(extension):
    assert str(bpy.utils.user_resource("DATAFILES")) in str(shelf.user_folder("thumbnails"))


def test_a_click_in_a_file_of_other_colours_is_fitted_for_them(cube, monkeypatch):
    assert work.is_quick("red-plastic", "ACEScg") is False
    assert work.is_quick("nothing", "Rec.709") is False
    monkeypatch.setattr(operators, "load_arguments", lambda _choices: {"colours": "ACEScg"})
    assert bpy.ops.measured_brdf.use_published(name="red-plastic") == {"FINISHED"}
    assert cube.active_material.measured_brdf.colours == "ACEScg"
    assert cube.active_material.measured_brdf.fitted_levels == "(3,4,92.5)"


def test_a_picture_and_its_name_are_buttons_of_the_same_material(cube, monkeypatch):
    monkeypatch.setattr(shelf, "published_icon", lambda _name: 7)
    layout = Layout()
    choices = SimpleNamespace(search="teflon", tag="plastic")
    panel._draw_published(layout, SimpleNamespace(window_manager=SimpleNamespace(measured_brdf_shelf=choices),
                                                  preferences=bpy.context.preferences, region=None), 2)
    pressed = [entry[4].name for entry in layout.drawn if entry[0] == "button" and hasattr(entry[4], "name")]
    assert pressed == ["teflon"] * 3           # the star is of it too
    assert ("picture", 7) in [(entry[0], entry[2]) for entry in layout.drawn]


def test_the_files_that_the_manual_says_where_to_get_are_read(extension):
    text = (ROOT / "docs" / "manual.md").read_text("utf-8")
    table = text[text.index("## Where to get data"):text.index("## What the panel says")]
    rows = [line.split("|") for line in table.splitlines() if line.startswith("| [")]
    assert len(rows) == 5
    for row in rows:
        assert all(name.strip(" `").endswith(EXTENSIONS) for name in row[4].split(",")), row
