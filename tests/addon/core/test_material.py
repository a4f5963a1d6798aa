"""Materials that cannot be made: called by scripts and by the batch, not inside an operator's own transaction."""

from types import SimpleNamespace

import bpy
import pytest

from support.blend_state import state


@pytest.fixture
def failing(blender, extension, glossy, write_astm, tmp_path, monkeypatch):
    """The module, whose last step fails, and what `create` takes."""
    from measured_brdf.addon.core.properties import CHOICES, use_preset
    from measured_brdf.addon.work import tasks

    module, path = extension.addon.core.material, str(write_astm(tmp_path / "a.astm", glossy, "a"))
    settings = bpy.types.Material.bl_rna.properties["measured_brdf"].fixed_type.properties
    choices = SimpleNamespace(**{name: settings[name].default for name in CHOICES})
    use_preset(choices, "Draft")
    choices.filepath = path
    given = tasks.outcome(path, "", {"diffuse_level": 1, "specular_level": None}), choices, bpy.context

    def fail(*_):
        raise ValueError("no more")

    def break_last_step():
        monkeypatch.setattr(module, "_replaced", fail)

    return SimpleNamespace(module=module, given=given, break_last_step=break_last_step)


def test_one_that_cannot_be_made_leaves_nothing(failing):
    failing.break_last_step()
    before = state()
    with pytest.raises(ValueError, match="no more"):
        failing.module.create(*failing.given)
    assert state() == before


@pytest.mark.parametrize("is_measured", [False, True])
def test_one_that_cannot_be_given_a_fit_stays_as_it_was(failing, is_measured):
    material = failing.module.create(*failing.given) if is_measured else bpy.data.materials.new("Plain")
    failing.module.use_nodes(material)
    failing.break_last_step()
    before = state()
    with pytest.raises(ValueError, match="no more"):
        failing.module.assign(material, *failing.given)
    assert state() == before


def test_one_without_nodes_holds_nothing(blender, extension):
    """As before Blender 5.0."""
    material = bpy.data.materials.new("Plain")
    assert extension.addon.core.material.group_nodes(material) == []
    assert not extension.addon.core.material.is_shown(material)
