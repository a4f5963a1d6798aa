"""An empty black scene in Cycles, what stands in it, and its picture as an array."""

import math
import signal
import tempfile
from pathlib import Path

import bpy
import numpy as np

from fitter.cycles.node_mixture import Nodes, cycles_mixture

TILE = 256                  # pixels across the picture of a lit sphere
EEVEE = "BLENDER_EEVEE_NEXT" if bpy.app.version < (5, 0) else "BLENDER_EEVEE"
# bpy 4.2.23 as a module of Python ends with a segmentation fault after any operator has been registered
EXITS = (0, -signal.SIGSEGV) if bpy.app.version < (4, 3) else (0,)


def black_scene(width, height, samples, span):
    """A scene without light, seen from above: orthographic, `span` units wide, the background transparent.

    Replaces whatever file is open. Settings that would bias the picture (Filter Glossy, clamping) are off.
    """
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    cycles = scene.cycles
    cycles.shading_system = True
    cycles.samples = samples
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    cycles.blur_glossy = cycles.sample_clamp_indirect = cycles.sample_clamp_direct = 0
    scene.render.film_transparent = True
    scene.render.resolution_x, scene.render.resolution_y = width, height
    data = bpy.data.cameras.new("Camera")
    data.type, data.ortho_scale = "ORTHO", span
    scene.camera = add(data, location=(0, 0, 10))
    scene.world = bpy.data.worlds.new("World")
    if not scene.world.node_tree:
        scene.world.use_nodes = True        # deprecated in 5.0, where every world has nodes
    background(scene, 0)
    return scene


def background(scene, strength, color=(1, 1, 1)):
    inputs = scene.world.node_tree.nodes["Background"].inputs
    inputs["Strength"].default_value = strength
    inputs["Color"].default_value = (*color, 1)


def sky_image(radiance):
    """A world lit by an image, as grey radiance (height, width), the lowest row first. Returns the world."""
    image = bpy.data.images.new("Sky", *radiance.shape[::-1], float_buffer=True, is_data=True)
    image.pixels.foreach_set(np.repeat(radiance, 4).astype(np.float32))
    image.pack()
    world = bpy.context.scene.world
    texture = world.node_tree.nodes.new("ShaderNodeTexEnvironment")
    texture.image = image
    background = world.node_tree.nodes["Background"]
    background.inputs["Strength"].default_value = 1
    world.node_tree.links.new(texture.outputs["Color"], background.inputs["Color"])
    return world


def add(data, location=(0, 0, 0), rotation=(0, 0, 0)):
    item = bpy.data.objects.new(data.name, data)
    item.location, item.rotation_euler = location, rotation
    bpy.context.scene.collection.objects.link(item)
    return item


def add_lamp(kind, energy, location=(0, 0, 0), rotation=(0, 0, 0), **settings):
    data = bpy.data.lights.new(kind.title(), kind)
    data.energy = energy
    for name, value in settings.items():
        setattr(data, name, value)
    return add(data, location, rotation)


def rotation_toward(location, target=(0, 0, 0)):
    """The rotation of a lamp or a camera that looks from a place to another."""
    away = [a - b for a, b in zip(location, target, strict=True)]
    return math.atan2(math.hypot(away[0], away[1]), away[2]), 0, math.atan2(away[0], -away[1])


def look(location, target=(0, 0, 0), lens=50):
    camera = bpy.context.scene.camera
    camera.data.type, camera.data.lens = "PERSP", lens
    camera.location, camera.rotation_euler = location, rotation_toward(location, target)


def add_sphere(segments=256, rings=128):
    """A unit sphere with a UV map, as the active object: that of Blender's operator, which takes three seconds."""
    turn, down = np.meshgrid(np.arange(segments) / segments, np.arange(1, rings) / rings)
    theta, phi = math.pi * down.ravel(), 2 * math.pi * turn.ravel() - math.pi
    points = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1)
    points = np.concatenate([[[0, 0, 1]], points, [[0, 0, -1]]])
    row, column = np.meshgrid(np.arange(rings), np.arange(segments), indexing="ij")

    def corner(down, along):
        at = row + down
        inner = 1 + (at - 1) * segments + (column + along) % segments
        number = np.where(at == 0, 0, np.where(at == rings, len(points) - 1, inner))
        across = np.where((at == 0) | (at == rings), column + 0.5, column + along)
        return number, np.stack([across / segments, 1 - at / rings], axis=-1)

    corners, places = zip(*(corner(*each) for each in ((0, 0), (1, 0), (1, 1), (0, 1))), strict=True)
    corners, places = np.stack(corners, axis=-1).reshape(-1, 4), np.stack(places, axis=2).reshape(-1, 4, 2)
    # at the poles a side has no length: triangles
    there = (corners != np.roll(corners, 1, axis=1)).ravel()
    sizes = there.reshape(-1, 4).sum(axis=1)
    mesh = bpy.data.meshes.new("Sphere")
    mesh.vertices.add(len(points))
    mesh.loops.add(there.sum())
    mesh.polygons.add(len(sizes))
    mesh.vertices.foreach_set("co", points.ravel())
    mesh.loops.foreach_set("vertex_index", corners.ravel()[there])
    mesh.polygons.foreach_set("loop_start", np.concatenate([[0], np.cumsum(sizes)[:-1]]))
    mesh.uv_layers.new(name="UVMap").data.foreach_set("uv", places.reshape(-1, 2)[there].ravel())
    mesh.update(calc_edges=True)
    mesh.shade_smooth()
    item = add(mesh)
    bpy.context.view_layer.objects.active = item
    item.select_set(True)
    return item


