"""Methods side by side on one measurement: size, errors seen and held out, physics, ringing, time."""

import time

import numpy as np

from ..quality import cross_validation, physics
from ..quality.metrics import error_metrics
from . import ringing
from .methods import METHODS
from .times import interleaved

ALBEDO_ANGLES = tuple(range(0, 90, 10))         # degrees
_REPEATS = 3                # evaluations that are timed


def compare(samples, methods=METHODS):
    """One row a method.

    Parameters
    ----------
    samples : Samples
    methods : name to (samples to model)

    Returns
    -------
    list of dict
        material, source, method, coefficients (a channel), bytes (all channels); rmse, mae, mre and
        cube_root_rmse at the samples; held_out_rmse and held_out_cube_root_rmse; ringing; reciprocity_error,
        negative_fraction and negative_energy; albedo, that of the brightest channel at ALBEDO_ANGLES;
        fit_seconds, and evaluate_microseconds for one pair of directions in NumPy, both of the processor.
    """
    lines = ringing.neighbours(samples)
    pairs = physics.direction_pairs()
    rows = []
    for name, make in methods.items():
        start = time.process_time()
        model = make(samples)
        fitted = time.process_time()
        evaluation, = interleaved({name: lambda model=model: model.evaluate(*pairs)}, _REPEATS).values()
        held_out = cross_validation.held_out(samples, make)
        albedo = physics.directional_albedo(model, np.radians(ALBEDO_ANGLES)).max(axis=1)
        rows.append({"material": samples.name, "source": samples.source, "method": name,
                     "coefficients": model.coefficient_count, "bytes": model.nbytes, **at_samples(samples, model),
                     "held_out_rmse": held_out.rmse, "held_out_cube_root_rmse": held_out.cube_root_rmse,
                     "ringing": ringing.ringing(samples, model, lines), **physics.measure(model, pairs)._asdict(),
                     "albedo": albedo.tolist(), "fit_seconds": fitted - start,
                     "evaluate_microseconds": 1e6 * evaluation / len(pairs[0])})
    return rows


def at_samples(samples, model):
    """The paper's errors at the samples, and that of the cube root of cosine-weighted values: a dict."""
    values = model.evaluate(*samples.directions)
    cubes = [cross_validation.cube_root(samples.theta_o, of) for of in (values, samples.values)]
    return {**error_metrics(samples.values, values)._asdict(),
            "cube_root_rmse": float(np.sqrt(np.mean((cubes[0] - cubes[1]) ** 2)))}
