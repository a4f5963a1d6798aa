"""Settings of a scene that change how measured materials look: the effect of each, and its fix.

Cycles treats most of the reflection of a measured material as glossy, so every setting for glossy paths affects it.
"""

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import NamedTuple

import bpy

from ...fitter.shader_constants import MAX_LAMPS, MOST_MIXED
from . import versions
from .blender import device, osl_support
from .lamps import instances, light_objects, sky_moves
from .shading import material as materials
from .shading import rendered, tangents
from .storage.properties import AUTOMATIC, EXACT, NODES


class Finding(NamedTuple):
    """A setting that changes the picture."""

    key: str            # by which an operator fixes it
    message: str        # the setting with its effect
    change: str = ""    # what the fix does; empty if there is none
    fix: Callable[[], object] | None = None


slice_checks: list[Callable[[Sequence[bpy.types.Material]], Iterator[Finding]]] = []
"""What slices find of materials."""


def check(scene: bpy.types.Scene, material: bpy.types.Material | None = None) -> list[Finding]:
    """The settings of a scene, and of a material or all in the file, that change how these look, worst first."""
    every, used = ([*bpy.data.materials], rendered.used_materials()) if material is None else ([material], [material])
    of_cycles = [] if rendered.is_eevee_used(scene) else [*_light_paths(scene), *_lamps(scene)]
    of_slices = (finding for check in slice_checks for finding in check(every))
    return [*_outputs(scene, used), *_osl(scene, used), *of_cycles, *of_slices, *_materials(every),
            *_tangents(scene)]


def _outputs(scene: bpy.types.Scene, used: Sequence[bpy.types.Material]) -> Iterator[Finding]:
    """Materials whose output for the engine has another surface."""
    engine = "EEVEE" if rendered.is_eevee_used(scene) else "Cycles"
    for item in used:
        if rendered.scene_rendering(item, scene).how == rendered.OTHER:
            yield Finding(f"output:{item.name}", f"{item.name} does not show the measurements: the output for {engine} "
                          f"has another surface. Connect the node group to one whose Target is {engine}")


def _osl(scene: bpy.types.Scene, used: Sequence[bpy.types.Material]) -> Iterator[Finding]:
    """Materials that are to be rendered with OSL, and are not."""
    why = rendered.osl_obstacle(scene)
    if not why:
        yield from _optix(scene, used)
        return
    chosen = [item for item in used if materials.get_rendering(item) == EXACT]
    if not chosen:
        return
    message = f"Exact was chosen for {_shared_name(chosen)}; because {why}, nodes are shown instead"
    if osl_support.reason_unavailable() or rendered.is_eevee_used(scene):
        yield Finding("osl", message, "Choose Automatic for them",
                      lambda: [materials.use_rendering(item, AUTOMATIC) for item in chosen if item.is_editable])
    elif device.effective_device(scene) not in device.WITH_OSL:
        yield Finding("osl", message, "Render with OSL on the CPU", lambda: _on_cpu(scene))
    else:
        yield Finding("osl", message, "Render with Cycles and OSL", lambda: osl_support.enable(scene))


def _shared_name(named: Sequence[bpy.types.Material]) -> str:
    return named[0].name if len(named) == 1 else f"{len(named)} measured materials"


def _optix(scene: bpy.types.Scene, used: Sequence[bpy.types.Material]) -> Iterator[Finding]:
    """Cycles has 1024 bytes for the closures of a material there, and does not check where they end."""
    by_osl = [item for item in used if materials.get_rendering(item) != NODES]
    if device.effective_device(scene) != device.OPTIX or not by_osl:
        return
    yield Finding("optix", f"Cycles renders {_shared_name(by_osl)} with OSL on OptiX, which has not been tested, and "
                  "has no room for another shader that is mixed in", "Choose Nodes for them",
                  lambda: [materials.use_rendering(item, NODES) for item in by_osl if item.is_editable])


def _on_cpu(scene: bpy.types.Scene) -> None:
    scene.cycles.device = "CPU"
    osl_support.enable(scene)


# settings of Cycles: the key, the name, the value that changes nothing, what another does, and the fix
_LIGHT_PATHS = (
    ("caustics", "caustics_reflective", True, "Reflective Caustics is off: measured materials do not reflect light "
     "onto diffuse surfaces", "Turn Reflective Caustics on"),
    ("clamp_indirect", "sample_clamp_indirect", 0, "Clamp Indirect is {:g}: it darkens bright reflections",
     "Set Clamp Indirect to 0; fireflies may appear"),
    ("clamp_direct", "sample_clamp_direct", 0, "Clamp Direct is {:g}: it darkens bright highlights",
     "Set Clamp Direct to 0"),
    ("filter_glossy", "blur_glossy", 0, "Filter Glossy is {:g}: it blurs narrow highlights that other surfaces reflect",
     "Set Filter Glossy to 0; caustics become noisier"))


