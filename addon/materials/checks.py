"""Settings of a scene that bias measured materials: what each does, what a fix would change, and the fix.

Most of what a measured material reflects is, to Cycles, glossy; so whatever treats glossy paths apart changes it.
"""

from collections.abc import Callable
from typing import NamedTuple

import bpy

from ...fitter.cycles.bake import MAX_LAMPS
from .. import versions
from ..scene.lamps import instances, light_objects, sky_moves
from . import material as materials


class Finding(NamedTuple):
    """A setting that changes the picture.

    Attributes
    ----------
    key : str
        Names the setting, for the operator.
    message : str
        What is set, and what that does to the picture.
    change : str
        What the fix would change; empty where there is none.
    fix : callable, or None
    """

    key: str
    message: str
    change: str = ""
    fix: Callable | None = None


def check(scene):
    """What in a scene changes how measured materials look, worst first: a list of `Finding`."""
    return [*_light_paths(scene), *_lamps(scene), *_materials()]


def _light_paths(scene):
    cycles = scene.cycles
    if not cycles.caustics_reflective:
        yield Finding("caustics", "Reflective caustics are off: measured materials that are seen by way of diffuse "
                      "surfaces are dark there", "Turn Reflective Caustics on",
                      lambda: setattr(cycles, "caustics_reflective", True))
    if cycles.sample_clamp_indirect > 0:
        yield Finding("clamp_indirect", f"Clamp Indirect is {cycles.sample_clamp_indirect:g}: bright "
                      "reflections are cut off, the picture is darker", "Set Clamp Indirect to 0; fireflies may show",
                      lambda: setattr(cycles, "sample_clamp_indirect", 0))
    if cycles.sample_clamp_direct > 0:
        yield Finding("clamp_direct", f"Clamp Direct is {cycles.sample_clamp_direct:g}: bright highlights are cut off",
                      "Set Clamp Direct to 0", lambda: setattr(cycles, "sample_clamp_direct", 0))
    if cycles.blur_glossy > 0:
        yield Finding("filter_glossy", f"Filter Glossy is {cycles.blur_glossy:g}: narrow highlights are blurred where "
                      "seen by way of other surfaces", "Set Filter Glossy to 0; caustics become noisier",
                      lambda: setattr(cycles, "blur_glossy", 0))


def _lamps(scene):
    shining = {item.session_uid: item for layer in scene.view_layers for item in light_objects.shining(layer)}
    lamps = [item for item in shining.values() if not item.hide_render and item.data.energy > 0]
    for item in sorted(lamps, key=lambda item: item.name):
        if not item.visible_glossy:
            yield Finding(f"glossy:{item.name}", f"{item.name} is hidden from glossy rays: most of its light is "
                          "missing", "Make it visible to glossy rays; mirrors will show it",
                          lambda item=item: setattr(item, "visible_glossy", True))
        light = item.data
        sized = light.type == "AREA" or (light.angle if light.type == "SUN" else light.shadow_soft_size) > 0
        if sized and not light.cycles.use_multiple_importance_sampling:
            yield Finding(f"importance:{item.name}", f"{item.name} is without Multiple Importance: drawn directions "
                          "miss it, its light is slightly wrong", "Turn Multiple Importance on",
                          lambda light=light: setattr(light.cycles, "use_multiple_importance_sampling", True))
    pointlike = sum(item.data.type in {"POINT", "SPOT"} and item.data.shadow_soft_size == 0 for item in lamps)
    if pointlike > MAX_LAMPS:
        yield Finding("pointlike", f"{pointlike} lamps have no size, more than the {MAX_LAMPS} that can be known: the "
                      "others are seen only as Fast shows them. Give them a size")
    if not scene.render.use_lock_interface and (sky_moves(scene.world) or instances.move()):
        yield Finding("lock_interface", "Instanced lamps or bright places of the sky move: in an animation that is "
                      "rendered from the window they are followed only with Lock Interface", "Turn Lock Interface on",
                      lambda: setattr(scene.render, "use_lock_interface", True))


def _materials():
    outdated = [material.name for material in bpy.data.materials if material.measured_brdf.coefficients
                and material.is_editable and versions.made_by(material) != versions.CURRENT
                and materials.is_outdated(material)]
    if outdated:
        yield Finding("version", f"An older version made {len(outdated)} of the measured materials: they render as "
                      "they did, without what has been improved since", "Update them; their fits stay as they are",
                      lambda: bpy.ops.measured_brdf.update_materials())
    for material in bpy.data.materials:
        if material.measured_brdf.coefficients and material.cycles.use_bump_map_correction and material.is_editable:
            yield Finding(f"bump:{material.name}", f"{material.name} has Bump Map Correction on, which bends its "
                          "directions", "Turn it off for this material",
                          lambda material=material: setattr(material.cycles, "use_bump_map_correction", False))
