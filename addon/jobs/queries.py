"""What panels ask about measurements and the choices for their fit. Each answer is worked out in the background."""

from functools import partial

import bpy

from . import icons, queue, tasks

_RECHECK = 5.0              # seconds after which a file that is shown is looked at again


def data(material):
    """The job that reads the file of a material: work.Data."""
    settings = material.measured_brdf
    path = bpy.path.abspath(settings.filepath, library=material.library)
    return queue.ask(_data_key(path, settings.sample), partial(tasks.read, path, settings.sample), "read",
                          max_age=_RECHECK)


def cost(measured, arguments):
    """The job that fits, work.Fitted, and the one that fits without the samples that are held out, their RMSE."""
    held = queue.ask(_key("held out", measured, arguments), partial(tasks.held_out, measured.samples, arguments),
                          "slow")
    found = queue.ask(_key("fit", measured, arguments),
                           partial(tasks.fitted, measured.samples, measured.digest, arguments))
    return found, held


def known_fit(path, sample, arguments):
    """(digest, work.Fitted) where a panel has asked for this fit before, else None."""
    measured = queue.known(_data_key(path, sample))
    found = None if measured is None else queue.known(_key("fit", measured, arguments))
    return None if found is None else (measured.digest, found)


def lit_sphere(measured, arguments):
    """The icon of the lit sphere, and the job that draws it."""
    return icons.icon(_key("sphere", measured, arguments), partial(tasks.lit_sphere, measured, arguments))


def polar_plot(measured, arguments, theta_i):
    """The icon of the polar plot at an incidence in radians, and the job that draws it."""
    theta_i = round(theta_i, 3)
    return icons.icon((*_key("polar", measured, arguments), theta_i),
                         partial(tasks.polar_plot, measured, arguments, theta_i))


def errors_by_level(measured, arguments):
    """The icon of the plot of errors, and the job that draws it."""
    return icons.icon(_key("levels", measured, arguments), partial(tasks.errors_by_level, measured, arguments),
                         "slow")


def _data_key(path, sample):
    return "data", path, sample


def _key(kind, measured, arguments):
    return kind, measured.digest, tasks.freeze(arguments)
