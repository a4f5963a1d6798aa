"""Synthetic measurements in the formats and geometries of the real ones, from a published analytic fit.

The fit is that of a blue house paint by E. P. F. Lafortune, S. C. Foo, K. E. Torrance, D. P. Greenberg: Non-Linear
Approximation of Reflectance Functions, SIGGRAPH 1997: a Lambertian and three cosine lobes a channel. Everything made
here says "synthetic" in its name.
"""

import numpy as np

from fitter.formats.curet import geometry

from .checkout import ROOT, has_measurements, measurements
from .hard_cases import gloss

# by channel: the diffuse albedo, and Cxy, Cz and n of each lobe
_RHO = np.array([0.3094, 0.39667, 0.70837])
_LOBES = np.array([
    [[0.870567, 0.857255, 0.670982], [0.803624, 0.774290, 0.586674], [21.820103, 18.597755, 7.472717]],
    [[-0.451218, -0.406681, -0.477976], [0.023123, 0.017625, 0.227295], [2.774499, 2.581499, 3.677653]],
    [[-1.031545, -1.029426, -1.026588], [0.706734, 0.696530, 0.687715], [66.899060, 63.767912, 57.489181]]])
CURET_CHANNELS = {1: 0, 5: 1, 15: 2}        # the paint's red, green and blue stand in for felt, leather and foil


def blue_house_paint(theta_i, phi_i, theta_o, phi_o):
    """The paint's BRDF, 1/sr: angles (n,) in radians to (n, 3)."""
    along = (np.sin(theta_i) * np.sin(theta_o) * np.cos(phi_o - phi_i))[:, None]
    up = (np.cos(theta_i) * np.cos(theta_o))[:, None]
    return _RHO / np.pi + sum(np.maximum(c_xy * along + c_z * up, 0) ** n for c_xy, c_z, n in _LOBES)


def measurements_or_synthetic():
    """The folder of real measurements, or where there are none, synthetic ones: (folder, whether synthetic)."""
    folder = measurements()
    if has_measurements(folder):
        return folder, False
    print(f"No measurements in {folder}: synthetic ones take their place.")
    folder = ROOT / "build" / "synthetic"
    write(folder)
    return folder, True


def write(folder):
    """Write `curet/abrdf.dat` and `cornell/krylon_blue.astm` with synthetic values below `folder`."""
    for name, text in (("curet/abrdf.dat", _curet()), ("cornell/krylon_blue.astm", _cornell())):
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)


def _curet():
    theta_v, phi_v, theta_i, phi_i = geometry().T
    values = blue_house_paint(theta_i, phi_i, theta_v, phi_v)
    return "".join(f"{number} " + " ".join(f"{value:.3f}" for value in values[:, channel]) + "\n"
                   for number, channel in CURET_CHANNELS.items())


def _cornell():
    rows = [(theta_i, 0, np.arccos(1 - (k / 10) ** 2), -j * np.radians(45 / k) if k else 0)
            for theta_i in np.radians(np.arange(10, 81, 10)) for k in range(10) for j in range(4 * k + 1)]
    directions = np.array(rows)
    values = blue_house_paint(*directions.T)
    lines = ["LAB_COMMENTS synthetic: a published Lafortune fit of a blue house paint",
             "SAMPLE_NAME synthetic blue paint", f"NUM_POINTS {len(rows)}", "VARS theta_i,phi_i,theta_s,phi_s,R,G,B"]
    return "\n".join(lines + [",".join(f"{number:.6f}" for number in row)
                              for row in np.concatenate([directions, values], axis=1)]) + "\n"


def make_files(folder, count):
    """As many CURET files of one sample each, all different: a list of paths."""
    theta_v, phi_v, theta_i, phi_i = geometry().T
    smooth = gloss(theta_i, theta_v, phi_v - phi_i)
    paths = []
    for number in range(count):
        noise = np.random.default_rng(number).normal(1, 0.05, len(smooth))
        row = " ".join([str(number % 61 + 1), *(f"{value:.3f}" for value in smooth * noise * (1 + number / count))])
        paths.append(folder / f"material{number:04d}.dat")
        paths[-1].write_text(row)
    return paths
