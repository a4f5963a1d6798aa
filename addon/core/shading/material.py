"""Makes materials of fits: puts a compiled shader where the surface of a material is."""

from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from typing import Any, Literal

import bpy
import numpy as np

from ....fitter.cycles.bake import SHADER_VERSION
from ....fitter.shader_constants import MOST_MIXED
from .. import versions
from ..annotations import as_text, not_none
from ..blender import followers
from ..blender.node_trees import list_upstream, use_nodes
from ..blender.transaction import new_data_removed_on_error, restored_on_error
from ..storage import edits, reading
from ..storage.outcomes import Outcome, Surface
from ..storage.properties import AUTOMATIC, CHOICES, EXACT, NODES, RESULTS, Choices, fit_arguments
from . import export_surface, mixing, node_group
from .compiler import Shader, compile_surface


def create(outcome: Outcome, choices: Choices, context: bpy.types.Context,
           shader: Shader | None = None) -> bpy.types.Material:
    """Make a new material; if that fails, the file stays as it was. `shader` is the outcome's, if it has been compiled.

    Raises CompileError if this Blender cannot compile the shader.
    """
    with new_data_removed_on_error():
        material = bpy.data.materials.new(outcome.measured.name)
        use_nodes(material).nodes.clear()
        assign(material, outcome, choices, context, shader)
    return material


def assign(material: bpy.types.Material, outcome: Outcome, choices: Choices, context: bpy.types.Context,
           shader: Shader | None = None) -> None:
    """Give a material a new fit, made by `choices`; if that fails, it stays as it was. Raises as `create` does."""
    shader = compile_surface(outcome.surface) if shader is None else shader
    with _replacement([material], context):
        use_nodes(material)
        is_new = group_node(material) is None
        _show_surface(material, outcome.surface, shader).label = outcome.measured.name
        rendering = choices.rendering if is_new else get_rendering(material)
        # this correction would bend the shader's directions, which are right as they are
        material.cycles.use_bump_map_correction = False
        _store(material.measured_brdf, choices, outcome)
        use_rendering(material, rendering)


def edit(material: bpy.types.Material, surface: Surface, context: bpy.types.Context, shader: Shader) -> None:
    """Give a measured material the shader of its fit as it was edited; if that fails, it stays as it was."""
    with _replacement([material], context):
        _show_surface(material, surface, shader)
        settings = material.measured_brdf
        settings.sphere, settings.adjusted, settings.version = surface.sphere, as_text(surface.edit), versions.CURRENT


def replace_shader(materials: Sequence[bpy.types.Material], shader: Shader, context: bpy.types.Context) -> None:
    """Give measured materials that share a shader a new one of the same fit; if that fails, all stay as they were."""
    with _replacement(materials, context):
        tree = node_group.find_or_create(shader, materials[0].name)
        for material in materials:
            show(material, tree)
            material.measured_brdf.version = versions.CURRENT


@contextmanager
def _replacement(materials: Sequence[bpy.types.Material], context: bpy.types.Context) -> Iterator[None]:
    """Have mixes, and whoever follows, know of the groups that the block gives to materials, and remove those that
    nothing uses any more; if any fails, all stay as they were."""
    former = [_group(item) for item in materials]
    with ExitStack() as restored:
        restored.enter_context(new_data_removed_on_error())
        for item in materials:
            restored.enter_context(restored_on_error(item, (*CHOICES, *RESULTS)))
        yield
        made = [not_none(_group(item)) for item in materials]
        mixed = dict.fromkeys(mix for item in materials for mix in mixing.mixes.holders(item))
        for mix in mixed:
            restored.enter_context(restored_on_error(mix, ()))
        for item, before, after in zip(materials, former, made, strict=True):
            restored.enter_context(mixing.mixes.following(item, before, after))
        followers.tell(context)
        unused = {each for before in former for each in node_group.unused_groups(before)}
        for mix in mixed:
            export_surface.mix(mix, not_none(mix_node(mix)))
    bpy.data.batch_remove(unused)
    # it could not have this name beside the former group; one that is of other materials too goes by theirs
    users = bpy.data.user_map(subset=made)[made[0]]
    if all(user in materials for user in users if isinstance(user, bpy.types.Material)):
        made[0].name = materials[0].name


