"""Maps of a flat sample, beside synthetic photographs by another renderer."""

from dataclasses import replace
from itertools import cycle

import numpy as np
import pytest
from scipy.optimize import nnls
from scipy.stats import spearmanr

import fitter
from fitter import progress
from fitter.model.microfacet import Microfacet
from fitter.photographs.flat import maps as flat
from fitter.photographs.flat import materials as flat_finding
from fitter.photographs.flat.advice import next_lamp
from fitter.photographs.flat.photograph import observe
from fitter.photographs.report import report_sample
from support import flat_scene
from support.cases import release

SHAPE, GIVEN = (24, 24), (16, 16)       # texels, where materials are found or given
RAYS = flat_scene.rays((90, 100))
TOWARD_CAMERA = flat_scene.CAMERA / np.linalg.norm(flat_scene.CAMERA)


@pytest.fixture(scope="module")
def materials(cornell, curet):
    """Two paints with highlights of different colours, and leather."""
    return tuple(fitter.fit(samples, **fitter.PRESETS["Standard"])
                 for samples in (cornell("garnet_red_RGB"), cornell("krylon_blue_RGB"), curet(5)))


def photographed(sample, lamps, **how):
    return [fitter.FlatPhotograph(flat_scene.photograph(sample, lamp, seed=k, **how), RAYS, flat_scene.CAMERA, lamp,
                                  flat_scene.INTENSITY, name=f"{k}.exr") for k, lamp in enumerate(lamps)]


def off(maps, sample):
    """How far a photograph under a lamp that was not used is from what the maps say of it, of its root mean square."""
    truth = flat_scene.shown(flat_scene.photograph(sample, flat_scene.UNUSED, noise=0), maps.weights.shape[:2])
    found = maps.radiance(flat_scene.CAMERA, flat_scene.UNUSED, flat_scene.INTENSITY)
    return float(np.linalg.norm(found - truth) / np.linalg.norm(truth))


def turned(maps, sample):
    """The median angle between normals and the true ones, degrees."""
    truth = sample.normals(*flat_scene.texels(maps.weights.shape[:2]))
    cosine = (maps.normals.reshape(-1, 3) * truth).sum(axis=1)
    return float(np.degrees(np.median(np.arccos(np.clip(cosine, -1, 1)))))


@pytest.mark.parametrize("count", [2, 3])
@pytest.mark.parametrize("weights", [flat_scene.smooth_weights, flat_scene.sharp_weights])
def test_an_unseen_lamp_masks_and_normals_with_the_materials_given(materials, weights, count):
    """Issue: 5 %, .05 and 2 degrees. Reached: at most .7 %, .014 and .05 degrees."""
    sample = flat_scene.Sample(materials[:count], weights(count), flat_scene.bumps)
    maps = fitter.maps_from_flat(photographed(sample, flat_scene.lamps()), flat_scene.corners(), GIVEN, sample.fits)
    truth = sample.weights(*flat_scene.texels(GIVEN))
    wrong = np.abs(maps.weights.reshape(-1, count) - truth)
    print(f"unseen lamp {off(maps, sample):.2%}, masks {wrong.mean(axis=0).max():.4f}, normals "
          f"{turned(maps, sample):.3f} degrees")
    assert off(maps, sample) < 0.05
    assert wrong.mean(axis=0).max() < 0.05
    assert turned(maps, sample) < 2
    assert (maps.weights >= 0).all()
    np.testing.assert_allclose(np.linalg.norm(maps.normals, axis=2), 1)
    if weights is flat_scene.smooth_weights:
        # deviations are those of the errors, within a factor of 2
        assert 0.25 < np.median(wrong / maps.deviation.reshape(-1, count)) < 1.4


@pytest.mark.parametrize(("count", "weights"), [
    (1, lambda count: lambda u, v: np.ones((len(u), count))), (3, flat_scene.sharp_weights),
    pytest.param(2, flat_scene.smooth_weights, marks=pytest.mark.release),
    pytest.param(2, flat_scene.sharp_weights, marks=pytest.mark.release),
    pytest.param(3, flat_scene.smooth_weights, marks=pytest.mark.release)])
