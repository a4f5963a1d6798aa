"""Contact sheets: pictures side by side, each with a caption, written as PNG."""

import bpy
import numpy as np

from fitter.imaging.pictures import srgb

from .stage import add, black_scene, render, simple_material

BACKDROP = 0.02             # scene-linear grey behind transparent pixels, so that a dark limb can be seen
CAPTION_HEIGHT = 28
_GAP = 4


def tile(picture, text):
    """A rendered picture (height, width, 3 or 4) as display-referred sRGB (height + caption, width, 3), with its
    caption."""
    return np.concatenate([_over_backdrop(picture), caption(text, picture.shape[1])])


def _over_backdrop(picture):
    alpha = picture[..., 3:] if picture.shape[2] == 4 else 1
    return srgb(picture[..., :3] + (1 - alpha) * BACKDROP)


def caption(text, width):
    """A line of text as a picture. Replaces whatever file is open."""
    scene = black_scene(width, CAPTION_HEIGHT, samples=32, span=width)
    curve = bpy.data.curves.new("Caption", "FONT")
    curve.body, curve.size = text, min(20, 1.7 * width / max(len(text), 1))
    curve.align_x, curve.align_y = "CENTER", "CENTER"
    curve.materials.append(simple_material("Caption", "ShaderNodeEmission"))
    add(curve)
    return _over_backdrop(render(scene))


def write(path, rows):
    height, width, _ = rows[0][0].shape
    columns = max(map(len, rows))
    sheet = np.zeros((len(rows) * (height + _GAP) - _GAP, columns * (width + _GAP) - _GAP, 4), dtype=np.float32)
    sheet[..., 3] = 1
    for i, row in enumerate(rows):
        for j, picture in enumerate(row):
            top, left = i * (height + _GAP), j * (width + _GAP)
            sheet[top:top + height, left:left + width, :3] = picture
    image = bpy.data.images.new(path.stem, sheet.shape[1], sheet.shape[0])
    image.pixels.foreach_set(np.ascontiguousarray(sheet[::-1]).ravel())
    image.file_format = "PNG"
    image.filepath_raw = str(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    image.save()
    bpy.data.images.remove(image)
