"""Measured BRDFs as smooth functions that are evaluated in constant time. NumPy only, no Blender.

Examples
--------
A table of measurements is made here; `load` reads one from a file.

>>> import numpy as np
>>> theta_i, theta_o = np.meshgrid(np.radians([0, 20, 40, 60]), np.radians([0, 20, 40, 60]))
>>> paper = Samples(theta_i.ravel(), np.zeros(16), theta_o.ravel(), np.full(16, np.pi), np.full((16, 1), 0.8 / np.pi),
...                 name="white paper")
>>> fitted = fit(paper, **PRESETS["Draft"])
>>> values = fitted.evaluate(theta_i=0.5, phi_i=0, theta_o=np.linspace(0, 1.5, 4), phi_o=2)      # 1/sr
>>> values.shape, bool(np.allclose(np.pi * values, 0.8))
((4, 1), True)
>>> error_metrics(paper.values, fitted.evaluate(*paper.directions)).rmse < 1e-6
True
"""

import sys

from . import interrupts

if sys.argv[:1] == ["-m"]:      # `python -m fitter` imports this first, which takes a second
    interrupts.end_at_once()

from .errors import ColumnsUnknownError, DatasetError, ImplausibleError, SampleUnknownError, UnitsUnknownError
from .formats import load
from .methods import fit
from .methods.editing import edited
from .methods.presets import PRESETS
from .methods.tolerance import fit_within
from .model.fit import Fit
from .model.mix import Mix
from .model.published import list_published, load_published
from .photographs.ball.measuring import samples_from_ball
from .photographs.ball.photograph import BallPhotograph
from .photographs.flat.maps import Maps, maps_from_flat
from .photographs.flat.photograph import FlatPhotograph
from .quality.metrics import ErrorMetrics, channel_metrics, error_metrics
from .samples import Samples

__all__ = ["PRESETS", "BallPhotograph", "ColumnsUnknownError", "DatasetError", "ErrorMetrics", "Fit", "FlatPhotograph",
           "ImplausibleError", "Maps", "Mix", "SampleUnknownError", "Samples", "UnitsUnknownError", "channel_metrics",
           "edited", "error_metrics", "fit", "fit_within", "list_published", "load", "load_published", "maps_from_flat",
           "samples_from_ball"]
