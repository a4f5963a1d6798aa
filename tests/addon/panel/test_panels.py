"""What the panels show, drawn without a window."""

import re
from types import SimpleNamespace

import blf
import bpy
import numpy as np
import pytest
from measured_brdf.addon.adjust import panel as adjust
from measured_brdf.addon.core import preferences
from measured_brdf.addon.core.annotations import as_text
from measured_brdf.addon.core.storage import properties
from measured_brdf.addon.core.storage.properties import CHOICES, quality_summary
from measured_brdf.addon.importing import details, import_data, measurements
from measured_brdf.addon.library import operators as saving
from measured_brdf.addon.mix import panel
from measured_brdf.addon.panel import layout as layouts
from measured_brdf.addon.panel import main, menu
from measured_brdf.addon.starter import shelf, thumbnails
from measured_brdf.addon.work import making, queries, queue, tasks

from fitter import PRESETS, error_metrics, fit
from fitter.quality import coverage
from support.cases import quick
from support.drawn import Layout, draw
from support.stage import EEVEE
from tests.addon.answers import answer_all

CHEAP = {"diffuse_level": 2, "specular_level": 4, "compression": 80.0}
ORDER = ["Draft", "Standard", "Reference", "Paper"]


@pytest.fixture
def material(blender, file):
    blender.ops.mesh.primitive_cube_add()
    blender.ops.measured_brdf.import_data(filepath=str(file), **CHEAP)
    return blender.context.object.active_material


def drawn(panel, material):
    """A panel, when its questions have been answered."""
    draw(panel, material=material)
    answer_all()
    return draw(panel, material=material)


def draw_as(panel, owner, **given):
    """What a class draws that is no panel: preferences, or an operator, with the properties of `owner`."""
    layout = Layout()
    settings = owner.measured_brdf
    values = {prop.identifier: getattr(settings, prop.identifier) for prop in settings.bl_rna.properties}
    values |= dict.fromkeys(("data_folder", "asset_library", "files", "complaint"), "") | given
    panel.draw(SimpleNamespace(layout=layout, **values), bpy.context)
    return layout


def use_cycles(scene, osl=True):
    scene.render.engine = "CYCLES"
    scene.cycles.shading_system = osl


def test_without_a_material_the_panel_offers_to_import(blender):
    blender.ops.mesh.primitive_cube_add()
    shown = draw(main.MEASUREDBRDF_PT_material)
    assert shown.button("Import...").operator == "measured_brdf.import_data"


def test_the_panel_opens_with_the_picture_the_preset_and_a_verdict(material, monkeypatch):
    use_cycles(bpy.context.scene)
    monkeypatch.setattr("measured_brdf.addon.work.queries.material_sphere",
                        lambda shown: (7, SimpleNamespace(error=None, finished=1.0)) if shown == material else None)
    shown = drawn(main.MEASUREDBRDF_PT_material, material)
    assert shown.kinds[0] == "picture"
    assert shown.texts.startswith("glossy: (2,4,80) Matches the measurements: ")
    for number in ("RMSE", "MRE", "coefficients", "Coefficients", "bytes"):
        assert number not in shown.texts


def controls(shown):
    """What can be clicked or typed into."""
    return [entry[2] for entry in shown.drawn if entry[0] not in ("text", "picture")]


def test_before_the_first_sub_panel_there_are_six_controls_and_all_but_adjust_are_closed(material):
    use_cycles(bpy.context.scene)
    bpy.ops.measured_brdf.add_studio()          # before a plain world it is offered
    shown = drawn(main.MEASUREDBRDF_PT_material, material)
    assert controls(shown) == ["Import...", "MEASUREDBRDF_PT_library", "", "Mix...", "Inspect", "Save..."]
    bpy.context.scene.cycles.shading_system = False
    assert len(controls(drawn(main.MEASUREDBRDF_PT_material, material))) == 7, "and Enable OSL"
    others = "Mix", "Material Library"          # of mixes, and of materials that are not measured
    below = [cls for cls in bpy.types.Panel.__subclasses__()
             if getattr(cls, "bl_parent_id", "") == "MEASUREDBRDF_PT_material" and cls.bl_label not in others]
    assert [cls.bl_label for cls in below if "DEFAULT_CLOSED" not in getattr(cls, "bl_options", ())] == ["Adjust"]
    assert min(below, key=lambda cls: cls.bl_order).bl_label == "Adjust"


