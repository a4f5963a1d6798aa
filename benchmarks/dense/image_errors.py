"""Errors of a picture against the true one, over the pixels of the sphere.

- PSNR (dB) and MAE, the *mean* absolute difference, of the pictures as shown: sRGB, clipped, 0 to 1.
- FLIP, mean, 0 to 1, of the same: P. Andersson et al.: FLIP: A Difference Evaluator for Alternating Images, HPG 2020.
- Delta E ITP, mean, of Rec. ITU-R BT.2124 (2019): of scene-linear pictures with white at WHITE cd/m^2, up to the 10,000
  of BT.2100's PQ, so that highlights count that are clipped as shown. 1 is just visible.
"""

import flip_evaluator
import numpy as np

from fitter.imaging.pictures import srgb

WHITE = 203.0               # cd/m^2: that of HDR reference white, Rep. ITU-R BT.2408
PIXELS_PER_DEGREE = 67      # FLIP's default: a monitor at arm's length
EXPOSED, PERCENTILE = 0.8, 95           # this percentile of the true picture is shown so bright
# Rec. ITU-R BT.2087: of BT.709, whose primaries are sRGB's, to BT.2020
_WIDE = np.array([[0.6274, 0.3293, 0.0433], [0.0691, 0.9195, 0.0114], [0.0164, 0.0880, 0.8956]])
# BT.2100: RGB to LMS, and L'M'S' to I, T, P, where BT.2124 takes half of BT.2100's CT
_LMS = np.array([[1688, 2146, 262], [683, 2951, 462], [99, 309, 3688]]) / 4096
_ITP = np.array([[2048, 2048, 0], [3305, -6806.5, 3501.5], [17933, -17390, -543]]) / 4096


def exposure(truth):
    """What the true picture's pixels (n, 3) are multiplied with to be shown."""
    return EXPOSED / max(float(np.percentile(truth.max(axis=1), PERCENTILE)), 1e-12)


def errors(truth, found, inside):
    """psnr (infinite for equal pictures), mae, flip and delta_e_itp of a picture against the truth, over pixels inside.

    Both are scene-linear, (height, width, 3), and are exposed as the truth is.
    """
    scale = exposure(truth[inside])
    shown = [srgb(scale * of) for of in (truth, found)]
    difference = (shown[0] - shown[1])[inside]
    square = np.mean(difference ** 2)
    return {"psnr": float(-10 * np.log10(square)) if square else float("inf"), "mae": float(np.abs(difference).mean()),
            "flip": flip(*shown, inside),
            "delta_e_itp": float(delta_e_itp(*(WHITE * scale * of[inside] for of in (truth, found))).mean())}


def flip(reference, picture, inside):
    """Mean FLIP of two sRGB pictures over the pixels inside."""
    found, _, _ = flip_evaluator.evaluate(*(np.ascontiguousarray(of, np.float32) for of in (reference, picture)), "LDR",
                                          applyMagma=False, parameters={"ppd": PIXELS_PER_DEGREE})
    return float(np.asarray(found).reshape(*inside.shape, -1)[inside].mean())


def delta_e_itp(first, second):
    """Delta E ITP of linear sRGB in cd/m^2, (..., 3): (...).

    Examples
    --------
    Of two greys only I differs.

    >>> float(delta_e_itp(np.full(3, 100.0), np.full(3, 203.0)).round(1))
    52.2
    """
    return 720 * np.linalg.norm(itp(first) - itp(second), axis=-1)


def itp(linear):
    """I, T and P of linear sRGB in cd/m^2, not below 0: (..., 3) to (..., 3)."""
    return pq(np.maximum(np.asarray(linear) @ _WIDE.T, 0) @ _LMS.T) @ _ITP.T


def pq(luminance):
    """The PQ signal of BT.2100 of 0 to 10,000 cd/m^2: 0 to 1.

    Examples
    --------
    BT.2408 gives 58 % for reference white.

    >>> pq([0, 203, 10000]).round(2).tolist()
    [0.0, 0.58, 1.0]
    """
    y = (np.clip(luminance, 0, 10_000) / 10_000) ** (2610 / 16384)
    return ((3424 / 4096 + 2413 / 128 * y) / (1 + 2392 / 128 * y)) ** (2523 / 32)
