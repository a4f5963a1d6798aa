"""How the material is rendered, and the settings of the scene that change how measured materials look."""

import bpy

from ..annotations import present
from ..materials import checks, rendered
from ..materials import material as materials
from ..materials.properties import AUTOMATIC, RENDERINGS
from ..operators.checks import MEASUREDBRDF_OT_fix_setting
from ..operators.rendering import MEASUREDBRDF_OT_enable_osl, MEASUREDBRDF_OT_use_method
from .layout import MaterialPanel, choices, draw_wrapped, fits


class MEASUREDBRDF_PT_rendering(MaterialPanel, bpy.types.Panel):
    """Exact or Nodes, and a list of wrong settings, each with a Fix button"""

    bl_label = "Rendering"
    bl_parent_id = "MEASUREDBRDF_PT_material"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.material is not None and materials.is_shown(context.material)

    def draw(self, context: bpy.types.Context) -> None:
        layout, material, scene = present(self.layout), present(context.material), present(context.scene)
        chosen = materials.rendering_of(material)
        buttons = choices(layout, [label for _, label, _ in RENDERINGS])
        for key, label, _ in RENDERINGS:
            buttons.operator(MEASUREDBRDF_OT_use_method.bl_idname, text=label, depress=chosen == key).method = key
        found = rendered.in_scene(material, scene)
        as_chosen = found.how == chosen or (chosen == AUTOMATIC and found.how != rendered.BLACK)
        draw_wrapped(layout, rendered.sentence(found, chosen), "INFO" if as_chosen else "ERROR")
        if found.can_enable:
            layout.operator(MEASUREDBRDF_OT_enable_osl.bl_idname)
        findings = checks.check(scene)
        if not findings:
            draw_wrapped(layout, "No setting of this scene changes the look", "CHECKMARK")
        for finding in findings:
            column = layout.box().column(align=True)
            draw_wrapped(column, finding.message)
            if finding.fix is not None:
                text = finding.change
                if not fits(text):
                    draw_wrapped(column, text, "DOT")
                    text = "Fix"
                column.operator(MEASUREDBRDF_OT_fix_setting.bl_idname, text=text).key = finding.key
