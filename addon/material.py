"""From measurements to a material: read, fit, bake, and put the result where the material's surface is."""

import time
from typing import NamedTuple

import bpy

from .. import fitter
from . import lamps, node_group
from .properties import fit_arguments


def import_material(choices, context):
    """A new material from measured data; nothing is left behind where that fails.

    Parameters
    ----------
    choices : properties.FitChoices
    context : bpy.types.Context

    Returns
    -------
    bpy.types.Material

    Raises
    ------
    fitter.DatasetError, node_group.CompileError, ValueError
        If the file or the choices are no good, or the shader cannot be compiled here.
    """
    result = _fit(choices)
    material = bpy.data.materials.new(result.samples.name)
    try:
        _use_nodes(material)
        material.node_tree.nodes.clear()
        _assign(material, choices, result, context)
    except BaseException:
        bpy.data.materials.remove(material)
        raise
    return material


def refit(material, context):
    """Fit the data of a measured material anew, with its present choices; on an error it stays as it was.

    Raises as `import_material` does.
    """
    choices = material.measured_brdf
    _assign(material, choices, _fit(choices), context)


def group_node(material):
    """The node of a material that holds a measured BRDF, or None."""
    if material.node_tree is None:
        return None
    return next((node for node in material.node_tree.nodes if node.type == "GROUP" and node.node_tree is not None
                 and node_group.script_node(node.node_tree) is not None), None)


class _Result(NamedTuple):
    """A fit, the samples it was made from, and the time it took."""

    samples: fitter.Samples
    fit: fitter.Fit
    seconds: float


def _fit(choices):
    samples = fitter.load(bpy.path.abspath(choices.filepath), choices.sample or None)
    start = time.perf_counter()
    fit = fitter.fit(samples, **fit_arguments(choices))
    return _Result(samples, fit, time.perf_counter() - start)


def _assign(material, choices, result, context):
    tree = node_group.create(result.fit)
    _use_nodes(material)
    node = group_node(material)
    if node is None:
        _add_group_node(material.node_tree, tree)
    else:
        before, node.node_tree = node.node_tree, tree
        node_group.remove(before)
    group_node(material).label = result.samples.name
    # this correction bends the shader's directions, which are right as they are
    material.cycles.use_bump_map_correction = False
    _store(material.measured_brdf, choices, result)
    lamps.update(context.evaluated_depsgraph_get())


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


def _store(settings, choices, result):
    for name in ("filepath", "sample", "diffuse_level", "specular_level", "compression"):
        setattr(settings, name, getattr(choices, name))
    errors = fitter.error_metrics(result.samples.values, result.fit.evaluate(*result.samples.directions))
    settings.name_of_data = result.samples.name
    settings.coefficients = result.fit.coefficient_count
    settings.bytes = result.fit.nbytes
    settings.rmse, settings.mre, settings.seconds = errors.rmse, errors.mre, result.seconds
