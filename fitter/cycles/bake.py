"""Baking a fit into OSL source: the shader of `osl/` with the fit's tables, constants of the compiled shader as they
are never written. It holds nothing but numbers and the project's own sources: no name or path from the data."""

import math
import re
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray
from ..coordinates.anisotropic_nusselt import AnisotropicNusselt
from ..coordinates.anisotropic_rusinkiewicz import AnisotropicRusinkiewicz
from ..coordinates.half_angle import HalfAngle
from ..coordinates.half_difference import HalfDifference
from ..coordinates.nusselt import Nusselt
from ..coordinates.rusinkiewicz import Rusinkiewicz
from ..lattice import dense, perfect_hash
from ..model import microfacet
from ..model.fit import Fit
from ..model.transform import LogRelative
from ..samples import RGB
from ..shader_constants import KNOTS, LOBE_EDGE_KNOT, MAX_LAMPS, shader_constants
from .node_mixture import NodeMixture, cycles_mixture

SHADER = "measured_brdf.osl"
MIX_SHADER = "mix.osl"
SHADER_VERSION = 12         # of the function that a baked shader computes
_INCLUDE = re.compile(r'^#include "(\w+\.h)"\n', re.MULTILINE)
_SHADER_COMMENT = re.compile(r"/\*.*?\*/", re.DOTALL)
_BLANK = re.compile(r"^[ \t]*\n", re.MULTILINE)
_NUMBER = re.compile(r"inf|nan|\d+\.?\d*(?:e[-+]?\d+)?")
_LARGEST = np.finfo(np.float32).max
# where the tangent points: given, or as the mesh has it by default; and by how much of a turn it is turned
_TANGENT_PARAMETERS = """\
                     vector Tangent = 0.0 [[string help = "Direction of the surface; unconnected, that of the mesh"]],
                     vector MeshTangent = 0.0,
                     float Rotation = 0.0 [[string help = "Turns the tangent about the normal; 1 is a whole turn"]],
"""
_SOURCES = Path(__file__).parents[2] / "osl"
_LINE_NUMBERS = 1000        # numbers of a table
MAX_ARRAY = 1_500_000       # numbers of a table: the OSL compiler takes 1,000,000 in one array, and refuses 3,000,000


def bake(fit: Fit, template: str | None = None, mixture: NodeMixture | None = None) -> str:
    """OSL source that evaluates and renders a fit of one channel or three; the mixture is `cycles_mixture` of the fit,
    if the caller has it.

    What is baked replaces `#include "baked_constants.h"` and, inside the shader, `#include "baked_tables.h"` of a
    template, by default `osl/measured_brdf.osl`; other includes are files of `osl/`. Raises ValueError if the fit has
    another number of channels, is too large for the OSL compiler, or holds a number that is not finite in single
    precision.
    """
    if len(fit.channels) not in (1, len(RGB)):
        raise ValueError(f"a fit of {len(fit.channels)} channels; a shader takes 1 or 3")
    constants, tables = _fit(fit)
    constants |= shader_constants()
    mixture = cycles_mixture(fit) if mixture is None else mixture
    mixture_constants, mixture_tables = _mixture(mixture)
    constants |= mixture_constants
    tables |= mixture_tables | {"FLAT_RAMP": _flat_ramp()}
    generated = {
        "lamp_parameters.h": _lamp_parameters(),
        "tangent_parameters.h": _TANGENT_PARAMETERS if constants["ANISOTROPIC"] else "",
        "baked_constants.h": "".join(f"#define {name} {_constant(name, value)}\n" for name, value in constants.items()),
        "baked_tables.h": "".join(_array(name, table) for name, table in tables.items())}
    return _expand_includes((_SOURCES / SHADER).read_text("utf-8") if template is None else template, generated)


