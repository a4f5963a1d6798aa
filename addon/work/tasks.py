"""The work of the background processes: reading, fitting, costs and pictures. Nothing here imports bpy.

Every function takes `report(fraction, doing)`, and calls it with its progress.
"""

import hashlib
import json
import math
import os
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from ... import fitter
from ...fitter import colours, methods, pictures, progress, tolerance
from ...fitter.arrays import FloatArray, SingleArray
from ...fitter.cycles import principled
from ...fitter.cycles.bake import SHADER_VERSION, bake
from ...fitter.cycles.node_mixture import Nodes, node_mixtures
from ...fitter.cycles.unbake import unbake
from ...fitter.methods.regression_kriging import MOST_SAMPLES
from ...fitter.model import fit_file
from ...fitter.model.mix import Mix
from ...fitter.packed_picture import SIZE, packed
from ...fitter.quality import cross_validation, describe, verdict
from ...fitter.ready import Ready
from ...fitter.samples import distinct_channels
from ..core.annotations import Arguments, Report
from ..core.outcomes import Data, Fitted, Kept, KeptMix, Measured, Outcome, Surface
from . import discovery, shared
from .recent import Recent

_PassedOn = TypeVar("_PassedOn")

Rebaked = tuple[str, Nodes, bytes]
"""OSL source and closure nodes of a fit, and the fit as materials keep it."""

_LEVELS = range(8)          # in the plot of errors; level 8 would take longer than all others together
# likewise of anisotropic samples: of a sparse lattice, and of a dense one alone. Level 0 is fitted as level 1 or close
# to it, and a finer lattice of four axes takes minutes or is more than a shader holds
_SPARSE_OF_FOUR_AXES, _DENSE_OF_FOUR_AXES = range(1, 7), range(1, 5)
_CHUNK = 1 << 16            # rows hashed at a time
_FINE = 7                   # level of a sparse lattice
_KEPT = 12                  # fits in the cache, a few MB each
_LARGEST = 2.0 ** 62        # integer of a digest: a file may hold an azimuth of 1e300
_QUICK = 5000               # samples of which one more fit takes a second at most
_SMALL = 1 << 20            # bytes: smaller files are read anew whenever they are asked for
_fits: Recent[tuple[str, str], Fitted] = Recent(_KEPT)
_kept_fits: Recent[str, fitter.Fit] = Recent(_KEPT)
# of the last samples: those of a large file, by what was asked and the file's stamp; their description; preparations
_loaded: Recent[tuple[tuple[str, str, str], tuple[int, int]], tuple[fitter.Samples, Measured]] = Recent(1)
_described: Recent[Measured, Data] = Recent(1)
_preparations: Recent[tuple[str, str], Arguments] = Recent(1)


def silent(_fraction: float, _doing: str) -> None:
    """A `report` that does nothing."""


def read(path: str, sample: str | None, report: Report = silent, how: Arguments | None = None) -> Data:
    """Read and describe measurements; `how` are keyword arguments of `fitter.load`. Raises DatasetError."""
    report(0.0, "Reading")
    samples, measured = _load(path, sample, how)
    if measured in _described and _stamp(path) is not None:
        return _described[measured]
    found = Data(measured, describe.describe(samples))
    _described[measured] = found
    return found


def found_again(wanted: Sequence[tuple[str, str, Arguments, str]], folder: str, report: Report = silent) -> list[str]:
    """Files in a folder, or below it, that have the names of files that are missing.

    Parameters
    ----------
    wanted : list of (path, sample, how, digest)
        How a missing file was read, and the digest of its measurements: of files of one name, that which has it.

    Returns
    -------
    list of str
        Their paths; empty where there is none.
    """
    report(0.0, "Searching")
    there: dict[str, list[str]] = {Path(path).name: [] for path, *_ in wanted}
    for entry in discovery.files_below(folder):
        if entry.name in there:
            there[entry.name].append(entry.path)
    found = []
    for number, (path, sample, how, key) in enumerate(wanted):
        report(number / len(wanted), f"Comparing {Path(path).name}")
        paths = there[Path(path).name]
        same = (each for each in paths if len(paths) > 1 and _has_digest(each, sample, how, key))
        found.append(next(same, paths[0] if paths else ""))
    return found


def _has_digest(path: str, sample: str, how: Arguments, key: str) -> bool:
    try:
        return _load(path, sample, how)[1].digest == key
    except ValueError:
        return False


