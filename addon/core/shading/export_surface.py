"""The surface of a measured material in other programs: a Principled BSDF that exporters find, and renderers never see.

It has a Material Output for all renderers. Cycles and EEVEE prefer those that are made for them; MaterialX and glTF
take this one, USD the first Principled BSDF of a material, OBJ and FBX one that is linked to an output.

How bright highlights are is a level in glTF and MaterialX, which follow links to Value nodes. In the preview of USD,
which takes what an input has without its link, as OBJ does, it is an index of refraction.

Tint and Strength multiply all that the closest Principled BSDF reflects. Where images are in them, or are masks of a
mix, the products are baked: of the four formats glTF alone has a factor beside a texture.
"""

from collections.abc import Callable, Collection, Iterator
from functools import partial
from typing import Any, NamedTuple

import bpy
import numpy as np

from ....fitter.arrays import FloatArray
from ....fitter.colours import DEFAULT_COLOURS, conversion
from ....fitter.cycles.principled_bsdf import DIELECTRIC, Principled
from ....fitter.optics.fresnel import reflectance_to_index
from ..annotations import not_none
from ..blender.node_trees import displayed_name
from ..storage.outcomes import Surface
from ..storage.reading import scene_colours
from . import export_inputs, mixing, node_group
from .export_inputs import ONE, Picture, Product

EXPORT_NAME = "Measured BRDF Export"
BASE_COLOR, ROUGH_METAL = f"{EXPORT_NAME} Base Color", f"{EXPORT_NAME} Roughness and Metallic"  # Image Texture nodes
_CHANNELS = f"{EXPORT_NAME} Channels"   # node that separates the latter
_FITTED = "measured_brdf"               # custom properties of the node: the values of the last fit,
_SHOWN = "measured_brdf_shown"          # those that were last written,
_ALBEDO_VALUE = "albedo"                # among either: of the whole surface, for the Solid viewport,
_NORMAL_SOURCE = "measured_brdf_normal"  # the node that the normal was taken from,
_DISPLACED = "measured_brdf_displacement"       # the node that displacement was taken from,
_EXPORT_KEY = "measured_brdf_key"       # what all was made of,
_LOST = "measured_brdf_lost"            # and what of it is not exported, a line each
_LEVEL_INPUT = "Specular IOR Level"
_INPUTS_OF_USD = ((_LEVEL_INPUT, 0.5), ("IOR", 1.5))      # where links are not followed, and what new nodes have
NOT_EVERYWHERE = "In "                  # how a loss begins that not all formats have
_HUE = 0.05                             # of a tint, largest less smallest over largest: less is grey
_VISIBLE = 1.5 / 255                    # a difference of roughness or of metallic that is worth a texture
_MOST_REFLECTED = 0.996                 # along the normal, by an index of 1000, which is the most that Blender takes
_SMOOTH_ROUGHNESS = 0.3                 # roughness below which reflections are seen as such

_Read = Callable[[bpy.types.NodeSocket], FloatArray]
_Values = dict[str, Any]


def update(material: bpy.types.Material, node: bpy.types.Node, surface: Surface) -> None:
    """Set the Principled BSDF that is exported to the closest one to the data, and the colour in the Solid viewport,
    both as the inputs of `node`, the measured group's, change it. The user's own output for all renderers stays."""
    albedo = scene_color(surface, surface.albedo)
    material.diffuse_color, material.roughness = (*albedo, 1), surface.principled.roughness
    material.metallic = 0           # the Solid viewport has next to nothing for metals to reflect
    export = _export_node(not_none(material.node_tree))
    if export is not None:
        fitted = inputs(surface.principled, lambda color: scene_color(surface, color))
        export[_SHOWN] = {**_last_written(export), _ALBEDO_VALUE: tuple(albedo)}
        export[_FITTED] = {**fitted, _ALBEDO_VALUE: tuple(albedo)}
        follow(material, node)


def mix(material: bpy.types.Material, node: bpy.types.Node) -> None:
    """Make the Principled BSDF of a mix that `node` shows, between those of its materials."""
    if _blend_values(node, material, partial(_read, seen={})):
        _export_node(not_none(material.node_tree))
        follow(material, node)


