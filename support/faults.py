"""Faults that fits may have where few samples are: how large they are.

A ring about retro-reflection, where most instruments hide the lamp; spikes and holes near mirror directions; the rims
of balls, and what lies between the nodes of RGL's files; and fits of the starter library beside their own models.
"""

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from fitter.arrays import select_directions, unit_vectors
from fitter.methods.energy import reflected_light
from fitter.model import published
from fitter.quality.cross_validation import cube_root

RING_DEGREES = 10, 20, 30, 45, 60, 70
_AROUND, _WITHIN = (5, 6, 7, 8, 9), (0.25, 0.5, 1, 1.5, 2, 2.5, 3, 4)         # degrees from retro-reflection
_AZIMUTHS = (np.arange(16) + 0.5) * np.pi / 8
WITHIN = 1.5                # degrees from the mirror direction
_NEAR = 3.0                 # degrees from a direction, within which samples surround it
_EACH = 2                   # samples of each quadrant about a direction, of which the least and largest bound it
_LEAST_OF_LARGEST = 1e-3    # of the channel's largest sample: below it a ratio is one of noise
_STEP = 0.1                 # degrees
_INCIDENCES = range(0, 80, 5)       # degrees, of a table's function
_BLUR = 3                   # steps within which such a function bounds a fit
LIBRARY_DEGREES = 5, 15, 30, 45, 60, 75
_STEEPEST = np.radians(80)
_CELLS = 64, 24             # of the hemisphere, to sum light over


def ring(fit):
    """By how much a fit within 4 degrees of retro-reflection is off the paraboloid through it at 5 to 9 degrees: the
    largest ratio less 1, of any of `RING_DEGREES` of incidence, of the mean over channels."""
    worst = 0.0
    for theta in np.radians(RING_DEGREES):
        around, within = (_paraboloid_terms(fit, theta, np.radians(degrees)) for degrees in (_AROUND, _WITHIN))
        paraboloid = np.linalg.lstsq(around[0], around[1], rcond=None)[0]
        ratio = np.maximum(within[1], 1e-9) / np.maximum(within[0] @ paraboloid, 1e-9)
        worst = max(worst, float(np.abs(np.log(ratio)).max()))
    return np.exp(worst) - 1


def _paraboloid_terms(fit, theta, radii):
    """Terms of a paraboloid in the offsets from the direction (theta, 0), (n, 4), and the fit there, (n,)."""
    radius, azimuth = (grid.ravel() for grid in np.meshgrid(radii, _AZIMUTHS))
    x, y, z = np.sin(radius) * np.cos(azimuth), np.sin(radius) * np.sin(azimuth), np.cos(radius)
    x, z = np.cos(theta) * x + np.sin(theta) * z, np.cos(theta) * z - np.sin(theta) * x
    found = fit.evaluate(theta, 0.0, np.arctan2(np.hypot(x, y), z), np.arctan2(y, x)).mean(axis=-1)
    along, across = radius * np.cos(azimuth), radius * np.sin(azimuth)
    return np.stack([np.ones_like(along), along, along ** 2, across ** 2], axis=1), found


def ratios_to_samples(fit, samples):
    """The largest factors by which a fit is above the largest, and below the least, of the samples around: (2,).

    Asked are directions within 1.5 degrees of the mirror direction, in the plane of incidence and across it, at every
    measured incidence. Each is compared with the two nearest samples of the incidence in every quadrant about it, and
    left out where a quadrant has none within 3 degrees. Where only the plane of incidence was measured, its two sides
    stand for the quadrants. The factors are 0 where there is no such direction.
    """
    theta_i, phi_i, theta_o, phi_o = (np.broadcast_to(each, len(samples)) for each in samples.directions)
    least = _LEAST_OF_LARGEST * samples.values.max(axis=0)
    offsets = np.radians(np.arange(-WITHIN, WITHIN + _STEP / 2, _STEP))
    worst = np.zeros(2)
    for incidence in np.unique(np.round([theta_i, phi_i], 6), axis=1).T:
        own = (np.abs(theta_i - incidence[0]) < 1e-5) & (np.abs(phi_i - incidence[1]) < 1e-5)
        mirror, inward, across = _frame(*incidence)
        outgoing, values = unit_vectors(theta_o[own], phi_o[own]), samples.values[own]
        close = outgoing @ mirror > np.cos(np.radians(WITHIN + _NEAR))
        outgoing, values = outgoing[close], values[close]
        in_plane = not len(outgoing) or np.ptp(outgoing @ across) < 1e-5
        if samples.isotropic and not in_plane:          # the plane of incidence is one of symmetry
            outgoing = np.concatenate([outgoing, outgoing - 2 * (outgoing @ across)[:, None] * across])
            values = np.concatenate([values, values])
        for line in [inward] if in_plane else [inward, across]:
            for at in np.cos(offsets)[:, None] * mirror + np.sin(offsets)[:, None] * line:
                around = _around(outgoing - at, inward, None if in_plane else across)
                if around is not None and at[2] > 0:
                    low, high = (np.maximum(bound(values[around], axis=0), least) for bound in (np.min, np.max))
                    value = np.maximum(np.ravel(fit.evaluate(*incidence, *_angles(at))), least)
                    worst = np.maximum(worst, [(value / high).max(), (low / value).max()])
    return worst


