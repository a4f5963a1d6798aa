"""Where the next lamp should stand, for photographs of a flat sample to say more of it.

It is the D-optimal one (A. Atkinson, A. Donev, R. Tobias: Optimum Experimental Designs, with SAS, 2007): with the
derivatives J of what a photograph would show by a texel's weights and slopes, over the noise, and the covariance C so
far, it adds the information 1/2 log det(I + J C J^T), in the mean over texels. Materials are taken as known.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...arrays import ArrayLike, FloatArray
from ..ball.coverage import LEAST
from .maps import Maps, evenly, sample_frame, texel_points
from .photograph import FlatPhotograph, ShadingGeometry, observe, shading_geometry
from .solving import DIFFERENCE, NOISE, STEEP, expected_deviation, normals_to_slopes, radiances, slopes_to_normals

_TEXELS = 100               # that are looked at
_PLACES = 150               # of lamps that are tried, 10 degrees apart
_LOWEST = np.radians(75)    # from the normal: lower ones light no bumps' far sides
_ALONE = 0.02               # of the uncertainty, below which a lamp is not worth its photograph


class NextLamp(NamedTuple):
    """Where the next lamp should stand."""

    place: FloatArray   # (3,), metres
    polar_angle: float  # from the sample's normal, at its middle, degrees
    azimuth: float      # from the direction of the first edge, counter-clockwise as the camera sees it, degrees
    gain: float         # share of a texel's uncertainty that it takes away, geometric mean of weights, slopes, texels

    @property
    def advice(self) -> str:
        """The same in words."""
        if self.gain < _ALONE:
            return "Another lamp would tell little more"
        return (f"Put the next lamp at {self.polar_angle:.0f}° from the sample's normal, {self.azimuth:.0f}° "
                f"counter-clockwise from its first edge, as far as the others: {self.gain:.0%} less uncertainty")


def next_lamp(maps: Maps, photographs: Sequence[FlatPhotograph], places: ArrayLike | None = None) -> NextLamp:
    """The lamp whose photograph would add most to these, of which the maps were made.

    It may stand at places, (n, 3), metres, as the lamps of a dome; by default all around, as far as the others.
    """
    frame, (height, width) = sample_frame(maps.corners, photographs), maps.weights.shape[:2]
    chosen = evenly(height, width, _TEXELS)
    points = texel_points(maps.corners, (height, width)).reshape(height, width, 3)[chosen].reshape(-1, 3)
    seen = observe(photographs, points, frame[2])
    enough = np.flatnonzero(seen.good.any(axis=1))
    points, seen = points[enough], seen.some(enough)
    weights = maps.weights[chosen].reshape(-1, len(maps.fits))[enough]
    slopes = normals_to_slopes(maps.normals[chosen].reshape(-1, 3)[enough], frame, np.inf)

    shown, change = _derivatives(maps, seen.lit, slopes, weights, frame)
    scale = expected_deviation(seen, shown, seen.good)
    change *= (seen.good[..., None] / scale)[..., None]
    # weights are expected to be about 1, and slopes about STEEP, before any photograph
    before = np.diag([1.0] * len(maps.fits) + [STEEP ** -2] * 2)
    covariance = np.linalg.inv(np.einsum("npci,npcj->nij", change, change) + before)

    middle, camera = maps.corners.mean(axis=0), photographs[-1].camera
    lamps = np.array([each.lamp for each in photographs])
    tried = (_dome_positions(middle, frame, camera, float(np.median(np.linalg.norm(lamps - middle, axis=1))))
             if places is None else np.asarray(places, dtype=float).reshape(-1, 3))
    intensity = np.median([each.intensity for each in photographs], axis=0)
    least = scale.min(axis=1, keepdims=True)
    shown, change = _derivatives(maps, shading_geometry(points, np.tile(camera, (len(tried), 1)), tried, np.tile(
        intensity, (len(tried), 1))), slopes, weights, frame)
    change /= np.maximum(least, NOISE * shown)[..., None]
    grown = np.einsum("npci,nij,npdj->npcd", change, covariance, change, optimize=True) + np.eye(change.shape[2])
    gains = np.linalg.slogdet(grown)[1].mean(axis=0) / 2
    best = int(np.argmax(gains))
    along = frame @ (tried[best] - middle)
    return NextLamp(tried[best], float(np.degrees(np.arctan2(np.hypot(*along[:2]), along[2]))),
                    float(np.degrees(np.arctan2(along[1], along[0])) % 360),
                    float(1 - np.exp(-gains[best] / len(before))))


def _derivatives(maps: Maps, seen: ShadingGeometry, slopes: FloatArray, weights: FloatArray,
                 frame: FloatArray) -> tuple[FloatArray, FloatArray]:
    """What n texels show in p photographs, (n, p, channels), and its derivatives by the weights and both slopes:
    (n, p, channels, materials + 2)."""
    def unit(at: FloatArray) -> FloatArray:
        return radiances(maps.fits, seen, slopes_to_normals(at, frame))

    now = unit(slopes)
    shown = np.einsum("npcm,nm->npc", now, weights)
    turned = [(np.einsum("npcm,nm->npc", unit(slopes + shift), weights) - shown) / DIFFERENCE
              for shift in DIFFERENCE * np.eye(2)]
    return shown, np.concatenate([now, np.stack(turned, axis=3)], axis=3)


def _dome_positions(middle: FloatArray, frame: FloatArray, camera: FloatArray, distance: float) -> FloatArray:
    """Places in a dome about the middle of a sample, those left out where lamp and camera are in each other's way."""
    k = np.arange(_PLACES)
    height = 1 - (1 - np.cos(_LOWEST)) * (k + 0.5) / _PLACES        # evenly over the sphere, in a spiral
    turn = np.pi * (3 - np.sqrt(5)) * k
    flat = np.sqrt(1 - height ** 2)
    toward = np.column_stack([flat * np.cos(turn), flat * np.sin(turn), height]) @ frame
    view = (camera - middle) / np.linalg.norm(camera - middle)
    return np.asarray(middle + distance * toward[toward @ view < np.cos(np.radians(2 * LEAST))])
