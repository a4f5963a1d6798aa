"""From photographs of a ball or a flat sample to its material: a scene of them, things in their places, comparisons."""

import math
from collections.abc import Generator, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from bpy.props import BoolProperty, CollectionProperty, FloatProperty, IntProperty, StringProperty

from ...fitter.arrays import FloatArray
from ...fitter.colours import DEFAULT_COLOURS, conversion
from ...fitter.photographs.capture import relative_difference
from ...fitter.photographs.description.capture_setup import Description
from ...fitter.photographs.rig.lamps import Scene
from ...fitter.storage.files import replace_file
from ..core.annotations import not_none
from ..core.blender import osl_support, targets
from ..core.blender.transaction import find_by_session_uid
from ..core.shading import compiler, material
from ..core.storage.outcomes import Outcome
from ..core.storage.properties import default_choices, fit_arguments, quality_summary, use_preset
from ..core.storage.reading import load_arguments, scene_colours
from ..work import process
from ..work.blender_process import Command
from ..work.job import Work
from ..work.modal import AsksForPath, InBackground, Steps
from . import comparison, describing, stage
from . import settings as photographs
from . import work as measuring
from .settings import CHOSEN

PICTURES = "*.exr;*.tif;*.tiff;*.png;*.jpg;*.jpeg"
LIGHTS = ";".join(f"*{suffix}" for suffix in measuring.LIGHT_POSITIONS)


class HasPhotographs(InBackground):
    """A mix-in for operators on the photographs of the scene, which is remembered while they work."""

    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if context.scene is None or not photographs.get(context.scene).photographs:
            cls.poll_message_set("This scene has no photographs to measure")
            return False
        return bool(context.scene.is_editable)

    def remember(self, context: bpy.types.Context) -> Any:
        """The settings of the context's scene, which `settings` finds again."""
        osl_support.make_importable("OpenImageIO")
        self._scene = not_none(context.scene).session_uid
        return photographs.get(not_none(context.scene))

    def settings(self) -> Any:
        """Those of the scene that was remembered. ValueError if it, or what is measured, has been removed meanwhile."""
        scene = find_by_session_uid(bpy.data.scenes, self._scene)
        if scene is None or photographs.surface(photographs.get(scene)) is None:
            raise ValueError("The scene of the photographs has been removed meanwhile")
        return photographs.get(scene)


class _ChoosesFiles(AsksForPath):
    """A mix-in for operators that ask for one file or several."""

    path_name = "filepath"
    filepath: StringProperty(subtype="FILE_PATH", options={"SKIP_SAVE"})
    directory: StringProperty(subtype="DIR_PATH", options={"HIDDEN", "SKIP_SAVE"})
    files: CollectionProperty(type=bpy.types.OperatorFileListElement, options={"HIDDEN", "SKIP_SAVE"})

    def paths(self, what: str) -> list[str]:
        """What was chosen. ValueError where that is nothing, which says what it should have been."""
        paths = [str(Path(self.directory) / item.name) for item in self.files if item.name] or [
            bpy.path.abspath(self.filepath or self.directory)]
        if not paths[0]:
            raise ValueError(f"The path is empty: choose {what}")
        return paths


