"""From an outcome to a material: compile the shader and put it where the material's surface is."""

import bpy

from ..fitter.bilevel import notation
from . import fallback, lamps, node_group
from .properties import CHOICES


def create(outcome, choices, context):
    """A new material; nothing is left behind where that fails.

    Parameters
    ----------
    outcome : work.Outcome
    choices : properties.FitChoices
    context : bpy.types.Context

    Returns
    -------
    bpy.types.Material

    Raises
    ------
    node_group.CompileError
        If the shader cannot be compiled here.
    """
    material = bpy.data.materials.new(outcome.samples.name)
    try:
        _use_nodes(material)
        material.node_tree.nodes.clear()
        assign(material, outcome, choices, context)
    except BaseException:
        bpy.data.materials.remove(material)
        raise
    return material


def assign(material, outcome, choices, context):
    """Give a material a new fit, made by `choices`; on an error it stays as it was. Raises as `create` does."""
    tree = node_group.create(outcome.fitted.fit, outcome.source)
    _use_nodes(material)
    node = group_node(material)
    if node is None:
        _add_group_node(material.node_tree, tree)
    else:
        before, node.node_tree = node.node_tree, tree
        node_group.remove(before)
    group_node(material).label = outcome.samples.name
    # this correction bends the shader's directions, which are right as they are
    material.cycles.use_bump_map_correction = False
    fallback.update(material, outcome)
    _store(material.measured_brdf, choices, outcome)
    lamps.update(context.evaluated_depsgraph_get())


def remove(material):
    """Remove a material that nothing uses, and its shader."""
    tree = group_node(material).node_tree
    bpy.data.materials.remove(material)
    node_group.remove(tree)


def group_node(material):
    """The node of a material that holds a measured BRDF, or None."""
    if material.node_tree is None:
        return None
    return next((node for node in material.node_tree.nodes if node.type == "GROUP" and node.node_tree is not None
                 and node_group.script_node(node.node_tree) is not None), None)


def is_measured(material):
    """Whether a material shows a finished fit."""
    return bool(material.measured_brdf.coefficients) and group_node(material) is not None


def _use_nodes(material):
    if bpy.app.version < (5, 0, 0):             # since then every material does
        material.use_nodes = True


def _add_group_node(nodes, tree):
    """Connect a group to the material's surface. What was connected there stays, unconnected."""
    output = nodes.get_output_node("CYCLES") or nodes.nodes.new("ShaderNodeOutputMaterial")
    node = nodes.nodes.new("ShaderNodeGroup")
    node.name, node.width, node.node_tree = node_group.NAME, 200, tree
    node.location = output.location.x - 260, output.location.y
    nodes.links.new(node.outputs["BSDF"], output.inputs["Surface"])


def _store(settings, choices, outcome):
    for name in CHOICES:
        setattr(settings, name, getattr(choices, name))
    fit, errors, seconds = outcome.fitted
    settings.name_of_data, settings.digest = outcome.samples.name, outcome.digest
    settings.coefficients, settings.bytes = fit.coefficient_count, fit.nbytes
    settings.rmse, settings.mre, settings.seconds = errors.rmse, errors.mre, seconds
    settings.changes = "; ".join(fit.changes)
    settings.fitted_levels = notation(fit.diffuse_level, fit.specular_level, fit.compression)
