"""A Blender scene of measured materials in Mitsuba 3, which evaluates each `Fit` itself: a second renderer's truth.

Mitsuba (W. Jakob et al.) is a dependency of `make test-mitsuba` alone. Its BSDFs can be written in Python: this one
hands arrays of directions to `Fit.evaluate`. It shares with the shader neither closures nor tables nor lamps.
"""

import math
from dataclasses import dataclass
from pathlib import Path

import bpy
import mitsuba as mi
import numpy as np

from . import flat_scene

mi.set_variant("llvm_ad_rgb")
import drjit as dr  # noqa: E402  (after the variant)

# Every bounce is computed at once, so that NumPy sees its arrays.
for _flag in (dr.JitFlag.SymbolicLoops, dr.JitFlag.SymbolicCalls, dr.JitFlag.SymbolicConditionals):
    dr.set_flag(_flag, False)

_EXPONENT = 150.0           # of the directions that are sampled about the mirror direction
_fits = {}                  # by the name of a material


@dataclass(frozen=True)
class Bumpy:
    """A fit on a surface that is raised by the heights of an image over the UV map."""

    fit: object
    heights: np.ndarray         # (rows, columns) float32: metres, the same upside down


class _FitBSDF(mi.BSDF):
    """The reflectance of a fit; directions are sampled by the cosine and about the mirror direction, half each."""

    def __init__(self, props):
        super().__init__(props)
        named = _fits[props["material"]]
        self.fit = named.fit if isinstance(named, Bumpy) else named
        self.m_flags = mi.BSDFFlags.GlossyReflection | mi.BSDFFlags.FrontSide
        self.m_components = [self.m_flags]

    def sample(self, context, si, sample1, sample2, active=True):
        mirror = mi.Frame3f(mi.reflect(si.wi))
        z = dr.power(sample2.x, 1 / (_EXPONENT + 1))
        r, turn = dr.sqrt(dr.maximum(0, 1 - z * z)), 2 * math.pi * sample2.y
        lobe = mirror.to_world(mi.Vector3f(r * dr.cos(turn), r * dr.sin(turn), z))
        found = mi.BSDFSample3f()
        found.wo = dr.select(sample1 < 0.5, mi.warp.square_to_cosine_hemisphere(sample2), lobe)
        found.eta, found.sampled_component = 1.0, mi.UInt32(0)
        found.sampled_type = mi.UInt32(+mi.BSDFFlags.GlossyReflection)
        found.pdf = self.pdf(context, si, found.wo, active)
        value = self.eval(context, si, found.wo, active)
        return found, dr.select(found.pdf > 0, value / dr.maximum(found.pdf, 1e-20), 0)

    def pdf(self, context, si, wo, active=True):
        cosine = dr.maximum(dr.dot(wo, mi.reflect(si.wi)), 0)
        density = 0.5 * wo.z / math.pi + 0.5 * (_EXPONENT + 1) / (2 * math.pi) * dr.power(cosine, _EXPONENT)
        return dr.select((si.wi.z > 0) & (wo.z > 0) & active, density, 0)

    def eval(self, context, si, wo, active=True):
        seen, lit = np.array(si.wi, float), np.array(wo, float)
        count = max(seen.shape[1], lit.shape[1])
        seen, lit = (np.broadcast_to(w, (3, count)) for w in (seen, lit))
        above = (seen[2] > 0) & (lit[2] > 0) & np.array(active)
        value = np.zeros((3, count), np.float32)
        if above.any():
            (theta_o, phi_o), (theta_i, phi_i) = (
                (np.arccos(w[2, above].clip(0, 1)), np.arctan2(w[1, above], w[0, above])) for w in (seen, lit))
            f = self.fit.evaluate(theta_i, phi_i, theta_o, phi_o)
            value[:, above] = (np.maximum(f, 0) * lit[2, above, None]).T
        return mi.Color3f(*value)

    def eval_pdf(self, context, si, wo, active=True):
        return self.eval(context, si, wo, active), self.pdf(context, si, wo, active)


mi.register_bsdf("fit", _FitBSDF)


