"""What panels ask about two materials. Workers answer, from the fits in the materials' shaders."""

from functools import partial
from typing import Any

import bpy
import numpy as np

from ...fitter.drawing import Color
from ...fitter.pictures import SIZE
from ..core.annotations import present
from ..work import icons, queries, queue
from ..work.job import Job
from . import work as comparisons


def figures(material: bpy.types.Material) -> Job[comparisons.Figures]:
    """The job that finds the numbers of a measured material."""
    found = present(queries.kept(material))
    return queue.ask(("figures", found.digest), partial(comparisons.figures, found))


def split_sphere(left: bpy.types.Material, right: bpy.types.Material, at: float) -> tuple[int, Job[Any]]:
    """The icon of a sphere of two measured materials with a line between them, and the job that draws it."""
    one, other, at = present(queries.kept(left)), present(queries.kept(right)), round(at, 2)
    return icons.icon(("split", (one.digest, other.digest), at),
                      partial(comparisons.split_sphere, one, other, at, SIZE))


def polar(first: bpy.types.Material, second: bpy.types.Material, theta_i: float) -> tuple[int, Job[Any]]:
    """The icon of the polar plot of two measured materials at an angle of incidence (radians), and its job."""
    one, other, theta_i = present(queries.kept(first)), present(queries.kept(second)), round(theta_i, 3)
    return icons.icon(("polar of two", (one.digest, other.digest), theta_i),
                      partial(comparisons.polar, one, other, theta_i, SIZE))


def swatch(color: Color) -> int:
    """The icon of a plain colour."""
    return icons.at_once(("swatch", color), lambda: np.full((16, 16, 4), (*color, 1), dtype=np.float32))
