"""The studio of thumbnails (`fitter.imaging.studio`) as a world: a window, a narrow light, a reflector below, walls.

It is an image that is packed into the .blend, turned about the vertical so that the camera sees what thumbnails show.
"""

import math

import bpy
import numpy as np
from mathutils import Vector

from ....fitter.imaging.studio import radiance
from ..annotations import not_none
from ..blender.node_trees import use_nodes
from .world_lights import directions

STUDIO_NAME = "Measured BRDF Studio"
_WORLD_HEIGHT = 160         # texels: the soft edge of the window is two of them wide, and the .blend gets 0.6 MB
_FRONT = 0.0, -1.0, 0.0     # where the viewer is in the image


def is_plain(world: bpy.types.World | None) -> bool:
    tree = None if world is None else world.node_tree
    output = None if tree is None else tree.get_output_node("ALL")
    links = () if output is None else not_none(output.inputs["Surface"].links)
    return all(link.from_node.type == "BACKGROUND" and not link.from_node.inputs["Color"].is_linked for link in links)


def add(scene: bpy.types.Scene, toward: Vector) -> bpy.types.World:
    """Make the studio the world of a scene, seen by a viewer in a direction from the origin; the former is kept."""
    if scene.world is not None and scene.world.library is None:
        scene.world.use_fake_user = True
    world = bpy.data.worlds.new(STUDIO_NAME)
    tree = use_nodes(world)
    tree.nodes.clear()
    place, turn, picture, background, output = (tree.nodes.new(f"ShaderNode{kind}") for kind in (
        "TexCoord", "Mapping", "TexEnvironment", "Background", "OutputWorld"))
    picture.image = _image()
    turn.inputs["Rotation"].default_value = (0, 0, math.atan2(_FRONT[1], _FRONT[0]) - math.atan2(toward.y, toward.x))
    for source, target in ((place.outputs["Generated"], turn.inputs["Vector"]),
                           (turn.outputs["Vector"], picture.inputs["Vector"]),
                           (picture.outputs["Color"], background.inputs["Color"]),
                           (background.outputs["Background"], output.inputs["Surface"])):
        tree.links.new(source, target)
    for step, node in enumerate((place, turn, picture, background, output)):
        node.location = 300 * step - 900, 0
    scene.world = world
    return world


def viewer(scene: bpy.types.Scene, view: bpy.types.RegionView3D | None) -> Vector:
    """The direction toward the camera of a scene, else toward that of a viewport, else the front."""
    turned = scene.camera.matrix_world if scene.camera is not None else None if view is None else (
        view.view_matrix.inverted())
    toward = Vector(_FRONT) if turned is None else turned.to_3x3() @ Vector((0, 0, 1))
    return toward if toward.xy.length > 1e-3 else Vector(_FRONT)


def _image() -> bpy.types.Image:
    image = bpy.data.images.new(STUDIO_NAME, 2 * _WORLD_HEIGHT, _WORLD_HEIGHT, float_buffer=True)
    # in the studio y is up, and z toward the viewer
    seen = radiance(directions(_WORLD_HEIGHT, 2 * _WORLD_HEIGHT)[..., [0, 2, 1]] * (1, 1, -1))
    pixels = np.insert(np.repeat(seen[..., None], 3, axis=2), 3, 1, axis=2)
    not_none(image.pixels).foreach_set(pixels.astype(np.float32).ravel())
    image.pack()
    return image
