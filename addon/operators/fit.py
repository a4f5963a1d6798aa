"""Fitting the data of a material, by its own choices."""

from functools import partial
from pathlib import Path
from types import SimpleNamespace

import bpy
from bpy.props import EnumProperty, StringProperty
from bpy_extras.io_utils import ImportHelper

from ..jobs import process, queries, tasks
from ..jobs.modal import InBackground
from ..library.discovery import GLOB
from ..materials import compiler, material, node_group
from ..materials.properties import CHOICES, PRESET_HELP, PRESET_ITEMS, fit_arguments, use_preset
from ..transaction import by_session_uid

METHODS = (("EXACT", "Exact", "What was measured, under every light; a little noisier and slower"),
           ("FAST", "Fast", "The nearest that Cycles samples by itself: as measured at lamps and in sum"))


class MEASUREDBRDF_OT_fit(InBackground, bpy.types.Operator):
    """Read this material's file and fit it with these levels and this compression"""

    bl_idname = "measured_brdf.fit"
    bl_label = "Fit"
    bl_options = {"REGISTER", "UNDO"}

    filepath: StringProperty(name="File", subtype="FILE_PATH", options={"HIDDEN", "SKIP_SAVE"},
                             description="Where the measurements are now; empty for where they were")

    @classmethod
    def poll(cls, context):
        return is_editable(cls, context)

    def invoke(self, context, _event):
        path = self.filepath or active_material(context).measured_brdf.filepath
        if not Path(bpy.path.abspath(path)).is_file() and not bpy.app.background:
            bpy.ops.measured_brdf.find_file("INVOKE_DEFAULT")
            return {"CANCELLED"}
        return self.start(context)

    def execute(self, context):
        return self.run(context)

    def work(self, context):
        target = active_material(context)
        # by then the user may have renamed the material, removed it, or changed its settings
        self._target = target.session_uid
        settings = target.measured_brdf
        self._choices = SimpleNamespace(**{name: getattr(settings, name) for name in CHOICES})
        self._choices.preset = self._choices.preset or "Paper"      # a damaged .blend may name one that does not exist
        self._choices.filepath = self.filepath or settings.filepath
        path, sample, arguments = bpy.path.abspath(self._choices.filepath), settings.sample, fit_arguments(settings)
        return process.Calculation(
            partial(tasks.outcome, path, sample, arguments, known=queries.known_fit(path, sample, arguments)))

    def prepare(self, outcome):
        yield 0.95, "Compiling"
        return outcome, compiler.compile_shader(outcome.source)

    def apply(self, context, prepared):
        outcome, shader = prepared
        target = by_session_uid(bpy.data.materials, self._target)
        if target is None or not target.is_editable:
            raise ValueError("The material has been removed meanwhile")
        before = target.measured_brdf.digest
        material.assign(target, outcome, self._choices, context, shader)
        if before not in ("", outcome.digest):
            self.report({"INFO"}, f"{target.name}: these are not the measurements of the fit before")


class MEASUREDBRDF_OT_update_materials(InBackground, bpy.types.Operator):
    """Give all measured materials of this file that an older version made the shader of this version. \
Their fits stay as they are; the measurements are not needed"""

    bl_idname = "measured_brdf.update_materials"
    bl_label = "Update Measured Materials"
    bl_options = {"REGISTER", "UNDO"}

    def invoke(self, context, _event):
        return self.start(context)

    def execute(self, context):
        return self.run(context)

    def work(self, _context):
        outdated = [item for item in bpy.data.materials if item.is_editable and material.is_outdated(item)]
        if not outdated:
            raise ValueError("All measured materials of this file are those of this version")
        shaders = {}
        for item in outdated:           # copies of a material may share a shader
            tree = material.group_node(item).node_tree
            shaders.setdefault(tree.session_uid, (node_group.source(tree), item.measured_brdf.compression, []))
            shaders[tree.session_uid][2].append(item.session_uid)
        return process.Calculation(partial(tasks.rebake, list(shaders.values())))

    def prepare(self, rebaked):
        prepared = []
        for number, (source, users) in enumerate(rebaked):
            yield number / len(rebaked), "Compiling"
            prepared.append((source if isinstance(source, Exception) else compiler.compile_shader(source), users))
        return prepared

    def apply(self, context, prepared):
        updated, failed = 0, []
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


class MEASUREDBRDF_OT_find_file(bpy.types.Operator, ImportHelper):
    """Say where the measurements of this material are now, and fit them"""

    bl_idname = "measured_brdf.find_file"
    bl_label = "Find File"

    filter_glob: StringProperty(default=GLOB, options={"HIDDEN"})

    @classmethod
    def poll(cls, context):
        return is_editable(cls, context)

    def execute(self, _context):
        bpy.ops.measured_brdf.fit("INVOKE_DEFAULT", filepath=self.filepath)
        return {"FINISHED"}


class MEASUREDBRDF_OT_use_preset(bpy.types.Operator):
    """Choose the levels and the method of a preset; nothing is fitted yet"""

    bl_idname = "measured_brdf.use_preset"
    bl_label = "Use Preset"
    bl_options = {"UNDO", "INTERNAL"}

    preset: EnumProperty(items=PRESET_ITEMS)

    @classmethod
    def poll(cls, context):
        return is_editable(cls, context)

    @classmethod
    def description(cls, _context, properties):
        return PRESET_HELP[properties.preset]

    def execute(self, context):
        use_preset(active_material(context).measured_brdf, self.preset)
        return {"FINISHED"}


class MEASUREDBRDF_OT_use_method(bpy.types.Operator):
    """Choose how this material is rendered"""

    bl_idname = "measured_brdf.use_method"
    bl_label = "Use Method"
    bl_options = {"UNDO", "INTERNAL"}

    method: EnumProperty(items=METHODS)

    @classmethod
    def poll(cls, context):
        target = active_material(context)
        return target is not None and exact_input(target) is not None and is_editable(cls, context)

    @classmethod
    def description(cls, _context, properties):
        return next(text for key, _, text in METHODS if key == properties.method)

    def execute(self, context):
        exact_input(active_material(context)).default_value = self.method == "EXACT"
        return {"FINISHED"}


def exact_input(target):
    """The node's input that chooses between Exact and Fast; None where a material has none."""
    node = material.group_node(target)
    return node.inputs.get("Exact") if node is not None else None


def active_material(context):
    """The material that the properties editor shows, else that of the active object, else None."""
    shown = getattr(context, "material", None)
    return shown if shown is not None or context.object is None else context.object.active_material


def is_editable(cls, context):
    """For `poll`: whether there is a material that can be given another shader."""
    target = active_material(context)
    if target is None or not target.is_editable or target.override_library is not None:
        cls.poll_message_set("There is no active material, or it belongs to another file: make it local first "
                             "(Object > Relations > Make Local)")
        return False
    return True


classes = (MEASUREDBRDF_OT_fit, MEASUREDBRDF_OT_update_materials, MEASUREDBRDF_OT_find_file, MEASUREDBRDF_OT_use_preset,
           MEASUREDBRDF_OT_use_method)
