"""Fits with parts of every kind, made without samples: what files, shaders and Blender must carry unchanged."""

from dataclasses import replace

import numpy as np

from fitter import Fit
from fitter.coordinates import ISOTROPIC_AXES
from fitter.coordinates.anisotropic_nusselt import AnisotropicNusselt
from fitter.coordinates.anisotropic_rusinkiewicz import AnisotropicRusinkiewicz
from fitter.coordinates.half_angle import HalfAngle
from fitter.coordinates.half_difference import HalfDifference
from fitter.coordinates.rusinkiewicz import Rusinkiewicz
from fitter.lattice import dense
from fitter.lattice.dense import DenseLattice
from fitter.lattice.sparse import keep_largest
from fitter.model.microfacet import NO_GAMMA, Microfacet
from fitter.model.transform import LogRelative
from fitter.samples import RGB
from fitter.shader_constants import DAMPING_KNOTS

_SHAPES = {"mirror": (0.15, 2.5, 0.08), "retro": (0.2, 3.0, 0.7), "sheen": (0.9, NO_GAMMA, 0.6),
           "fibre": (0.2, 2.5, 0.6)}


def made_fit(coordinates, kinds=("mirror",), columns=(0, 1, 2), damped=False, sparse=True):
    """A log-relative fit of random numbers, whose field varies by about 1, with lobes of these kinds in its prior, one
    or three columns for its channels, and a damping and a sparse lattice or not."""
    random = np.random.default_rng(7)
    stored = max(columns) + 1
    shapes = np.array([_SHAPES[kind] for kind in kinds]).reshape(len(kinds), 3) * (1 + 0.1 * random.random((1, 3)))
    gamma = np.where([kind == "sheen" for kind in kinds], NO_GAMMA, shapes[:, 1])
    prior = Microfacet(0.05 + 0.1 * random.random(stored), 0.2 + random.random((len(kinds), stored)), shapes[:, 0],
                       gamma, shapes[:, 2], tuple(kinds))
    axes = len(coordinates.axes)
    if axes > ISOTROPIC_AXES:
        turned = np.array([kind in ("mirror", "fibre") for kind in kinds])
        prior = replace(prior, across=np.where(turned, 0.4, prior.alpha), turn=np.where(turned, -0.6, 0.0))
    damping = 0.2 + 0.8 * random.random((DAMPING_KNOTS, stored)) if damped else np.zeros((0, 1))
    transform = LogRelative(prior, 0.1, np.linspace(8, 9, stored), 0.0, damping)
    control_points = 0.5 * _symmetric(2, random.standard_normal((*dense.shape(2, axes), stored)))
    diffuse = DenseLattice(2, control_points.astype(np.float32))
    specular = keep_largest(0.2 * _symmetric(4, random.standard_normal((*dense.shape(4, axes), stored))), 4, 800)
    return Fit(coordinates, diffuse, specular if sparse else None, transform, 90.0 if sparse else 0.0,
               RGB if len(columns) == 3 else ("grey",), columns, name="made", source="made_fits")


def _symmetric(level, control_points):
    """Control points of which mirror images are equal."""
    same = dense.representative(level, control_points.ndim - 1).ravel()
    return control_points.reshape(len(same), -1)[same].reshape(control_points.shape)


# each part in several surroundings: coordinates and their stretch, kinds of lobes, channels and columns, damping
MADE_FITS = {
    "half and difference": made_fit(HalfDifference()),
    "half and difference, stretched by 5, retro, grey, damped": made_fit(
        HalfDifference(stretch=5.0), ("retro",), (0,), damped=True),
    "half and difference, stretched by 33, sheen": made_fit(HalfDifference(stretch=33.0), ("sheen",)),
    "half and difference, stretched by 2, all lobes, two columns, damped": made_fit(
        HalfDifference(stretch=2.0), ("retro", "mirror", "sheen"), (0, 1, 0), damped=True),
    "half and difference, softened by 0.3, stretched by 12": made_fit(HalfDifference(0.3, 12.0), ("mirror", "retro")),
    "Rusinkiewicz": made_fit(Rusinkiewicz()),
    "Rusinkiewicz, sheen, grey, damped": made_fit(Rusinkiewicz(), ("sheen",), (0,), damped=True),
    "Rusinkiewicz, stretched by 5, retro and sheen, one column, damped": made_fit(
        Rusinkiewicz(stretch=5.0), ("retro", "sheen"), (0, 0, 0), damped=True),
    "Rusinkiewicz, stretched by 33, all lobes, damped": made_fit(
        Rusinkiewicz(stretch=33.0), ("mirror", "retro", "sheen"), damped=True),
    "Rusinkiewicz, stretched by 12, two lobes of a kind, grey": made_fit(
        Rusinkiewicz(stretch=12.0), ("retro", "mirror", "mirror"), (0,)),
    "Rusinkiewicz, a Lambertian, dense, two columns, damped": made_fit(
        Rusinkiewicz(), (), (0, 1, 1), damped=True, sparse=False),
    "half angle": made_fit(HalfAngle()),
    "half angle, stretched by 300, all lobes, damped": made_fit(
        HalfAngle(300.0), ("mirror", "retro", "sheen"), damped=True),
    "half angle, stretched by 12 and about retro-reflection by 33, retro": made_fit(
        HalfAngle(12.0, 33.0), ("mirror", "retro")),
    "anisotropic Rusinkiewicz": made_fit(AnisotropicRusinkiewicz(12.0, 3.0, 0.4)),
    "anisotropic Rusinkiewicz, all lobes, two columns, damped": made_fit(
        AnisotropicRusinkiewicz(1.0, 1.0), ("mirror", "retro", "sheen"), (0, 1, 0), damped=True),
    "anisotropic Rusinkiewicz, stretched by 33, a Lambertian, dense, grey": made_fit(
        AnisotropicRusinkiewicz(5.0, 33.0, -3.0), (), (0,), sparse=False),
    "anisotropic Rusinkiewicz, stretched by 5, fibres": made_fit(
        AnisotropicRusinkiewicz(5.0, 5.0, 1.0), ("fibre", "mirror", "fibre")),
    "anisotropic Nusselt, mirror": made_fit(AnisotropicNusselt()),
}