def render(scene, fits, samples, bounces, seed=0):
    """What Mitsuba makes of a Blender scene: (height, width, 3), scene-linear, the top row first.

    The scene is of meshes, one material each; of suns without a size, point lamps with one, and rectangular area lamps;
    under an even world or an image; with an orthographic or a perspective camera, which sees neither lamps nor world.
    `fits` has, by the name of a material, its `Fit`, or `Bumpy`; a number, the albedo of a Lambertian surface; or the
    path of an RGL file, which Mitsuba's own BSDF `measured` reads, whose tangent is the mesh's along the active UV map.
    Bounces are as `cycles.max_bounces` counts them.
    """
    _fits.clear()
    _fits.update(fits)
    parts = {"type": "scene", "integrator": {"type": "path", "max_depth": bounces + 2, "rr_depth": 1000,
                                             "hide_emitters": True}}
    depsgraph = bpy.context.evaluated_depsgraph_get()
    for number, instance in enumerate(depsgraph.object_instances):
        item, matrix = instance.object, np.array(instance.matrix_world)
        if item.type == "MESH" and not item.hide_render:
            parts[f"part_{number}"] = _mesh(f"part_{number}", item, matrix, fits)
        elif item.type == "LIGHT":
            parts[f"part_{number}"] = _lamp(item.data, matrix)
        elif item.original == scene.camera:
            parts["sensor"] = _camera(item.data, matrix, scene)
    world = _world(scene.world)
    if world is not None:
        parts["world"] = world
    return np.array(mi.render(mi.load_dict(parts), spp=samples, seed=seed))


def _transform(matrix):
    return mi.ScalarTransform4f(matrix.astype(np.float64))


def _mesh(name, item, matrix, fits):
    mesh = item.to_mesh()
    mesh.calc_loop_triangles()
    corners = np.empty(3 * len(mesh.loop_triangles), np.int32)
    mesh.loop_triangles.foreach_get("loops", corners)
    positions, normals = (np.empty((count, 3), np.float32) for count in (len(mesh.vertices), len(mesh.loops)))
    mesh.vertices.foreach_get("co", positions.ravel())
    mesh.corner_normals.foreach_get("vector", normals.ravel())
    of_corner = np.empty(len(mesh.loops), np.int32)
    mesh.loops.foreach_get("vertex_index", of_corner)
    texture = np.zeros((len(mesh.loops), 2), np.float32)
    mapped = isinstance(fits[item.material_slots[0].material.name], (Path, Bumpy))
    if mapped:
        mesh.uv_layers.active.data.foreach_get("uv", texture.ravel())
    linear = matrix[:3, :3]
    world = positions[of_corner[corners]] @ linear.T + matrix[:3, 3]
    turned = normals[corners] @ np.linalg.inv(linear)
    turned /= np.linalg.norm(turned, axis=1, keepdims=True)
    material = item.material_slots[0].material.name
    properties = mi.Properties()
    properties["bsdf"] = mi.load_dict(_bsdf(material, fits[material]))
    item.to_mesh_clear()
    made = mi.Mesh(name, len(corners), len(corners) // 3, has_vertex_normals=True, has_vertex_texcoords=mapped,
                   props=properties)
    values = mi.traverse(made)
    values["vertex_positions"], values["vertex_normals"] = world.ravel(), turned.ravel()
    if mapped:
        values["vertex_texcoords"] = texture[corners].ravel()
    values["faces"] = np.arange(len(corners), dtype=np.uint32)
    values.update()
    return made


def _bsdf(material, fit):
    if isinstance(fit, (int, float)):
        return {"type": "diffuse", "reflectance": {"type": "rgb", "value": float(fit)}}
    if isinstance(fit, Path):
        return {"type": "measured", "filename": str(fit)}
    if isinstance(fit, Bumpy):
        return {"type": "bumpmap", "bsdf": {"type": "fit", "material": material},
                "heights": {"type": "bitmap", "bitmap": mi.Bitmap(fit.heights[..., None]), "raw": True}}
    return {"type": "fit", "material": material}


def _lamp(light, matrix):
    """Blender states a sun's irradiance, and what other lamps emit in all, but for a factor of a point lamp."""
    at, colour = matrix[:3, 3], np.array(light.color, float) * light.energy
    if light.type == "SUN":
        return {"type": "directional", "direction": -matrix[:3, 2],
                "irradiance": {"type": "rgb", "value": colour.tolist()}}
    if light.type == "POINT":
        radius = light.shadow_soft_size
        return {"type": "sphere", "center": at.tolist(), "radius": radius,
                "emitter": _emitter(colour / (4 * math.pi**2 * radius**2))}
    width, height = light.size, light.size_y if light.shape == "RECTANGLE" else light.size
    placed = _transform(matrix @ np.diag([width / 2, -height / 2, -1, 1]))
    return {"type": "rectangle", "to_world": placed, "emitter": _emitter(colour / (math.pi * width * height))}


