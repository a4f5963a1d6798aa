"""Maps of a flat sample as pictures of 16 bits: masks, and a normal map.

A mask is white where the weight of its material is as large as nearly all are at most; what that is, stands in the
report. The normal map is in tangent space: x to the right in the picture, y upward (OpenGL, as Blender has it), z out
of the surface.
"""

import re
import tempfile
from collections.abc import Sequence
from functools import partial
from pathlib import Path

import numpy as np

from ...arrays import FloatArray
from ...errors import DatasetError, printable
from ...imaging.picture_files import NEEDED
from ...quality.physics import directional_albedo
from ...storage.files import others_files, replace_folder
from ..rig.report import MeasurementReport, judge_left_out
from ..rig.scale import SHARE_ANGLES, implausible_light
from .advice import next_lamp
from .judging import contradictions, turned_lamps
from .maps import Maps, evenly, maps_from_flat, sample_frame, texel_points
from .photograph import FlatPhotograph, observe

_WRITTEN = re.compile(r"mask-\d+\.png|material-\d+\.npz|normal\.png|report\.txt")
_NEARLY_ALL = 99.9          # percent of the texels, whose weights are white at most
UNSURE = 0.1                # standard deviation of a weight, of the largest, that is uncertain
_LEFT_OUT = 48              # texels along a side, of maps without one of the photographs
_WEIGHED = 4000             # texels whose reflectance is looked at
_JUDGED = 120               # texels by which photographs are judged


def layers(weights: FloatArray) -> tuple[FloatArray, FloatArray, float]:
    """Weights (h, w, materials) as layers that lie upon one another: the share of each but the first upon those before
    it, (h, w, materials - 1), the sum of the weights over that which nearly all are below, (h, w), both 0 to 1 and the
    top row of the picture first, and the latter: a few texels, as of a glint, may be brighter.

    Examples
    --------
    >>> masks, brightness, most = layers(np.array([[[0.2, 0.2, 0.4]]]))
    >>> masks.round(6).tolist(), brightness.round(6).tolist(), round(most, 6)
    ([[[0.5, 0.5]]], [[1.0]], 0.8)
    """
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


def _left_out_error(maps: Maps, others: Sequence[FlatPhotograph], shot: FlatPhotograph) -> float:
    """How far a photograph is from what coarse maps of the same materials by others say of it; not a number where it
    shows nothing of the sample."""
    height, width = (min(each, _LEFT_OUT) for each in maps.weights.shape[:2])
    coarse = maps_from_flat(others, maps.corners, (height, width), maps.fits)
    seen = observe([shot], texel_points(maps.corners, (height, width)), sample_frame(maps.corners, [shot])[2])
    counts = seen.good[:, 0] & (coarse.used.ravel() > 0)
    there = seen.radiance[counts, 0]
    expected = coarse.radiance(shot.camera, shot.lamp, shot.intensity).reshape(len(counts), -1)[counts]
    size = float(np.linalg.norm(there))
    return float(np.linalg.norm(expected - there)) / size if size else float("nan")


def report(maps: Maps, photographs: Sequence[FlatPhotograph], albedo: float | None = None) -> MeasurementReport:
    """What is to be said of maps. The albedo is that which was guessed, if it was."""
    height, width, count = maps.weights.shape
    most = float(maps.weights.max()) or 1.0
    unsure = (maps.deviation.max(axis=2) > UNSURE * most).mean()
    told = judge_left_out(photographs, len(photographs) // 2, partial(_left_out_error, maps))
    lines = [f"{width} x {height} texels of {count} material{'s' * (count > 1)}, {len(photographs)} photographs, of "
             f"which {maps.used.mean():.1f} tell of a texel in the mean",
             f"{(maps.used == 0).mean():.1%} of the texels are in none; the weights of {unsure:.1%} are uncertain by "
             f"more than {UNSURE:.0%} of the largest", told.words]
    bright = implausible_light(reflected_light(maps), albedo)
    frame, points = sample_frame(maps.corners, photographs), texel_points(maps.corners, (height, width))
    some = points.reshape(height, width, 3)[evenly(height, width, _JUDGED)].reshape(-1, 3)
    size = np.linalg.norm(np.diff(maps.corners[:3], axis=0), axis=1)
    judged = (*contradictions(maps.fits, observe(photographs, some, frame[2]), frame,
                              [each.name for each in photographs]),
              *turned_lamps(maps.normals, frame, maps.used > 0, size))
    return MeasurementReport((*lines, *maps.notes, *bright, *judged, next_lamp(maps, photographs).advice),
                             (*bright, *[told.words] * told.is_bad, *judged))


def reflected_light(maps: Maps) -> FloatArray:
    """The share of light from each of `SHARE_ANGLES` that a sample reflects, the median of its texels: (angles,
    channels)."""
    height, width, count = maps.weights.shape
    weights = maps.weights[evenly(height, width, _WEIGHED)].reshape(-1, count)
    shares = np.stack(np.broadcast_arrays(*(directional_albedo(fit, SHARE_ANGLES) for fit in maps.fits)))
    return np.asarray(np.median(np.einsum("nm,mac->nac", weights, shares), axis=0))


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
