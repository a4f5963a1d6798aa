"""A fit and its OSL source: what `bake` writes, `unbake` reads back."""

import re

import numpy as np
import pytest

import fitter
from fitter.cycles.bake import SHADER_VERSION, bake, shader_version
from fitter.cycles.unbake import unbake
from support.checkout import ROOT
from support.made_fits import MADE_FITS
from support.mixtures import any_mixture

DATA = ROOT / "tests" / "data"
SEVEN_DIGITS = 6e-7             # as tables are written, rounded to single precision


@pytest.mark.parametrize("name", MADE_FITS)
def test_every_part_of_a_fit_comes_back_from_its_shader(name, random):
    fit = MADE_FITS[name]
    source = bake(fit, mixture=any_mixture(fit))
    back = unbake(source, fit.name, fit.compression)
    assert (back.coefficient_count, back.nbytes) == (fit.coefficient_count, fit.nbytes)
    for part in ("name", "channels", "columns", "compression", "diffuse_level", "specular_level"):
        assert getattr(back, part) == getattr(fit, part), part
    assert type(back.coordinates) is type(fit.coordinates)
    assert vars(back.coordinates) == pytest.approx(vars(fit.coordinates), rel=1e-8)
    assert back.transform.prior.kinds == fit.transform.prior.kinds
    for part in ("kd", "ks", "alpha", "gamma", "f0", "across", "turn"):
        np.testing.assert_allclose(getattr(back.transform.prior, part), getattr(fit.transform.prior, part), rtol=1e-7)
    assert back.transform.damping.size == fit.transform.damping.size
    if fit.transform.damping.size:
        np.testing.assert_allclose(back.transform.damping, fit.transform.damping, rtol=SEVEN_DIGITS)
    np.testing.assert_allclose(back.diffuse.control_points, fit.diffuse.control_points, rtol=SEVEN_DIGITS)
    angles = random.random((4, 2000)) * [[1.57], [6.3], [1.57], [6.3]]
    np.testing.assert_allclose(back.evaluate(*angles), fit.evaluate(*angles), rtol=1e-6, atol=1e-7)
    # all that is read is there again, in the same words; widths come back by way of their squares or inverses
    def rounded(line):
        return re.sub(r"\d+\.\d+(?:e-?\d+)?", lambda number: f"{float(number[0]):.6g}", line[0])

    def words(text):
        return re.sub(r"^#define .*$", rounded, text, flags=re.MULTILINE)

    assert words(bake(back, mixture=any_mixture(fit))) == words(source)


def test_a_shader_of_the_first_release_comes_back_and_is_baked_as_one_of_this_version():
    """What extension 0.1.0 baked of a fit that its file holds."""
    source = (DATA / "shader_version_1.osl").read_text("utf-8")
    fit, back = fitter.Fit.load(DATA / "version_2.npz"), unbake(source)
    again = bake(back, mixture=any_mixture(back))
    assert (shader_version(source), shader_version(again)) == (1, SHADER_VERSION)
    assert back.coordinates == fit.coordinates
    assert back.transform.prior.kinds == ("mirror",)
    assert back.transform.damping.size == 0
    directions = np.random.default_rng(5).random((4, 2000)) * [[1.57], [6.3], [1.57], [6.3]]
    for found in (back, unbake(again)):
        np.testing.assert_allclose(found.evaluate(*directions), fit.evaluate(*directions), rtol=1e-6)


@pytest.mark.parametrize(("pattern", "replacement"), [
    (r"DAMPING\[", "DAMPENING["), (r"#define HALF_DIFFERENCE 0\n", ""), (r"#define LOG_RELATIVE 1\n", ""),
    (r"(DAMPING\[\d+\] = \{\n)[^,]*,", r"\1"), (r"(DAMPING\[\d+\] = \{\n)[^,]*,", r"\1nan,"),
    (r"#define STRETCH \S+", "#define STRETCH x"), (r"RETRO\(color", "RETRO(colour"),
    (r"SHEEN\(", "VELVET(")])
def test_a_damaged_source_is_refused(pattern, replacement):
    fit = MADE_FITS["Rusinkiewicz, stretched by 33, all lobes, damped"]
    source = bake(fit, mixture=any_mixture(fit))
    damaged, count = re.subn(pattern, replacement, source)
    assert count
    with pytest.raises(ValueError, match=r"shader|table|convert"):
        unbake(damaged)
