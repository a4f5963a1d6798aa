"""Spikes and holes that fits have within 1.5 degrees of mirror directions, in all files at hand that measure there.

Of files that measure many directions of each incidence, a fit is compared with the samples around (`support.faults`);
of RGL's, whose samples have an incidence each, with the file's own function within .3 degrees.

    python -m benchmarks.mirrors [NAME ...]
"""

import argparse

import fitter
from fitter.formats import rgl
from support.checkout import measurements
from support.evidence import show_table
from support.faults import Clipped, ratios_to_function, ratios_to_samples

from .dense.materials import RGL
from .harness.running import named

FILES = ("goniometer/lighttec_C1_White.astm", "goniometer/lighttec_C9_Gold.astm", "goniometer/carpaint_blue.mbsdf",
         "goniometer/aeroglaze_inplane.zemax.bsdf", "goniometer/ansys_planesymmetric.anisotropicbsdf",
         "goniometer/AnoBlackEC1onAlum.zemax.bsdf", "goniometer/AnoBlackEC2onAlum_fred.txt", "goniometer/IMX455.bsdf",
         *(f"rgl/{name}.bsdf" for name in RGL))


def main():
    parser = argparse.ArgumentParser(prog="python -m benchmarks.mirrors", description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", metavar="NAME", help="parts of files' names; by default all")
    rows = []
    for path in named([measurements() / each for each in FILES], parser.parse_args().names):
        samples = fitter.load(path)
        fit = fitter.fit(samples, **fitter.PRESETS["Standard"])
        if path.parent.name == "rgl":
            function = Clipped(rgl.read_table(path.read_bytes()))
            above, below = ratios_to_function(fit, function, samples.values.max(axis=0))
        else:
            above, below = ratios_to_samples(fit, samples)
        if above:
            rows.append((path.name, f"{above:.2f}", f"{below:.2f}"))
    show_table("mirrors", ("file", "above the largest around, times", "below the least, times"), rows)


if __name__ == "__main__":
    main()