def follow(material: bpy.types.Material, node: bpy.types.Node, again: bool = False) -> None:
    """Have the exported surface of a material, and its colour in the Solid viewport, follow what is set at `node`,
    connected to it, and the materials that it mixes. `again` where images have changed."""
    tree = not_none(material.node_tree)
    export = _node(tree)
    if export is None:
        return
    _follow_normal(tree, node, export)
    _follow_displacement(tree, export)
    products = [_product(socket) for socket in _factors(node)]
    key = repr((_blend_values(node, material, partial(_read, seen={})),
                [(each.constant.tolist(), [picture.key for picture in each.pictures]) for each in products],
                _list_losses(node)))
    if key == export.get(_EXPORT_KEY) and not again:
        return
    found = evaluate(material, node)
    if not found.values:
        return
    values = found.values
    _bake(material, export, values, found.placed)
    _set(export, {name: _mean(value) for name, value in values.items() if name != _ALBEDO_VALUE})
    if _ALBEDO_VALUE in values:
        _set_solid(material, export, _mean(values[_ALBEDO_VALUE]))
    export[_EXPORT_KEY], export[_LOST] = key, "\n".join(found.lost)


class Evaluated(NamedTuple):
    """What is exported of a measured group or a mix, where it varies at texels."""

    values: _Values     # by an input's name, (1 or 3,) or (height, width, 1 or 3), linear; empty if a part is missing
    tint: FloatArray    # Tint times Strength, which `values` have been multiplied by: (3,) or (height, width, 3)
    read: _Read         # the value of another input of the group or of a mix inside of it, as `tint`
    lost: list[str]     # what of it is not exported
    placed: bpy.types.Node | None       # the texels lie as the image of this node does


def evaluate(material: bpy.types.Material, node: bpy.types.Node, size: int = 0,
             fitted: Callable[[bpy.types.Material], _Values] | None = None) -> Evaluated:
    """What is exported of what `node` shows, the measured group's or a mix's: at the texels of the largest image, or at
    `size` by `size`. Instead of the closest Principled BSDF, `fitted` returns the values of a material's fit."""
    pictures = list(dict.fromkeys(picture for socket in _factors(node) for picture in _product(socket).pictures))
    read: _Read = partial(_read, seen=export_inputs.texels(pictures, size) if pictures else {})
    values, lost, tint = _blend_values(node, material, read, fitted), _list_losses(node), np.ones(3)
    for name in ("Tint", "Strength"):
        tint = tint * (read(node.inputs[name]) if name in node.inputs else 1.0)
    tint = np.maximum(tint, 0)              # as renderers take it
    if values:
        _multiply(values, tint, lost)
    return Evaluated(values, tint, read, lost, pictures[0].node if pictures else None)


def losses(material: bpy.types.Material) -> list[str]:
    """What of a measured material is not exported, a sentence each, without a full stop."""
    tree = not_none(material.node_tree)
    export, output = _node(tree), tree.get_output_node("ALL")
    links = () if output is None else not_none(output.inputs["Surface"].links)
    if all(link.from_node != export for link in links):
        return [f"What other programs get is the surface at the output {output.name}" if output is not None
                else "Other programs get no surface: there is no Material Output for all renderers"]
    lost = [line for line in export.get(_LOST, "").split("\n") if line]
    images = [tree.nodes[name].image for name in (BASE_COLOR, ROUGH_METAL) if name in tree.nodes]
    if any(image is not None and image.packed_file is not None for image in images):
        lost.append(f"{NOT_EVERYWHERE}OBJ, and in FBX that does not embed them, textures are named and not written "
                    "while they are packed: File > External Data > Unpack Resources writes them")
    return lost


def uses_images(node: bpy.types.Node, images: Collection[bpy.types.Image]) -> bool:
    """Whether what is exported of a measured group or a mix is made of any of these images."""
    names = {image.name for image in images}
    return any(picture.key[0] in names for socket in _factors(node) for picture in _product(socket).pictures)