def _expand_includes(template: str, generated: dict[str, str]) -> str:
    """A shader with its includes, generated ones and files of `osl/`, each file once, and without comments."""
    included: set[str] = set()

    def include(match: re.Match[str]) -> str:
        name = match[1]
        if name in generated:
            return generated[name]
        if name in included:
            return ""
        included.add(name)
        return _INCLUDE.sub(include, (_SOURCES / name).read_text("utf-8"))

    return _BLANK.sub("", _SHADER_COMMENT.sub("", _INCLUDE.sub(include, template)))


def mix_source() -> str:
    """OSL source of the shader that tells how strong two mixed materials are in a sample."""
    constants = "".join(f"#define {name} {value}\n" for name, value in shader_constants().items()
                        if name.startswith(("MOST_MIXED", "RANDOM_", "SEED_")))
    return _expand_includes((_SOURCES / MIX_SHADER).read_text("utf-8"), {"baked_constants.h": constants})


def interface(source: str) -> str:
    """OSL source of an empty shader with the parameters of a baked one, which compiles at once."""
    start = source.index("shader measured_brdf(")
    return source[start:source.index(")\n{", start)] + ")\n{\n}\n"


def _fit(fit: Fit) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """What `osl/fit.h` reads: (constants, tables)."""
    stored = fit.diffuse.control_points.shape[-1]
    constants = {"STORED": stored, "DIFFUSE_CELLS": dense.cells(fit.diffuse_level)}
    constants |= {f"CHANNEL_{i}": fit.columns[i % len(fit.columns)] for i in range(3)}
    tables: dict[str, NDArray[Any]] = {"DIFFUSE": fit.diffuse.control_points}
    specular = fit.specular if fit.specular is not None and fit.specular.count else None
    constants["SPARSE"] = int(specular is not None)
    if specular is not None:
        index = specular.index
        constants |= {"SPECULAR_CELLS": dense.cells(specular.level), "KEY_COUNT": len(index),
                      "BUCKET_COUNT": len(index.displacement), "MULTIPLIER": index.multiplier}
        count = math.prod(dense.shape(specular.level, specular.axes))
        tables |= {"SPECULAR": specular.coefficients, "OCCUPANCY": perfect_hash.occupancy(index.keys, count),
                   "DISPLACEMENT": index.displacement}
    constants["DAMPED"] = 0
    if fit.transform is not None and len(fit.transform.damping):
        constants["DAMPED"] = 1
        tables["DAMPING"] = fit.transform.damping
    if fit.edit is not None and len(fit.edit.balance):
        tables["BALANCE"] = fit.edit.balance
    if fit.edit is not None and len(fit.edit.through):
        tables["COAT_TRANSMITTANCE"] = np.repeat(fit.edit.through, stored, axis=1)
    return constants | _coordinates(fit) | _transform(fit.transform, fit.columns) | _edit(fit), tables


def _stretch(name: str, stretch: float) -> dict[str, Any]:
    """Whether there is a stretch, and what `coordinates.stretch` multiplies by."""
    return {f"{name}ED": int(stretch > 0), **({f"{name}": f"{stretch:.9g}",
                                               f"{name}_SCALE": f"{1 / np.arcsinh(stretch):.9g}"} if stretch else {})}


# Coordinates are told by their names, not by their classes: a script may bring a fit of its own copy of
# this package to the extension's.

