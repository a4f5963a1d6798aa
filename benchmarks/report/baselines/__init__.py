"""What Standard is compared with."""

import numpy as np

from fitter.arrays import FloatArray
from fitter.methods.regression_kriging import CEILING


def ceiling(values: FloatArray) -> FloatArray:
    """The largest value that is predicted: `CEILING` times the largest sample, (n, channels) to (channels,), 1/sr.

    Far from the samples a model may run away; without a bound, one held-out sample there would be all of its error.
    """
    return CEILING * np.maximum(values.max(axis=0), 0)
