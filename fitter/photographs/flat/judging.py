"""What photographs of a flat sample are judged by: predictions of those left out, also by texels that are each for
itself.

Those are a Lambertian, and a polynomial texture map (PTM: T. Malzbender, D. Gelb, H. Wolters: Polynomial Texture Maps,
SIGGRAPH 2001), which is a polynomial of second degree in the direction to the lamp.
"""

from collections.abc import Callable, Sequence
from itertools import combinations

import numpy as np

from ...arrays import ArrayLike, BoolArray, FloatArray, IntArray
from ...model import Reflectance
from .photograph import Observed
from .solving import Texels, radiances, slopes_to_normals, solve_texels

_RIDGE = 1e-6
_LEAST_SEEN = 10            # values of a photograph that can be judged
_TRIED = 30                 # texels by which photographs are taken out in turn
_IN_TURN = 6                # rounds of lamps and normals
_LEAST_COSINE = 0.05        # with which a texel faces a lamp; of the median, that a lamp has
_GROUPS = 4                 # of photographs, each of which is predicted by the others
_WORSE, _FAR_OFF = 2.5, 0.15    # of the median error, and above it, from where a photograph is not as others say
_WORTH_REJECTING = 0.6               # of the errors, that taking an odd photograph out leaves at most
_EXPLAINED = 2.0            # of the noise's variance, up to which nothing is odd
_EXCHANGED = 0.5            # of their errors, that two lamps have which are exchanged
_OF_ROOM = 0.7              # of the squared errors, that a room's light leaves, where there is some
_LEAST_ROOM = 0.02          # of what is seen, that a room's light is
_MOST_SUSPECTS = 4          # photographs whose lamps may be exchanged
_AS_GIVEN = 0.2            # of the curl of normals as given, that they have if lamps are mirrored or turned


def relative_errors(expected: FloatArray, seen: Observed) -> list[float]:
    """How far each photograph that tells of enough texels is from what is expected of it, (n, p, channels), of its root
    mean square."""
    good = seen.good[..., None]
    off, size = (np.sqrt((np.where(good, each, 0) ** 2).sum(axis=(0, 2))) for each in (
        expected - seen.radiance, seen.radiance))
    told = (seen.good.sum(axis=0) >= _LEAST_SEEN) & (size > 0)
    return [float(each) for each in off[told] / size[told]]


def predict_unconstrained(used: Observed, other: Observed, frame: FloatArray) -> dict[str, FloatArray]:
    """What a Lambertian and a PTM of each texel and channel expect of other photographs: (n, p, channels) each."""
    return {name: np.maximum(_linear(basis, used, other, frame), 0) * other.lit.brought
            for name, basis in UNCONSTRAINED.items()}


def lamp_brightness(seen: Observed, frame: FloatArray) -> FloatArray:
    """How bright each lamp is beside what is given, (p, channels), 1 in the geometric mean of each channel.

    By texels that are Lambertian, in the median over them, whose normals and lamps are found in turn. Where all texels
    lie flat a tilt of the sample and lamps that are brighter on one side are the same; it begins with no tilt.
    """
    seen = seen.some(np.flatnonzero(seen.good.sum(axis=1) > 2))
    values = np.where(seen.good[..., None], seen.radiance / seen.lit.brought, np.nan)
    known = seen.good.any(axis=0)
    expected = np.maximum(seen.lit.light @ frame[2], _LEAST_COSINE)[..., None] * np.nanmean(
        values, axis=1, keepdims=True)
    brightness = np.ones(values.shape[1:])
    for _ in range(_IN_TURN):
        ratio = np.where(expected > 0, values / np.where(expected > 0, expected, 1), np.nan)
        brightness[known] = np.nanmedian(ratio[:, known], axis=0)
        brightness = np.maximum(brightness, _LEAST_COSINE * np.median(brightness, axis=0) + np.finfo(float).tiny)
        brightness /= np.exp(np.log(brightness).mean(axis=0))
        equal = seen._replace(radiance=seen.radiance / brightness)
        expected = np.maximum(_linear(np.asarray, equal, equal, frame), 0)
    return brightness


def _linear(basis: Callable[[FloatArray], FloatArray], used: Observed, other: Observed,
            frame: FloatArray) -> FloatArray:
    there, here = (basis(seen.lit.light @ frame.T) for seen in (other, used))
    weight = used.good.astype(float)
    gram = np.einsum("np,npi,npj->nij", weight, here, here)
    gram += (_RIDGE * np.trace(gram, axis1=1, axis2=2) + np.finfo(float).tiny)[:, None, None] * np.eye(gram.shape[1])
    right = np.einsum("np,npi,npc->nic", weight, here, used.radiance / used.lit.brought)
    return np.asarray(np.einsum("npi,nic->npc", there, np.linalg.solve(gram, right)))


