"""The work of the background processes: reading, fitting, costs and pictures. Nothing here imports bpy."""

import hashlib
import json
import math
import time
from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from ... import fitter
from ...fitter import methods, progress
from ...fitter.arrays import FloatArray, SingleArray
from ...fitter.cycles import principled
from ...fitter.cycles.bake import SHADER_VERSION, bake
from ...fitter.cycles.node_mixture import Nodes, node_mixtures
from ...fitter.formats import time_and_size
from ...fitter.imaging import pictures, plane_plot
from ...fitter.imaging.packed_picture import SIZE, pack
from ...fitter.library.ready import Ready
from ...fitter.methods import extrapolation, tolerance
from ...fitter.methods.regression_kriging import MAX_GAUSSIAN_PROCESS_SAMPLES
from ...fitter.model import fit_file
from ...fitter.model.mix import Mix
from ...fitter.quality import albedo, cross_validation, describe, physics, verdict
from ...fitter.samples import distinct_channels
from ..core import versions
from ..core.annotations import Arguments, as_text
from ..core.storage.outcomes import Data, EmbeddedFit, FitRequest, Fitted, KeptMix, Measurement, Outcome, Shown, Surface
from . import discovery, shared
from .recent import Recent

Reaching = tuple[Shown, tuple[extrapolation.MeasuredDomain, ...]]
"""A fit, and how far its measurements go, as far as that is known."""

Rebaked = tuple[str, Nodes, bytes]
"""OSL source and closure nodes of a fit, and the fit as materials keep it."""

_BITS = 22                  # of a value that a digest keeps
_HASHED_ROWS = 1 << 16      # rows hashed at a time
_FINE_LEVEL = 7             # level of a sparse lattice
_KEPT_FITS = 12             # fits in the cache, a few MB each
_LEAST = 1e-12              # of the largest value: what is smaller is what rounding left of 0
_QUICK_SAMPLES = 5000       # samples of which one more fit takes a second at most
_SMALL_FILE = 1 << 20       # bytes: smaller files are read anew whenever they are asked for
_fits: Recent[tuple[str, str], Fitted] = Recent(_KEPT_FITS)
# of the last samples: those of a large file, by what was asked and the file's stamp; preparations
_loaded: Recent[tuple[tuple[str, str, str], tuple[int, int]], tuple[fitter.Samples, Measurement]] = Recent(1)
_preparations: Recent[tuple[str, str], Arguments] = Recent(1)


def read(path: str, sample: str | None, how: Arguments | None = None) -> Data:
    """Read and describe measurements; `how` are keyword arguments of `fitter.load`. Raises DatasetError."""
    progress.report(0.0, "Reading")
    samples, measured = _load(path, sample, how)
    return Data(measured, _describe(samples))


@lru_cache(maxsize=1)
def _describe(samples: fitter.Samples) -> describe.Description:
    return describe.describe(samples)


def found_again(wanted: Sequence[tuple[str, str, Arguments, str]], folder: str) -> list[str]:
    """The paths of files in a folder, or below it, that have the names of missing files, and among several the digest
    of their measurements, as they were read; empty where there is none."""
    progress.report(0.0, "Searching")
    there: dict[str, list[str]] = {Path(path).name: [] for path, *_ in wanted}
    for entry in discovery.files_below(folder):
        if entry.name in there:
            there[entry.name].append(entry.path)
    answers = []
    for number, (path, sample, how, key) in enumerate(wanted):
        progress.report(number / len(wanted), f"Comparing {Path(path).name}")
        paths = there[Path(path).name]
        same = (each for each in paths if len(paths) > 1 and _has_digest(each, sample, how, key))
        answers.append(next(same, paths[0] if paths else ""))
    return answers


def _has_digest(path: str, sample: str, how: Arguments, key: str) -> bool:
    try:
        return _load(path, sample, how)[1].digest == key
    except ValueError:
        return False


