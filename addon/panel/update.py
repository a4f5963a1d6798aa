"""Updates materials that an older version of the extension made."""

from collections.abc import Sequence
from functools import partial

import bpy

from ..core import compiler, material
from ..core.annotations import OperatorResult, present
from ..core.outcomes import Kept
from ..core.transaction import by_session_uid
from ..work import process, queries, tasks
from ..work.modal import InBackground, Steps

_Users = list[int]          # session_uid of the materials that share a shader


class MEASUREDBRDF_OT_update_materials(InBackground, bpy.types.Operator):
    """Update the shaders of all measured materials of this file that an older version made. \
The fits do not change, and the measurements are not needed"""

    bl_idname = "measured_brdf.update_materials"
    bl_label = "Update Measured Materials"
    bl_options = {"REGISTER", "UNDO"}

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> OperatorResult:
        return self.start(context)

    def execute(self, context: bpy.types.Context) -> OperatorResult:
        return self.run(context)

    def work(self, _context: bpy.types.Context) -> process.Calculation:
        outdated = [item for item in bpy.data.materials if item.is_editable and material.is_outdated(item)]
        if not outdated:
            raise ValueError("All measured materials of this file are up to date")
        fits: dict[int, tuple[Kept, _Users]] = {}
        for item in outdated:           # copies of a material, and materials of one fit, share a shader
            tree = present(material.group_node(item)).node_tree
            if tree.session_uid not in fits:
                fits[tree.session_uid] = present(queries.kept(item)), []
            fits[tree.session_uid][1].append(item.session_uid)
        return process.Calculation(partial(tasks.rebake, list(fits.values())))

    def prepare(self, rebaked: Sequence[tuple[tasks.Rebaked | ValueError, _Users]]) -> Steps:
        prepared: list[tuple[compiler.Shader | ValueError, _Users]] = []
        for number, (made, users) in enumerate(rebaked):
            yield 0.95 + 0.05 * number / len(rebaked), "Compiling"
            prepared.append((made if isinstance(made, Exception) else compiler.compile_shader(*made), users))
        return prepared

    def apply(self, context: bpy.types.Context,
              prepared: Sequence[tuple[compiler.Shader | ValueError, _Users]]) -> None:
        updated = 0
        failed: list[str] = []
        for shader, users in prepared:
            found = [item for uid in users if (item := by_session_uid(bpy.data.materials, uid)) is not None]
            if isinstance(shader, Exception):
                failed += [f"{item.name}: {shader}. Refit it instead" for item in found]
            elif found:
                material.replace_shader(found, shader, context)
                updated += len(found)
        if failed and not updated:
            raise ValueError("; ".join(failed))
        for message in failed:
            self.report({"WARNING"}, message)
        self.report({"INFO"}, f"{updated} materials updated")


classes = (MEASUREDBRDF_OT_update_materials,)
