"""A printed card that was photographed flat, measured and rendered: ``python -m demo_scenes.card PNG``.

Gold is printed on garnet lacquer and embossed. The photographs are synthetic, under twelve lamps and with 1 % of noise,
and lie as EXR with their description in the folder beside the picture, `card/`. The lamp under which the card is
compared was not among those, and the last picture shows it from the side, under an area lamp and an even sky.
"""

import math

import bpy
import numpy as np

import fitter
from fitter.library import ready
from support import ball_files, checkout, flat_files, flat_scene, sheet, stage

from . import run

SIZE = 224                  # pixels of a tile
SAMPLES = 64                # of a pixel
LAMPS, SHOWN = 12, (0, 1, 6)
ASIDE = np.array([0.09, -0.2, 0.13])
_EDGE, _BEVEL = 0.008, 0.03         # of the print: how wide ink and slope are there, in widths of the card
_HEIGHT = 0.0003            # m
_PETALS = 12
_EXPOSED, _PERCENTILE = 0.8, 98


def within(u, v):
    """How far points are inside of the print, in widths of the card; negative outside."""
    x, y = u - 0.5, 0.8 * (v - 0.5)
    far, turn = np.hypot(x, y), np.arctan2(y, x)
    petals = np.minimum(0.155 + 0.04 * np.cos(_PETALS * turn) - far, far - 0.085)
    sun = np.maximum(petals, 0.05 - far)
    ring = 0.02 - np.abs(far - 0.26)
    frame = 0.018 - np.abs(np.minimum(0.5 - np.abs(x), 0.4 - np.abs(y)) - 0.05)
    dots = 0.03 - np.hypot(0.5 - np.abs(x) - 0.13, 0.4 - np.abs(y) - 0.13)
    return np.maximum.reduce([sun, ring, frame, dots])


def printed(u, v):
    """The weights of lacquer and gold: (n, 2)."""
    gold = np.clip(within(u, v) / _EDGE + 0.5, 0, 1)
    return np.column_stack([1 - gold, gold])


def embossed(u, v):
    """The slopes of the raised print, with the waves of paper: (n, 2)."""
    def height(u, v):
        share = np.clip(within(u, v) / _BEVEL + 0.5, 0, 1)
        return (_HEIGHT * share ** 2 * (3 - 2 * share) + 6e-5 * np.sin(9 * u + 4 * v) * np.sin(7 * v)) / flat_scene.SIZE

    step = 1e-4
    return -np.column_stack([height(u + step, v) - height(u - step, v),
                             (height(u, v + step) - height(u, v - step)) / 0.8]) / (2 * step)


def sample():
    """The card: garnet lacquer where it has been measured, red phenolic of the library elsewhere, and satin gold."""
    path = checkout.measurements() / "cornell" / "garnet_red.astm"
    lacquer = (fitter.fit(fitter.load(path), **fitter.PRESETS["Standard"]) if path.is_file()
               else ready.find("red-phenolic").fit)
    return flat_scene.Sample((lacquer, ready.find("gold-satin").fit), printed, embossed)


def photographed(card, folder, size):
    """Write photographs of a card, and what it is made of: the path of the description."""
    folder.mkdir(parents=True, exist_ok=True)
    for fit, name in zip(card.fits, ("lacquer.npz", "gold.npz"), strict=True):
        fit.save(folder / name)
    top = f"texels = {size}\nmaterials = ['lacquer.npz', 'gold.npz']"
    return flat_files.write(folder, card, flat_scene.lamps(LAMPS), size=(size, size), top=top)


def draw(path, size=SIZE, samples=SAMPLES):
    """Photograph, measure and render; write the picture to a path, and the photographs beside it."""
    ball_files.add_openimageio()
    card = sample()
    setup = photographed(card, path.parent / "card", size)
    scene = stage.black_scene(size, size, samples, span=1)
    scene.cycles.max_bounces, scene.cycles.pixel_filter_type = 0, "BOX"
    stage.measure_flat_sample(setup)
    mask, normals = (_of_image(word, size) for word in ("mask", "normals"))
    most = flat_scene.INTENSITY.max()
    lamp = stage.add_lamp("POINT", 4 * math.pi * most, tuple(flat_scene.UNUSED), color=flat_scene.INTENSITY / most,
                          shadow_soft_size=0.0)
    lamp.data.use_soft_falloff = False
    stage.look(tuple(flat_scene.CAMERA), tuple(flat_scene.TARGET), lens=36 / 0.25)
    scene.camera.data.sensor_width = 36
    measured = stage.render(scene)[..., :3]
    lamps = flat_scene.lamps(LAMPS)
    shown = [_exposed(flat_scene.photograph(card, lamps[k], (size, size), seed=k)) for k in SHOWN]
    truth = flat_scene.photograph(card, flat_scene.UNUSED, (size, size), noise=0)
    bpy.data.objects.remove(lamp)
    lamp = stage.add_lamp("AREA", 3.0, shape="DISK", size=0.12)
    rows = [[*((picture, f"photograph {k + 1}") for picture, k in zip(shown, SHOWN, strict=True)),
             (mask, "mask of the gold"), (normals, "normal map")],
            [(_exposed(truth), "the card, another lamp"), (_exposed(measured, truth), "measured"),
             *((_aside(scene, lamp, turn), f"aside, lamp {text}") for turn, text in (
                 (-40, "left"), (0, "behind"), (40, "right")))]]
    sheet.write(path, [[sheet.tile(picture, text) for picture, text in row] for row in rows])


def _aside(scene, lamp, turn):
    """The card from the side, under an area lamp behind it, turned by so many degrees, and an even sky."""
    turn = math.radians(turn)
    place = tuple(0.45 * np.array([math.sin(turn), math.cos(turn), 0.6]))
    lamp.location, lamp.rotation_euler = place, stage.rotation_toward(place)
    stage.background(scene, 0.15)
    stage.look(tuple(ASIDE), (0, 0, 0), lens=75)
    return _exposed(stage.render(scene)[..., :3])


def _of_image(word, size):
    """An image of the file, a square of this size, as numbers that are shown as they are."""
    image = next(each for each in bpy.data.images if word in each.name)
    width, height = image.size
    pixels = np.array(image.pixels[:], np.float32).reshape(height, width, 4)[::-1, :, :3]
    down = (np.arange(size) * width / size).astype(int)
    rows = down - (size - height * size // width) // 2
    square = pixels[np.clip(rows, 0, height - 1)][:, down]
    square[(rows < 0) | (rows >= height)] = 0
    return np.where(square <= 0.04045, square / 12.92, ((square + 0.055) / 1.055) ** 2.4)


def _exposed(picture, like=None):
    """A picture as bright as is good to see, or as another one is shown."""
    like = picture if like is None else like
    return _EXPOSED / np.percentile(like[like.max(axis=2) > 1e-6], _PERCENTILE) * picture


if __name__ == "__main__":
    run(draw, "measured_card.png")