def test_a_mix_shows_its_picture_and_the_measurements_of_its_parts(material, tmp_path, glossy, write_astm, blender,
                                                                   monkeypatch):
    other = write_astm(tmp_path / "dull.astm", glossy, "dull")
    blender.ops.measured_brdf.import_data(filepath=str(other), **CHEAP)
    blender.ops.measured_brdf.mix(first="glossy", second="dull", factor=0.5)
    mix = blender.data.materials["glossy + dull"]
    with monkeypatch.context() as patched:
        patched.setattr("measured_brdf.addon.work.queries.material_sphere",
                        lambda shown: (7, SimpleNamespace(error=None, finished=1.0)) if shown == mix else None)
        shown = drawn(main.MEASUREDBRDF_PT_material, mix)
    assert shown.kinds[0] == "picture"
    assert shown.texts.startswith("glossy + dull: Mix ")
    assert controls(shown)[-3:] == ["Mix...", "Inspect", "Save..."]
    assert measurements.MEASUREDBRDF_PT_data.poll(SimpleNamespace(material=mix))
    rows = [entry[2] for entry in drawn(measurements.MEASUREDBRDF_PT_data, mix).drawn if entry[0] == "text"]
    assert rows.count(f"{len(glossy):,} direction pairs, {' '.join(glossy.channels)}") == 2
    assert [text for text in rows if text in ("glossy", "dull")][::2] == ["glossy", "dull"]


def test_a_folder_is_asked_for_with_the_choices_that_a_file_has(material, monkeypatch):
    monkeypatch.setattr(Layout, "panel", lambda layout, _name, **_: (Layout(layout), Layout(layout)))
    of_file = draw_as(import_data.MEASUREDBRDF_OT_import_data, material, filepath="/data/paint.unknown")
    of_folder = draw_as(import_data.MEASUREDBRDF_OT_import_folder, material, directory="/data/")
    assert set(of_file.fields) - set(of_folder.fields) == {"filepath", "sample"}
    choices = {entry[2:] for entry in of_folder.drawn if entry[0] == "choice"}
    assert choices == {("preset", "Standard"), ("preset", "Reference"), ("rendering", "AUTO"),
                       ("rendering", "EXACT"), ("rendering", "NODES")}
    assert draw_as(saving.MEASUREDBRDF_OT_convert_folder, material, directory="/data/", library="").fields[-1] == (
        "library")


def test_a_mix_is_a_stack_of_layers_each_with_its_picture_share_and_adjustments(material, blender, monkeypatch):
    for name in ("dull", "red", "moss"):
        material.copy().name = name
    for first, second, factor in (("glossy", "dull", 0.1), ("red", "moss", 0.2), ("glossy + dull", "red + moss", 0.3)):
        assert blender.ops.measured_brdf.mix(first=first, second=second, factor=factor) == {"FINISHED"}
    mix = blender.data.materials["glossy + dull + red + moss"]
    icons = {"red + moss": 1, "dull": 2, "glossy": 3}
    monkeypatch.setattr(queries, "material_sphere", lambda shown: (icons[shown.name], None))
    shown = drawn(panel.MEASUREDBRDF_PT_mix, mix)
    assert [entry[2] for entry in shown.drawn if entry[0] == "picture"] == [1, 2, 3], "the uppermost first"
    assert shown.texts == "red + moss dull Adjust glossy Base Adjust"
    assert shown.fields == ["default_value"] * 2
    opened = lambda layout, *_, **_options: (Layout(layout), Layout(layout))  # noqa: E731
    monkeypatch.setattr(Layout, "panel", opened)
    shown = drawn(panel.MEASUREDBRDF_PT_mix, mix)
    assert shown.fields.count("highlight_width") == 2
    blender.data.materials.remove(blender.data.materials["dull"])
    assert "A material that has been deleted" in drawn(panel.MEASUREDBRDF_PT_mix, mix).texts