def _coordinates(fit: Fit) -> dict[str, Any]:
    """What `osl/coordinates.h` reads."""
    systems = {"HALF_DIFFERENCE": HalfDifference.name, "RUSINKIEWICZ": Rusinkiewicz.name, "HALF_ANGLE": HalfAngle.name,
               "ANISOTROPIC_RUSINKIEWICZ": AnisotropicRusinkiewicz.name, "ANISOTROPIC_NUSSELT": AnisotropicNusselt.name}
    system: Any = fit.coordinates
    name = system.name
    constants: dict[str, Any] = {constant: int(name == each) for constant, each in systems.items()}
    constants["AXES"] = len(system.axes)
    if name in (HalfDifference.name, Rusinkiewicz.name, HalfAngle.name):
        constants |= {"SOFTENING_2": f"{system.softening ** 2:.9g}", **_stretch("STRETCH", system.stretch)}
        if name == HalfAngle.name:
            constants |= _stretch("BACK_STRETCH", system.back_stretch)
    elif name == AnisotropicRusinkiewicz.name:
        constants |= {"STRETCH_ALONG": f"{system.along:.9g}", "STRETCH_ACROSS": f"{system.across:.9g}",
                      "STRETCH_SCALE": f"{1 / np.arcsinh(max(system.along, system.across)):.9g}",
                      "ROTATION_COSINE": f"{math.cos(system.turn):.9g}",
                      "ROTATION_SINE": f"{math.sin(system.turn):.9g}"}
    elif name not in (Nusselt.name, AnisotropicNusselt.name):
        raise ValueError(f"the shader has no {name} coordinates")
    return constants


def _transform(transform: LogRelative | None, columns: tuple[int, ...]) -> dict[str, Any]:
    """What `osl/fit.h` and `osl/prior.h` read."""
    if transform is None:
        return {"LOG_RELATIVE": 0}
    prior = transform.prior

    def value(stored: FloatArray) -> str:
        return _value(stored[list(columns)] if len(stored) > 1 else stored)

    def lobe(kind: microfacet.Kind, ks: FloatArray, alpha: float, gamma: float, f0: float,
             across: float | None = None, turn: float = 0.0) -> str:
        # a lobe of two widths, or a fibre, has its rotation first
        if across is not None and (kind == "fibre" or across != alpha):
            macro, numbers = "FIBRE", [1 / alpha, across, gamma, f0]
            if kind != "fibre":
                macro, numbers = "ANISOTROPIC_LOBE", [1 / alpha, 1 / across, gamma, f0, min(alpha, 1.0),
                                                      min(across, 1.0)]
            text = ", ".join(f"{number:.9g}" for number in (math.cos(turn), math.sin(turn), *numbers))
            return f"{macro}({value(ks)}, {text})"
        # a lobe of one width
        shape = f"{value(ks)}, {alpha ** -2:.9g}"
        if kind == "retro":
            return f"RETRO({shape}, {gamma:.9g}, {f0:.9g})"
        if kind == "sheen":
            return f"SHEEN({shape}, {f0:.9g})"
        return f"LOBE({shape}, {gamma:.9g}, {f0:.9g}, {min(alpha, 1.0) ** 2:.9g})"

    # the prior, and the transform relative to it
    lobes = [lobe(kind, ks, *shape) for kind, ks, shape in zip(prior.kinds, prior.ks, prior.shapes, strict=True)]
    return {"LOG_RELATIVE": 1, "PRIOR_LOBES": " ".join(lobes), "PRIOR_RETRO": int("retro" in prior.kinds),
            "PRIOR_ANISOTROPIC": int(not prior.isotropic), "PRIOR_KD": value(prior.kd),
            "PRIOR_OFFSET": f"{transform.offset:.9g}", "PRIOR_CEILING": value(transform.ceiling),
            "DESATURATED": int(transform.desaturation > 0),
            "RESATURATION": f"{transform.desaturation / (1 - transform.desaturation):.9g}"}


def _edit(fit: Fit) -> dict[str, Any]:
    """What `osl/edit.h` reads."""
    edit = fit.edit
    if edit is None:
        return {"EDITED": 0, "WIDENED": 0, "COATED": 0}
    level = edit.level[list(fit.columns)] if len(edit.level) > 1 else edit.level
    return {"EDITED": 1, "WIDENED": int(len(edit.balance) > 0), "COATED": int(len(edit.through) > 0),
            "EDIT_LEVEL": _value(level), "EDIT_DIFFUSE": _value(edit.diffuse), "EDIT_HIGHLIGHT": _value(edit.highlight),
            "EDIT_WIDTH": f"{edit.width:.9g}", "COAT": f"{edit.coat:.9g}",
            "COAT_ALPHA_2": f"{edit.coat_width ** 2:.9g}"}


