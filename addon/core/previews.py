"""Pictures of Blender's previews and icons."""

import bpy

from ...fitter.arrays import SingleArray


def fill(preview: bpy.types.ImagePreview, picture: SingleArray) -> None:
    """Make an `ImagePreview` show a picture: (height, width, 4) float32."""
    preview.image_size = picture.shape[1::-1]
    preview.image_pixels_float.foreach_set(picture.ravel())
