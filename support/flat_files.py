"""Synthetic photographs of a flat sample as files, with their description: what `python -m fitter flat` reads."""

from pathlib import Path

from . import flat_scene
from .ball_files import write_picture
from .flat_scene import ANGLE

SIZE = 90, 100


def corners(size=SIZE):
    """Where the sample's corners are in a picture of this height and width: (4, 2), pixels from the left and top."""
    return flat_scene.project(flat_scene.corners(), size)


def description(names, lamps, *, camera="", sample="", scale="", top="", size=SIZE, shots=None):
    """The description of photographs, as text; what is given is in the place of the truth."""
    places = [[round(float(x), 3) for x in place] for place in corners(size)]
    lines = ['name = "flat sample (synthetic)"', top, "[camera]", camera or f"field_of_view = {ANGLE}", "[sample]",
             sample or f"width = 0.1\nheight = 0.08\ncorners = {places}", "[scale]",
             scale or f"intensity = {flat_scene.INTENSITY.tolist()}"]
    for number, (name, lamp) in enumerate(zip(names, lamps, strict=True)):
        lines += ["[[photograph]]", f"files = ['{name}']",
                  shots[number] if shots else f"lamp = {[round(float(x), 6) for x in lamp]}"]
    return "\n".join(lines) + "\n"


def write(folder, sample, lamps, size=SIZE, noise=0.01, **how):
    """Write photographs of a sample under lamps, and their description: its path."""
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    names = [f"lamp{number}.exr" for number in range(1, len(lamps) + 1)]
    for number, (name, lamp) in enumerate(zip(names, lamps, strict=True)):
        write_picture(folder / name, flat_scene.photograph(sample, lamp, size, noise, seed=number))
    path = folder / "setup.toml"
    path.write_text(description(names, lamps, size=size, **how), encoding="utf-8")
    return path
