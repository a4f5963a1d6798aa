"""A fit is twice continuously differentiable across every seam of its coordinates.

The truth is Taylor's theorem: with f twice continuously differentiable at a pair of directions, value, gradient and
second derivatives leave a remainder that falls faster than the square of the step, whatever the direction of the step.
A jump leaves one that does not fall, a kink one that falls as the step, a bend without a second derivative one that
falls as its square.
"""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import fitter
from fitter import Samples
from fitter.arrays import unit_vectors as unit
from fitter.coordinates import ISOTROPIC_AXES
from fitter.coordinates.anisotropic_nusselt import AnisotropicNusselt
from fitter.coordinates.anisotropic_rusinkiewicz import AnisotropicRusinkiewicz
from fitter.coordinates.half_angle import HalfAngle
from fitter.coordinates.half_difference import HalfDifference
from fitter.coordinates.rusinkiewicz import Rusinkiewicz
from fitter.model.transform import LARGEST_EXPONENT
from fitter.samples import subset
from support import checkout
from support.cases import quick, release
from support.made_fits import made_fit

STEPS = 3e-4, 3e-5          # radians: far below the softening radius, and a cell of the finest stretched lattice
KRIGED = "Draft", "Standard", "Reference"
ANGLES = np.radians([3, 20, 45, 70, 85])
REAL = [("leather", preset) for preset in KRIGED] + [("aluminum foil", preset) for preset in KRIGED] + [
    ("krylon_blue_RGB", "Standard"), ("garnet_red", "Standard")]


def angles(w):
    return np.arctan2(np.hypot(w[..., 0], w[..., 1]), w[..., 2]), np.arctan2(w[..., 1], w[..., 0])


# pairs of directions on each seam: (n, 2, 3)
SEAMS = {
    "retro-reflection": [(unit(a, p), unit(a, p)) for a in ANGLES for p in (0.0, 2.5)],
    "both at the normal": [(unit(0.0, 0.0), unit(0.0, 0.0))],
    "normal incidence": [(unit(0.0, 0.0), unit(a, 0.4)) for a in ANGLES],
    "normal exitance": [(unit(a, 0.4), unit(0.0, 0.0)) for a in ANGLES],
    "plane of incidence, same side": [(unit(a, 0.7), unit(b, 0.7)) for a in ANGLES for b in ANGLES[::2] + 0.05],
    "plane of incidence, far side": [(unit(a, 0.7), unit(b, 0.7 + np.pi)) for a in ANGLES for b in ANGLES[::2] + 0.05],
    "mirror reflection": [(unit(a, 0.7), unit(a, 0.7 + np.pi)) for a in ANGLES],
    "azimuth wrap": [(unit(a, np.pi), unit(b, p)) for a in ANGLES[1:] for b, p in ((0.5, 1.0), (1.2, -2.0))],
    "one grazes": [(unit(np.pi / 2, 0.0), unit(a, p)) for a in ANGLES[::2] for p in (0.0, 1.0, 3.0)],
    "the other grazes": [(unit(a, p), unit(np.pi / 2, 0.0)) for a in ANGLES[::2] for p in (0.0, 1.0, 3.0)],
    "both graze": [(unit(np.pi / 2, 0.0), unit(np.pi / 2, p)) for p in (0.0, 0.5, 1.5)],
}
SEAMS = {name: np.array(pairs) for name, pairs in SEAMS.items()}
NOT_THE_PAPERS = "normal incidence", "both at the normal"       # where its coordinates have no azimuth


def steps(count=40, seed=5):
    """Steps of length 1 in the four tangent directions of a pair, with each its opposite: (2 count, 2, 2)."""
    step = np.random.default_rng(seed).standard_normal((count, 2, 2))
    step[:8, 0] = 0                                             # one direction alone, and both together
    step[8:16, 1] = 0
    step[16:20, 1] = step[16:20, 0]
    step /= np.linalg.norm(step, axis=(1, 2), keepdims=True)
    return np.concatenate([step, -step])


