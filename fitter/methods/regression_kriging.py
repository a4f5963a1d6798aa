"""Regression kriging: a model of lobes, a Gaussian process of its residuals, and splines that store the result (T.
Hengl, G. B. M. Heuvelink, D. G. Rossiter: About regression-kriging, Computers & Geosciences 33(10), 2007). The steps of
docs/fitting.md are modules: `prior`, `gaussian_process` with `highlight`, `lattices`, which of many samples chooses
coordinates, prior and kernel too, and `energy`."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from operator import attrgetter
from typing import cast

import numpy as np

from .. import progress
from ..arrays import FloatArray
from ..coordinates import Coordinates, half_difference, rusinkiewicz
from ..coordinates.anisotropic_rusinkiewicz import AnisotropicRusinkiewicz
from ..coordinates.half_angle import HalfAngle
from ..coordinates.half_difference import HalfDifference
from ..coordinates.rusinkiewicz import Rusinkiewicz
from ..model.fit import Fit
from ..model.microfacet import Microfacet
from ..model.transform import LEAST_OFFSET, LogRelative, desaturate
from ..quality.physics import direction_pairs
from ..samples import RGB, Samples, subsample
from ..shader_constants import LEAST_LENGTH
from . import energy, gaussian_process, highlight, lattices, prior
from .gaussian_process import RECIPROCITIES, Field, Kernel
from .highlight import HighlightColour
from .levels import Levels

MAX_GAUSSIAN_PROCESS_SAMPLES = 2000         # of a Gaussian process: its cost grows with the cube of the number
CEILING = 4.0               # a fit is at most 4 times the largest sample
_TRIED_STRETCHES = 0.0, 2.0, 5.0, 12.0, 33.0
_STRETCHES_OF_MANY = 5.0, 12.0, 33.0, 100.0, 300.0, 1000.0
_BACK_STRETCH = 33.0        # of many samples above a prior with a lobe about retro-reflection
_RESOLVED = 0.4             # of a stretch times the finest measured half angle: above, cells have no samples
_FEW_HALF_ANGLES = 5        # half angles that may be finer, and samples nearer to retro-reflection
_THINNEST = 0.01            # softening radius of few samples
_SEARCHED = 450             # samples of which the likelihood is computed
_OF_LATTICES = 4000         # samples to which lobes are fitted, and of many those of which it is computed
_ROUGHNESSES = (0.7, 1e-5), (1.0, 1e-4), (1.75, 1e-4), (1.75, 1e-3)     # lengths and noises of kernels for many
                            # samples, from rough fields to smooth ones; under the first the rest is chosen
# samples this many times below the prior count as failures, if they are at most this share
_FAILED_FACTOR, _RARELY = 5.0, 0.01
_FAILURE = 10.0             # variance of the noise of failures, relative to the field's
_EQUAL_ANGLES = np.radians(1)  # polar angles that are taken as equal
_BOTH_WAYS = 0.1            # share of the pairs measured the rarer way, from which samples tell if they are reciprocal
_POSITIVE_SHARE, _MOST_GREY = 0.99, 0.8  # share of the bright samples that grey makes positive; of it, at most
_TYPICAL, _OF_TYPICAL = 400, 10_000     # directions whose median is the offset, and samples that are looked at
_LEAST_OF_LARGEST = 1e-9    # of the largest sample, that the offset is
_MOST_ELONGATED = 10        # ratio of the stretches of an anisotropic half vector


@dataclass(frozen=True, eq=False)
class Estimate:
    """What is known of samples before lattices are fitted: most of the work, which fits of several levels share. Of
    more than `MAX_GAUSSIAN_PROCESS_SAMPLES` samples and of anisotropic ones there is no field; a highlight is None
    where the field keeps its own colours."""

    coordinates: Coordinates
    transform: LogRelative
    kernel: Kernel
    field: Field | None             # over 2 x - 1 of the coordinates x
    highlight: HighlightColour | None
    left_out: FloatArray | None     # each sample as the others predict it, (n, channels), 1/sr; the prior knows all


def estimate(samples: Samples, lobes: Microfacet | None = None) -> Estimate:
    """The likeliest coordinates, prior (`lobes` where known) and kernel of samples, and the field where there are
    few."""
    # priors of one, two and three lobes
    grey = _desaturation(samples.values)
    plain = replace(samples, values=desaturate(samples.values, grey))
    typical = _typical(plain)
    offset = _offset(typical)
    ceiling = CEILING * np.maximum(plain.values.max(axis=0), 1e-6 * offset)
    with progress.part(0.0, 0.4, "Fitting lobes"):
        transforms = [LogRelative(model, offset, ceiling, desaturation=grey)
                      for model in ([lobes] if lobes is not None else
                                    prior.candidates(subsample(plain, _OF_LATTICES), typical, offset))]
    if not samples.isotropic or len(samples) > MAX_GAUSSIAN_PROCESS_SAMPLES:
        progress.report(0.4, "Fitting shape")
        return _estimate_many(samples, transforms)
    # the maximum likelihood over coordinates, kernel and prior
    families = _families(samples, transforms[-1].prior)
    searched = subsample(samples, _SEARCHED)
    systems = [system for family in families for system in family]
    search = gaussian_process.Search(
        [_mu(system, searched) for system in systems],
        [each.field(searched.values, *searched.directions) for each in transforms],
        [_information_criterion(each.prior, searched.values.size) for each in transforms],
        _known_noise(searched, transforms[-1]), _reciprocities(samples))
    numbers = np.split(np.arange(len(systems)), np.cumsum([len(family) for family in families])[:-1])
    with progress.part(0.4, 0.8, "Fitting shape"):
        likeliest = max((search.maximise(each.tolist()) for each in progress.each(numbers)), key=attrgetter("value"))
    progress.report(0.8, "Fitting shape")
    # the field of all samples, and the colour of its highlight
    coordinates, transform = systems[likeliest.system], transforms[likeliest.prior]
    known = _known_noise(samples, transform)
    field, left_out = gaussian_process.krige(
        _mu(coordinates, samples), transform.field(samples.values, *samples.directions), likeliest.kernel, known)
    room = replace(cast(HalfDifference | Rusinkiewicz, coordinates), stretch=_TRIED_STRETCHES[-1])
    found, left_out = highlight.find(samples, transform, room, known, left_out)
    plausible = replace(transform, floor=0.0)
    return Estimate(coordinates, transform, likeliest.kernel, field, found,
                    plausible.reflectance(left_out, *samples.directions))


def _estimate_many(samples: Samples, transforms: Sequence[LogRelative]) -> Estimate:
    """The likeliest coordinates and prior of many samples, and the kernel that predicts incidences best which it has
    not seen: how densely directions are covered decides how rough a field they tell."""
    systems = [system for family in _families(samples, transforms[-1].prior) for system in family]
    fewer, reciprocities = subsample(samples, _OF_LATTICES), _reciprocities(samples)
    kernels = [Kernel(length, noise, reciprocities[0]) for length, noise in _ROUGHNESSES]
    costs = np.array([_information_criterion(each.prior, fewer.values.size) for each in transforms])
    values = lattices.likelihoods(fewer, systems, transforms, kernels[0]) - costs
    first, number = divmod(int(values.argmax()), len(transforms))
    system, transform = systems[first], transforms[number]
    # a peak about retro-reflection gets room where it is part of the prior
    narrow = [HalfAngle(each.stretch, _BACK_STRETCH) for each in systems if isinstance(each, HalfAngle)]
    if narrow and "retro" in transform.prior.kinds:
        back = lattices.likelihoods(fewer, narrow, [transform], kernels[0])[:, 0] - costs[number]
        if back.max() > values[first, number]:
            system = narrow[int(back.argmax())]
    progress.report(0.6)
    error = lattices.incidence_error(subsample(samples, lattices.MAX_STRATIFIED), system, transform)
    kernel = lattices.select_kernel(kernels, error)
    if len(reciprocities) > 1:
        kernel = min((replace(kernel, reciprocity=each) for each in reciprocities), key=error)
    return Estimate(system, transform, kernel, None, None, None)


def _information_criterion(model: Microfacet, values: int) -> float:
    """The price of a prior's parameters (G. Schwarz: Estimating the Dimension of a Model, Annals of Statistics 6(2),
    1978)."""
    return 0.5 * math.log(values) * prior.parameter_count(model) / values


def _mu(coordinates: Coordinates, samples: Samples) -> FloatArray:
    return 2 * coordinates.encode(*samples.directions) - 1


def _families(samples: Samples, model: Microfacet) -> list[list[Coordinates]]:
    """Systems of coordinates, each with its stretches: of few samples those that say most of directions where none are,
    of many the one in which a lattice shows most; of anisotropic ones, also along the narrowest lobe's axes."""
    stretches = [each for each in _STRETCHES_OF_MANY if each * _finest(samples) < _RESOLVED]
    if samples.isotropic:
        if len(samples) > MAX_GAUSSIAN_PROCESS_SAMPLES:
            return [[HalfAngle(stretch) for stretch in (0.0, 2.0, *stretches)]]
        softening = _softening(samples)
        return [[HalfDifference(softening, stretch) for stretch in _TRIED_STRETCHES],
                [Rusinkiewicz(rusinkiewicz.SINES * softening, stretch) for stretch in _TRIED_STRETCHES]]
    stretches = stretches or [_STRETCHES_OF_MANY[0]]
    families: list[list[Coordinates]] = [[AnisotropicRusinkiewicz(each, each) for each in stretches]]
    if not model.isotropic:
        narrowest = int(np.argmin(np.where(model.across == model.alpha, np.inf, np.minimum(model.alpha, model.across))))
        alpha, across = model.alpha[narrowest], model.across[narrowest]
        least = max(min(alpha, across), max(alpha, across) / _MOST_ELONGATED)
        shares = least / max(alpha, least), least / max(across, least)      # at most 1, but for rounding
        families.append([AnisotropicRusinkiewicz(each * min(shares[0], 1.0), each * min(shares[1], 1.0),
                                                 float(model.turn[narrowest])) for each in stretches])
    return families


