"""RGL materials made for tests: small, in the container of the real ones, and known in closed form."""

import struct

import numpy as np

_KINDS = {"u1": 1, "u4": 5, "f2": 9, "f4": 10, "f8": 11}


def pack(arrays):
    """The bytes of a tensor file: {name: array}."""
    head = 18 + sum(13 + len(name) + 8 * np.ndim(array) for name, array in arrays.items())
    table, data = b"tensor_file\0\1\0" + struct.pack("<I", len(arrays)), b""
    for name, array in arrays.items():
        data += bytes(-(head + len(data)) % 8)
        kind = _KINDS[array.dtype.str[1:]]
        table += struct.pack(f"<H{len(name)}sHBQ{array.ndim}Q", len(name), name.encode(), array.ndim, kind,
                             head + len(data), *array.shape)
        data += array.tobytes()
    return table + data


def material(size=4, angles=(0.1, 0.7, 1.3), seed=None):
    """The arrays of an isotropic RGL file.

    With a seed its tables are random; without one all microfacets' densities are 1, and so the grid is the unit square
    of half vectors, where rgb is (0.5 + 0.25 x + 0.125 y, 1 + theta_i, 0.75).
    """
    x, y = np.meshgrid(*[np.linspace(0, 1, size)] * 2)
    planes = [np.stack([0.5 + 0.25 * x + 0.125 * y, np.full_like(x, 1 + angle), np.full_like(x, 0.75)])
              for angle in angles]
    arrays = {"version": np.array([1, 0]), "description": np.frombuffer(b"Made of lead", "u1"), "phi_i": np.zeros(1),
              "theta_i": np.array(angles), "sigma": np.ones((2, 5)), "ndf": np.full((2, 5), 2.0),
              "vndf": np.ones((1, len(angles), 5, 6)), "luminance": np.ones((1, len(angles), size, size)),
              "rgb": np.array(planes)[None], "jacobian": np.array([1], "u1"),
              "valid": np.full(len(angles) * size * size, 255, "u1")}
    if seed is not None:
        random = np.random.default_rng(seed)
        for name in ("sigma", "ndf", "vndf", "rgb"):
            arrays[name] = 0.1 + random.random(arrays[name].shape)
    types = {"version": "u4", "description": "u1", "jacobian": "u1", "valid": "u1"}
    return {name: array.astype("<" + types.get(name, "f4")) for name, array in arrays.items()}


def anisotropic(arrays, azimuths=(-180, -135, -90), seed=None):
    """The arrays of an anisotropic material at these azimuths, degrees, of an isotropic one's.

    With a seed each azimuth has random tables; without one they are all alike.
    """
    of_azimuth = {name: np.repeat(arrays[name], len(azimuths), axis=0) for name in ("vndf", "luminance", "rgb")}
    if seed is not None:
        random = np.random.default_rng(seed)
        of_azimuth = {name: (0.5 + random.random(array.shape)).astype("<f4") for name, array in of_azimuth.items()}
    return arrays | of_azimuth | {"phi_i": np.radians(azimuths).astype("<f4")}


def spectral(arrays, wavelengths):
    """The same material with spectra instead of rgb: flat ones, of the height of its green channel."""
    green = arrays["rgb"][:, :, 1:2]
    spectra = {"wavelengths": np.asarray(wavelengths, "<f4"), "spectra": np.repeat(green, len(wavelengths), axis=2)}
    return {name: array for name, array in arrays.items() if name != "rgb"} | spectra