def _polynomial(light: FloatArray) -> FloatArray:
    x, y = light[..., 0], light[..., 1]
    return np.stack([x * x, y * y, x * y, x, y, np.ones_like(x)], axis=-1)


UNCONSTRAINED: dict[str, Callable[[FloatArray], FloatArray]] = {"Lambertian": np.asarray, "PTM": _polynomial}


class _Room:
    """What is as bright whatever the lamp: a reflectance 1 / cos(theta_i)."""

    def evaluate(self, theta_i: ArrayLike, phi_i: ArrayLike, theta_o: ArrayLike, phi_o: ArrayLike) -> FloatArray:
        """As of any model: (..., 1)."""
        return np.asarray(1 / np.maximum(np.cos(theta_i), 1e-3))[..., None]


def contradictions(fits: Sequence[Reflectance], seen: Observed, frame: FloatArray, names: Sequence[str]) -> list[str]:
    """What n texels, some of a sample of these materials, say against what is given of their photographs: in words.

    Photographs that the others do not predict, and a room that was not dark.
    """
    enough = np.flatnonzero(seen.good.sum(axis=1) >= 3)
    if len(enough) < _LEAST_SEEN or len(names) < _GROUPS:
        return []
    seen = seen.some(enough)
    lines = []
    alike, slopes, errors = _reject_odd_photographs(fits, seen, frame)
    usual = float(np.median(errors[alike]))
    odd = [int(k) for k in np.flatnonzero(errors > usual + max(_FAR_OFF, (_WORSE - 1) * usual))]
    if odd:
        lines.append("The others do not predict " + ", ".join(f"{names[k]} ({errors[k]:.2f} off)" for k in odd)
                     + f", beside {usual:.2f} in the median: is the lamp where it is said to be? leave_out leaves such "
                       "photographs out")
    for i, j in combinations(odd[:_MOST_SUSPECTS], 2):
        order = np.arange(len(names))
        order[[i, j]] = j, i
        swapped = seen._replace(lit=seen.lit._replace(light=seen.lit.light[:, order],
                                                      brought=seen.lit.brought[:, order]))
        if _errors(fits, swapped, frame, alike, slopes)[[i, j]].sum() < _EXCHANGED * errors[[i, j]].sum():
            lines.append(f"The lamps of {names[i]} and {names[j]} look as if they were exchanged")
    return lines if odd else lines + _room(fits, seen, frame, slopes)