def _load(path: str, sample: str | None, how: Arguments | None) -> tuple[fitter.Samples, Measured]:
    """Read measurements; a large file only if it has changed since it was read last."""
    asked = path, sample or "", freeze(how or {})
    stamp = _stamp(path)
    if stamp is not None and (asked, stamp) in _loaded:
        return _loaded[asked, stamp]
    samples = fitter.load(path, sample or None, **(how or {}))
    found = samples, Measured(*asked, samples.name, samples.channels, samples.colours, digest(samples))
    if stamp is not None:
        _loaded[asked, stamp] = found
    return found


def samples_of(data: Data) -> fitter.Samples:
    """The samples of measurements. Raises DatasetError if they cannot be read any more, or are others."""
    measured = data.measured
    samples, now = _load(measured.path, measured.sample, json.loads(measured.how))
    if now.digest != measured.digest:
        raise fitter.DatasetError("has changed while it was used; try again", measured.path)
    return samples


def _stamp(path: str) -> tuple[int, int] | None:
    """Tells whether a large file has changed; None for others, which may be read together with files beside them."""
    try:
        found = os.stat(path)
    except (OSError, ValueError):
        return None
    return (found.st_mtime_ns, found.st_size) if found.st_size > _SMALL else None


def outcome(path: str, sample: str | None, arguments: Arguments, report: Report = silent,
            known: tuple[str, Fitted] | None = None, how: Arguments | None = None,
            edit: Arguments | None = None) -> Outcome:
    """Read measurements, fit them, and bake the shader's source.

    Parameters
    ----------
    path, sample
        The measurements.
    arguments
        Of the fit.
    known : (str, Fitted), optional
        The fit, if it has been made before, with the digest of its measurements.
    how : dict, optional
        Of reading: keyword arguments of `fitter.load`.
    edit : dict, optional
        Keyword arguments of `fitter.edited`.

    Returns
    -------
    Outcome

    Raises
    ------
    DatasetError, ValueError
        If the measurements or the arguments are invalid.
    """
    report(0.0, "Reading")
    samples, measured = _load(path, sample, how)
    key = measured.digest
    is_known = known is not None and known[0] == key
    share = 0.0 if is_known else _share_of_fit(samples, arguments)
    with progress.part(0.0, share, "Fitting"):
        found = known[1] if known is not None and is_known else fitted(samples, key, arguments)
    with progress.part(share, 1.0):
        return _finish(samples, measured, found, fitter.edited(found.fit, **(edit or {})), edit or {}, report)


def outcome_of(made: Ready, path: str, how: Arguments | None = None) -> Outcome:
    """What a material is made from, of a fit that was made beforehand, and where its measurements are."""
    samples, measured = _load(path, None, how)
    return Outcome(measured, found := assess(samples, made.fit, 0.0), verdict.of(samples, made.fit, found.unseen),
                   _assembled(made, measured.colours, {}))


def outcomes(sources: Sequence[tuple[str, str]], arguments: Arguments, report: Report = silent,
             how: Arguments | None = None) -> list[tuple[str, str, Outcome | ValueError]]:
    """Outcomes of several measurements; for those that failed, the error.

    Parameters
    ----------
    sources : list of (path, sample)
    arguments, how : dict
        As `outcome` takes them.

    Returns
    -------
    list of (path, sample, Outcome or ValueError)
    """
    done: list[tuple[str, str, Outcome | ValueError]] = []
    for number, (path, sample) in enumerate(sources):
        about = f"{sample or Path(path).name}: " if len(sources) > 1 else ""
        try:
            with progress.part(number / len(sources), (number + 1) / len(sources), about=about):
                done.append((path, sample, outcome(path, sample, arguments, report, how=how)))
        except ValueError as error:
            done.append((path, sample, error))
    return done


def _share_of_fit(samples: fitter.Samples, arguments: Arguments) -> float:
    """The share of an outcome's time that its fit takes, as measured: the rest takes as long for every fit."""
    if arguments.get("method") == "mba":
        return 0.1
    fine = 0.2 * _is_fine(arguments)
    if not samples.isotropic or len(samples) > MOST_SAMPLES:
        return 0.7 + fine / 2
    return 0.7 if "tolerance" in arguments else 0.35 + 0.3 * len(samples) / MOST_SAMPLES + fine


def _is_fine(arguments: Arguments) -> bool:
    """Whether the sparse lattice is so fine that it takes most of the time."""
    return (arguments.get("specular_level") or 0) >= _FINE


