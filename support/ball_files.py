"""Synthetic photographs of a ball as files, with their description: what `python -m fitter photographs` reads."""

import importlib.util
import sys
from pathlib import Path

import numpy as np

from . import ball_scene


def add_openimageio():
    """Make OpenImageIO importable: Blender as a Python module has it in a folder that is not on the path.

    Returns the folder in which it lies, also where another has made it importable; False where it is not there.
    """
    known = importlib.util.find_spec("OpenImageIO")
    if known is not None:
        return Path(known.origin).parents[1]
    import bpy

    folders = sorted(Path(bpy.utils.resource_path("LOCAL")).glob("python/lib/python3.*/site-packages"))
    found = [folder for folder in folders if (folder / "OpenImageIO").exists()]
    if not found:
        return False
    sys.path.append(str(found[0]))
    return found[0]


def write_picture(path, pixels, depth=None, **attributes):
    """Write a picture (height, width, channels), linear, as OpenImageIO knows its name, with attributes of the file;
    the depth ("uint16") is by default single precision, or 8 bits of PNG and JPEG."""
    import OpenImageIO

    pixels = np.ascontiguousarray(pixels, dtype=np.float32)
    file = OpenImageIO.ImageBuf(pixels)
    for name, value in attributes.items():
        file.specmod().attribute(name.replace("__", ":"), value)
    if depth or str(path).endswith((".png", ".jpg")):
        file.set_write_format(depth or "uint8")
    if not file.write(str(path)):
        raise OSError(file.geterror())


def description(scenes, files, scale, centre="outline", more=""):
    """The description of photographs of scenes, as text."""
    first = scenes[0]
    lines = ['name = "painted ball (synthetic)"', "", "[camera]", f"position = {list(first.camera)}",
             f"look_at = {list(first.target)}", f"field_of_view = {first.angle}", "", "[ball]",
             f"centre = {centre!r}" if centre == "outline" else f"centre = {list(centre)}", f"radius = {first.radius}",
             "", "[lamp]", f"radius = {first.lamp_radius}" if first.lamp_radius else "", more, "", "[scale]", scale]
    for scene, names in zip(scenes, files, strict=True):
        lines += ["", "[[photograph]]", f"files = {names}", f"lamp = {[round(float(x), 6) for x in scene.lamp]}"]
    return "\n".join(lines).replace("'", '"') + "\n"


def write(folder, model, scenes, noise=0.01):
    """Write photographs of a model to a folder, with a card that has the scale, and their description: its path."""
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    names = []
    for number, scene in enumerate(scenes, start=1):
        names.append([f"lamp{number}.exr"])
        write_picture(folder / names[-1][0], ball_scene.photograph(model, scene, noise=noise, seed=number))
    first, height, width = scenes[0], *scenes[0].size
    normal = np.subtract(first.camera, first.centre) / np.linalg.norm(np.subtract(first.camera, first.centre))
    away = np.subtract(first.lamp, first.centre)
    card = 0.18 / np.pi * np.asarray(first.intensity) * (normal @ away) / np.linalg.norm(away) ** 3
    write_picture(folder / "card.exr", np.broadcast_to(card, (height, width, 3)))
    region = [width // 3, height // 3, 2 * width // 3, 2 * height // 3]
    scale = (f'card = {{file = "card.exr", albedo = 0.18, normal = {normal.tolist()}, '
             f'lamp = {[float(x) for x in first.lamp]}, region = {region}}}')
    path = folder / "setup.toml"
    path.write_text(description(scenes, names, scale), encoding="utf-8")
    return path
