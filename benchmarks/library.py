"""How far the fits of the starter library are from their own models: the one truth that is known everywhere.

Of how many materials the albedo at some angle from 5 to 75 degrees, in some channel, is off by more than 2, 5, 10 and
25 %; and the median and the largest error of the cube root at swapped directions. The worst materials are named.

    python -m benchmarks.library [NAME ...]
"""

import argparse
import os

os.environ["OPENBLAS_NUM_THREADS"] = "1"    # before NumPy starts them: seconds are of one core

import time

import numpy as np

from fitter import published, ready
from support.evidence import show_table
from support.library import albedo_error, swapped_error

_LIMITS = 0.02, 0.05, 0.1, 0.25
_WORST = 5


def main():
    """Print a row for what was fitted to MERL, one for metals, and one for all."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.library", description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", metavar="NAME", help="materials; by default all that users are offered")
    names = parser.parse_args().names
    found = {"not metals": [], "metals": []}
    for material in map(published.find, names) if names else published.offered():
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


if __name__ == "__main__":
    main()
