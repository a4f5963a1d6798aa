"""What edits and mixes cost: ``python -m benchmarks.editing`` prints two tables.

For a lacquer, a metallic paint and a cloth of the starter library, with each edit: the light that the highlight keeps,
the error of the closure nodes, and the time of a render with Exact, to that of the material as measured.
Then a mix of two: time and noise, to those of a Mix Shader that renders both, and to those of one material alone.
"""

import sys
import time

import numpy as np

import fitter
from fitter.cycles.node_mixture import cycles_mixture
from support import checkout
from support.albedo import mirror_albedo

MATERIALS = ("specular-blue-phenolic", "gold-metallic-paint", "red-fabric")
EDITS = {
    "as measured": {},
    "diffuse x 0.5, highlight x 2": {"diffuse": 0.5, "highlight": 2.0},
    "width 0.5": {"width": 0.5},
    "width 2": {"width": 2.0},
    "width 4": {"width": 4.0},
    "coat 1, alpha 0.05": {"coat": 1.0, "coat_width": 0.05},
}
ANGLES = np.radians([0, 20, 40, 60, 75])
SIZE, SAMPLES, REPEATS, TRUTH = 96, 32, 5, 2048


def main():
    """Print the tables."""
    extension = checkout.extension()
    extension.register()
    extension.addon.core.osl_support.missing()
    fits = {name: fitter.fit(fitter.load_published(name), **fitter.PRESETS["Standard"]) for name in MATERIALS}
    print("| Material | Edit | Light kept | Nodes | Time |")
    print("| --- | --- | --- | --- | --- |")
    for name, fit in fits.items():
        plain = None
        for text, edit in EDITS.items():
            made = fitter.edited(fit, **edit)
            seconds = _seconds(made)
            plain = plain or seconds
            error = cycles_mixture(made).error
            print(f"| {name} | {text} | {_kept(fit, edit)} | {error:.1%} | {seconds / plain:.2f} |")
    print()
    _mixes(fits[MATERIALS[1]], fits[MATERIALS[2]])


def _kept(fit, edit):
    """The largest change of the light that the highlight reflects, over five polar angles, where it is to be kept."""
    if "width" not in edit:
        return ""
    before, after = (np.array([mirror_albedo(fitter.edited(fit, diffuse=0.0, **more), angle) for angle in ANGLES])
                     for more in ({}, edit))
    changes = (after / before - 1)[before > 1e-3]
    return f"{changes.min():+.1%} to {changes.max():+.1%}"


def _scene(material):
    import bpy

    from support.stage import add_lamp, add_sphere, background, black_scene

    scene = black_scene(SIZE, SIZE, SAMPLES, span=2)
    add_sphere()
    bpy.context.object.data.materials.append(material())
    add_lamp("AREA", 100, (-3, 0, 2), (0, -0.98, 0), size=1.0)
    background(scene, 0.3)
    return scene


def _seconds(fit):
    from support.stage import material_for, render

    scene = _scene(lambda: material_for(fit))
    scene.cycles.samples = 4 * SAMPLES
    render(scene)                       # compiles the shader
    return min(_timed(lambda: render(scene))[0] for _ in range(REPEATS))


def _timed(function):
    start = time.perf_counter()
    result = function()
    return time.perf_counter() - start, result


def _mixes(first, second):
    """Print the table of mixes, for shares of a half and for a mask of black and white."""
    print("| Share of the second | Time, to one material | Time, to a Mix Shader | Noise, to a Mix Shader |")
    print("| --- | --- | --- | --- |")
    for factor in (0.5, None):
        alone, both, picked = (_noise_and_time(make, first, second, factor) for make in (_alone, _mix_shader, _mix))
        share = "a mask of black and white" if factor is None else f"{factor:g}"
        print(f"| {share} | {picked[1] / alone[1]:.2f} | {picked[1] / both[1]:.2f} | {picked[0] / both[0]:.2f} |")


def _noise_and_time(make, first, second, factor):
    """The root of the mean squared error of a render, over its mean, and its seconds."""
    from support.stage import render

    scene = _scene(lambda: make(first, second, factor))
    scene.cycles.samples = TRUTH
    truth = render(scene)[..., :3].copy()
    scene.cycles.samples = SAMPLES
    times, errors = [], []
    for seed in range(REPEATS):
        scene.cycles.seed = seed + 1
        seconds, picture = _timed(lambda: render(scene)[..., :3].copy())
        times.append(seconds)
        errors.append(np.mean((picture - truth) ** 2))
    return np.sqrt(np.mean(errors)) / truth.mean(), min(times)


def _alone(first, _second, _factor):
    from support.stage import material_for

    return material_for(first)


def _mix_shader(first, second, factor):
    """Both materials in one Mix Shader, as users would build it."""
    from support.stage import material_for

    mixed, other = material_for(first), material_for(second)
    tree = mixed.node_tree
    group = tree.nodes.new("ShaderNodeGroup")
    group.node_tree = next(node for node in other.node_tree.nodes if node.type == "GROUP").node_tree
    mixer = tree.nodes.new("ShaderNodeMixShader")
    surface = tree.get_output_node("CYCLES").inputs["Surface"]
    tree.links.new(surface.links[0].from_socket, mixer.inputs[1])
    tree.links.new(group.outputs["BSDF"], mixer.inputs[2])
    tree.links.new(mixer.outputs[0], surface)
    _share(tree, mixer.inputs[0], factor)
    return mixed


def _mix(first, second, factor):
    import bpy

    from support.stage import material_for

    parts = [material_for(fit) for fit in (first, second)]
    bpy.ops.measured_brdf.mix(first=parts[0].name, second=parts[1].name)
    mixed = bpy.data.materials[f"{parts[0].name} + {parts[1].name}"]
    node = next(node for node in mixed.node_tree.nodes if node.type == "GROUP")
    _share(mixed.node_tree, node.inputs["Factor"], factor)
    bpy.context.object.data.materials.clear()
    return mixed


def _share(tree, socket, factor):
    """A share, or where it is None a mask: the right half is the second material."""
    if factor is not None:
        socket.default_value = factor
        return
    place, apart, step = (tree.nodes.new(kind) for kind in ("ShaderNodeNewGeometry", "ShaderNodeSeparateXYZ",
                                                            "ShaderNodeMath"))
    step.operation, step.inputs[1].default_value = "GREATER_THAN", 0.0
    tree.links.new(place.outputs["Position"], apart.inputs[0])
    tree.links.new(apart.outputs["X"], step.inputs[0])
    tree.links.new(step.outputs[0], socket)


if __name__ == "__main__":
    sys.exit(main())