def _load(path: str, sample: str | None, how: Arguments | None) -> tuple[fitter.Samples, Measurement]:
    """Read measurements; a large file only if it has changed since it was read last."""
    asked = path, sample or "", as_text(how or {})
    stamp = _stamp(path)
    if stamp is not None and (asked, stamp) in _loaded:
        return _loaded[asked, stamp]
    samples = fitter.load(path, sample or None, **(how or {}))
    loaded = samples, Measurement(*asked, samples.name, samples.channels, samples.colours, digest(samples))
    if stamp is not None:
        _loaded[asked, stamp] = loaded
    return loaded


def load_samples(data: Data) -> fitter.Samples:
    """The samples of measurements. Raises DatasetError if they cannot be read any more, or are others."""
    measured = data.measured
    samples, now = _load(measured.path, measured.sample, json.loads(measured.how))
    if now.digest != measured.digest:
        raise fitter.DatasetError("has changed while it was used; try again", measured.path)
    return samples


def _stamp(path: str) -> tuple[int, int] | None:
    """Tells whether a large file has changed; None for others."""
    stamp = time_and_size(path)
    return stamp if stamp is not None and stamp[1] > _SMALL_FILE else None


def outcome(path: str, sample: str | None, arguments: Arguments,
            how: Arguments | None = None, edit: Arguments | None = None, ask: bool = False) -> Outcome:
    """Read measurements, fit them, and bake the shader's source.

    `arguments` are of `fitter.fit`, `how` of `fitter.load`, `edit` of `fitter.edited`. Raises ValueError if anything
    is invalid; with `ask`, where users can be asked, ImplausibleError if no surface has such values.
    """
    progress.report(0.0, "Reading")
    samples, measured = _load(path, sample, how)
    if ask and (doubt := albedo.implausibility_message(samples)):
        raise fitter.ImplausibleError(f"{doubt} Choose what the numbers are, or import them as they are", path)
    share = _share_of_fit(samples, arguments)
    with progress.part(0.0, share, "Fitting"):
        made = fit_once(samples, measured.digest, arguments)
    with progress.part(share, 1.0):
        return _finish(samples, measured, made, fitter.edited(made.fit, **(edit or {})), edit or {})


def ready_outcome(made: Ready, path: str, how: Arguments | None = None) -> Outcome:
    """What a material is made from, of a fit that was made beforehand, and where its measurements are."""
    samples, measured = _load(path, None, how)
    fitting = assess(samples, made.fit, 0.0)
    return Outcome(measured, fitting, verdict.judge(samples, made.fit, fitting.unseen),
                   _assemble_surface(made, measured.colours, {}))


def outcome_alone(made: fitter.Fit, space: str) -> Outcome:
    """What a material is made from, of a fit whose measurements are in no file; its errors are not known."""
    measured = Measurement("", "", as_text({}), made.name, made.channels, space, "")
    errors = fitter.ErrorMetrics(math.nan, math.nan, math.nan)
    return Outcome(measured, Fitted(made, errors, 0.0), verdict.Verdict(verdict.UNKNOWN, verdict.UNKNOWN, 0.0, 0.0),
                   _surface(made, space, {}))


def outcomes(sources: Sequence[tuple[str, str]], arguments: Arguments,
             how: Arguments | None = None, ask: bool = False) -> list[tuple[str, str, Outcome | ValueError]]:
    """Outcomes of several measurements, (path, sample) each, as of `outcome`; for those that failed, the error."""
    done: list[tuple[str, str, Outcome | ValueError]] = []
    for number, (path, sample) in enumerate(sources):
        about = f"{sample or Path(path).name}: " if len(sources) > 1 else ""
        try:
            with progress.part(number / len(sources), (number + 1) / len(sources), about=about):
                done.append((path, sample, outcome(path, sample, arguments, how=how, ask=ask)))
        except ValueError as error:
            done.append((path, sample, error))
    return done


def _share_of_fit(samples: fitter.Samples, arguments: Arguments) -> float:
    """The share of an outcome's time that its fit takes, as measured: the rest takes as long for every fit."""
    if arguments.get("method") == "mba":
        return 0.1
    fine = 0.2 * _is_fine(arguments)
    if not samples.isotropic or len(samples) > MAX_GAUSSIAN_PROCESS_SAMPLES:
        return 0.7 + fine / 2
    return 0.7 if "tolerance" in arguments else 0.35 + 0.3 * len(samples) / MAX_GAUSSIAN_PROCESS_SAMPLES + fine


