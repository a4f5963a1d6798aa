"""Exact has no black pixels where lights that the shader does not know, area lamps and bump maps make them likely."""

import pytest

from benchmarks import black_pixels
from support import stage
from support.cases import quick

# of 16,000 pixels: where a peak is narrower than its lamp
MOST = {"cayman, three lamps": 1, "malachite, bump map": 3, "mint, three lamps": 2}


@pytest.mark.parametrize("name", quick([*black_pixels.SCENES], "foil, lit mesh", "krylon, bump map"))
def test_no_pixel_is_far_below_zero(extension, openimageio, name):
    if not black_pixels.is_there(name):
        pytest.skip("no measurements")
    fit, nodes = black_pixels.fitted(black_pixels.SCENES[name][1])
    picture = stage.render(black_pixels.scene(name, lambda: stage.material_for(fit, nodes)))[..., :3]
    assert black_pixels.below(picture) <= MOST.get(name, 0)