def lit_sphere(angle):
    """A sphere under a sun that stands `angle` degrees to the left of the viewer."""
    scene = black_scene(TILE, TILE, samples=16, span=2.15)
    add_lamp("SUN", 1.5, rotation=(0, -math.radians(angle), 0))
    add_sphere()
    return scene


def suzanne():
    """Suzanne under an area lamp from above left and a dim world."""
    scene = black_scene(512, 448, samples=192, span=1)
    scene.camera.data.type, scene.camera.data.lens = "PERSP", 70
    scene.camera.location, scene.camera.rotation_euler = (0.9, -6.2, 1.1), (math.radians(81), 0, math.radians(8))
    scene.cycles.use_denoising = True
    background(scene, 0.35, (0.75, 0.85, 1.0))
    add_lamp("AREA", 420, (-2.6, -3.0, 3.4), (math.radians(50), 0, math.radians(-40)), shape="SQUARE", size=2.0)
    bpy.ops.mesh.primitive_monkey_add(size=2, rotation=(0, 0, math.radians(12)))
    bpy.ops.object.shade_smooth()
    bpy.context.object.modifiers.new("Subdivision", "SUBSURF").render_levels = 3
    return scene


def blank_material(name, shader):
    """A material with one node of the type `shader`, unconnected: (material, that node, the surface to connect)."""
    material = bpy.data.materials.new(name)
    if not material.node_tree:
        material.use_nodes = True           # as for the world
    material.cycles.use_bump_map_correction = False     # as the extension has it: 4.2 heeds it for tilted closures too
    tree = material.node_tree
    tree.nodes.clear()
    return material, tree.nodes.new(shader), tree.nodes.new("ShaderNodeOutputMaterial").inputs["Surface"]


def simple_material(name, shader, inputs=None):
    """A material of one node of the type `shader`, with values of its inputs by name, which the surface shows."""
    material, node, surface = blank_material(name, shader)
    for socket, value in (inputs or {}).items():
        node.inputs[socket].default_value = value
    material.node_tree.links.new(node.outputs[0], surface)
    return material


def material_for(fit, nodes=None):
    """A material that holds a fit in the extension's node group; the extension must be registered.

    `nodes` may be `fitter.cycles.node_mixture.Nodes` in the place of the fit's own, which take a second to make.
    """
    from measured_brdf.addon.core.shading import node_group
    from measured_brdf.addon.core.shading.compiler import compile_shader
    from measured_brdf.fitter.cycles.bake import bake

    material, group, surface = blank_material("Measured", "ShaderNodeGroup")
    group.node_tree = (node_group.make(fit) if nodes is None
                       else node_group.create(compile_shader(bake(fit, mixture=nodes.cycles), nodes)))
    material.node_tree.links.new(group.outputs["BSDF"], surface)
    return material


def osl_material_for(fit):
    """A material of a fit for pictures with OSL: what it has for EEVEE is what Cycles has."""
    mixture = cycles_mixture(fit)
    return material_for(fit, Nodes(mixture, mixture))


def add_eevee_output(material):
    """Have EEVEE show what a material's group has for it, and Cycles the rest, as in the extension's materials."""
    tree = material.node_tree
    next(node for node in tree.nodes if node.type == "OUTPUT_MATERIAL").target = "CYCLES"
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    output.target = "EEVEE"
    tree.links.new(group_node(material).outputs["EEVEE"], output.inputs["Surface"])


def group_node(material):
    """The first group of a material's tree: of those of `material_for` the fit's."""
    return next(node for node in material.node_tree.nodes if node.type == "GROUP")


def set_input(material, name, value):
    group_node(material).inputs[name].default_value = value


def connect_vector(material, name, vector):
    """Connect an input of the group to a vector, as nodes compute normals, tangents and tints."""
    node = material.node_tree.nodes.new("ShaderNodeCombineXYZ")
    for socket, value in zip(node.inputs, vector, strict=True):
        socket.default_value = value
    material.node_tree.links.new(node.outputs[0], group_node(material).inputs[name])


def render_in_eevee(scene, samples):
    """As `render`, in EEVEE, which needs OpenGL."""
    engine, scene.render.engine = scene.render.engine, EEVEE
    scene.eevee.taa_render_samples = samples
    found = render(scene)
    scene.render.engine = engine
    return found


def render(scene):
    """Render the scene: (height, width, 4) float32, scene-linear, the top row first."""
    with tempfile.TemporaryDirectory() as folder:
        scene.render.image_settings.file_format = "OPEN_EXR"
        scene.render.image_settings.color_depth = "32"
        scene.render.image_settings.color_mode = "RGBA"
        scene.render.filepath = str(Path(folder) / "picture.exr")
        bpy.ops.render.render(write_still=True)
        image = bpy.data.images.load(scene.render.filepath)
        pixels = np.empty(len(image.pixels), dtype=np.float32)
        image.pixels.foreach_get(pixels)
        picture = pixels.reshape(image.size[1], image.size[0], 4)[::-1]
        bpy.data.images.remove(image)
    return picture


def measure_flat_sample(path, **settings):
    """The plane that a description of photographs of a flat sample becomes, with these settings of its scene: it is
    moved to the scene that was open."""
    before = bpy.context.scene
    bpy.ops.measured_brdf.measure_sample_photographs(filepath=str(path))
    made = bpy.context.scene.measured_brdf_photographs
    for name, value in settings.items():
        setattr(made, name, value)
    assert bpy.ops.measured_brdf.measure_sample() == {"FINISHED"}
    bpy.context.window.scene = before
    before.collection.objects.link(made.sample)
    return made.sample
