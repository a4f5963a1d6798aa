"""What a measured material remembers: the data it came from, the choices for the fit, and what came out."""

import math

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty, StringProperty

from ...fitter import PRESETS
from ...fitter.formats import KNOWN_FILES
from ...fitter.lattice.dense import MAX_LEVEL

NO_SPECULAR_LEVEL = -1
LEVELS = ("diffuse_level", "specular_level", "compression")
RESULTS = ("name_of_data", "digest", "coefficients", "bytes", "rmse", "mre", "seconds", "fitted_levels", "changes",
           "version")
CHOICES = ("filepath", "sample", "preset", *LEVELS, "use_tolerance", "tolerance")
PRESET_HELP = {
    "Draft": "The smooth shape alone, a few KB, for look development: peaks of single directions are lost",
    "Standard": "What a scene is rendered with: a few tens of KB, close to the measurements and smooth between them",
    "Reference": "Every sample as it was measured, the narrowest highlights included: the largest files",
    "Paper": "Exactly the method and the levels of Kameya and Lewis (2002): highlights can ripple between the measured "
             "directions",
}
PRESET_ITEMS = tuple((name, name, PRESET_HELP.get(name, "")) for name in sorted(PRESETS, key=list(PRESET_HELP).index))
_PAPER = PRESETS["Paper"]


class FitChoices:
    """The choices for a fit, shared by the import operators and the material.

    A mix-in: Blender collects the annotations of the class that is registered and of its bases.
    """

    filepath: StringProperty(
        name="File", subtype="FILE_PATH",
        description=f"Measured reflectance: {KNOWN_FILES}")
    sample: StringProperty(
        name="Sample",
        description="Which of the samples in a CURET file: its number or its name. Empty for the first, and for files "
                    "that hold just one")
    preset: EnumProperty(
        name="Preset", items=PRESET_ITEMS, default="Paper",
        description="The method of the fit, and levels to begin with")
    diffuse_level: IntProperty(
        name="Diffuse Level", default=_PAPER["diffuse_level"], min=0, max=MAX_LEVEL, soft_max=6,
        description="Fineness of the dense lattice that carries the broad shape. Higher levels ring less between the "
                    "measured directions; each multiplies the storage by up to 8")
    specular_level: IntProperty(
        name="Specular Level", default=_PAPER["specular_level"], min=NO_SPECULAR_LEVEL, max=MAX_LEVEL, soft_max=7,
        description="Fineness of the sparse lattice that carries highlights. Higher levels make them narrower and "
                    "brighter, as measured. -1 for none: the diffuse level alone")
    compression: FloatProperty(
        name="Compression", default=_PAPER["compression"], min=0, max=100, subtype="PERCENTAGE", precision=2,
        description="Share of the specular lattice that is dropped, smallest first. Higher makes a smaller file and "
                    "a flatter highlight")
    use_tolerance: BoolProperty(
        name="Auto", default=False,
        description="Take the smallest fit whose error is within the tolerance, instead of these levels")
    tolerance: FloatProperty(
        name="Tolerance", default=0.05, min=1e-6, soft_max=1, precision=4,
        description="Largest root mean square error at the samples, in 1/sr. Smaller follows the measurements more "
                    "closely, and makes a larger file")


def fit_arguments(choices):
    """What decides a fit, as `work.fit` takes it, from `FitChoices`.

    Not a method: bpy 4.2 as a module crashes at exit once a class with functions of its own has been a property group.
    """
    if choices.use_tolerance:
        return {"tolerance": round(choices.tolerance, 7)}
    arguments = PRESETS.get(choices.preset, _PAPER) | {name: getattr(choices, name) for name in LEVELS}
    arguments["compression"] = round(arguments["compression"], 4)       # what single precision makes of 99.9
    if choices.specular_level == NO_SPECULAR_LEVEL:
        arguments["specular_level"] = None
    return arguments


def use_preset(choices, name):
    """Choose a preset, with its levels."""
    choices.preset, choices.use_tolerance = name, False
    for level in LEVELS:
        value = PRESETS[name][level]
        setattr(choices, level, NO_SPECULAR_LEVEL if value is None else value)


def is_preset(choices, name):
    """Whether the choices are those of a preset, unchanged."""
    mine = fit_arguments(choices)
    return choices.preset == name and not choices.use_tolerance and all(
        mine[key] == value or (isinstance(value, float) and math.isclose(mine[key], value))
        for key, value in PRESETS[name].items())


def complete(operator):
    """Give an operator the levels of its preset where it was called without any."""
    given = operator.properties.is_property_set
    if given("preset") and not any(given(level) for level in LEVELS):
        use_tolerance = operator.use_tolerance
        use_preset(operator, operator.preset)
        operator.use_tolerance = use_tolerance


class MeasuredMaterial(FitChoices, bpy.types.PropertyGroup):
    """Stored with the material; the result is written by `material.assign` and only shown afterwards."""

    name_of_data: StringProperty(name="Data")
    digest: StringProperty(name="Digest")               # of the measurements
    asset_key: StringProperty(name="Asset Key")         # of an asset that a batch made
    version: StringProperty(name="Version")             # of the extension that made the fit; 0.1.0 left it empty
    coefficients: IntProperty(name="Coefficients")
    bytes: IntProperty(name="Bytes")
    rmse: FloatProperty(name="RMSE")
    mre: FloatProperty(name="MRE")
    seconds: FloatProperty(name="Seconds")
    fitted_levels: StringProperty(name="Levels")
    changes: StringProperty(name="Changes")             # to the fit, for the sake of physics
    shown_theta: FloatProperty(
        name="Incidence", default=math.radians(40), min=0, max=math.radians(85), subtype="ANGLE",
        description="Angle of incidence of the polar plot. It changes nothing in the material")


def register():
    bpy.utils.register_class(MeasuredMaterial)
    bpy.types.Material.measured_brdf = PointerProperty(type=MeasuredMaterial, name="Measured BRDF")


def unregister():
    del bpy.types.Material.measured_brdf
    bpy.utils.unregister_class(MeasuredMaterial)
