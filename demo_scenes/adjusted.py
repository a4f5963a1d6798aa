"""The picture of what can be changed of a measured material: ``python -m demo_scenes.adjusted PNG``."""

import bpy

from support import sheet
from support.stage import group_node, render

from . import gallery, run

SIZE = 224
PAINT, FABRIC, GOLD = "published:specular-blue-phenolic", "published:red-fabric", "published:gold-metallic-paint"
# caption, file, and settings of its material
ADJUSTED = (
    ("as measured", GOLD, {}),
    ("highlight width 0.4", GOLD, {"highlight_width": 0.4}),
    ("highlight width 3", GOLD, {"highlight_width": 3.0}),
    ("highlight tinted", GOLD, {"highlight_gain": 1.4, "highlight_tint": (0.4, 0.75, 1.0)}),
    ("diffuse tinted", PAINT, {"diffuse_tint": (3.0, 1.6, 0.12)}),
    ("as measured", FABRIC, {}),
    ("coat 1", FABRIC, {"coat": 1.0, "coat_roughness": 0.15}),
)


def draw(path):
    tiles = []
    for text, file, settings in ADJUSTED:
        _stage()
        adjust(_import(file), settings)
        tiles.append(_tile(text))
    _stage()
    first, second = _import(FABRIC), _import(GOLD)
    bpy.ops.measured_brdf.mix(first=first.name, second=second.name)
    mixed = bpy.context.object.active_material
    noise = mixed.node_tree.nodes.new("ShaderNodeTexNoise")
    noise.inputs["Scale"].default_value = 2.5
    steep = mixed.node_tree.nodes.new("ShaderNodeMapRange")
    steep.inputs["From Min"].default_value, steep.inputs["From Max"].default_value = 0.48, 0.52
    links = mixed.node_tree.links
    links.new(noise.outputs[0], steep.inputs["Value"])
    links.new(steep.outputs["Result"], group_node(mixed).inputs["Factor"])
    tiles.append(_tile("mixed by a mask with gold paint"))
    sheet.write(path, [tiles[:4], tiles[4:]])


def adjust(material, settings):
    """Move sliders of the active material and have it rendered so."""
    for name, value in settings.items():
        setattr(material.measured_brdf_adjustments, name, value)
    bpy.ops.measured_brdf.adjust()


def _stage():
    scene = gallery.stage()
    scene.render.resolution_x = scene.render.resolution_y = SIZE


def _import(file):
    bpy.ops.measured_brdf.import_data(filepath=file, preset="Standard")
    return bpy.context.object.active_material


def _tile(text):
    # the sheet is scene-linear: as bright as the gallery's exposure makes it
    picture = render(bpy.context.scene).copy()
    picture[..., :3] *= 2 ** bpy.context.scene.view_settings.exposure * 0.6
    return sheet.tile(picture, text)


if __name__ == "__main__":
    run(draw, "adjusted.png")