def is_reflective(material: bpy.types.Material) -> bool:
    export = _node(not_none(material.node_tree))
    fitted = {} if export is None else dict(export.get(_FITTED, {}).items())
    return bool(fitted) and (fitted["Metallic"] > 0.5 or fitted["Roughness"] < _SMOOTH_ROUGHNESS
                             or (fitted["Coat Weight"] > 0.5 and fitted["Coat Roughness"] < _SMOOTH_ROUGHNESS))


def inputs(close: Principled, shown: Callable[[FloatArray], FloatArray]) -> dict[str, Any]:
    """The values of the inputs of a Principled BSDF by name; `shown` converts its colours, (3,) each."""
    return {"Base Color": (*shown(close.base_color), 1.0), "Metallic": close.metallic, "Roughness": close.roughness,
            _LEVEL_INPUT: close.specular_level, "Specular Tint": (1.0, 1.0, 1.0, 1.0),
            "Sheen Weight": close.sheen_weight,
            "Sheen Roughness": close.sheen_roughness, "Sheen Tint": (*shown(close.sheen_tint), 1.0),
            "Coat Weight": close.coat_weight, "Coat Roughness": close.coat_roughness}


def scene_color(surface: Surface, color: FloatArray) -> FloatArray:
    """A colour of a surface, (3,), in the space of the open file, as Blender takes it: libraries may have another."""
    return np.clip(conversion(surface.colours, scene_colours() or DEFAULT_COLOURS) @ color, 0, 1)


def _factors(node: bpy.types.Node) -> Iterator[bpy.types.NodeSocket]:
    """The inputs that change what is exported of a measured group or of a mix, also of the mixes inside of it."""
    yield from (node.inputs[name] for name in ("Tint", "Strength") if name in node.inputs)
    yield from _share_sockets(node)


def _share_sockets(node: bpy.types.Node) -> Iterator[bpy.types.NodeSocket]:
    if mixing.mixes.is_mix(node.node_tree):
        yield mixing.mixes.factor(node)
        for part in mixing.mixes.nodes(node):
            yield from _share_sockets(part)


def _product(socket: bpy.types.NodeSocket) -> Product:
    """What is read of an input; where it cannot be, what the input has without a link, or 1."""
    try:
        return export_inputs.read(socket)
    except ValueError:
        return ONE if socket.name in ("Tint", "Strength") else Product(np.full(3, socket.default_value))


def _read(socket: bpy.types.NodeSocket, seen: dict[Picture, FloatArray]) -> FloatArray:
    """The value of an input, (3,) or (height, width, 3); pictures that have not been looked up count 1."""
    product = _product(socket)
    value = product.constant
    for picture in product.pictures:
        value = value * seen.get(picture, 1.0)
    return value


def _blend_values(node: bpy.types.Node, material: bpy.types.Material | None, read: _Read,
             fitted: Callable[[bpy.types.Material], _Values] | None = None) -> _Values:
    """The values of what a measured group or a mix shows, by name: (1 or 3,) or (height, width, 1 or 3); none where
    a material of a mix has been deleted, or has no exported surface."""
    if not mixing.mixes.is_mix(node.node_tree):
        export = None if material is None else _node(not_none(material.node_tree))
        if material is None or export is None or export.get(_FITTED) is None:
            return {}
        return _own(export, dict(export[_FITTED].items()) if fitted is None else fitted(material))
    parts, share = mixing.mixes.parts(node), np.clip(read(mixing.mixes.factor(node)), 0, 1)
    below, above = (_blend_values(part, of, read, fitted)
                    for part, of in zip(mixing.mixes.nodes(node), parts[:2], strict=True))
    return {name: (1 - weight) * below[name] + weight * above[name] for name in below if name in above
            for weight in [share if len(below[name]) == 3 else share[..., :1]]}


def _own(export: bpy.types.Node, fitted: _Values) -> _Values:
    """The values of a fit, and what the user has changed of them."""
    written, values = _last_written(export), {}
    for name, value in fitted.items():
        is_fitted = name == _ALBEDO_VALUE or _is_as_written(export, name, written)
        own = value if is_fitted else _socket(export, name).default_value
        values[name] = np.array(own, dtype=float).ravel()[:3]
    return values


def _last_written(export: bpy.types.Node) -> _Values:
    return dict(export.get(_SHOWN, {}).items())


