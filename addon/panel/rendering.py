"""How the material is rendered, and the settings of the scene that change how measured materials look."""

from collections.abc import Callable

import bpy
from bpy.props import EnumProperty

from ..core import checks
from ..core.annotations import OperatorResult, not_none
from ..core.blender import osl_support
from ..core.blender.active_material import active_material, is_editable
from ..core.lamps import studio_world
from ..core.shading import export_surface, node_group, rendered
from ..core.shading import material as materials
from ..core.storage.properties import AUTOMATIC, RENDERINGS
from .fixes import MEASUREDBRDF_OT_fix_setting
from .layout import SubPanel, choices, draw_wrapped, fits

export_buttons: list[Callable[[bpy.types.UILayout], None]] = []
"""Draw how a material leaves Blender by another way than its exporters."""


class MEASUREDBRDF_OT_enable_osl(bpy.types.Operator):
    """Render this scene with Cycles and Open Shading Language, which renders measured materials exactly"""

    bl_idname = "measured_brdf.enable_osl"
    bl_label = "Enable OSL"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context: bpy.types.Context) -> OperatorResult:
        reason = osl_support.reason_unavailable()
        if reason:
            self.report({"ERROR"}, reason)
            return {"CANCELLED"}
        osl_support.enable(not_none(context.scene))
        return {"FINISHED"}


class MEASUREDBRDF_OT_add_studio(bpy.types.Operator):
    """Light this scene by the studio of the library's pictures: a window, a narrow light, a reflector from below and \
walls, as its world. Metals and smooth materials show them. The former world stays in the file"""

    bl_idname = "measured_brdf.add_studio"
    bl_label = "Add Studio"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context: bpy.types.Context) -> OperatorResult:
        scene = not_none(context.scene)
        world = studio_world.add(scene, studio_world.viewer(scene, context.region_data))
        self.report({"INFO"}, f"The world is {world.name}")
        return {"FINISHED"}


class MEASUREDBRDF_OT_use_method(bpy.types.Operator):
    """Choose how this material is rendered"""

    bl_idname = "measured_brdf.use_method"
    bl_label = "Use Method"
    bl_options = {"UNDO", "INTERNAL"}

    method: EnumProperty(items=RENDERINGS)

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        target = active_material(context)
        return target is not None and materials.is_shown(target) and is_editable(cls, context)

    @classmethod
    def description(cls, _context: bpy.types.Context, properties: "MEASUREDBRDF_OT_use_method") -> str:
        return next(text for key, _, text in RENDERINGS if key == properties.method)

    def execute(self, context: bpy.types.Context) -> OperatorResult:
        materials.use_rendering(not_none(active_material(context)), self.method)
        return {"FINISHED"}


class MEASUREDBRDF_PT_rendering(SubPanel, bpy.types.Panel):
    """Exact or Nodes, and a list of wrong settings, each with a Fix button"""

    bl_label = "Rendering"
    bl_order = 50

    def draw(self, context: bpy.types.Context) -> None:
        layout, material, scene = not_none(self.layout), not_none(context.material), not_none(context.scene)
        chosen = materials.get_rendering(material)
        buttons = choices(layout, [label for _, label, _ in RENDERINGS])
        for key, label, _ in RENDERINGS:
            buttons.operator(MEASUREDBRDF_OT_use_method.bl_idname, text=label, depress=chosen == key).method = key
        now = rendered.scene_rendering(material, scene)
        as_chosen = chosen in (AUTOMATIC, now.how)
        draw_wrapped(layout, rendered.sentence(now, chosen), "INFO" if as_chosen else "ERROR")
        if now.can_enable:
            layout.operator(MEASUREDBRDF_OT_enable_osl.bl_idname)
        if below := rendered.subsurface_message(material, scene):
            draw_wrapped(layout, below, "INFO")
            layout.prop(not_none(materials.surface_node(material)).inputs[node_group.SCALE_INPUT], "default_value",
                        text="Metres per Unit")
        findings = checks.check(scene, material)
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
        if losses := export_surface.losses(material):
            draw_wrapped(layout, "In other programs, a Principled BSDF:", "INFO")
            for line in losses:
                draw_wrapped(layout, line, "DOT")
        for draw_exporting in export_buttons:
            draw_exporting(layout)


def draw_words(layout: bpy.types.UILayout, context: bpy.types.Context, material: bpy.types.Material) -> None:
    """Say in a line how a material is rendered, and offer OSL where that helps."""
    now = rendered.scene_rendering(material, not_none(context.scene))
    row = layout.row(align=True)
    row.label(text=rendered.rendering_words(now, _is_previewed(context)), icon="SHADING_RENDERED")
    if now.can_enable:
        row.operator(MEASUREDBRDF_OT_enable_osl.bl_idname)
    world = not_none(context.scene).world
    # metals and smooth surfaces show what is around them, and here there is nothing
    if studio_world.is_plain(world) and any(map(export_surface.is_reflective, materials.measured_parts(material))):
        layout.operator(MEASUREDBRDF_OT_add_studio.bl_idname, icon="WORLD")


def _is_previewed(context: bpy.types.Context) -> bool:
    """Whether a 3-D viewport of the window shows Material Preview, which is EEVEE's."""
    areas = context.screen.areas if context.screen is not None else ()
    return any(area.type == "VIEW_3D" and area.spaces.active.shading.type == "MATERIAL" for area in areas)


classes = (MEASUREDBRDF_OT_enable_osl, MEASUREDBRDF_OT_add_studio, MEASUREDBRDF_OT_use_method,
           MEASUREDBRDF_PT_rendering)
