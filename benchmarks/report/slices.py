"""The plots of the fits themselves: slices in the plane of incidence."""

import re
from pathlib import Path

import numpy as np
from matplotlib import pyplot
from matplotlib.figure import Figure

from fitter.samples import Samples

from .methods import METHODS, levels
from .plots import save
from .rows import MakeModel

POLAR: dict[str, MakeModel] = {
    "(1,6,90)": levels(1, 6, 90), **{name: METHODS[name] for name in ("Paper", "Standard", "Lafortune 3")}}
_ANGLES = 4                 # incident angles in a polar plot
_IN_PLANE = 0.03            # largest distance of plotted samples from the plane of incidence, on the unit sphere


def draw_polar(samples: Samples, out: Path) -> str:
    """Write the polar plot of a material to a folder. Returns its file name."""
    name = f"polar_{re.sub(r'[^a-z0-9]+', '_', samples.name.lower()).strip('_') or 'material'}.png"
    save(_polar(samples), out / name)
    return name


def _polar(samples: Samples) -> Figure:
    """Fits and samples in the plane of incidence: the mean of the channels, relative to the largest sample."""
    incident, delta_phi = np.degrees(samples.theta_i).round(), samples.phi_o - samples.phi_i
    in_plane = np.abs(np.sin(samples.theta_o) * np.sin(delta_phi)) < _IN_PLANE
    outgoing = np.where(np.cos(delta_phi) > 0, -1, 1) * samples.theta_o     # negative on the light's side
    angles, counts = np.unique(incident[in_plane], return_counts=True)
    angles = angles[(counts > 3) & (angles > 0)]
    angles = angles[np.linspace(0, len(angles) - 1, min(_ANGLES, len(angles))).round().astype(int)]
    t = np.linspace(-np.pi / 2, np.pi / 2, 721)
    figure, axes = pyplot.subplots(2, 2, figsize=(9, 5.6), sharex=True, sharey=True, constrained_layout=True)
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
