"""Isotropic materials of EPFL's Realistic Graphics Lab (.bsdf), measured by an adaptive gonio-photometer.

Measured by J. Dupuy, W. Jakob: An Adaptive Parameterization for Efficient Material Acquisition and Rendering, ACM TOG
37(6), 2018. Owner's page: https://rgl.epfl.ch/materials

Layout: arrays in a `tensor_file`; theta_i is irregular, and directions are points of a unit square,
u = (sqrt(2 theta / pi), (phi + pi) / (2 pi)), with u_y along the rows of a table ::

    phi_i (1), theta_i (T)      angles of incidence, radians
    ndf, sigma (m, n)           density of the microfacets' normals, and their area seen from a direction
    vndf (1, T, m, n)           density of the half vectors: the more, the finer the grid is there
    rgb (1, T, 3, N, N), or spectra (1, T, bands, N, N) and wavelengths (bands) in nm
    luminance (1, T, N, N), jacobian (1), description; valid says which nodes are above the horizon

The grid is one of half vectors: the place s of a half vector is what `rgl_warp` makes of it by vndf, and ::

    f cos theta_o = rgb(s) ndf(u_h) / (4 sigma(u_i))

(without the last factor where jacobian is 0). So the file is a function, `RglTable`, and the samples are its values at
the nodes of the grid that are above the horizon. All nodes of a column where the half vector is the normal are one
direction: the sample is their mean. The angles of incidence may be 30 degrees apart, across which a highlight changes
more than any fit can guess, and the grid is wide where ndf is not even: further samples are the function's values
between, at angles of incidence at most 4 degrees apart, and at outgoing directions that are spread evenly, of which the
grid of a gloss has few.

Limits: anisotropic materials are refused. Values may be negative (out of the gamut of sRGB), and stay so; those at
theta_i = 90 degrees are the authors' extrapolation, and so are samples between it and the last measured angle.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..arrays import ArrayLike, BoolArray, FloatArray, IntArray
from ..errors import DatasetError
from ..samples import HORIZON, LARGEST_VALUE, RGB, Samples
from . import rgl_warp, tensor_file
from .format import Format
from .reading import BY_DEFAULT, Reading
from .rgl_warp import Warp, cell
from .spectra import srgb_weights, to_linear_srgb
from .text import decode

LARGEST = 64 << 20          # bytes; a spectral file has up to 15 million
_NEEDED = ("phi_i", "theta_i", "sigma", "ndf", "vndf", "luminance", "jacobian")
_STEP = np.radians(4)       # between the angles of incidence of the samples, at most
_LAST_MEASURED = np.radians(89)     # at most; what is tabulated beyond is an extrapolation
_EVENLY = 24                # squared: directions of each angle of incidence that are spread evenly, at most
_MOST_BETWEEN = 300_000     # samples between the nodes, about; a file of 32 x 32 nodes has 39,000
_LOWEST = 1e-6              # cosine of theta_o below which a direction is on the horizon, where f is not defined


@dataclass(frozen=True, eq=False)
class RglTable:
    """The BRDF that a file defines, between its measurements too, as the authors' reader evaluates it.

    Attributes
    ----------
    theta_i : (T,) float64
        Tabulated angles of incidence, radians.
    ndf, sigma : (m, n) float64
        Over the unit square of directions.
    warp : Warp
        From half vectors to the grid, a slice for each angle of incidence.
    values : (T, N, N, 3) float64
        Linear sRGB of f cos theta_o, divided by the Jacobian if that is used.
    has_jacobian : bool
    name : str
        What was measured.
    notes : tuple of str
        What reading made of the file.
    """

    theta_i: FloatArray
    ndf: FloatArray
    sigma: FloatArray
    warp: Warp
    values: FloatArray
    has_jacobian: bool
    name: str
    notes: tuple[str, ...] = ()

    def evaluate(self, theta_i: ArrayLike, phi_i: ArrayLike, theta_o: ArrayLike, phi_o: ArrayLike) -> FloatArray:
        """The BRDF: (n,) radians each to (n, 3), 1/sr, without the cosine; 0 below the horizon.

        Beyond the tabulated angles of incidence it is that of the nearest one. Values may be negative.
        """
        theta_i, phi_i, theta_o, phi_o = (np.asarray(angle, dtype=float)
                                          for angle in np.broadcast_arrays(theta_i, phi_i, theta_o, phi_o))
        turn = phi_o - phi_i
        x = np.sin(theta_i) + np.sin(theta_o) * np.cos(turn)
        y = np.sin(theta_o) * np.sin(turn)
        theta_h = np.arctan2(np.hypot(x, y), np.cos(theta_i) + np.cos(theta_o))
        u_x, u_y = _square(theta_h, np.arctan2(y, x))
        after = np.clip(np.searchsorted(self.theta_i, theta_i, side="right"), 1, len(self.theta_i) - 1)
        index = after - 1
        weight = np.clip((theta_i - self.theta_i[index]) / (self.theta_i[after] - self.theta_i[index]), 0, 1)
        s_x, s_y = rgl_warp.to_grid(self.warp, index, weight, u_x, u_y)
        value = ((1 - weight)[:, None] * _bilinear(self.values, s_x, s_y, index)
                 + weight[:, None] * _bilinear(self.values, s_x, s_y, after))
        return value * self._factor(theta_i, theta_o, u_x, u_y)[:, None]

    def _factor(self, theta_i: FloatArray, theta_o: FloatArray, u_x: FloatArray, u_y: FloatArray) -> FloatArray:
        """What the table's values are multiplied with to be f: (n,); u is the half vector's."""
        cosine = np.cos(theta_o)
        above = (cosine > _LOWEST) & (theta_i <= HORIZON)
        factor = np.divide(1, cosine, out=np.zeros_like(cosine), where=above)
        if self.has_jacobian:
            factor *= _bilinear(self.ndf, u_x, u_y) / (4 * _bilinear(self.sigma, *_square(theta_i, 0 * theta_i)))
        return factor

    def nodes(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """The measured directions above the horizon, and the BRDF there.

        Returns
        -------
        theta_i, theta_o, phi_o : (n,) float64
            Radians; phi_i is 0.
        values : (n, 3) float64
            1/sr.
        """
        parts = []
        for index, theta in enumerate(np.minimum(self.theta_i, HORIZON)):
            u_x, u_y = self._half_vectors(index)
            value = self.values[index, :-1].copy()
            value[:, 0] = value[:, 0].mean(axis=0)
            theta_i, theta_o, phi_o, kept = self._above(theta, u_x, u_y)
            factor = self._factor(theta_i, theta_o, u_x[kept], u_y[kept])
            parts.append((theta_i, theta_o, phi_o, value[kept] * factor[:, None]))
        theta_i, theta_o, phi_o, values = (np.concatenate(part) for part in zip(*parts, strict=True))
        return theta_i, theta_o, phi_o, values

    def between(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Directions between the nodes, and between the angles of incidence, and the BRDF there; as `nodes`.

        The grid is halved from the normal outward, and the half vectors are those of the nearest angle of incidence, on
        one side of the plane of incidence. Besides there are outgoing directions that are spread evenly.
        """
        theta_i, size = np.minimum(self.theta_i, HORIZON), self.values.shape[1]
        steps = np.maximum(np.ceil(np.append(np.diff(theta_i), 0) / _STEP), 1).astype(int)
        thin = max(int(np.ceil(size * np.sqrt(steps.sum() / _MOST_BETWEEN))), 1)
        x, y = np.arange(1, 2 * size - 1, thin) / (2 * size - 2), np.arange(0, size // 2, thin) / (size - 1)
        evenly = _evenly_spread(min(size, _EVENLY))
        parts = []
        for index, count in enumerate(steps.tolist()):
            for step in range(count):
                u_x, u_y = rgl_warp.from_grid(self.warp, index + (2 * step > count), x, y)
                if not step and thin == 1:
                    u_x = u_x[:, ::2]       # the others are nodes
                theta = theta_i[index] + (step / count * (theta_i[index + 1] - theta_i[index]) if step else 0)
                parts.append(self._above(theta, u_x, np.broadcast_to(u_y[:, None], u_x.shape))[:3])
                parts.append((np.full(len(evenly[0]), theta), *evenly))
        incident, theta_o, phi_o = (np.concatenate(part) for part in zip(*parts, strict=True))
        return incident, theta_o, phi_o, self.evaluate(incident, np.zeros_like(incident), theta_o, phi_o)

    def _half_vectors(self, index: int) -> tuple[FloatArray, FloatArray]:
        """The nodes of the grid for an angle of incidence, in the unit square: (N - 1, N) each."""
        size = self.values.shape[1]
        step = np.arange(size) / (size - 1)
        u_x, u_y = rgl_warp.from_grid(self.warp, index, step, step[:-1])    # the last row is the first, 2 pi on
        u_x[:, 0] = 0
        return u_x, np.broadcast_to(u_y[:, None], u_x.shape)

    @staticmethod
    def _above(theta: float, u_x: FloatArray, u_y: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, BoolArray]:
        """theta_i, theta_o and phi_o of the half vectors that reflect above the horizon, (n,); and which these are.

        Of a column where the half vector is the normal, the first.
        """
        theta_i = np.full_like(u_x, theta)
        theta_o, phi_o = _reflected(theta_i, u_x ** 2 * HORIZON, (2 * u_y - 1) * np.pi)
        kept = np.cos(theta_o) > _LOWEST
        kept[1:] &= u_x[1:] > 0
        return theta_i[kept], theta_o[kept], phi_o[kept], kept


def recognises(content: bytes) -> bool:
    r"""Whether the file begins with the name of the container.

    Examples
    --------
    >>> recognises(b"tensor_file\0\1\0"), recognises(b"#Data Generated by Zemax")
    (True, False)
    """
    return content.startswith(tensor_file.MAGIC)


def read(path: str | Path, content: bytes, reading: Reading = BY_DEFAULT) -> Samples:
    """Read a .bsdf file: its values at the nodes of its grid and between; spectra become linear sRGB.

    Returns
    -------
    Samples

    Raises
    ------
    DatasetError
        If the file is damaged, lacks an array, or holds an anisotropic material.
    """
    table = read_table(path, content, reading)
    nodes, between = table.nodes(), table.between()
    theta_i, theta_o, phi_o, values = (np.concatenate(pair) for pair in zip(nodes, between, strict=True))
    count = len(nodes[0])
    if not count:
        raise DatasetError("no measurement above the horizon", path)
    note = (f"{count:,} nodes at {len(table.theta_i)} angles of incidence, {len(values) - count:,} between by the "
            f"interpolation that the file defines")
    if table.theta_i[-1] > _LAST_MEASURED:
        note += f"; beyond {np.degrees(table.theta_i[-2]):.0f} degrees it is the authors' extrapolation"
    return Samples(theta_i, np.zeros_like(theta_i), theta_o, phi_o, values, RGB, table.name, str(path),
                   (note, *table.notes))


def read_table(path: str | Path, content: bytes, reading: Reading = BY_DEFAULT) -> RglTable:
    """Read a .bsdf file as the function that it defines; raises `DatasetError` as `read` does."""
    fields = tensor_file.read(content, path)
    colour = "spectra" if "spectra" in fields else "rgb"
    needed = (*_NEEDED, colour, *(["wavelengths"] if colour == "spectra" else []))
    missing = [name for name in needed if name not in fields]
    if missing:
        raise DatasetError(f"no array {', '.join(missing)}; expected those of an RGL material, {', '.join(needed)}",
                           path)
    azimuths, angles = fields["phi_i"].size, fields["theta_i"].size
    if azimuths > 2:
        raise DatasetError(f"an anisotropic material ({azimuths} azimuths phi_i found, expected 1): anisotropic "
                           f"measurements cannot be used yet", path)
    for name, leading in (("phi_i", (azimuths,)), ("theta_i", (angles,)), ("sigma", (None, None)),
                          ("ndf", (None, None)), ("vndf", (azimuths, angles, None, None)),
                          ("luminance", (azimuths, angles, None, None)), ("jacobian", (1,)),
                          (colour, (azimuths, angles, None, None, None))):
        _check_shape(fields[name], name, leading, path)
    return _table(path, fields, colour, reading)


def _table(path: str | Path, fields: dict[str, NDArray[Any]], colour: str, reading: Reading) -> RglTable:
    """The table of arrays whose shapes have been checked."""
    theta_i = _finite(fields["theta_i"], "theta_i", path)
    if len(theta_i) < 2 or (np.diff(theta_i) <= 0).any() or theta_i[0] < 0 or theta_i[-1] > HORIZON + 1e-5:
        raise DatasetError("theta_i must hold at least two rising angles from 0 to pi/2 radians", path)
    ndf, sigma, density = (_finite(fields[name], name, path) for name in ("ndf", "sigma", "vndf"))
    if ndf.min() < 0 or sigma.min() <= 0 or density.min() < 0 or not (density.sum(axis=(-2, -1)) > 0).all():
        raise DatasetError("ndf, sigma and vndf must not be negative, nor sigma or a slice of vndf zero", path)
    channels, size = fields[colour].shape[2:4]
    if size != fields[colour].shape[4]:
        raise DatasetError(f"{colour} has the shape {fields[colour].shape}, expected square tables", path)
    if colour == "rgb" and channels != len(RGB):
        raise DatasetError(f"rgb has {channels} channels, expected {len(RGB)}", path)
    for name in ("vndf", colour):
        if not np.array_equal(fields[name][0], fields[name][-1]):
            raise DatasetError(f"an anisotropic material ({name} differs with the azimuth phi_i): anisotropic "
                               f"measurements cannot be used yet", path)
    weights = (np.eye(len(RGB)) if colour == "rgb" else
               _weights(fields["wavelengths"], channels, path, reading.illuminant))
    values = np.zeros((len(theta_i), size, size, len(RGB)))
    for band, plane in enumerate(np.moveaxis(fields[colour][0], 1, 0)):     # one at a time, to save memory
        values += _finite(plane, colour, path)[..., None] * weights[:, band]
    name = decode(fields["description"].tobytes()).strip() if "description" in fields else ""
    return RglTable(theta_i, ndf, sigma, rgl_warp.warp(density[0]), values, bool(fields["jacobian"][0]),
                    name if name and name.isprintable() else Path(path).stem,
                    reading.notes if colour == "spectra" else ())


def _check_shape(array: NDArray[Any], name: str, expected: tuple[int | None, ...], path: str | Path) -> None:
    """Raise `DatasetError` unless the array has these dimensions; None stands for any number from 2."""
    if array.ndim != len(expected) or not all(size >= 2 if wanted is None else size == wanted
                                              for size, wanted in zip(array.shape, expected, strict=True)):
        shown = ", ".join("2 or more" if wanted is None else str(wanted) for wanted in expected)
        raise DatasetError(f"{name} has the shape {array.shape}, expected ({shown})", path)


def _finite(array: NDArray[Any], name: str, path: str | Path) -> FloatArray:
    numbers = array.astype(float)
    if not (np.abs(numbers) <= LARGEST_VALUE).all():
        raise DatasetError(f"{name} holds numbers that are not finite, or larger than {LARGEST_VALUE:g}", path)
    return numbers


def _weights(wavelengths: NDArray[Any], bands: int, path: str | Path, illuminant: str) -> FloatArray:
    """The matrix from spectra to linear sRGB: (3, bands)."""
    _check_shape(wavelengths, "wavelengths", (bands,), path)
    wavelengths = _finite(wavelengths, "wavelengths", path)
    to_linear_srgb(wavelengths, np.zeros((1, bands)), path)         # refuses wavelengths that make no colour
    return srgb_weights(wavelengths, illuminant)


def _evenly_spread(count: int) -> tuple[FloatArray, FloatArray]:
    """theta_o and phi_o of directions spread evenly by their cosine over half of the hemisphere: (count^2,) each."""
    step = (np.arange(count) + 0.5) / count
    theta_o, phi_o = np.meshgrid(np.arcsin(np.sqrt(step)), step * np.pi, indexing="ij")
    return theta_o.ravel(), phi_o.ravel()


def _square(theta: FloatArray, phi: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The point of the unit square for a direction; phi = pi is where phi = -pi is."""
    u_y = (phi + np.pi) / (2 * np.pi)
    return np.sqrt(np.clip(theta / HORIZON, 0, 1)), u_y - np.floor(u_y)


def _bilinear(table: FloatArray, u_x: FloatArray, u_y: FloatArray, index: IntArray | None = None) -> FloatArray:
    """Interpolate a table (rows, columns, ...), or slice `index` of (slices, rows, columns, ...)."""
    at: tuple[IntArray, ...] = () if index is None else (index,)
    rows, columns = table.shape[len(at):len(at) + 2]
    (i, a), (j, b) = cell(u_x, columns), cell(u_y, rows)
    extra = (slice(None), *[None] * (table.ndim - len(at) - 2))
    a, b = a[extra], b[extra]
    return ((1 - b) * ((1 - a) * table[(*at, j, i)] + a * table[(*at, j, i + 1)])
            + b * ((1 - a) * table[(*at, j + 1, i)] + a * table[(*at, j + 1, i + 1)]))


def _reflected(theta_i: FloatArray, theta_h: FloatArray, phi_h: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The direction (theta_o, phi_o) into which half vectors mirror (theta_i, 0); theta_o up to pi."""
    x, y, z = np.sin(theta_h) * np.cos(phi_h), np.sin(theta_h) * np.sin(phi_h), np.cos(theta_h)
    cosine = np.sin(theta_i) * x + np.cos(theta_i) * z
    x, y, z = 2 * cosine * x - np.sin(theta_i), 2 * cosine * y, 2 * cosine * z - np.cos(theta_i)
    return np.arctan2(np.hypot(x, y), z), np.arctan2(y, x)


FORMAT = Format("RGL", "RGL .bsdf", (".bsdf",), recognises, read, ("illuminant",), is_text=False, largest=LARGEST)