def _is_as_written(export: bpy.types.Node, name: str, written: _Values) -> bool:
    return name not in written or np.allclose(written[name], _socket(export, name).default_value, atol=1e-6)


def _socket(export: bpy.types.Node, name: str) -> Any:
    """Where the value of an input is: at a Value node of ours that is connected to it, or at the input itself."""
    link = next(iter(not_none(export.inputs[name].links)), None)
    is_ours = link is not None and link.from_node.name == f"{EXPORT_NAME} {name}" and link.from_node.type == "VALUE"
    return link.from_socket if link is not None and is_ours else export.inputs[name]


def _multiply(values: _Values, factor: FloatArray, lost: list[str]) -> None:
    """Multiply all that a surface reflects; `lost` gets what of it exceeds 1, or is not in all files."""
    # of highlights brightness is in their level, and hue in the tint; that of a metal is of its edge, without a level
    grey = (factor @ export_inputs.grey_weights())[..., None]
    brightest = factor.max(axis=-1, keepdims=True) ** (1 - values["Metallic"])
    values["Specular Tint"] = np.divide(1.0, brightest, out=np.ones_like(brightest), where=brightest > 0) * np.ones(3)
    if _LEVEL_INPUT in values:
        values[_LEVEL_INPUT] = values[_LEVEL_INPUT] * brightest
    if np.abs(brightest - 1).max() > _HUE:
        lost.append(f"{NOT_EVERYWHERE}FBX highlights are as bright as without Tint and Strength; so they are in OBJ "
                    "where a program does not read its index of refraction")
    if (np.ptp(factor / np.maximum(brightest, 1e-9), axis=-1, keepdims=True) * (1 - values["Metallic"])).max() > _HUE:
        lost.append(f"{NOT_EVERYWHERE}USD, OBJ and FBX highlights are white: these formats have no tint of them")
    for name, by in (("Base Color", factor), ("Specular Tint", factor), ("Sheen Tint", factor), ("Coat Weight", grey),
                     (_ALBEDO_VALUE, factor)):
        if name in values:
            bright = values[name] * by
            if name == "Base Color" and bright.max() > 1 + _VISIBLE:
                lost.append(f"Tint and Strength make the base color {bright.max():.2g} at its brightest, which is "
                            "exported as 1")
            values[name] = np.clip(bright, 0, 1)


def _mean(value: FloatArray) -> Any:
    """A value for an input: a number, or a colour with an alpha of 1."""
    mean = value.reshape(-1, value.shape[-1]).mean(axis=0)
    return (*mean.tolist(), 1.0) if len(mean) == 3 else float(mean[0])


def _list_losses(node: bpy.types.Node) -> list[str]:
    lost, placements = [], []
    for socket in _factors(node):
        try:
            placements += [picture.placement for picture in export_inputs.read(socket).pictures]
        except ValueError as error:
            lost.append(str(error))
    if len(set(placements)) > 1:
        lost.append("Images that lie otherwise than the first are exported as their mean")
    normal = node.inputs.get("Normal")
    source = None if normal is None else normal_map(normal)
    if normal is not None and normal.is_linked and source is None:
        lost.append("Normal: a Normal Map node in tangent space is exported, and not "
                    f"{displayed_name(not_none(not_none(normal.links)[0].from_node))}")
    elif source is not None and source.node.inputs["Strength"].default_value != 1:
        lost.append(f"{NOT_EVERYWHERE}USD the normal map has a Strength of 1")
    if "Tangent" in node.inputs:
        lost.append("The highlight is exported round: Tangent and Rotation have no effect")
    if node_group.SCALE_INPUT in node.inputs:
        lost.append("Light below the surface is exported as a diffuse surface of the same albedo")
    return lost


def normal_map(socket: bpy.types.NodeSocket) -> bpy.types.NodeSocket | None:
    """The output of a Normal Map node of an image, if it is connected to an input."""
    source: Any = not_none(socket.links)[0].from_socket if socket.is_linked else None
    while source is not None and source.node.type == "REROUTE":
        source = source.node.inputs[0].links[0].from_socket if source.node.inputs[0].is_linked else None
    is_exported = source is not None and source.node.type == "NORMAL_MAP" and source.node.space == "TANGENT"
    return source if is_exported else None


