"""Maps of a flat sample as pictures of 16 bits: masks, and a normal map.

A mask is white where the weight of its material is as large as nearly all are at most; what that is, stands in the
report. The normal map is in tangent space: x to the right in the picture, y upward (OpenGL, as Blender has it), z out
of the surface.
"""

import re
import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ...arrays import FloatArray
from ...errors import DatasetError, printable
from ...imaging.picture_files import NEEDED
from ...storage.files import others_files, replace_folder
from .maps import Maps

_WRITTEN = re.compile(r"mask-\d+\.png|material-\d+\.npz|normal\.png|report\.txt")
_NEARLY_ALL = 99.9          # percent of the texels, whose weights are white at most


def layers(weights: FloatArray) -> tuple[FloatArray, FloatArray, float]:
    """Weights (h, w, materials) as layers that lie upon one another: the share of each but the first upon those before
    it, (h, w, materials - 1), the sum of the weights over that which nearly all are below, (h, w), both 0 to 1 and the
    top row of the picture first, and the latter: a few texels, as of a glint, may be brighter."""
    sums = np.cumsum(weights, axis=2)[::-1]
    masks = weights[::-1, :, 1:] / np.where(sums[..., 1:] > 0, sums[..., 1:], 1.0)
    most = white(sums[..., -1])
    return masks, np.minimum(sums[..., -1] / most, 1), most


def white(weights: FloatArray) -> float:
    """The weight that is white in a picture: what nearly all of them are at most, or 1 where all are 0."""
    return float(np.percentile(weights, _NEARLY_ALL, method="higher") or weights.max()) or 1.0


def normal_map(maps: Maps) -> FloatArray:
    """Normals in tangent space, 0 to 1, the top row of the picture first: (h, w, 3)."""
    along = maps.corners[1] - maps.corners[0]
    normal = np.cross(along, maps.corners[3] - maps.corners[0])
    x, z = (each / np.linalg.norm(each) for each in (along, normal))
    return np.asarray((maps.normals @ np.stack([x, np.cross(z, x), z]).T)[::-1] / 2 + 0.5)


def png(values: FloatArray) -> bytes:
    """A file of values, 0 to 1, (h, w) or (h, w, 3), as integers of 16 bits. ImportError without OpenImageIO."""
    try:
        import OpenImageIO
    except ImportError as error:
        raise ImportError(NEEDED) from error
    whole = np.round(np.clip(values, 0, 1) * 65535).astype(np.uint16).reshape(*values.shape[:2], -1)
    height, width, channels = whole.shape
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "map.png")
        file = OpenImageIO.ImageOutput.create(str(path))
        if not (file and file.open(str(path), OpenImageIO.ImageSpec(width, height, channels, str(whole.dtype)))
                and file.write_image(np.ascontiguousarray(whole)) and file.close()):
            raise DatasetError(f"cannot be written: {OpenImageIO.geterror() or 'the disk may be full'}", path)
        return path.read_bytes()


def check_folder(folder: str | Path) -> None:
    """Raise DatasetError if `write` would replace files in a folder that it has not written."""
    if others := others_files(Path(folder), _WRITTEN):
        raise DatasetError(f"{', '.join(others)}: not written by an earlier run, or changed since; move what is to be "
                           "replaced away, or choose another folder", folder)


def write(maps: Maps, lines: Sequence[str], folder: str | Path) -> list[str]:
    """Write masks, normal map, fits and a report of these lines to a folder, which is made, in the place of those of an
    earlier run: the names of the files. Raises OSError, or ImportError without OpenImageIO."""
    most = white(maps.weights.max(axis=2))
    told = [*lines, f"White in a mask is a weight of {most:.6g}"]
    with replace_folder(Path(folder)) as part:
        for number, fit in enumerate(maps.fits):
            (part / f"mask-{number + 1}.png").write_bytes(png(maps.weights[::-1, :, number] / most))
            fit.save(part / f"material-{number + 1}.npz")
            told.append(f"mask-{number + 1}.png is the mask of material-{number + 1}.npz, {fit.name}")
        (part / "normal.png").write_bytes(png(normal_map(maps)))
        (part / "report.txt").write_text("".join(f"{printable(line)}\n" for line in told), "utf-8")
        return sorted(each.name for each in part.iterdir())
