"""The published parameters of the microfacet model of J. Low and others (`model.low2012`), from a file of them."""

import json
from pathlib import Path

import numpy as np

from ...model.low2012 import Low2012


def published(path: str | Path, name: str) -> Low2012:
    """The published parameters of a material of MERL.

    Parameters
    ----------
    path : path-like
        A JSON file, whose `materials` have kd, A, B, C and eta.
    name : str

    Returns
    -------
    Low2012

    Raises
    ------
    ValueError
        If there is no material of this name.
    """
    materials = json.loads(Path(path).read_text("utf-8"))["materials"]
    if name not in materials:
        raise ValueError(f"no material {name!r} in {path}; expected one of {', '.join(materials)}")
    found = materials[name]
    return Low2012(np.array(found["kd"]), np.array(found["A"]), found["B"], found["C"], found["eta"])
