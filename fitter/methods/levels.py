"""The size of a fit: the levels of its lattices, and how much of the sparse one is kept."""

from dataclasses import dataclass
from numbers import Real

import numpy as np

from ..lattice import dense

_FINEST_DENSE, _FINEST_SPARSE = 3, 4    # of four axes: 9,317 control points, and 75,449 to choose from
KEPT_OF_FOUR = 3           # times the control points of three axes are kept of four


@dataclass(frozen=True)
class Levels:
    """The levels of a bi-level fit (Kameya and Lewis 2002, section 4). Raises ValueError if one is out of range."""

    diffuse: int            # D, the level of the dense lattice
    specular: int | None    # S, the level of the sparse lattice; None for the dense lattice alone
    compression: float      # C, the percentage of the (2^S + 3)^3 specular control points to drop

    def __post_init__(self) -> None:
        object.__setattr__(self, "diffuse", _check("diffuse_level", self.diffuse))
        if self.specular is not None:
            object.__setattr__(self, "specular", _check("specular_level", self.specular))
            if not isinstance(self.compression, Real) or not 0 <= self.compression <= 100:
                raise ValueError(f"compression is {self.compression!r}, expected a percentage from 0 to 100")

    def kept_count(self, axes: int) -> int:
        """How many control points of the sparse lattice are kept."""
        size = 0 if self.specular is None else dense.full_size(self.specular, axes)
        return round((1 - self.compression / 100) * size)

    def four_axis_levels(self) -> "Levels":
        """Levels of about the same use for an anisotropic fit: one lower, with three times as many control points."""
        diffuse = min(max(self.diffuse - 1, 0), _FINEST_DENSE)
        if self.specular is None:
            return Levels(diffuse, None, self.compression)
        specular = min(max(self.specular - 1, 0), _FINEST_SPARSE)
        kept = min(KEPT_OF_FOUR * self.kept_count(3) / dense.full_size(specular, 4), 1.0)
        return Levels(diffuse, specular, 100 * (1 - kept))

    def check_four_axes(self) -> None:
        """Raise ValueError if a lattice of four axes of these levels would not fit in memory."""
        for name, level, most in (("diffuse_level", self.diffuse, dense.MAX_LEVEL_OF_FOUR_AXES - 1),
                                  ("specular_level", self.specular, dense.MAX_LEVEL_OF_FOUR_AXES)):
            if level is not None and level > most:
                raise ValueError(f"{name} is {level}, expected at most {most} of an anisotropic fit")

    @property
    def effective_compression(self) -> float:
        """The compression that a `Fit` states: 0 without a sparse lattice."""
        return 0.0 if self.specular is None else float(self.compression)


def _check(name: str, level: int) -> int:
    if isinstance(level, bool) or not isinstance(level, int | np.integer) or not 0 <= level <= dense.MAX_LEVEL:
        raise ValueError(f"{name} is {level!r}, expected a whole number from 0 to {dense.MAX_LEVEL}")
    return int(level)
