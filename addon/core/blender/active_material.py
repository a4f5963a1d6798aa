"""The material that an operator works on."""

import bpy


def active_material(context: bpy.types.Context) -> bpy.types.Material | None:
    """The material that the properties editor shows, else the one of the active object, else None."""
    shown = getattr(context, "material", None)
    return shown if shown is not None or context.object is None else context.object.active_material


def can_change(item: bpy.types.ID) -> bool:
    """Whether a data-block belongs to this file and overrides none of another: a material can get another shader."""
    return item.is_editable and item.override_library is None


def is_editable(cls: type[bpy.types.Operator], context: bpy.types.Context) -> bool:
    """For `poll`: whether there is a material that can get another shader."""
    target = active_material(context)
    if target is None or not can_change(target):
        cls.poll_message_set("There is no active material, or it belongs to another file: make it local first "
                             "(Object > Relations > Make Local)")
        return False
    return True
