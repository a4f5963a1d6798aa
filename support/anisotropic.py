"""Analytic anisotropic reflectances: truths to judge fits and pictures by, and what instruments measure of them.

A `Truth` of `support.truths`, which depends on both azimuths; phi = 0 is the tangent. Each kind has two materials, "a"
and "b", of different parameters: constants of a method are chosen on the one and judged on the other.
"""

import numpy as np

from fitter.arrays import unit_vectors
from fitter.coordinates.rusinkiewicz import Rusinkiewicz
from fitter.lattice import dense
from fitter.model.fit import Fit
from fitter.model.microfacet import Microfacet
from fitter.model.transform import LogRelative
from fitter.samples import RGB

from .truths import Truth

COLOUR = np.array([1.0, 0.8, 0.5])


def unit(theta, phi):
    """Unit vectors: (3, n)."""
    return unit_vectors(theta, phi).T


def vectors(theta_i, phi_i, theta_o, phi_o):
    """Unit vectors of pairs of directions (n,): two (n, 3)."""
    return unit_vectors(theta_i, phi_i), unit_vectors(theta_o, phi_o)


def turned(w, angle):
    """Vectors (n, 3) in axes that are turned by an angle about the normal."""
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * w[:, 0] + s * w[:, 1], c * w[:, 1] - s * w[:, 0], w[:, 2]], axis=-1)


def ggx_lobe(wi, wo, along, across):
    """Anisotropic GGX with height-correlated masking, without a Fresnel term (Walter et al. 2007; Heitz 2014): (n,)."""
    h = wi + wo
    h = h / np.linalg.norm(h, axis=1)[:, None]
    distribution = 1 / (np.pi * along * across * ((h[:, 0] / along) ** 2 + (h[:, 1] / across) ** 2 + h[:, 2] ** 2) ** 2)

    def masking(w):
        return (np.sqrt(1 + ((along * w[:, 0]) ** 2 + (across * w[:, 1]) ** 2) / w[:, 2] ** 2) - 1) / 2

    cosines = np.maximum(wi[:, 2] * wo[:, 2], 1e-9)
    return distribution / (1 + masking(wi) + masking(wo)) / (4 * cosines)


def ward_lobe(wi, wo, along, across):
    """G. Ward's model (1992) with the denominator of A. Duer (2005): (n,)."""
    h = wi + wo
    slope2 = ((h[:, 0] / along) ** 2 + (h[:, 1] / across) ** 2) / h[:, 2] ** 2
    return np.exp(-slope2) / (4 * np.pi * along * across * np.maximum(wi[:, 2] * wo[:, 2], 1e-3))


def ggx(along=0.12, across=0.45, diffuse=0.1, turn=0.0, specular=1.0, lobe=ggx_lobe):
    """A lobe of two roughnesses on a Lambertian, without a Fresnel term; the frame is turned by `turn` radians."""
    def function(*directions):
        wi, wo = (turned(w, turn) for w in vectors(*directions))
        return np.outer(diffuse / np.pi + specular * lobe(wi, wo, along, across), COLOUR)
    return function


def ward(turn=0.0):
    return ggx(0.1, 0.3, 0.2, turn, 1.2, ward_lobe)


def brushed(kd, ks, along, across, turn, model=ggx_lobe):
    def function(*directions):
        wi, wo = (turned(w, turn) for w in vectors(*directions))
        cos_d = np.linalg.norm(wi + wo, axis=1) / 2
        fresnel = np.asarray(ks) + (1 - np.asarray(ks)) * ((1 - np.minimum(cos_d, 1)) ** 5)[:, None]
        return np.asarray(kd) + fresnel * model(wi, wo, along, across)[:, None]
    return function


