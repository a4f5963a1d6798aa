"""What is asked about mixes of materials: the slice `mix` answers, and without it there are none."""

from contextlib import AbstractContextManager, nullcontext

import bpy


class Mixes:
    """What is known of mixes where there are none."""

    def mix(self, _first: bpy.types.Material, _second: bpy.types.Material, _factor: float,
            _mask: bpy.types.Image | None, _context: bpy.types.Context, /) -> bpy.types.Material:
        """Make a material that mixes two, by a factor or by the brightness of an image."""
        raise ValueError("The part of the extension that mixes materials is not there")

    @staticmethod
    def is_mix(_tree: bpy.types.NodeTree | None, /) -> bool:
        return False

    @staticmethod
    def count(_tree: bpy.types.NodeTree, /) -> int:
        return 0

    def parts(self, _node: bpy.types.Node) -> tuple[bpy.types.Material | None, bpy.types.Material | None, float | None]:
        """What the node of a mix mixes, None for what has been deleted; the share of the second, None with a mask."""
        return None, None, None

    @staticmethod
    def factor(_node: bpy.types.Node, /) -> bpy.types.NodeSocket:
        """The input of a mix's node that says the share of the second material."""
        raise LookupError("not the node of a mix")

    @staticmethod
    def nodes(_node: bpy.types.Node, /) -> tuple[bpy.types.Node, ...]:
        """The nodes inside of a mix's that show the first and the second material."""
        return ()

    @staticmethod
    def following(_material: bpy.types.Material, _before: bpy.types.NodeTree | None,
                  _after: bpy.types.NodeTree, /) -> AbstractContextManager[None]:
        """Give mixes of a material its new group in the place of the former; if the block raises, the former again."""
        return nullcontext()

    def holders(self, _material: bpy.types.Material) -> list[bpy.types.Material]:
        """The materials of this file that mix a material with another that is there, and those that mix these."""
        return []


mixes = Mixes()