def around(pairs, length):
    """Pairs of directions near to some, and how far along their tangents: (n, m, 2, 3) and (n, m, 4).

    Where a direction grazes, steps are taken upward only.
    """
    theta, phi = angles(pairs)
    upward, sideward = -unit(theta + np.pi / 2, phi), unit(np.pi / 2, phi + np.pi / 2)         # (n, 2, 3)
    step = np.repeat(steps()[None], len(pairs), axis=0) * length                                # (n, m, 2, 2)
    grazes = (theta > np.pi / 2 - 1e-9)[:, None]
    step[..., 0] = np.where(grazes, np.abs(step[..., 0]), step[..., 0])
    tangent = step[..., :1] * upward[:, None] + step[..., 1:] * sideward[:, None]
    size = np.linalg.norm(tangent, axis=-1, keepdims=True)
    moved = np.cos(size) * pairs[:, None] + np.sinc(size / np.pi) * tangent
    moved[..., 2] = np.where(grazes, np.maximum(moved[..., 2], 0), moved[..., 2])
    return moved, step.reshape(*step.shape[:2], 4)


def values(fit, pairs):
    theta, phi = angles(pairs)
    return fit.evaluate(theta[..., 0], phi[..., 0], theta[..., 1], phi[..., 1])


def clipped(fit, pairs):
    """Where the floor or the steepest field holds: (..., channels) bool."""
    f, columns = values(fit, pairs), list(fit.columns)
    if fit.transform is None:
        return np.zeros(f.shape, dtype=bool)
    theta, phi = (angle.reshape(-1, 2) for angle in angles(pairs))
    transform = fit.transform
    prior = transform.prior.evaluate(theta[:, 0], phi[:, 0], theta[:, 1], phi[:, 1])[:, columns].reshape(f.shape)
    steepest = f + transform.offset >= 0.9 * np.exp(LARGEST_EXPONENT) * (prior + transform.offset)
    return (f <= transform.floor) | steepest


def remainders(fit, pairs):
    """What Taylor's polynomial of second order leaves at each step length, over the values' size: (2, n, channels)."""
    scale = np.abs(fit.diffuse.control_points).max() if fit.transform is None else fit.transform.offset
    size = np.abs(values(fit, pairs)) + scale
    rows, columns = np.triu_indices(4)
    left = []
    for length in STEPS:
        moved, step = around(pairs, length)
        change = values(fit, moved) - values(fit, pairs)[:, None]
        step = step / length
        terms = np.concatenate([step, step[..., rows] * step[..., columns]], axis=-1)
        rest = change - terms @ (np.linalg.pinv(terms) @ change)
        left.append(np.abs(rest).max(axis=1) / size)
    return np.array(left)


def smooth(fit, seam):
    """Whether a fit is twice differentiable, for every pair of a seam and channel that no clip is near: (m,) bool.

    Where both directions graze, once: a lobe there is the power 2 gamma > 2 of the distance. Left out is where they
    also coincide, if there is a retro-reflective lobe: its back vector vanishes, and the lobe has no limit.
    """
    pairs, order = SEAMS[seam], 1 if seam == "both graze" else 2
    free = ~clipped(fit, around(pairs, STEPS[0])[0]).any(axis=1)
    if fit.transform is not None and "retro" in fit.transform.prior.kinds:
        free &= (np.abs(pairs[:, 0] - pairs[:, 1]).max(axis=1) + pairs[:, 0, 2] > 1e-9)[:, None]
    large, small = remainders(fit, pairs)
    # coefficients are rounded to single precision, one by one: a lattice is symmetric to about 1e-7
    return (small <= 0.3 * (STEPS[1] / STEPS[0]) ** order * large + 1e-6 * STEPS[1])[free]


@cache
def synthetic(preset):
    """A fit of 300 samples that vary with all coordinates, and steeply about retro-reflection; without a floor."""
    random = np.random.default_rng(11)
    theta_i, theta_o = np.arcsin(np.sqrt(random.random((2, 300)) * 0.99))
    theta_o[::3] = theta_i[::3] + 0.1 * random.random(100)
    phi = np.where(np.arange(300) % 3, 2 * np.pi * random.random(300), 0.3 * random.standard_normal(300))
    cosine = (unit(theta_i, 0) * unit(theta_o, phi)).sum(axis=-1)
    f = 0.1 + 0.3 * np.exp(10 * (cosine - 1)) + 0.1 * np.sin(3 * theta_i) * np.cos(phi) * np.sin(theta_o) ** 2
    samples = Samples(theta_i, 0 * phi, theta_o, phi, np.stack([f, f[::-1], f * f], axis=-1), ("R", "G", "B"))
    return fitter.fit(samples, **fitter.PRESETS[preset], plausible=False)


