"""The settings of a measured material: its data, the choices for the fit, and the results."""

import json
import math
from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any, Literal, NamedTuple, cast

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty, StringProperty

from ....fitter import PRESETS, DatasetError
from ....fitter.formats import KNOWN_FILES
from ....fitter.formats.reading import OPTIONS, Option
from ....fitter.lattice.dense import MAX_LEVEL
from ....fitter.library import ready
from ....fitter.methods.presets import PRESET_DESCRIPTIONS
from ....fitter.model import published
from ....fitter.quality import verdict
from ....fitter.quality.verdict import UNKNOWN
from ..annotations import Arguments, as_text
from .paths import RELATIVE_PATHS

NO_SPECULAR_LEVEL = -1
FIT_LEVELS = ("diffuse_level", "specular_level", "compression")
RESULTS = ("name_of_data", "digest", "coefficients", "bytes", "rmse", "mre", "seconds", "fitted_levels", "changes",
           "version", "colours", "sphere", "fitted_as", "match", "between", "farthest", "hole", "least", "adjusted")
CHOICES = ("filepath", "sample", "preset", *FIT_LEVELS, "use_tolerance", "tolerance", "rendering", *OPTIONS)
AUTOMATIC, EXACT, NODES = "AUTO", "EXACT", "NODES"
RENDERINGS = (
    (AUTOMATIC, "Automatic", "Exact where Cycles renders with OSL, and Nodes everywhere else"),
    (EXACT, "Exact", "The measured reflectance under every light; slightly noisier and slower. It needs Cycles with "
                     "OSL: elsewhere, Nodes are shown"),
    (NODES, "Nodes", "An approximation by ordinary nodes, without OSL: on every device, quick, and without noise of "
                     "its own"))
_FAST = "FAST"              # scripts may name it, and get NODES
ORIGINAL = "Paper"
_PRESET_LABELS = {ORIGINAL: "Original 2002 Method"}
PRESET_ITEMS = tuple((name, _PRESET_LABELS.get(name, name), text) for name, text in PRESET_DESCRIPTIONS.items())
OFFERED = "Standard", "Reference"       # the others are for scripts, and `ORIGINAL` is a choice of Fit Settings
_PRESET_ARGUMENTS: dict[str, Arguments] = {name: cast(Arguments, preset) for name, preset in PRESETS.items()}
_PAPER = _PRESET_ARGUMENTS[ORIGINAL]
_BEST = "Reference"
# what to do about a poor match
_OF_THE_BEST = ". Measurements lists the values that are doubtful"
_OF_OTHERS = f". Choose {_BEST} in Measurements, and Refit"


Choices = Any               # `FitChoices`, or a SimpleNamespace that copies one


def _use_levels_of_preset(choices: Any, _context: bpy.types.Context) -> None:
    """Of an operator, a preset brings its levels; scripts give a material its preset and its levels in any order."""
    if isinstance(choices, bpy.types.OperatorProperties):
        choices.use_tolerance = False
        _use_levels(choices, choices.preset)


def _use_nodes_for_fast(choices: Any, _context: bpy.types.Context) -> None:
    if choices.rendering == _FAST:
        choices.rendering = NODES


class FitChoices:
    """A mix-in for the import operators and the material: the properties of `Choices`."""

    filepath: StringProperty(
        name="File", subtype="FILE_PATH", options=RELATIVE_PATHS,
        description=f"File of measured reflectance: {KNOWN_FILES}")
    sample: StringProperty(
        name="Sample",
        description="Number or name of the sample in a CURET file. Empty: the first, or the only one")
    preset: EnumProperty(
        name="Preset", items=PRESET_ITEMS, default=ORIGINAL, update=_use_levels_of_preset,
        description="Method of the fit, with initial levels")
    diffuse_level: IntProperty(
        name="Diffuse Level", default=_PAPER["diffuse_level"], min=0, max=MAX_LEVEL, soft_max=6,
        description="Resolution of the dense lattice, which holds the broad shape. Higher levels ripple less between "
                    "the measured directions; each multiplies the storage by up to 8")
    specular_level: IntProperty(
        name="Specular Level", default=_PAPER["specular_level"], min=NO_SPECULAR_LEVEL, max=MAX_LEVEL, soft_max=7,
        description="Resolution of the sparse lattice, which holds highlights. Higher levels make them narrower and "
                    "brighter, as measured. -1: no sparse lattice")
    compression: FloatProperty(
        name="Compression", default=_PAPER["compression"], min=0, max=100, subtype="PERCENTAGE", precision=2,
        description="How much of the fine detail is left out, the least visible first: at 98.2 %, 1.8 % are kept. "
                    "Higher values make smaller files and flatter highlights; lower ones, sharper highlights")
    use_tolerance: BoolProperty(
        name="Auto", default=False,
        description="Choose the smallest fit within the tolerance, instead of setting levels")
    tolerance: FloatProperty(
        name="Tolerance", default=0.05, min=1e-6, soft_max=1, precision=4,
        description="Largest RMSE at the samples, in 1/sr. Lower values follow the measurements more closely and make "
                    "larger files")
    rendering: EnumProperty(
        name="Rendering", items=(*RENDERINGS, (_FAST, "Fast", "Nodes")), default=AUTOMATIC,
        update=_use_nodes_for_fast, description="How the material is rendered. It can be changed at any time")