def remove(material: bpy.types.Material) -> None:
    """Remove a material that nothing uses, and its shader, or the group by which it mixes others."""
    trees = [node.node_tree for node in (group_node(material), mix_node(material)) if node is not None]
    bpy.data.materials.remove(material)
    for tree in trees:
        bpy.data.batch_remove(node_group.unused_groups(tree))


def group_node(material: bpy.types.Material) -> bpy.types.Node | None:
    """The node of a material that holds a measured BRDF, or None."""
    return next(iter(group_nodes(material)), None)


def _group(material: bpy.types.Material) -> bpy.types.NodeTree | None:
    node = group_node(material)
    return None if node is None else node.node_tree


def mix_node(material: bpy.types.Material) -> bpy.types.Node | None:
    return next((node for node in _list_groups(material.node_tree) if mixing.mixes.is_mix(node.node_tree)), None)


def surface_node(material: bpy.types.Material) -> bpy.types.Node | None:
    """The node of a material that holds a measured BRDF, or a mix of some; None for other materials."""
    return group_node(material) or mix_node(material)


def is_shown(material: bpy.types.Material) -> bool:
    return surface_node(material) is not None


def group_nodes(material: bpy.types.Material) -> list[bpy.types.Node]:
    return [node for node in _list_groups(material.node_tree)
            if node_group.script_node(not_none(node.node_tree)) is not None]


def _list_groups(tree: bpy.types.NodeTree | None) -> list[bpy.types.Node]:
    nodes = () if tree is None else tree.nodes
    return [node for node in nodes if node.type == "GROUP" and node.node_tree is not None]


def shows(material: bpy.types.Material, engine: Literal["CYCLES", "EEVEE"]) -> bool:
    """Whether what a renderer takes as the surface of a material has a measured BRDF in it."""
    tree = not_none(material.node_tree)
    output = tree.get_output_node(engine)
    seen = [] if output is None else list_upstream(not_none(output.inputs["Surface"].links))
    measured = group_nodes(material)
    return any(node in seen for node in measured) or count_rendered(tree) > len(measured)


def count_rendered(tree: bpy.types.NodeTree | None) -> int:
    """How many measured BRDFs a node tree renders at once, also inside of node groups; of a mix, at most two."""
    groups = [not_none(node.node_tree) for node in _list_groups(tree)]
    return sum(1 if node_group.script_node(group) is not None
               else min(mixing.mixes.count(group), MOST_MIXED) if mixing.mixes.is_mix(group) else count_rendered(group)
               for group in groups)


def get_rendering(material: bpy.types.Material) -> str:
    """How a measured material is rendered, one of `properties.RENDERINGS`; users may have changed its inputs."""
    nodes = not_none(surface_node(material)).inputs.get("Nodes")
    if nodes is not None and nodes.default_value:
        return NODES
    return EXACT if material.measured_brdf.rendering == EXACT else AUTOMATIC


def use_rendering(material: bpy.types.Material, rendering: str) -> None:
    """Choose how all measured BRDFs of a material are rendered, also those inside of node groups."""
    for node in _measured_nodes(not_none(material.node_tree)):
        if "Nodes" in node.inputs:              # users may have removed it from the group
            node.inputs["Nodes"].default_value = rendering == NODES
    material.measured_brdf.rendering = rendering


def _measured_nodes(tree: bpy.types.NodeTree) -> Iterator[bpy.types.Node]:
    """The nodes that hold a measured BRDF or a mix of some, also inside of the node groups of this file."""
    for node in _list_groups(tree):
        if node_group.script_node(node.node_tree) is not None or mixing.mixes.is_mix(node.node_tree):
            yield node
        elif node.node_tree.is_editable:
            yield from _measured_nodes(node.node_tree)


def measured_parts(material: bpy.types.Material) -> list[bpy.types.Material]:
    """The materials that a mix is made of, less those that have been deleted; of another material, itself."""
    node = None if group_node(material) is not None else mix_node(material)
    if node is None:
        return [material]
    both = [measured_parts(part) for part in mixing.mixes.parts(node)[:2] if part is not None]
    return list(dict.fromkeys(part for parts in both for part in parts))


def tangent_input(material: bpy.types.Material) -> bpy.types.NodeSocket | None:
    """The input of an anisotropic material, or of a mix with one, that its direction comes from; None for others."""
    node = surface_node(material)
    return node.inputs.get("Tangent") if node is not None else None