def _follow_normal(tree: bpy.types.NodeTree, node: bpy.types.Node, export: bpy.types.Node) -> None:
    wanted = normal_map(node.inputs["Normal"]) if "Normal" in node.inputs else None
    if _follow_link(tree, export.inputs["Normal"], wanted, export.get(_NORMAL_SOURCE, "")):
        export[_NORMAL_SOURCE] = not_none(wanted).node.name


def _follow_displacement(tree: bpy.types.NodeTree, export: bpy.types.Node) -> None:
    """Connect what displaces at the exported output, the one that Blender highlights, to those of the renderers."""
    outputs = [node for node in tree.nodes if node.type == "OUTPUT_MATERIAL"]
    ours = [node for node in outputs
            if any(link.from_node == export for link in not_none(node.inputs["Surface"].links))]
    links = [link for node in ours for link in not_none(node.inputs["Displacement"].links)]
    before, wanted = export.get(_DISPLACED, ""), not_none(links[0].from_socket) if links else None
    for node in outputs:
        if ours and node not in ours:
            _follow_link(tree, node.inputs["Displacement"], wanted, before)
    now = "" if wanted is None else wanted.node.name
    if now != before:
        export[_DISPLACED] = now


def _follow_link(tree: bpy.types.NodeTree, target: bpy.types.NodeSocket, wanted: bpy.types.NodeSocket | None,
                 before: str) -> bool:
    """Connect an input to what is wanted, in the place of a link from the node `before` alone: whether it is new."""
    for link in not_none(target.links):
        if link.from_node.name == before and link.from_socket != wanted:
            tree.links.remove(link)
    if wanted is None or target.is_linked:
        return False
    tree.links.new(wanted, target)
    return True


def _bake(material: bpy.types.Material, export: bpy.types.Node, values: _Values,
          placed: bpy.types.Node | None) -> None:
    """Connect textures of what varies over the surface, laid onto it as the image of `placed` is; remove the others."""
    tree = not_none(material.node_tree)
    color = values["Base Color"] if values["Base Color"].ndim == 3 else None
    if _fill(tree, BASE_COLOR, f"{material.name} base color", color, placed, is_data=False):
        _connect(tree, tree.nodes[BASE_COLOR].outputs["Color"], export.inputs["Base Color"])
        values["Base Color"] = np.ones(3)       # OBJ multiplies both
    varying = [values[name] for name in ("Roughness", "Metallic")]
    packed = None
    if any(each.ndim == 3 and np.ptp(each) > _VISIBLE for each in varying):
        shape = next(each.shape[:2] for each in varying if each.ndim == 3)
        packed = np.concatenate([np.broadcast_to(each, (*shape, 1)) for each in (np.ones(1), *varying)], axis=2)
    if _fill(tree, ROUGH_METAL, f"{material.name} roughness and metallic", packed, placed, is_data=True):
        channels = tree.nodes.get(_CHANNELS) or tree.nodes.new("ShaderNodeSeparateColor")
        channels.name, channels.location = _CHANNELS, (export.location.x - 200, export.location.y - 300)
        _connect(tree, tree.nodes[ROUGH_METAL].outputs["Color"], channels.inputs[0])
        for output, name in (("Green", "Roughness"), ("Blue", "Metallic")):
            _connect(tree, channels.outputs[output], export.inputs[name])
    elif _CHANNELS in tree.nodes:
        tree.nodes.remove(tree.nodes[_CHANNELS])


def _fill(tree: bpy.types.NodeTree, name: str, called: str, picture: FloatArray | None, placed: bpy.types.Node | None,
          is_data: bool) -> bool:
    """Give an Image Texture node of a name a packed image, (height, width, 3), or remove both: whether it has."""
    texture: Any = tree.nodes.get(name)
    if texture is not None and texture.image is not None:
        former = texture.image
        texture.image = None
        if not former.users:
            bpy.data.images.remove(former)
    if picture is None or placed is None:
        if texture is not None:
            tree.nodes.remove(texture)
        return False
    image = new_image(called, picture, is_data)
    image.filepath_raw = f"//{image.name}.png"      # OBJ and USD name it by its path, and USD writes it by its name
    image.pack()
    if texture is None:
        export = tree.nodes[EXPORT_NAME]
        texture = tree.nodes.new("ShaderNodeTexImage")
        texture.name = texture.label = name
        texture.location = export.location.x - 500, export.location.y - 300 * is_data
    texture.image, texture.extension, texture.projection = image, placed.extension, placed.projection
    vector = placed.inputs["Vector"]
    if vector.is_linked:                # in the material: images inside of a mix are laid onto its UV map
        _connect(tree, not_none(not_none(vector.links)[0].from_socket), texture.inputs["Vector"])
    else:
        for link in texture.inputs["Vector"].links:
            tree.links.remove(link)
    return True