@pytest.mark.parametrize(("path", "fields"), [
    ("abrdf.dat", ["sample"]), ("leather.bin", ["isotropic", "encoding"]), ("chrome.binary", []),
    ("paint.csv", ["sample", "angles", "quantity", "illuminant", "isotropic", "symmetry", "keep_unmeasured"])])
def test_a_dialog_has_the_choices_of_the_format_at_hand(material, monkeypatch, path, fields):
    monkeypatch.setattr(Layout, "panel", lambda layout, _name, **_: (Layout(layout), Layout(layout)))
    asked = {"sample", "angles", "quantity", "illuminant", "isotropic", "symmetry", "encoding", "keep_unmeasured"}
    for files, filepath in (([], f"/data/{path}"), ([SimpleNamespace(name=path)], "")):
        shown = draw_as(import_data.MEASUREDBRDF_OT_import_data, material, filepath=filepath, files=files)
        assert [name for name in shown.fields if name in asked] == fields


def test_one_line_tells_how_many_files_of_the_data_folder_cannot_be_read(extension, monkeypatch):
    from measured_brdf.addon.starter import panel

    unreadable = [thumbnails.FolderEntry(f"{name}.csv", "", (1, 2), f"{name}.csv: broken") for name in "ab"]
    monkeypatch.setattr(shelf, "watch_folder", lambda folder: SimpleNamespace(error=None, result=unreadable))
    monkeypatch.setattr(panel.preferences, "get", lambda context: SimpleNamespace(data_folder="/data"))
    assert panel.MEASUREDBRDF_PT_folder.poll(bpy.context)
    shown = draw(panel.MEASUREDBRDF_PT_folder)
    assert shown.button("Get from RGL").options["url"] == "https://rgl.epfl.ch/materials"
    assert "2 files cannot be read" in shown.texts
    assert "broken" not in shown.texts


def test_what_the_verdict_says_is_what_the_fit_is_worth(material, glossy):
    settings = material.measured_brdf
    predicted = fit(glossy, 2, 4, 80.0).evaluate(*glossy.directions)
    white = np.pi * np.cos(glossy.theta_o)[:, None]
    lightness = [np.clip(np.cbrt(white * values), 0, 2) for values in (glossy.values, predicted)]
    assert settings.match == pytest.approx(100 * np.sqrt(np.mean((lightness[1] - lightness[0]) ** 2)), rel=1e-3)
    assert settings.between >= settings.match
    assert settings.farthest == pytest.approx(np.degrees(max(glossy.theta_i.max(), glossy.theta_o.max())), abs=0.01)
    assert settings.hole == pytest.approx(coverage.widest_gap(glossy)[0], abs=0.01)


def test_a_material_of_an_older_version_is_not_judged(material):
    material.measured_brdf.match, material.measured_brdf.version = -1, ""
    assert quality_summary(material.measured_brdf) == ("", "", False, False)


@pytest.mark.parametrize(("match", "words", "icon", "level"), [
    (0.5, "Matches the measurements: excellent", "CHECKMARK", "INFO"),
    (5.0, "Matches the measurements: fair", "INFO", "INFO"),
    (9.0, "Matches the measurements: poor. Between measured angles: poor. Choose", "ERROR", "WARNING"),
    (-1.0, "Matches the measurements: not judged, for there is nothing to compare. Meas", "ERROR", "WARNING")])
