"""What is connected to the inputs of a measured material's node, as far as a file for other programs can have it: a
product of a constant and of images."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import bpy
import numpy as np

from ....fitter.arrays import FloatArray
from ....fitter.colours import DEFAULT_COLOURS, conversion, decode_srgb, luminance
from ....fitter.imaging.pictures import srgb
from ..annotations import not_none
from ..blender.node_trees import displayed_name
from ..blender.previews import image_pixels
from ..storage.reading import scene_colours

LARGEST = 2048              # texels on a side of what is baked
_STILL_KINDS = "FILE", "GENERATED"


class Picture(NamedTuple):
    """An output of an Image Texture node; `is_grey` where a number is made of its colour."""

    node: bpy.types.Node
    output: str
    is_grey: bool = False

    @property
    def placement(self) -> tuple[str, str, str]:
        """What lays it onto a surface: images with the same one lie texel upon texel, but for their sizes."""
        vector = self.node.inputs["Vector"]
        link = not_none(vector.links)[0] if vector.is_linked else None
        where = "" if link is None else f"{link.from_node.name}.{link.from_socket.identifier}"
        return where, str(self.node.extension), str(self.node.projection)

    @property
    def key(self) -> tuple[Any, ...]:
        image: Any = self.node.image
        return image.name, tuple(image.size), self.output, self.is_grey, self.placement


class Product(NamedTuple):
    """A constant, (3,) linear, times pictures."""

    constant: FloatArray
    pictures: tuple[Picture, ...] = ()


ONE = Product(np.ones(3))


def read(socket: bpy.types.NodeSocket) -> Product:
    """The value of an input, of a colour or of a number. ValueError if something else is connected to it."""
    if not socket.is_linked:
        return _constant(socket)
    link = not_none(socket.links)[0]
    node: Any = link.from_node
    if node.type == "REROUTE":
        product = read(node.inputs[0])
    elif node.type in ("RGB", "VALUE"):
        product = _constant(link.from_socket)
    elif (node.type == "TEX_IMAGE" and node.image is not None and node.image.source in _STILL_KINDS
          and min(node.image.size)):
        product = Product(np.ones(3), (Picture(node, link.from_socket.name),))
    elif factors := _factors(node):
        first, second = (read(factor) for factor in factors)
        product = Product(first.constant * second.constant, first.pictures + second.pictures)
    else:
        raise ValueError(f"{socket.name}: a constant, an image or their product is exported, and not what the node "
                         f"{displayed_name(node)} makes")
    return _as_number(socket, product) if socket.type == "VALUE" else product


def texels(pictures: Sequence[Picture], size: int = 0) -> dict[Picture, FloatArray]:
    """The linear values of pictures in the open file's colour space, (height, width, 3), of `size` by `size` or as the
    largest; of those that lie otherwise than the first the mean, (3,)."""
    largest = np.max([each.node.image.size for each in pictures], axis=0)
    height, width = (size, size) if size else np.minimum(largest, LARGEST)[::-1]
    values = {each: _linear(each, height, width) for each in pictures}
    return {each: value if each.placement == pictures[0].placement else value.mean(axis=(0, 1))
            for each, value in values.items()}


def _linear(picture: Picture, height: int, width: int) -> FloatArray:
    image: Any = picture.node.image
    y, x = (((np.arange(wanted) + 0.5) * there / wanted).astype(int)
            for wanted, there in ((height, image.size[1]), (width, image.size[0])))
    stored = image_pixels(image)[np.ix_(y, x)].astype(float)
    if picture.output == "Alpha":
        return np.repeat(stored[..., 3:], 3, axis=2)
    colour = linear_colours(image, stored[..., :3])
    return np.repeat(colour @ grey_weights()[:, None], 3, axis=2) if picture.is_grey else colour


def linear_colours(image: bpy.types.Image, stored: FloatArray) -> FloatArray:
    """The values of an image's texels, (..., 3), as renderers take them: linear, in the open file's colour space."""
    if image.is_float or image.colorspace_settings.name != "sRGB":
        return stored
    return np.asarray(decode_srgb(stored) @ conversion(DEFAULT_COLOURS, scene_colours() or DEFAULT_COLOURS).T)


def stored_colours(linear: FloatArray) -> FloatArray:
    """The inverse of `linear_colours`, for an image of 8 bits: (..., 3)."""
    return srgb(linear @ conversion(scene_colours() or DEFAULT_COLOURS, DEFAULT_COLOURS).T)


def grey_weights() -> FloatArray:
    """What red, green and blue count, (3,), where a colour becomes a number."""
    return luminance(np.eye(3), scene_colours() or DEFAULT_COLOURS)


def _constant(socket: Any) -> Product:
    value = np.array(socket.default_value, dtype=float).ravel()[:3]
    return Product(np.broadcast_to(value, 3))


def _factors(node: Any) -> list[bpy.types.NodeSocket]:
    """The two inputs that a node multiplies, if that is what it does."""
    if node.type == "MATH" and node.operation == "MULTIPLY" and not node.use_clamp:
        return list(node.inputs[:2])
    if node.type == "MIX" and (node.data_type, node.blend_type) == ("RGBA", "MULTIPLY") and not node.clamp_result:
        share, *colours = (socket for socket in node.inputs if socket.enabled)
        if not share.is_linked and share.default_value == 1:
            return colours
    return []


def _as_number(socket: bpy.types.NodeSocket, product: Product) -> Product:
    colours = [each for each in product.pictures if not each.is_grey and each.output != "Alpha"]
    number = np.full(3, product.constant @ grey_weights())
    if len(colours) > 1 or (colours and not np.allclose(number, product.constant)):
        raise ValueError(f"{socket.name}: the brightness of a product of colours is not exported")
    return Product(number, tuple(each._replace(is_grey=True) for each in product.pictures))