def asset(path: str, sample: str | None, arguments: Arguments, folder: str, report: Report = silent,
          how: Arguments | None = None, edit: Arguments | None = None) -> tuple[Outcome, SingleArray]:
    """An outcome and a thumbnail. The fit is saved in a folder, as measured, and loaded from there the next time."""
    samples, measured = _load(path, sample, how)
    keep = Path(folder) / f"{fit_key(samples.name, measured.digest, arguments)}.npz"
    if keep.is_file():
        found = assess(samples, fitter.Fit.load(keep), 0.0)
    else:
        found = fitted(samples, measured.digest, arguments)
        keep.parent.mkdir(parents=True, exist_ok=True)
        found.fit.save(keep)
    made = fitter.edited(found.fit, **(edit or {}))
    return (_finish(samples, measured, found, made, edit or {}, report),
            pictures.lit_sphere(made, colours=samples.colours))


def fit_key(name: str, data_digest: str, arguments: Arguments) -> str:
    """Identifies a saved fit: by the name and digest of its measurements, its arguments, and the file format."""
    parts: tuple[Any, ...] = name, data_digest, freeze(arguments), fit_file.VERSION
    return hashlib.sha256("\n".join(map(str, parts)).encode()).hexdigest()[:24]


def asset_key(key_of_fit: str) -> str:
    """Identifies an up-to-date asset: by its fit and the version of the shader."""
    return hashlib.sha256(f"{key_of_fit}\n{SHADER_VERSION}".encode()).hexdigest()[:24]


def rebake(fits: Sequence[tuple[Kept, _PassedOn]],
           report: Report = silent) -> list[tuple[Rebaked | ValueError, _PassedOn]]:
    """Make the shaders of this version for fits of materials.

    Parameters
    ----------
    fits : list of (Kept, any)
        Each with anything to return with it.

    Returns
    -------
    list of (Rebaked or ValueError, any)
        What this version makes of the same fit, or the error.
    """
    done: list[tuple[Rebaked | ValueError, _PassedOn]] = []
    for number, (kept, passed_on) in enumerate(fits):
        report(number / len(fits), f"Updating {number + 1} of {len(fits)}")
        try:
            fit = kept_fit(kept)
            nodes = node_mixtures(fit)
            done.append(((bake(fit, mixture=nodes.cycles), nodes, kept_bytes(fit)), passed_on))
        except ValueError as error:
            done.append((error, passed_on))
    return done


def _finish(samples: fitter.Samples, measured: Measured, found: Fitted, made: fitter.Fit, edit: Arguments,
            report: Report) -> Outcome:
    """Add to a fit what else a material needs; `made` is the fit as `edit` has changed it."""
    return Outcome(measured, found, verdict.of(samples, found.fit, found.unseen),
                   _surface(made, measured.colours, edit, report))


def adjusted(kept: Kept, edit: Arguments, report: Report = silent) -> Surface:
    """Edit the fit of a material anew. Raises ValueError if there is none, or an argument is wrong."""
    report(0.0, "Editing")
    return _surface(fitter.edited(kept_fit(kept), **edit), kept.colours, edit, report)


def _surface(fit: fitter.Fit, space: str, edit: Arguments, report: Report) -> Surface:
    """What a material shows of a fit that `edit` has made."""
    with progress.part(0.0, 0.75, "Matching closures"):
        nodes = node_mixtures(fit)
    report(0.75, "Matching the viewport colour")
    made = Ready(fit, nodes, principled.principled(fit))
    report(0.85, "Writing the shader")
    return _assembled(made, space, edit)


def _assembled(made: Ready, space: str, edit: Arguments) -> Surface:
    fit, nodes = made.fit, made.nodes
    return Surface(space, kept_bytes(fit), bake(fit, mixture=nodes.cycles), nodes, principled.albedo(fit),
                   made.principled, packed(pictures.lit_sphere(fit, SIZE, colours=space)), edit)


def fitted(samples: fitter.Samples, key: str, arguments: Arguments, _report: Report = silent) -> Fitted:
    """Fit samples with this digest, unless a worker has done it before. Raises ValueError."""
    whole = key, freeze(arguments)
    if whole not in _fits:
        _fits[whole] = shared.once(f"fit {whole}", lambda: _fitted(samples, key, arguments))
    return _fits[whole]


