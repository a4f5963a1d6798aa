"""What operators share that make materials of measurements: what the material is for, and one material per outcome."""

import contextlib
from collections.abc import Iterable, Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import bpy
from bpy.props import IntProperty, StringProperty

from ..core import preferences
from ..core.annotations import OperatorResult, not_none
from ..core.blender import targets
from ..core.shading import compiler, material, rendered
from ..core.storage import edits, properties
from ..core.storage.outcomes import Outcome
from ..core.storage.reading import draw_reading
from .discovery import GLOB, files_in, passed_over
from .modal import AsksForPath, InBackground, Steps

Outcomes = Sequence[tuple[str, str, Outcome | ValueError]]
"""As `tasks.outcomes` returns them."""
_Prepared = Sequence[tuple[str, str, Outcome | ValueError, compiler.Shader | None]]


class HasTarget:
    """A mix-in for the operators that an import goes through, which tell one another what the material is for."""

    target: IntProperty(options={"HIDDEN", "SKIP_SAVE"})
    slot: IntProperty(default=targets.ACTIVE_SLOT, options={"HIDDEN", "SKIP_SAVE"})
    others: StringProperty(options={"HIDDEN", "SKIP_SAVE"})     # that are selected too, separated by spaces

    def remember_target(self, context: bpy.types.Context, event: bpy.types.Event | None = None) -> None:
        """Unless the caller has named one, remember the object under the mouse, else the active and selected ones."""
        if not self.target:
            dropped_on = None if event is None else targets.find_under_mouse(context, event)
            (self.target, self.slot), *others = [dropped_on] if dropped_on else targets.list_selected(context)
            self.others = " ".join(str(each.item) for each in others)

    def all_targets(self) -> list[targets.Target]:
        return [targets.Target(self.target, self.slot), *(targets.Target(int(uid)) for uid in self.others.split())]


class MakesMaterials(HasTarget, InBackground):
    """A mix-in for operators whose work returns `Outcomes`: each becomes a material, and the first is assigned.

    Files that failed are reported as warnings; if all of them failed, the first is reported as an error.
    """

    def prepare(self, outcomes: Outcomes) -> Steps:
        prepared: list[tuple[str, str, Outcome | ValueError, compiler.Shader | None]] = []
        for number, (path, sample, outcome) in enumerate(outcomes):
            shader = None
            if not isinstance(outcome, Exception):
                yield 0.95 + 0.05 * number / len(outcomes), f"Compiling {outcome.measured.name}"
                shader = compiler.compile_surface(outcome.surface)
            prepared.append((path, sample, outcome, shader))
        return prepared

    def apply(self, context: bpy.types.Context, prepared: _Prepared) -> None:
        made: list[bpy.types.Material] = []
        failed = [outcome for _, _, outcome, _ in prepared if isinstance(outcome, Exception)]
        if len(failed) == len(prepared):
            raise failed[0]
        choices = SimpleNamespace(**{name: getattr(self, name) for name in properties.CHOICES})
        for path, sample, outcome, shader in prepared:
            if not isinstance(outcome, Exception):
                choices.filepath, choices.sample = path, sample
                made.append(material.create(outcome, choices, context, shader))
                for sliders in edits.sliders:
                    sliders.move(made[-1], outcome.surface.edit)
        for item in made[1:]:
            item.use_fake_user = True           # without a user, Blender does not save it
        judged = [(item.name, properties.quality_summary(item.measured_brdf)) for item in made]
        first, is_one = judged[0][1], len(made) == 1
        told = f"{made[0].name}: {first.whole}" if is_one else f"{len(made)} materials; {len(failed)} files failed"
        how = rendered.advice(made[0], not_none(context.scene))
        for error in failed:
            self.report({"WARNING"}, str(error))
        for name, summary in judged:
            if summary.is_bad and not is_one:
                self.report({"WARNING"}, f"{name}: {summary.line}")
        report_questions(self, (outcome for _, _, outcome, _ in prepared if not isinstance(outcome, Exception)))
        # last, because it is the only change that is not taken back on an error
        if why := targets.assign_all(self.all_targets(), made[0]):
            made[0].use_fake_user = True
            self.report({"WARNING"}, f"{made[0].name} is not assigned: {why}")
        self.report({first.level if is_one else "INFO"}, f"{told}. {how}" if how else told)
        if self.options.is_invoke:
            show_first(context, made)


class FromFolder(properties.FitChoices, AsksForPath):
    """A mix-in for operators that fit the measurements of a folder."""

    directory: StringProperty(name="Folder", subtype="DIR_PATH", options={"SKIP_SAVE"})

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> OperatorResult:
        begin_with_preference(self, context)
        return super().invoke(context, event)

    def draw(self, _context: bpy.types.Context) -> None:
        layout = not_none(self.layout)
        layout.use_property_split, layout.use_property_decorate = True, False
        draw_choices(layout, self, self.directory)

    def checked_folder(self) -> str:
        """The folder, or an error if it has no files of measurements; folders in it that have some are reported."""
        if not self.directory:
            raise ValueError("no folder is named: the path is empty")
        folder = bpy.path.abspath(self.directory)
        if not Path(folder).is_dir():
            raise ValueError(f"{folder}: not a folder")
        if not files_in([folder]):
            said = f"{self.directory}: no files of measurements ({GLOB}); choose a folder that has some"
            raise ValueError("; ".join((said, *passed_over([folder]))))
        for line in passed_over([folder]):
            self.report({"WARNING"}, line)
        return folder


def begin_with_preference(operator: Any, context: bpy.types.Context) -> None:
    """Use the preset of the preferences if the caller gave no choices; those of earlier calls are forgotten."""
    chosen = _says_how_to_fit(operator)
    for name in properties.CHOICES:
        if not operator.properties.is_property_set(name):
            operator.properties.property_unset(name)
    if not chosen:
        properties.use_preset(operator, preferences.get(context).preset)


def begin_as_script(operator: Any) -> None:
    """Use the preset Standard if a script gave neither a preset nor levels; levels alone are the method of 2002."""
    if not _says_how_to_fit(operator):
        properties.use_preset(operator, properties.OFFERED[0])


def _says_how_to_fit(operator: Any) -> bool:
    names = "preset", "use_tolerance", *properties.FIT_LEVELS
    return any(map(operator.properties.is_property_set, names))


def draw_choices(layout: bpy.types.UILayout, operator: Any, path: str, with_sample: bool = False) -> None:
    properties.draw_presets(layout, operator)
    if with_sample:
        layout.prop(operator, "sample")
    properties.draw_rendering(layout, operator)
    header, body = layout.panel("MEASUREDBRDF_levels", default_closed=True)
    header.label(text="Fit Settings")
    if body is not None:
        for name in (*properties.FIT_LEVELS, "use_tolerance", "tolerance"):
            row = body.row()
            row.active = name == "use_tolerance" or operator.use_tolerance == (name == "tolerance")
            row.prop(operator, name)
    draw_reading(layout, operator, path)


def report_questions(operator: bpy.types.Operator, outcomes: Iterable[Outcome]) -> None:
    for outcome in outcomes:
        for question in outcome.questions:
            operator.report({"WARNING"}, question)


def show_first(context: bpy.types.Context, made: Sequence[bpy.types.Material]) -> None:
    """Show the material tab in the properties editors of the window, if these are the first measured materials."""
    if context.window is None or any(material.is_measured(item) for item in bpy.data.materials if item not in made):
        return
    for area in context.window.screen.areas:
        if area.type == "PROPERTIES":
            with contextlib.suppress(TypeError):        # there is no such tab: the active object has no materials
                area.spaces.active.context = "MATERIAL"