def test_a_bad_fit_is_a_warning_in_the_panel_and_in_the_info_line(material, match, words, icon, level):
    settings = material.measured_brdf
    settings.match = settings.between = match
    settings.farthest = settings.least = 90
    judged = quality_summary(settings)
    assert judged.line.startswith(words)
    assert judged.whole.startswith(words.split(". ")[0])
    assert (judged.icon, judged.level) == (icon, level)
    assert words in drawn(main.MEASUREDBRDF_PT_material, material).texts


def test_a_published_fit_is_called_one_in_the_panel_and_when_it_is_made(blender, capfd):
    blender.ops.mesh.primitive_cube_add()
    capfd.readouterr()
    blender.ops.measured_brdf.import_data(filepath="published:chrome", preset="Draft")
    material = blender.context.object.active_material
    imported, shown = capfd.readouterr().out, quality_summary(material.measured_brdf).line
    blender.ops.measured_brdf.fit()
    for text in (imported, shown, capfd.readouterr().out):
        assert "ublished fit" in text
        assert "not a measurement" in text
        assert "Matches" not in text


@pytest.mark.parametrize("preset", quick(["Draft", "Standard", "Paper"], "Paper", "Standard"))
def test_the_name_of_a_fit_is_that_of_its_preset(blender, file, preset, quick):
    blender.ops.mesh.primitive_cube_add()
    blender.ops.measured_brdf.import_data(filepath=str(file), preset=preset)
    settings = blender.context.object.active_material.measured_brdf
    assert properties.name_of_fit(settings) == preset
    assert properties.is_as_fitted(settings, settings.digest)
    assert not properties.is_as_fitted(settings, "of other measurements")
    settings.diffuse_level += 1
    assert properties.name_of_fit(settings) == preset
    assert not properties.is_as_fitted(settings, settings.digest)


def test_nothing_is_fitted_to_draw_a_material_that_has_its_fit(material, monkeypatch):
    asked = []
    monkeypatch.setattr(queue, "ask", lambda key, *_rest, **_options: asked.append(key[0]) or SimpleNamespace(
        finished=None, error=None, result=None, fraction=0.0, doing="Starting"))
    draw(main.MEASUREDBRDF_PT_material, material=material)
    draw(details.MEASUREDBRDF_PT_details, material=material)
    assert set(asked) <= {"data", "sphere", "thumbnail"}


def test_presets_have_one_order_everywhere(blender, material):
    shown = drawn(measurements.MEASUREDBRDF_PT_data, material)
    assert shown.button("Standard").place < shown.button("Reference").place
    assert list(PRESETS) == ORDER
    assert [item[0] for item in properties.PRESET_ITEMS] == ORDER
    assert [item.identifier for item in material.measured_brdf.bl_rna.properties["preset"].enum_items] == ORDER


@pytest.mark.parametrize(("engine", "osl", "says"), [
    (EEVEE, False, "Nodes: within "), ("CYCLES", False, "Nodes: OSL is off"), ("CYCLES", True, "Exact")])
def test_the_panel_says_how_the_material_is_rendered_in_four_words(material, engine, osl, says):
    scene = bpy.context.scene
    scene.render.engine = engine
    scene.cycles.shading_system = osl
    shown = drawn(main.MEASUREDBRDF_PT_material, material)
    assert says in shown.texts
    assert "Highlight Error" not in shown.texts
    assert (shown.button("Enable OSL") is not None) == (engine != "CYCLES" or not osl)


def test_under_material_preview_the_panel_says_that_final_renders_are_exact(material):
    use_cycles(bpy.context.scene)
    shading = SimpleNamespace(type="MATERIAL")
    view = SimpleNamespace(type="VIEW_3D", spaces=SimpleNamespace(active=SimpleNamespace(shading=shading)))
    shown = {"material": material, "screen": SimpleNamespace(areas=[SimpleNamespace(type="OUTLINER"), view])}
    assert "Exact on final renders" in draw(main.MEASUREDBRDF_PT_material, **shown).texts
    shading.type = "RENDERED"
    assert "Exact on final renders" not in draw(main.MEASUREDBRDF_PT_material, **shown).texts


