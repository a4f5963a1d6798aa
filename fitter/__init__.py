"""Measured reflectance as smooth, constant-time functions: NumPy only, no Blender.

>>> samples = load("abrdf.dat", sample="leather")              # doctest: +SKIP
>>> leather = fit(samples, diffuse_level=4, specular_level=6)   # doctest: +SKIP
>>> leather.evaluate(theta_i=0.5, phi_i=0, theta_o=0.5, phi_o=3.14159)   # doctest: +SKIP
"""

from .errors import DatasetError
from .formats import load
from .methods import fit
from .methods.tolerance import fit_within
from .model.fit import Fit
from .presets import PRESETS
from .quality.metrics import ErrorMetrics, channel_metrics, error_metrics
from .samples import Samples

__all__ = ["PRESETS", "DatasetError", "ErrorMetrics", "Fit", "Samples", "channel_metrics", "error_metrics", "fit",
           "fit_within", "load"]