def _emitter(radiance):
    return {"type": "area", "radiance": {"type": "rgb", "value": radiance.tolist()}}


def _film(width, height):
    return {"type": "hdrfilm", "width": width, "height": height, "pixel_format": "rgb", "rfilter": {"type": "box"}}


def _camera(data, matrix, scene):
    width, height = scene.render.resolution_x, scene.render.resolution_y
    sensor = {"film": _film(width, height), "sampler": {"type": "independent"}, "near_clip": 1e-3, "far_clip": 1e4}
    looking = matrix @ np.diag([-1, 1, -1, 1])          # Mitsuba's camera looks along +z, its x to the left
    if data.type == "ORTHO":
        half = data.ortho_scale / 2
        return sensor | {"type": "orthographic", "to_world": _transform(looking @ np.diag([half, half, 1, 1]))}
    return sensor | {"type": "perspective", "fov": math.degrees(data.angle), "fov_axis": "larger",
                     "to_world": _transform(looking)}


def _resampled(pixels):
    """The bilinear function of Blender's image at finer texels; Mitsuba's first and last rows are the poles."""
    finer = 4
    height, width = pixels.shape[:2]
    row = (np.linspace(0, 1, finer * height) * height - 0.5).clip(0, height - 1)
    column = (np.arange(finer * width) + 0.5) / finer - 0.5
    upper, left = np.minimum(row.astype(int), height - 2), np.floor(column).astype(int)
    down, right = (row - upper)[:, None, None], (column - left)[:, None]
    lines = (1 - down) * pixels[upper] + down * pixels[upper + 1]
    return np.ascontiguousarray((1 - right) * lines[:, left % width] + right * lines[:, (left + 1) % width])


def _world(world):
    background = world.node_tree.nodes["Background"]
    strength = background.inputs["Strength"].default_value
    if background.inputs["Color"].links:
        image = background.inputs["Color"].links[0].from_node.image
        pixels = np.array(image.pixels[:], np.float32).reshape(image.size[1], image.size[0], 4)[::-1, :, :3]
        # in the middle of Mitsuba's image is z, and up is y; of Blender's, x and z
        upright = np.array([[0, 0, 1, 0], [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 1]])
        return {"type": "envmap", "bitmap": mi.Bitmap(_resampled(pixels)), "scale": strength,
                "to_world": _transform(upright)}
    colour = strength * np.array(background.inputs["Color"].default_value[:3])
    return {"type": "constant", "radiance": {"type": "rgb", "value": colour.tolist()}} if colour.any() else None


def flat_photograph(sample, lamp, size, texels, samples=16):
    """A photograph of a `flat_scene.Sample` of two materials: (height, width, 3), without noise of its own.

    Mask and normals are images of so many texels, (height, width); lamp and camera are those of `flat_scene`.
    """
    u, v = flat_scene.texels(texels)
    mask = sample.weights(u, v)[:, 1].reshape(*texels, 1).astype(np.float32)
    normals = (sample.normals(u, v) / 2 + 0.5).reshape(*texels, 3).astype(np.float32)
    _fits.clear()
    _fits.update({str(number): fit for number, fit in enumerate(sample.fits)})
    blended = {"type": "blendbsdf", "weight": _data(mask), **{
        f"part_{name}": {"type": "fit", "material": name} for name in _fits}}
    stands = mi.ScalarTransform4f().look_at(flat_scene.CAMERA.tolist(), flat_scene.TARGET.tolist(), [0, 0, 1])
    half = [flat_scene.SIZE / 2, 0.4 * flat_scene.SIZE, 1]
    parts = {"type": "scene", "integrator": {"type": "direct", "bsdf_samples": 0, "emitter_samples": 1},
             "card": {"type": "rectangle", "to_world": mi.ScalarTransform4f().scale(half),
                      "bsdf": {"type": "normalmap", "normalmap": _data(normals), "bsdf": blended}},
             "lamp": {"type": "point", "position": lamp.tolist(),
                      "intensity": {"type": "rgb", "value": flat_scene.INTENSITY.tolist()}},
             "sensor": {"type": "perspective", "fov": math.degrees(2 * math.atan(0.125)), "fov_axis": "x",
                        "to_world": stands, "film": _film(*size[::-1])}}
    return np.array(mi.render(mi.load_dict(parts), spp=samples))


def _data(values):
    """A texture of numbers, whose first row is at v = 0."""
    return {"type": "bitmap", "bitmap": mi.Bitmap(values), "raw": True, "wrap_mode": "clamp"}
