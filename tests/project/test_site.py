"""The documentation as a site: what `make docs` builds, and the part of it in the extension."""

import subprocess
import sys
import zipfile

import pytest

from support.cases import release
from support.checkout import ROOT
from tools.docs import check

pytestmark = release        # `make docs` builds the site and checks its links

SPHINX = ROOT / "build" / f"env-docs-{sys.version_info[0]}.{sys.version_info[1]}" / "bin" / "python"
needs_sphinx = pytest.mark.skipif(not SPHINX.exists(), reason="`make docs` installs Sphinx")


def built(folder, *options):
    done = subprocess.run([sys.executable, "-m", "tools.docs", folder, "--python", SPHINX, *options], cwd=ROOT,
                          capture_output=True, text=True, check=False, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr
    return folder


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    return built(tmp_path_factory.mktemp("site") / "site")


@pytest.fixture(scope="module")
def manual_site(tmp_path_factory):
    return built(tmp_path_factory.mktemp("manual") / "html", "--manual")


@needs_sphinx
def test_every_page_is_reached_from_the_first(site):
    pages = {path.relative_to(site).as_posix() for path in site.rglob("*.html")}
    seen, waiting = set(), ["index.html"]
    while waiting:
        page = waiting.pop()
        seen.add(page)
        waiting += check.linked_pages(site, site / page) - seen
    assert pages - seen <= {"search.html", "genindex.html", "py-modindex.html"}
    sources = {path.relative_to(ROOT / "docs").with_suffix(".html").as_posix() for path in ROOT.glob("docs/**/*.md")}
    assert sources | {"changelog.html", "contributing.html", "reference/python.html"} <= seen


@needs_sphinx
def test_the_reference_has_every_public_name_operator_argument_and_command(site, blender):
    import fitter

    python = check.anchors(site / "reference" / "python.html")
    assert {f"fitter.{name}" for name in fitter.__all__} <= python
    assert {"fitter.Fit.evaluate", "fitter.Samples.directions"} <= python
    text = (site / "reference" / "operators.html").read_text("utf-8")
    names = dir(blender.ops.measured_brdf)
    assert {"fit", "import_data"} <= set(names)
    for name in names:
        assert name.replace("_", "-") in check.anchors(site / "reference" / "operators.html"), name
        for argument, _ in getattr(blender.ops.measured_brdf, name).get_rna_type().properties.items():
            assert argument in ("rna_type", "filter_glob") or f">{argument}<" in text, (name, argument)
    text = (site / "reference" / "command_line.html").read_text("utf-8")
    for command in ("fitter info", "fitter fit", "fitter bake", "measured_brdf convert", "measured_brdf render"):
        assert f"python -m {command}" in text or f"usage: {command}" in text, command


@needs_sphinx
def test_every_topic_of_f1_leads_to_an_anchor_of_the_extensions_pages(manual_site, extension):
    from measured_brdf.addon.core import manual

    assert len(manual.topics()) > 8
    for topic in manual.topics():
        redirect = manual_site / manual.REDIRECTS / f"{manual.file_name(topic)}.html"
        page, _, anchor = topic.partition("#")
        assert f"url=../{page}.html#{anchor}" in redirect.read_text("utf-8")
        assert anchor in check.anchors(manual_site / f"{page}.html"), topic


@needs_sphinx
def test_the_extensions_pages_are_small_and_complete(manual_site, tmp_path):
    assert list(check.problems(manual_site)) == []
    with zipfile.ZipFile(tmp_path / "html.zip", "w", zipfile.ZIP_DEFLATED) as file:
        for path in manual_site.rglob("*"):
            file.write(path, path.relative_to(manual_site))
    assert (tmp_path / "html.zip").stat().st_size < 1e6
    names = {path.relative_to(manual_site).as_posix() for path in manual_site.rglob("*.html")}
    assert {"manual.html", "start.html", "formats.html", "manual/engines.html", "search.html"} <= names
    assert not {"fitting.html", "reference/python.html"} & names
    assert not list(manual_site.rglob("*.png"))[3:]         # the theme's own; the manual's are WebP


@pytest.mark.parametrize(("text", "found"), [
    ('<a href="b.html">', []),
    ('<a href="b.html#there">', []),
    ('<a href="c.html">', ["a.html: c.html is not there"]),
    ('<a href="b.html#gone">', ["a.html: b.html#gone: no such anchor"]),
    ('<a href="#here"><p id="here">', []),
    ('<a href="#gone">', ["a.html: #gone: no such anchor"]),
    ('<a href="https://example.org">', []),
    ('<img src="none.png">', ["a.html: none.png is not there"]),
    ('<img src="https://example.org/x.png">', ["a.html: fetches https://example.org/x.png"]),
    ('<script src="//example.org/x.js"></script>', ["a.html: fetches //example.org/x.js"]),
    ('<link rel="stylesheet" href="https://example.org/x.css">', ["a.html: fetches https://example.org/x.css"]),
    ('<p style="background: url(https://example.org/x)">', ["a.html: fetches https://example.org/x"]),
    ('<img src="data:image/png;base64,AA">', []),
    ('<meta http-equiv="refresh" content="0; url=c.html">', ["a.html: c.html is not there"]),
])
def test_dead_links_and_requests_to_other_hosts_are_found(tmp_path, text, found):
    (tmp_path / "a.html").write_text(text)
    (tmp_path / "b.html").write_text('<h1 id="there">')
    assert list(check.problems(tmp_path)) == found


def test_a_style_sheet_that_fetches_a_font_is_found(tmp_path):
    (tmp_path / "x.css").write_text("@import 'https://example.org/font.css'; p { background: url(gone.svg) }")
    assert list(check.problems(tmp_path)) == ["x.css: fetches https://example.org/font.css",
                                              "x.css: gone.svg is not there"]