class MakesScene(_ChoosesFiles):
    """A mix-in for operators that make a scene of photographs."""

    bl_options = {"REGISTER", "UNDO"}
    expected = "the photographs, their folder, or a description"
    exposures: IntProperty(name="Exposures", default=0, min=0,
                           description="Pictures of each lamp, which follow one another by name. 0: found by the "
                                       "exposure times in the files")
    side_properties: tuple[str, ...] = ()         # the properties at the right of the file browser

    def describe(self) -> Description:
        """Camera and ball, or sample, of pictures that nobody has described."""
        raise NotImplementedError

    def work(self, context: bpy.types.Context) -> Work:
        osl_support.make_importable("OpenImageIO")
        self._scene = not_none(context.scene).session_uid
        paths, choices = self.paths(self.expected), default_fit("")
        return process.Calculation(partial(measuring.find_scene, paths, self.describe(), self.exposures,
                                           fit_arguments(choices), load_arguments(choices)))

    def prepare(self, found: tuple[Scene, list[Outcome]]) -> Steps:
        return *found, (yield from compile_outcomes(found[1]))

    def apply(self, context: bpy.types.Context, prepared: tuple[Scene, list[Outcome], list[compiler.Shader]]) -> None:
        described, outcomes, shaders = prepared
        materials = create_materials(outcomes, shaders, context)
        made = stage.make(described)
        for name, each in zip(CHOSEN, materials, strict=False):
            setattr(photographs.get(made), name, each)
        count = len(photographs.get(made).photographs)
        self.report({"INFO"}, f"{made.name}: {count} photograph{'s' * (count > 1)}")
        # the last step opens the scene, because that is not taken back on an error
        if context.window is not None:
            context.window.scene = made
            for area in () if bpy.app.background else context.window.screen.areas:
                if area.type == "VIEW_3D":      # through the camera, with the light of the scene
                    space: Any = area.spaces.active
                    space.region_3d.view_perspective, space.shading.type = "CAMERA", "RENDERED"

    def draw(self, _context: bpy.types.Context) -> None:
        layout = not_none(self.layout)
        layout.use_property_split = True
        for name in (*self.side_properties, "exposures"):
            layout.prop(self, name)


def default_fit(path: str, preset: str = "Standard") -> Any:
    choices = default_choices(path)
    use_preset(choices, preset)
    return choices


def compile_outcomes(outcomes: Sequence[Outcome]) -> Generator[tuple[float, str], None, list[compiler.Shader]]:
    shaders = []
    for each in outcomes:
        yield 0.95, f"Compiling {each.measured.name}"
        shaders.append(compiler.compile_surface(each.surface))
    return shaders


def create_materials(outcomes: Sequence[Outcome], shaders: Sequence[compiler.Shader],
                     context: bpy.types.Context) -> list[bpy.types.Material]:
    return [material.create(each, default_fit(each.measured.path), context, shader)
            for each, shader in zip(outcomes, shaders, strict=True)]


class MEASUREDBRDF_OT_measure_photographs(MakesScene, bpy.types.Operator):
    """Make a scene of photographs of a painted ball, in which its material is measured: choose all of them, \
their folder, or a description (.toml, .lp)"""

    bl_idname = "measured_brdf.measure_photographs"
    bl_label = "Measure Photographs"

    filter_glob: StringProperty(default=f"{PICTURES};*.toml;*.lp", options={"HIDDEN"})
    radius: FloatProperty(name="Ball Radius", default=0.025, min=1e-5, subtype="DISTANCE", precision=5,
                          description="Of the ball")
    distance: FloatProperty(name="Camera Distance", default=1.5, min=1e-4, subtype="DISTANCE",
                            description="From the camera to the ball, about. The camera can be moved later")
    to_scene: BoolProperty(name="To This Scene", options={"HIDDEN", "SKIP_SAVE"},
                           description="Add them to the photographs of this scene")

    @property
    def side_properties(self) -> tuple[str, ...]:
        return () if self.to_scene else ("radius", "distance")

    def describe(self) -> Description:
        return {"camera": {"position": [0.0, -self.distance, 0.0]},
                "ball": {"centre": [0.0, 0.0, 0.0], "radius": self.radius}}

    def apply(self, context: bpy.types.Context, prepared: tuple[Scene, list[Outcome], list[compiler.Shader]]) -> None:
        if not self.to_scene:
            super().apply(context, prepared)
            return
        scene = find_by_session_uid(bpy.data.scenes, self._scene)
        known = [] if scene is None else list(photographs.lamps(photographs.get(scene)))
        if scene is None or not known:
            raise ValueError("This scene has no photographs to measure")
        stage.add(scene, prepared[0].setup.photographs, known[0].data)
        photographs.get(scene).active = len(photographs.get(scene).photographs) - 1