def _light_paths(scene: bpy.types.Scene) -> Iterator[Finding]:
    for key, name, harmless, effect, change in _LIGHT_PATHS:
        value = getattr(scene.cycles, name)
        if value != harmless:
            yield Finding(key, effect.format(value), change, partial(setattr, scene.cycles, name, harmless))


def _lamps(scene: bpy.types.Scene) -> Iterator[Finding]:
    shining = {item.session_uid: item for layer in scene.view_layers for item in light_objects.shining(layer)}
    lamps = [item for item in shining.values() if not item.hide_render and light_objects.get_light(item).energy > 0]
    for item in sorted(lamps, key=lambda item: item.name):
        light = light_objects.get_light(item)
        if not item.visible_glossy:
            yield Finding(f"glossy:{item.name}", f"{item.name} is hidden from glossy rays: most of its light is "
                          "missing", "Make it visible to glossy rays; mirrors will show it",
                          partial(setattr, item, "visible_glossy", True))
        sized = light.type == "AREA" or (light.angle if light.type == "SUN" else light.shadow_soft_size) > 0
        if sized and not light.cycles.use_multiple_importance_sampling:
            yield Finding(f"importance:{item.name}", f"Multiple Importance is off for {item.name}: its light is "
                          "slightly wrong", "Turn Multiple Importance on",
                          partial(setattr, light.cycles, "use_multiple_importance_sampling", True))
    pointlike = sum(item.data.type in {"POINT", "SPOT"} and item.data.shadow_soft_size == 0 for item in lamps)
    if pointlike > MAX_LAMPS:
        yield Finding("pointlike", f"{pointlike} lamps have no size, and only {MAX_LAMPS} can be rendered exactly. The "
                      "highlights of the others are approximate. Give them a size")
    if not scene.render.use_lock_interface and (sky_moves(scene.world) or instances.can_move()):
        yield Finding("lock_interface", "Instanced lamps or bright places of the sky move: animations rendered from "
                      "the window follow them only with Lock Interface", "Turn Lock Interface on",
                      partial(setattr, scene.render, "use_lock_interface", True))


def _materials(looked_at: Sequence[bpy.types.Material]) -> Iterator[Finding]:
    for material in looked_at:
        count = materials.count_rendered(material.node_tree) if material.users > material.use_fake_user else 0
        if count > MOST_MIXED:
            yield Finding(f"mixed:{material.name}", f"{material.name} mixes {count} measured materials: Cycles has "
                          f"room for {MOST_MIXED}, and where there are several lamps, light of the "
                          "others is lost. Mix them by Mix Measured BRDFs, which renders some of them at a time")
    outdated = [material for material in looked_at if material.measured_brdf.coefficients
                and material.is_editable and material.measured_brdf.version != versions.CURRENT
                and materials.is_outdated(material)]
    if outdated:
        yield Finding("version", f"An older version made {_shared_name(outdated)}: rendered as before, without the "
                      "improvements of this one", "Update them and keep their fits",
                      lambda: bpy.ops.measured_brdf.update_materials())
    for material in looked_at:
        if material.measured_brdf.coefficients and material.cycles.use_bump_map_correction and material.is_editable:
            yield Finding(f"bump:{material.name}", f"Bump Map Correction is on for {material.name}: it shifts the "
                          "highlights", "Turn Bump Map Correction off for this material",
                          partial(setattr, material.cycles, "use_bump_map_correction", False))


def _tangents(scene: bpy.types.Scene) -> Iterator[Finding]:
    """Of the active object: where an anisotropic material has no direction that is worth having."""
    item = bpy.context.object
    if item is None or scene.objects.get(item.name) != item or not tangents.can_be_judged(item):
        return
    for material in tangents.anisotropic(item):
        node, key = tangents.find_tangent_node(material), f"tangent:{material.name}"
        if node is None and not tangents.is_turned(item.data):
            message = (f"The direction of {material.name} runs around the Z axis of {item.name}, as a lathe leaves it, "
                       "and the object has another shape")
            if not tangents.has_uv(item.data):
                what = "has no area" if item.data.uv_layers else "is missing"
                yield Finding(key, f"{message}. Its UV map, which could give another direction, {what}: unwrap it")
            elif material.is_editable:
                yield Finding(key, message, "Use the UV map's tangent", partial(tangents.take_from_uv, material))
            else:
                yield Finding(key, f"{message}. Connect a Tangent node in the file that {material.name} belongs to")
        elif (node is not None and node.type == "TANGENT" and node.direction_type == "UV_MAP"
              and not tangents.has_uv(item.data, node.uv_map)):
            message = (f"The tangent of {material.name} is that of a UV map that {item.name} does not have, or that "
                       "has no area")
            if material.is_editable:
                yield Finding(key, message, "Use the tangent around the Z axis",
                              partial(tangents.take_around_axis, material))
            else:
                yield Finding(key, f"{message}. Unwrap it")
