"""Materials that were fitted for another colour space than that of the open file."""

from collections.abc import Iterator, Sequence

import bpy

from ...fitter.colours import COLOURS
from ..core.checks import Finding
from ..core.storage import reading


def check(looked_at: Sequence[bpy.types.Material]) -> Iterator[Finding]:
    """Materials with other colours, each with a button that fits it again where its measurements are at hand."""
    here = reading.scene_colours()
    coloured = [material for material in looked_at
                if material.measured_brdf.coefficients and material.measured_brdf.colours != reading.GREY]
    if coloured and not here:
        yield Finding("colours", f"The working space of this file is none of {', '.join(COLOURS)}: measured colours "
                      "are wrong in it. Choose one of these, or an OpenColorIO configuration that has one")
    for material in coloured:
        if fitted := reading.other_colours(material.measured_brdf, here):
            message = f"{material.name} was fitted for colours in {fitted}; those of this file are in {here}"
            if material.is_editable and reading.has_file(material):
                yield Finding(f"colours:{material.name}", f"{message}. It looks too pale or too saturated",
                              f"Refit it for {here}", lambda material=material: _refit(material))
            else:
                yield Finding(f"colours:{material.name}", f"{message}. Refit it in the file that it belongs to, and "
                              "where its measurements are")


def _refit(material: bpy.types.Material) -> None:
    with bpy.context.temp_override(material=material):
        bpy.ops.measured_brdf.fit()
