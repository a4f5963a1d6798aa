"""How far the fits of the starter library are from their own models: the one truth that is known everywhere.

Of how many materials the albedo at some angle from 5 to 75 degrees, in some channel, is off by more than 2, 5, 10 and
25 %; and the median and the largest error of the cube root at swapped directions. The worst materials are named.

    python -m benchmarks.library [NAME ...] [--picture FILE]
"""

import argparse
import os
from pathlib import Path
from unittest import mock

os.environ["OPENBLAS_NUM_THREADS"] = "1"    # before NumPy starts them: seconds are of one core

import time

import numpy as np

from fitter.library import ready
from fitter.methods import regression_kriging
from fitter.methods.gaussian_process import Kernel
from fitter.model import published
from support.evidence import show_table
from support.faults import albedo_error, swapped_error
from support.spheres import lamp_sphere

_LIMITS = 0.02, 0.05, 0.1, 0.25
_WORST = 5
_BALLS = "specular-white-phenolic", "light-brown-fabric", "alumina-oxide"
_LAMP = 0.75, 0.35, 0.55
_SIZE, _BRIGHT = 160, 0.35


def main():
    """Print a row for what was fitted to MERL, one for metals, and one for all; draw three balls where asked to."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.library", description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", metavar="NAME", help="materials; by default all that users are offered")
    parser.add_argument("--picture", type=Path, metavar="FILE", help="draw three materials as balls")
    names, picture = vars(parser.parse_args()).values()
    if picture:
        draw(picture)
    found = {"not metals": [], "metals": []}
    for material in map(published.find, names) if names else published.list_offered():
        begun = time.process_time()
        fit = ready.fit(material.name)
        seconds = time.process_time() - begun
        found["metals" if published.METAL in material.tags else "not metals"].append(
            (material.name, albedo_error(material.name, fit), swapped_error(material.name, fit), seconds))
    rows = []
    for kind, errors in (*found.items(), ("all", [*found["not metals"], *found["metals"]])):
        if errors:
            _, albedos, swapped, seconds = zip(*errors, strict=True)
            worst = sorted(errors, key=lambda each: -each[1])[:_WORST]
            rows.append((kind, len(errors), *(sum(error > limit for error in albedos) for limit in _LIMITS),
                         f"{np.median(swapped):.4f}", f"{max(swapped):.4f}", f"{sum(seconds):.0f}",
                         ", ".join(f"{name} {100 * error:.1f} %" for name, error, *_ in worst)))
    show_table("library", ("materials", "number", *(f"albedo off by more than {limit:.0%}" for limit in _LIMITS),
                           "swapped, median", "swapped, largest", "seconds", "largest of albedo"), rows)


def draw(path):
    """Draw materials under one lamp: the model, its fit where samples from one side do not count as reciprocal and the
    trend has a slope between the sides, as it was, and its fit."""
    from .report.plots import pyplot, save

    figure, axes = pyplot.subplots(len(_BALLS), 3, figsize=(5, 5.2), layout="constrained")
    for name, row in zip(_BALLS, axes, strict=True):
        with (mock.patch.object(regression_kriging, "_BOTH_WAYS", 0.0),
              mock.patch.object(Kernel, "_slopes", lambda _, axes: np.ones(axes))):
            before = ready.fit(name)
        model = published.find(name).model
        lit = model.evaluate(0.6, 0, 0.6, np.pi / 2).max() * np.cos(0.6) * np.pi
        for axis, title, each in zip(row, ("model", "before", "now"), (model, before, ready.fit(name)), strict=True):
            axis.imshow(lamp_sphere(each, _SIZE, [(_LAMP, _BRIGHT / lit)]), origin="lower")
            axis.set_axis_off()
            axis.set_title(f"{published.find(name).label}: {title}", fontsize=8)
    save(figure, path)


if __name__ == "__main__":
    main()
