"""Baking a fit into OSL source: the readable shader of `osl/` with the fit's tables written into it.

Arrays that are initialised and never written become constants of the compiled shader. Nothing but numbers and the
project's own sources goes into the result: no name or path from the data.
"""

import re
from pathlib import Path

import numpy as np

from ..lattice import dense
from ..model import microfacet
from ..model.transform import STEEPEST, LogRelative
from ..samples import RGB
from . import closure_mixture as closures
from . import direction_grid, sampling_table
from .closure_mixture import closure_mixture

SHADER = "measured_brdf.osl"
SHADER_VERSION = 2          # of what is baked: 1 was that of extension 0.1.0, whose source does not name it
MAX_LAMPS = 32             # that a shader takes, as in osl/lamps.h
_INCLUDE = re.compile(r'^#include "(\w+\.h)"\n', re.MULTILINE)
_NUMBER = re.compile(r"inf|nan|\d+\.?\d*(?:e[-+]?\d+)?")
_LARGEST = np.finfo(np.float32).max
_SOURCES = Path(__file__).parents[2] / "osl"
MAX_ARRAY = 1_500_000       # the OSL compiler gives up somewhere beyond 1,000,000 to 3,000,000 literals in one array


def bake(fit, template=None, mixture=None):
    """OSL source that evaluates and renders `fit`.

    Parameters
    ----------
    fit : Fit
        With one channel, or three.
    template : str, optional
        The shader to fill in, `osl/measured_brdf.osl` by default. `#include "baked_constants.h"` and, inside the
        shader, `#include "baked_tables.h"` stand for what is baked; other includes are files of `osl/`.
    mixture : closure_mixture.Mixture, optional
        That of the fit, where it is at hand already.

    Returns
    -------
    str

    Raises
    ------
    ValueError
        If the fit has another number of channels, is too large for the OSL compiler, or would write a number that is
        not finite in single precision.
    """
    if len(fit.channels) not in (1, len(RGB)):
        raise ValueError(f"a fit of {len(fit.channels)} channels; a shader takes 1 or 3")
    constants, tables = _fit(fit)
    constants["SHADER_VERSION"] = SHADER_VERSION
    mixture_constants, mixture_tables = _mixture(closure_mixture(fit) if mixture is None else mixture)
    constants |= mixture_constants
    tables |= mixture_tables
    generated = {
        "lamp_parameters.h": _lamp_parameters(),
        "baked_constants.h": "".join(f"#define {name} {_constant(name, value)}\n" for name, value in constants.items()),
        "baked_tables.h": "".join(_array(name, table) for name, table in tables.items())}

    def include(match):
        name = match[1]
        return generated[name] if name in generated else (_SOURCES / name).read_text("utf-8")

    return _INCLUDE.sub(include, (_SOURCES / SHADER).read_text("utf-8") if template is None else template)


def fast_error(source):
    """The error of Fast rendering, `closure_mixture.Mixture.error`, that is baked into OSL source."""
    return float(re.search(r"^#define FAST_ERROR (\S+)$", source, re.MULTILINE)[1])


def shader_version(source):
    """The version of the extension's shader that OSL source was baked from, as `SHADER_VERSION` counts them."""
    found = re.search(r"^#define SHADER_VERSION (\d+)$", source, re.MULTILINE)
    return int(found[1]) if found else 1


def interface(source):
    """A shader with the parameters of a baked one that does nothing: OSL source that compiles at once."""
    start = source.index("shader measured_brdf(")
    return source[start:source.index(")\n{", start)] + ")\n{\n}\n"


def _fit(fit):
    """What `osl/lattice.h` reads: (constants, tables)."""
    stored = fit.diffuse.control_points.shape[-1]
    constants = {"STORED": stored, "DIFFUSE_CELLS": dense.cells(fit.diffuse_level)}
    constants |= {f"CHANNEL_{i}": fit.columns[i % len(fit.columns)] for i in range(3)}
    tables = {"DIFFUSE": fit.diffuse.control_points}
    sparse = fit.specular is not None and len(fit.specular) > 0
    constants["SPARSE"] = int(sparse)
    if sparse:
        index = fit.specular.index
        constants |= {"SPECULAR_CELLS": dense.cells(fit.specular_level), "KEY_COUNT": len(index),
                      "BUCKET_COUNT": len(index.displacement), "MULTIPLIER": index.multiplier}
        tables |= {"SPECULAR": fit.specular.coefficients, "KEYS": index.keys, "DISPLACEMENT": index.displacement}
    constants["PRIOR"] = int(isinstance(fit.transform, LogRelative))
    if isinstance(fit.transform, LogRelative):
        constants |= _prior(fit)
    return constants, tables


