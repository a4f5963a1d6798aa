"""How measured materials are rendered in a scene: exactly or by closure nodes; and why, where nodes stand in.

Which it is follows from the engine, the device and the settings of a scene, without the extension (`node_group`). This
module tells the panel and, when a render begins without a window, the console.
"""

import math
from collections import Counter
from typing import NamedTuple

import bpy
from bpy.app.handlers import persistent

from ..annotations import not_none
from ..blender import device, osl_support
from ..storage.properties import EXACT, NODES, RENDERINGS
from . import material as materials
from . import node_group

_RENDERING_LABELS = {key: label for key, label, _ in RENDERINGS}
OTHER = "OTHER"             # something else is connected to the output
_EEVEE_ENGINES = ("BLENDER_EEVEE", "BLENDER_EEVEE_NEXT")
_IN_EEVEE, _IN_ANOTHER = "the engine is EEVEE", "the engine is not Cycles"
_NOT_COMPILED = "its shader is not compiled yet"


class Rendered(NamedTuple):
    """How a material is rendered."""

    how: str            # `properties.EXACT` or NODES, or OTHER
    error: float        # the share of the light that goes in wrong directions, in the mean over the viewing angles
    worst: float        # and at the worst
    why: str            # why OSL does not run; empty if it does, and where closure nodes were chosen
    can_enable: bool    # whether OSL would run if the scene's settings for it were changed


def scene_rendering(material: bpy.types.Material, scene: bpy.types.Scene) -> Rendered:
    if not materials.shows(material, "EEVEE" if is_eevee_used(scene) else "CYCLES"):
        return Rendered(OTHER, 1.0, 1.0, "", False)
    tree, chosen = not_none(not_none(materials.surface_node(material)).node_tree), materials.get_rendering(material)
    is_chosen = chosen == NODES and not is_eevee_used(scene)
    off = "" if is_chosen else osl_obstacle(scene)
    # of a mix nobody asks whether it is compiled
    is_compiled = node_group.script_node(tree) is None or node_group.is_compiled(tree)
    why = off or ("" if is_chosen or is_compiled else _NOT_COMPILED)
    if not why and chosen != NODES:
        return Rendered(EXACT, 0.0, 0.0, "", False)
    can_enable = (bool(off) and chosen != NODES and not osl_support.reason_unavailable()
                  and device.effective_device(scene) in device.WITH_OSL)
    error, worst = ((node_group.EEVEE_ERROR, node_group.EEVEE_WORST) if is_eevee_used(scene)
                    else (node_group.NODES_ERROR, node_group.NODES_WORST))
    return Rendered(NODES, tree[error], tree[worst], why, can_enable)


def subsurface_message(material: bpy.types.Material, scene: bpy.types.Scene) -> str:
    """What light below the surface of a material is rendered by; empty where there is none."""
    if node_group.SCALE_INPUT not in not_none(materials.surface_node(material)).inputs:
        return ""
    if str(scene.render.engine) == "CYCLES":
        return "Light below the surface: a random walk, which nodes and OSL share"
    if is_eevee_used(scene):
        return "Light below the surface: EEVEE's approximation"
    return "Light below the surface: this engine has none. It shows a diffuse surface of the same albedo"


def is_eevee_used(scene: bpy.types.Scene) -> bool:
    return str(scene.render.engine) in _EEVEE_ENGINES


def osl_obstacle(scene: bpy.types.Scene) -> str:
    """Why a scene is not rendered with OSL, as the end of a sentence; empty if it is."""
    if is_eevee_used(scene):
        return _IN_EEVEE
    if str(scene.render.engine) != "CYCLES":
        return _IN_ANOTHER
    if osl_support.reason_unavailable():
        return "this Blender was built without OSL"
    found = device.effective_device(scene)
    if found not in device.WITH_OSL:
        return f"Cycles has no OSL on {found} devices"
    return "" if scene.cycles.shading_system else "OSL is off"


def brief(found: Rendered, chosen: str) -> str:
    """How a material is rendered, in a few words; `chosen` is one of `properties.RENDERINGS`."""
    if found.how == OTHER:
        return "Not shown: the Material Output of this engine has another surface"
    if found.how == EXACT:
        return "Exact"
    because = f", because {found.why}" if found.why else ""
    instead = f" instead of {_RENDERING_LABELS[chosen]}" if chosen == EXACT else ""
    return f"Rendered by nodes{instead}{because}"


def sentence(found: Rendered, chosen: str) -> str:
    """What the panel Rendering says of a material: `brief`, and how much light goes in wrong directions."""
    if found.how != NODES:
        return brief(found, chosen)
    error = f"Highlight Error {found.error:.1%} of the light"
    if found.worst > found.error:
        error += f", up to {found.worst:.1%} at the worst viewing angle"
    return f"{brief(found, chosen)}. {error}"


def rendering_words(found: Rendered, is_previewed: bool = False) -> str:
    """How a material is rendered, in some four words; `is_previewed` where a viewport shows another engine."""
    if found.how == EXACT:
        return "Exact on final renders" if is_previewed else "Exact"
    if found.how == OTHER:
        return "Not connected to the output"
    if found.why in ("", _IN_EEVEE, _IN_ANOTHER):
        return f"Nodes: within {math.ceil(100 * found.error)} % of the light"
    if found.why == _NOT_COMPILED:
        return "Nodes: not compiled yet"
    return "Nodes: OSL is off" if found.can_enable else "Nodes: no OSL here"


def advice(material: bpy.types.Material, scene: bpy.types.Scene) -> str:
    """How a material is rendered in a scene, and how it would be rendered exactly; empty if it is as was chosen."""
    found, chosen = scene_rendering(material, scene), materials.get_rendering(material)
    if not found.why and found.how != OTHER:
        return ""
    text = f"{brief(found, chosen)}, an approximation" if found.how == NODES else brief(found, chosen)
    if found.can_enable:
        return f"{text}. Enable OSL in its panel renders it exactly"
    if found.how == NODES and not osl_support.reason_unavailable() and chosen != NODES:
        return f"{text}. The CPU, with OSL on, renders it exactly"
    return text


def used_materials() -> list[bpy.types.Material]:
    """The materials of the file that show measurements, or mixes of them, and are used."""
    return [item for item in bpy.data.materials if item.users > item.use_fake_user
            and (materials.is_measured(item) or materials.mix_node(item) is not None)]


def summary(scene: bpy.types.Scene) -> str:
    """What a render without a window says, in one line; empty without measured materials."""
    counts = Counter(scene_rendering(item, scene).how for item in used_materials())
    if not counts:
        return ""
    parts = [f"{counts[how]} {text}" for how, text in ((EXACT, "exact"), (NODES, "by closure nodes"),
                                                       (OTHER, "not connected to the output")) if counts[how]]
    why = osl_obstacle(scene)
    where = str(scene.render.engine) if is_eevee_used(scene) else f"Cycles on {device.effective_device(scene)}"
    return f"Measured BRDF: {', '.join(parts)} ({where}{'; ' + why if why else ', with OSL'})"


@persistent
def _on_render(scene: bpy.types.Scene, *_: object) -> None:
    if bpy.app.background and (text := summary(scene)):
        print(text, flush=True)


handlers = {"render_init": _on_render}
