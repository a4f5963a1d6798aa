"""Least squares, against SciPy."""

import numpy as np
import pytest
import scipy.optimize

from fitter.least_squares import damped_step, levenberg_marquardt, nonnegative_least_squares


@pytest.mark.parametrize("unlike", [1.0, 1e-2, 1e-4], ids="columns that differ by {}".format)
@pytest.mark.parametrize("unknowns", [1, 4, 10])
def test_the_least_squares_without_negatives(random, unknowns, unlike):
    matrix = random.standard_normal((300, 30, 1)) + unlike * random.standard_normal((300, 30, unknowns))
    target = random.standard_normal((300, 30))
    transposed = np.swapaxes(matrix, 1, 2)
    found = nonnegative_least_squares(transposed @ matrix, (transposed @ target[..., None])[..., 0])
    for each, columns, wanted in zip(found, matrix, target, strict=True):
        best, residual = scipy.optimize.nnls(columns, wanted)
        assert each.min() >= 0
        assert np.linalg.norm(columns @ each - wanted) == pytest.approx(residual, rel=1e-9)
        np.testing.assert_allclose(each, best, atol=1e-7 / unlike)


def test_of_equal_columns_any_share_will_do():
    found = nonnegative_least_squares(np.ones((3, 3)), np.array([2.0, 2.0, 2.0]))
    assert found.min() >= 0
    assert found.sum() == pytest.approx(2)


def test_no_problem_goes_round_in_circles(random):
    """Changing all wrong unknowns at once does, of about one in two hundred of these."""
    matrix, target = random.standard_normal((2000, 6, 6)), random.standard_normal((2000, 6))
    transposed = np.swapaxes(matrix, 1, 2)
    found = nonnegative_least_squares(transposed @ matrix, (transposed @ target[..., None])[..., 0])
    for each, columns, wanted in zip(found, matrix, target, strict=True):
        assert np.linalg.norm(columns @ each - wanted) < scipy.optimize.nnls(columns, wanted)[1] + 1e-6


@pytest.mark.parametrize("start", [[-1.2, 1.0], [3.0, -2.0]])
def test_the_nonlinear_least_squares_are_those_of_scipy(start):
    """Rosenbrock's valley."""
    evaluated = []

    def evaluate(x):
        residual = np.array([10 * (x[1] - x[0] ** 2), 1 - x[0]])
        evaluated.append(float(residual @ residual))
        return evaluated[-1], residual

    def linearise(x, residual):
        slope = np.array([[-20 * x[0], 10], [-1, 0]])
        return lambda damping: x - damped_step(slope.T @ slope, slope.T @ residual, damping)

    found, cost, residual = levenberg_marquardt(np.array(start), evaluate, linearise, steps=200, tries=20, grow=4,
                                                shrink=4, enough=1e-12)
    np.testing.assert_allclose(found, scipy.optimize.least_squares(lambda x: evaluate(x)[1], start).x, atol=1e-6)
    assert cost == residual @ residual < 1e-12


def test_no_step_is_taken_from_the_least():
    found, cost, tried = levenberg_marquardt(np.zeros(2), lambda x: (float(x @ x), 7), lambda x, _: lambda _: x + 1,
                                             steps=5, tries=3, grow=2, shrink=2, enough=0)
    assert (found.tolist(), cost, tried) == ([0, 0], 0, 7)
