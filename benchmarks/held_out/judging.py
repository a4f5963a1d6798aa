"""The errors of methods on one set: at samples held out, and where the truth is known, at directions all over.

A set of up to `SMALL` samples is predicted in five folds, of a larger one the first of them. The errors against a
truth, the bytes and the pictures are of the fit that did not see the first fold.
"""

from functools import partial

import numpy as np

from fitter.quality import cross_validation
from fitter.samples import distinct_channels, subset

from ..harness.judging import KINDS, are_judged, attempted, directions, errors
from ..report.methods import METHODS
from . import pictures

SMALL = 300                 # samples
_KINDS = KINDS[:2]
ERRORS = tuple(f"{place}_{kind}" for place in ("held_out", "truth") for kind in _KINDS)


def judge(found, out):
    """Fit all `METHODS` to a `JudgedSet`, measure them, and write the spheres of a telling one: the record.

    name, family, half; samples, judged (how many were predicted), folds, channels (distinct ones), and methods: for
    each its `ERRORS` (those of the truth None where there is none), bytes of all channels, and seconds of the
    processor. A method that failed has None for its errors, and says why in "failed".
    """
    samples, truth = found.open()
    parts = cross_validation.folds(len(samples))
    parts = parts[:1] if len(samples) > SMALL else parts
    judged = are_judged(samples)
    models = {}

    def measured(name):
        row, model = _measure(samples, truth, parts, judged, METHODS[name])
        models[name] = model
        return row

    record = {"name": found.name, "family": found.family, "half": found.half, "samples": len(samples),
              "judged": sum(np.count_nonzero(judged[part]) for part in parts), "folds": len(parts),
              "channels": len(distinct_channels(samples)[0].channels),
              "methods": {name: attempted(partial(measured, name), (*ERRORS, "bytes")) for name in METHODS}}
    if found.name in pictures.TELLING:
        pictures.write(found, models, out)
    return record


def _measure(samples, truth, parts, judged, make):
    predicted = np.empty(samples.values.shape)
    first = None
    for part in parts:
        seen = np.ones(len(samples), dtype=bool)
        seen[part] = False
        model = make(subset(samples, seen))
        predicted[part] = model.evaluate(*subset(samples, part).directions)
        first = model if first is None else first
    here = np.concatenate([part[judged[part]] for part in parts])
    row = errors("held_out", samples.theta_o[here], samples.values[here], predicted[here], _KINDS)
    against = {f"truth_{kind}": None for kind in _KINDS}
    if truth is not None:
        at = directions()
        against = errors("truth", at[2], truth.evaluate(*at), first.evaluate(*at), _KINDS)
    return {**row, **against, "bytes": first.nbytes}, first
