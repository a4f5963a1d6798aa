"""What each stage of the preset Standard gains: ``python -m benchmarks.ablation`` prints a table.

Each set is fitted with all stages, and without one of them at a time: one function or constant of `fitter` is replaced.
Two folds of five are predicted by fits to the others, and judged as `make held-out` does: by the error of the cube
root of cosine-weighted reflectance, of samples up to 85 degrees. The table has the geometric means over the sets of the
errors in those with all stages: 1.10 is a stage whose absence makes errors a tenth larger. Sets of the judged half, of
which larger ones are reduced to 640 samples at random; on one core, about a quarter of an hour. A stage that the code
no longer has is left out, and said to be.
"""

import argparse
import os
import pkgutil
import sys
import time
from collections.abc import Callable
from contextlib import ExitStack
from functools import partial
from typing import Any, NamedTuple
from unittest import mock

if __name__ == "__main__":
    os.environ["OPENBLAS_NUM_THREADS"] = "1"    # before NumPy starts them

import numpy as np

from fitter import PRESETS, methods
from fitter.quality import cross_validation
from fitter.samples import subset

from .harness.judging import are_judged
from .harness.running import named
from .held_out import sets

CURET_STEP = 5              # every fifth of the judged half
OTHERS = ("Cornell garnet_red_RGB", "RGL vch_silk_blue_rgb", "MERL pvc", "MERL silver-paint")
QUICK = ("CURET 2 ", "CURET 32 ", "MERL pvc")
MOST = 640                  # samples
FOLDS = 2
ALL = "all stages"
_KRIGING, _PROCESS, _LATTICES = (f"fitter.methods.{name}" for name in (
    "regression_kriging", "gaussian_process", "lattices"))


class Stage(NamedTuple):
    """How a stage is switched off.

    Attributes
    ----------
    name : str
        What is left out.
    target : str
        The dotted name of the function or constant that is replaced; empty where an argument of `fit` does it.
    replacement : callable
        Of what the target was; returns what takes its place.
    estimated : bool
        Whether it is part of `methods.prepare`, which does not depend on the levels, or comes after it.
    arguments : tuple of (str, value)
        Of `fit`, in the place of the preset's.
    """

    name: str
    target: str = ""
    replacement: Callable[[Any], Any] = lambda original: original
    estimated: bool = False
    arguments: tuple[tuple[str, Any], ...] = ()


def _number(value):
    return lambda _original: value


def _only(number):
    """One system of coordinates."""
    return lambda families: lambda samples, model: families(samples, model)[number:number + 1]


def _as_it_is(_mean):
    return lambda field, mu: field.at(mu.reshape(-1, 3)).reshape(*mu.shape[:-1], -1)


STAGES = (
    Stage("Gaussian process: lattices fitted as for many samples", f"{_KRIGING}.MOST_SAMPLES", _number(0), True),
    Stage("search: first length, noise by likelihood", f"{_PROCESS}._ROUNDS", _number(0), True),
    Stage("choice of the stretch: 5 for all", f"{_KRIGING}._STRETCHES", _number((5.0,)), True),
    Stage("choice of the length: 1.75 for all", f"{_PROCESS}.LENGTHS", _number((1.75,)), True),
    Stage("trend of the kernel", f"{_PROCESS}.TREND", _number(1e-6), True),
    Stage("reciprocity of the kernel", f"{_PROCESS}.RECIPROCITIES", _number((0.0,)), True),
    Stage("half and difference angles", f"{_KRIGING}._families", _only(0), True),
    Stage("half and difference vectors", f"{_KRIGING}._families", _only(1), True),
    Stage("lobes: a Lambertian prior", "fitter.methods.prior.candidates", lambda of: partial(of, most=0), True),
    Stage("second and third lobe", "fitter.methods.prior.candidates", lambda of: partial(of, most=1), True),
    Stage("third lobe", "fitter.methods.prior.candidates", lambda of: partial(of, most=2), True),
    Stage("retro-reflecting and sheen lobes", "fitter.methods.prior._STARTS",
          lambda starts: tuple(start for start in starts if start[0] == "mirror"), True),
    Stage("failures of detectors", f"{_KRIGING}._RARELY", _number(-1.0), True),
    Stage("sparse lattice", arguments=(("specular_level", None),)),
    Stage("directions between the samples", f"{_LATTICES}._BETWEEN", _number(1)),
    Stage("mean over azimuths at retro-reflection", f"{_LATTICES}._mean_over_azimuths", _as_it_is),
    Stage("plausibility: floor and energy", arguments=(("plausible", False),)),
)


def off(stage):
    """A context in which a stage is switched off; AttributeError or ImportError where there is no such stage."""
    if not stage.target:
        return ExitStack()
    return mock.patch(stage.target, stage.replacement(pkgutil.resolve_name(stage.target)))


def errors(samples):
    """The error without each stage that there is, by its name, and with all of them: a dict."""
    found = {stage.name: [] for stage in (Stage(ALL), *STAGES)}
    for part in cross_validation.folds(len(samples))[:FOLDS]:
        seen = np.ones(len(samples), bool)
        seen[part] = False
        seen_samples, judged = subset(samples, seen), subset(samples, part[are_judged(samples)[part]])
        estimate = methods.prepare(seen_samples, "kriging")
        for stage in (Stage(ALL), *STAGES):
            try:
                with off(stage):
                    fitted = methods.fit(seen_samples, **PRESETS["Standard"] | dict(stage.arguments),
                                         **({} if stage.estimated else estimate))
            except (AttributeError, ImportError) as error:
                print(f"left out: {stage.name}: {error}")
                continue
            predicted = fitted.evaluate(*judged.directions)
            found[stage.name].append(cross_validation.errors(judged, predicted).cube_root_rmse)
    return {name: float(np.sqrt(np.mean(np.square(each)))) for name, each in found.items() if each}


def main(arguments=None):
    """Print the table."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.ablation", description=__doc__.splitlines()[0])
    parser.add_argument("--sets", nargs="+", metavar="NAME", help="those of the judged half whose names contain one")
    parser.add_argument("--quick", action="store_true", help="two sets of CURET and one other")
    options = parser.parse_args(arguments)
    at_hand, _ = sets.at_hand("judged")
    curet = [each for each in at_hand if each.family == "CURET"][::CURET_STEP]
    names = options.sets or (QUICK if options.quick else [*(each.name for each in curet), *OTHERS])
    columns = {"CURET": [], "others": []}
    for chosen in named(at_hand, names):
        start, (samples, _) = time.process_time(), chosen.open()
        some = np.sort(np.random.default_rng(0).permutation(len(samples))[:MOST])
        of_all = (found := errors(subset(samples, some)))[ALL]
        columns["CURET" if chosen.family == "CURET" else "others"].append(
            {name: error / of_all for name, error in found.items()})
        print(f"{chosen.name}: {len(some)} samples, error {of_all:.4f}; {time.process_time() - start:.0f} s",
              flush=True)
    print(f"\n{'without':52}" + "".join(f"{f'{name} ({len(each)})':>14}" for name, each in columns.items()))
    for stage in STAGES:
        shares = [[ratios[stage.name] for ratios in each if stage.name in ratios] for each in columns.values()]
        print(f"{stage.name:52}" + "".join(f"{np.exp(np.mean(np.log(each))) if each else np.nan:14.3f}"
                                           for each in shares))


if __name__ == "__main__":
    sys.exit(main())
