"""The results of the background processes, which materials are made from. Nothing here imports bpy."""

import hashlib
from typing import NamedTuple

from ....fitter import ErrorMetrics, Fit
from ....fitter.arrays import FloatArray
from ....fitter.cycles.node_mixture import Nodes
from ....fitter.cycles.principled_bsdf import Principled
from ....fitter.quality import verdict
from ....fitter.quality.describe import Description
from ..annotations import Arguments, as_text


class Measurement(NamedTuple):
    """Measurements in a file, which each process reads for itself."""

    path: str
    sample: str
    how: str                # keyword arguments of `fitter.load`, as JSON
    name: str               # this and what follows is of the samples, which `digest` identifies
    channels: tuple[str, ...]
    colours: str
    digest: str


class Data(NamedTuple):
    """Measurements and their description."""

    measured: Measurement
    description: Description

    @property
    def digest(self) -> str:
        return self.measured.digest


class Fitted(NamedTuple):
    """A fit, and how it was made."""

    fit: Fit
    errors: ErrorMetrics    # at its samples
    seconds: float
    unseen: float = verdict.UNKNOWN     # `verdict.lightness_error` at samples that it had not seen


class EmbeddedFit(NamedTuple):
    """A fit that a material keeps, as `Fit.to_bytes` returns it, and its name."""

    fit: bytes
    name: str
    colours: str

    @property
    def digest(self) -> str:
        """Identifies the fit: 32 hexadecimal digits."""
        return hashlib.blake2b(f"{self.name}\n{self.colours}\n".encode() + self.fit, digest_size=16).hexdigest()


class FitRequest(NamedTuple):
    """The fit that measurements have with some arguments; nobody need have made it yet."""

    data: Data
    arguments: Arguments

    @property
    def digest(self) -> str:
        return f"{self.data.digest} {as_text(self.arguments)}"

    @property
    def colours(self) -> str:
        return self.data.measured.colours


class KeptMix(NamedTuple):
    """The fits that a mix keeps, each of a material or of a mix; and the share of the second, None with a mask."""

    first: "EmbeddedFit | KeptMix"
    second: "EmbeddedFit | KeptMix"
    share: float | None

    @property
    def digest(self) -> str:
        return f"{self.first.digest} {self.second.digest} {self.share}"

    @property
    def colours(self) -> str:
        return self.first.colours


Shown = EmbeddedFit | KeptMix | FitRequest
"""A fit that pictures are made of."""


class Surface(NamedTuple):
    """What a material shows."""

    colours: str
    kept: bytes             # the fit, as `Fit.to_bytes` has it
    source: str             # the OSL shader that `bake` made of it
    nodes: Nodes
    albedo: FloatArray      # (3,), linear
    principled: Principled  # the closest one
    sphere: str             # a small picture, as `packed` makes it
    edit: Arguments         # the keyword arguments of `fitter.edited` that the fit was made with


class Outcome(NamedTuple):
    """Everything that a material is made from; `questions` are the `open_questions` of the measurements."""

    measured: Measurement
    fitted: Fitted
    verdict: verdict.Verdict
    surface: Surface
    questions: tuple[str, ...] = ()
