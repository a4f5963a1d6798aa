"""Where camera, lamps and what is measured were when photographs were taken."""

from typing import NamedTuple

from ...arrays import BoolArray
from ..description.capture_setup import ScaleSetup, Shot
from .camera import View
from .lamps import Lamp, MeasuredPlace


class Scene(NamedTuple):
    """What all photographs of a description share, and a lamp for each."""

    view: View
    what: MeasuredPlace             # the ball, or the middle of a sample with its diagonal
    shots: tuple[Shot, ...]
    lamps: list[Lamp]
    scale: ScaleSetup
    lit: MeasuredPlace              # what the lamps light that tell the scale
    notes: tuple[str, ...]
    mask: BoolArray | None = None   # pixels that count, of a ball