def test_an_unseen_lamp_and_normals_with_the_materials_found(materials, count, weights):
    """Issue: 8 % and 2 degrees. Reached: at most 6.1 % and .48 degrees.

    What is found may be any mixes of the true materials that others are mixes of, so masks are compared as far as they
    are a linear function of the true ones.
    """
    sample = flat_scene.Sample(materials[:count], weights(count), flat_scene.bumps)
    maps = fitter.maps_from_flat(photographed(sample, flat_scene.lamps()), flat_scene.corners(), SHAPE)
    assert len(maps.fits) == count, maps.notes
    truth, found = sample.weights(*flat_scene.texels(SHAPE)), maps.weights.reshape(-1, count)
    mapped = found @ np.linalg.lstsq(found, truth, rcond=None)[0]
    print(f"unseen lamp {off(maps, sample):.2%}, masks {np.abs(mapped - truth).mean(axis=0).max():.4f}, normals "
          f"{turned(maps, sample):.3f} degrees")
    assert off(maps, sample) < 0.08
    assert np.abs(mapped - truth).mean(axis=0).max() < 0.05
    assert turned(maps, sample) < 2
    assert 0.7 < np.quantile(found, 0.98, axis=0).min() < 1.4


def test_a_way_that_misses_some_photographs_altogether_is_not_taken(materials, monkeypatch):
    """Lambertians that miss one photograph in three by 1.6 are further off in the mean, .73, than a material that
    misses each by .6."""
    sample = flat_scene.Sample(materials[:1], lambda u, v: np.ones((len(u), 1)), flat_scene.bumps)
    shots = photographed(sample, flat_scene.lamps())
    frame = flat.sample_frame(flat_scene.corners(), shots)
    seen = observe(shots, flat.texel_points(flat_scene.corners(), GIVEN), frame[2])
    lambertian = [(0.3, 0.2), (0.3, 0.2), (1.6, 0.2)]
    by_way = [[(0.6, 0.2)] * 3] * flat_finding.MOST_MATERIALS + [[(0.9, 0.2)] * 3] + [lambertian] * 3
    turns = cycle(by_way)
    monkeypatch.setattr(flat_finding, "_both_errors", lambda expected, other: next(turns))
    assert flat_finding._best_count(seen, frame)[0] == 1


@pytest.mark.parametrize(("count", "better"), [(16, 1), (30, 4)])
def test_all_of_many_photographs_say_whether_more_materials_may_be_better(materials, monkeypatch, count, better):
    """Four materials halve the error but not that of cube roots; few photographs cannot tell so many apart."""
    sample = flat_scene.Sample(materials[2:], lambda u, v: np.ones((len(u), 1)), flat_scene.bumps)
    shots = photographed(sample, flat_scene.lamps(count))
    frame = flat.sample_frame(flat_scene.corners(), shots)
    seen = observe(shots, flat.texel_points(flat_scene.corners(), (8, 8)), frame[2])
    judged = []
    by_way = cycle([[(error, 0.2)] for error in (0.6, 0.5, 0.5, 0.3, 0.7, 0.7, 0.7, 0.7)])

    def errors(expected, other):
        judged.append(other.good.any(axis=0))
        return next(by_way)

    monkeypatch.setattr(flat_finding, "_both_errors", errors)
    assert flat_finding._best_count(seen, frame)[:2] == (1, better)
    assert np.any(judged, axis=0).sum() == count


