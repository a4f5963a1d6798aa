import math

import numpy as np
import pytest

import fitter


def test_errors_are_those_of_equations_8_to_10(random):
    measured, fitted = random.standard_normal((2, 40, 3))
    pairs = list(zip(measured.ravel().tolist(), fitted.ravel().tolist(), strict=True))
    rmse = math.sqrt(sum((a - b) ** 2 for a, b in pairs) / len(pairs))
    mae = max(abs(a - b) for a, b in pairs)
    errors = fitter.error_metrics(measured, fitted)
    assert errors == pytest.approx((rmse, mae, mae / max(abs(a) for a, _ in pairs)))


def test_per_channel_each_channel_has_its_own_peak():
    measured, fitted = np.array([[1.0, 10], [2, 20]]), np.array([[1.0, 10], [1, 19]])
    assert [errors.mre for errors in fitter.channel_metrics(measured, fitted)] == [0.5, 0.05]


def test_nothing_measured_but_zeros_has_no_relative_error():
    assert math.isnan(fitter.error_metrics([0.0, 0], [0.0, 1]).mre)


@pytest.mark.parametrize("shapes", [((3,), (4,)), ((0,), (0,)), ((3, 1), (3,))])
def test_arrays_that_do_not_match_are_refused(shapes):
    with pytest.raises(ValueError, match="one shape"):
        fitter.error_metrics(np.zeros(shapes[0]), np.zeros(shapes[1]))