def _fitted(samples: fitter.Samples, key: str, arguments: Arguments) -> Fitted:
    start = time.perf_counter()
    share = 0.2 if _is_fine(arguments) else 0.5
    with progress.part(0.0, share):
        prepared = _prepared(samples, key, arguments)
    with progress.part(share if prepared else 0.0, 0.95):
        made = fit(samples, arguments, prepared)
    found = assess(samples, made, time.perf_counter() - start)
    with progress.part(0.95, 1.0):
        return found._replace(unseen=_unseen(samples, found, arguments, prepared))


def _unseen(samples: fitter.Samples, found: Fitted, arguments: Arguments, prepared: Arguments) -> float:
    """`verdict.steps` at samples that the fit had not seen, where that takes no longer than the fit; else UNKNOWN.

    Kriging predicts each sample from the others in passing; a fit that does not follow its samples does no better.
    """
    if "estimated" in prepared:
        columns = distinct_channels(samples)[1]
        left_out = prepared["estimated"].left_out
        if left_out is None:
            return verdict.UNKNOWN
        return math.hypot(verdict.steps(samples, left_out[:, columns]),
                          verdict.steps(samples, found.fit.evaluate(*samples.directions)))
    if len(samples) > _QUICK:
        return verdict.UNKNOWN
    if "tolerance" in arguments:
        arguments = tolerance.arguments_of(found.fit)
    return verdict.unseen(samples, lambda part: fit(part, arguments))


def _prepared(samples: fitter.Samples, key: str, arguments: Arguments) -> Arguments:
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
    """A fit with its errors at the samples."""
    return Fitted(made, fitter.error_metrics(samples.values, made.evaluate(*samples.directions)), seconds)


def fitted_of(data: Data, arguments: Arguments, _report: Report = silent) -> Fitted:
    """As `fitted`."""
    return fitted(samples_of(data), data.digest, arguments)


def held_out_of(data: Data, arguments: Arguments, report: Report = silent) -> float:
    """As `held_out`."""
    return held_out(samples_of(data), arguments, report)


def held_out(samples: fitter.Samples, arguments: Arguments, report: Report = silent) -> float:
    """RMSE at held-out samples, 1/sr. A tolerance gives the levels from all samples."""
    folds = iter(range(cross_validation.FOLDS))
    if "tolerance" in arguments:
        report(0.0, "Fitting")
        arguments = tolerance.arguments_of(fitted(samples, digest(samples), arguments).fit)

    def reported_fit(part: fitter.Samples) -> fitter.Fit:
        fold = next(folds)
        begin, end = fold / cross_validation.FOLDS, (fold + 1) / cross_validation.FOLDS
        with progress.part(begin, end, "Testing at unseen angles"):
            return fit(part, arguments)

    return cross_validation.held_out(samples, reported_fit).rmse


def errors_by_level(data: Data, arguments: Arguments, report: Report = silent) -> SingleArray:
    """The plot of RMSE at the samples against level, with the present choice marked: (size, size, 4).

    Levels are those of the settings: an anisotropic fit of the same settings may have lower ones.
    """
    samples = samples_of(data)
    current = fitted(samples, data.digest, arguments)
    if "tolerance" in arguments:
        arguments = tolerance.arguments_of(current.fit)
    varied = "diffuse_level" if arguments["specular_level"] is None else "specular_level"
    chosen, levels = arguments[varied], _levels(samples, varied)
    errors, first = {chosen: current.errors.rmse}, {_levels_of(current.fit): chosen}
    for number, level in enumerate(levels):
        with progress.part(number / len(levels), (number + 1) / len(levels), "Fitting every level"):
            found = fitted(samples, data.digest, {**arguments, varied: level})
        if samples.isotropic or first.setdefault(_levels_of(found.fit), level) == level:
            errors[level] = found.errors.rmse
    shown = list(levels) if samples.isotropic else sorted(errors)
    return pictures.error_plot(shown, [errors[level] for level in shown], (chosen, current.errors.rmse))


def _levels(samples: fitter.Samples, varied: str) -> range:
    """The levels that the plot of errors shows."""
    if samples.isotropic:
        return _LEVELS
    return _DENSE_OF_FOUR_AXES if varied == "diffuse_level" else _SPARSE_OF_FOUR_AXES


def _levels_of(found: fitter.Fit) -> tuple[int, int | None]:
    return found.diffuse_level, found.specular_level


def lit_sphere(data: Data, arguments: Arguments, _report: Report = silent) -> SingleArray:
    """The picture of a lit sphere, with the tangent of an anisotropic fit: (size, size, 4)."""
    return pictures.lit_sphere(fitted_of(data, arguments).fit, colours=data.measured.colours, with_tangent=True)