@pytest.mark.parametrize(("count", "wrong"), [(1, 3), (2, 1)])
def test_fits_decide_where_lobes_leave_open_how_many_materials_there_are(materials, monkeypatch, count, wrong):
    """One material for which three are fitted as well, none of whose texels show the third; and two of which one is
    not enough."""
    weights = flat_scene.sharp_weights(2) if count == 2 else lambda u, v: np.ones((len(u), 1))
    sample = flat_scene.Sample(materials[:count], weights, flat_scene.bumps)
    monkeypatch.setattr(flat_finding, "_best_count", lambda *_: (*sorted((count, wrong)), ()))
    maps = fitter.maps_from_flat(photographed(sample, flat_scene.lamps(30)), flat_scene.corners(), GIVEN)
    assert len(maps.fits) == count, maps.notes
    assert off(maps, sample) < 0.08


def test_fewer_materials_than_were_asked_for_are_told(materials):
    sample = flat_scene.Sample(materials[:1], lambda u, v: np.ones((len(u), 1)), flat_scene.bumps)
    maps = fitter.maps_from_flat(photographed(sample, flat_scene.lamps(30)), flat_scene.corners(), GIVEN, 3)
    words = ["The photographs show 1 material, where 3 were asked for",
             "The photographs show 2 materials, where 3 were asked for"]
    assert words[len(maps.fits) - 1] in maps.notes


def test_shadows_and_saturated_texels_do_not_count(materials):
    sample = flat_scene.Sample(materials[:2], flat_scene.smooth_weights(2), flat_scene.bumps)
    shots = photographed(sample, flat_scene.lamps())
    whole = fitter.maps_from_flat(shots, flat_scene.corners(), GIVEN, sample.fits)
    spoilt = []
    for k, each in enumerate(shots):
        radiance = each.radiance.copy()
        radiance[30 + k:50 + k, 40:60] *= 0.02 if k % 4 == 0 else 1         # a shadow
        spoilt.append(replace(each, radiance=np.minimum(radiance, np.quantile(radiance, 0.98))))
    maps = fitter.maps_from_flat(spoilt, flat_scene.corners(), GIVEN, sample.fits)
    assert maps.used.mean() < whole.used.mean() - 0.3
    assert off(maps, sample) < 0.03
    assert np.abs(maps.weights - whole.weights).max(axis=2).mean() < 0.01


def paint_of(ks, kinds=("mirror",), alpha=0.3):
    """A dark paint with one lobe, on bumps."""
    paint = Microfacet(np.full(3, 0.05 / np.pi), np.full((1, 3), ks), np.array([alpha]), np.array([2.0]),
                       np.array([0.08]), kinds)
    return flat_scene.Sample((paint,), lambda u, v: np.ones((len(u), 1)), flat_scene.bumps)


def off_beside_the_camera(sample, shots):
    """How far maps of one material are from a sample under a lamp two degrees beside the camera."""
    beside = 0.6 * (TOWARD_CAMERA + np.array([0.02, 0, 0]))
    truth = flat_scene.shown(flat_scene.photograph(sample, beside, noise=0), GIVEN)
    found = fitter.maps_from_flat(shots, flat_scene.corners(), GIVEN, 1).radiance(
        flat_scene.CAMERA, beside, flat_scene.INTENSITY)
    off = np.linalg.norm(found - truth) / np.linalg.norm(truth)
    print(f"beside the camera {off:.2f} off")
    return off


def test_a_lamp_that_is_brighter_makes_no_peak_where_no_lamp_stood():
    """Lamps 14 degrees and more from the camera, of which the two nearest are 30 % brighter than is said: a lamp beside
    the camera is 40 % off, as bright as these. It was 220 % off, by a peak of retro-reflection whose foot they were."""
    sample, lamps = paint_of(0.8), flat_scene.lamps(24)
    away = np.degrees(np.arccos(lamps @ TOWARD_CAMERA / np.linalg.norm(lamps, axis=1)))
    shots = photographed(sample, lamps[away > 14])
    shots = [replace(each, radiance=each.radiance * (1.3 if angle < 20 else 1))
             for each, angle in zip(shots, away[away > 14], strict=True)]
    assert off_beside_the_camera(sample, shots) < 0.5


