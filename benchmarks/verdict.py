"""What the grades of `fitter.quality.verdict` rest on: fits of surfaces that are known everywhere, and their pictures.

A lit sphere of each fit is compared with one of the surface. A grade promises that they differ by no more than its
limit, in the mean over the sphere: "excellent" is not visible, "good" just noticeable, "fair" visible beside each
other. Printed is how often that is so, for each half of the sets: the limits of the errors were chosen with one.

    python -m benchmarks.verdict        some five minutes
"""

import math
import os
import sys

os.environ["OPENBLAS_NUM_THREADS"] = "1"    # before NumPy starts them

import numpy as np

import fitter
from fitter import methods, pictures
from fitter.quality import verdict

from .held_out import sets

PROMISED = {"excellent": 1.0, "good": 2.3, "fair": 5.0}     # CIELAB; 2.3 is the just noticeable difference
PRESETS = ("Draft", "Standard", "Paper")
_SIZE = 64                  # pixels of a sphere
_QUICK = 5                  # of the nets of RGL, every fifth
_TO_XYZ = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])


def quick_sets(half):
    """The sets of a half that are measurements of a known surface, and have few samples."""
    found = [each for each in sets.at_hand(half)[0] if not each.name.endswith("goniometer")]
    nets = [each for each in found if each.name.startswith("RGL net")]
    return [each for each in found if each.family in ("synthetic", "MERL nets")] + nets[::_QUICK]


def lab(picture):
    """CIELAB of a picture in sRGB: (..., 4) to (..., 3)."""
    encoded = picture[..., :3].astype(float)
    linear = np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)
    x = linear @ (_TO_XYZ / _TO_XYZ.sum(axis=1, keepdims=True)).T
    f = np.where(x > 216 / 24389, np.cbrt(x), (24389 / 27 * x + 16) / 116)
    return np.stack([116 * f[..., 1] - 16, 500 * (f[..., 0] - f[..., 1]), 200 * (f[..., 1] - f[..., 2])], axis=-1)


def judged(item):
    """(preset, error at the samples, at unseen ones, difference of the spheres) of the fits of a set."""
    samples, truth = item.open()
    inside, expected = pictures.sphere(_SIZE)[1], lab(pictures.lit_sphere(truth, _SIZE))
    prepared = methods.prepare(samples, "kriging")
    for name in PRESETS:
        arguments = fitter.PRESETS[name]
        made = fitter.fit(samples, **arguments, **(prepared if arguments["method"] == "kriging" else {}))
        match, unseen = verdict.steps(samples, made.evaluate(*samples.directions)), verdict.UNKNOWN
        if arguments["method"] == "mba":
            unseen = verdict.unseen(samples, lambda part, arguments=arguments: fitter.fit(part, **arguments))
        elif prepared["estimated"].left_out is not None:
            columns = fitter.samples.distinct_channels(samples)[1]
            unseen = math.hypot(match, verdict.steps(samples, prepared["estimated"].left_out[:, columns]))
        found = np.linalg.norm(lab(pictures.lit_sphere(made, _SIZE)) - expected, axis=-1)[inside].mean()
        yield name, match, unseen, found


def table(rows):
    """How often the grades keep their promise, as text."""
    lines = []
    for kind, column, limits in (("at the samples", 1, verdict.MATCH_LIMITS), ("between them", 2,
                                                                               verdict.BETWEEN_LIMITS)):
        known = [row for row in rows if row[column] != verdict.UNKNOWN]
        for limit, (grade, promised) in zip(limits, PROMISED.items(), strict=True):
            found = [row[3] <= promised for row in known if row[column] <= limit]
            lines.append(f"{kind:15} {grade:10} up to {limit:4.1f} steps: {len(found):3} of {len(known)} fits, "
                         f"{np.mean(found):6.1%} of them within {promised} of the surface")
    return "\n".join(lines)


def main():
    """Print the table of each half."""
    for half in reversed(sets.HALVES):
        items = quick_sets(half)
        rows = []
        for number, item in enumerate(items, 1):
            rows += judged(item)
            print(f"{half}: {number} of {len(items)}", end="\r", file=sys.stderr, flush=True)
        print(f"{half} half, {len(items)} sets, presets {', '.join(PRESETS)}\n{table(rows)}\n", flush=True)


if __name__ == "__main__":
    main()
