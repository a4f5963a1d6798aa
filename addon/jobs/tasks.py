"""What is worked out in the background: reading, fitting, costs and pictures. Nothing here touches bpy.

Every function takes `report(fraction, doing)`, which is told how far it is.
"""

import hashlib
import json
import time
from collections import OrderedDict
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ... import fitter
from ...fitter import formats, pictures
from ...fitter.cycles import stand_in
from ...fitter.cycles.bake import SHADER_VERSION, bake
from ...fitter.cycles.unbake import unbake
from ...fitter.methods import regression_kriging, tolerance
from ...fitter.model import fit_file
from ...fitter.quality import cross_validation, describe
from ...fitter.samples import distinct_channels

_LEVELS = range(8)          # of the plot of errors: level 8 takes longer than all others together
_CHUNK = 1 << 16            # rows that are digested at a time
_KEPT = 12                  # fits, a few MB each
_LARGEST = 2.0 ** 62        # of a digest's whole numbers: files may claim azimuths of 1e300
_fits = OrderedDict()
_estimates = {}             # of the samples that were fitted last


def silent(_fraction, _doing):
    """A `report` for work that nobody watches."""


class Data(NamedTuple):
    """Measurements, what is to be said of them, and what tells them from others."""

    samples: fitter.Samples
    description: describe.Description
    digest: str


class Fitted(NamedTuple):
    """A fit, its errors at its samples, and the time it took."""

    fit: fitter.Fit
    errors: fitter.ErrorMetrics
    seconds: float


class Outcome(NamedTuple):
    """All that a material is made from."""

    samples: fitter.Samples
    digest: str
    fitted: Fitted
    source: str
    albedo: np.ndarray
    principled: stand_in.Principled


def read(path, sample, report=silent):
    """Read and describe measurements: Data. Raises DatasetError."""
    report(0.0, "Reading")
    samples = fitter.load(path, sample or None)
    return Data(samples, describe.describe(samples, formats.overflowed(path, sample or None)), digest(samples))


def outcome(path, sample, arguments, report=silent, known=None):
    """Read and fit measurements, up to the shader's source.

    Parameters
    ----------
    path, sample, arguments
        The measurements, and what decides the fit.
    known : (str, Fitted), optional
        The fit, where it has been made before, with the digest of its measurements.

    Returns
    -------
    Outcome

    Raises
    ------
    DatasetError, ValueError
        If the measurements or the arguments are no good.
    """
    report(0.0, "Reading")
    samples = fitter.load(path, sample or None)
    key = digest(samples)
    report(0.1, "Fitting")
    found = known[1] if known is not None and known[0] == key else fitted(samples, key, arguments)
    return finish(samples, key, found, report)


def outcomes(sources, arguments, report=silent):
    """Outcomes of several measurements, or the errors that stand for them.

    Parameters
    ----------
    sources : list of (path, sample)
    arguments : dict

    Returns
    -------
    list of (path, sample, Outcome or ValueError)
    """
    done = []
    for number, (path, sample) in enumerate(sources):
        def within(fraction, doing, number=number, name=sample or Path(path).name):
            report((number + fraction) / len(sources), f"{name}: {doing}")

        try:
            done.append((path, sample, outcome(path, sample, arguments, within)))
        except ValueError as error:
            done.append((path, sample, error))
    return done


def asset(path, sample, arguments, folder, report=silent):
    """An Outcome and a thumbnail; the fit is kept in a folder, and taken from there the next time."""
    samples = fitter.load(path, sample or None)
    key = digest(samples)
    keep = Path(folder) / f"{fit_key(samples.name, key, arguments)}.npz"
    if keep.is_file():
        found = assess(samples, fitter.Fit.load(keep), 0.0)
    else:
        found = fitted(samples, key, arguments)
        keep.parent.mkdir(parents=True, exist_ok=True)
        found.fit.save(keep)
    return finish(samples, key, found, report), pictures.lit_sphere(found.fit)


def fit_key(name, data_digest, arguments):
    """Tells whether a kept fit is that of some measurements: it changes with their name, themselves, the choices, and
    the format of fits."""
    parts = name, data_digest, freeze(arguments), fit_file.VERSION
    return hashlib.sha256("\n".join(map(str, parts)).encode()).hexdigest()[:24]


def asset_key(key_of_fit):
    """Tells whether an asset is up to date: it changes with its fit and with the version of the shader."""
    return hashlib.sha256(f"{key_of_fit}\n{SHADER_VERSION}".encode()).hexdigest()[:24]


