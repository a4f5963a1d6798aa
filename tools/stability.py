"""The fits of every preset to the hard cases: ``python -m tools.stability`` prints the table of docs/stability.md."""

import sys
from dataclasses import replace

import numpy as np

import fitter
from fitter.coordinates.nusselt import Nusselt
from fitter.lattice import dense
from support.evidence import show_table
from support.hard_cases import BOUND, ERROR, hard_cases, probe

CONSTANT = "all values equal"


def measure(samples, fit):
    """What is expected of a fit: whether it is finite everywhere, not only at the samples; its largest absolute value
    anywhere, and its RMSE at the samples, over the largest absolute value of these."""
    everywhere = fit.evaluate(*probe())
    scale = np.abs(samples.values).max() or 1.0
    error = np.sqrt(np.mean((fit.evaluate(*samples.directions) - samples.values) ** 2 / scale ** 2))
    return bool(np.isfinite(everywhere).all()), float(np.abs(everywhere).max() / scale), float(error)


def errors_by_level(samples, levels=range(8)):
    """RMSE at the samples of plain MBA, level by level, over the largest absolute value."""
    return [measure(samples, fitter.fit(samples, level, None))[2] for level in levels]


def single_precision(fit, directions):
    """The lattices of a fit evaluated in float32 throughout: (n, channels) float32."""
    x = Nusselt().encode(*directions).astype(np.float32)
    total = _lattice_in_single(fit.diffuse.control_points, fit.diffuse_level, x)
    if fit.specular is not None:
        total = total + _lattice_in_single(fit.specular.dense, fit.specular_level, x)
    return total


def _lattice_in_single(points, level, x):
    """Equation 7 in float32, coordinates counted from the middle of the cube as the shader counts them."""
    m, one = dense.cells(level), np.float32(1)
    u = (2 * x - one) * np.float32(m / 2) + np.float32(m / 2 - m // 2)
    cell = np.clip(np.floor(u), -(m // 2), m - 1 - m // 2)
    s = u - cell
    t = one - s
    w = np.stack([t ** 3 / 6, (4 - 3 * s * s * (2 - s)) / 6, (4 - 3 * t * t * (2 - t)) / 6, s ** 3 / 6])
    first = cell.astype(int) + m // 2 - 1 - np.array(dense.origin(level))
    total = np.zeros((len(x), points.shape[-1]), np.float32)
    for tap in np.ndindex(4, 4, 4):
        weight = w[tap[0], :, 0] * w[tap[1], :, 1] * w[tap[2], :, 2]
        total += weight.astype(np.float32)[:, None] * points[tuple((first + tap).T)]
    return total


def halved(fit):
    """A fit whose coefficients were stored in half precision, relative to the largest of each lattice."""
    specular = fit.specular
    if specular is not None and specular.count:
        specular = replace(specular, coefficients=_halve(specular.coefficients))
    diffuse = replace(fit.diffuse, control_points=_halve(fit.diffuse.control_points))
    return replace(fit, diffuse=diffuse, specular=specular)


def _halve(points):
    scale = np.abs(points).max() or np.float32(1)
    return (points / scale).astype(np.float16).astype(np.float32) * scale


def main():
    """Print the table."""
    rows = []
    for name, case in hard_cases().items():
        rows.append((name, *(_cell(case.samples, case.fit(preset)) for preset in fitter.PRESETS)))
    show_table("stability", ("", *fitter.PRESETS), [
        *rows, ("at most", *(f"{BOUND[preset]:g} / {ERROR[preset]:g}" for preset in fitter.PRESETS))])


def _cell(samples, fit):
    finite, largest, error = measure(samples, fit)
    return f"{largest:.2f} / {error:.1e}" if finite else "not finite"


if __name__ == "__main__":
    sys.exit(main())
