"""The databases that the panel, the preferences and the manual name are the same."""

from support.checkout import ROOT


def test_each_source_is_complete_and_in_the_manual(extension):
    from measured_brdf.addon.starter.data_sources import SOURCES

    assert {source.name for source in SOURCES} == {"CURET", "Cornell", "MERL", "RGL", "UTIA"}
    manual = (ROOT / "docs" / "manual.md").read_text("utf-8")
    for source in SOURCES:
        assert source.url.startswith(("https://", "http://"))
        assert len(source.facts) == 5
        row = next(line for line in manual.splitlines() if line.startswith(f"| [{source.name}]({source.url})"))
        for text in (source.owner, source.licence, source.size, source.good_for):
            assert text, source.name
            assert text in row, source.name


def test_what_the_sources_write_is_read(extension):
    from measured_brdf.addon.starter.data_sources import SOURCES
    from measured_brdf.fitter.formats import EXTENSIONS

    for source in SOURCES:
        for name in source.files.split(", "):
            assert name.endswith(EXTENSIONS), name
