"""Bakes a measured material for games and other programs."""

import os
import tempfile
from pathlib import Path

import bpy
from bpy.props import IntProperty, StringProperty

from ...fitter.quality import verdict
from ..core.annotations import OperatorResult, not_none
from ..core.blender.active_material import active_material
from ..core.blender.transaction import new_data_removed_on_error
from ..core.shading import export_surface
from ..panel.layout import has_measured, name_beside_value
from .maps import COLOUR, Maps, bake

_BAKED = "measured_brdf_baked"      # custom property of images that were baked
_DIALOG = 320               # pixels


class MEASUREDBRDF_OT_bake_pbr(bpy.types.Operator):
    """Make images of base color, roughness, metallic and normal of this material, for games and other programs, and \
say how far they are from the measurement"""

    bl_idname = "measured_brdf.bake_pbr"
    bl_label = "Bake Measured Material"
    bl_options = {"REGISTER", "UNDO"}

    size: IntProperty(name="Size", default=1024, min=1, max=8192, soft_min=64, description="Pixels on a side")
    directory: StringProperty(name="Folder", subtype="DIR_PATH",
                              description="Where the images are also written, as PNG. Empty: nowhere but into this "
                                          ".blend")

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return has_measured(cls, context)

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> OperatorResult:
        return context.window_manager.invoke_props_dialog(self, width=_DIALOG, confirm_text="Bake")

    def draw(self, _context: bpy.types.Context) -> None:
        layout = not_none(self.layout)
        name_beside_value(layout)
        layout.prop(self, "size")
        layout.prop(self, "directory")

    def execute(self, context: bpy.types.Context) -> OperatorResult:
        target = not_none(active_material(context))
        try:
            with new_data_removed_on_error():
                maps = bake(target, self.size)
                images = _images(target.name, maps)
                written = _write(images, bpy.path.abspath(self.directory)) if self.directory else []
                names = _replace_former(images)
        except (ValueError, OSError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        for line in maps.lost:
            self.report({"WARNING"}, f"{target.name}: {line}")
        mean, most = float(maps.errors.mean()), float(maps.errors.max())
        farthest = f", {most:.1f} where the images are farthest" if len(maps.errors) > 1 else ""
        message = f"On a sphere {mean:.1f} steps of lightness from the measurement's fit{farthest}"
        judged = verdict.grade_message(message, most, verdict.MATCH_LIMITS)
        self.report({"WARNING"} if judged.is_bad else {"INFO"}, judged.words)
        self.report({"INFO"}, f"Baked {', '.join(written or names)}")
        return {"FINISHED"}


def _images(name: str, maps: Maps) -> dict[str, bpy.types.Image]:
    """New images, packed into the file, by the names that they are to have."""
    images = {}
    for kind, picture in maps.pictures.items():
        image = export_surface.new_image(f"{name} {kind}", picture, is_data=kind != COLOUR)
        image.file_format = "PNG"
        image.pack()
        image.use_fake_user = True
        images[bpy.path.clean_name(f"{name} {kind}")] = image
    return images


def _write(images: dict[str, bpy.types.Image], folder: str) -> list[str]:
    """Write images into a folder: all of them or none. Their paths."""
    if not os.path.isdir(folder):
        raise OSError(f"{folder}: no such folder")
    with tempfile.TemporaryDirectory(dir=folder) as made:
        parts = {Path(made, f"{name}.png"): image for name, image in images.items()}
        for path, image in parts.items():
            image.save(filepath=str(path), save_copy=True)
        for path in parts:
            os.replace(path, Path(folder, path.name))
    return [str(Path(folder, path.name)) for path in parts]


def _replace_former(images: dict[str, bpy.types.Image]) -> list[str]:
    """Give the names and users of former images of the same material to the new ones: their names."""
    for name, image in images.items():
        image[_BAKED] = True
        former = bpy.data.images.get(name)
        if former is not None and former != image and former.get(_BAKED) and former.library is None:
            former.user_remap(image)
            bpy.data.images.remove(former)
            image.name = name
    return [image.name for image in images.values()]


classes = (MEASUREDBRDF_OT_bake_pbr,)