@pytest.mark.parametrize(("match", "preset", "advice"), [
    (6.1, "Standard", "Matches the measurements: poor. Choose Reference in Measurements, and Refit"),
    (6.1, "Reference", "Matches the measurements: poor. Measurements lists the values that are doubtful"),
    (6.0, "Standard", "Matches the measurements: fair")])
def test_a_poor_match_comes_with_what_to_do_about_it(material, match, preset, advice):
    settings = material.measured_brdf
    settings.match, settings.between = match, -1
    properties.use_preset(settings, preset)
    settings.fitted_as = as_text(properties.fit_arguments(settings))
    assert properties.quality_summary(settings).line == advice
    assert advice in draw(main.MEASUREDBRDF_PT_material, material=material).texts


def test_a_linked_material_cannot_be_refitted_until_it_is_local(blender, material, from_library):
    before = material.measured_brdf.fitted_as
    linked = from_library(material.name)
    shown = drawn(measurements.MEASUREDBRDF_PT_data, linked)
    assert not shown.button("Standard").enabled
    assert not shown.button("Refit").enabled
    assert drawn(main.MEASUREDBRDF_PT_material, linked).button("Make Local").enabled
    assert blender.ops.measured_brdf.make_local() == {"FINISHED"}
    local = blender.context.object.active_material
    assert local.is_editable
    assert local.measured_brdf.fitted_as == before
    assert not blender.ops.measured_brdf.make_local.poll()
    assert drawn(measurements.MEASUREDBRDF_PT_data, local).button("Standard").enabled
    assert drawn(main.MEASUREDBRDF_PT_material, local).button("Make Local") is None
    assert blender.ops.measured_brdf.fit() == {"FINISHED"}


def test_a_wrong_sample_leads_to_the_list_of_samples(blender, data):
    blender.ops.mesh.primitive_cube_add()
    blender.ops.measured_brdf.import_data(filepath=str(data / "curet" / "abrdf.dat"), sample="1", **CHEAP)
    material = blender.context.object.active_material
    material.measured_brdf.sample = "no such stone"
    draw(measurements.MEASUREDBRDF_PT_data, material=material)
    lane = queue._lanes["read"]
    for key, job, _then in lane.queue:
        with pytest.raises(ValueError, match="no such stone") as caught:
            job.function()
        job.error, job.finished = caught.value, float("inf")
        queue._answers[key] = job
    lane.queue.clear()
    shown = draw(measurements.MEASUREDBRDF_PT_data, material=material)
    assert shown.button("Relink...") is None
    button = shown.button("Choose Sample")
    assert (button.operator, button.options["for_material"]) == ("measured_brdf.choose_sample", True)


def test_progress_reads_as_progress_and_the_result_as_a_number(material, monkeypatch):
    answer_all()
    drawn(measurements.MEASUREDBRDF_PT_data, material)            # reads the measurements
    job = SimpleNamespace(finished=None, error=None, result=None, fraction=0.4)
    monkeypatch.setattr(queries, "held_out", lambda *_: job)
    assert dict(details.rows(material))["Error at Unseen Angles"] == "working out, 40%"
    job.finished, job.result = 1.0, 0.0123456
    assert dict(details.rows(material))["Error at Unseen Angles"] == "0.0123 / sr"


def test_details_have_the_numbers(material, glossy):
    expected = fit(glossy, 2, 4, 80.0)
    errors = error_metrics(glossy.values, expected.evaluate(*glossy.directions))
    shown = dict(details.rows(material))
    assert shown["RMSE"] == f"{errors.rmse:.3g} / sr"
    assert shown["Coefficients"] == f"{expected.coefficient_count:,}"
    assert re.fullmatch(r"Nodes \d+\.\d%, EEVEE \d+\.\d%", shown["Highlight Error"])


