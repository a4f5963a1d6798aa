"""Starting from published fits: picking one by its picture, and the asset library of all."""

from functools import partial
from pathlib import Path
from typing import Any

import bpy
from bpy.props import EnumProperty, FloatProperty, FloatVectorProperty, PointerProperty, StringProperty

from ...fitter import DatasetError
from ...fitter.library import ready
from ...fitter.library.matching import WINDOWS, Match, match_lines
from ...fitter.model.published import METAL, PREFIX, find
from ...fitter.model.translucent import SURFACE_WIDTHS, TRANSLUCENT
from ...fitter.optics.subsurface import INDICES, LONGEST
from ..core.annotations import Arguments, OperatorResult, not_none
from ..core.blender import osl_support, targets
from ..core.shading import material as materials
from ..core.storage import edits
from ..core.storage.properties import fitted_arguments
from ..core.storage.reading import load_arguments, scene_colours
from ..work import process
from ..work.blender_process import Command
from ..work.making import MakesMaterials
from ..work.modal import AsksForPath, InBackground
from . import shelf, starter, work

_TAG_ITEMS = ((shelf.ALL, "All", "All materials"), *((tag, tag.capitalize(), f"Materials with the tag {tag}")
                                                     for tag in shelf.tags()))

_WINDOW_ITEMS = (("AUTO", "Find Out", "Where the light suits the photograph best"),
                 *((name.upper(), name.capitalize(), f"A window: {name}") for name in WINDOWS))


class MeasuredShelf(bpy.types.PropertyGroup):
    """What the panels show of the starter library and of the data folder."""

    search: StringProperty(name="Search", options={"TEXTEDIT_UPDATE", "SKIP_SAVE"},
                           description="Show the materials whose names or tags hold these words")
    tag: EnumProperty(name="Kind", items=_TAG_ITEMS, default=METAL, options={"SKIP_SAVE"},
                      description="Show the materials of this kind")
    data_search: StringProperty(name="Search", options={"TEXTEDIT_UPDATE", "SKIP_SAVE"},
                                description="Show the measurements whose names hold these words")


class MEASUREDBRDF_OT_use_published(MakesMaterials, bpy.types.Operator):
    """Make a material of a published fit, and assign it to all selected objects"""

    bl_idname = "measured_brdf.use_published"
    bl_label = "Use Library Material"
    bl_options = {"UNDO", "INTERNAL"}

    name: StringProperty(options={"SKIP_SAVE"})
    note: StringProperty(options={"SKIP_SAVE", "HIDDEN"})       # for the tooltip
    diffuse: FloatVectorProperty(size=3, default=(1, 1, 1), min=0, options={"SKIP_SAVE"},
                                 description="Factors of the diffuse part, as Adjust has them")
    highlight: FloatVectorProperty(size=3, default=(1, 1, 1), min=0, options={"SKIP_SAVE"},
                                   description="Factors of the highlight, as Adjust has them")

    @classmethod
    def description(cls, _context: bpy.types.Context, properties: Any) -> str:
        try:
            material = find(properties.name)
        except DatasetError as error:
            return str(error)
        if properties.note:
            return f"{properties.note}. A click adjusts it so, and assigns it to all selected objects"
        return f"{material.label}, assigned to all selected objects. {material.description}"

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> OperatorResult:
        is_quick = not self._edit() and work.is_quick(self.name, scene_colours())
        return self.execute(context) if is_quick else self._use_again(context) or self.start(context)

    def execute(self, context: bpy.types.Context) -> OperatorResult:
        return self._use_again(context) or self.run(context)

    def _use_again(self, context: bpy.types.Context) -> OperatorResult | None:
        """Assign the material of this file that has been made before, if the user has not changed it since."""
        path = PREFIX + self.name
        there = next((item for item in bpy.data.materials if item.measured_brdf.filepath == path
                      and fitted_arguments(item.measured_brdf) == ready.ARGUMENTS and materials.is_as_made(item)), None)
        if there is None or self._edit():
            return None
        self.remember_target(context)
        if why := targets.assign_all(self.all_targets(), there):
            self.report({"WARNING"}, f"{there.name} is not assigned: {why}")
        self.report({"INFO"}, f"{there.name} is in this file, and is used again")
        return {"FINISHED"}

    def work(self, context: bpy.types.Context) -> process.Calculation:
        choices = starter.starter_choices(find(self.name))
        for name, value in vars(choices).items():       # what `MakesMaterials` looks for
            setattr(self, name, value)
        self.remember_target(context)
        return process.Calculation(partial(work.outcomes, self.name, load_arguments(choices), self._edit()))

    def _edit(self) -> Arguments:
        edit: Arguments = {name: [*getattr(self, name)] for name in ("diffuse", "highlight")
                           if tuple(getattr(self, name)) != (1, 1, 1)}
        for sliders in edits.sliders:
            edit = sliders.rounded(edit)
        return edit


