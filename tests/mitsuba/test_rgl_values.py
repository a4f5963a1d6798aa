"""RGL's files as Mitsuba's own BSDF `measured` evaluates them, beside `RglTable`: `make test-mitsuba`."""

import numpy as np
import pytest

from fitter.formats import rgl
from support.checkout import measurements

mi = pytest.importorskip("mitsuba", reason="Mitsuba is absent; `make test-mitsuba` installs it")
FILES = sorted((measurements() / "rgl").glob("*_rgb.bsdf"))
ISOTROPIC = [path for path in FILES if not path.stem.startswith("synthetic")]


@pytest.fixture(scope="module")
def directions():
    """Angles up to 80 degrees, half of them about the mirror direction: four (n,), radians."""
    random = np.random.default_rng(0)
    theta_i, theta_o = np.radians(80) * np.sqrt(random.random((2, 4000)))
    phi_i, phi_o = 2 * np.pi * random.random((2, 4000))
    near = slice(0, 2000)
    theta_o[near] = np.abs(theta_i[near] + 0.1 * random.standard_normal(2000))
    phi_o[near] = phi_i[near] + np.pi + 0.1 * random.standard_normal(2000)
    below = theta_o < np.radians(80)
    return theta_i[below], phi_i[below], theta_o[below], phi_o[below]


def unit(theta, phi):
    return np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])


@pytest.mark.skipif(not ISOTROPIC, reason="no RGL files at hand")
@pytest.mark.parametrize("path", ISOTROPIC, ids=lambda path: path.stem)
def test_the_values_are_mitsubas(path, directions):
    """Mitsuba computes in single precision; values are compared where f cos theta_o exceeds a thousandth."""
    mi.set_variant("llvm_ad_rgb")
    theta_i, phi_i, theta_o, phi_o = directions
    bsdf = mi.load_dict({"type": "measured", "filename": str(path)})
    surface = mi.SurfaceInteraction3f()
    surface.wi = mi.Vector3f(unit(theta_i, phi_i).astype(np.float32))
    theirs = np.array(bsdf.eval(mi.BSDFContext(), surface, mi.Vector3f(unit(theta_o, phi_o).astype(np.float32)))).T
    ours = rgl.read_table(path, path.read_bytes()).evaluate(*directions) * np.cos(theta_o)[:, None]
    bright = (np.abs(theirs) > 1e-3) | (np.abs(ours) > 1e-3)
    assert bright.mean() > 0.5
    np.testing.assert_allclose(ours[bright], theirs[bright], rtol=1e-3)