def test_neither_draft_nor_the_method_of_2002_is_among_the_presets_of_panel_dialog_and_preferences(material):
    """Draft takes as long as Standard, and the other one has its place in Fit Settings. Scripts may name both."""
    choices = [entry[3] for panel in (preferences.MeasuredPreferences, import_data.MEASUREDBRDF_OT_import_data)
               for entry in draw_as(panel, material).drawn if entry[0] == "choice" and entry[2] == "preset"]
    assert choices == ["Standard", "Reference"] * 2
    shown = drawn(measurements.MEASUREDBRDF_PT_data, material)
    assert shown.button("Draft") is shown.button("Paper") is shown.button("Original 2002 Method") is None


def test_the_method_of_2002_is_chosen_in_fit_settings(material):
    button = drawn(details.MEASUREDBRDF_PT_settings, material).button("Original 2002 Method")
    assert (button.operator, button.options["preset"]) == ("measured_brdf.use_preset", "Paper")


@pytest.mark.parametrize(("dropped", "text"), [
    (98.2, "98.2 % of the fine lattice dropped, 1.8 % kept"), (0.0, "0 % of the fine lattice dropped, 100 % kept")])
def test_compression_is_explained_as_what_is_kept(material, dropped, text):
    material.measured_brdf.compression = dropped
    assert text in draw(details.MEASUREDBRDF_PT_settings, material=material).texts


@pytest.mark.parametrize(("kind", "width", "scale", "expected"), [
    ("WINDOW", 420, 1.0, 61), ("WINDOW", 420, 1.25, 46), ("WINDOW", 60, 1.0, 20), ("UI", 420, 1.0, 55)])
def test_columns_follow_from_the_width_of_the_region(monkeypatch, kind, width, scale, expected):
    system = SimpleNamespace(system=SimpleNamespace(ui_scale=scale))
    monkeypatch.setattr(layouts, "bpy", SimpleNamespace(context=SimpleNamespace(
        region=SimpleNamespace(type=kind, width=width), preferences=system)))
    assert layouts.room() == expected


@pytest.mark.parametrize("width", [150, 220, 400])
@pytest.mark.parametrize("scale", [1.0, 1.25, 2.0])
def test_lines_fill_the_width_of_the_region_and_are_not_cut(monkeypatch, width, scale):
    text = ("Published fit of MERL's specular-blue-phenolic, not a measurement (Low, Kronander, Ynnerman, Unger 2012, "
            "ACM TOG 31(1)). WITH CAPITALS: MMMM WWWW MMMM WWWW; illicit little lilies")
    monkeypatch.setattr(layouts, "bpy", SimpleNamespace(context=SimpleNamespace(
        region=SimpleNamespace(type="WINDOW", width=width * scale), preferences=SimpleNamespace(
            system=SimpleNamespace(ui_scale=scale),
            ui_styles=[SimpleNamespace(widget=SimpleNamespace(points=11.0))]))))
    lines = layouts.wrap_text(text)
    blf.size(0, 11.0 * scale)
    widest = max(blf.dimensions(0, line)[0] for line in lines) / scale
    assert "".join(lines).replace(" ", "") == text.replace(" ", "")
    assert 0.7 * (width - 60) < widest <= width - 50


@pytest.mark.parametrize(("width", "is_beside"), [(700, True), (480, True), (250, False)])
def test_a_value_that_would_be_cut_beside_its_name_stands_below_it(monkeypatch, width, is_beside):
    monkeypatch.setattr(layouts, "bpy", SimpleNamespace(context=SimpleNamespace(
        region=SimpleNamespace(type="WINDOW", width=width), preferences=SimpleNamespace(
            system=SimpleNamespace(ui_scale=1.0), ui_styles=[SimpleNamespace(widget=SimpleNamespace(points=11.0))]))))
    name, value = "Widest hole", "17\N{DEGREE SIGN} at 10 in, 40 out, 150 around"
    layout = Layout()
    splits = []
    monkeypatch.setattr(Layout, "split", lambda self, factor: splits.append(factor) or Layout(self), raising=False)
    layouts.draw_value(layout, name, value, 0.3)
    texts = [entry[2] for entry in layout.drawn]
    assert (" ".join(texts), splits) == (f"{name} {value}", [0.3] * is_beside)
    blf.size(0, 11.0)
    shares = [0.3, 0.7] if is_beside else [1] * len(texts)
    assert all(blf.dimensions(0, text)[0] < share * width - 20 for text, share in zip(texts, shares, strict=True))


