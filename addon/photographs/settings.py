"""Photographs of a ball or of a flat sample in a scene: which files they are, and which objects stand for camera, ball
or sample, and lamps.

Where these are, the objects alone know. Each photograph has a lamp object of its own, of which the active photograph's
is shown.
"""

import math
from collections.abc import Iterator
from typing import Any

import bpy
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    EnumProperty,
    FloatProperty,
    FloatVectorProperty,
    IntProperty,
    IntVectorProperty,
    PointerProperty,
    StringProperty,
)

from ...fitter.photographs.description.capture_setup import ENCODINGS, LEAST_VALUE, MOST_MATERIALS, MOST_TEXELS
from ...fitter.photographs.description.capture_setup import GUESS as GUESSED
from ...fitter.quality import verdict
from ..core.shading import material
from ..core.storage.paths import RELATIVE_PATHS, Place
from ..core.storage.properties import PRESET_ITEMS

AS_THE_FILE_SAYS = "auto"
GUESS, CARD, WHITE_BALL, INTENSITY = "albedo", "card", "ball", "intensity"
_SCALES = ((GUESS, "Guess", "The albedo is a guess, and with it the scale of the reflectance"),
           (CARD, "Card", "A card of known albedo was photographed at the ball's place, or in the plane of the sample"),
           (WHITE_BALL, "White Ball",
            "A matte ball of known albedo, of the same size, was photographed at the same place"),
           (INTENSITY, "Intensity", "The lamp's radiant intensity is known"))
_FOUND = "0"
_COUNTS = ((_FOUND, "Found", "As many as predict photographs best that are left out"),
           *((str(count), str(count), f"{count} of them are found") for count in range(1, MOST_MATERIALS + 1)))
CHOSEN = "first", "second", "third", "fourth"
_ENCODINGS = ((AS_THE_FILE_SAYS, "As the Files Say", "sRGB where the files say so or have 8 bits; else linear"),
              (ENCODINGS[0], "Linear", "Linear, whatever the files say"),
              (ENCODINGS[1], "sRGB", "sRGB, whatever the files say"))


def _file(name: str, description: str, options: Any = RELATIVE_PATHS) -> Any:
    return StringProperty(name=name, subtype="FILE_PATH", options=options, description=description)


class MeasuredExposure(bpy.types.PropertyGroup):
    """A file of a photograph."""

    filepath: _file("File", "EXR, TIFF, PNG or JPEG; linear ones are best")
    exposure: FloatProperty(
        name="Exposure", min=0, precision=5,
        description="Exposure time in seconds, where several files of one lamp do not say theirs. 0: as the file says")


class MeasuredPhotograph(bpy.types.PropertyGroup):
    """The ball or the sample under one lamp, in one exposure or several."""

    files: CollectionProperty(type=MeasuredExposure)
    used: BoolProperty(name="Use", default=True, description="Measure this photograph")
    lamp: PointerProperty(name="Lamp", type=bpy.types.Object, description="The lamp of this photograph")
    brightness: FloatProperty(name="Brightness", default=1, min=LEAST_VALUE, precision=3,
                              description="Of this lamp beside the others, where these are of a flat sample")
    picture: PointerProperty(name="Picture", type=bpy.types.Image)              # behind the camera's view
    comparison: PointerProperty(name="Comparison", type=bpy.types.Image)        # with the ball as it was rendered
    difference: FloatProperty(name="Difference")        # as `fitter.photographs.capture` defines it


def _show_active(settings: Any, context: bpy.types.Context) -> None:
    show(settings)
    lamp = active(settings).lamp
    if lamp is not None and lamp.name in context.view_layer.objects:
        for item in context.view_layer.objects:
            item.select_set(item == lamp)
        context.view_layer.objects.active = lamp


def _set_radius(settings: Any, radius: float) -> None:
    if settings.ball is not None:
        settings.ball.scale = radius, radius, radius


