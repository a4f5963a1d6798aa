"""From an outcome to a material: put the compiled shader where the material's surface is."""

from contextlib import ExitStack

import bpy

from ...fitter.cycles.bake import SHADER_VERSION
from .. import versions
from ..scene import lamps
from ..transaction import new_data_removed_on_error, restored_on_error
from . import node_group, stand_in
from .compiler import compile_shader
from .properties import CHOICES, RESULTS


def create(outcome, choices, context, shader=None):
    """A new material; nothing is left behind where that fails.

    Parameters
    ----------
    outcome : work.Outcome
    choices : properties.FitChoices
    context : bpy.types.Context
    shader : compiler.Shader, optional
        The outcome's source, where it has been compiled already.

    Returns
    -------
    bpy.types.Material

    Raises
    ------
    compiler.CompileError
        If the shader cannot be compiled here.
    """
    with new_data_removed_on_error():
        material = bpy.data.materials.new(outcome.samples.name)
        _use_nodes(material)
        material.node_tree.nodes.clear()
        assign(material, outcome, choices, context, shader)
    return material


def assign(material, outcome, choices, context, shader=None):
    """Give a material a new fit, made by `choices`; on an error it stays as it was. Raises as `create` does."""
    shader = compile_shader(outcome.source) if shader is None else shader
    with new_data_removed_on_error(), restored_on_error(material, (*CHOICES, *RESULTS)):
        _use_nodes(material)
        node, before = _show(material, node_group.create(None, shader))
        node.label = outcome.samples.name
        # this correction bends the shader's directions, which are right as they are
        material.cycles.use_bump_map_correction = False
        stand_in.update(material, outcome)
        _store(material.measured_brdf, choices, outcome)
        lamps.update(context.evaluated_depsgraph_get())
        unused = node_group.unused(before)
    bpy.data.batch_remove(unused)


def replace_shader(materials, shader, context):
    """Give measured materials that share a shader that of this version, for the fit that they have.

    On an error all stay as they were.
    """
    with ExitStack() as restored:
        restored.enter_context(new_data_removed_on_error())
        tree, replaced = node_group.create(None, shader), []
        for material in materials:
            restored.enter_context(restored_on_error(material, RESULTS))
            replaced.append(_show(material, tree)[1])
            material.measured_brdf.version = versions.CURRENT
        lamps.update(context.evaluated_depsgraph_get())
        unused = {item for before in replaced for item in node_group.unused(before)}
    bpy.data.batch_remove(unused)


def remove(material):
    """Remove a material that nothing uses, and its shader."""
    node = group_node(material)
    tree = None if node is None else node.node_tree
    bpy.data.materials.remove(material)
    bpy.data.batch_remove(node_group.unused(tree))


def group_node(material):
    """The node of a material that holds a measured BRDF, or None."""
    if material.node_tree is None:
        return None
    return next((node for node in material.node_tree.nodes if node.type == "GROUP" and node.node_tree is not None
                 and node_group.script_node(node.node_tree) is not None), None)


def is_measured(material):
    """Whether a material shows a finished fit."""
    return bool(material.measured_brdf.coefficients) and group_node(material) is not None


def is_outdated(material):
    """Whether an older version of the extension made the shader of a measured material."""
    node = group_node(material)
    return node is not None and node_group.version(node.node_tree) < SHADER_VERSION


def _use_nodes(material):
    if bpy.app.version < (5, 0, 0):             # since then every material does
        material.use_nodes = True


def _show(material, tree):
    """Put a shader's group in the place of the one before, or else behind the surface: its node, and the group before.

    What was connected to the surface stays, unconnected. A material without an output, whose user has deleted it, gets
    one.
    """
    nodes = material.node_tree.nodes
    node, output, before = group_node(material), material.node_tree.get_output_node("CYCLES"), None
    if node is None:
        node = nodes.new("ShaderNodeGroup")
        node.name, node.width, node.node_tree = node_group.NAME, 200, tree
        if output is not None:
            node.location = output.location.x - 260, output.location.y
            _connect(material, node, output)
    else:
        before, node.node_tree = node.node_tree, tree
    if output is None:
        output = nodes.new("ShaderNodeOutputMaterial")
        output.location = node.location.x + 260, node.location.y
        _connect(material, node, output)
    return node, before


def _connect(material, node, output):
    material.node_tree.links.new(node.outputs["BSDF"], output.inputs["Surface"])


def _store(settings, choices, outcome):
    for name in CHOICES:
        setattr(settings, name, getattr(choices, name))
    fit, errors, seconds = outcome.fitted
    results = {"name_of_data": outcome.samples.name, "digest": outcome.digest,
               "coefficients": fit.coefficient_count, "bytes": fit.nbytes, "rmse": errors.rmse, "mre": errors.mre,
               "seconds": seconds, "changes": "; ".join(fit.changes), "version": versions.CURRENT,
               "fitted_levels": fit.notation}
    for name in RESULTS:
        setattr(settings, name, results[name])
