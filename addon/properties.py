"""What a measured material remembers: the data it came from, the choices for the fit, and what came out."""

import bpy
from bpy.props import EnumProperty, FloatProperty, IntProperty, PointerProperty, StringProperty

from ..fitter import PRESETS
from ..fitter.lattice import MAX_LEVEL

NO_SPECULAR_LEVEL = -1
_PAPER = PRESETS["Paper"]


class FitChoices:
    """The choices for a fit, shared by the import operator and the material.

    A mix-in: Blender collects the annotations of the class that is registered and of its bases.
    """

    filepath: StringProperty(
        name="File", subtype="FILE_PATH",
        description="Measured reflectance: CURET abrdf.dat, Cornell .astm, pbrt-v2 .brdf or Cornell paint.reformat.mat")
    sample: StringProperty(
        name="Sample",
        description="Which of the samples in a CURET file: its number or its name. Empty for the first, and for files "
                    "that hold just one")
    diffuse_level: IntProperty(
        name="Diffuse Level", default=_PAPER["diffuse_level"], min=0, max=MAX_LEVEL, soft_max=6,
        description="Fineness of the dense lattice that carries the broad shape. Higher levels ring less between the "
                    "measured directions; each multiplies the storage by up to 8")
    specular_level: IntProperty(
        name="Specular Level", default=_PAPER["specular_level"], min=NO_SPECULAR_LEVEL, max=MAX_LEVEL, soft_max=7,
        description="Fineness of the sparse lattice that carries highlights. Higher levels make them narrower and "
                    "brighter, as measured. -1 for none: the diffuse level alone")
    compression: FloatProperty(
        name="Compression", default=_PAPER["compression"], min=0, max=100, subtype="PERCENTAGE", precision=1,
        description="Share of the specular lattice that is dropped, smallest first. Higher makes a smaller file and "
                    "a flatter highlight")


def fit_arguments(choices):
    """Keyword arguments for `fitter.fit` from `FitChoices`.

    Not a method: bpy 4.2 as a module crashes at exit once a class with functions of its own has been a property group.
    """
    plain = choices.specular_level == NO_SPECULAR_LEVEL
    return {"diffuse_level": choices.diffuse_level, "specular_level": None if plain else choices.specular_level,
            "compression": choices.compression}


METHODS = (
    ("EXACT", "Exact", "What was measured, under every light; a little noisier and slower"),
    ("FAST", "Fast", "The nearest that Cycles samples by itself: as measured at lamps and in sum, not everywhere"))


def _method(settings):
    return int(not _exact_input(settings).default_value)


def _set_method(settings, value):
    _exact_input(settings).default_value = value == 0


def _exact_input(settings):
    """The node's input, where the choice is stored."""
    from . import material

    return material.group_node(settings.id_data).inputs["Exact"]


class MeasuredMaterial(FitChoices, bpy.types.PropertyGroup):
    """Stored with the material; the result is written by `material.assign` and only shown afterwards."""

    method: EnumProperty(name="Method", items=METHODS, get=_method, set=_set_method,
                         description="How the material is rendered")
    name_of_data: StringProperty(name="Data")
    coefficients: IntProperty(name="Coefficients")
    bytes: IntProperty(name="Bytes")
    rmse: FloatProperty(name="RMSE")
    mre: FloatProperty(name="MRE")
    seconds: FloatProperty(name="Seconds")


def register():
    bpy.utils.register_class(MeasuredMaterial)
    bpy.types.Material.measured_brdf = PointerProperty(type=MeasuredMaterial, name="Measured BRDF")


def unregister():
    del bpy.types.Material.measured_brdf
    bpy.utils.unregister_class(MeasuredMaterial)