def _reading_property(option: Option) -> Any:
    named = {"name": option.label, "description": option.tooltip, "default": option.to_stored(option.default)}
    if option.choices:
        return EnumProperty(items=[(choice.key, choice.label, choice.tooltip) for choice in option.choices], **named)
    return BoolProperty(**named) if isinstance(option.default, bool) else StringProperty(**named)


FitChoices.__annotations__.update({name: _reading_property(option) for name, option in OPTIONS.items()})


def draw_presets(layout: bpy.types.UILayout, choices: Any) -> None:
    """Draw the choice of a preset, of those that are offered."""
    _draw_enum(layout, choices, "preset", OFFERED)


def draw_rendering(layout: bpy.types.UILayout, choices: Any) -> None:
    _draw_enum(layout, choices, "rendering", [key for key, *_ in RENDERINGS])


def _draw_enum(layout: bpy.types.UILayout, choices: Any, name: str, keys: Sequence[str]) -> None:
    split = layout.split(factor=0.3)
    split.use_property_split = False        # Blender would split each value
    label = split.row()
    label.alignment = "RIGHT"
    label.label(text=name.capitalize())
    row = split.row(align=True)
    for key in keys:
        row.prop_enum(choices, name, key)


def fit_arguments(choices: Choices) -> Arguments:
    """The arguments of the fit that `choices` ask for.

    Not a method: bpy 4.2 as a module crashes at exit if a property group has had a base class with functions.
    """
    if choices.use_tolerance:
        return {"tolerance": round(choices.tolerance, 7)}
    arguments = _PRESET_ARGUMENTS.get(choices.preset, _PAPER) | {name: getattr(choices, name) for name in FIT_LEVELS}
    arguments["compression"] = round(arguments["compression"], 4)       # single precision does not hold 99.9 exactly
    if choices.specular_level == NO_SPECULAR_LEVEL:
        arguments["specular_level"] = None
    return arguments


def use_preset(choices: Choices, name: str) -> None:
    choices.preset, choices.use_tolerance = name, False
    _use_levels(choices, name)


def _use_levels(choices: Choices, name: str) -> None:
    for level in FIT_LEVELS:
        value = _PRESET_ARGUMENTS[name][level]
        setattr(choices, level, NO_SPECULAR_LEVEL if value is None else value)


def fitted_arguments(settings: Any) -> Arguments | None:
    """The arguments that a material was fitted with; None where it does not know them."""
    try:
        arguments = json.loads(settings.fitted_as)
    except ValueError:
        return None
    return arguments if isinstance(arguments, dict) else None


def is_as_fitted(settings: Any, digest: str | None) -> bool:
    """Whether another fit with a material's settings would be the one that it has, of measurements with this digest,
    if it is known."""
    return settings.fitted_as == as_text(fit_arguments(settings)) and digest in (None, settings.digest)


def label_of_fit(settings: Any) -> str:
    name = name_of_fit(settings)
    return _PRESET_LABELS.get(name, name)


def name_of_fit(settings: Any) -> str:
    """A material's fit by the name of its preset, or its levels; that of the starter library by the name of that."""
    arguments = fitted_arguments(settings)
    if arguments == ready.ARGUMENTS and published.parse_virtual_path(settings.filepath) is not None:
        return "Material Library"
    if arguments is not None and "tolerance" in arguments:
        return f"Auto {settings.fitted_levels}"
    return next((name for name, preset in _PRESET_ARGUMENTS.items() if arguments == preset), settings.fitted_levels)