def is_measured(material: bpy.types.Material) -> bool:
    return bool(material.measured_brdf.coefficients) and group_node(material) is not None


def is_outdated(material: bpy.types.Material) -> bool:
    node = group_node(material)
    return node is not None and node_group.version(node.node_tree) < SHADER_VERSION


def is_as_made(material: bpy.types.Material) -> bool:
    """Whether a material of this file is as an import makes it: nothing is adjusted, or set at its node."""
    node = group_node(material)
    if node is None or not is_measured(material) or material.library is not None or is_outdated(material):
        return False
    defaults = {item.identifier: item.default_value for item in not_none(not_none(node.node_tree).interface).items_tree
                if item.item_type == "SOCKET" and item.in_out == "INPUT" and hasattr(item, "default_value")}
    return (material.measured_brdf.adjusted in ("", as_text({})) and not edits.edit_arguments(material)
            and shows(material, "CYCLES") and not any(socket.is_linked for socket in node.inputs)
            and all(np.array_equal(defaults[socket.identifier], socket.default_value) for socket in node.inputs
                    if socket.identifier in defaults and not socket.hide_value))


def show(material: bpy.types.Material, tree: bpy.types.NodeTree) -> bpy.types.Node:
    """Replace the measured group of a material, or connect a new one to its surface: the node."""
    own_tree = not_none(material.node_tree)
    nodes = own_tree.nodes
    node, output = group_node(material), own_tree.get_output_node("CYCLES")
    is_connected = node is not None and output is not None
    if node is None:
        node = nodes.new("ShaderNodeGroup")
        node.name, node.width = node_group.GROUP_NAME, 200
        if output is not None:
            node.location = output.location.x - 260, output.location.y
    node.node_tree = tree
    if output is None:
        output = nodes.new("ShaderNodeOutputMaterial")
        output.location = node.location.x + 260, node.location.y
    if not is_connected:
        own_tree.links.new(node.outputs[node_group.CYCLES_OUTPUT], output.inputs["Surface"])
    _show_in_eevee(own_tree, node, output)
    return node


def _show_in_eevee(tree: bpy.types.NodeTree, node: bpy.types.Node, cycles: bpy.types.Node) -> None:
    """Give EEVEE an output of its own, unless the user has, or mixes the measured BRDF with something else."""
    eevee = next((each for each in tree.nodes if each.type == "OUTPUT_MATERIAL" and each.target == "EEVEE"), None)
    if eevee is None:
        shown = [link.from_node for link in cycles.inputs["Surface"].links]
        if shown != [node]:
            return
        cycles.target = "CYCLES" if cycles.target == "ALL" else cycles.target
        eevee = tree.nodes.new("ShaderNodeOutputMaterial")
        eevee.target = "EEVEE"
        eevee.location = cycles.location.x, cycles.location.y - 180
    elif eevee.inputs["Surface"].is_linked:
        return
    tree.links.new(node.outputs[node_group.EEVEE_OUTPUT], eevee.inputs["Surface"])


def _show_surface(material: bpy.types.Material, surface: Surface, shader: Shader) -> bpy.types.Node:
    node = show(material, node_group.find_or_create(shader, material.name, unlike=_group(material)))
    export_surface.update(material, node, surface)
    return node


def _store(settings: Any, choices: Choices, outcome: Outcome) -> None:
    for name in CHOICES:
        setattr(settings, name, getattr(choices, name))
    (fit, errors, seconds, _), surface = outcome.fitted, outcome.surface
    results = {"name_of_data": outcome.measured.name, "digest": outcome.measured.digest,
               "coefficients": fit.coefficient_count, "bytes": fit.nbytes, "rmse": errors.rmse, "mre": errors.mre,
               "seconds": seconds, "changes": "; ".join(fit.changes), "version": versions.CURRENT,
               "fitted_levels": fit.notation, "sphere": surface.sphere, "adjusted": as_text(surface.edit),
               "fitted_as": as_text(fit_arguments(choices)), **outcome.verdict._asdict(),
               "colours": outcome.measured.colours if len(outcome.measured.channels) > 1 else reading.GREY}
    for name in RESULTS:
        setattr(settings, name, results[name])