def _finest(samples: Samples) -> float:
    """The radius of the half angle up to which samples tell what a highlight is like, in the plane of incidence: across
    it steps of the azimuth are as fine as one likes at small polar angles."""
    radius = 2 * HalfAngle().encode(*samples.directions)[:, 0] - 1
    along = np.abs(samples.theta_i - samples.theta_o)
    across = np.sin(samples.theta_o) * np.arccos(-np.cos(samples.phi_o - samples.phi_i))
    return _sixth_smallest(radius[(radius > LEAST_LENGTH) & (across <= along)])


def _softening(samples: Samples) -> float:
    """The softening radius about retro-reflection: as wide as nobody measured there."""
    distance = 2 * HalfDifference(rusinkiewicz.LEAST_SOFTENING).encode(*samples.directions)[:, 0] - 1
    return float(np.clip(_sixth_smallest(distance) / 2, _THINNEST, half_difference.HALF_DIFFERENCE_SOFTENING))


def _sixth_smallest(numbers: FloatArray) -> float:
    """The sixth smallest of numbers, up to 1."""
    return float(np.sort(np.append(numbers, np.ones(_FEW_HALF_ANGLES + 1)))[_FEW_HALF_ANGLES])


def fit(samples: Samples, levels: Levels, plausible: bool = True, estimated: Estimate | None = None) -> Fit:
    """Fit samples by regression kriging; `estimated` is what `estimate` returned for them."""
    if estimated is None:
        with progress.part(0.0, 0.6):
            estimated = estimate(samples)
        with progress.part(0.6, 1.0):
            return fit(samples, levels, plausible, estimated)
    transform = replace(estimated.transform, floor=0.0) if plausible else estimated.transform
    with progress.part(0.0, 0.8 if samples.isotropic else 0.5):
        if estimated.field is not None:
            both = lattices.fit_to_field(samples, estimated.coordinates, transform, estimated.field, levels,
                                         estimated.highlight)
        else:
            levels = levels if samples.isotropic else levels.four_axis_levels()
            both = lattices.fit_to_samples(samples, estimated.coordinates, transform, estimated.kernel, levels)
    fitted = Fit(estimated.coordinates, *both, transform, levels.effective_compression, samples.channels,
                 name=samples.name, source=samples.source)
    with progress.part(0.8 if samples.isotropic else 0.5, 1.0, "Checking the energy"):
        return energy.conserve_energy(fitted, transform, samples) if plausible else fitted