def polar_plot(data: Data, arguments: Arguments, theta_i: float, phi_i: float = 0.0,
               _report: Report = silent) -> tuple[SingleArray, float]:
    """The polar plot, and the angle of incidence of the samples in it (radians)."""
    return pictures.polar_plot(fitted_of(data, arguments).fit, samples_of(data), theta_i, phi_i=phi_i)


def turned_plane(data: Data, arguments: Arguments, theta_i: float, _report: Report = silent) -> SingleArray:
    """The picture of the plane of incidence as it turns about the normal: (size, size, 4)."""
    return pictures.turned_plane(fitted_of(data, arguments).fit, theta_i, colours=data.measured.colours)


def near_plane(data: Data, theta_i: float, phi_i: float = 0.0,
               _report: Report = silent) -> tuple[FloatArray, FloatArray, float]:
    """As `pictures.near_plane`."""
    return pictures.near_plane(samples_of(data), theta_i, phi_i)


def kept_fit(kept: Kept, _report: Report = silent) -> fitter.Fit:
    """The fit of a material. Raises ValueError if there is none."""
    key = kept.digest
    if key not in _kept_fits:
        _kept_fits[key] = (replace(fitter.Fit.from_bytes(kept.fit), name=kept.name) if kept.fit else
                           unbake(kept.source, kept.name, kept.compression))
    return _kept_fits[key]


def kept_bytes(fit: fitter.Fit) -> bytes:
    """A fit as materials keep it: without the names of its measurements and of their file, which materials know."""
    return replace(fit, name="", source="").to_bytes()


def kept_sphere(kept: Kept | KeptMix, _report: Report = silent) -> SingleArray:
    """As `lit_sphere`, of the fit of a material; of a mix by a mask, the half of each."""
    if isinstance(kept, KeptMix) and kept.share is None:
        return pictures.split(kept_sphere(kept.first), kept_sphere(kept.second))
    return pictures.lit_sphere(_reflectance(kept), colours=_colours(kept), with_tangent=True)


def adjusted_sphere(kept: Kept, edit: Arguments, _report: Report = silent) -> SingleArray:
    """As `kept_sphere`, as `adjusted` would edit the fit. Raises ValueError if an argument is wrong."""
    return pictures.lit_sphere(fitter.edited(kept_fit(kept), **edit), colours=kept.colours, with_tangent=True)


def _reflectance(kept: Kept | KeptMix) -> fitter.Fit | Mix:
    if isinstance(kept, Kept):
        return kept_fit(kept)
    return Mix(_reflectance(kept.first), _reflectance(kept.second), 0.5 if kept.share is None else kept.share)


def _colours(kept: Kept | KeptMix) -> str:
    return kept.colours if isinstance(kept, Kept) else _colours(kept.first)


def kept_polar(kept: Kept, data: Data | None, theta_i: float, phi_i: float = 0.0,
               _report: Report = silent) -> tuple[SingleArray, float]:
    """As `polar_plot`, of the fit of a material; without measurements it has no samples, and their angle is nan."""
    samples = None if data is None else samples_of(data)
    return pictures.polar_plot(kept_fit(kept), samples, theta_i, phi_i=phi_i)


def kept_turned(kept: Kept, theta_i: float, _report: Report = silent) -> SingleArray:
    """As `turned_plane`, of the fit of a material."""
    return pictures.turned_plane(kept_fit(kept), theta_i, colours=kept.colours)


def digest(samples: fitter.Samples) -> str:
    """Identifies measurements by their content: 32 hexadecimal digits.

    Values are rounded, because the conversion of spectra differs in the last bits between computers.
    """
    space = () if samples.colours == colours.DEFAULT else (samples.colours,)
    kind = () if samples.isotropic else ("anisotropic",)
    content = hashlib.sha256("\n".join((*samples.channels, *space, *kind)).encode())
    scale = np.abs(samples.values).max() or 1.0
    scatter = [] if samples.deviation is None else [(samples.deviation, 1.0)]
    for array, unit in (*((angle, 1.0) for angle in samples.directions), (samples.values, scale), *scatter):
        for start in range(0, len(array), _CHUNK):
            part = array[start:start + _CHUNK] / unit
            content.update(np.clip(np.round(1e7 * part), -_LARGEST, _LARGEST).astype("<i8").tobytes())
    return content.hexdigest()[:32]


def freeze(arguments: Arguments) -> str:
    """Arguments as a cache key."""
    return json.dumps(arguments, sort_keys=True)
