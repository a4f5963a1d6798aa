"""What the grades rest on."""

import numpy as np
import pytest

from benchmarks import verdict
from fitter.quality.verdict import UNKNOWN


@pytest.mark.parametrize(("rgb", "expected"), [
    ((1, 1, 1), (100, 0, 0)), ((0, 0, 0), (0, 0, 0)), ((1, 0, 0), (53.24, 80.09, 67.20)),
    ((0, 0, 1), (32.30, 79.19, -107.86))])
def test_colours_are_those_of_cielab(rgb, expected):
    np.testing.assert_allclose(verdict.lab(np.array([*rgb, 1.0], dtype=np.float32)), expected, atol=0.05)


def test_the_table_counts_the_fits_that_keep_the_promise():
    rows = [("Draft", 0.5, 0.5, 0.9), ("Draft", 0.5, UNKNOWN, 1.1), ("Paper", 5.0, 9.0, 4.0)]
    lines = verdict.table(rows).splitlines()
    assert "2 of 3 fits,  50.0% of them within 1.0" in lines[0]
    assert "3 of 3 fits, 100.0% of them within 5.0" in lines[2]
    assert "1 of 2 fits, 100.0% of them within 1.0" in lines[3]
