"""Fits of the starter library that are made beforehand (`tools.ready_fits`), with their closure nodes and the closest
Principled BSDF; where there is none, it is made when it is wanted.

The levels are lower than those of Standard: a published model has no noise and no detail beyond its lobe, and errors
between its samples are about the same.
"""

from dataclasses import fields
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .. import methods
from ..cycles.node_lobes import Shape
from ..cycles.node_mixture import NodeMixture, Nodes, Sampling, node_mixtures, subsurface_walk
from ..cycles.principled import principled
from ..cycles.principled_bsdf import Principled
from ..errors import DatasetError
from ..methods import regression_kriging
from ..methods.levels import Levels
from ..model import published
from ..model.conductor import Conductor
from ..model.fit import Fit
from ..storage import files, npz

PRESET = "Standard"         # whose method it is
ARGUMENTS: dict[str, Any] = {"diffuse_level": 3, "specular_level": 4, "compression": 92.5, "method": "kriging"}
FOLDER = Path(__file__).parents[2] / "starter_library" / "fits"
_INPUT_NAMES = [field.name for field in fields(Principled)]
_ENGINES = "cycles", "eevee"
_OF_MIXTURE = "kinds", "errors", "colours", "table"
_INPUT_WIDTHS = 3, 1, 1, 1, 3, 1, 1, 1  # of the inputs


class Ready(NamedTuple):
    """A fit, its closure nodes, and the Principled BSDF that is closest to it."""

    fit: Fit
    nodes: Nodes
    principled: Principled


def is_there(name: str) -> bool:
    """Whether the fit of a published material has been made beforehand."""
    return _path(name).is_file()


def find(name: str) -> Ready:
    """The fit of a published material: read, or made where it has not been made beforehand.

    Raises DatasetError if there is no material of this name, or its file is damaged.
    """
    published.find(name)
    return read(_path(name)) if is_there(name) else make(name)


def make(name: str) -> Ready:
    """Fit a published material, in linear Rec.709. Raises DatasetError if there is none of this name."""
    made = fit(name)
    return Ready(made, node_mixtures(made), principled(made))


def fit(name: str) -> Fit:
    """The fit that `make` makes, without what belongs to it."""
    model, samples = published.find(name).model, published.load_published(name)
    if not isinstance(model, Conductor):
        return methods.fit(samples, **ARGUMENTS)
    levels = Levels(ARGUMENTS["diffuse_level"], ARGUMENTS["specular_level"], ARGUMENTS["compression"])
    # all but its Fresnel term is known
    return regression_kriging.fit(samples, levels, estimated=regression_kriging.estimate(samples, model.lobes))


def write(made: Ready, path: str | Path) -> None:
    """Write a fit of three channels into a file, and what belongs to it in single precision."""
    arrays: dict[str, NDArray[Any]] = {
        "fit": np.frombuffer(made.fit.to_bytes(), np.uint8),
        "principled": np.hstack([getattr(made.principled, name) for name in _INPUT_NAMES]).astype(np.float32)}
    for engine, mixture in zip(_ENGINES, (made.nodes.cycles, made.nodes.eevee), strict=True):
        columns = [mixture.theta, *mixture.shape, *(mixture.sampling or ())[1:]]
        colours = [mixture.colour, *(mixture.sampling or ())[:1]]
        arrays |= {f"{engine}_kinds": np.array(mixture.kinds),
                   f"{engine}_errors": np.array([mixture.error, mixture.worst, mixture.albedo_error,
                                                np.nan if mixture.turn is None else mixture.turn]),
                   f"{engine}_colours": np.stack(colours).astype(np.float32),
                   f"{engine}_table": np.hstack([column.reshape(len(mixture.theta), -1)
                                                 for column in columns]).astype(np.float32)}
    with files.replace_file(path) as stream:
        stream.write(npz.to_bytes(arrays))


def read(path: str | Path) -> Ready:
    """Read a file that `write` wrote. Raises DatasetError if it is damaged."""
    try:
        arrays = npz.read(files.read_bytes(path, npz.LARGEST_ARCHIVE))
        made = Fit.from_bytes(arrays["fit"].tobytes())
        cycles, eevee = (_mixture(*(arrays[f"{engine}_{name}"] for name in _OF_MIXTURE)) for engine in _ENGINES)
        return Ready(made, Nodes(cycles, eevee, subsurface_walk(made)), _principled(arrays["principled"]))
    except (ValueError, KeyError) as error:
        raise DatasetError(f"a damaged fit of the starter library: {error}", path) from error


def _mixture(kinds: NDArray[Any], errors: NDArray[Any], colours: NDArray[Any], table: NDArray[Any]) -> NodeMixture:
    lobes = len(kinds)
    channels = colours.shape[-1]
    # of the columns that `write` writes
    sampled = (lobes + 1, 1, channels, channels, channels)
    widths = 1, lobes, lobes, lobes, *(sampled if len(colours) > 1 else len(sampled) * (0,))
    if table.shape[1] != sum(widths):
        raise ValueError(f"a mixture of {table.shape[1]} columns found, expected {sum(widths)}: `make zip` makes it")
    theta, *shape, shares, probability, albedo, left, balance = np.split(table.astype(float), np.cumsum(widths)[:-1],
                                                                         axis=1)
    colour, *below = colours.astype(float)
    *found, turn = errors.tolist()
    sampling = Sampling(below[0], shares, probability[:, 0], albedo, left, balance) if below else None
    return NodeMixture(tuple(kinds.tolist()), theta[:, 0], Shape(*shape), colour,
                       None if np.isnan(turn) else turn, sampling, *found)


def _principled(numbers: NDArray[Any]) -> Principled:
    base, roughness, metallic, level, tint, *others = np.split(numbers.astype(float), np.cumsum(_INPUT_WIDTHS)[:-1])
    return Principled(base, float(roughness[0]), float(metallic[0]), float(level[0]), tint,
                      *(float(each[0]) for each in others))


def _path(name: str) -> Path:
    return FOLDER / f"{name}.npz"