def ratios_to_function(fit, function, largest):
    """Likewise of a function, at incidences up to 75 degrees, by its values within .3 degrees: (2,)."""
    least, worst = _LEAST_OF_LARGEST * largest, np.zeros(2)
    reach = round(WITHIN / _STEP) + _BLUR
    x, y = np.meshgrid(*2 * [np.radians(_STEP * np.arange(-reach, reach + 1))], indexing="ij")
    for theta in np.radians(_INCIDENCES):
        mirror, inward, across = _frame(theta, 0.0)
        at = mirror + x[..., None] * inward + y[..., None] * across
        angles = _angles(at / np.linalg.norm(at, axis=-1, keepdims=True))
        value, truth = (np.maximum(each.evaluate(theta, 0.0, *angles), least) for each in (fit, function))
        window = sliding_window_view(truth, 2 * [2 * _BLUR + 1], axis=(0, 1))
        inner = slice(_BLUR, -_BLUR)
        near = np.hypot(x, y)[inner, inner] <= np.radians(WITHIN)
        value = value[inner, inner][near]
        worst = np.maximum(worst, [(value / window.max(axis=(-1, -2))[near]).max(),
                                   (window.min(axis=(-1, -2))[near] / value).max()])
    return worst


def _around(offsets, inward, across):
    """The nearest samples of each quadrant, by offsets (n, 3) from a direction; None if a quadrant has none near."""
    distance = np.linalg.norm(offsets, axis=1)
    quadrant = (offsets @ inward > 0).astype(int) + (0 if across is None else 2 * (offsets @ across > 0))
    found = []
    for number in range(2 if across is None else 4):
        own = np.flatnonzero((quadrant == number) & (distance < np.radians(_NEAR)))
        if not len(own):
            return None
        found += [*own[np.argsort(distance[own], kind="stable")[:_EACH]]]
    return found


def _frame(theta_i, phi_i):
    """The mirror direction, that to the normal from it in the plane of incidence, and that across."""
    mirror, inward = unit_vectors(theta_i, phi_i + np.pi), unit_vectors(theta_i - np.pi / 2, phi_i + np.pi)
    return mirror, inward, np.cross(mirror, inward)


def _angles(vectors):
    return np.arccos(np.clip(vectors[..., 2], -1, 1)), np.arctan2(vectors[..., 1], vectors[..., 0])


class Clipped:
    """A table of RGL without negative values."""

    isotropic = True

    def __init__(self, table):
        self.table = table

    def evaluate(self, *angles):
        """As `Fit.evaluate`."""
        broadcast = np.broadcast_arrays(*(np.asarray(angle, dtype=float) for angle in angles))
        values = self.table.evaluate(*(angle.ravel() for angle in broadcast))
        return np.maximum(values, 0).reshape(*broadcast[0].shape, -1)


def albedo(model, degrees):
    """Of light that leaves at angles: (angles, channels)."""
    return reflected_light(model, np.radians(degrees), _CELLS).sum(axis=2).mean(axis=0)


def error(model, golden):
    """The relative root mean square of differences of cube roots of f cos theta_o, of a table of golden values."""
    found = np.cbrt(np.maximum(model.evaluate(*golden[:, :4].T), 0) * np.cos(golden[:, 2])[:, None])
    wanted = np.cbrt(np.maximum(golden[:, 4:7], 0))
    return float(np.sqrt(((found - wanted) ** 2).mean() / (wanted ** 2).mean()))


def albedo_error(name, fit):
    """By how much the albedo of a fit is off its model's, of light that leaves or arrives: the ratio of the channel and
    the angle of `LIBRARY_DEGREES` where it is largest, either way, less 1."""
    found, wanted = (reflected_light(each, np.radians(LIBRARY_DEGREES), _CELLS).sum(axis=2)
                     for each in (fit, published.find(name).model))
    return float(np.exp(np.abs(np.log(found / wanted)).max()) - 1)


def swapped_error(name, fit):
    """The root mean square of differences of the cube roots of f cos theta_o, of which a white Lambertian's is 1, where
    the light comes from the direction from which samples up to `_STEEPEST` are seen, and is seen from that of their
    light: nobody sampled those."""
    theta_i, phi_i, theta_o, phi_o = select_directions(at := published.directions(published.find(name).model),
                                                       np.maximum(at[0], at[2]) < _STEEPEST)
    found, wanted = (cube_root(theta_i, np.pi * each.evaluate(theta_o, phi_o, theta_i, phi_i))
                     for each in (fit, published.find(name).model))
    return float(np.sqrt(((found - wanted) ** 2).mean()))


def mirror_albedo(fit, theta):
    """Directional albedo (channels,) at a polar angle in radians, by rings about the mirror direction, closer there."""
    mirror, x = np.array([-np.sin(theta), 0, np.cos(theta)]), np.array([np.cos(theta), 0, np.sin(theta)])
    y = np.cross(mirror, x)
    u, turn = (np.arange(400) + 0.5) / 400, 2 * np.pi * (np.arange(240) + 0.5) / 240
    away, width = np.pi * u ** 3, 3 * np.pi * u ** 2 / 400
    to = (np.cos(away)[:, None, None] * mirror + np.sin(away)[:, None, None]
          * (np.cos(turn)[:, None] * x + np.sin(turn)[:, None] * y))
    up = to[..., 2] > 1e-3
    value = fit.evaluate(theta, 0.0, np.arccos(np.clip(to[up, 2], -1, 1)), np.arctan2(to[up, 1], to[up, 0]))
    weight = np.broadcast_to((np.sin(away) * width)[:, None] * (2 * np.pi / 240), up.shape)[up] * to[up, 2]
    return value.T @ weight
