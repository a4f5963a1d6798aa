"""Judge dense measurements: print what holds, and write `results.json` and a picture to a folder.

python -m benchmarks.dense [--materials NAME...] [--jobs N] [--resume] [--out FOLDER]
"""

import os

os.environ["OPENBLAS_NUM_THREADS"] = "1"    # before NumPy starts them: a process for each core has the materials

import numpy as np

from fitter.files import replacing

from ..harness import running
from . import judging, materials, sheet, summary


def _judged(material, out):
    """The record of a material. Its pictures are written beside."""
    record, pictures = judging.judge(material)
    with replacing(sheet.pictures_of(record, out), "wb") as stream:
        np.savez_compressed(stream, **pictures)
    return record


def _is_whole(record, out):
    return sheet.pictures_of(record, out).is_file()


BENCH = running.Bench("dense", "materials", _judged, _is_whole, "models", "samples_cube_root_rmse", summary.show,
                      sheet.draw, ("support/merl_files.py", "benchmarks/dense"))


def main(arguments=None):
    """Judge the materials that the command names."""
    options = running.parser(BENCH, __doc__).parse_args(arguments)
    running.main(BENCH, *materials.at_hand(options.names), options)


if __name__ == "__main__":
    main()
