"""Lattices of the field of a Gaussian process, found from its mean (`fit_to_field`) or, of many samples, without it
(`fit_to_samples`).

The mean minimises the squared errors at the samples plus noise times the field's squared norm in the kernel's Hilbert
space (C. E. Rasmussen, C. K. I. Williams: Gaussian Processes for Machine Learning, 2006, section 6.2). Of many samples
the norm is that of the dense lattice's control points, c^T K^-1 c with the kernel's covariance K of their places, and a
multiple of the squared control points of the sparse lattice.
"""

import math
from collections.abc import Callable, Sequence

import numpy as np

from .. import progress
from ..arrays import ArrayLike, Directions, FloatArray, IntArray, concatenate_directions, select_directions
from ..coordinates import Coordinates
from ..lattice import dense, mba, sparse
from ..lattice.dense import DenseLattice
from ..lattice.normal_equations import NormalEquations, gains, select_largest
from ..lattice.positive_definite import inverse_root
from ..lattice.sparse import SparseLattice
from ..model.transform import LogRelative
from ..samples import Samples, subsample, subset
from . import extrapolation
from .gaussian_process import Field, Kernel
from .highlight import HighlightColour
from .levels import Levels
from .prior import WEIGHT

_BETWEEN = 1000             # directions between the samples at which the sparse lattice follows the field
_NEAR = 30                  # degrees from the mirror direction, up to which half of them lie
_AZIMUTHS = 16              # averaged over at exact retro-reflection
MAX_STRATIFIED = 50_000     # samples that lattices are fitted to: of a few thousand control points more say no more
_CANDIDATES = 4 * MAX_STRATIFIED     # samples of which these are chosen
_STRATA, _STRATIFIED = 4096, 0.35   # of a grid, in each of which as many are chosen, and their share; the rest anywhere
_FINEST = {3: 4, 4: 2}      # by the number of axes, level of the largest dense lattice whose equations are solved: a
                            # finer one is refined from it, and corrected where that helps most
_TRIED = {3: 3, 4: 2}       # likewise, of the lattice whose likelihood is computed
_FOLDS, _STEPS_PER_DEGREE = 5, 2    # of the cross-validation; incidences that are told apart in a degree
_ALIKE_ERRORS = 1.06        # errors of kernels up to this ratio are no different
_PRIOR_PRECISION = 0.1      # of a control point that moves from the spline through the nodes: errors at as many samples
                            # as that count as much as a move (.01 follows 1,439 samples too closely, 1 few too little)
_VARIANCE = 1e-3            # of a sparse control point, relative to the field's
RIDGE = 1e-2                # of the mean diagonal, of the sparse lattice of few samples: keeps the spline from
                            # overshooting between close samples of different values
_MOST_UNKNOWNS = 4500       # control points that are fitted together: memory is the square of it
_BATCHES = {3: 2, 4: 3}     # by the number of axes, in which the control points of the sparse lattice are chosen
_JITTER = 1e-4              # makes the covariance of the control points invertible
_PRECISE = 0.02             # deviation of a sample, relative to it, up to which it is trusted like any other


