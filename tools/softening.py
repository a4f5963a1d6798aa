"""``python -m tools.softening``: the cost and the effect of the softening radius of `coordinates.half_difference`.

Standard's errors with a radius over those without, at the samples and held out in five folds, as medians over one half
of the CURET sets: the radius is chosen on the samples of odd numbers and judged on those of even numbers. Then how far
the fit is from its value at exact retro-reflection when a direction is moved by a millionth of a radian.
"""

import sys

import numpy as np

import fitter
from fitter.methods import regression_kriging
from fitter.quality import cross_validation
from fitter.samples import distinct_channels
from support import checkout

RADII = {"odd": (0.01, 0.02), "even": (0.01,)}
ANGLES = np.radians([10, 30, 50, 70, 85])
_STEP = 1e-6                # radians


def fit(samples, softening):
    """Standard's fit with a radius."""
    estimated = regression_kriging.Estimate(distinct_channels(samples)[0], softening)
    return fitter.fit(samples, **fitter.PRESETS["Standard"], estimated=estimated)


def errors(samples, softening):
    """RMSE and RMSE of cube roots at the samples, then both held out: (4,)."""
    seen = cross_validation.errors(samples, fit(samples, softening).evaluate(*samples.directions))
    return np.array([*seen, *cross_validation.held_out(samples, lambda part: fit(part, softening))])


def jump(model):
    """The largest change of a fit beside exact retro-reflection, over its value there."""
    azimuth = np.arange(16) * np.pi / 8
    theta = ANGLES[:, None] + _STEP * np.cos(azimuth)
    phi = _STEP * np.sin(azimuth) / np.sin(ANGLES[:, None])
    there = model.evaluate(ANGLES, 0, ANGLES, 0)[:, None]
    beside = model.evaluate(ANGLES[:, None], 0, theta, phi)
    return float((np.abs(beside - there) / np.maximum(np.abs(there), 1e-6 * np.abs(there).max())).max())


def main():
    """Print the tables."""
    folder = checkout.measurements()
    curet = folder / "curet" / "abrdf.dat"
    print("| sets | radius | RMSE | cube roots | held out | held out, cube roots |\n|---|---:|---:|---:|---:|---:|")
    for half, radii in RADII.items():
        sets = [fitter.load(curet, number) for number in range(1 + (half == "even"), 62, 2)]
        without = np.array([errors(samples, 0.0) for samples in sets])
        for radius in radii:
            ratio = np.median(np.array([errors(samples, radius) for samples in sets]) / without, axis=0)
            print(f"| {half} | {radius:g} | {' | '.join(f'{value:.3f}' for value in ratio)} |", flush=True)
    print("\n| Jump at retro-reflection | without | with |\n|---|---:|---:|")
    for samples in (fitter.load(curet, "leather"), fitter.load(folder / "cornell" / "garnet_red.astm"),
                    fitter.load(folder / "cornell" / "krylon_blue.astm")):
        softened = jump(fit(samples, regression_kriging.SOFTENING))
        print(f"| {samples.name} | {jump(fit(samples, 0.0)):.2g} | {softened:.2g} |", flush=True)


if __name__ == "__main__":
    sys.exit(main())
