"""One table of the numbers that the shader and Python share."""

import re
from typing import get_args

import numpy as np

import fitter
from fitter import shader_constants
from fitter.cycles.bake import bake
from fitter.cycles.node_lobes import Kind
from fitter.cycles.node_mixture import CYCLES
from support.checkout import ROOT

SOURCES = {path.name: re.sub(r"/\*.*?\*/", "", path.read_text(), flags=re.DOTALL)
           for path in sorted((ROOT / "osl").glob("*"))}
KINDS = {kind.lower() for kind in get_args(Kind)}
TABLE = shader_constants.shader_constants()
OF_FORMULAS = {0, 0.25, 0.5, 1, 2, 3, 4, 5, 6}       # B-splines, Schlick's approximation, halves, thirds, squares
OF_CYCLES = {"mixture.h": {1.259, 0.396, 3.535, 2.181, 1.6, 1e-5}}      # Walter's masking; that of sheen


def test_every_constant_is_used_by_the_shader_or_by_another_constant():
    table = (ROOT / "fitter" / "shader_constants.py").read_text()
    for name in TABLE:
        derived = re.search(rf"^[A-Z_0-9]+ = .*\b{name}\b", table, re.MULTILINE)
        # the baker writes the kinds of a fit's lobes, each of which has a closure
        word = rf"\bADD_{name}\b" if name.removesuffix("_LOBE").lower() in KINDS else rf"\b{name}\b"
        assert derived or any(re.search(word, text) for text in SOURCES.values()), name


def test_the_shader_has_no_tuning_number_of_its_own():
    for name, source in SOURCES.items():
        numbers = re.findall(r"(?<![\w.])(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?", source)
        assert {float(number) for number in numbers} <= OF_FORMULAS | OF_CYCLES.get(name, set()), name


def test_literals_are_those_numbers_in_single_precision_and_floats_stay_floats():
    for name, literal in TABLE.items():
        value = getattr(shader_constants, name)
        assert np.float32(literal) == np.float32(value), name
        assert isinstance(value, float) == bool(re.search(r"[.e]", literal)), name


def test_all_of_them_are_baked_once(glossy):
    source = bake(fitter.fit(glossy, 1, None))
    for name, literal in TABLE.items():
        assert re.findall(rf"^#\s*define {name} (.*)$", source, re.MULTILINE) == [literal]


def test_all_closures_of_a_point_fit_into_the_pool_of_a_gpu():
    """Cycles on OptiX has a fixed number of bytes for them, and does not check its end (docs/devices.md)."""
    pool, ramp, microfacet, total, product = 1024, 128, 64, 24, 24
    ramps = shader_constants.CLOSURE_LIMITED_LOBES + 1               # of lamps, and the remainder
    closures = 1 + CYCLES.lobes + ramps
    needed = (1 + CYCLES.lobes) * microfacet + ramps * ramp + (closures - 1) * total
    mix_shader = 2 * product + total        # a user's, besides what is mixed in
    assert needed + mix_shader <= pool


def test_the_kinds_of_lobes_have_numbers_of_their_own():
    numbers = [getattr(shader_constants, f"{kind.upper()}_LOBE") for kind in get_args(Kind)]
    assert len(set(numbers)) == len(numbers)