class MEASUREDBRDF_OT_measure_sample_photographs(MakesScene, bpy.types.Operator):
    """Make a scene of photographs of a flat sample, in which its materials are measured: choose all of them, \
their folder, light positions (.lp), a project of relight, or a description (.toml)"""

    bl_idname = "measured_brdf.measure_sample_photographs"
    bl_label = "Measure Photographs of a Flat Sample"

    filter_glob: StringProperty(default=f"{PICTURES};*.toml;{LIGHTS}", options={"HIDDEN"})
    width: FloatProperty(name="Sample Width", default=0.1, min=1e-5, subtype="DISTANCE", precision=5,
                         description="Of what fills the pictures. Corners can be moved later")
    side_properties = "width",
    expected = "the photographs, their folder, light positions, or a description"

    def describe(self) -> Description:
        return {"camera": {"position": "far"}, "sample": {"width": self.width, "height": self.width}}


class MEASUREDBRDF_OT_fit_outline(HasPhotographs, bpy.types.Operator):
    """Move the ball to its outline in the photographs, or the camera to where the corners of a sample say"""

    bl_idname = "measured_brdf.fit_outline"
    bl_label = "Fit Outline"

    def work(self, context: bpy.types.Context) -> Work:
        description = describing.describe_scene(self.remember(context), whole=False)
        return process.Calculation(partial(measuring.find_places, description))

    def apply(self, _context: bpy.types.Context, found: Scene) -> None:
        settings = self.settings()
        if settings.ball is not None:
            name, place = "ball", found.what.middle
            settings.ball.location = place
        else:
            name, place = "camera", found.view.position
            settings.camera.matrix_basis = stage.camera_pose(found.view)
        self.report({"INFO"}, "The {} is at {:.4f}, {:.4f}, {:.4f} m".format(name, *place))


class MEASUREDBRDF_OT_place_lamp(_ChoosesFiles, HasPhotographs, bpy.types.Operator):
    """Place the lamps of all photographs by pictures of a chrome ball, one under each lamp and chosen at once, or by \
light positions (.lp, a project of relight); the lamp of this photograph by one picture"""

    bl_idname = "measured_brdf.place_lamp"
    bl_label = "Place Lamps"

    filter_glob: StringProperty(default=f"{PICTURES};{LIGHTS}", options={"HIDDEN"})
    distance: FloatProperty(name="Lamp Distance", default=1.0, min=0, subtype="DISTANCE",
                            description="From the lamps to the middle of ball or sample. 0: far away")

    def work(self, context: bpy.types.Context) -> Work:
        settings, paths = self.remember(context), self.paths("pictures of a chrome ball, or light positions")
        is_one = len(paths) == 1 and Path(paths[0]).suffix.lower() not in measuring.LIGHT_POSITIONS
        shots = [photographs.active(settings)] if is_one else [*settings.photographs]
        self._lamps = [None if each.lamp is None else each.lamp.session_uid for each in shots]
        return process.Calculation(partial(measuring.lamps_by, describing.describe_scene(settings, shots, whole=False),
                                           paths, self.distance, bpy.path.abspath(settings.chrome_mask)))

    def apply(self, _context: bpy.types.Context, places: list[list[float] | None]) -> None:
        lamps = [find_by_session_uid(bpy.data.objects, uid) for uid in self._lamps]
        if None in lamps:
            raise ValueError("A lamp has been removed meanwhile")
        for lamp, place in zip(lamps, places, strict=True):
            if place is not None:
                not_none(lamp).location = place
        if missing := places.count(None):
            self.report({"WARNING"}, f"{missing} of {len(places)} lamps were not found, and stay where they are")