@cache
def real(name, preset):
    folder = checkout.measurements()
    path = folder / "cornell" / f"{name}.astm"
    if not checkout.has_measurements(folder):
        pytest.skip(f"real measurements are absent from {folder}")
    samples = fitter.load(path) if path.is_file() else fitter.load(folder / "curet" / "abrdf.dat", name)
    return fitter.fit(samples, **fitter.PRESETS[preset])


MADE = {f"{system.__name__}, {stretch:g}, {'damped' if damped else 'not damped'}": (system(stretch=stretch), damped)
        for system in (HalfDifference, Rusinkiewicz, HalfAngle) for stretch in (0.0, 5.0, 33.0)
        for damped in (False, True)}
MADE |= {str(system): (system, False) for system in (
    AnisotropicNusselt(), AnisotropicRusinkiewicz(), AnisotropicRusinkiewicz(12.0, 3.0, 0.4),
    AnisotropicRusinkiewicz(33.0, 33.0, -2.0), HalfAngle(12.0, 33.0))}


@pytest.mark.parametrize("seam", SEAMS)
@pytest.mark.parametrize("name", quick(MADE, "HalfDifference, 5, not damped", "Rusinkiewicz, 33, damped",
                                       "HalfAngle, 33, not damped", str(HalfAngle(12.0, 33.0)),
                                       str(AnisotropicRusinkiewicz(12.0, 3.0, 0.4))))
def test_fits_of_every_part_are_smooth_across_the_seams(name, seam):
    """Random lattices, whose field has no reason to be smooth where the coordinates are not; all kinds of lobes."""
    coordinates, damped = MADE[name]
    kinds = ("mirror", "retro", "sheen" if len(coordinates.axes) == ISOTROPIC_AXES else "fibre")
    fit = made_fit(coordinates, kinds, (0, 1, 2), damped=damped)
    fit = replace(fit, transform=replace(fit.transform, ceiling=np.full(3, 1e9)))
    smoothed = smooth(fit, seam)
    assert len(smoothed) == 3 * (len(SEAMS[seam]) - (seam == "both graze"))
    assert smoothed.all()


@pytest.mark.parametrize("seam", SEAMS)
@pytest.mark.parametrize("preset", quick(KRIGED, "Standard"))
def test_fits_of_synthetic_data_are_smooth_across_the_seams(preset, seam):
    smoothed = smooth(synthetic(preset), seam)
    assert len(smoothed) > 2.3 * len(SEAMS[seam])
    assert smoothed.all()


@pytest.mark.parametrize("seam", SEAMS)
@pytest.mark.parametrize(("name", "preset"), REAL)
@release
def test_fits_of_real_data_are_smooth_across_the_seams(name, preset, seam):
    smoothed = smooth(real(name, preset), seam)
    assert len(smoothed)
    assert smoothed.all()


@pytest.mark.parametrize("stretch", [0.0, 5.0])
def test_without_softening_the_check_finds_retro_reflection_and_no_other_seam(stretch):
    fit = made_fit(HalfDifference(1e-6, stretch))
    rough = {seam for seam in SEAMS if not smooth(fit, seam).all()}
    # the others are cases of it, though at the normal the jump is as small as the step
    assert {"retro-reflection", "both graze"} <= rough <= {"retro-reflection", "both graze", "both at the normal"}


@pytest.mark.parametrize("seam", quick((name for name in SEAMS if name not in NOT_THE_PAPERS),
                                       "plane of incidence, same side"))
def test_the_papers_fit_is_smooth_but_at_normal_incidence(glossy, seam):
    fit = fitter.fit(subset(glossy, slice(400)), **fitter.PRESETS["Paper"])
    assert smooth(fit, seam).all()


def test_at_normal_incidence_the_papers_fit_depends_on_an_azimuth_that_is_not_there(glossy):
    fit = fitter.fit(subset(glossy, slice(400)), **fitter.PRESETS["Paper"])
    assert not smooth(fit, "normal incidence").all()