def new_image(name: str, picture: FloatArray, is_data: bool) -> bpy.types.Image:
    """An image of values, (height, width, 3): numbers, or linear colours in the open file's space."""
    height, width = picture.shape[:2]
    image = bpy.data.images.new(bpy.path.clean_name(name), width, height, is_data=is_data)
    stored = picture if is_data else export_inputs.stored_colours(picture)
    not_none(image.pixels).foreach_set(np.insert(stored, 3, 1, axis=2).astype(np.float32).ravel())
    return image


def _connect(tree: bpy.types.NodeTree, source: bpy.types.NodeSocket, target: bpy.types.NodeSocket) -> None:
    """Connect an input, unless the user has connected something to it."""
    links = not_none(target.links)
    if target.node.name != EXPORT_NAME or all(link.from_node.name in (BASE_COLOR, _CHANNELS) for link in links):
        tree.links.new(source, target)


def _set(node: bpy.types.Node, values: dict[str, Any]) -> None:
    """Set inputs; what a user has changed since they were last set stays."""
    written = _last_written(node)
    for name, value in values.items():
        if _is_as_written(node, name, written):
            _socket(node, name).default_value = written[name] = value
    node[_SHOWN] = written
    # UsdPreviewSurface has no level: an index alone tells how bright highlights are
    if all(_socket(node, name) != node.inputs[name] for name, _ in _INPUTS_OF_USD):
        level = np.array(_socket(node, _LEVEL_INPUT).default_value)
        reflected = np.minimum(2 * DIELECTRIC * level, _MOST_REFLECTED)
        node.inputs["IOR"].default_value = float(reflectance_to_index(reflected))


def _set_solid(material: bpy.types.Material, export: bpy.types.Node, albedo: Any) -> None:
    """Set the colour in the Solid viewport, unless the user has."""
    before = _last_written(export)
    if _ALBEDO_VALUE not in before or np.allclose(before[_ALBEDO_VALUE], material.diffuse_color[:3], atol=1e-6):
        material.diffuse_color = albedo
        export[_SHOWN] = {**before, _ALBEDO_VALUE: albedo[:3]}


def _node(tree: bpy.types.NodeTree) -> bpy.types.Node | None:
    node = tree.nodes.get(EXPORT_NAME)
    return node if node is not None and node.bl_idname == "ShaderNodeBsdfPrincipled" else None


def _export_node(tree: bpy.types.NodeTree) -> bpy.types.Node | None:
    """The Principled BSDF to set, which is made where there is none; None if the user exports something else."""
    node = _node(tree)
    outputs = [each for each in tree.nodes if each.type == "OUTPUT_MATERIAL"]
    if any(each.target == "ALL" for each in outputs):
        return node
    right = max((each.location.x for each in outputs), default=0)
    below = min((each.location.y for each in outputs), default=0) - 180
    if node is None:
        node = tree.nodes.new("ShaderNodeBsdfPrincipled")
        for number, (name, value) in enumerate(_INPUTS_OF_USD):
            made = tree.nodes.new("ShaderNodeValue")
            made.name, made.label, made.location = f"{EXPORT_NAME} {name}", name, (right - 460, below - 100 * number)
            made.outputs[0].default_value = node.inputs[name].default_value = value
            tree.links.new(made.outputs[0], node.inputs[name])
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    node.name = node.label = output.label = EXPORT_NAME
    output.location, node.location = (right, below), (right - 260, below)
    tree.links.new(node.outputs["BSDF"], output.inputs["Surface"])
    output.is_active_output = True
    return node
