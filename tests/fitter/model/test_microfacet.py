"""The prior's model of lobes, against its formulas written out with vectors, one pair of directions at a time."""

from dataclasses import replace

import numpy as np
import pytest

from fitter.arrays import unit_vectors
from fitter.model.microfacet import KINDS, MAX_PRIOR_LOBES, NO_GAMMA, Microfacet
from fitter.shader_constants import DENSEST
from support.made_fits import MADE_FITS

ALPHA = {"narrow": 0.02, "medium": 0.3, "wider than 1": 2.5}
FRESNEL = 0.3
TURN, DIP = 0.7, 0.4        # of fibres


def mirror(i, o, alpha, gamma, f0):
    """Burley's distribution, Schlick's Fresnel term and Heitz's height-correlated visibility."""
    h = (i + o) / np.linalg.norm(i + o)
    tan2 = 1 / h[2] ** 2 - 1
    rough = min(alpha, 1.0)
    smith = [n * np.sqrt(rough ** 2 + (1 - rough ** 2) * m ** 2) for n, m in ((i[2], o[2]), (o[2], i[2]))]
    return (1 + tan2 / alpha ** 2) ** -gamma * (f0 + (1 - f0) * (1 - i @ h) ** 5) * 0.5 / (sum(smith) + DENSEST)


def retro(i, o, alpha, gamma, f0):
    """The half and the difference angle of i and of o, turned by half a turn about the normal."""
    turned = o * [-1, -1, 1]
    b = (i + turned) / np.linalg.norm(i + turned)
    return (1 + (1 / b[2] ** 2 - 1) / alpha ** 2) ** -gamma * (f0 + (1 - f0) * (i @ b) ** 2)


def sheen(i, o, alpha, _gamma, f0):
    """The inverted Gaussian of Ashikhmin, and Neubelt and Pettineo's denominator."""
    h = (i + o) / np.linalg.norm(i + o)
    theta_h = np.arccos(h[2])
    shine = np.exp(-1 / (alpha * np.tan(theta_h)) ** 2) if theta_h else 0.0
    return shine * (f0 + (1 - f0) * (1 - i @ h)) / (i[2] + o[2] - i[2] * o[2] + DENSEST)


def fibre(i, o, alpha, gamma, f0):
    """The cones of threads that dip to both sides."""
    z = (i + o)[2]
    cones = []
    for side in (-1, 1):
        # the sum's part along the thread, over the cosine of the dip
        thread = np.array([np.cos(TURN), np.sin(TURN), side * DIP])
        cones.append((1 + ((i + o) @ thread / alpha) ** 2) ** -gamma)
    h = (i + o) / np.linalg.norm(i + o)
    return np.mean(cones) * (f0 + (1 - f0) * (1 - i @ h)) / (z - i[2] * o[2] + DENSEST)


FORMULAS = {"mirror": mirror, "retro": retro, "sheen": sheen, "fibre": fibre}


@pytest.fixture
def pairs(random):
    """Pairs of directions, among them mirror and retro-reflective ones, and some that graze."""
    theta_i, theta_o = np.arccos(1 - 0.999 * random.random((2, 300)))
    phi = 2 * np.pi * random.random(300)
    theta_o[:80] = theta_i[:80]
    phi[:40], phi[40:80] = 0, np.pi
    phi[80:120] += np.where(phi[80:120] > np.pi, 1, -1) * 0.9 * np.abs(phi[80:120] - np.pi)      # near the mirror
    return theta_i, np.full(300, 0.4), theta_o, phi + 0.4


def model(kind, alpha, gamma=2.5, f0=FRESNEL):
    """A Lambertian and one lobe, in two channels."""
    made = Microfacet(np.array([0.02, 0.05]), np.array([[2.0, 0.5]]), np.array([alpha]), np.array([gamma]),
                      np.array([f0]), (kind,))
    return replace(made, across=np.array([DIP]), turn=np.array([TURN])) if kind == "fibre" else made


def test_every_kind_has_a_formula_here():
    assert set(FORMULAS) == set(KINDS)


@pytest.mark.parametrize("width", ALPHA)
@pytest.mark.parametrize("kind", KINDS)
def test_a_lobe_is_its_formula(pairs, kind, width):
    lobes = model(kind, ALPHA[width])
    expected = [[kd + ks * FORMULAS[kind](unit_vectors(*pair[:2]), unit_vectors(*pair[2:]), ALPHA[width], 2.5, FRESNEL)
                 for kd, ks in zip(lobes.kd, lobes.ks[0], strict=True)] for pair in zip(*pairs, strict=True)]
    np.testing.assert_allclose(lobes.evaluate(*pairs), expected, rtol=1e-8)


def test_lobes_add_and_are_mirrors_unless_told(pairs):
    three = Microfacet(np.array([0.1]), np.array([[2.0], [0.3], [0.5]]), np.array([0.1, 0.5, 0.9]),
                       np.array([2.0, 3.0, NO_GAMMA]), np.array([0.05, 0.4, 1.0]), ("mirror", "retro", "sheen"))
    alone = [Microfacet(np.zeros(1), three.ks[k:k + 1], three.alpha[k:k + 1], three.gamma[k:k + 1], three.f0[k:k + 1],
                        three.kinds[k:k + 1]).evaluate(*pairs) for k in range(MAX_PRIOR_LOBES)]
    np.testing.assert_allclose(three.evaluate(*pairs), 0.1 + sum(alone), rtol=1e-12)
    old = Microfacet(np.zeros(1), three.ks[:2], three.alpha[:2], three.gamma[:2], three.f0[:2])
    assert old.kinds == ("mirror", "mirror")


@pytest.mark.parametrize("name", MADE_FITS)
def test_a_prior_is_reciprocal_finite_and_not_negative(pairs, name):
    prior = MADE_FITS[name].transform.prior
    theta = np.concatenate([pairs[0], [np.pi / 2] * 3]), np.concatenate([pairs[2], [np.pi / 2, np.pi / 2, 0]])
    phi = np.concatenate([pairs[3], [0, np.pi, 1]])
    there, back = prior.evaluate(theta[0], 0, theta[1], phi), prior.evaluate(theta[1], phi, theta[0], 0)
    np.testing.assert_allclose(there, back, rtol=1e-9)
    assert np.isfinite(there).all()
    assert (there >= 0).all()


def test_the_bytes_of_a_prior_are_its_numbers_and_kinds():
    assert model("retro", 0.1).nbytes == 4 * (2 + 2 + 1 + 1 + 1) + 1
