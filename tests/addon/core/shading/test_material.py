"""Materials that are made, given another fit, or cannot be: as the batch and scripts do it, without an operator's own
transaction."""

from types import SimpleNamespace

import bpy
import pytest
from measured_brdf.addon.core import lamps
from measured_brdf.addon.core.blender import followers
from measured_brdf.addon.core.blender.node_trees import use_nodes
from measured_brdf.addon.core.shading import material as materials
from measured_brdf.addon.core.storage.properties import use_preset
from measured_brdf.addon.work import tasks

from support.blend_state import state
from support.operators import default_choices


@pytest.fixture
def making(blender, glossy, write_astm, tmp_path, monkeypatch):
    """What `create` takes, twice, and what lets its last step fail from then on."""
    path = str(write_astm(tmp_path / "a.astm", glossy, "a"))
    choices = default_choices()
    use_preset(choices, "Draft")
    choices.filepath = path
    given, other = ((tasks.outcome(path, "", {"diffuse_level": level, "specular_level": None}), choices, bpy.context)
                    for level in (1, 2))

    def fail(*_):
        raise ValueError("no more")

    def break_last_step():
        monkeypatch.setattr(followers, "followers", [fail])

    return SimpleNamespace(given=given, other=other, break_last_step=break_last_step)


def test_one_that_cannot_be_made_leaves_nothing(making):
    making.break_last_step()
    before = state()
    with pytest.raises(ValueError, match="no more"):
        materials.create(*making.given)
    assert state() == before


@pytest.mark.parametrize("is_measured", [False, True])
def test_one_that_cannot_be_given_a_fit_stays_as_it_was(making, is_measured):
    material = materials.create(*making.given) if is_measured else bpy.data.materials.new("Plain")
    use_nodes(material)
    making.break_last_step()
    before = state()
    with pytest.raises(ValueError, match="no more"):
        materials.assign(material, *making.given)
    assert state() == before


def test_one_without_nodes_holds_nothing(blender):
    """As before Blender 5.0."""
    material = bpy.data.materials.new("Plain")
    assert materials.group_nodes(material) == []
    assert not materials.is_shown(material)


def test_who_makes_a_material_knows_no_lamps_and_whoever_follows_is_told(making, monkeypatch):
    assert "lamps" not in vars(materials)
    told = []
    monkeypatch.setattr(followers, "followers", [*followers.followers, told.append])
    monkeypatch.setattr(lamps, "update", lambda depsgraph: told.append("lamps"))
    materials.create(*making.given)
    assert told[-2] == "lamps"
    assert isinstance(told[-1], bpy.types.Depsgraph)