class MEASUREDBRDF_OT_measure_ball(HasPhotographs, bpy.types.Operator):
    """Measure the reflectance of the ball in the photographs, save it as samples, and make the ball's material of \
them"""

    bl_idname = "measured_brdf.measure_ball"
    bl_label = "Measure"

    def work(self, context: bpy.types.Context) -> Work:
        settings = self.remember(context)
        self._choices = default_fit(settings.samples, settings.preset or "Standard")
        path = Path(bpy.path.abspath(settings.samples))
        if not settings.samples or not path.parent.is_dir():
            raise ValueError(f"Save As: {path.parent}: not a folder" if settings.samples
                             else "Save As is empty: name the file of the samples")
        return process.Calculation(partial(
            measuring.measure_ball, describing.describe_scene(settings), str(path), fit_arguments(self._choices),
            load_arguments(self._choices)))

    def prepare(self, result: measuring.BallResult) -> Steps:
        yield 0.95, "Compiling"
        return result, compiler.compile_surface(result.outcome.surface)

    def apply(self, context: bpy.types.Context, prepared: tuple[measuring.BallResult, compiler.Shader]) -> None:
        (outcome, content, centre, intensity, *lines), shader = prepared
        told, doubts = (measuring.translate_keys("\n".join(each)) for each in lines)
        settings = self.settings()
        ball, energy, colour = settings.ball, *blender_light(intensity)
        lights: list[Any] = [lamp.data for lamp in photographs.lamps(settings)]
        with replace_file(outcome.measured.path) as stream:
            stream.write(content)
        made = ball.active_material
        if made is not None and made.is_editable and material.is_measured(made):
            material.assign(made, outcome, self._choices, context, shader)
        else:
            made = material.create(outcome, self._choices, context, shader)
            if why := targets.assign(targets.Target(ball.session_uid), made):
                raise ValueError(why)
        summary = quality_summary(made.measured_brdf).line
        # no call may follow that can fail: this is not taken back
        ball.location = centre
        for light in lights:
            light.energy, light.color = energy, colour
        settings.told, settings.doubts = told, doubts
        for line in doubts.splitlines():
            self.report({"WARNING"}, line)
        self.report({"INFO"}, f"{made.name}: {summary}")


def blender_light(intensity: FloatArray) -> tuple[float, FloatArray]:
    """The power and the colour of a lamp in Blender, by its radiant intensity, (channels,) in linear Rec.709."""
    matrix = conversion(DEFAULT_COLOURS, scene_colours() or DEFAULT_COLOURS)
    colour = np.maximum(matrix @ np.broadcast_to(intensity, 3), 0)
    return float(4 * math.pi * colour.max()), colour / colour.max()


class MEASUREDBRDF_OT_compare_photograph(HasPhotographs, bpy.types.Operator):
    """Render ball or sample in this scene, in the place and under the lamp of this photograph, and show what differs"""

    bl_idname = "measured_brdf.compare_photograph"
    bl_label = "Compare with Photograph"

    def work(self, context: bpy.types.Context) -> Work:
        settings = self.remember(context)
        shot = photographs.active(settings)
        description = describing.describe_scene(settings, [shot], whole=False)
        self._lamp, self._folder = shot.lamp.session_uid, process.temporary()
        comparison.write_request(Path(self._folder.name), settings.id_data, description)
        return Command("photograph", self._folder.name)

    def prepare(self, _result: Any) -> Steps:
        pair = comparison.read_answer(Path(self._folder.name))
        self._folder.cleanup()
        return pair
        yield

    def apply(self, _context: bpy.types.Context, pair: comparison.RenderedPair) -> None:
        settings = self.settings()
        shot = next((each for each in settings.photographs
                     if each.lamp is not None and each.lamp.session_uid == self._lamp), None)
        if shot is None:
            raise ValueError("The photograph has been removed meanwhile")
        before, difference = shot.comparison, relative_difference(*pair)
        judged = photographs.judge_render(shot.name, difference)
        made = comparison.new_image(f"{shot.name} compared", comparison.sheet(pair))
        # no call may follow that can fail: this is not taken back
        shot.comparison, shot.difference = made, difference
        if before is not None:
            bpy.data.images.remove(before)
        self.report({"WARNING"} if judged.is_bad else {"INFO"}, judged.words)


classes = (MEASUREDBRDF_OT_measure_photographs, MEASUREDBRDF_OT_measure_sample_photographs,
           MEASUREDBRDF_OT_fit_outline, MEASUREDBRDF_OT_place_lamp, MEASUREDBRDF_OT_measure_ball,
           MEASUREDBRDF_OT_compare_photograph)
