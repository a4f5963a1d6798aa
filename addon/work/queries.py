"""What panels ask about measurements and fits. Every answer comes from a worker."""

from collections.abc import Hashable
from functools import partial
from typing import Any, cast

import bpy
import numpy as np

from ...fitter.arrays import FloatArray
from ...fitter.colours import COLOURS, DEFAULT_COLOURS
from ...fitter.imaging.packed_picture import unpack
from ...fitter.methods import extrapolation
from ...fitter.model import Reflectance
from ..core.annotations import Arguments, as_text, not_none
from ..core.shading import material as materials
from ..core.shading import mixing, node_group
from ..core.storage import edits, paths
from ..core.storage.outcomes import Data, EmbeddedFit, Fitted, KeptMix, Shown
from ..core.storage.reading import load_arguments
from . import icons, queue, tasks
from .job import Job

_RECHECK = 5.0              # seconds after which the file of a shown material is read again


def data(material: bpy.types.Material) -> Job[Data]:
    """The job that reads the file of a material."""
    settings = material.measured_brdf
    path = paths.absolute(material)
    how = load_arguments(settings)
    return queue.ask(("data", path, settings.sample, as_text(how)),
                     partial(tasks.read, path, settings.sample, how=how), "read", max_age=_RECHECK)


def cost(measured: Data, arguments: Arguments) -> tuple[Job[Fitted], Job[float]]:
    """The job that fits, and the one that finds the RMSE at held-out samples."""
    return fitting_job(measured, arguments), held_out(measured, arguments)


def fitting_job(measured: Data, arguments: Arguments) -> Job[Fitted]:
    return queue.ask(_key("fit", measured, arguments), partial(tasks.fit_data, measured, arguments))


def held_out(measured: Data, arguments: Arguments) -> Job[float]:
    return queue.ask(_key("held out", measured, arguments), partial(tasks.held_out, measured, arguments), "slow")


def lit_sphere(about: Hashable, shown: Shown, edit: Arguments | None = None) -> tuple[int, Job[Any]]:
    """The icon of the lit sphere of a fit as it is edited, or until then of one `about` the same; and its job."""
    key = "sphere", about, shown.digest, "" if edit is None else as_text(edit)
    return icons.icon(key, partial(tasks.lit_sphere, shown, edit), latest=True)


def polar_plot(about: Hashable, fits: tuple[tasks.Reaching, ...], data: Data | None, theta_i: float,
               phi_i: float = 0.0) -> tuple[int, Job[Any]]:
    """The icon of the plot of a plane of incidence (radians), of one fit or two, with the samples of the first if they
    are given, and its job."""
    theta_i, phi_i = round(theta_i, 3), round(phi_i, 3)
    digests = tuple((shown.digest, reaches) for shown, reaches in fits), None if data is None else data.digest
    return icons.icon(("polar", about, *digests, theta_i, phi_i),
                      partial(tasks.polar_plot, fits, data, theta_i, phi_i))


def turned_plane(about: Hashable, shown: Shown, theta_i: float) -> tuple[int, Job[Any]]:
    """The icon of the plane of incidence, turned, at an angle of incidence (radians), and its job."""
    theta_i = round(theta_i, 3)
    return icons.icon(("turned", about, shown.digest, theta_i), partial(tasks.turned_plane, shown, theta_i))


def fit_job(material: bpy.types.Material, masked: float | None = None) -> Job[Reflectance] | None:
    """The job that reads what `shown_fits` returns, or fails with ValueError where a fit has been damaged; or None."""
    stored = shown_fits(material, masked)
    return None if stored is None else queue.ask(("kept fit", stored.digest), partial(tasks.shown_reflectance, stored))


def material_sphere(material: bpy.types.Material) -> tuple[int, Job[Any]]:
    """The icon of the lit sphere of a measured material or of a mix, as it will be where it is being adjusted; until it
    is drawn, of its previous fit, or the small picture in the material's settings; and its job."""
    stored = cast(EmbeddedFit | KeptMix, shown_fits(material))
    as_it_is = isinstance(stored, KeptMix) or edits.is_as_wanted(material)
    icon, job = lit_sphere(material.session_uid, stored, None if as_it_is else edits.edit_arguments(material))
    text = material.measured_brdf.sphere
    if not icon and text:
        icon = icons.draw_at_once(("small sphere", hash(text)), lambda: unpack(text))
    return icon, job


def shown_fits(material: bpy.types.Material, masked: float | None = None) -> EmbeddedFit | KeptMix | None:
    """What a material keeps: its fit, or those that it mixes, by a mask with the share `masked`; None if none is."""
    return embedded_fit(material) or _kept_parts(materials.mix_node(material), masked)


def _kept_parts(node: bpy.types.Node | None, masked: float | None = None) -> EmbeddedFit | KeptMix | None:
    if node is None or not mixing.mixes.is_mix(node.node_tree):
        return None
    *mixed, share = mixing.mixes.parts(node)
    base, on_top = (None if part is None else embedded_fit(part) or _kept_parts(inner)
                    for part, inner in zip(mixed, mixing.mixes.nodes(node), strict=True))
    if base is None or on_top is None:
        return base or on_top
    return KeptMix(base, on_top, masked if share is None else share)


def reaches(material: bpy.types.Material) -> tuple[extrapolation.MeasuredDomain, ...]:
    """How far the measurements of a material go, or of those that it mixes, as far as that is known."""
    angles = [(part.measured_brdf.farthest, part.measured_brdf.least) for part in materials.measured_parts(material)]
    return tuple(extrapolation.MeasuredDomain(*np.radians(each).tolist()) for each in angles if min(each) > 0)


def samples_near_plane(material: bpy.types.Material, theta_i: float,
                       phi_i: float = 0.0) -> Job[tuple[FloatArray, FloatArray, float]] | None:
    """The job of `plane_plot.samples_near_plane`; None where the measurements are not at hand, or not read yet."""
    measured = data(material).result if material.measured_brdf.filepath else None
    if measured is None:
        return None
    theta_i, phi_i = round(theta_i, 2), round(phi_i, 2)
    return queue.ask(("near plane", measured.digest, theta_i, phi_i),
                     partial(tasks.samples_near_plane, measured, theta_i, phi_i), "read")


def embedded_fit(material: bpy.types.Material) -> EmbeddedFit | None:
    node = materials.group_node(material)
    if node is None:
        return None
    settings = material.measured_brdf
    space = settings.colours if settings.colours in COLOURS else DEFAULT_COLOURS
    return EmbeddedFit(node_group.kept_fit(not_none(node.node_tree)), settings.name_of_data, space)


def _key(kind: str, measured: Data, arguments: Arguments) -> tuple[str, str, str]:
    return kind, measured.digest, as_text(arguments)
