"""The reflected radiance that closure nodes are fitted to: by polar angle of the viewer, over incident directions."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..arrays import FloatArray, RealArray, unit_vectors
from ..model import Reflectance
from . import direction_grid
from .direction_grid import OUTGOING_COUNT, IncidentDirections
from .node_lobes import Pairs

_VIEW_POLAR, _VIEW_AZIMUTHS = 13, 9  # tabulated viewing directions of an anisotropic fit, over a turn; an odd number of
                                # azimuths differ where half a turn changes nothing, too
_DARKER, _DARKER_CHANNEL = 0.33, 0.5        # powers of the reciprocal radiance, and of that of a channel's albedo
_MEAN_FLOOR, _CHANNEL_FLOOR = 0.05, 0.03    # shares of the mean above which both are taken
_DARK_VALUE = 1e-12


@dataclass(frozen=True, eq=False)
class OutgoingDirections:
    """What is seen from polar angles of the viewer, each with azimuths: of an isotropic fit only 0; of an anisotropic
    one in the principal axes. Arrays of directions are in single precision."""

    theta: FloatArray               # (views,), radians
    azimuthal_basis: FloatArray     # (azimuths, 1 or 2): colours of a lobe times 1, or cos^2 and sin^2 of the azimuth
    pairs: Pairs                    # arrays (views, azimuths, ...)
    solid_angle: RealArray          # of each incident direction, (views, azimuths, n); 0 below the horizon
    target: RealArray               # f cos theta_i, (views, channels, azimuths, n)
    importance: RealArray  # by what errors are multiplied, as they are seen: more in dark directions and channels

    @cached_property
    def albedo(self) -> FloatArray:
        """The reflected share of an even light: (views, azimuths, channels)."""
        return self.reflected_light(self.target)

    @cached_property
    def brightness(self) -> FloatArray:
        """The mean over the azimuths of the sum over the channels of the albedo: (views,)."""
        return np.maximum(self.albedo.mean(axis=1).sum(axis=-1), _DARK_VALUE)

    @cached_property
    def target_rows(self) -> RealArray:
        """`rows` of the target; the weights of closures are to add to its albedo."""
        return self.rows(self.target, np.swapaxes(self.albedo, 1, 2).astype(self.target.dtype))

    @cached_property
    def weight(self) -> RealArray:
        """Solid angle and importance of the target's rows, in the light: (views, channels, azimuths, n)."""
        share = self.solid_angle / self.brightness[:, None, None]
        return np.asarray(self.importance * share.astype(self.target.dtype)[:, None])

    def reflected_light(self, radiance: RealArray) -> FloatArray:
        """The integral over the hemisphere: (views, channels, azimuths, n) to (views, azimuths, channels)."""
        return np.asarray(np.einsum("van,vcan->vac", self.solid_angle, radiance), dtype=float)

    def rows(self, values: RealArray, weights: RealArray) -> RealArray:
        """Values at all directions of a view, (views, ..., azimuths, n), what they sum to over the hemisphere, and what
        is given beside them, (views, ..., azimuths), in one axis: (views, ..., azimuths * (n + 2))."""
        axes = values.ndim - self.solid_angle.ndim
        solid_angle = self.solid_angle.reshape(len(self.theta), *(1,) * axes, *self.solid_angle.shape[1:], 1)
        whole = np.concatenate([values, (values[..., None, :] @ solid_angle)[..., 0], weights[..., None]], axis=-1)
        return whole.reshape(*values.shape[:-2], -1)

    def select(self, views: slice, directions: slice) -> "OutgoingDirections":
        """Some of the views and directions; these stand for those that are left out."""
        count = self.solid_angle.shape[2]
        scale = count / len(range(count)[directions])
        chosen = (np.ascontiguousarray(each[views, ..., directions])
                  for each in (self.solid_angle * self.solid_angle.dtype.type(scale), self.target, self.importance))
        pairs = self.pairs.select(views, directions)
        return OutgoingDirections(self.theta[views], self.azimuthal_basis, pairs, *chosen)

    def directional_error(self, radiance: RealArray) -> FloatArray:
        """The share of light that (views, channels, azimuths, n) radiance has in wrong directions: (views,)."""
        difference = np.abs(self.target - radiance).sum(axis=1)
        return np.asarray((self.solid_angle * difference).sum(axis=2).mean(axis=1) / self.brightness)


def tabulate_outgoing(fit: Reflectance, turn: float | None, stretch: float = 1.0) -> OutgoingDirections:
    """The outgoing directions of a fit, and its values there. `turn` is the azimuth of the first principal axis,
    radians, None for an isotropic fit. Every other angle is one that nodes tabulate."""
    if turn is None:
        theta = direction_grid.outgoing_angles(OUTGOING_COUNT)
        grids = [direction_grid.mirror_grid(angle) for angle in theta]
        to = IncidentDirections(*(np.stack(arrays)[:, None] for arrays in zip(*grids, strict=True)))
        phi_o, phases = np.zeros((1,)), np.ones((1, 1))
    else:
        theta = direction_grid.outgoing_angles(_VIEW_POLAR)
        phi_o = np.arange(_VIEW_AZIMUTHS) * 2 * np.pi / _VIEW_AZIMUTHS
        phases = np.stack([np.cos(phi_o) ** 2, np.sin(phi_o) ** 2], axis=1)
        grids = [direction_grid.half_vector_grid(unit_vectors(angle, phi_o), stretch) for angle in theta]
        to = IncidentDirections(*(np.stack(arrays) for arrays in zip(*grids, strict=True)))
    wo = unit_vectors(theta[:, None], phi_o)
    above, turned = to.solid_angle > 0, turn or 0.0
    outgoing = [np.broadcast_to(angle, above.shape)[above] for angle in (theta[:, None, None], phi_o[:, None] + turned)]
    value = fit.evaluate(to.theta[above], to.phi[above] + turned, *outgoing)
    target = np.zeros((value.shape[-1], *above.shape), np.float32)
    target[:, above] = (np.maximum(value, 0) * to.unit[above][:, 2:]).T
    target = np.ascontiguousarray(np.swapaxes(target, 0, 1))
    # a microfacet lobe is symmetric about the plane of the viewer or, of an anisotropic fit, about the principal axes
    tangent = np.broadcast_to([1.0, 0.0, 0.0], wo.shape)
    solid_angle = to.solid_angle.astype(np.float32)
    return OutgoingDirections(theta, phases, Pairs.make(wo, to.unit, tangent).to_single(), solid_angle, target,
                              _importance(target, solid_angle))


def _importance(target: RealArray, solid_angle: RealArray) -> RealArray:
    albedo = np.einsum("van,vcan->vc", solid_angle, target)[:, :, None, None] / target.shape[2]
    mean = np.maximum(albedo.mean(axis=1, keepdims=True), _DARK_VALUE)
    in_the_dark = (mean / (np.pi * target + _MEAN_FLOOR * mean)) ** _DARKER
    return np.asarray(in_the_dark * (mean / (albedo + _CHANNEL_FLOOR * mean)) ** _DARKER_CHANNEL)
