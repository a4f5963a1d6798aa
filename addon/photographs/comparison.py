"""What Cycles renders in the scene of photographs, beside one of them: made by a second Blender."""

import json
from pathlib import Path
from typing import Any, NamedTuple

import bpy
import numpy as np

from ...fitter import progress
from ...fitter.arrays import BoolArray, FloatArray, SingleArray
from ...fitter.colours import DEFAULT_COLOURS, conversion
from ...fitter.imaging.pictures import srgb
from ...fitter.photographs.capture import Part, area_means, read_compared
from ...fitter.photographs.description.capture_setup import Description
from ...fitter.photographs.description.parsing import parse
from ..core.annotations import not_none
from ..core.blender import osl_support
from ..core.blender.previews import image_pixels
from ..core.storage.reading import scene_colours

_SOURCE = "scene.blend"
TIMES = 4                   # by which differences are enlarged to be seen
_REQUEST, _ANSWER = "request.json", "compared.npz"
_SIZE, _SAMPLES = 256, 32   # of renders: pixels on a side at most, and samples per pixel
_SHOWN, _PERCENTILE = 0.6, 97       # the linear value that this percentile of the photograph is shown with


class RenderedPair(NamedTuple):
    """A photograph and a render: (size, size, 3) linear, the top row first; pixels that count (size, size)."""

    photograph: FloatArray
    rendered: FloatArray
    counted: BoolArray


def write_request(folder: Path, scene: bpy.types.Scene, description: Description) -> None:
    """Write what `answer` is to compare: a scene, and the description of one of its photographs."""
    bpy.data.libraries.write(str(folder / _SOURCE), {scene}, path_remap="ABSOLUTE", fake_user=True)
    request = {"scene": scene.name, "description": description, "colours": scene_colours() or DEFAULT_COLOURS}
    (folder / _REQUEST).write_text(json.dumps(request), "utf-8")


def answer(folder: Path) -> None:
    """Read the photograph of a folder's request, and render the same place. `read_answer` reads both."""
    osl_support.make_importable("OpenImageIO")
    request = json.loads((folder / _REQUEST).read_text("utf-8"))
    progress.report(0.0, "Reading")
    radiance, counts, part = read_compared(parse(request["description"], request["scene"]))
    size = min(part.side, _SIZE)
    photograph = area_means(radiance, part, size)
    counted = area_means(counts[..., None].astype(float), part, size)[..., 0] > 1 - 1e-6
    if photograph.shape[2] == 3:
        photograph = photograph @ conversion(DEFAULT_COLOURS, request["colours"]).T
    progress.report(0.3, "Rendering")
    with bpy.data.libraries.load(str(folder / _SOURCE), link=False) as (_, target):
        target.scenes = [request["scene"]]
    picture = _render_part(target.scenes[0], part, radiance.shape, size, folder / "render.exr")
    np.savez(folder / _ANSWER, photograph=np.broadcast_to(photograph, (size, size, 3)), rendered=picture[..., :3],
             counted=counted & (picture[..., 3] > 1 - 1e-6))


def _render_part(scene: Any, part: Part, shape: tuple[int, ...], size: int, path: Path) -> SingleArray:
    """Render a part of a scene's picture in a size: (size, size, 4), linear, the top row first."""
    osl_support.enable(scene)
    camera, (height, width, _) = scene.camera.data, shape
    camera.sensor_width *= part.side / width
    camera.shift_x = (part.left + part.side / 2 - width / 2) / part.side
    camera.shift_y = (height / 2 - part.top - part.side / 2) / part.side
    scene.cycles.device, scene.cycles.samples, scene.cycles.use_denoising = "CPU", _SAMPLES, False
    scene.cycles.pixel_filter_type = "BOX"          # each pixel is the mean of its area, as in `area_means`
    scene.render.resolution_x = scene.render.resolution_y = size
    scene.render.resolution_percentage, scene.render.film_transparent = 100, True
    settings = scene.render.image_settings
    settings.file_format, settings.color_depth, settings.color_mode = "OPEN_EXR", "32", "RGBA"
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True, scene=scene.name)
    return image_pixels(bpy.data.images.load(str(path)))[::-1]


def read_answer(folder: Path) -> RenderedPair:
    with np.load(folder / _ANSWER, allow_pickle=False) as stored:
        return RenderedPair(stored["photograph"], stored["rendered"], stored["counted"])


def sheet(pair: RenderedPair) -> SingleArray:
    """The photograph beside the render, and below them half of each beside what differs, enlarged `TIMES`: (2 size, 2
    size, 4), sRGB, the bottom row first."""
    brightest = pair.photograph[pair.counted].max(axis=1) if pair.counted.any() else np.ones(1)
    white = max(float(np.percentile(brightest, _PERCENTILE)), np.finfo(float).tiny)
    seen, shown = (srgb(each / white * _SHOWN) for each in (pair.photograph, pair.rendered))
    left = np.arange(seen.shape[1]) < seen.shape[1] // 2
    differing = np.clip(TIMES * np.abs(seen - shown), 0, 1) * pair.counted[..., None]
    rows = np.concatenate([np.concatenate([seen, shown], axis=1),
                           np.concatenate([np.where(left[:, None], seen, shown), differing], axis=1)])
    whole = np.ones((*rows.shape[:2], 4), dtype=np.float32)
    whole[..., :3] = rows[::-1]
    return whole


def new_image(name: str, picture: SingleArray) -> bpy.types.Image:
    height, width = picture.shape[:2]
    image = bpy.data.images.new(name, width, height)
    not_none(image.pixels).foreach_set(picture.ravel())
    image.pack()
    return image