def _lacquered(kd, ks, along, across, turn, coat, width):
    """Brushed metal under a smooth coat of an index of 1.5, which lets through what its Fresnel term leaves."""
    base = brushed(kd, ks, along, across, turn)

    def function(*directions):
        wi, wo = vectors(*directions)
        through = (1 - (1 - wi[:, 2]) ** 5) * (1 - (1 - wo[:, 2]) ** 5)
        cos_d = np.minimum(np.linalg.norm(wi + wo, axis=1) / 2, 1)
        gloss = (0.04 + 0.96 * (1 - cos_d) ** 5) * coat * ggx_lobe(wi, wo, width, width)
        return base(*directions) * through[:, None] + gloss[:, None]
    return function


def woven(*threads, ground=0.02):
    """A cloth of threads, each a colour, an azimuth, a slope at which it lies, and a width: each shines on a cone about
    its direction, as the fibres of J. Kajiya and T. Kay (1989), but reciprocal. The ground is what dye leaves below."""
    def function(*directions):
        wi, wo = vectors(*directions)
        total = np.tile(np.broadcast_to(ground, 3), (len(wi), 1))
        for colour, azimuth, slope, width in threads:
            for side in (-slope, slope):
                thread = np.array([np.cos(azimuth) * np.cos(side), np.sin(azimuth) * np.cos(side), np.sin(side)])
                off = wi @ thread + wo @ thread
                lobe = np.exp(-(off / width) ** 2) / (wi[:, 2] + wo[:, 2] + 0.1)
                total += np.asarray(colour) * lobe[:, None]
        return total
    return function


def _twill(warp, weft, width, slope):
    return woven((warp, 0.0, slope, width), (weft, np.pi / 2, slope, width))


ANISOTROPIC = (
    Truth("brushed a", "brushed metal", brushed([0.01, 0.01, 0.01], [0.9, 0.75, 0.4], 0.12, 0.45, np.radians(20))),
    Truth("brushed b", "brushed metal", brushed([0.02, 0.02, 0.03], [0.7, 0.72, 0.75], 0.3, 0.06, np.radians(-35))),
    Truth("ward a", "lacquered wood", brushed([0.15, 0.08, 0.04], [0.05, 0.05, 0.05], 0.1, 0.25, 0.0, ward_lobe)),
    Truth("ward b", "lacquered wood", brushed([0.25, 0.2, 0.1], [0.1, 0.1, 0.1], 0.2, 0.08, np.radians(45), ward_lobe)),
    Truth("lacquered a", "lacquered metal", _lacquered([0.01, 0.01, 0.02], [0.6, 0.3, 0.2], 0.4, 0.15, 0.5, 1.0, 0.05)),
    Truth("lacquered b", "lacquered metal", _lacquered([0.02, 0.03, 0.02], [0.3, 0.5, 0.5], 0.1, 0.3, -1.0, 0.8, 0.1)),
    Truth("woven a", "satin", _twill([0.3, 0.05, 0.06], [0.05, 0.1, 0.3], 0.15, np.radians(12))),
    Truth("woven b", "satin", _twill([0.4, 0.35, 0.1], [0.1, 0.02, 0.02], 0.25, np.radians(20))))
# of tables as a user would write them, whose ground is along the tangent: a highlight is narrow along the grooves
STEEL = Truth("brushed steel", "brushed metal", brushed(3 * [0.012], [0.63, 0.61, 0.58], 0.09, 0.42, 0.0))
# warp threads along the tangent, that float over the weft
SATIN = Truth("satin", "satin", woven(([0.42, 0.11, 0.135], 0.0, np.radians(3), 0.125),
                                      ([0.04, 0.003, 0.007], np.pi / 2, np.radians(20), 0.3),
                                      ground=[0.018, 0.0015, 0.003]))