def _reject_odd_photographs(fits: Sequence[Reflectance], seen: Observed,
                frame: FloatArray) -> tuple[IntArray, FloatArray, FloatArray]:
    """Reject one photograph after the other, at most a quarter, while the rest then agree much better: the indices of
    those that are kept; the slopes that these tell, (n, 2); and the error of each photograph beside them, (p,)."""
    alike, fewest = np.arange(seen.good.shape[1]), max(_GROUPS, 3 * seen.good.shape[1] // 4)
    texels = solve_texels(fits, seen, frame)
    # first each one without which the rest explains some texels best
    some = np.arange(0, len(seen.good), max(len(seen.good) // _TRIED, 1))
    few, now = seen.some(some), texels.part(some)
    while len(alike) > fewest and np.median(now.misfit) > _EXPLAINED:
        used = np.isin(np.arange(seen.good.shape[1]), alike)
        # each row leaves one of those that are used out
        tried = _solve_each_choice(fits, few, frame, now.slopes, used & ~np.eye(len(used), dtype=bool)[alike])
        misfit = np.median(tried.misfit.reshape(len(alike), -1), axis=1)
        odd = int(np.argmin(misfit))
        if not misfit[odd] < _WORTH_REJECTING * np.median(now.misfit):
            break
        alike, now = np.delete(alike, odd), tried.part(odd * len(some) + np.arange(len(some)))
    if len(alike) < seen.good.shape[1]:
        texels = solve_texels(fits, seen.some(np.s_[:, alike]), frame, texels.slopes)
    # then each one that the rest predicts worst: slopes and shadows may have explained it
    errors = _errors(fits, seen, frame, alike, texels.slopes)
    while len(alike) > fewest:
        fewer = np.delete(alike, int(np.argmax(errors[alike])))
        again = _errors(fits, seen, frame, fewer, texels.slopes)
        if not np.mean(again[fewer]) < _WORTH_REJECTING * np.mean(errors[fewer]):
            break
        alike, errors = fewer, again
    if len(alike) < texels.used.shape[1]:
        texels = solve_texels(fits, seen.some(np.s_[:, alike]), frame, texels.slopes)
    return alike, texels.slopes, errors


def _errors(fits: Sequence[Reflectance], seen: Observed, frame: FloatArray, alike: IntArray,
            slopes: FloatArray) -> FloatArray:
    """How far each photograph is from what those of the other groups that are alike say of it, of its root mean square:
    (p,). They are solved from slopes (n, 2)."""
    photograph = np.arange(seen.good.shape[1])
    own = photograph % _GROUPS == np.arange(_GROUPS)[:, None]
    texels = _solve_each_choice(fits, seen, frame, slopes, ~own & np.isin(photograph, alike))
    there = _repeat(seen, own)
    good = there.good & (texels.used.sum(axis=1) > 1)[:, None]
    unit = radiances(fits, there.lit, slopes_to_normals(texels.slopes, frame), good)
    off = np.where(good[..., None], np.einsum("npcm,nm->npc", unit, texels.weights) - there.radiance, 0)
    size = np.where(good[..., None], there.radiance, 0)
    return np.sqrt((off ** 2).sum(axis=(0, 2)) / np.maximum((size ** 2).sum(axis=(0, 2)), 1e-300))


def _solve_each_choice(fits: Sequence[Reflectance], seen: Observed, frame: FloatArray, slopes: FloatArray,
                       used: BoolArray) -> Texels:
    """What each of some choices of photographs, (choices, p), tells of n texels, solved from slopes (n, 2) all at once:
    choices * n of them."""
    return solve_texels(fits, _repeat(seen, used), frame, np.tile(slopes, (len(used), 1)))


def _repeat(seen: Observed, used: BoolArray) -> Observed:
    """The same for each of some choices of photographs, (choices, p), that count."""
    many = seen.some(np.tile(np.arange(len(seen.good)), len(used)))
    return many._replace(good=many.good & np.repeat(used, len(seen.good), axis=0))


def _room(fits: Sequence[Reflectance], seen: Observed, frame: FloatArray, slopes: FloatArray) -> list[str]:
    """Whether photographs show light that no lamp of theirs brings."""
    dark, lit = solve_texels(fits, seen, frame, slopes), solve_texels([*fits, _Room()], seen, frame, slopes)
    brought = np.where(seen.good[..., None], seen.lit.brought, 0).mean(axis=2)
    share = float(np.median((lit.weights[:, -1:] * brought).sum(axis=1) / np.maximum(
        np.where(seen.good, seen.radiance.mean(axis=2), 0).sum(axis=1), 1e-300)))
    if np.median(lit.misfit) < _OF_ROOM * np.median(dark.misfit) and share > _LEAST_ROOM:
        return [f"Some {share:.0%} of what photographs show looks as if it were there without the lamp: the room may "
                "not have been dark. A photograph with the lamp off, lamp.dark, takes that away"]
    return []


def turned_lamps(normals: FloatArray, frame: FloatArray, known: BoolArray, size: FloatArray) -> list[str]:
    """Whether the lamps look mirrored, or the corners turned: then normals (h, w, 3) are not those of a surface, whose
    slopes have no curl. `known` is (h, w), `size` the width and height of the sample; half a turn leaves no trace."""
    along = normals @ frame.T
    p, q = np.moveaxis(-along[..., :2] / np.maximum(along[..., 2:], 1e-3), 2, 0)
    inner = known[1:-1, 1:-1] & known[:-2, 1:-1] & known[2:, 1:-1] & known[1:-1, :-2] & known[1:-1, 2:]
    if inner.sum() < _LEAST_SEEN ** 2:
        return []
    x, y = size / known.shape[::-1]
    (p_y, p_x), (q_y, q_x) = ([(each[2:, 1:-1] - each[:-2, 1:-1])[inner] / y,
                               (each[1:-1, 2:] - each[1:-1, :-2])[inner] / x] for each in (p, q))
    curl = {"": p_y - q_x, "mirrored": p_y + q_x, "turned by 90 degrees": p_x + q_y,
            "turned by 90 degrees and mirrored": p_x - q_y}
    rest = {way: float(np.median(each ** 2)) for way, each in curl.items()}
    best = min(rest, key=lambda way: rest[way])
    if best and rest[best] < _AS_GIVEN * rest[""]:
        return [f"The normals are no surface's, but would be if the lamps' directions were {best}: are the corners in "
                "their order, and is x to the right and y up for the lamps?"]
    return []
