"""Favourites of the library: a row above it, kept in the preferences."""

from types import SimpleNamespace

import bpy
import pytest
from measured_brdf.addon.core import preferences
from measured_brdf.addon.starter import panel, shelf

from support.drawn import draw


@pytest.fixture
def stored(extension, monkeypatch):
    """Stands for the preferences of an installed extension."""
    found = SimpleNamespace(favourites="", preset="Standard", data_folder="", asset_library="")
    monkeypatch.setattr(preferences, "get", lambda _context: found)
    return found


def test_a_star_puts_a_material_into_the_row_above_and_takes_it_out(stored):
    choices = bpy.context.window_manager.measured_brdf_shelf
    choices.search = "unobtainium"                      # so that nothing but the row is drawn
    assert draw(panel.MEASUREDBRDF_PT_library).kinds.count("picture") == 0
    for name in ("gold-polished", "teflon"):
        assert bpy.ops.measured_brdf.favourite(name=name) == {"FINISHED"}
    assert [each.name for each in shelf.favourites()] == ["teflon", "gold-polished"]
    assert draw(panel.MEASUREDBRDF_PT_library).kinds.count("picture") == 2
    assert bpy.ops.measured_brdf.favourite(name="teflon") == {"FINISHED"}
    assert stored.favourites == "gold-polished"
    choices.property_unset("search")


def test_names_of_other_versions_are_left_out_and_unknown_ones_refused(stored):
    stored.favourites = "unobtainium,gold-satin"
    assert [each.name for each in shelf.favourites()] == ["gold-satin"]
    with pytest.raises(RuntimeError, match="no published material"):
        bpy.ops.measured_brdf.favourite(name="unobtainium")
    assert stored.favourites == "unobtainium,gold-satin"


def test_without_preferences_a_favourite_is_refused(extension):
    with pytest.raises(RuntimeError, match="not installed"):
        bpy.ops.measured_brdf.favourite(name="teflon")