def test_the_sidebar_shows_what_the_material_tab_shows(material):
    class WithoutMaterial(SimpleNamespace):
        """The context of a 3-D viewport has no `material`."""

    tab = drawn(main.MEASUREDBRDF_PT_material, material)
    sidebar = draw(main.MEASUREDBRDF_PT_sidebar)
    assert sidebar.texts == tab.texts
    assert sidebar.fields == tab.fields
    assert (main.MEASUREDBRDF_PT_sidebar.bl_space_type, main.MEASUREDBRDF_PT_sidebar.bl_category) == (
        "VIEW_3D", "Measured BRDF")


def test_the_sidebar_has_what_can_be_adjusted(material):
    assert adjust.MEASUREDBRDF_PT_adjust_sidebar.poll(bpy.context)
    sidebar = draw(adjust.MEASUREDBRDF_PT_adjust_sidebar)
    assert "highlight_gain" in sidebar.fields
    assert sidebar.fields == draw(adjust.MEASUREDBRDF_PT_adjust, material=material).fields
    material.measured_brdf_adjustments.highlight_gain = 0.5
    assert "glossy: (2,4,80), adjusted" in drawn(main.MEASUREDBRDF_PT_sidebar, None).texts


@pytest.mark.parametrize("word", ["Import", "Fit", "Compare", "Convert", "Mix"])
def test_searching_finds_what_can_be_done(word):
    """F3 finds what is in the menus of the editors that are open, and no INTERNAL operator."""
    listed = [entry for entry in draw(menu.MEASUREDBRDF_MT_menu).drawn if entry[0] == "button"]
    entries = [entry for entry in listed if word in entry[2] and "Measured BRDF" in entry[2]]
    assert entries
    for entry in entries:
        operator = next(cls for cls in bpy.types.Operator.__subclasses__() if cls.bl_idname == entry[3])
        assert "INTERNAL" not in getattr(operator, "bl_options", ())


@pytest.mark.parametrize("menu", ["VIEW3D_MT_object", "NODE_MT_node", "MATERIAL_MT_context_menu"])
def test_the_menu_is_in_the_menus_of_blender(menu):
    functions = getattr(bpy.types, menu).draw._draw_funcs
    assert any(function.__module__.endswith("addon.panel.menu") for function in functions)


class TestTabs:
    """After the first import, the editor of properties shows the material."""

    @pytest.fixture
    def window(self, extension):
        class Space:
            has_materials, _shown = True, "OBJECT"

            @property
            def context(self):
                return self._shown

            @context.setter
            def context(self, value):
                if not self.has_materials:
                    raise TypeError(f'enum "{value}" not found in (...)')
                self._shown = value

        spaces = {kind: Space() for kind in ("PROPERTIES", "VIEW_3D")}
        areas = [SimpleNamespace(type=kind, spaces=SimpleNamespace(active=space)) for kind, space in spaces.items()]
        context = SimpleNamespace(window=SimpleNamespace(screen=SimpleNamespace(areas=areas)))
        return SimpleNamespace(context=context, spaces=spaces)

    def test_the_first_import_shows_the_material_tab(self, window, material):
        making.show_first(window.context, [material])
        assert (window.spaces["PROPERTIES"].context, window.spaces["VIEW_3D"].context) == ("MATERIAL", "OBJECT")

    def test_later_imports_leave_the_tab_alone(self, window, material):
        making.show_first(window.context, [material.copy()])
        assert window.spaces["PROPERTIES"].context == "OBJECT"

    def test_where_there_is_no_such_tab_nothing_happens(self, window, material):
        window.spaces["PROPERTIES"].has_materials = False
        making.show_first(window.context, [material])
        assert window.spaces["PROPERTIES"].context == "OBJECT"

    def test_scripts_without_a_window_can_import(self, material):
        making.show_first(SimpleNamespace(window=None), [material])


