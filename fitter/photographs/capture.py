"""The scene of a description, whichever surface that is of."""

from .ball.measuring import locate_ball
from .description.capture_setup import CaptureSetup
from .flat.reading import locate_sample
from .pictures.reading import Pictures
from .rig.lamps import Scene


def resolve(setup: CaptureSetup) -> Scene:
    """The scene in which a description is measured.

    Raises DatasetError if the description or a file is wrong, with file and key; ImportError without OpenImageIO.
    """
    pictures = Pictures(setup)
    return locate_sample(setup, pictures) if setup.ball is None else locate_ball(setup, pictures)