def _reciprocities(samples: Samples) -> Sequence[float]:
    """Those among which samples choose: of nearly all pairs measured one way, nothing tells how they differ from those
    measured the other way, and the field is reciprocal."""
    apart = samples.theta_i - samples.theta_o
    apart = apart[np.abs(apart) > _EQUAL_ANGLES]
    both_ways = len(apart) and min((apart > 0).mean(), (apart < 0).mean()) >= _BOTH_WAYS
    return RECIPROCITIES if both_ways else RECIPROCITIES[-1:]


def _known_noise(samples: Samples, transform: LogRelative) -> FloatArray:
    """The variance of each sample's noise beyond that of the kernel, relative to the field's, (n,): of repeated
    measurements, their scatter. A few samples far below the prior are failures of a detector, which reads next to
    nothing amid a lobe; where there are many, it is the prior that fails."""
    field = transform.field(samples.values, *samples.directions)
    failed = field.mean(axis=1) < -math.log(_FAILED_FACTOR)
    noise = np.where(failed & (failed.mean() <= _RARELY), _FAILURE, 0.0)
    if samples.deviation is not None:
        bright = np.abs(samples.values).mean(axis=1)
        in_field = samples.deviation * bright / (bright + transform.offset)
        noise += in_field ** 2 / max(np.mean(field ** 2), np.finfo(float).tiny)
    return np.asarray(noise)