def _prior(fit):
    lobe = fit.transform.prior

    def value(columns):
        numbers = columns[list(fit.columns)] if len(columns) > 1 else columns
        text = ", ".join(f"{number:.9g}" for number in numbers)
        return f"color({text})" if len(numbers) > 1 else f"({text})"

    lobes = " ".join(f"LOBE({value(ks)}, {alpha ** -2:.9g}, {gamma:.9g}, {f0:.9g}, {min(alpha, 1.0) ** 2:.9g})"
                     for ks, alpha, gamma, f0 in zip(lobe.ks, lobe.alpha, lobe.gamma, lobe.f0, strict=True))
    return {"PRIOR_LOBES": lobes, "PRIOR_KD": value(lobe.kd), "PRIOR_OFFSET": f"{fit.transform.offset:.9g}",
            "PRIOR_CEILING": value(fit.transform.ceiling), "SOFTENING_2": f"{fit.coordinates.softening ** 2:.9g}",
            "STEEPEST": STEEPEST, "DENSEST": microfacet.DENSEST}


def _mixture(mixture):
    """What the closure mixture and the draw table add: (constants, tables)."""
    constants = {"CHANNELS": mixture.table.shape[-1], "VIEWS": direction_grid.VIEWS,
                 "GRAZING": f"{direction_grid.GRAZING:.9g}", "ROW": closures.ROW, "WEIGHTS": closures.WEIGHTS,
                 "MICROFACET": closures.MICROFACET, "DRAWN": closures.DRAWN, "SHARE": closures.SHARE,
                 "REPLACED": closures.REPLACED, "ROUGHNESS": mixture.roughness,
                 "EXPONENT_0": float(mixture.exponents[0]), "EXPONENT_1": float(mixture.exponents[1]),
                 "DRAW_RINGS": direction_grid.RINGS, "DRAW_SECTORS": direction_grid.SECTORS,
                 "DRAW_CELLS": direction_grid.RINGS * direction_grid.SECTORS, "FAST_ERROR": f"{mixture.error:.6g}"}
    solid_angle = direction_grid.grid().solid_angle
    return constants, {"MIXTURE": mixture.table, "OFFSET": mixture.offset,
                       "DRAW_REST": sampling_table.draw_table(mixture.rest, solid_angle, 0.1),
                       "DRAW_ALL": sampling_table.draw_table(mixture.reflected, solid_angle, 0.02)}


def _lamp_parameters():
    """The shader's parameters for the lamps, and a macro that does something for each."""
    numbers = range(1, MAX_LAMPS + 1)
    lines = [f"                     vector Lamp{n} = 0.0, vector Extent{n} = 0.0,\n" for n in numbers]
    lines.append("#define EACH_LAMP(DO) " + " ".join(f"DO({n})" for n in numbers) + "\n")
    return "".join(lines)


def _constant(name, value):
    """The text of a constant, each number of which has to be one to the shader."""
    text = str(value)
    numbers = np.array(_NUMBER.findall(text), dtype=float)
    if not (np.abs(numbers) <= _LARGEST).all():
        raise ValueError(f"{name} is {text}, expected numbers that are finite in single precision")
    return text


def _array(name, table):
    if not (table.min() >= -_LARGEST and table.max() <= _LARGEST):
        raise ValueError(f"the table {name} holds numbers that are not finite in single precision")
    if table.size > MAX_ARRAY:
        raise ValueError(f"{table.size:,} numbers in one table, at most {MAX_ARRAY:,} can be compiled: choose a lower "
                         f"level, or a compression that drops more")
    kind, form = ("int", "%d") if np.issubdtype(table.dtype, np.integer) else ("float", "%.9g")
    flat = table.ravel().tolist()
    lines = [",".join([form] * len(flat[start:start + 16])) for start in range(0, len(flat), 16)]
    return f"  {kind} {name}[{len(flat)}] = {{\n" + ",\n".join(lines) % tuple(flat) + "};\n"
