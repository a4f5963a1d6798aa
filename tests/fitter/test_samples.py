"""Symmetries of samples: what they add, beside a naive loop; and an analytic material that has them."""

from dataclasses import replace

import numpy as np
import pytest

import fitter
from fitter import DatasetError
from fitter.samples import (
    HALF_TURN,
    HALF_TURN_AND_MIRROR,
    MIRROR,
    MOST_REPEATED,
    NO_SYMMETRY,
    SYMMETRIES,
    Rotations,
    apply_symmetry,
    choice,
    rotations,
    subset,
)
from support import anisotropic as instruments


def measured(directions):
    return fitter.Samples(*directions, instruments.ggx()(*directions), ("R", "G", "B"), isotropic=False)


def naive(samples, symmetry):
    """Whole degrees: {direction: value}, of which a measured one wins."""
    images = {NO_SYMMETRY: [], HALF_TURN: [(1, 180)], MIRROR: [(-1, 0)],
              HALF_TURN_AND_MIRROR: [(1, 180), (-1, 0), (-1, 180)]}[symmetry]
    found = {}
    for factor, turn in [(1, 0), *images]:
        for *angles, value in zip(*np.rint(np.degrees(samples.directions)).astype(int), samples.values, strict=True):
            theta_i, phi_i, theta_o, phi_o = angles
            key = (theta_i, (factor * phi_i + turn) % 360 if theta_i else 0,
                   theta_o, (factor * phi_o + turn) % 360 if theta_o else 0)
            found.setdefault(key, value)
    return found


@pytest.mark.parametrize("symmetry", SYMMETRIES)
@pytest.mark.parametrize("rotations", [range(0, 91, 30), range(0, 181, 45), [10, 40]])
def test_what_a_symmetry_adds_is_what_a_loop_adds(symmetry, rotations):
    samples = measured(instruments.grid([10, 20, 50], rotations, [15, 30, 60], range(0, 360, 60)))
    repetition = apply_symmetry(samples, symmetry)
    expected = naive(samples, symmetry)
    seen = naive(repetition, NO_SYMMETRY)
    assert seen.keys() == expected.keys()
    assert len(repetition) == len(expected)
    for key, value in expected.items():
        np.testing.assert_array_equal(seen[key], value)
    np.testing.assert_array_equal(repetition.theta_i[:len(samples)], samples.theta_i)


def test_the_normal_has_no_azimuth():
    samples = measured(instruments.grid([0], [0, 50], [0, 30], [0, 40]))
    assert len(apply_symmetry(samples, "half_turn")) == 2 * 2 * 2 + 4          # nothing new where both are the normal
    assert naive(apply_symmetry(samples, "mirror"), NO_SYMMETRY).keys() == naive(samples, MIRROR).keys()


@pytest.mark.parametrize(("symmetry", "rotations"), [(HALF_TURN, range(0, 180, 20)), (MIRROR, range(0, 181, 20)),
                                                     (HALF_TURN_AND_MIRROR, range(0, 91, 15))])
def test_a_material_of_this_symmetry_has_the_values_that_it_adds(symmetry, rotations):
    samples = measured(instruments.grid([15, 45], rotations, [10, 40, 70], range(5, 360, 50)))
    repetition = apply_symmetry(samples, symmetry)
    assert len(repetition) > 1.7 * len(samples)
    np.testing.assert_allclose(repetition.values, instruments.ggx()(*repetition.directions), rtol=1e-9)
    shown = symmetry.replace("_", " ")
    assert repetition.notes == (f"Symmetry, {shown}: {len(samples):,} samples stand for {len(repetition):,}",)


def test_none_adds_nothing_and_other_words_are_refused():
    samples = measured(instruments.grid([15], [0], [10], [0]))
    assert apply_symmetry(samples, "none") is samples
    with pytest.raises(DatasetError, match="symmetry 'rotation' found, expected none, half_turn, mirror"):
        apply_symmetry(samples, "rotation")


def test_deviations_and_saturated_ones_go_with_their_samples():
    samples = replace(measured(instruments.grid([15], [0, 30], [10, 20], [50])), deviation=[0.1, 0.2, 0.3, 0.4],
                      saturated=[True, False, False, True])
    repetition = apply_symmetry(samples, "half_turn")
    np.testing.assert_array_equal(repetition.deviation, [0.1, 0.2, 0.3, 0.4] * 2)
    np.testing.assert_array_equal(repetition.saturated, [True, False, False, True] * 2)
    np.testing.assert_array_equal(subset(samples, slice(2, None)).saturated, [False, True])


def test_a_mask_of_saturated_samples_has_one_entry_for_each_and_cannot_be_changed():
    samples = measured(instruments.grid([15], [0, 30], [10, 20], [50]))
    assert samples.saturated is None
    with pytest.raises(DatasetError, match=r"saturated has the shape \(3,\), expected \(4,\)"):
        replace(samples, saturated=np.zeros(3, bool))
    mask = np.zeros(4, bool)
    marked = replace(samples, saturated=mask)
    mask[0] = True
    assert not marked.saturated.any()
    with pytest.raises(ValueError, match="read-only"):
        marked.saturated[0] = True


def test_more_samples_than_memory_should_hold_are_refused():
    count = MOST_REPEATED // 4 + 1
    angle = np.full(count, 0.5)
    samples = fitter.Samples(angle, angle, angle, angle, np.ones((count, 1)))
    with pytest.raises(DatasetError, match=r"1,000,001 samples, which the symmetry 'half_turn_and_mirror' makes 4,0"):
        apply_symmetry(samples, "half_turn_and_mirror")


def test_the_range_of_rotations_is_the_complement_of_the_widest_gap():
    def at(*degrees):
        turns = rotations(np.ones(len(degrees)), np.radians(degrees))
        return turns.count, turns.first, turns.last

    assert at(0, 45, 90) == (3, 0, 90)
    assert at(350, 370, 20, -360) == (4, 350, 380)
    assert at(*range(0, 360, 10)) == (36, 0, 350)
    assert at(7, 7.1, 6.9) == (1, 7, 7)
    assert rotations(np.zeros(2), np.array([1.0, 2.0])) == Rotations(1, 0, 0)


def test_a_choice_of_many_has_no_repetition_and_is_always_the_same():
    chosen = choice(3000, 2000)
    assert len(set(chosen.tolist())) == 2000
    assert (np.diff(chosen) > 0).all()
    np.testing.assert_array_equal(chosen, choice(3000, 2000))
