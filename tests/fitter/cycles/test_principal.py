"""The axes of anisotropic reflectances, against those that they are made with."""

import numpy as np
import pytest

from fitter.cycles.principal import principal
from support.anisotropic import ANISOTROPIC, brushed_fit

TRUTHS = {truth.name: truth for truth in ANISOTROPIC}


@pytest.mark.parametrize(("name", "degrees"), [("brushed a", 20 + 90), ("brushed b", -35), ("ward b", 45),
                                               ("ward a", 90)])
def test_the_first_axis_is_the_one_along_which_the_highlight_is_longest(name, degrees):
    axes = principal(TRUTHS[name])
    off = np.degrees(axes.turn) - degrees
    assert abs((off + 90) % 180 - 90) < 2
    assert axes.stretch > 1.1


def test_a_round_highlight_is_not_stretched():
    assert principal(brushed_fit(0.2, 0.2 * (1 + 1e-9))).stretch == pytest.approx(1, abs=0.02)
