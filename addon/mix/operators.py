"""Mixes two measured materials into a new one, by a factor or by a mask."""

import bpy
from bpy.props import FloatProperty, StringProperty

from ..core.annotations import OperatorResult, not_none
from ..core.blender import targets
from ..core.blender.active_material import active_material
from ..core.blender.transaction import new_data_removed_on_error
from ..core.shading import compiler
from ..core.shading import material as materials
from ..panel.layout import name_beside_value
from . import mix_group
from .mixed import mix

_DIALOG = 320               # pixels


def _material_names() -> list[str]:
    """The names of measured materials; a linked one may have that of another, which hides it."""
    return [*dict.fromkeys(item.name for item in bpy.data.materials if materials.is_shown(item))]


class MEASUREDBRDF_OT_mix(bpy.types.Operator):
    """Make a material of two measured ones, mixed by a factor or by a mask. It renders in every engine"""

    bl_idname = "measured_brdf.mix"
    bl_label = "Mix Measured BRDFs"
    bl_options = {"REGISTER", "UNDO"}

    first: StringProperty(name="Base", description="A measured material")
    second: StringProperty(name="On Top", description="The measured material that the factor or the mask adds")
    factor: FloatProperty(name="Factor", default=0.5, min=0, max=1, subtype="FACTOR",
                          description="Share of the material On Top")
    mask: StringProperty(name="Mask", description="Image whose brightness is the share of the material On Top. Empty: "
                                                  "the factor, everywhere")

    @classmethod
    def poll(cls, _context: bpy.types.Context) -> bool:
        if len(_material_names()) < 2:
            cls.poll_message_set("There are fewer than two measured materials in this file")
            return False
        return True

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> OperatorResult:
        known = _material_names()
        active = active_material(context)
        if self.first not in known:
            self.first = active.name if active is not None and active.name in known else known[0]
        if self.second not in known or self.second == self.first:
            self.second = next(name for name in known if name != self.first)
        return context.window_manager.invoke_props_dialog(self, width=_DIALOG, confirm_text="Mix")

    def draw(self, _context: bpy.types.Context) -> None:
        layout = not_none(self.layout)
        name_beside_value(layout)
        for name in ("first", "second"):
            layout.prop_search(self, name, bpy.data, "materials")
        layout.prop_search(self, "mask", bpy.data, "images")
        row = layout.row()
        row.active = not self.mask
        row.prop(self, "factor")

    def execute(self, context: bpy.types.Context) -> OperatorResult:
        chosen = [bpy.data.materials.get(name) for name in (self.first, self.second)]
        for name, item in zip((self.first, self.second), chosen, strict=True):
            if item is None or not materials.is_shown(item):
                self.report({"ERROR"}, f"{name or 'No name'!r} is not a measured material of this file")
                return {"CANCELLED"}
        mask = bpy.data.images.get(self.mask) if self.mask else None
        if self.mask and mask is None:
            self.report({"ERROR"}, f"{self.mask!r} is not an image of this file")
            return {"CANCELLED"}
        first: bpy.types.Material = not_none(chosen[0])
        second: bpy.types.Material = not_none(chosen[1])
        left = {item.name: mix_group.left_behind(not_none(materials.surface_node(item))) for item in (first, second)}
        try:
            with new_data_removed_on_error():
                mixed = mix(first, second, self.factor, mask, context)
                if why := targets.assign_all(targets.list_selected(context), mixed):
                    mixed.use_fake_user = True
                    self.report({"WARNING"}, f"{mixed.name} is not assigned: {why}")
                # as `mix_group.keep`; no call may follow the assignment, which is not taken back
                first.use_fake_user = first.use_fake_user or first.library is None
                second.use_fake_user = second.use_fake_user or second.library is None
        except (compiler.CompileError, ValueError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        for name, inputs in left.items():
            if inputs:
                self.report({"WARNING"}, f"{', '.join(inputs)} of the node of {name} stays there: set or connect it at "
                                         "the node of the mix")
        self.report({"INFO"}, f"{mixed.name} mixes {self.first} and {self.second}")
        return {"FINISHED"}


classes = (MEASUREDBRDF_OT_mix,)
