"""A carved lion in real photographs, measured: ``python -m demo_scenes.carving PNG``.

Of 240 photographs under a dome of lamps, 20 become maps. Under lamps that were not among those, each photograph stands
above what the maps send there; shadows that parts of a carving cast on others are not in it. Without the measurements
there is no picture.
"""

import tempfile
from pathlib import Path

import numpy as np

import fitter
from fitter.photographs.description.parsing import read
from fitter.photographs.flat.reading import read_sample
from support import ball_files, checkout, sheet

from . import run

SIZE = 384                  # pixels of a tile's width
LION = checkout.measurements() / "photographs" / "lion" / "dirs.lp"
WIDTH, HEIGHT = 64, 43      # pixels of a photograph
USED, OTHERS = 20, (30, 90, 150, 210)
_DESCRIPTION = f"""texels = {WIDTH}
[camera]
position = "far"
[sample]
width = {WIDTH / 1e4}
height = {HEIGHT / 1e4}
corners = [[0, {HEIGHT}], [{WIDTH}, {HEIGHT}], [{WIDTH}, 0], [0, 0]]
[scale]
albedo = 0.3
[lamp]
positions = '{{}}'
"""


def measured():
    """Photographs that were left out, and what maps of others send under their lamps: two (h, w, 3) for each."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "lion.toml")
        path.write_text(_DESCRIPTION.format(LION), "utf-8")
        sample = read_sample(read(path))
    photographs = sample.photographs
    used = [photographs[k] for k in range(0, len(photographs), len(photographs) // USED)]
    maps = fitter.maps_from_flat(used, sample.corners, sample.shape)
    return [(photographs[k].radiance, maps.radiance(photographs[k].camera, photographs[k].lamp,
                                                    photographs[k].intensity)[::-1]) for k in OTHERS]


def draw(path, size=SIZE):
    """Measure and write the picture; nothing without the measurements."""
    if not LION.is_file():
        print(f"{LION} is absent: no picture of it")
        return
    ball_files.add_openimageio()
    rows = [[], []]
    for number, pair in zip(OTHERS, measured(), strict=True):
        white = np.percentile(pair[0], 99.5)
        for row, picture, text in zip(rows, pair, (f"photograph {number + 1}", "measured"), strict=True):
            row.append((np.kron(picture / white, np.ones((size // WIDTH, size // WIDTH, 1))), text))
    sheet.write(path, [[sheet.tile(picture, text) for picture, text in row] for row in rows])


if __name__ == "__main__":
    run(draw, "measured_carving.png")