def _is_fine(arguments: Arguments) -> bool:
    """Whether the sparse lattice is so fine that it takes most of the time."""
    return (arguments.get("specular_level") or 0) >= _FINE_LEVEL


def asset(path: str, sample: str | None, arguments: Arguments, folder: str,
          how: Arguments | None = None, edit: Arguments | None = None) -> tuple[Outcome, SingleArray]:
    """An outcome and a thumbnail. The fit is saved in a folder, as measured, and loaded from there the next time."""
    samples, measured = _load(path, sample, how)
    keep = Path(folder) / f"{fit_key(samples.name, measured.digest, arguments)}.npz"
    if keep.is_file():
        fitting = assess(samples, fitter.Fit.load(keep), 0.0)
    else:
        fitting = fit_once(samples, measured.digest, arguments)
        keep.parent.mkdir(parents=True, exist_ok=True)
        fitting.fit.save(keep)
    made = fitter.edited(fitting.fit, **(edit or {}))
    return (_finish(samples, measured, fitting, made, edit or {}),
            pictures.lit_sphere(made, colours=samples.colours))


def fit_key(name: str, data_digest: str, arguments: Arguments) -> str:
    """Identifies a saved fit, also by the file format, and by the extension, whose versions may fit differently."""
    parts: tuple[Any, ...] = name, data_digest, as_text(arguments), fit_file.VERSION, versions.CURRENT
    return hashlib.sha256("\n".join(map(str, parts)).encode()).hexdigest()[:24]


def asset_key(key_of_fit: str, rendering: str) -> str:
    """Identifies an up-to-date asset: its fit and the version of the shader; and, in clear, the rendering asked for."""
    return f"{hashlib.sha256(f'{key_of_fit} {SHADER_VERSION}'.encode()).hexdigest()[:24]} {rendering}"


def rebake(fits: Sequence[EmbeddedFit]) -> list[Rebaked | ValueError]:
    """The shaders of this version for fits of materials; for those that have been damaged, the error."""
    done: list[Rebaked | ValueError] = []
    for number, kept in enumerate(fits):
        progress.report(number / len(fits), f"Updating {number + 1} of {len(fits)}")
        try:
            fit = kept_fit(kept)
            nodes = node_mixtures(fit)
            done.append((bake(fit, mixture=nodes.cycles), nodes, kept_bytes(fit)))
        except ValueError as error:
            done.append(error)
    return done


def _finish(samples: fitter.Samples, measured: Measurement, fitting: Fitted, made: fitter.Fit,
            edit: Arguments) -> Outcome:
    return Outcome(measured, fitting, verdict.judge(samples, fitting.fit, fitting.unseen),
                   _surface(made, measured.colours, edit), describe.open_questions(samples))


def edit_surface(kept: EmbeddedFit, edit: Arguments) -> Surface:
    """Edit the fit of a material anew. Raises ValueError if there is none, or an argument is wrong."""
    progress.report(0.0, "Editing")
    return _surface(fitter.edited(kept_fit(kept), **edit), kept.colours, edit)


def _surface(fit: fitter.Fit, space: str, edit: Arguments) -> Surface:
    with progress.part(0.0, 0.75, "Matching nodes"):
        nodes = node_mixtures(fit)
    progress.report(0.75, "Matching the viewport colour")
    made = Ready(fit, nodes, principled.principled(fit))
    progress.report(0.85, "Writing the shader")
    return _assemble_surface(made, space, edit)


def _assemble_surface(made: Ready, space: str, edit: Arguments) -> Surface:
    fit, nodes = made.fit, made.nodes
    return Surface(space, kept_bytes(fit), bake(fit, mixture=nodes.cycles), nodes, principled.albedo(fit),
                   made.principled, pack(pictures.lit_sphere(fit, SIZE, colours=space)), edit)


def fit_once(samples: fitter.Samples, key: str, arguments: Arguments) -> Fitted:
    """Fit samples with this digest, unless a worker has done it before. Raises ValueError."""
    whole = key, as_text(arguments)
    if whole not in _fits:
        _fits[whole] = shared.once(f"fit {whole}", lambda: _fit_and_judge(samples, key, arguments))
    return _fits[whole]


