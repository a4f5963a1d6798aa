"""How true fits are between the nodes of RGL's files, and at the rims of balls, where nobody measured.

Of each RGL file: the relative error of the cube roots of f cos theta_o at 200 pairs of directions, beside the authors'
own reader; the largest and the mean ratio of the albedo to the file's, of all channels, at six angles from 30 to 86
degrees; and what the measured directions lost of their light. Of other files the albedo at 60, 70 and 88 degrees.

    python -m benchmarks.rims [--presets Standard Reference]
"""

import argparse
import time

import numpy as np

import fitter
from fitter.formats import rgl
from fitter.methods import prepare
from support.checkout import measurements
from support.rims import Clipped, albedo, error

from .dense.materials import RGL

OTHERS = ("goniometer/lighttec_C9_Gold.astm", "goniometer/lighttec_C1_White.astm", "goniometer/carpaint_blue.mbsdf",
          "cornell/cayman.astm", "cornell/krylon_blue.astm", "cornell/garnet_red.astm")
_DEGREES = (30, 50, 66, 75, 80, 86)


def _fits(path, presets):
    samples = fitter.load(path)
    begun = time.process_time()
    prepared = prepare(samples, "kriging")
    shared = time.process_time() - begun
    for preset in presets:
        begun = time.process_time()
        fit = fitter.fit(samples, **fitter.PRESETS[preset], **prepared)
        yield preset, fit, shared + time.process_time() - begun


def main():
    """Print a line for each file and preset."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.rims", description=__doc__.splitlines()[0])
    parser.add_argument("--presets", nargs="+", default=["Standard", "Reference"])
    presets = parser.parse_args().presets
    errors = {preset: [] for preset in presets}
    folder = measurements()
    for stem in RGL:
        path = folder / "rgl" / f"{stem}.bsdf"
        table = Clipped(rgl.read_table(path, path.read_bytes()))
        golden = np.loadtxt(path.with_name(f"golden_{stem}.csv"), delimiter=",")
        wanted = albedo(table, _DEGREES)
        for preset, fit, seconds in _fits(path, presets):
            ratio = np.abs(np.log(albedo(fit, _DEGREES) / wanted))
            errors[preset].append(error(fit, golden))
            print(f"{stem:24} {preset:9} error {errors[preset][-1]:.4f}, albedo x{np.exp(ratio.max()):.2f} at most, "
                  f"x{np.exp(ratio.mean()):.3f} in the mean, {seconds:.1f} s; {'; '.join(fit.changes)}", flush=True)
    for preset, found in errors.items():
        print(f"{preset}: error in the geometric mean {np.exp(np.log(found).mean()):.4f}")
    for name in OTHERS:
        for preset, fit, seconds in _fits(folder / name, presets):
            shown = ", ".join("/".join(f"{value:.2f}" for value in row) for row in albedo(fit, (60, 70, 88)))
            print(f"{name:34} {preset:9} albedo at 60, 70, 88 degrees {shown}, {seconds:.1f} s; "
                  f"{'; '.join(fit.changes)}", flush=True)


if __name__ == "__main__":
    main()
