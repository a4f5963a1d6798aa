"""The pictures of the held-out errors, drawn from the views."""

import numpy as np

from fitter.pictures import srgb

from ..report.plots import COLORS, pyplot, save
from . import lamps, ridge, views
from .summary import OWN

SPHERES, LAMPS, RIDGE = "held_out_spheres.png", "held_out_lamps.png", "held_out_ridge.png"
_BACKGROUND = "0.16"
_INK = "0.9"
_DOT = 0.9                  # of the picture: how bright the median highlight of the reference is


def draw(results, out, into=None):
    """Draw the pictures of the telling sets among the results, as `Bench.draw` does."""
    records = {record["name"]: record for record in results["sets"]}
    shown = [(records[name], view) for name in views.TELLING if name in records and (view := views.read(out, name))]
    drawn = []
    for name, function, key in ((SPHERES, _spheres, "spheres"), (LAMPS, _lamps, "lamps"), (RIDGE, _ridge, "ridge")):
        found = [(record, view) for record, view in shown if getattr(view, key).size]
        if found:
            save(function(found), (into or out) / name)
            drawn.append(name)
    return drawn


def _spheres(shown):
    """A row of spheres for each set: the reference, Standard and the rivals, with their errors."""
    methods = list(dict.fromkeys(name for _, view in shown for name in view.names[1:]))
    figure, axes = pyplot.subplots(len(shown), 1 + len(methods), squeeze=False, layout="constrained",
                                   figsize=(1.85 * (1 + len(methods)), 2.1 * len(shown) + 0.6))
    figure.set_facecolor(_BACKGROUND)
    figure.suptitle("The truth, or where there is none Standard fitted to all samples; and fits to 80 % of the "
                    "samples,\nwith their RMSE of the cube root at samples held out, the smallest of which is framed",
                    color=_INK, fontsize=12)
    for line, (record, view) in zip(axes, shown, strict=True):
        errors = {name: row["held_out_cube_root_rmse"] for name, row in record["methods"].items()}
        least = min((error for error in errors.values() if error is not None), default=None)
        for axis, name in zip(line, (view.names[0], *methods), strict=True):
            _bare(axis)
            if name in view.names:
                axis.imshow(view.spheres[view.names.index(name)], origin="lower")
            else:
                axis.set_xlim(0, 1)
            axis.set_title(name, color=_INK, fontsize=9, pad=2)
            if name in errors:
                error = errors[name]
                axis.set_xlabel("failed" if error is None else f"{error:.3g}", color=_INK, fontsize=11, labelpad=2,
                                weight="bold" if error == least else "normal")
                if error is not None and error == least:
                    for spine in axis.spines.values():
                        spine.set(visible=True, color="tab:orange", linewidth=2)
        line[0].set_ylabel(record["name"].replace(", ", "\n"), color=_INK, fontsize=9)
    return figure


def _lamps(shown):
    """The row-of-lamps pictures: a row for each set."""
    columns = max(len(view.lamp_names) for _, view in shown)
    figure, axes = pyplot.subplots(len(shown), columns, squeeze=False, layout="constrained",
                                   figsize=(5.4 * columns, 5.7 * len(shown) + 0.7))
    figure.set_facecolor(_BACKGROUND)
    most = np.degrees(np.abs(lamps.INCIDENCES).max())
    figure.suptitle(f"Under a row of {lamps.COUNT} small lamps, mirrored at incidences of 0 to {most:g} degrees: a "
                    "coat shows a line of dots,\nwhich fade or change colour in turn where a fit loses it between "
                    "measured incidences",
                    color=_INK, fontsize=12)
    for line, (record, view) in zip(axes, shown, strict=True):
        exposure = _DOT / max(np.median(_highlights(view.lamps[0])), 1e-9)
        for axis in line:
            _bare(axis)
        for axis, name, picture in zip(line, view.lamp_names, view.lamps, strict=False):
            axis.imshow(srgb(exposure * picture), origin="lower")
            row = record["methods"].get(name)
            axis.set_title(name + (f", from 80 %: held out {row['held_out_cube_root_rmse']:.3g}" if row else ""),
                           color=_INK, fontsize=11)
        line[0].set_ylabel(record["name"].replace(", ", "\n"), color=_INK, fontsize=11)
    return figure


def _ridge(shown):
    """Energy of each channel, and colour, along the mirror ridge: a row for each set."""
    figure, axes = pyplot.subplots(len(shown), 4, squeeze=False, layout="constrained",
                                   figsize=(18, 3.1 * len(shown) + 0.6))
    figure.suptitle(f"Energy in the cone of {np.degrees(ridge.HALF_ANGLE):.0f} degrees about the mirror direction "
                    "(integral of f cos), against the angle of incidence in degrees; points at measured incidences. "
                    "Right: its colour", fontsize=12)
    degrees = np.degrees(ridge.INCIDENCES)
    for line, (record, view) in zip(axes, shown, strict=True):
        for channel, axis in enumerate(line[:3]):
            if channel < view.ridge.shape[2]:
                _energies(axis, degrees, view, channel)
            axis.set_title(f"{record['name']}: {'RGB'[channel]}", fontsize=9)
        _colors(line[3], degrees, view)
    axes[0, 0].legend(fontsize=7)
    return figure


def _energies(axis, degrees, view, channel):
    """The energy of one channel by each method."""
    reference = view.ridge[0, :, channel]
    axis.semilogy(degrees, reference, color="black", linewidth=3, alpha=0.35, label=view.names[0])
    for name, energies in zip(view.names[1:], view.ridge[1:, :, channel], strict=True):
        axis.semilogy(degrees, energies, color=COLORS[name], linewidth=1.8 if name == OWN else 0.7, label=name,
                      zorder=3 if name == OWN else 2)
    at = np.degrees(view.measured)
    axis.semilogy(at, np.exp(np.interp(at, degrees, np.log(np.maximum(reference, 1e-12)))), "ko", markersize=4)
    axis.set_ylim(reference.min() / 4, reference.max() * 4)


def _colors(axis, degrees, view):
    """A strip for each method: the colour of its highlight at each incidence, all equally bright."""
    energies = view.ridge if view.ridge.shape[2] == 3 else np.repeat(view.ridge[..., :1], 3, axis=2)
    strips = srgb(0.8 * energies / np.maximum(energies.max(axis=2, keepdims=True), 1e-12))
    axis.imshow(strips, aspect="auto", interpolation="nearest",
                extent=(degrees[0], degrees[-1], len(view.names) - 0.5, -0.5))
    axis.set_yticks(range(len(view.names)), view.names, fontsize=7)
    axis.set_ylim(len(view.names) - 0.5, -0.5)
    for at in np.degrees(view.measured):
        axis.axvline(at, color="black", linewidth=0.4)


def _highlights(picture):
    """The brightest pixel at the mirror image of each lamp: (lamps.COUNT,)."""
    size = len(picture)
    brightest = picture.max(axis=2)
    found = []
    for incidence in lamps.INCIDENCES:
        half = lamps.disk(incidence)[0] + (0, 0, 1)
        column, row = ((half[:2] / np.linalg.norm(half) * 0.96 + 1) / 2 * size).astype(int)
        found.append(brightest[max(row - 2, 0):row + 3, max(column - 2, 0):column + 3].max())
    return np.array(found)


def _bare(axis):
    """No ticks and no frame; labels stay."""
    axis.set_xticks([])
    axis.set_yticks([])
    axis.set_facecolor(_BACKGROUND)
    for spine in axis.spines.values():
        spine.set_visible(False)
