"""Materials of the starter library, of the fits that were made beforehand. Nothing here imports bpy."""

import numpy as np

from ...fitter import DatasetError
from ...fitter.colours import DEFAULT_COLOURS
from ...fitter.imaging.picture_files import read_picture
from ...fitter.library import matching, ready
from ...fitter.model import published
from ..core.annotations import Arguments
from ..core.storage.outcomes import EmbeddedFit, Outcome
from ..work import tasks


def match_photograph(path: str, window: str) -> tuple[str, list[matching.Match]]:
    """What `matching.find_nearest` says of a photograph of a ball. Raises DatasetError."""
    pixels = read_picture(path).pixels
    try:
        return matching.find_nearest(np.broadcast_to(pixels, (*pixels.shape[:2], 3)), window)
    except DatasetError as error:
        raise DatasetError(str(error), path) from error


def is_quick(name: str, colours: str) -> bool:
    """Whether `outcome` takes less than a second, for a file of these colours: nothing is to be fitted."""
    return colours in ("", DEFAULT_COLOURS) and ready.is_there(name)


def import_result(name: str, how: Arguments, edit: Arguments | None = None) -> Outcome:
    """What a material is made from, of a published fit, edited as `fitter.edited` does; where the file has other
    colours, it is fitted for them.

    Raises DatasetError if there is none of this name, or its fit is damaged.
    """
    path = published.find(name).path
    if how["colours"] != DEFAULT_COLOURS:
        return tasks.outcome(path, None, ready.ARGUMENTS, how, edit)
    made = tasks.ready_outcome(ready.find(name), path, how)
    kept = EmbeddedFit(made.surface.kept, name, made.measured.colours)
    return made._replace(surface=tasks.edit_surface(kept, edit)) if edit else made


def outcomes(name: str, how: Arguments, edit: Arguments | None = None) -> list[tuple[str, str, Outcome]]:
    """The one outcome, as `tasks.outcomes` returns several."""
    return [(published.find(name).path, "", import_result(name, how, edit))]
