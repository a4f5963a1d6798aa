"""Methods side by side on one material: size, errors at fitted and held-out samples, physics and time."""

import time
from functools import partial

import numpy as np

from fitter.model import Reflectance
from fitter.quality import cross_validation, physics
from fitter.quality.metrics import error_metrics
from fitter.samples import Samples

from .methods import METHODS
from .rows import Row
from .times import interleaved

_REPEATS = 3                # timed evaluations


def compare(samples: Samples) -> list[Row]:
    """Compare all `METHODS` on samples.

    One row a method: material, source, method, coefficients (of a channel), bytes (of all channels); rmse, mae, mre and
    cube_root_rmse at the samples; held_out_rmse and held_out_cube_root_rmse; reciprocity_error, negative_fraction and
    negative_energy; fit_seconds, and evaluate_microseconds for one pair of directions in NumPy, both in processor time.
    """
    pairs = physics.direction_pairs()
    rows = []
    for name, make in METHODS.items():
        start = time.process_time()
        model = make(samples)
        fitted = time.process_time()
        evaluation, = interleaved({name: partial(model.evaluate, *pairs)}, _REPEATS).values()
        held_out = cross_validation.cross_validate(samples, make)
        rows.append({"material": samples.name, "source": samples.source, "method": name,
                     "coefficients": model.coefficient_count, "bytes": model.nbytes, **at_samples(samples, model),
                     "held_out_rmse": held_out.rmse, "held_out_cube_root_rmse": held_out.cube_root_rmse,
                     **physics.measure(model, pairs)._asdict(), "fit_seconds": fitted - start,
                     "evaluate_microseconds": 1e6 * evaluation / len(pairs[0])})
    return rows


def at_samples(samples: Samples, model: Reflectance) -> Row:
    """Errors at the samples: rmse, mae, mre and cube_root_rmse, the RMSE of the cube root of cosine-weighted values."""
    values = model.evaluate(*samples.directions)
    cubes = [cross_validation.cube_root(samples.theta_o, of) for of in (values, samples.values)]
    return {**error_metrics(samples.values, values)._asdict(),
            "cube_root_rmse": float(np.sqrt(np.mean((cubes[0] - cubes[1]) ** 2)))}
