"""How long a job still takes, as the progress line says it."""

import pytest
from measured_brdf.addon.work.job import Job


@pytest.mark.parametrize(("fraction", "elapsed", "expected"), [
    (0.05, 20, ""), (0.5, 2, ""), (1.0, 20, ""), (0.25, 10, "about 30 s left"), (0.1, 18, "about 3 min left"),
    (0.8, 16, "about 4 s left"), (0.99, 30, "about 1 s left")])
def test_the_rest_takes_as_long_as_the_pace_so_far_says(extension, fraction, elapsed, expected):
    job = Job(None)
    assert job.time_left(100) == ""
    job.fraction = fraction
    assert job.time_left(100 + elapsed) == expected
    if expected:
        unit = 60 if "min" in expected else 1
        assert int(expected.split()[1]) * unit == pytest.approx(elapsed * (1 - fraction) / fraction, abs=20 * unit / 20)


def test_a_job_that_has_ended_takes_no_longer(extension):
    job = Job(None)
    job.time_left(0)
    job.fraction, job.finished = 0.5, 9.0
    assert job.time_left(10) == ""