class MEASUREDBRDF_OT_translucent_material(bpy.types.Operator):
    """Make a translucent material of coefficients, or of an albedo and a mean free path, for all selected objects"""

    bl_idname = "measured_brdf.translucent_material"
    bl_label = "Translucent Material"
    bl_options = {"REGISTER"}

    label: StringProperty(name="Name", default="Translucent")
    given: EnumProperty(name="Given", items=(
        ("COEFFICIENTS", "Coefficients", "Reduced scattering and absorption, as measurements are published"),
        ("ALBEDO", "Albedo and Path", "The share of light that leaves again, and how far it goes between scattering")))
    scattering: FloatVectorProperty(name="Scattering", size=3, default=(2.19, 2.62, 3.0), min=0, precision=4,
                                    description="Reduced, of red, green and blue light, 1/mm")
    absorption: FloatVectorProperty(name="Absorption", size=3, default=(0.0021, 0.0041, 0.0071), min=0, precision=4,
                                    description="Of red, green and blue light, 1/mm")
    albedo: FloatVectorProperty(name="Albedo", subtype="COLOR", size=3, default=(0.8, 0.8, 0.8), min=0, max=1)
    path: FloatVectorProperty(name="Mean Free Path", size=3, default=(1, 1, 1), min=1e-6, max=LONGEST,
                              description="Of red, green and blue light, mm")
    index: FloatProperty(name="IOR", default=1.3, min=INDICES[0], max=INDICES[1])
    width: FloatProperty(name="Width", default=0.1, min=SURFACE_WIDTHS[0], max=SURFACE_WIDTHS[1],
                         description="Of the slopes of the surface: smooth, 0.01, to matte, 1")

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> OperatorResult:
        return context.window_manager.invoke_props_dialog(self)

    def draw(self, _context: bpy.types.Context) -> None:
        layout = not_none(self.layout)
        layout.use_property_split = True
        for name in ("label", "given", *self._numbers(), "index", "width"):
            layout.prop(self, name)

    def execute(self, _context: bpy.types.Context) -> OperatorResult:
        words = [f"{name} {' '.join(f'{number:.6g}' for number in getattr(self, name))}" for name in self._numbers()]
        words += [f"index {self.index:.6g}", f"width {self.width:.6g}", f"name {self.label.replace(';', ' ')}"]
        called = "EXEC_DEFAULT" if bpy.app.background else "INVOKE_DEFAULT"
        return bpy.ops.measured_brdf.use_published(called, name="; ".join((TRANSLUCENT, *words)))

    def _numbers(self) -> tuple[str, str]:
        return ("scattering", "absorption") if self.given == "COEFFICIENTS" else ("albedo", "path")


class MEASUREDBRDF_OT_match_photograph(AsksForPath, bpy.types.Operator):
    """Find the library's materials that are nearest to a photograph of a ball, cropped to it. They appear in a row \
above the library"""

    bl_idname = "measured_brdf.match_photograph"
    bl_label = "Match a Photograph"
    bl_options = {"REGISTER"}

    path_name = "filepath"
    filepath: StringProperty(subtype="FILE_PATH", options={"SKIP_SAVE"})
    filter_glob: StringProperty(default="*.exr;*.tif;*.tiff;*.png;*.jpg;*.jpeg", options={"HIDDEN"})
    window: EnumProperty(name="Light", items=_WINDOW_ITEMS, default="AUTO",
                         description="Where the window is that the ball was photographed by")

    def draw(self, _context: bpy.types.Context) -> None:
        layout = not_none(self.layout)
        layout.use_property_split = True
        layout.prop(self, "window")

    def work(self, _context: bpy.types.Context) -> process.Calculation:
        osl_support.make_importable("OpenImageIO")
        window = "" if self.window == "AUTO" else self.window.lower()
        return process.Calculation(partial(work.match_photograph, bpy.path.abspath(self.filepath), window))

    def apply(self, _context: bpy.types.Context, result: tuple[str, list[Match]]) -> None:
        shelf.nearest[:] = result[1]
        for line in match_lines(*result):
            self.report({"INFO"}, line)


class MEASUREDBRDF_OT_favourite(bpy.types.Operator):
    """Keep this material in the row of favourites above the library, or take it out. They are in the preferences"""

    bl_idname = "measured_brdf.favourite"
    bl_label = "Favourite"
    bl_options = {"INTERNAL"}

    name: StringProperty(options={"SKIP_SAVE"})

    def execute(self, _context: bpy.types.Context) -> OperatorResult:
        try:
            is_one = shelf.toggle_favourite(self.name)
        except ValueError as error:             # DatasetError too
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self.report({"INFO"}, f"{find(self.name).label} is {'a' if is_one else 'no longer a'} favourite")
        return {"FINISHED"}


class MEASUREDBRDF_OT_add_starter_library(InBackground, bpy.types.Operator):
    """Show the published fits in the Asset Browser: add their library to those of the preferences. Where it is not \
there yet, it is made first, which takes half a minute; some minutes in a checkout"""

    bl_idname = "measured_brdf.add_starter_library"
    bl_label = "Add to Asset Browser"
    bl_options = {"REGISTER"}

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> OperatorResult:
        return self.execute(context) if starter.folder() is not None else self.start(context)

    def execute(self, context: bpy.types.Context) -> OperatorResult:
        folder = starter.folder()
        if folder is None:
            return self.run(context)
        self.apply(context, {"path": str(folder)})
        return {"FINISHED"}

    def work(self, context: bpy.types.Context) -> Command:
        return Command("starter", "-o", starter.own_folder())

    def apply(self, context: bpy.types.Context, result: dict[str, Any]) -> None:
        starter.offer(context, Path(result["path"]))
        self.report({"INFO"}, f"The Asset Browser has the library {starter.LIBRARY_NAME}")


classes = (MeasuredShelf, MEASUREDBRDF_OT_match_photograph, MEASUREDBRDF_OT_use_published, MEASUREDBRDF_OT_favourite,
           MEASUREDBRDF_OT_add_starter_library, MEASUREDBRDF_OT_translucent_material)
pointers = ((bpy.types.WindowManager, "measured_brdf_shelf", PointerProperty(type=MeasuredShelf)),)
