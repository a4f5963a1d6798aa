"""Photographs of a flat sample made into maps: seconds, memory, and how far the maps are from the sample.

    python -m benchmarks.flat [TEXELS] [--coin FOLDER]      along each side, 1,024 by default; some ten minutes

Then real ones (`flat_real`); with 0 texels these alone.

Sixteen photographs of 1,024 x 1,024 pixels with 1 % of noise, four materials that are given, normals to 15 degrees. The
photographs are rendered at an eighth of the size and enlarged. Processor time is that of all threads, which on idle
cores is divided among them; memory is the most that was resident, photographs included.
"""

import argparse
import os
import resource
import time
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")      # before NumPy starts them

import numpy as np
from scipy.ndimage import zoom

import fitter
from support import flat_scene
from support.evidence import show_table

from . import flat_real
from .photographs import materials

PIXELS, ENLARGED = 1024, 8
NAMES = "garnet", "krylon", "leather", "felt"


def four_weights(u, v):
    """Weights that pass into one another: (n, 4)."""
    fourth = 0.3 + 0.3 * np.sin(11 * u * v)
    return np.column_stack([flat_scene.smooth_weights(3)(u, v) * (1 - fourth)[:, None], fourth])


def photographs(sample):
    """Sixteen `fitter.FlatPhotograph`s."""
    rays, small = flat_scene.rays((PIXELS, PIXELS)), (PIXELS // ENLARGED, PIXELS // ENLARGED)
    return [fitter.FlatPhotograph(
        zoom(flat_scene.photograph(sample, lamp, small, seed=number), (ENLARGED, ENLARGED, 1), order=1,
             mode="nearest", grid_mode=True), rays, flat_scene.CAMERA, lamp, flat_scene.INTENSITY)
        for number, lamp in enumerate(flat_scene.lamps())]


def main():
    """Print the tables."""
    parser = argparse.ArgumentParser()
    parser.add_argument("texels", nargs="?", type=int, default=1024)
    parser.add_argument("--coin", type=Path, metavar="FOLDER")
    options = parser.parse_args()
    if options.texels:
        computed(options.texels)
    flat_real.main(options.coin)


def computed(side):
    """Print the table of computed photographs, of maps with so many texels along each side."""
    sample = flat_scene.Sample(tuple(make() for _, make in materials(NAMES)), four_weights, flat_scene.bumps)
    shots = photographs(sample)
    start, work = time.perf_counter(), time.process_time()
    maps = fitter.maps_from_flat(shots, flat_scene.corners(), (side, side), sample.fits)
    seconds, work = time.perf_counter() - start, time.process_time() - work
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024 ** 2
    wrong = np.abs(maps.weights.reshape(-1, len(sample.fits)) - four_weights(*flat_scene.texels((side, side))))
    show_table("flat", ("texels", "seconds", "processor seconds", "memory, GiB", "masks off by, mean"), [
        (f"{side} x {side}", f"{seconds:.0f}", f"{work:.0f}", f"{memory:.2f}", f"{wrong.mean():.4f}")])


if __name__ == "__main__":
    main()