def test_retro_reflection_is_found_by_lamps_eight_degrees_from_the_camera():
    sample, lamps = paint_of(1.5, ("retro",), 0.1), flat_scene.lamps(16)
    near = [0.6 * (TOWARD_CAMERA + np.array(place)) for place in ([0.13, 0.02, 0], [-0.02, 0.13, 0])]
    assert off_beside_the_camera(sample, photographed(sample, [*lamps, *near])) < 0.2


@pytest.mark.parametrize("fits", ["given", 2, pytest.param(None, marks=pytest.mark.release)])
def test_texels_without_noise_and_radiance_leave_the_others_as_they_are(materials, fits, monkeypatch):
    """Saturated pixels have no noise, and neither has what a file says is black: both are masked, and some black ones
    are not. Without any the unseen lamp is 9 % off where two materials are found."""
    monkeypatch.setattr(flat_finding, "_JUDGED", 80)
    sample = flat_scene.Sample(materials[:2], flat_scene.sharp_weights(2), flat_scene.bumps)
    shots, spoilt, place = photographed(sample, flat_scene.lamps(8)), [], np.indices((90, 100)) // 8
    black, bright, dark = ((place == np.array(each)[:, None, None]).all(axis=0) for each in ((5, 5), (5, 7), (7, 5)))
    hurt = black | bright | dark
    for each in shots:
        radiance, noise = each.radiance.copy(), np.full(each.radiance.shape, each.floor)
        radiance[hurt], noise[hurt] = 9.0 * bright[hurt, None], 0
        spoilt.append(replace(each, radiance=radiance, noise=noise, mask=~black & ~bright))
    maps = fitter.maps_from_flat(spoilt, flat_scene.corners(), GIVEN, sample.fits if fits == "given" else fits)
    at_hurt, masked = (flat_scene.shown(np.repeat(each[..., None].astype(float), 3, axis=2), GIVEN)[..., 0] > 0
                       for each in (hurt, black | bright))
    assert (maps.used[masked] == 0).any()
    assert (maps.weights[maps.used == 0] == 0).all()
    truth = flat_scene.shown(flat_scene.photograph(sample, flat_scene.UNUSED, noise=0), GIVEN)[~at_hurt]
    there = maps.radiance(flat_scene.CAMERA, flat_scene.UNUSED, flat_scene.INTENSITY)[~at_hurt]
    wrong = np.linalg.norm(there - truth) / np.linalg.norm(truth)
    print(f"unseen lamp {wrong:.2%}")
    assert fits is None or wrong < (0.03 if fits == "given" else 0.12)
    assert np.isfinite(maps.weights).all()
    assert not any("nan" in line for line in (*maps.notes, *report_sample(maps, spoilt).lines))


def test_a_flat_surface_stays_flat_and_an_unseen_part_takes_its_neighbours_normals(materials):
    sample = flat_scene.Sample(materials[2:], lambda u, v: np.ones((len(u), 1)), lambda u, v: np.zeros((len(u), 2)))
    shots = photographed(sample, flat_scene.lamps(8))
    maps = fitter.maps_from_flat(shots, flat_scene.corners(), GIVEN, sample.fits)
    assert turned(maps, sample) < 0.3
    mask = np.ones((90, 100), bool)
    mask[40:50, 45:55] = False
    hidden = fitter.maps_from_flat([replace(each, mask=mask) for each in shots], flat_scene.corners(), GIVEN,
                                   sample.fits)
    assert (hidden.used == 0).any()
    assert (hidden.weights[hidden.used == 0] == 0).all()
    assert np.isinf(hidden.deviation[hidden.used == 0]).all()
    assert turned(hidden, sample) < 0.3


