"""What panels ask about measurements and fits. Every answer comes from a worker."""

from functools import partial
from typing import Any

import bpy

from ..annotations import Arguments
from ..materials.reading import load_arguments
from . import icons, queue, tasks
from .job import Job

_RECHECK = 5.0              # seconds after which the file of a shown material is read again


def data(material: bpy.types.Material) -> Job[tasks.Data]:
    """The job that reads the file of a material."""
    settings = material.measured_brdf
    path = bpy.path.abspath(settings.filepath, library=material.library)
    how = load_arguments(settings)
    return queue.ask(_data_key(path, settings.sample, how), partial(tasks.read, path, settings.sample, how=how), "read",
                     max_age=_RECHECK)


def cost(measured: tasks.Data, arguments: Arguments) -> tuple[Job[tasks.Fitted], Job[float]]:
    """The job that fits, and the one that finds the RMSE at held-out samples."""
    held = queue.ask(_key("held out", measured, arguments), partial(tasks.held_out_of, measured, arguments), "slow")
    found = queue.ask(_key("fit", measured, arguments), partial(tasks.fitted_of, measured, arguments))
    return found, held


def known_fit(path: str, sample: str, how: Arguments, arguments: Arguments) -> tuple[str, tasks.Fitted] | None:
    """A fit that a panel has asked for before, with the digest of its measurements; else None."""
    measured = queue.known(_data_key(path, sample, how))
    found = None if measured is None else queue.known(_key("fit", measured, arguments))
    return None if found is None else (measured.digest, found)


def lit_sphere(measured: tasks.Data, arguments: Arguments) -> tuple[int, Job[Any]]:
    """The icon of the lit sphere, and the job that draws it."""
    return icons.icon(_key("sphere", measured, arguments), partial(tasks.lit_sphere, measured, arguments))


def polar_plot(measured: tasks.Data, arguments: Arguments, theta_i: float,
               phi_i: float = 0.0) -> tuple[int, Job[Any]]:
    """The icon of the polar plot at an angle of incidence and an azimuth of the light (radians), and the job that draws
    it."""
    theta_i, phi_i = round(theta_i, 3), round(phi_i, 3)
    return icons.icon((*_key("polar", measured, arguments), theta_i, phi_i),
                      partial(tasks.polar_plot, measured, arguments, theta_i, phi_i))


def turned_plane(measured: tasks.Data, arguments: Arguments, theta_i: float) -> tuple[int, Job[Any]]:
    """The icon of the plane of incidence, turned, at an angle of incidence (radians), and the job that draws it."""
    theta_i = round(theta_i, 3)
    return icons.icon((*_key("turned", measured, arguments), theta_i),
                      partial(tasks.turned_plane, measured, arguments, theta_i))


def errors_by_level(measured: tasks.Data, arguments: Arguments) -> tuple[int, Job[Any]]:
    """The icon of the plot of errors, and the job that draws it."""
    return icons.icon(_key("levels", measured, arguments), partial(tasks.errors_by_level, measured, arguments), "slow")


def _data_key(path: str, sample: str, how: Arguments) -> tuple[str, ...]:
    return "data", path, sample, tasks.freeze(how)


def _key(kind: str, measured: tasks.Data, arguments: Arguments) -> tuple[str, str, str]:
    return kind, measured.digest, tasks.freeze(arguments)
