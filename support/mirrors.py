"""Spikes and holes at a mirror: how far a fit goes beyond what was measured around it, near each mirror direction."""

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from fitter.arrays import unit_vectors

WITHIN = 1.5                # degrees from the mirror direction
_NEAR = 3.0                 # degrees from a direction, within which samples surround it
_EACH = 2                   # samples of each quadrant about a direction, of which the least and largest bound it
_LEAST_OF_LARGEST = 1e-3    # of the channel's largest sample: below it a ratio is one of noise
_STEP = 0.1                 # degrees
_INCIDENCES = range(0, 80, 5)       # degrees, of a table's function
_BLUR = 3                   # steps within which such a function bounds a fit


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
