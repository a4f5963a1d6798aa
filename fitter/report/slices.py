"""The plots of the fits themselves: slices in the plane of incidence, and histograms of the error."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..samples import Samples
from .methods import METHODS, levels
from .plots import COLORS, panels, pyplot, save
from .rows import MakeModel

if TYPE_CHECKING:
    from matplotlib.figure import Figure

POLAR: dict[str, MakeModel] = {
    "(1,6,90)": levels(1, 6, 90), **{name: METHODS[name] for name in ("Paper", "Standard", "Lafortune 3")}}
_ANGLES = 4                 # incident angles in a polar plot
_IN_PLANE = 0.03            # largest distance of plotted samples from the plane of incidence, on the unit sphere


def draw_polar(samples: Samples, out: Path) -> list[str]:
    """Write the polar plot of a material to a folder. Returns its file name, none if matplotlib is not installed."""
    if pyplot() is None:
        return []
    name = f"polar_{re.sub(r'[^a-z0-9]+', '_', samples.name.lower()).strip('_') or 'material'}.png"
    save(_polar(samples), out / name)
    return [name]


def draw_histograms(shown: Sequence[Samples], out: Path) -> list[str]:
    """Write histograms of materials' errors to a folder. Returns the file name, none if matplotlib is not installed."""
    if pyplot() is None:
        return []
    save(_histograms(shown), out / "histograms.png")
    return ["histograms.png"]


def _polar(samples: Samples) -> Figure:
    """Fits and samples in the plane of incidence: the mean of the channels, relative to the largest sample."""
    incident, delta_phi = np.degrees(samples.theta_i).round(), samples.phi_o - samples.phi_i
    in_plane = np.abs(np.sin(samples.theta_o) * np.sin(delta_phi)) < _IN_PLANE
    outgoing = np.where(np.cos(delta_phi) > 0, -1, 1) * samples.theta_o     # negative on the light's side
    angles, counts = np.unique(incident[in_plane], return_counts=True)
    angles = angles[(counts > 3) & (angles > 0)]
    angles = angles[np.linspace(0, len(angles) - 1, min(_ANGLES, len(angles))).round().astype(int)]
    t = np.linspace(-np.pi / 2, np.pi / 2, 721)
    figure, axes = pyplot().subplots(2, 2, figsize=(9, 5.6), sharex=True, sharey=True, constrained_layout=True)
    for axis, (method, make) in zip(axes.ravel(), POLAR.items(), strict=True):
        model = make(samples)
        axis.plot(np.sin(t), np.cos(t), color="lightgray", linewidth=0.8)
        for number, angle in enumerate(angles):
            here = in_plane & (incident == angle)
            measured = samples.values[here].mean(axis=1)
            value = model.evaluate(np.radians(angle), 0, np.abs(t), np.where(t < 0, 0, np.pi)).mean(axis=1)
            for radius, at, style in ((value, t, "-"), (measured, outgoing[here], ".")):
                radius = np.maximum(radius, 0) / measured.max()
                axis.plot(radius * np.sin(at), radius * np.cos(at), style, color=f"C{number}", linewidth=0.8,
                          markersize=4, label=f"{angle:.0f}°" if style == "-" else None)
        axis.set(xlim=(-1.2, 1.2), ylim=(0, 1.2), aspect="equal")
        axis.tick_params(labelsize=6)
        axis.set_title(method, fontsize=9)
    if len(angles):
        axes[0, 0].legend(fontsize=6, loc="upper left", title="incident angle", title_fontsize=6)
    figure.suptitle(f"{samples.name}: f in the plane of incidence, at each incident angle relative to its largest "
                    "sample; the mirror direction is to the right", fontsize=9)
    return figure


def _histograms(shown: Sequence[Samples]) -> Figure:
    """Histograms of the absolute errors at the samples."""
    figure, axes = panels(len(shown), 3, (4, 2.4))
    bins = np.linspace(-7, 2, 73)
    for axis, samples in zip(axes.ravel(), shown, strict=False):
        for method, make in METHODS.items():
            error = np.abs(make(samples).evaluate(*samples.directions) - samples.values).ravel()
            axis.hist(np.log10(np.maximum(error, 1e-7)), bins, histtype="step", color=COLORS[method], label=method)
        axis.set_title(samples.name, fontsize=9)
    axes[0, 0].legend(fontsize=6, loc="upper left")
    figure.supxlabel("log10 of |error| at the samples, 1/sr; the first bar holds all that is smaller", fontsize=8)
    return figure
