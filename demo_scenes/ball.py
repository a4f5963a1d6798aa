"""A ball that was photographed, measured and rendered, beside the truth: ``python -m demo_scenes.ball PNG``.

The photographs are synthetic, of a red paint with a highlight of GGX .1, and lie as EXR with their description in the
folder beside the picture, `ball/`. The lamps of the lower row were not among those that photographed it.
"""

import bpy
import numpy as np

from fitter.formats import saved_samples
from fitter.photographs.ball.measuring import measure_ball
from fitter.photographs.description.parsing import read
from support import ball_files, ball_scene, ball_stage, sheet
from support.stage import render

from . import run

SIZE = 224                  # pixels of a tile
SHOWN = 0, 2, 4, 6          # of the photographs
OTHERS = (65, 200), (105, 20)       # phase and turn of lamps that did not photograph it
_EXPOSED, _PERCENTILE = 0.7, 97


def draw(path, size=SIZE, preset="Standard"):
    """Photograph, measure, fit and render; write the picture to a path, and the photographs beside it."""
    ball_files.add_openimageio()
    model, scenes = ball_scene.glossy(), ball_scene.scenes(size=(size, size))
    folder = path.parent / "ball"
    saved_samples.write(measure_ball(read(ball_files.write(folder, model, scenes))).samples, folder / "ball.npz")
    compared = []
    scene = ball_stage.scene(*OTHERS[0], size=size)
    bpy.ops.measured_brdf.import_data(filepath=str(folder / "ball.npz"), preset=preset)
    for phase, turn in OTHERS:
        ball_stage.lamp(scene).location = ball_stage.lamp_place(phase, turn)
        truth = ball_scene.photograph(model, ball_stage.as_scene(scene, size))
        compared += [(truth, f"the paint, lamp at {phase}°"), (render(scene)[..., :3], f"measured, lamp at {phase}°")]
    rows = [[(ball_scene.photograph(model, scenes[k]), f"photograph, lamp at {ball_scene.PHASES[k]}°") for k in SHOWN],
            compared]
    shown = [_exposures([picture for picture, _ in row]) for row in rows]
    shown[1] = np.repeat(shown[1][::2], 2)          # what is measured as bright as the truth
    sheet.write(path, [[sheet.tile(scale * picture, text) for (picture, text), scale in zip(
        row, scales, strict=True)] for row, scales in zip(rows, shown, strict=True)])


def _exposures(pictures):
    """What each picture is multiplied with to be shown."""
    return [_EXPOSED / np.percentile(each[each.max(axis=2) > 0], _PERCENTILE) for each in pictures]


if __name__ == "__main__":
    run(draw, "measured_ball.png")
