"""The bench of dense materials. Worker processes import it: they cannot import what stands in `__main__`."""

import numpy as np

from fitter.storage.files import replace_file

from ..harness import running
from . import judging, sheet, summary


def _judged(material, out):
    """The record of a material. Its pictures are written beside."""
    record, pictures = judging.judge(material)
    with replace_file(sheet.pictures_of(record, out), "wb") as stream:
        np.savez_compressed(stream, **pictures)
    return record


def _is_whole(record, out):
    return sheet.pictures_of(record, out).is_file()


BENCH = running.Bench("dense", "materials", _judged, _is_whole, "models", "samples_cube_root_rmse", summary.show,
                      sheet.draw, ("support/merl_files.py", "benchmarks/dense"))