def _side(axis: int, name: str, default: str) -> Any:
    def get_side(settings: Any) -> float:
        return settings.sample.data.vertices[2].co[axis] * 2 if settings.sample is not None else 0.0

    def set_side(settings: Any, length: float) -> None:
        # of the meshes, for the scale of an object makes slopes steeper
        for item in () if settings.sample is None else (settings.sample, *settings.sample.children):
            for vertex in item.data.vertices:
                vertex.co[axis] = math.copysign(length / 2, vertex.co[axis])
            item.data.update()
    return FloatProperty(name=name, get=get_side, set=set_side, min=0, subtype="DISTANCE", precision=5,
                         description=f"Of the sample{default}")


def _is_fitted(_settings: Any, made: bpy.types.Material) -> bool:
    return material.is_measured(made)


def _material(number: int) -> Any:
    return PointerProperty(name=f"Material {number}", type=bpy.types.Material, description=(
        "A measured material of this file that the sample is a mix of. Where none is chosen they are found in the "
        "photographs"), poll=_is_fitted)


class MeasuredPhotographs(bpy.types.PropertyGroup):
    """Stored with the scene."""

    photographs: CollectionProperty(type=MeasuredPhotograph)
    active: IntProperty(name="Photograph", update=_show_active)
    camera: PointerProperty(name="Camera", type=bpy.types.Object)
    ball: PointerProperty(name="Ball", type=bpy.types.Object)
    radius: FloatProperty(name="Ball Radius", min=0, subtype="DISTANCE", precision=5, set=_set_radius,
                          get=lambda settings: settings.ball.scale[0] if settings.ball is not None else 0.0,
                          description="Of the ball: the scale of its object")
    sample: PointerProperty(name="Sample", type=bpy.types.Object)
    width: _side(0, "Width", ", from its left to its right")
    height: _side(1, "Height", ", from its lower to its upper edge")
    corners: FloatVectorProperty(name="Corners", size=8, min=0, precision=1, description=(
        "Of the sample in the photographs, pixels from their left and their top: bottom left, bottom right, top right, "
        "top left"))
    drawn_corners: PointerProperty(name="Corners", type=bpy.types.Mask, description=(
        "A mask of four points, drawn upon a photograph in the Image Editor, in the place of the numbers"))
    drawn_outline: PointerProperty(name="Drawn Mask", type=bpy.types.Mask, description=(
        "A mask drawn around the sample upon a photograph in the Image Editor: a coin or a leaf is no rectangle"))
    is_far: BoolProperty(name="Far Away", description=(
        "The camera looks straight down from far away, nobody knows how far; else the corners and its lens say where "
        "it stood"))
    chrome_mask: _file("Chrome Ball", "Picture that is white where a chrome ball is whose highlights say where lamps "
                                      "were. Without it, and for a painted ball, it is found by its outline")
    finds_brightness: BoolProperty(name="Lamps Differ", description=(
        "Find how bright each lamp is beside the others, by the sample itself"))
    tile: BoolProperty(name="Tile", description=(
        "Cut a part out of the sample that can be repeated, along the least visible seam"))
    texels: IntProperty(name="Texels", min=0, max=MOST_TEXELS,
                        description="Of the masks and the normal map, along the width. 0: as many as it has pixels")
    count: EnumProperty(name="Materials", items=_COUNTS, default=_FOUND,
                        description="How many materials the sample is a mix of")
    first: _material(1)
    second: _material(2)
    third: _material(3)
    fourth: _material(4)
    dark: _file("Lamp Off", "Photograph with the lamp off, if there is one")
    flat: _file("Even Surface", "Photograph of an evenly bright surface, if the lens darkens the corners")
    mask: _file("Mask", "Picture that is white where pixels count, for a stand or a reflection")
    encoding: EnumProperty(name="Values", items=_ENCODINGS, default=AS_THE_FILE_SAYS,
                           description="What the pixels of the photographs are")
    matrix: StringProperty(name="Camera Matrix",
                           description="From the camera's colours to linear Rec.709: [[...], [...], [...]]. Empty: as "
                                       "the files say")
    scale: EnumProperty(name="Scale", items=_SCALES, default=GUESS, description="How bright the lamp is")
    albedo: FloatProperty(name="Albedo", default=GUESSED, min=0, max=1, subtype="FACTOR",
                          description="What you guess ball or sample to have: the share of even light that it reflects")
    known: _file("File", "Photograph of the card or of the white ball")
    known_exposure: FloatProperty(name="Exposure", min=0, precision=5,
                                  description="Exposure time in seconds. 0: as the file says")
    known_albedo: FloatVectorProperty(name="Albedo", size=3, default=(0.18, 0.18, 0.18), min=0, max=1, subtype="COLOR",
                                      description="Of the card or of the white ball, linear")
    known_lamp: PointerProperty(name="Lamp", type=bpy.types.Object, poll=lambda _, item: item.type == "LIGHT",
                                description="The lamp under which the card or the white ball was photographed")
    normal: FloatVectorProperty(name="Card Faces", size=3, default=(0, -1, 0), subtype="XYZ",
                                description="The direction in which the card faces")
    region: IntVectorProperty(name="Region", size=4, min=0,
                              description="Left, top, right and bottom of the pixels that the card fills")
    intensity: FloatVectorProperty(name="Intensity", size=3, default=(1, 1, 1), min=0,
                                   description="Radiant intensity of the lamp, W/sr in units of the pictures")
    preset: EnumProperty(name="Preset", items=PRESET_ITEMS, default="Standard", description="Method of the fit")
    samples: _file("Save As", "File of the samples that are measured, .npz, which the material is fitted to")
    told: StringProperty(name="What Was Measured")      # lines
    doubts: StringProperty(name="What Is Wrong")        # those of them that say so


