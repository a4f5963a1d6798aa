"""Materials that mix two measured ones, and what the rest of the extension asks about them."""

from collections.abc import Iterator

import bpy
import numpy as np

from ..core.annotations import not_none
from ..core.blender import followers
from ..core.blender.node_trees import use_nodes
from ..core.blender.transaction import new_data_removed_on_error
from ..core.shading import export_surface, mixing
from ..core.shading import material as materials
from . import mix_group


def mix(first: bpy.types.Material, second: bpy.types.Material, factor: float, mask: bpy.types.Image | None,
        context: bpy.types.Context) -> bpy.types.Material:
    """Make a material that mixes two that show measured BRDFs, by a factor or by the brightness of an image.

    Raises ValueError if there would be too many in it, CompileError if this Blender cannot compile the shader of their
    shares; the file then stays as it was.
    """
    with new_data_removed_on_error():
        nodes = [not_none(materials.surface_node(item)) for item in (first, second)]
        mixed = bpy.data.materials.new(f"{first.name} + {second.name}")
        tree = use_nodes(mixed)
        tree.nodes.clear()
        node = materials.show(mixed, mix_group.create(first, nodes[0], second, nodes[1], factor))
        node.inputs[mix_group.FACTOR_INPUT].default_value = factor
        for each in tree.nodes:
            each.select = each == node
        tree.nodes.active = node
        if mask is not None:
            picture = tree.nodes.new("ShaderNodeTexImage")
            picture.image, picture.location = mask, (node.location.x - 320, node.location.y)
            tree.links.new(picture.outputs["Color"], node.inputs[mix_group.FACTOR_INPUT])
        mixed.cycles.use_bump_map_correction = False
        weights = np.array([1 - factor, factor])
        mixed.diffuse_color = weights @ np.array([item.diffuse_color for item in (first, second)])
        mixed.roughness, mixed.metallic = (float(weights @ [getattr(item, name) for item in (first, second)])
                                           for name in ("roughness", "metallic"))
        export_surface.mix(mixed, node)
        followers.tell(context)
    return mixed


class Mixes(mixing.Mixes):
    """What `core.shading.mixing` asks."""

    mix = staticmethod(mix)
    is_mix = staticmethod(mix_group.is_mix)
    count = staticmethod(mix_group.count)
    nodes = staticmethod(mix_group.nodes)
    following = staticmethod(mix_group.following)

    def parts(self, node: bpy.types.Node) -> tuple[bpy.types.Material | None, bpy.types.Material | None, float | None]:
        factor = self.factor(node)
        first, second = mix_group.parts(not_none(node.node_tree))
        return first, second, None if factor.is_linked else factor.default_value

    @staticmethod
    def factor(node: bpy.types.Node) -> bpy.types.NodeSocket:
        return node.inputs[mix_group.FACTOR_INPUT]

    def holders(self, material: bpy.types.Material) -> list[bpy.types.Material]:
        waiting = [material]
        for part in waiting:
            waiting += [item for item in _list_mixes(part) if item not in waiting]
        return waiting[1:]


def _list_mixes(part: bpy.types.Material) -> Iterator[bpy.types.Material]:
    """The materials of this file that mix a material with another that is there."""
    for item in bpy.data.materials:
        node = materials.mix_node(item) if item.is_editable else None
        if node is not None:
            pair = mix_group.parts(not_none(node.node_tree))
            if part in pair and None not in pair:
                yield item


def register() -> None:
    mixing.mixes = Mixes()


def unregister() -> None:
    mixing.mixes = mixing.Mixes()
