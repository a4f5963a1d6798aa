"""The pictures of anisotropic materials: their data, their shapes, and the whole of it in a few pixels."""

import numpy as np
import pytest

import fitter
from support.anisotropic import SATIN, STEEL, few, write_table


@pytest.mark.parametrize("truth", [STEEL, SATIN])
def test_the_tables_are_anisotropic_reciprocal_and_say_that_they_are_synthetic(truth, tmp_path):
    samples = fitter.load(write_table(tmp_path / "table.csv", truth, 8))
    assert not samples.isotropic
    assert "synthetic" in samples.name
    np.testing.assert_allclose(samples.values, truth.evaluate(*samples.directions), rtol=0.05, atol=1e-4)
    theta_i, phi_i, theta_o, phi_o = samples.directions
    np.testing.assert_allclose(truth.evaluate(*samples.directions), truth.evaluate(theta_o, phi_o, theta_i, phi_i))


def test_the_pan_is_a_turned_part_and_the_cloth_has_its_threads_in_a_uv_map(extension, blender):
    from measured_brdf.addon.core.shading import tangents

    from demo_scenes import anisotropic

    assert tangents.is_turned(anisotropic.pan().data)
    cloth = anisotropic.cloth(42, 24).data
    assert not tangents.is_turned(cloth)
    assert tangents.has_uv(cloth)


def test_both_are_imported_and_rendered(baked_once, tmp_path, monkeypatch):
    import bpy

    from demo_scenes import anisotropic

    monkeypatch.setattr(anisotropic, "write_table", lambda path, truth, _: write_table(path, truth, directions=few()))
    for name, value in {"DATA": tmp_path, "WIDTH": 24, "HEIGHT": 18}.items():
        monkeypatch.setattr(anisotropic, name, value)
    anisotropic.draw(tmp_path / "picture.png", samples=1, choices={"diffuse_level": 2, "specular_level": -1})
    picture = bpy.data.images.load(str(tmp_path / "picture.png"))
    assert tuple(picture.size) == (52, 18)
    assert bpy.data.objects["Satin"].active_material.name == "satin (synthetic)"