def fit_to_field(samples: Samples, coordinates: Coordinates, transform: LogRelative, field: Field, levels: Levels,
                 highlight: HighlightColour | None = None) -> tuple[DenseLattice, SparseLattice | None]:
    """Fit the lattices to a field over 2 x - 1 of the coordinates x, given its isotropic samples and their
    highlight."""
    progress.report(0.0, "Fitting the dense lattice")
    # interpolate the field at the nodes
    nodes = dense.nodes(levels.diffuse)
    x = nodes.reshape(-1, nodes.shape[-1])
    flat, at = field.predict(2 * x - 1), coordinates.decode(x)
    values = flat.reshape(*nodes.shape[:-1], -1)            # the same array
    if levels.diffuse:
        values[0] = _mean_over_azimuths(field, 2 * nodes[0] - 1)
    _transfer_last_colour(flat, at, samples, coordinates, field)
    if highlight is not None:
        values = highlight.blend(at, flat).reshape(values.shape)
    box = dense.interpolate(values, levels.diffuse)
    progress.report(0.2)
    # what else the lattices follow: the field at the samples, and between them
    between = _random_directions(samples)
    directions = concatenate_directions([samples.directions, between])
    x = coordinates.encode(*directions)
    wanted = np.concatenate([field.at_samples, field.predict(2 * x[len(samples):] - 1)])
    if highlight is not None:
        wanted = highlight.blend(directions, wanted)
    # together the directions between weigh as much as the samples
    share = np.concatenate([np.ones(len(samples)), np.full(_BETWEEN, math.sqrt(len(samples) / _BETWEEN))])
    bright = np.maximum(transform.reflectance(wanted, *directions), 0).mean(axis=1) + transform.offset
    weights = share * bright ** WEIGHT
    weights /= math.sqrt(np.mean(weights ** 2))
    # move the control points that matter most, by regularised least squares
    if levels.diffuse <= _FINEST[x.shape[1]]:       # a finer one interpolates well enough
        residual = wanted - dense.evaluate(box, levels.diffuse, x)
        chosen = _most_useful(x, levels.diffuse, weights, residual, _MOST_UNKNOWNS, np.zeros(0, int))
        norm = np.full(len(chosen), _PRIOR_PRECISION)
        moves, = NormalEquations(x, [(levels.diffuse, chosen)]).solve(weights, residual, [norm])
        box += _scatter_to_box(levels.diffuse, x.shape[1], chosen, moves)
    diffuse = DenseLattice(levels.diffuse, box.astype(np.float32))
    if levels.specular is None:
        return diffuse, None
    progress.report(0.3, "Fitting the sparse lattice")
    return diffuse, sparse_fit(x, wanted - diffuse.evaluate(x), weights, levels.specular, levels.kept_count(3))


def sparse_fit(x: FloatArray, z: FloatArray, weights: FloatArray, level: int, count: int) -> SparseLattice:
    """A sparse lattice of at most `count` control points by ridge regression: those of the largest magnitude in the
    B-spline approximation of weighted values z, (n, channels), fitted again, all together (where Kameya and Lewis 2002,
    section 4.1, keep them as they are): far fewer then reach the same error."""
    magnitude = np.abs(mba.basis_approximation(x, z * weights[:, None], level)).max(axis=-1).ravel()
    axes = x.shape[1]
    keys = select_largest(magnitude, dense.representative(level, axes).ravel(), count)
    control_points, = NormalEquations(x, [(level, keys)]).solve(weights, z, ridge=RIDGE)
    return sparse.keep(_scatter_to_box(level, axes, keys, control_points), level, keys)


def _transfer_last_colour(values: FloatArray, at: Directions, samples: Samples, coordinates: Coordinates,
                          field: Field) -> None:
    """Give values at directions, (n, channels), outside the measured domain the colour of its edge."""
    limits = extrapolation.measured_domain(samples)
    which = extrapolation.is_extrapolated(at[0], at[2], limits)
    at = select_directions(at, which)
    there = field.predict(2 * coordinates.encode(*extrapolation.clamp_to_domain(at, limits)) - 1)
    far = extrapolation.extrapolation_distance(at[0], at[2], limits)[:, None]
    values[which] += far * (extrapolation.transfer_colour(there, values[which]) - values[which])


def _mean_over_azimuths(field: Field, mu: FloatArray) -> FloatArray:
    """The mean of a field over azimuths of the half vector, at nodes (b, c, 3) of d = 0, retro-reflection."""
    radius, which = np.unique(np.round(np.hypot(mu[..., 1], mu[..., 2]), 9), return_inverse=True)
    turn = (np.arange(_AZIMUTHS) + 0.5) * (np.pi / 2 / _AZIMUTHS)       # a quarter: the field is even in x and y there
    ring = np.stack([0 * np.outer(radius, turn), np.outer(radius, np.cos(turn)), np.outer(radius, np.sin(turn))], -1)
    mean = field.predict(ring.reshape(-1, 3)).reshape(len(radius), _AZIMUTHS, -1).mean(axis=1)
    return np.asarray(mean[which.reshape(mu.shape[:-1])])