def _desaturation(values: FloatArray) -> float:
    """`LogRelative.desaturation` with which nearly all bright samples, (n, channels), are positive."""
    if values.shape[1] != len(RGB):
        return 0.0
    mean, least = values.mean(axis=1), values.min(axis=1)
    bright = (mean >= np.median(mean)) & (mean > least) & (mean > 0)
    shares = np.maximum(-least[bright], 0) / (mean - least)[bright]
    return float(min(np.quantile(shares, _POSITIVE_SHARE), _MOST_GREY)) if len(shares) else 0.0


def _typical(samples: Samples) -> FloatArray:
    """The values of the samples nearest to directions spread evenly, (n, channels), 1/sr: most may lie in a peak."""
    system = HalfDifference() if samples.isotropic else AnisotropicRusinkiewicz()
    chosen = subsample(samples, _OF_TYPICAL)
    places = system.encode(*chosen.directions)
    return chosen.values[[int(np.argmin(((places - each) ** 2).sum(axis=1)))
                        for each in system.encode(*direction_pairs(_TYPICAL))]]


def _offset(typical: FloatArray) -> float:
    """The median of typical values, 1/sr; zeros, of which a detector that sees nothing gives many, have no size."""
    sizes = np.abs(typical[typical != 0])
    return float(max(np.median(sizes), _LEAST_OF_LARGEST * sizes.max(), LEAST_OFFSET)) if len(sizes) else 1.0
