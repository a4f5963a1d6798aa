"""How true fits are between the nodes of RGL's files, and at the rims of balls, where nobody measured.

    python -m benchmarks.rims [--presets Standard Reference]
"""

import argparse
import time
from pathlib import Path

import numpy as np

import fitter
from fitter.formats import rgl
from fitter.methods import prepare
from support.checkout import measurements
from support.evidence import show_table
from support.faults import Clipped, albedo, error

from .dense.materials import RGL

OTHERS = ("goniometer/lighttec_C9_Gold.astm", "goniometer/lighttec_C1_White.astm", "goniometer/carpaint_blue.mbsdf",
          "cornell/cayman.astm", "cornell/krylon_blue.astm", "cornell/garnet_red.astm")
_DEGREES, _RIM = (30, 50, 66, 75, 80, 86), (60, 70, 88)


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
    parser = argparse.ArgumentParser(prog="python -m benchmarks.rims", description=__doc__.splitlines()[0])
    parser.add_argument("--presets", nargs="+", default=["Standard", "Reference"])
    presets = parser.parse_args().presets
    errors, rows = {preset: [] for preset in presets}, []
    folder = measurements()
    for stem in RGL:
        path = folder / "rgl" / f"{stem}.bsdf"
        table = Clipped(rgl.read_table(path.read_bytes()))
        golden = np.loadtxt(path.with_name(f"golden_{stem}.csv"), delimiter=",")
        wanted = albedo(table, _DEGREES)
        for preset, fit, seconds in _fits(path, presets):
            ratio = np.abs(np.log(albedo(fit, _DEGREES) / wanted))
            errors[preset].append(error(fit, golden))
            rows.append((stem, preset, errors[preset][-1], f"{np.exp(ratio.max()):.2f}", f"{np.exp(ratio.mean()):.3f}",
                         f"{seconds:.1f}", "; ".join(fit.changes)))
    rows += [("geometric mean", preset, float(np.exp(np.log(found).mean())), "", "", "", "")
             for preset, found in errors.items()]
    show_table("rims-rgl", ("file", "preset", "error", "albedo at most, times", "in the mean, times", "seconds",
                            "changed"), rows)
    heads = "file", "preset", *(f"albedo at {angle} degrees" for angle in _RIM), "seconds", "changed"
    show_table("rims-others", heads,
               [(Path(name).name, preset, *("/".join(f"{value:.2f}" for value in row) for row in albedo(fit, _RIM)),
                 f"{seconds:.1f}", "; ".join(fit.changes))
                for name in OTHERS for preset, fit, seconds in _fits(folder / name, presets)])


if __name__ == "__main__":
    main()