def _value(numbers: FloatArray) -> str:
    """A constant of one number, or of one for each channel."""
    text = ", ".join(f"{number:.9g}" for number in numbers)
    return f"color({text})" if len(numbers) > 1 else f"({text})"


def _mixture(mixture: NodeMixture) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """What `osl/mixture.h` reads: (constants, tables). A row has, for each stop, the shape and both colours of each
    lobe; then the rest of `Sampling`."""
    stops, lobes, phases, channels = mixture.colour.shape
    constants = {"CHANNELS": channels, "AZIMUTHAL_TERMS": phases, "POLAR_KNOTS": stops, "LOBES": lobes,
                 "EACH_LOBE(DO)": " ".join(f"DO({k}, {kind.upper()}_LOBE)" for k, kind in enumerate(mixture.kinds)),
                 "ANISOTROPIC": int(mixture.turn is not None)}
    if mixture.turn is not None:
        constants["PRINCIPAL_AZIMUTH"] = f"{mixture.turn:.9g}"
    shapes = np.stack(mixture.shape, axis=-1)
    if mixture.sampling is None:
        raise ValueError("a mixture that is not sampled; a shader takes that of Cycles")
    below, shares, probability, *reflected = mixture.sampling
    rows = [shapes, *(each.reshape(stops, lobes, -1) for each in (mixture.colour, below))]
    table = np.concatenate([np.concatenate(rows, axis=-1).reshape(stops, -1), shares, probability[:, None], *reflected],
                           axis=1)
    return constants, {"MIXTURE": table}


def _flat_ramp() -> FloatArray:
    """The ramp over c = cos^e of an angle that makes c ramp(c) flat from c = 1 down to the first knot: (KNOTS,). It is
    piecewise linear, 0 at c = 0, and its mean between two knots j / 7, weighted by solid angle, is 1: from the axis
    outward, knot[j] = 14 ln((j + 1) / j) - knot[j + 1]."""
    ramp = np.zeros(KNOTS)
    ramp[-1] = 1
    for j in range(KNOTS - 2, LOBE_EDGE_KNOT - 1, -1):
        ramp[j] = 2 * (KNOTS - 1) * math.log((j + 1) / j) - ramp[j + 1]
    return ramp


def _lamp_parameters() -> str:
    """The shader's parameters for the lamps, and a macro that expands another one for each lamp."""
    numbers = range(1, MAX_LAMPS + 1)
    lines = [f"                     vector Lamp{n} = 0.0, vector Extent{n} = 0.0,\n" for n in numbers]
    lines.append("#define EACH_LAMP(DO) " + " ".join(f"DO({n})" for n in numbers) + "\n")
    return "".join(lines)


def _constant(name: str, value: Any) -> str:
    """The text of a constant, whose numbers must all be finite in the shader."""
    text = str(value)
    numbers = np.array(_NUMBER.findall(text), dtype=float)
    if not (np.abs(numbers) <= _LARGEST).all():
        raise ValueError(f"{name} is {text}, expected numbers that are finite in single precision")
    return text


def _array(name: str, table: NDArray[Any]) -> str:
    """The declaration of a table, its numbers in one list."""
    if not (table.min() >= -_LARGEST and table.max() <= _LARGEST):
        raise ValueError(f"the table {name} holds numbers that are not finite in single precision")
    if table.size > MAX_ARRAY:
        raise ValueError(f"{table.size:,} numbers in one table, at most {MAX_ARRAY:,} can be compiled: choose a lower "
                         f"level, or a compression that drops more")
    kind, form = ("int", "%d") if np.issubdtype(table.dtype, np.integer) else ("float", "%.9g")
    flat = table.ravel().tolist()
    lines = [",".join([form] * len(flat[start:start + _LINE_NUMBERS])) for start in range(0, len(flat), _LINE_NUMBERS)]
    return f"  {kind} {name}[{len(flat)}] = {{\n" + ",\n".join(lines) % tuple(flat) + "};\n"
