"""Compiles the shaders of library materials, which have none, when objects use them in a window.

Until then closure nodes show them, and so they do where another file owns the material. It is no step of its own for
undo: what is taken back is compiled again.
"""

from collections import defaultdict

import bpy
from bpy.app.handlers import persistent

from ...fitter import DatasetError
from ...fitter.cycles.bake import bake
from ...fitter.library import ready
from ...fitter.model.published import parse_virtual_path
from ..core.annotations import not_none
from ..core.blender import osl_support
from ..core.shading import compiler, node_group
from ..core.shading import material as materials
from ..work import tasks

_DELAY = 0.1                # s, until the drop has become an undo step
_failed: set[int] = set()   # session_uid of node groups


def compile_used() -> int:
    """Compile the shaders of library materials that objects use: how many."""
    waiting = defaultdict(list)
    for item in bpy.data.materials:
        if _is_waiting(item):
            waiting[not_none(materials.group_node(item)).node_tree].append(item)
    for tree, users in waiting.items():
        name = not_none(parse_virtual_path(users[0].measured_brdf.filepath))
        try:
            made = ready.find(name)
            if tasks.kept_bytes(made.fit) == node_group.kept_fit(tree):
                shader = compiler.compile_shader(bake(made.fit, mixture=made.nodes.cycles), made.nodes,
                                                 node_group.kept_fit(tree))
                materials.replace_shader(users, shader, bpy.context)
                continue
        except (compiler.CompileError, DatasetError):       # Update, in the panel, says why
            pass
        _failed.add(tree.session_uid)
    return len(waiting)


def _is_waiting(material: bpy.types.Material) -> bool:
    name = parse_virtual_path(material.measured_brdf.filepath)
    if name is None or not material.is_editable or material.override_library is not None:
        return False
    node = materials.group_node(material)
    return (node is not None and not node_group.is_compiled(node.node_tree) and node.node_tree.is_editable
            and node.node_tree.session_uid not in _failed and ready.is_there(name)
            and any(slot.material == material for item in bpy.context.scene.objects for slot in item.material_slots))


def _tick() -> None:
    compile_used()


@persistent
def _on_change(_scene: object, depsgraph: bpy.types.Depsgraph) -> None:
    if bpy.app.background or not (depsgraph.id_type_updated("OBJECT") or depsgraph.id_type_updated("MATERIAL")):
        return
    _compile_soon()


@persistent
def _on_load(_file: object) -> None:
    _failed.clear()
    if not bpy.app.background:
        _compile_soon()


def _compile_soon() -> None:
    if len(bpy.data.materials) and not osl_support.reason_unavailable() and not bpy.app.timers.is_registered(_tick):
        bpy.app.timers.register(_tick, first_interval=_DELAY, persistent=True)


handlers = {"depsgraph_update_post": _on_change, "load_post": _on_load}


def unregister() -> None:
    if bpy.app.timers.is_registered(_tick):
        bpy.app.timers.unregister(_tick)
    _failed.clear()
