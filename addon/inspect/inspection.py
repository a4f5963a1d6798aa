"""What is inspected: a spot, the direction of the light there, and what a fit reflects. Mouse and keys change it."""

from typing import Literal, NamedTuple

import numpy as np

from ...fitter.arrays import BoolArray, FloatArray, unit_vectors
from ...fitter.imaging.lobe import RADII, Lobe, Radius, lobe_surface
from ...fitter.imaging.plane_plot import Plane, Plotted
from ...fitter.methods import extrapolation
from ...fitter.model import Reflectance
from ..core.annotations import not_none
from .plot import Plot
from .surface import Spot
from .view import View, drag_direction, limit_polar_angle

HANDLE = 1.3                # distance of the light's handle, over the longest radius of the lobe
_REACH = 1.12               # over that of the handle: where a click in the view takes it
_FINE, _COARSE = (64, 128), (40, 80)        # rows and columns of the lobe: at rest, and while the light is dragged
_STEP = np.radians(1)       # of the arrow keys
_KEYS = {"LEFT_ARROW": (_STEP, 0.0), "RIGHT_ARROW": (-_STEP, 0.0), "UP_ARROW": (0.0, _STEP),
         "DOWN_ARROW": (0.0, -_STEP)}


class InspectedSurface(NamedTuple):
    """A fit or a mix, and what is said of it."""

    fit: Reflectance
    name: str
    space: str              # of its colours
    reaches: tuple[extrapolation.MeasuredDomain, ...] = ()      # as far as they are known
    note: str = ""


class Measurements(NamedTuple):
    """Samples near the plane of incidence, as `plane_plot.samples_near_plane` returns them, and what they come from."""

    theta_o: FloatArray
    values: FloatArray
    theta_i: float
    source: str = "measured"


class Inspection:
    """The state of an inspection: `size` is the longest radius of the lobe, in the world; angles are radians, `phi_i`
    from the tangent; `side` is where the plot is."""

    def __init__(self, spot: Spot, size: float, theta_i: float, phi_i: float,
                 side: Literal["LEFT", "RIGHT"] = "RIGHT") -> None:
        self.spot, self.size, self.side = spot, size, side
        self.theta_i, self.phi_i = limit_polar_angle(theta_i), phi_i
        self.radius: Radius = "cube root"
        self.with_plot = True
        self.shown: InspectedSurface | None = None          # once it is known
        self.second: InspectedSurface | None = None         # the pinned one, of which the plot has a curve
        self.lobe: Lobe | None = None
        self.samples: Measurements | None = None
        self.plane = Plane((), self.theta_i)
        self.drag: Literal["", "LOBE", "PLOT"] = ""         # what the mouse drags the light on
        self.mouse: FloatArray | None = None                # (2,) pixels of the region

    def show(self, shown: InspectedSurface | None, second: InspectedSurface | None = None) -> bool:
        """Show a fit, beside the second one in the plot: whether either is another than before."""
        if (shown, second) == (self.shown, self.second):
            return False
        self.shown, self.second = shown, second
        self._evaluate()
        return True

    def show_samples(self, samples: Measurements | None) -> None:
        surfaces = () if self.shown is None else (self.shown, self.second)
        fits = [Plotted(each.fit, each.space, each.reaches) for each in surfaces if each is not None]
        self.samples = samples
        self.plane = Plane(fits, self.theta_i, self.phi_i, samples and samples[:2], self.radius)

    def press(self, view: View, frame: FloatArray, plot: Plot, at: FloatArray) -> bool:
        """The mouse is pressed: whether that was meant for the inspection."""
        if self.with_plot and plot.holds(at):
            self.drag = "PLOT" if plot.is_read(at) else ""
            self.move(view, frame, plot, at)
            return True
        away = np.linalg.norm(view.project(frame[:3, 3]) - at) * view.pixel(frame[:3, 3])
        if not away <= _REACH * HANDLE * self.size:
            return False
        self.drag = "LOBE"
        self.move(view, frame, plot, at)
        return True

    def move(self, view: View, frame: FloatArray, plot: Plot, at: FloatArray) -> None:
        self.mouse = at
        if self.drag == "LOBE":
            self.theta_i, self.phi_i = drag_direction(view, at, frame, HANDLE * self.size)
        elif self.drag == "PLOT":
            self.theta_i = limit_polar_angle(-plot.angle(at))
        if self.drag:
            self._evaluate(_COARSE)

    def release(self) -> None:
        self.drag = ""
        self._evaluate()

    def key(self, kind: str) -> bool:
        """A key is pressed: whether it means something."""
        if kind == "R":
            self.radius = "linear" if self.radius == "cube root" else "cube root"
        elif kind == "P":
            self.with_plot = not self.with_plot
        elif kind in _KEYS:
            theta, phi = _KEYS[kind]
            self.theta_i, self.phi_i = limit_polar_angle(self.theta_i + theta), self.phi_i + phi
        else:
            return False
        self._evaluate()
        return True

    @property
    def longest(self) -> float:
        """The longest radius of the lobe as it is, at least above 0."""
        return 0.0 if self.lobe is None else max(float(np.linalg.norm(self.lobe.vertices, axis=1).max()), 1e-9)

    @property
    def curve(self) -> tuple[FloatArray, FloatArray] | None:
        return self.plane.plane_curves[0] if self.plane.fits else None

    def light(self) -> FloatArray:
        """The direction to the light in the frame of the surface, (3,)."""
        return unit_vectors(self.theta_i, self.phi_i)

    def ridge(self) -> FloatArray:
        """The lobe in the plane of incidence: (k, 3) in the frame of the surface, 1 at its longest."""
        theta, values = not_none(self.curve)
        radii = RADII[self.radius](np.maximum(values.mean(axis=1), 0)) / self.longest
        # negative angles are on the light's side
        return radii[:, None] * unit_vectors(-theta, self.phi_i)

    def is_extrapolated(self, theta: FloatArray) -> BoolArray:
        """Whether nobody measured what leaves at polar angles (n,), radians; they may be negative."""
        reaches = () if self.shown is None else self.shown.reaches
        return extrapolation.is_extrapolated_in_any(np.full(len(theta), self.theta_i), np.abs(theta), reaches)

    def _evaluate(self, detail: tuple[int, int] = _FINE) -> None:
        self.show_samples(self.samples)
        self.lobe = None if self.shown is None else lobe_surface(self.shown.fit, self.theta_i, self.phi_i, *detail,
                                                                 self.radius)