def test_the_first_corner_is_at_the_first_texel_and_the_second_ends_its_row(materials):
    sample = flat_scene.Sample(materials[:2], lambda u, v: np.column_stack([u, 0.1 + v]),
                               lambda u, v: np.zeros((len(u), 2)))
    maps = fitter.maps_from_flat(photographed(sample, flat_scene.lamps(6)), flat_scene.corners(), (5, 7), sample.fits)
    np.testing.assert_allclose(maps.weights[0, :, 0], (np.arange(7) + 0.5) / 7, atol=0.02)
    np.testing.assert_allclose(maps.weights[:, 0, 1], 0.1 + (np.arange(5) + 0.5) / 5, atol=0.02)


def test_texels_that_start_from_coarser_ones_end_where_others_do(materials, monkeypatch):
    sample = flat_scene.Sample(materials[:2], flat_scene.sharp_weights(2), flat_scene.bumps)
    shots = photographed(sample, flat_scene.lamps(8))
    whole = fitter.maps_from_flat(shots, flat_scene.corners(), SHAPE, sample.fits)
    monkeypatch.setattr(flat, "_COARSEST", 50)
    monkeypatch.setattr(flat, "_BLOCK", 100)
    told = []
    with progress.listen(lambda fraction, doing: told.append(fraction)):
        quick = fitter.maps_from_flat(shots, flat_scene.corners(), SHAPE, sample.fits)
    assert np.abs(quick.weights - whole.weights).mean() < 0.002
    apart = np.degrees(np.linalg.norm(quick.normals - whole.normals, axis=2))
    assert np.quantile(apart, 0.95) < 0.1
    assert apart.max() < 3
    assert len(set(told)) > 8
    assert told[-1] == 1

    def cancel(fraction, doing):
        if fraction > 0.5:
            raise InterruptedError
    with progress.listen(cancel), pytest.raises(InterruptedError):
        fitter.maps_from_flat(shots, flat_scene.corners(), SHAPE, sample.fits)


def test_an_unseen_part_does_not_smooth_what_is_seen(random):
    """Relief that is known well, beside twice as much that nobody knows."""
    relief = np.stack([np.sin(np.mgrid[:20, :20][0]), np.cos(np.mgrid[:20, :20][1])], axis=2) * 0.2
    slopes, known = np.zeros((20, 60, 2)), np.arange(60) < 20
    slopes[:, :20] = relief + 0.01 * random.standard_normal(relief.shape)
    precision = np.where(known[:, None, None], 1e4, 1.0) * np.eye(2) * np.ones((20, 1, 1, 1))
    found = flat.smooth_slopes(slopes, precision, known * np.ones((20, 1), bool))
    assert np.abs(found[:, :18] - relief[:, :18]).max() < 0.05


@pytest.mark.parametrize("turn", [0.004, 0.08])     # by the derivative, and anew
def test_weights_follow_normals_that_are_smoothed(materials, monkeypatch, turn):
    """Beside nonnegative least squares at the normals of the maps, by SciPy and another renderer."""
    sample, lamps, shape = flat_scene.Sample(materials[:2], flat_scene.smooth_weights(2), flat_scene.bumps), \
        flat_scene.lamps(8), (8, 8)
    shots = photographed(sample, lamps, noise=0)
    kept = fitter.maps_from_flat(shots, flat_scene.corners(), shape, sample.fits)
    monkeypatch.setattr(flat, "smooth_slopes", lambda slopes, precision, known: slopes + np.array([turn, -turn / 2]))
    maps = fitter.maps_from_flat(shots, flat_scene.corners(), shape, sample.fits)
    at, normals = flat_scene.texels(shape), maps.normals.reshape(-1, 3)
    unit = np.moveaxis([[flat_scene.radiance(flat_scene.Sample((fit,), lambda u, v: np.ones((len(u), 1)),
                                                               lambda u, v: normals[:, :2] / normals[:, 2:]), *at, lamp)
                         for fit in sample.fits] for lamp in lamps], 2, 0)
    shown = np.stack([flat_scene.shown(each.radiance, shape).reshape(-1, 3) for each in shots], axis=1)
    before = kept.weights.reshape(-1, 2)
    scale = np.einsum("npmc,nm->npc", unit, before)     # errors are shares of what is expected
    expected = [nnls((each / by[:, None]).swapaxes(1, 2).reshape(-1, 2), (values / by).ravel())[0]
                for each, by, values in zip(unit, scale, shown, strict=True)]
    changed, wrong = (np.abs(each - expected).mean() for each in (before, maps.weights.reshape(-1, 2)))
    print(f"weights change by {changed:.5f} and are {wrong:.5f} off")
    assert wrong < 0.5 * changed