def _random_directions(samples: Samples) -> Directions:
    """Directions at which the field is followed, as far as samples reach, half of them near the mirror's: four (n,)."""
    rng = np.random.default_rng(0)
    farthest = max(samples.theta_i.max(), samples.theta_o.max())
    theta_i, theta_o = farthest * np.sqrt(rng.random((2, _BETWEEN)))
    turn = np.pi * rng.random(_BETWEEN)
    near = slice(0, _BETWEEN // 2)
    # offsets from the mirror direction, in the plane of incidence and across it: evenly in the logarithm, over 2.5
    # decades
    size = np.radians(_NEAR) * 10 ** (-2.5 * rng.random(_BETWEEN // 2))
    angle = 2 * np.pi * rng.random(_BETWEEN // 2)
    theta_o[near] = np.clip(theta_i[near] + size * np.cos(angle), 0, farthest)
    turn[near] = np.pi - np.minimum(np.abs(size * np.sin(angle)) / np.maximum(np.sin(theta_i[near]), 0.1), np.pi)
    return theta_i, np.zeros(_BETWEEN), theta_o, turn


def fit_to_samples(samples: Samples, coordinates: Coordinates, transform: LogRelative, kernel: Kernel, levels: Levels,
                   ) -> tuple[DenseLattice, SparseLattice | None]:
    """Fit a dense lattice to many samples, and a sparse one to what it leaves, by regularised least squares."""
    # a stratified sample, `represented` of which each stands for
    used = subsample(samples, _CANDIDATES)
    x, axes = coordinates.encode(*used.directions), len(coordinates.axes)
    which, represented = stratified_sample(x)
    x, used = x[which], subset(used, which)
    z, weights = transform.field(used.values, *used.directions), _weights(used, transform.offset, represented)

    progress.report(0.0, "Fitting the dense lattice")
    # the dense lattice, with the precision of the kernel as its prior
    no_keys = np.zeros(0, int)
    level, finer = min(levels.diffuse, _FINEST[axes]), levels.diffuse
    regularisation = kernel.noise * precision(level, axes, kernel)
    control_points, = NormalEquations(x, [(level, None)]).solve(weights, z, [regularisation])
    box = _refine_box(control_points, level, finer, axes)
    # extrapolated directions count as samples of what follows, with light and view in either order
    limits = extrapolation.measured_domain(samples)
    guessed = extrapolation.sample_extrapolated(limits, samples.isotropic)
    if len(guessed[0]):
        unmeasured, measured = ([coordinates.encode(*each) for each in (pairs, (*pairs[2:], *pairs[:2]))]
                                for pairs in (guessed, extrapolation.clamp_to_domain(guessed, limits)))
        continued, last = (np.mean([dense.evaluate(box, finer, each) for each in orders], axis=0)
                           for orders in (unmeasured, measured))
        guesses = extrapolation.extrapolate(continued, last)
        x, z = np.concatenate([x, *unmeasured]), np.concatenate([z, guesses, guesses])
        weights = np.concatenate([weights, np.ones(2 * len(guesses))])
    # of a finer dense lattice only some control points move
    if level < finer:
        residual = z - dense.evaluate(box, finer, x)
        chosen = _most_useful(x, finer, weights, residual, _MOST_UNKNOWNS, no_keys)
        box += _scatter_to_box(finer, axes, chosen, _solve_control_points(x, finer, chosen, weights, residual, kernel))
    if levels.specular is None:
        return DenseLattice(finer, box.astype(np.float32)), None
    # the sparse lattice, in batches of the control points that matter most
    keys, specular = no_keys, _scatter_to_box(levels.specular, axes, no_keys, z[:0])
    for number in range(_BATCHES[axes]):
        progress.report(0.4 + 0.6 * number / _BATCHES[axes], "Fitting the sparse lattice")
        residual = z - dense.evaluate(box, finer, x) - dense.evaluate(specular, levels.specular, x)
        count = min(levels.kept_count(axes) // _BATCHES[axes], _MOST_UNKNOWNS)
        chosen = _most_useful(x, levels.specular, weights, residual, count, keys)
        keys = np.union1d(keys, chosen)
        if level == finer and len(control_points) + len(keys) <= _MOST_UNKNOWNS:
            equations = NormalEquations(x, [(level, None), (levels.specular, keys)])
            control_points, of_sparse = equations.solve(weights, z, [regularisation, _independent(keys, kernel)])
            box = _refine_box(control_points, level, finer, axes)
            specular = _scatter_to_box(levels.specular, axes, keys, of_sparse)
        else:
            of_sparse = _solve_control_points(x, levels.specular, chosen, weights, residual, kernel)
            specular += _scatter_to_box(levels.specular, axes, chosen, of_sparse)
    return DenseLattice(finer, box.astype(np.float32)), sparse.keep(specular, levels.specular, keys)


def stratified_sample(x: FloatArray) -> tuple[IntArray, FloatArray]:
    """A stratified random sample of at most `MAX_STRATIFIED` of coordinates (n, axes) in [0, 1]: their indices, and how
    many each stands for. Some are of the cells of a grid, as many of each: about a mirror direction a table may have a
    handful amid millions elsewhere, of which a random sample has none, and lattices have spikes and holes."""
    if len(x) <= MAX_STRATIFIED:
        return np.arange(len(x)), np.ones(len(x))
    side = round(_STRATA ** (1 / x.shape[1]))
    cell = np.ravel_multi_index(tuple(np.minimum((x * side).astype(np.int64), side - 1).T), (side,) * x.shape[1])
    random = np.random.default_rng(0)
    shuffled = random.permutation(len(x))
    order = shuffled[np.argsort(cell[shuffled], kind="stable")]
    _, first, counts = np.unique(cell[order], return_index=True, return_counts=True)
    number_in_cell = np.arange(len(x)) - np.repeat(first, counts)
    of_cells, others = np.split(order[np.argsort(number_in_cell, kind="stable")], [round(_STRATIFIED * MAX_STRATIFIED)])
    chosen = np.sort(np.concatenate([of_cells, random.permutation(others)[:MAX_STRATIFIED - len(of_cells)]]))
    kept = np.bincount(cell[chosen], minlength=side ** x.shape[1])
    return chosen, np.bincount(cell, minlength=len(kept))[cell[chosen]] / kept[cell[chosen]]


def _most_useful(x: FloatArray, level: int, weights: FloatArray, residual: FloatArray, count: int,
                 known: IntArray) -> IntArray:
    """The control points, other than those known, that can each lower the errors most: positions in the box."""
    gain = gains(x, level, weights, residual)
    gain[known] = 0
    return select_largest(gain, dense.representative(level, x.shape[1]).ravel(), count)


def _solve_control_points(x: FloatArray, level: int, keys: IntArray, weights: FloatArray, residual: FloatArray,
                          kernel: Kernel) -> FloatArray:
    """Independent control points that follow a residual, by regularised least squares: (k, channels)."""
    control_points, = NormalEquations(x, [(level, keys)]).solve(weights, residual, [_independent(keys, kernel)])
    return control_points


def _independent(keys: IntArray, kernel: Kernel) -> FloatArray:
    """The norm of independent control points, of errors as `precision` has it: (k,)."""
    return np.full(len(keys), kernel.noise / _VARIANCE)


def _weights(samples: Samples, offset: float, stood_for: ArrayLike = 1.0) -> FloatArray:
    """What errors of the field at samples that each stand for some are multiplied by: (n,)."""
    bright = np.maximum(samples.values, 0).mean(axis=1) / offset + 1
    weights = (bright * np.cos(samples.theta_o)) ** WEIGHT      # reflectance is seen times its cosine
    if samples.deviation is not None:
        weights /= np.hypot(1, samples.deviation / _PRECISE)
    weights *= np.sqrt(stood_for)
    return np.asarray(weights / math.sqrt(np.mean(weights ** 2)))       # the kernel's noise is that of the mean sample


def likelihoods(samples: Samples, systems: Sequence[Coordinates], transforms: Sequence[LogRelative], kernel: Kernel,
                ) -> FloatArray:
    """The log-likelihood of each value of many samples in systems of as many axes, above priors of one offset, with a
    dense lattice for the field: (systems, transforms); constants are left out.

    The control points have the kernel's covariance, and the samples noise that falls with their weights; the variance
    of the field is the most likely one of each channel (Rasmussen and Williams, equations 5.8, and A.9 and A.10, by
    which its matrices have the size of the lattice).
    """
    weights = _weights(samples, transforms[0].offset)
    z = np.concatenate([each.field(samples.values, *samples.directions) for each in transforms], axis=1)
    total = ((weights[:, None] * z) ** 2).sum(axis=0)
    axes = len(systems[0].axes)
    level = _TRIED[axes]
    first = np.unique(dense.representative(level, axes))
    inverse = precision(level, axes, kernel)[first[:, None], first]
    of_lattice = np.linalg.slogdet(inverse)[1] + len(first) * np.log(kernel.noise)
    values = np.empty((len(systems), len(transforms)))
    for number, system in enumerate(systems):
        equations = NormalEquations(system.encode(*samples.directions), [(level, None)])
        matrix, moment = equations.reduced_system(weights, z)
        root = np.linalg.cholesky(matrix + kernel.noise * inverse)
        squares = np.maximum(total - (np.linalg.solve(root, moment) ** 2).sum(axis=0), np.finfo(float).tiny)
        logarithms = 2 * np.log(np.diag(root)).sum() - of_lattice
        values[number] = (-0.5 * np.log(squares).reshape(len(transforms), -1).mean(axis=1)
                          - 0.5 * logarithms / len(samples))
    return values


def incidence_error(samples: Samples, coordinates: Coordinates, transform: LogRelative) -> Callable[[Kernel], float]:
    """The error of a kernel by cross-validation: the root mean square of weighted errors with which a dense lattice
    predicts whole incidences of many samples that it has not seen, between the flattest and the steepest, in `_FOLDS`
    folds; of samples without any, single ones."""
    axes = len(coordinates.axes)
    level = _TRIED[axes]
    first, unknown = np.unique(dense.representative(level, axes).ravel(), return_inverse=True)
    x, z = coordinates.encode(*samples.directions), transform.field(samples.values, *samples.directions)
    weights, fold = _weights(samples, transform.offset), _folds(samples)
    parts = [out for out in (fold == number for number in range(_FOLDS)) if out.any() and not out.all()]
    systems = [NormalEquations(x[~out], [(level, None)]).reduced_system(weights[~out], z[~out]) for out in parts]

    def error(kernel: Kernel) -> float:
        inverse, errors = kernel.noise * precision(level, axes, kernel)[first[:, None], first], []
        for out, (matrix, moment) in zip(parts, systems, strict=True):
            box = np.linalg.solve(matrix + inverse, moment)[unknown].reshape(*dense.shape(level, axes), -1)
            errors.append(weights[out, None] * (dense.evaluate(box, level, x[out]) - z[out]))
        return float(np.sqrt(np.mean(np.concatenate(errors) ** 2))) if errors else 0.0

    return error


def select_kernel(kernels: Sequence[Kernel], error: Callable[[Kernel], float]) -> Kernel:
    """The first of kernels whose error is about the least, as far as so coarse a lattice shows."""
    errors = [error(kernel) for kernel in kernels]
    return next(kernel for kernel, each in zip(kernels, errors, strict=True) if each <= _ALIKE_ERRORS * min(errors))


def _folds(samples: Samples) -> IntArray:
    """The fold of the cross-validation in which each sample is left out, (n,), with all others of its incidence: -1 for
    never, as nothing beyond the flattest and the steepest incidences is measured."""
    steps = np.rint(np.degrees(samples.theta_i) * _STEPS_PER_DEGREE).astype(np.int64)
    incidences = steps
    if not samples.isotropic:
        turn = 360 * _STEPS_PER_DEGREE
        azimuths = np.rint(np.degrees(samples.phi_i) * _STEPS_PER_DEGREE).astype(np.int64)
        incidences = steps * turn + azimuths % turn
    between = (steps > steps.min()) & (steps < steps.max())
    if not between.any():
        return np.arange(len(samples)) % _FOLDS
    return np.where(between, np.unique(incidences, return_inverse=True)[1] % _FOLDS, -1)


def _scatter_to_box(level: int, axes: int, keys: IntArray, control_points: FloatArray) -> FloatArray:
    """The box of control points that are the sums of some: (k,) positions and (k, channels)."""
    box = np.zeros((math.prod(dense.shape(level, axes)), control_points.shape[1]))
    np.add.at(box, keys, control_points)
    return box.reshape(*dense.shape(level, axes), -1)


def _refine_box(control_points: FloatArray, level: int, finer: int, axes: int) -> FloatArray:
    """The box of a finer level that has the spline of control points (points, channels)."""
    return dense.refine_to_level(control_points.reshape(*dense.shape(level, axes), -1), level, finer)


def precision(level: int, axes: int, kernel: Kernel) -> FloatArray:
    """The inverse of a kernel's covariance of the places of a dense lattice's control points, (points, points). Of
    mirror images, which are one unknown, the first has all of it."""
    shape, origin = dense.shape(level, axes), dense.origin(level, axes)
    first = np.unique(dense.representative(level, axes))
    places = np.moveaxis(np.indices(shape), 0, -1).reshape(-1, axes)[first] + np.array(origin)
    mu = 2 * places / dense.cells(level) - 1
    covariance = kernel.gram(mu)
    covariance[np.diag_indices(len(mu))] += _JITTER
    matrix = np.zeros((math.prod(shape),) * 2)
    root = inverse_root(covariance)
    matrix[np.ix_(first, first)] = root.T @ root
    return matrix
