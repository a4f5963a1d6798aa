"""Rings that fits have within 5 degrees of retro-reflection, where few samples are: CURET's 61 and Cornell's files.

    python -m benchmarks.rings [NAME ...]
"""

import argparse

import numpy as np

import fitter
from support.evidence import show_table
from support.faults import ring

from .held_out import sets

_FAMILIES = "CURET", "Cornell"
_LARGE = 0.1
_WORST = 8


def main():
    parser = argparse.ArgumentParser(prog="python -m benchmarks.rings", description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", metavar="NAME", help="sets; by default all")
    found = {half: [] for half in sets.HALVES}
    for each in sets.at_hand("all", parser.parse_args().names)[0]:
        if each.family in _FAMILIES:
            fit = fitter.fit(each.open()[0], **fitter.PRESETS["Standard"])
            found[each.half].append((ring(fit), each.name))
    show_table("rings", ("half", "sets", f"rings of more than {_LARGE:.0%}", "mean", "largest"), [
        (half, len(rings), sum(size > _LARGE for size, _ in rings), f"{np.mean([size for size, _ in rings]):.0%}",
         ", ".join(f"{name} {size:.0%}" for size, name in sorted(rings, reverse=True)[:_WORST]))
        for half, rings in found.items() if rings])


if __name__ == "__main__":
    main()