def test_only_the_import_of_a_user_leads_to_the_tab(blender, file, monkeypatch):
    shown = []
    monkeypatch.setattr(making, "show_first", lambda _context, made: shown.extend(item.name for item in made))
    blender.ops.mesh.primitive_cube_add()
    blender.ops.measured_brdf.import_data(filepath=str(file), **CHEAP)
    assert shown == []

    class Invoked(making.MakesMaterials):
        options, target, slot, others = SimpleNamespace(is_invoke=True), 0, 0, ""

        def report(self, *_):
            pass

    operator = Invoked()
    settings = blender.context.object.active_material.measured_brdf
    for name in CHOICES:
        setattr(operator, name, getattr(settings, name))
    outcome = tasks.outcome(str(file), "", {"diffuse_level": 1, "specular_level": None})
    operator.apply(blender.context, [(str(file), "", outcome, None)])
    assert shown == ["glossy.001"]


@pytest.mark.parametrize("odd", [float("nan"), float("inf"), -1e30, "", "[1]", '{"tolerance": 3}', "x" * 2000,
                                 "\u00e9"])
def test_results_of_a_damaged_file_are_drawn_or_left_out(material, odd):
    """Of any kind, where the property can hold it."""
    settings = material.measured_brdf
    for name in ("match", "between", "farthest", "hole", "sphere", "fitted_as", "fitted_levels", "colours", "filepath"):
        if isinstance(getattr(settings, name), type(odd)):
            setattr(settings, name, odd)
    for each in (main.MEASUREDBRDF_PT_material, measurements.MEASUREDBRDF_PT_data, details.MEASUREDBRDF_PT_details,
                 details.MEASUREDBRDF_PT_settings):
        assert draw(each, material=material).texts


def test_look_shows_the_fit_that_the_material_has_and_fits_only_for_other_settings(extension, material, monkeypatch):
    asked, done = [], SimpleNamespace(error=None, finished=1.0, result=(None, float("nan")))
    queries = extension.addon.work.queries
    for name in ("material_sphere", "lit_sphere", "polar_plot"):
        monkeypatch.setattr(queries, name, lambda *arguments, name=name: (asked.append((name, *(
            type(each).__name__ for argument in arguments
            for each in (argument, *(argument[0] if type(argument) is tuple and type(argument[0]) is tuple else ()))
            if hasattr(each, "digest")))), (7, done))[1])
    look = extension.addon.compare.curves.MEASUREDBRDF_PT_pictures
    drawn(look, material)
    assert set(asked) == {("material_sphere",), ("polar_plot", "EmbeddedFit"), ("polar_plot", "EmbeddedFit", "Data")}
    asked.clear()
    material.measured_brdf.diffuse_level += 1
    drawn(look, material)
    assert set(asked) == {("lit_sphere", "FitRequest"), ("polar_plot", "FitRequest", "Data")}
    asked.clear()
    material.measured_brdf.filepath = "/nowhere/file.astm"
    draw(look, material=material)
    assert set(asked) == {("material_sphere",), ("polar_plot", "EmbeddedFit")}


def test_a_picture_that_is_drawn_anew_moves_nothing_below_it(extension):
    """A slider under it would leave the pointer that drags it."""
    rows = []
    for icon, finished in ((7, 1.0), (7, None), (0, None)):
        layout = Layout()
        extension.addon.panel.layout.draw_picture(
            layout, icon, SimpleNamespace(error=None, finished=finished, fraction=0.1, doing="Starting"), 3)
        rows.append([entry[0] for entry in layout.drawn])
    assert rows == [["picture"], ["picture"], ["text"]]
