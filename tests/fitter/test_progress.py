"""Progress of fits: it rises evenly to the end, and says what is being done."""

import numpy as np
import pytest

import fitter
from fitter import PRESETS, progress
from fitter.cycles.bake import bake
from fitter.cycles.node_mixture import node_mixtures
from fitter.samples import Samples, subset

pytestmark = pytest.mark.usefixtures("fresh")       # what is kept tells no progress


def told_by(work):
    told = []
    with progress.listen(lambda fraction, doing: told.append((fraction, doing))):
        result = work()
    return told, result


def assert_even(told, steps, doings, largest_jump=0.25):
    fractions = [fraction for fraction, _ in told]
    assert fractions == sorted(fractions)
    assert fractions[0] == 0
    assert len({*fractions}) >= steps
    assert np.diff([*fractions, 1.0]).max() <= largest_jump
    assert doings <= {doing for _, doing in told}


@pytest.fixture(scope="module")
def many(glossy):
    """More samples than a Gaussian process takes."""
    random = np.random.default_rng(3)
    angles = random.random((3, 2500)) * np.array([[1.4], [1.4], [np.pi]])
    values = 0.2 + np.exp(-20 * ((angles[0] - angles[1]) ** 2 + (np.pi - angles[2]) ** 2))
    return Samples(angles[0], np.zeros(2500), angles[1], angles[2], values[:, None])


@pytest.mark.parametrize("preset", PRESETS)
def test_every_preset_tells_its_steps(glossy, preset):
    told, _ = told_by(lambda: fitter.fit(subset(glossy, slice(150)), **PRESETS[preset]))
    if PRESETS[preset]["method"] == "kriging":
        assert_even(told, 12, {"Fitting lobes", "Fitting shape", "Fitting the sparse lattice", "Checking the energy"})
    else:
        assert_even(told, 5, {"Fitting the dense lattice", "Fitting the sparse lattice"}, 0.5)


def test_fits_of_many_samples_tell_their_steps(many):
    told, _ = told_by(lambda: fitter.fit(many, 3, 4, 98.0, "kriging"))
    assert_even(told, 12, {"Fitting shape", "Fitting the dense lattice", "Fitting the sparse lattice"})


def test_a_fit_by_tolerance_tells_its_steps(glossy):
    told, _ = told_by(lambda: fitter.fit_within(subset(glossy, slice(60)), 0.05))
    assert_even(told, 12, {"Fitting the sparse lattice"}, 0.8)        # it ends as soon as it has found one


def test_shaders_and_nodes_tell_every_view_and_step(glossy):
    fit = fitter.fit(subset(glossy, slice(150)), 2, None)
    assert_even(told_by(lambda: bake(fit))[0], 2, set(), 0.5)         # half a second
    assert_even(told_by(lambda: node_mixtures(fit))[0], 4, set())


def test_fractions_never_fall_and_stay_within_1():
    def work():
        with progress.part(0.5, 1.0, "first"):
            progress.report(1.5)
        with progress.part(0.2, 0.4, "second"):
            progress.report(0.5)

    told, _ = told_by(work)
    assert told == [(0.5, "first"), (1.0, "first"), (1.0, "second"), (1.0, "second")]


def test_parts_of_a_list_name_what_they_are_about():
    def work():
        for number in range(2):
            with progress.part(number / 2, (number + 1) / 2, about=f"file {number}: "):
                progress.report(0.0, "Reading")
                with progress.part(0.5, 1.0, "Fitting"):
                    progress.report(0.5)

    told, _ = told_by(work)
    assert [each for each in told if each[1]] == [
        (0.0, "file 0: Reading"), (0.25, "file 0: Fitting"), (0.375, "file 0: Fitting"), (0.5, "file 0: Fitting"),
        (0.5, "file 1: Reading"), (0.75, "file 1: Fitting"), (0.875, "file 1: Fitting")]


def test_whoever_listens_outside_is_told_what_is_overheard():
    inner = []

    def work():
        with progress.part(0.5, 1.0), progress.listen_also(lambda fraction, doing: inner.append((fraction, doing))):
            progress.report(0.5, "half")

    told, _ = told_by(work)
    assert inner == [(0.5, "half")]
    assert told[-1] == (0.75, "half")


def test_after_an_error_the_listener_before_hears_again():
    def work():
        try:
            with progress.part(0.0, 0.5):
                raise ValueError
        except ValueError:
            progress.report(0.75, "after")

    assert told_by(work)[0][-1] == (0.75, "after")
