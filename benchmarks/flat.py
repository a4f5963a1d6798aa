"""Photographs of a flat sample made into maps: seconds, memory, and how far the maps are from the sample.

    python -m benchmarks.flat [TEXELS] [--coin FOLDER]      along each side, 1,024 by default; some ten minutes

Sixteen photographs of 24 million pixels as TIFF of 16 bits (2.3 GB, in a temporary folder), which are rendered at a
40th of the size and enlarged. Processor time is that of all threads; memory is the most that was resident, after the
photographs were read and at the end. Then real ones (`flat_real`); with 0 texels these alone.
"""

import argparse
import multiprocessing
import os
import resource
import tempfile
import time
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")      # before NumPy starts them

import numpy as np
from scipy.ndimage import zoom

import fitter
from fitter.photographs.description import parsing
from fitter.photographs.flat.reading import read_sample
from support import ball_files, flat_files, flat_scene
from support.checkout import ROOT
from support.evidence import show_table

from . import flat_real
from .photographs import materials

PIXELS, ENLARGED = (4680, 5200), 40      # height and width
NAMES = "garnet", "krylon", "leather", "felt"


def four_weights(u, v):
    """Weights that pass into one another: (n, 4)."""
    fourth = 0.3 + 0.3 * np.sin(11 * u * v)
    return np.column_stack([flat_scene.smooth_weights(3)(u, v) * (1 - fourth)[:, None], fourth])


def sample():
    return flat_scene.Sample(tuple(make() for _, make in materials(NAMES)), four_weights, flat_scene.bumps)


def write(folder, side):
    """Write sixteen photographs, and their description: in a process of its own, whose memory does not count."""
    ball_files.add_openimageio()
    names, small = [f"lamp{number}.tif" for number in range(1, 17)], tuple(each // ENLARGED for each in PIXELS)
    white = 0.0
    for number, (name, lamp) in enumerate(zip(names, flat_scene.lamps(), strict=True)):
        shown = flat_scene.photograph(sample(), lamp, small, noise=0, seed=number).astype(np.float32)
        white = white or 4 * float(shown.max())
        picture = zoom(shown / white, (ENLARGED, ENLARGED, 1), order=1, mode="nearest", grid_mode=True)
        picture *= 1 + 0.01 * np.random.default_rng(number).standard_normal(picture.shape, np.float32)
        ball_files.write_picture(Path(folder, name), np.clip(picture, 0, 1), depth="uint16")
    Path(folder, "setup.toml").write_text(flat_files.description(
        names, flat_scene.lamps(), top=f"texels = {side}", size=tuple(each // ENLARGED * ENLARGED for each in PIXELS),
        scale=f"intensity = {(flat_scene.INTENSITY / white).tolist()}"), "utf-8")


def resident():
    """The most memory that was resident, GiB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024 ** 2


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("texels", nargs="?", type=int, default=1024)
    parser.add_argument("--coin", type=Path, metavar="FOLDER", default=ROOT / "build" / "cointest")
    options = parser.parse_args()
    if options.texels:
        computed(options.texels)
    flat_real.main(options.coin)


def computed(side):
    ball_files.add_openimageio()
    with tempfile.TemporaryDirectory() as folder:
        writing = multiprocessing.get_context("spawn").Process(target=write, args=(folder, side))
        writing.start()
        writing.join()
        start, work = time.perf_counter(), time.process_time()
        given = read_sample(parsing.read(Path(folder, "setup.toml")))
    reading, read = time.perf_counter() - start, resident()
    true = sample()
    maps = fitter.maps_from_flat(given.photographs, given.corners, given.shape, true.fits)
    seconds, work = time.perf_counter() - start, time.process_time() - work
    wrong = np.abs(maps.weights.reshape(-1, len(true.fits)) - four_weights(*flat_scene.texels(given.shape)))
    show_table("flat", ("texels", "seconds", "of reading", "processor seconds", "memory, GiB", "of reading",
                        "masks off by, mean"), [
        (f"{given.shape[1]} x {given.shape[0]}", f"{seconds:.0f}", f"{reading:.0f}", f"{work:.0f}", f"{resident():.2f}",
         f"{read:.2f}", f"{wrong.mean():.4f}")])


if __name__ == "__main__":
    main()
