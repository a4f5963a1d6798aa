"""Fits the data of a material again, with the material's settings, which presets set; and finds those that need it."""

from collections.abc import Iterator, Sequence
from functools import partial
from types import SimpleNamespace

import bpy
from bpy.props import EnumProperty, StringProperty

from ...fitter import SampleUnknownError
from ...fitter.colours import COLOURS
from ...fitter.formats import is_there
from ...fitter.formats.reading import OPTIONS
from ...fitter.methods.presets import PRESET_DESCRIPTIONS
from ..core.annotations import OperatorMixIn, OperatorResult, not_none
from ..core.blender.active_material import active_material, is_editable
from ..core.blender.transaction import find_by_session_uid
from ..core.checks import Finding
from ..core.shading import compiler, material, rendered
from ..core.storage import reading
from ..core.storage.edits import edit_arguments
from ..core.storage.outcomes import Outcome
from ..core.storage.properties import CHOICES, PRESET_ITEMS, fit_arguments, quality_summary, use_preset
from ..work import process, tasks
from ..work.making import report_questions
from ..work.modal import InBackground, Steps, begin_another

AS_CHOSEN = "AS_CHOSEN"    # in the place of a preset


class FitsWithPreset(OperatorMixIn):
    """A mix-in for operators that fit the active material, by its own settings or a preset."""

    preset: EnumProperty(name="Preset", default=AS_CHOSEN, options={"HIDDEN", "SKIP_SAVE"},
                         items=((AS_CHOSEN, "As Chosen", "The settings of the material"), *PRESET_ITEMS),
                         description="A preset that replaces the settings of the material")

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return is_editable(cls, context)


class MEASUREDBRDF_OT_fit(FitsWithPreset, InBackground, bpy.types.Operator):
    """Read the file of this material and fit it with these settings"""

    bl_idname = "measured_brdf.fit"
    bl_label = "Fit"
    bl_options = {"REGISTER", "UNDO"}

    filepath: StringProperty(name="File", subtype="FILE_PATH", options={"HIDDEN", "SKIP_SAVE"},
                             description="New location of the measurements. Empty: the location has not changed")

    @classmethod
    def description(cls, _context: bpy.types.Context, properties: "MEASUREDBRDF_OT_fit") -> str:
        text = PRESET_DESCRIPTIONS.get(properties.preset, "")
        return f"Fit with {properties.preset}. {text}" if text else ""

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> OperatorResult:
        path = self.filepath or not_none(active_material(context)).measured_brdf.filepath
        if not is_there(bpy.path.abspath(path)) and not bpy.app.background:
            return begin_another(self, "find_file", preset=self.preset, refit=True)
        return self.start(context)

    def _report_failure(self, error: Exception) -> OperatorResult:
        if isinstance(error, SampleUnknownError) and self.options.is_invoke and not bpy.app.background:
            # the other operator asks, and starts anew
            return begin_another(self, "choose_sample", filepath=self.filepath, for_material=True, refit=self.preset)
        return InBackground._report_failure(self, error)

    def work(self, context: bpy.types.Context) -> process.Calculation:
        target = not_none(active_material(context))
        # meanwhile, the user may rename or remove the material, or change its settings
        self._target = target.session_uid
        settings = target.measured_brdf
        self._choices = SimpleNamespace(**{name: getattr(settings, name) for name in CHOICES})
        # a damaged .blend may name some that do not exist
        for name in (*OPTIONS, "preset", "rendering"):
            default = settings.bl_rna.properties[name].default
            setattr(self._choices, name, getattr(self._choices, name) or default)
        self._choices.filepath = self.filepath or settings.filepath
        if self.preset != AS_CHOSEN:
            use_preset(self._choices, self.preset)
        path = bpy.path.abspath(self._choices.filepath)
        return process.Calculation(partial(tasks.outcome, path, settings.sample, fit_arguments(self._choices),
                                           how=reading.load_arguments(settings), edit=edit_arguments(target)))

    def prepare(self, outcome: Outcome) -> Steps:
        yield 0.95, "Compiling"
        return outcome, compiler.compile_surface(outcome.surface)

    def apply(self, context: bpy.types.Context, prepared: tuple[Outcome, compiler.Shader]) -> None:
        outcome, shader = prepared
        target = find_by_session_uid(bpy.data.materials, self._target)
        if target is None or not target.is_editable:
            raise ValueError("The material has been removed meanwhile")
        before, space = target.measured_brdf.digest, target.measured_brdf.colours
        how = rendered.advice(target, not_none(context.scene)) if material.is_measured(target) else ""
        report_questions(self, [outcome])
        material.assign(target, outcome, self._choices, context, shader)
        judged = quality_summary(target.measured_brdf)
        told = judged.whole
        if before not in ("", outcome.measured.digest) and space == target.measured_brdf.colours:
            told = f"the measurements differ from those of the previous fit. {told}"
        self.report({judged.level}, f"{target.name}: {told}. {how}" if how else f"{target.name}: {told}")


class MEASUREDBRDF_OT_use_preset(bpy.types.Operator):
    """Use the method and the levels of a preset. Fit applies them"""

    bl_idname = "measured_brdf.use_preset"
    bl_label = "Use Preset"
    bl_options = {"UNDO", "INTERNAL"}

    preset: EnumProperty(items=PRESET_ITEMS)

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return is_editable(cls, context)

    @classmethod
    def description(cls, _context: bpy.types.Context, properties: "MEASUREDBRDF_OT_use_preset") -> str:
        return PRESET_DESCRIPTIONS[properties.preset]

    def execute(self, context: bpy.types.Context) -> OperatorResult:
        use_preset(not_none(active_material(context)).measured_brdf, self.preset)
        return {"FINISHED"}


def check_colours(looked_at: Sequence[bpy.types.Material]) -> Iterator[Finding]:
    """Materials that were fitted for another colour space than that of the open file, each with a button that fits it
    again where its measurements are at hand."""
    here = reading.scene_colours()
    coloured = [each for each in looked_at
                if each.measured_brdf.coefficients and each.measured_brdf.colours != reading.GREY]
    if coloured and not here:
        yield Finding("colours", f"The working space of this file is none of {', '.join(COLOURS)}: measured colours "
                      "are wrong in it. Choose one of these, or an OpenColorIO configuration that has one")
    for each in coloured:
        if fitted := reading.other_colours(each.measured_brdf, here):
            message = f"{each.name} was fitted for colours in {fitted}; those of this file are in {here}"
            if each.is_editable and reading.has_file(each):
                yield Finding(f"colours:{each.name}", f"{message}. It looks too pale or too saturated",
                              f"Refit it for {here}", partial(_refit, each))
            else:
                yield Finding(f"colours:{each.name}", f"{message}. Refit it in the file that it belongs to, and "
                              "where its measurements are")


def _refit(target: bpy.types.Material) -> None:
    with bpy.context.temp_override(material=target):
        bpy.ops.measured_brdf.fit()


classes = (MEASUREDBRDF_OT_fit, MEASUREDBRDF_OT_use_preset)