class QualitySummary(NamedTuple):
    """What a material is worth."""

    line: str
    whole: str          # in full
    is_well: bool       # whether that is all one could wish for
    is_bad: bool = False

    @property
    def icon(self) -> Literal["CHECKMARK", "ERROR", "INFO"]:
        return "CHECKMARK" if self.is_well else "ERROR" if self.is_bad else "INFO"

    @property
    def level(self) -> Literal["INFO", "WARNING"]:
        return "WARNING" if self.is_bad else "INFO"


def quality_summary(settings: Any) -> QualitySummary:
    """What the fit of a material is worth; empty where it was not judged."""
    name = published.parse_virtual_path(settings.filepath)
    if name is not None:
        try:
            material = published.find(name)
            line = material.brief if material.is_computed else "Published fit, not a measurement"
            return QualitySummary(line, material.brief, material.is_computed)
        except DatasetError as error:
            return QualitySummary(str(error), str(error), False)
    if not settings.match >= 0 and (math.isnan(settings.rmse) or not settings.version):
        return QualitySummary("", "", False)             # its measurements are in no file, or nobody judged it
    judged = verdict.Verdict(*(getattr(settings, field) for field in verdict.Verdict._fields))
    is_adjusted = settings.adjusted != as_text({})
    line, whole, after = verdict.line(judged), verdict.sentence(judged), ""
    if is_adjusted:
        line = f"Match before adjusting: {verdict.grade(judged.match, verdict.MATCH_LIMITS)}"
        whole = f"Before it was adjusted: {whole}"
    is_bad = verdict.match_message(judged).is_bad
    if is_bad:
        after = _OF_THE_BEST if judged.match < 0 or name_of_fit(settings) == _BEST else _OF_OTHERS
    return QualitySummary(f"{line}{after}", f"{whole}{after}", verdict.is_well(judged) and not is_adjusted, is_bad)


def is_preset(choices: Choices, name: str) -> bool:
    mine = fit_arguments(choices)
    return choices.preset == name and not choices.use_tolerance and all(
        mine[key] == value or (isinstance(value, float) and math.isclose(mine[key], value))
        for key, value in _PRESET_ARGUMENTS[name].items())


class MeasuredMaterial(FitChoices, bpy.types.PropertyGroup):
    """Stored with the material. `material.assign` writes the results, which are read-only for users."""

    name_of_data: StringProperty(name="Data")
    digest: StringProperty(name="Digest")               # of the measurements
    asset_key: StringProperty(name="Asset Key")         # set for assets that a batch made
    version: StringProperty(name="Version")             # of the extension that made the fit
    coefficients: IntProperty(name="Coefficients")
    bytes: IntProperty(name="Bytes")
    rmse: FloatProperty(name="RMSE")
    mre: FloatProperty(name="MRE")
    seconds: FloatProperty(name="Seconds")
    fitted_levels: StringProperty(name="Levels")
    colours: StringProperty(name="Colours")             # reading.GREY, or the space
    fitted_as: StringProperty(name="Fitted As")         # JSON of fit_arguments
    match: FloatProperty(name="Match", default=UNKNOWN)         # quality.verdict.Verdict
    between: FloatProperty(name="Between", default=UNKNOWN)
    farthest: FloatProperty(name="Farthest")
    hole: FloatProperty(name="Widest Hole")
    least: FloatProperty(name="Least")
    adjusted: StringProperty(name="Adjusted")           # JSON of the edit that the shader has
    sphere: StringProperty(name="Sphere")               # as packed_picture.packed makes it
    changes: StringProperty(name="Changes")             # that made the fit physically plausible
    shown_theta: FloatProperty(
        name="Incidence", default=math.radians(40), min=0, max=math.radians(85), subtype="ANGLE",
        description="Angle of the light in the plane of incidence that is shown. Does not change the material")
    shown_phi: FloatProperty(
        name="Light's Azimuth", default=0, min=0, max=math.radians(360), subtype="ANGLE",
        description="Azimuth of the plane of incidence that is shown, counter-clockwise from the tangent to the light. "
                    "Does not change the material")


def default_choices(path: str) -> Choices:
    defaults = MeasuredMaterial.bl_rna.properties
    return SimpleNamespace(**{name: defaults[name].default for name in CHOICES} | {"filepath": path})


classes = (MeasuredMaterial,)
pointers = ((bpy.types.Material, "measured_brdf", PointerProperty(type=MeasuredMaterial, name="Measured BRDF")),)