def _fit_and_judge(samples: fitter.Samples, key: str, arguments: Arguments) -> Fitted:
    start = time.perf_counter()
    share = 0.2 if _is_fine(arguments) else 0.5
    with progress.part(0.0, share):
        prepared = _prepare_fit(samples, key, arguments)
    with progress.part(share if prepared else 0.0, 0.95):
        made = fit(samples, arguments, prepared)
    fitting = assess(samples, made, time.perf_counter() - start)
    with progress.part(0.95, 1.0):
        return fitting._replace(unseen=_unseen_error(samples, fitting, arguments, prepared))


def _unseen_error(samples: fitter.Samples, fitting: Fitted, arguments: Arguments, prepared: Arguments) -> float:
    """`verdict.lightness_error` at unseen samples, where that takes no longer than the fit; else UNKNOWN."""
    if samples.subsurface is not None:          # computed, and known everywhere
        return verdict.UNKNOWN
    # kriging predicts each sample from the others in passing; a fit that does not follow its samples does no better
    if "estimated" in prepared:
        columns = distinct_channels(samples)[1]
        left_out = prepared["estimated"].left_out
        if left_out is None:
            return verdict.UNKNOWN
        return math.hypot(verdict.lightness_error(samples, left_out[:, columns]),
                          verdict.lightness_error(samples, fitting.fit.evaluate(*samples.directions)))
    if len(samples) > _QUICK_SAMPLES:
        return verdict.UNKNOWN
    if "tolerance" in arguments:
        arguments = tolerance.fit_arguments(fitting.fit)
    return verdict.unseen_error(samples, lambda part: fit(part, arguments))


def _prepare_fit(samples: fitter.Samples, key: str, arguments: Arguments) -> Arguments:
    """The part of a fit that does not depend on its levels, cached for other fits of the same samples."""
    if "method" not in arguments:
        return {}
    known = key, arguments["method"]
    if known not in _preparations:
        _preparations.clear()       # it may be large
        _preparations[known] = shared.once(f"preparation {known}",
                                           lambda: methods.prepare(samples, arguments["method"]))
    return _preparations[known]


def fit(samples: fitter.Samples, arguments: Arguments, prepared: Arguments | None = None) -> fitter.Fit:
    """A fit by keyword arguments of `fitter.fit`, or by a tolerance."""
    if "tolerance" in arguments:
        return fitter.fit_within(samples, arguments["tolerance"])
    return fitter.fit(samples, **arguments, **(prepared or {}))


def assess(samples: fitter.Samples, made: fitter.Fit, seconds: float) -> Fitted:
    return Fitted(made, fitter.error_metrics(samples.values, made.evaluate(*samples.directions)), seconds)


def fit_data(data: Data, arguments: Arguments) -> Fitted:
    return fit_once(load_samples(data), data.digest, arguments)


def held_out(data: Data, arguments: Arguments) -> float:
    """RMSE at held-out samples, 1/sr. A tolerance gives the levels from all samples."""
    samples, folds = load_samples(data), iter(range(cross_validation.FOLD_COUNT))
    if "tolerance" in arguments:
        progress.report(0.0, "Fitting")
        arguments = tolerance.fit_arguments(fit_once(samples, data.digest, arguments).fit)

    def reported_fit(part: fitter.Samples) -> fitter.Fit:
        fold = next(folds)
        begin, end = fold / cross_validation.FOLD_COUNT, (fold + 1) / cross_validation.FOLD_COUNT
        with progress.part(begin, end, "Testing at unseen angles"):
            return fit(part, arguments)

    return cross_validation.cross_validate(samples, reported_fit).rmse


def lit_sphere(shown: Shown, edit: Arguments | None) -> SingleArray:
    """A lit sphere of a fit as it is edited, with the tangent of an anisotropic one: (size, size, 4); of a mix by a
    mask the half of each. Raises ValueError if there is no fit, or an argument is wrong."""
    if isinstance(shown, KeptMix) and shown.share is None:
        return pictures.split(lit_sphere(shown.first, None), lit_sphere(shown.second, None))
    made = shown_reflectance(shown)
    if edit is not None and isinstance(made, fitter.Fit):
        made = fitter.edited(made, **edit)
    return pictures.lit_sphere(made, colours=shown.colours, with_tangent=True)


