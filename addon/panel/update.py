"""Materials from elsewhere: those of an older version are updated, those of another file made local."""

from collections.abc import Sequence
from functools import partial

import bpy

from ..core.annotations import OperatorResult, not_none
from ..core.blender.active_material import active_material, can_change
from ..core.blender.transaction import find_by_session_uid
from ..core.shading import compiler, material
from ..core.storage import paths
from ..core.storage.outcomes import EmbeddedFit
from ..work import process, queries, tasks
from ..work.modal import InBackground, Steps


class MEASUREDBRDF_OT_update_materials(InBackground, bpy.types.Operator):
    """Update the shaders of all measured materials of this file that an older version made. \
The fits do not change, and the measurements are not needed"""

    bl_idname = "measured_brdf.update_materials"
    bl_label = "Update Measured Materials"
    bl_options = {"REGISTER", "UNDO"}

    def work(self, _context: bpy.types.Context) -> process.Calculation:
        outdated = [item for item in bpy.data.materials if item.is_editable and material.is_outdated(item)]
        if not outdated:
            raise ValueError("All measured materials of this file are up to date")
        fits: dict[int, tuple[EmbeddedFit, list[int]]] = {}
        for item in outdated:           # copies of a material, and materials of one fit, share a shader
            tree = not_none(material.group_node(item)).node_tree
            if tree.session_uid not in fits:
                fits[tree.session_uid] = not_none(queries.embedded_fit(item)), []
            fits[tree.session_uid][1].append(item.session_uid)
        self._users = [users for _, users in fits.values()]
        return process.Calculation(partial(tasks.rebake, [kept for kept, _ in fits.values()]))

    def prepare(self, rebaked: Sequence[tasks.Rebaked | ValueError]) -> Steps:
        prepared: list[compiler.Shader | ValueError] = []
        for number, made in enumerate(rebaked):
            yield 0.95 + 0.05 * number / len(rebaked), "Compiling"
            prepared.append(made if isinstance(made, Exception) else compiler.compile_shader(*made))
        return prepared

    def apply(self, context: bpy.types.Context, prepared: Sequence[compiler.Shader | ValueError]) -> None:
        updated = 0
        failed: list[str] = []
        for shader, uids in zip(prepared, self._users, strict=True):
            users = [item for uid in uids if (item := find_by_session_uid(bpy.data.materials, uid)) is not None]
            if isinstance(shader, Exception):
                failed += [f"{item.name}: {shader}. Refit it instead" for item in users]
            elif users:
                material.replace_shader(users, shader, context)
                updated += len(users)
        if failed and not updated:
            raise ValueError("; ".join(failed))
        for message in failed:
            self.report({"WARNING"}, message)
        self.report({"INFO"}, f"{updated} material{'s' * (updated != 1)} updated")


class MEASUREDBRDF_OT_make_local(bpy.types.Operator):
    """Make this material part of this file, so that it can be changed. Its file stays as it is"""

    bl_idname = "measured_brdf.make_local"
    bl_label = "Make Local"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        target = active_material(context)
        return target is not None and not can_change(target)

    def execute(self, context: bpy.types.Context) -> OperatorResult:
        target = not_none(active_material(context))
        path = paths.absolute(target)
        target.make_local(clear_liboverride=True).measured_brdf.filepath = path
        return {"FINISHED"}


classes = (MEASUREDBRDF_OT_update_materials, MEASUREDBRDF_OT_make_local)