@release
def test_the_next_lamp_is_one_whose_photograph_lowers_the_errors_most(materials):
    """Of lamps on one side; the errors are those of maps with a photograph more, from the truth."""
    sample, shape = flat_scene.Sample(materials[:2], flat_scene.smooth_weights(2), flat_scene.bumps), (12, 12)
    lamps = [each for each in flat_scene.lamps() if each[0] > 0][:3]
    maps = fitter.maps_from_flat(photographed(sample, lamps), flat_scene.corners(), shape, sample.fits)
    advised = next_lamp(maps, photographed(sample, lamps))
    tried = [advised.place, *flat_scene.lamps(40)[3:38:5]]
    gains = [next_lamp(maps, photographed(sample, lamps), [place]).gain for place in tried]
    errors = [turned(fitter.maps_from_flat(photographed(sample, [*lamps, place]), flat_scene.corners(), shape,
                                           sample.fits), sample) for place in tried]
    assert errors[0] < turned(maps, sample) / 1.5
    assert errors[0] <= sorted(errors)[2]
    assert spearmanr(gains, errors).statistic < -0.7
    assert gains[0] == max(gains) == advised.gain > 0.2
    assert np.linalg.norm(advised.place) == pytest.approx(np.median(np.linalg.norm(lamps, axis=1)))
    assert f"{advised.polar_angle:.0f}° from the sample's normal" in advised.advice
    many = photographed(sample, flat_scene.lamps(32))
    told = next_lamp(fitter.maps_from_flat(many, flat_scene.corners(), (4, 4), sample.fits), many)
    assert told.gain < advised.gain / 5


CORNERS = flat_scene.corners()


@pytest.mark.parametrize(("corners", "change", "message"), [
    (CORNERS[[0, 2, 1, 3]], {}, "corners .*crossed"),
    (CORNERS[::-1], {}, "clockwise"),
    (CORNERS + [[0, 0, 0.02], [0, 0, 0], [0, 0, 0], [0, 0, 0]], {}, "not in a plane"),
    (CORNERS[:3], {}, "expected four points"),
    (CORNERS + [1, 0, 0], {}, "no texel is seen"),
    (CORNERS, {"lamp": (0.1, 0.1, -0.5)}, "the lamp is behind the sample"),
    (CORNERS, {"radiance": np.ones((9, 9, 3)), "rays": flat_scene.rays((9, 9)), "mask": None},
     "9 x 9 pixels .*expected 100 x 90"),
])
def test_what_cannot_be_is_refused(materials, corners, change, message):
    shots = [fitter.FlatPhotograph(np.ones((90, 100, 3)), RAYS, flat_scene.CAMERA, lamp, flat_scene.INTENSITY)
             for lamp in flat_scene.lamps(3)]
    with pytest.raises(fitter.DatasetError, match=message):
        fitter.maps_from_flat([*shots[:2], replace(shots[2], **change)], corners, (4, 4), materials[:1])
    with pytest.raises(fitter.DatasetError, match="expected two or more"):
        fitter.maps_from_flat(shots[:1], CORNERS, (4, 4), materials[:1])
    with pytest.raises(ValueError, match="expected 1 to 4"):
        fitter.maps_from_flat(shots, CORNERS, (4, 4), ())
    with pytest.raises(fitter.DatasetError, match=r"0 texels .*expected 30 for the materials"):
        fitter.maps_from_flat(shots, CORNERS, (4, 4))
