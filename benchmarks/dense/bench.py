"""The dense measurements as a bench, and as a part of the report. The pictures of each material are an .npz file."""

import numpy as np

from fitter.files import replacing

from ..harness import command
from ..harness.running import Bench
from . import judging, materials, sheet, summary


def dense_sets(_shown, out):
    """Errors on dense measurements, from the last `make dense` if there was one; else they are made."""
    return command.supplement(BENCH, "dense_sets", *materials.at_hand(), out)


def _judged(material, out):
    """The record of a material. Its pictures are written beside."""
    record, pictures = judging.judge(material)
    with replacing(sheet.pictures_of(record, out), "wb") as stream:
        np.savez_compressed(stream, **pictures)
    return record


def _is_whole(record, out):
    return sheet.pictures_of(record, out).is_file()


BENCH = Bench("dense", "materials", "Dense measurements", "", _judged, _is_whole, "models", "samples_cube_root_rmse",
              summary.text, summary.outcome, sheet.draw, (
                  "support/merl_files.py", *(f"benchmarks/dense/{name}.py" for name in (
                      "image_errors", "judging", "materials", "sky", "sphere"))))
