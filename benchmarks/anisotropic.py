"""Anisotropic materials: error and storage of the presets, and of what else there is of their size.

    python -m benchmarks.anisotropic [--materials ...] [--write docs/anisotropic.md]

Analytic truths are measured at 16 rotations with noise of half a percent, and fits judged at directions between the
measured ones. Files are judged at a fifth of their samples, which no fit has seen. Errors are root mean squares of cube
roots of cosine-weighted values, relative to those of the truth. Rivals are one anisotropic lobe over a Lambertian,
fitted by least squares (GGX, Ward), and the paper's method in four dimensions, (2, 4, C) or (2, 5, C), with as many
bytes as Standard. Materials "a" and the synthetic RGL file were looked at while constants were chosen; the others were
not.
"""

import argparse
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

import fitter
from fitter.quality.cross_validation import cube_root
from fitter.samples import RGB, Samples, subset
from support.anisotropic import ANISOTROPIC, between, rotations
from support.checkout import measurements

from .harness.running import commit
from .report.baselines import anisotropic

FILES = ("rgl/synthetic_aniso_rgb.bsdf", "goniometer/IMX455.bsdf")
PRESETS = ("Draft", "Standard", "Reference")
RIVALS = "GGX", "Ward"
_ROTATIONS, _BETWEEN, _FOR_LOBES = 16, 20_000, 5000
_FARTHEST = np.radians(83)
_BUDGET = 64 * 1024         # bytes a channel, of Standard


def materials():
    """Pairs of (name, function to call): (samples to fit, samples to judge by)."""
    def analytic(truth):
        directions, random = rotations(_ROTATIONS), np.random.default_rng(0)
        exact = truth.evaluate(*directions)
        noisy = exact * (1 + truth.noise * random.standard_normal(exact.shape))
        unseen = between(_BETWEEN, _FARTHEST)
        return (Samples(*directions, noisy, RGB, truth.name, isotropic=False),
                Samples(*unseen, truth.evaluate(*unseen), RGB, isotropic=False))

    def measured(path):
        samples = fitter.load(path)
        held = np.random.default_rng(0).random(len(samples)) < 0.2
        return subset(samples, ~held), subset(samples, held)

    found = {truth.name: lambda truth=truth: analytic(truth) for truth in ANISOTROPIC}
    files = [path for path in map(measurements().joinpath, FILES) if path.is_file()]
    return found | {path.stem: lambda path=path: measured(path) for path in files}


def models(samples):
    """Pairs of (name, function that makes it)."""
    some = subset(samples, np.sort(np.random.default_rng(2).permutation(len(samples))[:_FOR_LOBES]))
    made = {}

    def of_preset(name):
        made[name] = fitter.fit(samples, **fitter.PRESETS[name])
        return made[name]

    def of_paper(level):
        small = fitter.fit(samples, 2, level, 99.9)
        count = (made["Standard"].nbytes - small.diffuse.nbytes) / (small.specular.nbytes / len(small.specular))
        return fitter.fit(samples, 2, level, 100 * (1 - count / (2 ** level + 3) ** 4))

    yield from ((name, lambda name=name: of_preset(name)) for name in PRESETS)
    yield from ((f"Paper (2,{level})", lambda level=level: of_paper(level)) for level in (4, 5))
    yield from ((kind, lambda kind=kind: anisotropic.fit(some, kind)) for kind in RIVALS)
    yield "Standard, isotropic", lambda: fitter.fit(replace(samples, isotropic=True), **fitter.PRESETS["Standard"])


def error(model, judge):
    """The relative error of a model at samples."""
    true = cube_root(judge.theta_o, judge.values)
    found = cube_root(judge.theta_o, model.evaluate(*judge.directions))
    return float(np.sqrt(np.mean((found - true) ** 2) / np.mean(true ** 2)))


def rows(names):
    """A row for each material and model."""
    for name, make in materials().items():
        if names and name not in names:
            continue
        samples, judge = make()
        seen = subset(samples, np.sort(np.random.default_rng(3).permutation(len(samples))[:_BETWEEN]))
        for model_name, make_model in models(samples):
            start = time.process_time()
            model = make_model()
            seconds = time.process_time() - start
            yield {"material": name, "model": model_name, "bytes": model.nbytes // len(samples.channels),
                   "samples": error(model, seen), "between": error(model, judge), "seconds": seconds}


def summary(table):
    """What of the wished bounds is met, as lines."""
    names = list(dict.fromkeys(row["material"] for row in table))
    by = {(row["material"], row["model"]): row for row in table}
    rivals = [model for model in dict.fromkeys(row["model"] for row in table) if model in RIVALS or "Paper" in model]
    ratios = {name: by[name, "Standard"]["between"] / min(by[name, rival]["between"] for rival in rivals)
              for name in names}
    met = [name for name in names if ratios[name] <= 0.5]
    missed = ", ".join(f"{name} ({ratios[name]:.2f})" for name in names if name not in met)
    small = sum(by[name, "Standard"]["bytes"] <= _BUDGET for name in names)
    return [f"Standard takes at most {_BUDGET:,} bytes a channel: {small} of {len(names)}",
            f"Standard has at most half of the best rival's error between the samples: {len(met)} of {len(names)}"
            + (f"; not for {missed}" if missed else "")]


def markdown(table):
    """The table as text."""
    lines = ["| material | model | bytes a channel | error, samples | error, between | fit [s] |",
             "| --- | --- | ---: | ---: | ---: | ---: |"]
    lines += [f"| {row['material']} | {row['model']} | {row['bytes']:,} | {row['samples']:.4f} | "
              f"{row['between']:.4f} | {row['seconds']:.1f} |" for row in table]
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(prog="benchmarks.anisotropic", description=__doc__.split("\n")[0])
    parser.add_argument("--materials", nargs="+", default=(), help="all, unless some are named")
    parser.add_argument("--write", type=Path, metavar="FILE.md", help="write a page, besides printing")
    arguments = parser.parse_args()
    table = []
    for row in rows(arguments.materials):
        table.append(row)
        print(f"{row['material']:20} {row['model']:20} {row['bytes']:8,} {row['samples']:8.4f} {row['between']:8.4f} "
              f"{row['seconds']:7.1f} s", flush=True)
    lines = summary(table)
    print("\n".join(lines))
    if arguments.write:
        arguments.write.write_text(page(table, lines), encoding="utf-8")


def page(table, lines):
    """The page of the documentation."""
    method = " ".join(__doc__.split("\n\n", 2)[2].split())
    text = "\n".join(f"- {line}" for line in lines)
    return (f"# Anisotropic materials\n\nWritten by `python -m benchmarks.anisotropic --write docs/anisotropic.md` at "
            f"commit {commit()}.\n\n{text}\n\n{method}\n\n{markdown(table)}\n")


if __name__ == "__main__":
    main()
