"""The size and the errors of the presets and their rivals on one material.

The presets are fitted to all samples and judged at all of them, and between them at the directions of `harness.judging`
against the truth; those of the paper's method, which takes a minute for MERL's million, to PAPER_SAMPLES at random,
which changes errors by less than 1 %. Folds, as `held_out` has, would not judge the published models, which have seen
all.

RGL's values may be negative, a fifth of chm_mint's, which no preset nor network follows. So there are errors at the
samples "clipped" too, where negative ones count as 0, as in the authors' own reader; and between them, and in pictures,
the truth is clipped. GGX is fitted to samples to 85 degrees: beyond them its lobe is bright in every metal, and a few
extrapolated samples would decide its width.
"""

import time
from functools import partial

import numpy as np

import fitter
from fitter.methods import prepare
from fitter.samples import distinct_channels, subset
from fitter.storage.files import replace_file

from ..harness.judging import KINDS, are_judged, attempted, directions, errors
from ..report.baselines import ggx
from . import image_errors, sphere

OWN = ("Draft", "Standard", "Reference", "Paper")
GGX = "GGX"
GGX_SAMPLES, PAPER_SAMPLES = 4000, 100_000
PLACES = ("samples", "clipped", "between")
ERRORS = tuple(f"{place}_{kind}" for place in PLACES for kind in KINDS)
RENDERED = ("psnr", "mae", "flip", "delta_e_itp")
TRUTH = "truth"
_SEED = 2012


def pictures_of(record, out):
    """The file of a material's pictures, of the truth and the models by name: (size, size, 3) float32, scene-linear."""
    return out / f"{record['name']}.npz"


def judge(material, out):
    """Fit the presets and GGX to a material, measure them and the published models, and write pictures: the record.

    name, family; samples, channels (distinct ones); and models: for each bytes of all channels, seconds of the fit in
    processor time, `ERRORS` and `RENDERED`, 1/sr, or to the power 1/3 where of cube roots. What is not known is None:
    all errors of a model that the samples are made of, and of one that failed, which says why in "failed".
    """
    opened = material.open()
    samples, truth, scene = opened.samples, opened.truth, sphere.scene()
    between = directions()
    exact, true_picture = np.maximum(sphere.evaluated(truth, between), 0), sphere.render(truth, scene)
    pictures = {TRUTH: true_picture.astype(np.float32)}

    def measured(name, make):
        begun = time.process_time()
        model = make()
        fitted = time.process_time() - begun
        picture = sphere.render(model, scene)
        values = sphere.evaluated(model, samples.directions)
        row = {"bytes": model.nbytes, "seconds": fitted,
               **errors("samples", samples.theta_o, samples.values, values),
               **errors("clipped", samples.theta_o, np.maximum(samples.values, 0), values),
               **errors("between", between[2], exact, sphere.evaluated(model, between)),
               **image_errors.errors(true_picture, picture, scene.inside)}
        pictures[name] = picture.astype(np.float32)
        return row

    unknown = "bytes", *ERRORS, *RENDERED
    models = {name: attempted(partial(measured, name, make), unknown)
              for name, make in _makers(samples, opened.rivals).items()}
    models |= {name: dict.fromkeys(unknown) | {"bytes": size, "seconds": 0.0} for name, size in opened.stored.items()}
    record = {"name": material.name, "family": material.family, "samples": len(samples),
              "channels": len(distinct_channels(samples)[0].channels), "models": models}
    with replace_file(pictures_of(record, out), "wb") as stream:
        np.savez_compressed(stream, **pictures)
    return record


def _makers(samples, rivals):
    """Functions without arguments that return each model. The presets of one method share what `prepare` does."""
    prepared = {}

    def of_preset(name):
        preset = fitter.PRESETS[name]
        if preset["method"] == "mba":
            return fitter.fit(_thinned(samples, PAPER_SAMPLES), **preset)
        if preset["method"] not in prepared:
            prepared[preset["method"]] = prepare(samples, preset["method"])
        return fitter.fit(samples, **preset, **prepared[preset["method"]])

    makers = {name: (lambda name=name: of_preset(name)) for name in OWN}
    return makers | {name: (lambda model=model: model) for name, model in rivals.items()} | {
        GGX: lambda: ggx.fit(_thinned(_below(samples), GGX_SAMPLES))}


def _below(samples):
    """The samples to STEEPEST, or where there are none all."""
    kept = are_judged(samples)
    return subset(samples, kept) if kept.any() else samples


def _thinned(samples, count):
    if len(samples) <= count:
        return samples
    kept = np.random.default_rng(_SEED).choice(len(samples), count, replace=False)
    return subset(samples, np.sort(kept))
