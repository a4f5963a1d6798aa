"""The sets at hand, in two halves: constants of a method were chosen on the one, and are judged by the other.

Materials alternate between the halves; one of RGL is in the same half as a file and as a net. Nets are measured by two
instruments in turn, synthetic materials by all three. A net is a truth, though not quite that of its name.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial

import fitter
from fitter.formats import list_samples
from fitter.samples import Samples
from support import truths
from support.checkout import measurements

from ..harness.running import named

HALVES = ("judged", "chosen")
FAMILIES = ("CURET", "Cornell", "RGL", "MERL nets", "synthetic")
_CORNELL = {"krylon_blue_RGB": "chosen", "cayman": "judged", "garnet_red_RGB": "judged"}
_ALTERNATING = ("goniometer", "Cornell")        # instruments that measure nets
_MERL_STEP = 5


@dataclass(frozen=True)
class JudgedSet:
    """A set of samples, which another process can open; the truth is what they are measurements of, if it is known."""

    name: str
    family: str                 # one of FAMILIES
    half: str                   # one of HALVES
    open: Callable[[], tuple[Samples, truths.Truth | None]]


def at_hand(half="all", names=()):
    """The sets of a half, or of "all", whose names contain one of the names; and why others are left out, in words."""
    found, left_out = [], []
    for family in (_curet, _cornell, _rgl, _merl, _synthetic):
        try:
            for item in family():
                (found if isinstance(item, JudgedSet) else left_out).append(item)
        except (fitter.DatasetError, OSError) as error:
            left_out.append(str(error))
    return named([each for each in found if half in ("all", each.half)], names), left_out


def _half(number):
    """Of the names 0, 1, ...: constants were chosen on every second."""
    return HALVES[1 - number % 2]


def _curet() -> Iterator[JudgedSet]:
    path = measurements() / "curet" / "abrdf.dat"
    for number, name in list_samples(path):
        yield JudgedSet(f"CURET {number} {name}", "CURET", _half(number - 1), partial(_file, path, number))


def _cornell() -> Iterator[JudgedSet | str]:
    for stem, half in _CORNELL.items():
        path = measurements() / "cornell" / f"{stem}.astm"
        yield JudgedSet(f"Cornell {stem}", "Cornell", half, partial(_file, path)) if path.is_file() else (
            f"{path}: is not there")


def _rgl() -> Iterator[JudgedSet | str]:
    names = truths.neural_names("rgl")
    for number, name in enumerate(names):
        path = measurements() / "rgl" / f"{name}.bsdf"
        try:
            fitter.load(path)
            yield JudgedSet(f"RGL {name}", "RGL", _half(number), partial(_file, path))
        except fitter.DatasetError as error:
            yield str(error)
    yield from _nets("rgl", "RGL net", "RGL", 1)


def _merl() -> Iterator[JudgedSet]:
    yield from _nets("merl", "MERL", "MERL nets", _MERL_STEP)


def _nets(folder, label, family, step) -> Iterator[JudgedSet]:
    names = truths.neural_names(folder)
    for first in (0, 1):
        for k, name in enumerate(names[first::2][::step]):
            instrument = _ALTERNATING[k % 2]
            yield JudgedSet(f"{label} {name}, {instrument}", family, _half(first),
                            partial(_measured, partial(truths.neural, folder, name), instrument))


def _synthetic() -> Iterator[JudgedSet]:
    for name in truths.TRUTHS:
        half = HALVES[0] if name.endswith(" b") else HALVES[1]
        for instrument in truths.INSTRUMENTS:
            yield JudgedSet(f"{name}, {instrument}", "synthetic", half,
                            partial(_measured, partial(_truth, name), instrument))


def _truth(name):
    return truths.TRUTHS[name]


def _file(path, number=None):
    return fitter.load(path, number), None


def _measured(make_truth, instrument):
    truth = make_truth()
    return truth.measured(instrument), truth
