"""The Principled BSDF that is fitted is the one that Cycles renders: a lit plane, seen at an angle."""

import math

import bpy
import numpy as np
import pytest
from measured_brdf.addon.core.shading import export_surface

from fitter.cycles.principled_bsdf import Principled
from support import stage

COLOR = np.array([0.6, 0.3, 0.1])
BSDFS = {"plastic": Principled(COLOR, 0.4, 0.0, 0.5), "glossy": Principled(COLOR, 0.3, 0.0, 1.0),
         "rough": Principled(COLOR, 0.9, 0.0, 0.5), "metal": Principled(COLOR, 0.4, 1.0, 0.5),
         "rough metal": Principled(COLOR, 0.9, 1.0, 0.5), "mixed": Principled(COLOR, 0.5, 0.4, 0.5),
         "cloth": Principled(COLOR, 0.5, 0.0, 0.5, np.array([0.5, 0.3, 0.2]), 0.45),
         "fuzz": Principled(COLOR, 0.5, 0.0, 0.5, np.array([0.5, 0.3, 0.2]), 0.8),
         "lacquer": Principled(COLOR, 0.5, 0.0, 0.5, coat_weight=0.8, coat_roughness=0.2)}
DIRECTIONS = [(0.3, 0.0, 0.4), (0.5, 0.2, 0.5), (1.0, 2.0, 0.3), (0.2, 1.0, 1.1), (1.2, 0.1, 1.2), (1.1, 3.0, 1.2)]


def rendered(close):
    """f cos(theta_i), 1/sr, by Cycles at `DIRECTIONS`: theta_i, the azimuth from the mirror direction, theta_o."""
    scene = stage.black_scene(4, 4, 1, span=0.1)
    material, node, surface = stage.blank_material("principled", "ShaderNodeBsdfPrincipled")
    for name, value in export_surface.inputs(close, np.asarray).items():
        node.inputs[name].default_value = value
    material.node_tree.links.new(node.outputs[0], surface)
    bpy.ops.mesh.primitive_plane_add()
    plane = bpy.context.object
    plane.data.materials.append(material)
    lamp = stage.add_lamp("SUN", 1.0, angle=0.0)
    found = []
    for theta_i, phi, theta_o in DIRECTIONS:
        plane.rotation_euler = 0, theta_o, 0            # the camera is above, in the plane's direction -x
        x, y, z = math.sin(theta_i) * math.cos(phi), math.sin(theta_i) * math.sin(phi), math.cos(theta_i)
        toward = x * math.cos(theta_o) + z * math.sin(theta_o), y, z * math.cos(theta_o) - x * math.sin(theta_o)
        lamp.rotation_euler = stage.rotation_toward(toward)
        found.append(stage.render(scene)[2, 2, :3])
    return np.array(found)


@pytest.mark.parametrize("name", BSDFS)
def test_cycles_renders_what_is_fitted_with_the_inputs_that_are_exported(name):
    theta_i, phi, theta_o = np.transpose(DIRECTIONS)
    expected = BSDFS[name].evaluate(theta_i, phi, theta_o, np.pi) * np.cos(theta_i)[:, None]
    np.testing.assert_allclose(rendered(BSDFS[name]), expected, rtol=0.04)