def get(scene: bpy.types.Scene) -> Any:
    return scene.measured_brdf_photographs


def active(settings: Any) -> Any:
    return settings.photographs[min(max(settings.active, 0), len(settings.photographs) - 1)]


def judge_render(name: str, difference: float) -> verdict.Judgement:
    """How far a render is from a photograph that it was compared with, in words."""
    return verdict.grade_message(f"{name}: the render differs by {difference:.1%}", difference,
                                 verdict.PREDICTED_LIMITS)


def surface(settings: Any) -> Any:
    """The object that is measured: the ball, or the sample; None where it has been deleted."""
    return settings.ball or settings.sample


def is_flat(settings: Any) -> bool:
    """Whether the photographs are of a flat sample: its corners are in them, whether or not its object is."""
    return any(settings.corners)


def lamps(settings: Any) -> Iterator[bpy.types.Object]:
    yield from (each.lamp for each in settings.photographs if each.lamp is not None)


def places(scene: bpy.types.Scene) -> Iterator[Place]:
    """Where the files of a scene's photographs are told."""
    settings = get(scene)
    yield from ((settings, name) for name in ("dark", "flat", "mask", "chrome_mask", "known", "samples"))
    for each in settings.photographs:
        yield from ((file, "filepath") for file in each.files)
        yield from ((picture, "filepath_raw") for picture in (each.picture, each.comparison) if picture is not None)


def show(settings: Any) -> None:
    """Show the active photograph behind the camera's view, and its lamp alone."""
    shown = active(settings)
    for lamp in lamps(settings):
        lamp.hide_viewport = lamp.hide_render = lamp != shown.lamp
    if settings.camera is not None:
        for background in settings.camera.data.background_images:
            background.image = shown.picture


classes = (MeasuredExposure, MeasuredPhotograph, MeasuredPhotographs)


def register() -> None:
    bpy.types.Scene.measured_brdf_photographs = PointerProperty(type=MeasuredPhotographs, name="Photographs")


def unregister() -> None:
    del bpy.types.Scene.measured_brdf_photographs
