"""What an export loses of measured materials, in the dialogs of the exporters."""

import bpy

from ..core.annotations import not_none
from ..core.shading.export_follow import lost_in
from .layout import draw_wrapped

_EXPORTERS = ("EXPORT_SCENE_OT_gltf", "WM_OT_usd_export", "WM_OT_obj_export", "EXPORT_SCENE_OT_fbx")


class MEASUREDBRDF_PT_export(bpy.types.Panel):
    """What other programs do not get of the measured materials of this file"""

    bl_label = "Measured BRDFs"
    bl_space_type = "FILE_BROWSER"
    bl_region_type = "TOOL_PROPS"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        operator = getattr(context.space_data, "active_operator", None)
        return operator is not None and operator.bl_idname in _EXPORTERS and bool(_list_losses())

    def draw(self, _context: bpy.types.Context) -> None:
        for line in _list_losses():
            draw_wrapped(not_none(self.layout), line, "INFO")


def _list_losses() -> list[str]:
    return [line for item in bpy.data.materials if item.users for line in lost_in(item)]


classes = (MEASUREDBRDF_PT_export,)
