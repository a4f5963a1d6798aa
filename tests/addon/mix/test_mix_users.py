"""What a mix holds is bounded, and what it follows is saved with the file.

Blender's windows forget that a mix uses it (tests/window).
"""

import pytest

from support.blend_state import state


@pytest.fixture
def mixed(blender, quick, glossy, write_astm, tmp_path):
    """Two materials that nothing but their mix uses."""
    for name in ("first", "second"):
        path = write_astm(tmp_path / f"{name}.astm", glossy, name)
        blender.ops.measured_brdf.import_data(filepath=str(path), preset="Draft")
    blender.ops.measured_brdf.mix(first="first", second="second")
    return [blender.data.materials[name] for name in ("first", "second")]


def saved(blender, path):
    blender.ops.wm.save_as_mainfile(filepath=str(path), copy=True)
    with blender.data.libraries.load(str(path)) as (there, _):
        return set(there.materials)


def test_what_is_mixed_is_saved_without_other_users(blender, mixed, tmp_path):
    assert all(material.use_fake_user for material in mixed)
    assert saved(blender, tmp_path / "mixed.blend") >= {"first", "second"}


def test_what_is_mixed_is_saved_too_where_blender_took_its_fake_user_away(blender, mixed, tmp_path):
    for material in mixed:
        material.use_fake_user = False
        material.user_clear()               # as windows of Blender do
    assert saved(blender, tmp_path / "mixed.blend") >= {"first", "second"}


def test_a_mix_that_would_hold_too_many_is_refused_and_nothing_changes(blender, mixed):
    """Mixed with itself again and again: each time the shaders of all are in it twice."""
    name, before = "first + second", set(blender.data.materials.keys())
    for _ in range(2):
        blender.ops.measured_brdf.mix(first=name, second=name)
        name, = set(blender.data.materials.keys()) - before
        before.add(name)
    old = state()
    with pytest.raises(RuntimeError, match="would hold 16 measured materials, expected at most 8") as raised:
        blender.ops.measured_brdf.mix(first=name, second=name)
    assert str(raised.value).count("\n") == 1
    assert state() == old