def rebake(shaders, report=silent):
    """Write the shaders of an older version anew.

    Parameters
    ----------
    shaders : list of (source, compression, any)
        OSL source, and the percentage that its sparse lattice was compressed by.

    Returns
    -------
    list of (source or ValueError, any)
        OSL source of this version for the same fits, or why there is none.
    """
    done = []
    for number, (source, compression, passed_on) in enumerate(shaders):
        report(number / len(shaders), f"Updating {number + 1} of {len(shaders)}")
        try:
            done.append((bake(unbake(source, compression=compression)), passed_on))
        except ValueError as error:
            done.append((error, passed_on))
    return done


def finish(samples, key, found, report=silent):
    """What a material needs besides its fit: Outcome."""
    report(0.6, "Writing the shader")
    source = bake(found.fit)
    report(0.9, "Measuring its colour")
    return Outcome(samples, key, found, source, stand_in.albedo(found.fit), stand_in.principled(samples))


def fitted(samples, key, arguments, _report=silent):
    """Fit, or take the fit that was made before: Fitted. Raises ValueError."""
    whole = key, freeze(arguments)
    if whole in _fits:
        _fits.move_to_end(whole)
        return _fits[whole]
    start = time.perf_counter()
    made = fit(samples, arguments, _estimate(samples, key) if arguments.get("method") == "kriging" else None)
    found = assess(samples, made, time.perf_counter() - start)
    _fits[whole] = found
    while len(_fits) > _KEPT:
        _fits.popitem(last=False)
    return found


def _estimate(samples, key):
    """What fits by "kriging" begin with, kept for other fits of the same samples: most of the work."""
    if key not in _estimates:
        _estimates.clear()
        _estimates[key] = regression_kriging.Estimate(distinct_channels(samples)[0])
    return _estimates[key]


def fit(samples, arguments, estimated=None):
    """A fit by keyword arguments of `fitter.fit`, or by a tolerance."""
    if "tolerance" in arguments:
        return fitter.fit_within(samples, arguments["tolerance"])
    options = {} if estimated is None else {"estimated": estimated}
    return fitter.fit(samples, **arguments, **options)


def assess(samples, made, seconds):
    """A fit with its errors at the samples: Fitted."""
    return Fitted(made, fitter.error_metrics(samples.values, made.evaluate(*samples.directions)), seconds)


def held_out(samples, arguments, report=silent):
    """RMSE at samples that the fit has not seen, 1/sr; by a tolerance, with the levels that all samples ask for."""
    done = 0
    if "tolerance" in arguments:
        report(0.0, "Fitting")
        arguments = tolerance.arguments_of(fit(samples, arguments))

    def watched(part):
        nonlocal done
        report(done / cross_validation.FOLDS, "Predicting held-out samples")
        done += 1
        return fit(part, arguments)

    return cross_validation.held_out(samples, watched).rmse


def errors_by_level(data, arguments, report=silent):
    """The plot of errors at the samples against level, the choice marked: (size, size, 4) float32."""
    current = fitted(data.samples, data.digest, arguments)
    plain = current.fit.specular_level is None
    if "tolerance" in arguments:
        arguments = tolerance.arguments_of(current.fit)
    errors = []
    for level in _LEVELS:
        report(level / len(_LEVELS), "Fitting every level")
        changed = {**arguments, "diffuse_level" if plain else "specular_level": level}
        errors.append(fitted(data.samples, data.digest, changed).errors.rmse)
    level = current.fit.diffuse_level if plain else current.fit.specular_level
    return pictures.error_plot(list(_LEVELS), errors, (level, current.errors.rmse))


def lit_sphere(data, arguments, _report=silent):
    """The picture of a lit sphere: (size, size, 4) float32."""
    return pictures.lit_sphere(fitted(data.samples, data.digest, arguments).fit)


def polar_plot(data, arguments, theta_i, _report=silent):
    """The polar plot, and the incidence of the samples on it (radians)."""
    return pictures.polar_plot(fitted(data.samples, data.digest, arguments).fit, data.samples, theta_i)


def digest(samples):
    """Tells measurements from any others, wherever their file lies: 32 hexadecimal digits.

    Rounded, because the conversion of spectra differs in the last bits from one computer to another.
    """
    content = hashlib.sha256("\n".join(samples.channels).encode())
    scale = np.abs(samples.values).max() or 1.0
    for array, unit in (*((angle, 1.0) for angle in samples.directions), (samples.values, scale)):
        for start in range(0, len(array), _CHUNK):
            part = array[start:start + _CHUNK] / unit
            content.update(np.clip(np.round(1e7 * part), -_LARGEST, _LARGEST).astype("<i8").tobytes())
    return content.hexdigest()[:32]


def freeze(arguments):
    """Keyword arguments as a key."""
    return json.dumps(arguments, sort_keys=True)
