"""The contact sheet: what it counts, and that what is hard to render looks no worse than a Principled."""

import bpy
import numpy as np
import pytest

from benchmarks import contact
from fitter.cycles.node_mixture import node_mixtures
from support import stage
from support.cases import release

# of the sheet, by what is conspicuous beside a Principled's
WORST = ("curet/abrdf.dat moss", "rgl/chm_mint_rgb.bsdf", "cornell/krylon_blue.astm, width .25",
         "rgl/cc_green_malachite_rgb.bsdf", "rgl/irid_flake_paint1_rgb.bsdf, width .25", "rgl/ilm_solo_m_68_rgb.bsdf",
         "rgl/irid_flake_paint1_rgb.bsdf, gain 8", "rgl/irid_flake_paint1_rgb.bsdf, red", "cornell/cayman.astm",
         pytest.param("goniometer/carpaint_blue.mbsdf", marks=pytest.mark.xfail(
             reason="its dark rim is measured, and a Principled has none", strict=True)))
MOST_BELOW = 40             # pixels of a tile before denoising


def test_pixels_that_differ_from_those_around_them_are_counted():
    picture = np.ones((12, 12, 3))
    picture[2, 2], picture[6, 6], picture[9, 3] = 0.2, 5.0, (-0.1, 1, 1)
    picture[9, 9] = -0.3, 0.2, 0.2
    found = contact.tile(picture)
    assert (found.dark, found.bright, found.below) == (2, 1, 2)


def test_everything_that_is_offered_is_on_it():
    from fitter import published

    assert {each.path for each in published.offered()} < {*contact.materials()}
    assert [*contact.materials(published=89 // 2)][1] == published.offered()[2].path


@pytest.mark.parametrize(("name", "seed"), [("published:two-layer-silver", 3), ("goniometer/IMX455.bsdf", 3),
                                            ("published:black-obsidian", 0)])
def test_there_are_no_dots_in_narrow_peaks_and_at_silhouettes(extension, openimageio, name, seed):
    if name not in contact.materials():
        pytest.skip("no measurements")
    fit = contact.materials()[name]()
    made = contact.scene()
    made.cycles.use_denoising, made.cycles.seed = False, seed
    bpy.data.objects["Sphere"].data.materials.append(stage.material_for(fit, node_mixtures(fit)))
    shown = contact.tile(stage.render(made)[..., :3])
    assert shown.below == 0
    assert shown.bright <= 12, "a black ball's highlights are"


@release
@pytest.mark.parametrize("name", WORST)
def test_the_worst_are_no_more_conspicuous_than_a_principled(extension, openimageio, name):
    """Exact after denoising, Nodes before it too."""
    if name not in contact.materials():
        pytest.skip("no measurements")
    found = contact.tiles(contact.materials()[name](), name, ("Exact", "Nodes", "Principled"))
    (raw, exact), nodes, like = (found[way] for way in ("Exact", "Nodes", "Principled"))
    assert raw.below <= MOST_BELOW
    for ours, theirs in zip((exact, *nodes), (like[1], *like), strict=True):
        assert ours.below <= theirs.below
        assert ours.dark <= theirs.dark + 5
        assert ours.bright <= theirs.bright + 5