def polar_plot(fits: Sequence[Reaching], data: Data | None, theta_i: float,
               phi_i: float = 0.0) -> tuple[SingleArray, float]:
    """As `plane_plot.polar_plot`, of one fit or two. Raises ValueError if there is no fit."""
    progress.report(0.0, "Drawing")
    plotted = [plane_plot.Plotted(shown_reflectance(shown), shown.colours, reaches) for shown, reaches in fits]
    return plane_plot.polar_plot(plotted, None if data is None else load_samples(data), theta_i, phi_i=phi_i)


def turned_plane(shown: Shown, theta_i: float) -> SingleArray:
    """The picture of the plane of incidence as it turns about the normal: (size, size, 4)."""
    return plane_plot.turned_plane(shown_reflectance(shown), theta_i, colours=shown.colours)


def normal_albedo(kept: EmbeddedFit | KeptMix) -> FloatArray:
    """The albedo of a fit for light along the normal, (3,), linear. Raises ValueError if there is no fit."""
    progress.report(0.0, "Albedo")
    return np.broadcast_to(physics.directional_albedo(shown_reflectance(kept), [0.0])[0], 3).copy()


def samples_near_plane(data: Data, theta_i: float, phi_i: float = 0.0) -> tuple[FloatArray, FloatArray, float]:
    return plane_plot.samples_near_plane(load_samples(data), theta_i, phi_i)


@lru_cache(maxsize=_KEPT_FITS)
def kept_fit(kept: EmbeddedFit) -> fitter.Fit:
    """The fit of a material. Raises ValueError if there is none."""
    return replace(fitter.Fit.from_bytes(kept.fit), name=kept.name)


def kept_bytes(fit: fitter.Fit) -> bytes:
    """A fit as materials keep it: without the names of its measurements and of their file, which materials know."""
    return replace(fit, name="", source="").to_bytes()


def shown_reflectance(shown: Shown) -> fitter.Fit | Mix:
    """The reflectance that is shown. Raises ValueError if there is none."""
    if isinstance(shown, FitRequest):
        return fit_data(*shown).fit
    if isinstance(shown, EmbeddedFit):
        return kept_fit(shown)
    return Mix(shown_reflectance(shown.first), shown_reflectance(shown.second),
               0.5 if shown.share is None else shown.share)


def digest(samples: fitter.Samples) -> str:
    """Identifies measurements by all that a fit depends on: 32 hexadecimal digits.

    Numbers are rounded, because the conversion of spectra differs in the last bits between computers: angles to 1e-7
    radians, values to `_BITS` binary digits.
    """
    header = *samples.channels, samples.colours, "isotropic" if samples.isotropic else "anisotropic"
    if samples.subsurface is not None:
        header += tuple(f"{name} {each:.12e}" for name, values in vars(samples.subsurface).items()
                        for each in np.ravel(values))
    content = hashlib.sha256("\n".join(header).encode())
    for angle in samples.directions:
        for start in range(0, len(angle), _HASHED_ROWS):
            content.update(np.round(1e7 * angle[start:start + _HASHED_ROWS]).astype("<i8").tobytes())
    for array in (samples.values, *([] if samples.deviation is None else [samples.deviation])):
        least = _LEAST * np.abs(array).max()
        for start in range(0, len(array), _HASHED_ROWS):
            part = array[start:start + _HASHED_ROWS]
            mantissa, exponent = np.frexp(np.where(np.abs(part) > least, part, 0.0))
            # again, because what lies just below a power of two is rounded to it
            mantissa, exponent = np.frexp(np.ldexp(np.round(np.ldexp(mantissa, _BITS)), exponent - _BITS))
            content.update(np.ldexp(mantissa, _BITS).astype("<i4").tobytes())
            content.update(exponent.astype("<i2").tobytes())
    return content.hexdigest()[:32]
