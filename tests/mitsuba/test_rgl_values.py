"""RGL's files as Mitsuba's own BSDF `measured` evaluates them, beside `RglTable`: `make test-mitsuba`."""

import numpy as np
import pytest

from fitter.arrays import unit_vectors
from fitter.formats import rgl
from support import tensor_files
from support.checkout import measurements

mi = pytest.importorskip("mitsuba", reason="Mitsuba is absent; `make test-mitsuba` installs it")
FILES = sorted((measurements() / "rgl").glob("*_rgb.bsdf"))
ANISOTROPIC = [path for path in FILES if path.stem.startswith("synthetic")]


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


def both(path, directions):
    """f cos theta_o by Mitsuba, which computes in single precision, and by `RglTable`: (n, 3) each."""
    mi.set_variant("llvm_ad_rgb")
    theta_i, phi_i, theta_o, phi_o = directions
    bsdf = mi.load_dict({"type": "measured", "filename": str(path)})
    surface = mi.SurfaceInteraction3f()
    surface.wi = mi.Vector3f(unit_vectors(theta_i, phi_i).T.astype(np.float32))
    outgoing = mi.Vector3f(unit_vectors(theta_o, phi_o).T.astype(np.float32))
    theirs = np.array(bsdf.eval(mi.BSDFContext(), surface, outgoing)).T
    return theirs, rgl.read_table(path.read_bytes()).evaluate(*directions) * np.cos(theta_o)[:, None]


@pytest.mark.skipif(not FILES, reason="no RGL files at hand")
@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_the_values_are_mitsubas(path, directions):
    """Values are compared where f cos theta_o exceeds a thousandth."""
    theirs, ours = both(path, directions)
    bright = (np.abs(theirs) > 1e-3) | (np.abs(ours) > 1e-3)
    assert bright.mean() > 0.5
    np.testing.assert_allclose(ours[bright], theirs[bright], rtol=1e-3)


@pytest.mark.skipif(not ANISOTROPIC, reason="no anisotropic RGL file at hand")
@pytest.mark.parametrize("count", [9, 5], ids=["half a turn", "a quarter"])
def test_symmetries_are_mitsubas(count, directions, tmp_path):
    """Of files with the first azimuths of another one; as Mitsuba continues them, whether the material is so or not.

    Where the plane of symmetry is met, either side is right: the tables differ there.
    """
    path = ANISOTROPIC[0]
    arrays = dict(rgl.read_arrays(path.read_bytes()))
    for name in ("phi_i", "vndf", "luminance", "rgb"):
        arrays[name] = np.ascontiguousarray(arrays[name][:count])
    (tmp_path / "part.bsdf").write_bytes(tensor_files.pack(arrays))
    away = np.abs(np.sin(2 * directions[1])) > 1e-5
    theirs, ours = both(tmp_path / "part.bsdf", [angle[away] for angle in directions])
    bright = (np.abs(theirs) > 1e-3) | (np.abs(ours) > 1e-3)
    assert bright.mean() > 0.5
    np.testing.assert_allclose(ours[bright], theirs[bright], rtol=1e-3)