def rotations(count, turn=2 * np.pi):
    """Pairs of directions at which an instrument measures at several rotations of the sample: four (n,), radians.

    Incidences of every 15 degrees, outgoing directions on a grid of 10 by 15 degrees and about the mirror direction.
    """
    phi_i = np.arange(count) / count * turn
    grid = np.array(np.meshgrid(phi_i, np.radians(np.arange(0, 76, 15)), np.radians(np.arange(0, 86, 10)),
                                np.radians(np.arange(0, 360, 15)), indexing="ij")).reshape(4, -1)
    near = np.array(np.meshgrid(phi_i, np.radians(np.arange(0, 76, 15)), np.radians([-12, -6, -3, 0, 3, 6, 12]),
                                np.radians(180 + np.array([-12, -6, 0, 6, 12])), indexing="ij")).reshape(4, -1)
    near[2] += near[1]
    near = near[:, (near[2] >= 0) & (near[2] < np.radians(86))]
    phi_i, theta_i, theta_o, turns = np.concatenate([grid, near], axis=1)
    return theta_i, phi_i, theta_o, phi_i + turns


def between(count, farthest=1.4, seed=1):
    """Random pairs of directions up to a polar angle, a third of them near the mirror direction: four (n,), radians."""
    random = np.random.default_rng(seed)
    theta_i, theta_o = farthest * np.sqrt(random.random((2, count)))
    phi_i, phi_o = 2 * np.pi * random.random((2, count))
    near = slice(0, count // 3)
    theta_o[near] = np.clip(theta_i[near] + 0.15 * random.standard_normal(count // 3), 0, farthest)
    phi_o[near] = phi_i[near] + np.pi + 0.3 * random.standard_normal(count // 3)
    return theta_i, phi_i, theta_o, phi_o


def grid(theta_i, phi_i, theta_o, apart):
    """All combinations of angles in degrees, of which `apart` is phi_o - phi_i: four (n,), radians."""
    axes = np.meshgrid(*(np.radians(np.asarray(axis, float)) for axis in (theta_i, phi_i, theta_o, apart)),
                       indexing="ij")
    theta_i, phi_i, theta_o, apart = (axis.ravel() for axis in axes)
    return theta_i, phi_i, theta_o, phi_i + apart


def goniometer(rotations=range(0, 360, 15)):
    """Directions of a goniometer that turns the sample: 75 to 15 degrees of incidence, 9 x 18 outgoing directions."""
    return grid(range(15, 76, 15), rotations, range(0, 81, 10), range(0, 360, 20))


def scattered(count, random):
    """Directions anywhere above 10 degrees from the horizon: four (count,), radians."""
    share = random.random((4, count))
    return (np.arcsin(np.sqrt(0.97 * share[0])), 2 * np.pi * share[1], np.arcsin(np.sqrt(0.97 * share[2])),
            2 * np.pi * share[3])


def write_table(path, truth, count=24, turn=2 * np.pi, directions=None):
    """Write a table of what an instrument measures of a truth, with noise: its path.

    Directions are four (n,), radians, by default those of `rotations`, which divide an angle by a count.
    """
    directions = rotations(count, turn) if directions is None else directions
    values = truth.evaluate(*directions)
    values = values * (1 + truth.noise * np.random.default_rng(0).standard_normal(values.shape))
    rows = np.column_stack([*np.degrees(directions), np.maximum(values, 0)])
    lines = [f"# name: {truth.name} (synthetic)", "# angles: degrees",
             "theta_i, phi_i, theta_o, phi_o, R, G, B"]
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join(lines + [",".join(f"{number:.6g}" for number in row) for row in rows]) + "\n")
    return path


def few(count=6):
    """Few pairs of directions at several rotations, for tests: four (n,), radians."""
    return grid((0, 30, 60), np.arange(count) * 360 / count, (0, 25, 50, 75), range(0, 360, 45))


def brushed_fit(along=0.12, across=0.45, turn=0.35):
    """A fit that is a Lambertian and one anisotropic lobe, under a field of 0."""
    prior = Microfacet(np.array([0.02, 0.015, 0.01]), np.array([[0.8, 0.6, 0.25]]), np.array([along]), np.array([2.0]),
                       np.array([0.9]), ("mirror",), np.array([across]), np.array([turn]))
    transform = LogRelative(prior, 0.05, np.full(3, 1e4), 0.0)
    field = dense.DenseLattice(1, np.zeros((*dense.shape(1), 3), np.float32))
    return Fit(Rusinkiewicz(), field, None, transform, channels=RGB, name="brushed")
