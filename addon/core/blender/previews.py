"""Pictures of Blender's previews, icons and images."""

import bpy
import numpy as np

from ....fitter.arrays import SingleArray
from ..annotations import not_none

_SMALL_ICON = 32            # pixels of a small icon


def fill(preview: bpy.types.ImagePreview, picture: SingleArray) -> None:
    """Make an `ImagePreview` show a picture: (height, width, 4) float32."""
    preview.image_size = picture.shape[1::-1]
    preview.image_pixels_float.foreach_set(picture.ravel())


def fill_small(preview: bpy.types.ImagePreview, picture: SingleArray) -> None:
    """Make the small icon of an `ImagePreview` show a picture, which lists have beside their names."""
    step = max(len(picture) // _SMALL_ICON, 1)
    small = np.ascontiguousarray(picture[step // 2::step, step // 2::step])
    preview.icon_size = small.shape[1::-1]
    preview.icon_pixels_float.foreach_set(small.ravel())


def image_pixels(image: bpy.types.Image) -> SingleArray:
    """The picture that an image holds: (height, width, 4), the bottom row first."""
    picture = np.empty((image.size[1], image.size[0], 4), dtype=np.float32)
    not_none(image.pixels).foreach_get(picture.ravel())
    return picture
