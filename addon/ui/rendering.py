"""Exact or Fast, and the settings of the scene that change how measured materials look."""

import bpy

from ..annotations import present
from ..materials import checks, node_group
from ..materials import material as materials
from ..operators.checks import MEASUREDBRDF_OT_fix_setting
from ..operators.rendering import METHODS, MEASUREDBRDF_OT_use_method
from .layout import MaterialPanel, draw_wrapped


class MEASUREDBRDF_PT_rendering(MaterialPanel, bpy.types.Panel):
    """Exact or Fast, and a list of wrong settings, each with a Fix button"""

    bl_label = "Rendering"
    bl_parent_id = "MEASUREDBRDF_PT_material"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.material is not None and materials.exact_input(context.material) is not None

    def draw(self, context: bpy.types.Context) -> None:
        layout, material = present(self.layout), present(context.material)
        exact = present(materials.exact_input(material)).default_value
        row = layout.row(align=True)
        for key, label, _ in METHODS:
            row.operator(MEASUREDBRDF_OT_use_method.bl_idname, text=label,
                         depress=exact == (key == "EXACT")).method = key
        tree = present(materials.group_node(material)).node_tree
        misplaced = tree.get(node_group.FAST_ERROR, 0)
        worst = tree.get(node_group.FAST_WORST, misplaced)
        draw_wrapped(layout, f"Fast reflects {misplaced:.1%} of the light in wrong directions, seen at the worst angle "
                             f"{worst:.1%}")
        findings = checks.check(present(context.scene))
        if not findings:
            layout.label(text="No setting of this scene changes the look", icon="CHECKMARK")
        for finding in findings:
            column = layout.box().column(align=True)
            draw_wrapped(column, finding.message)
            if finding.fix is not None:
                column.operator(MEASUREDBRDF_OT_fix_setting.bl_idname, text=finding.change).key = finding.key
