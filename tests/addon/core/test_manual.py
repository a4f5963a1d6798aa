"""What F1 and the Manual button open: pages of the extension, of a website, or the Markdown of a checkout."""

import re
from fnmatch import fnmatchcase
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest
from measured_brdf.addon.core import manual

from support.checkout import ROOT

HEADING = re.compile(r"^#+ (.*)$", re.MULTILINE)


@pytest.fixture
def with_html(blender, monkeypatch, tmp_path):
    monkeypatch.setattr(manual, "WEBSITE", "")
    monkeypatch.setattr(manual, "HTML", tmp_path)
    return tmp_path


def opened(blender, name):
    """The file that F1 opens over something."""
    url = blender.types.WM_OT_doc_view_manual._lookup_rna_url(name, verbose=False)
    return None if url is None else Path(unquote(urlsplit(url).path))


def controls(blender):
    """Every operator and setting of the extension, as F1 asks for them."""
    yield from (f"bpy.ops.measured_brdf.{name}" for name in dir(blender.ops.measured_brdf))
    for owner in (blender.types.Material, blender.types.Scene, blender.types.WindowManager):
        for settings in owner.bl_rna.properties:
            if settings.type == "POINTER" and settings.identifier.startswith("measured_brdf"):
                yield from (f"bpy.types.{settings.fixed_type.identifier}.{argument.identifier}"
                            for argument in settings.fixed_type.properties
                            if argument.identifier not in ("rna_type", "name"))


def slugs(page):
    """The headings of a page, as links name them."""
    return {re.sub(r"[^\w -]", "", heading.lower()).strip().replace(" ", "-")
            for heading in HEADING.findall((ROOT / "docs" / f"{page}.md").read_text("utf-8"))}


def test_a_checkout_opens_its_markdown(blender, with_html, monkeypatch):
    monkeypatch.setattr(manual, "HTML", with_html / "absent")
    for name in ("bpy.ops.measured_brdf.fit", "bpy.types.MeasuredMaterial.diffuse_level"):
        assert opened(blender, name) == ROOT / "docs" / "manual.md"


def test_f1_finds_a_page_over_every_control(blender, with_html):
    names = list(controls(blender))
    assert len(names) > 30
    for name in names:
        path = opened(blender, name)
        assert path is not None, name
        assert path.is_relative_to(with_html), name


def test_every_operator_has_a_heading_of_its_own(blender):
    general = [pattern for pattern, topic in manual.all_topics() if "#" not in topic]
    for name in dir(blender.ops.measured_brdf):
        name = f"bpy.ops.measured_brdf.{name}"
        pattern = next(pattern for pattern, _ in manual.all_topics() if fnmatchcase(name, pattern))
        assert pattern not in general, f"{name}: no heading of the manual"


def test_no_topic_is_of_a_control_that_is_gone(blender):
    known = [name.lower() for name in controls(blender)]
    for pattern, _ in manual.all_topics():
        if pattern.startswith(("bpy.ops.", "bpy.types.measured")) and "preferences" not in pattern:
            assert any(fnmatchcase(name, pattern) for name in known), pattern


def test_every_topic_is_a_heading_of_the_manual(blender):
    for topic in manual.topics():
        page, _, heading = topic.partition("#")
        assert heading in slugs(page), topic


def test_over_a_control_the_page_is_opened_that_leads_to_its_heading(blender, with_html):
    assert opened(blender, "bpy.ops.measured_brdf.use_method") == with_html / "f1" / "manual-engines--choose.html"
    assert opened(blender, "bpy.types.MeasuredMaterial.shown_theta") == (
        with_html / "f1" / "manual--curves.html")


def test_where_the_manifest_names_a_website_and_blender_may_go_online_that_is_opened(blender, monkeypatch, with_html):
    class Online:
        online_access = True

    monkeypatch.setattr(manual, "WEBSITE", "https://example.org/brdf")
    monkeypatch.setattr(manual.bpy, "app", Online)
    assert manual.url() == "https://example.org/brdf/manual.html"
    assert manual.url("manual/engines#choose") == "https://example.org/brdf/manual/engines.html#choose"
    Online.online_access = False
    assert manual.url("manual#fit") == (with_html / "f1" / "manual--fit.html").as_uri()
    assert manual.url() == (with_html / "manual.html").as_uri()
