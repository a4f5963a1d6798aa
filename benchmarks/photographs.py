"""How true materials are that photographs of a ball make: synthetic photographs of known reflectances.

    python -m benchmarks.photographs [NAME ...] [--lamps 8]     some two minutes; the names of materials choose

The photographs have 120 x 120 pixels and 1 % of noise, and are fitted by the preset Standard. Errors are root mean
squares of the difference of cube roots of cosine-weighted values, as shares of those of the truth, at the directions of
`harness.judging`: at those that photographs cover (`fitter.photographs.coverage`), and at all. FLIP is that of the ball
under a lamp that was not used. The last columns say by how much, in the same measure at covered directions, the result
changes where the ball is one pixel beside its place, or each lamp one degree.
"""

import argparse
import os
import sys

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")      # before NumPy starts them

from dataclasses import replace

import numpy as np

import fitter
from fitter.photographs.coverage import are_covered
from fitter.quality.cross_validation import cube_root
from support import ball_scene
from support.checkout import measurements
from support.evidence import show_table

from .dense import image_errors
from .dense.sphere import evaluated
from .harness.judging import directions

NOISE = 0.01
SYNTHETIC = ball_scene.matte, ball_scene.satin, ball_scene.glossy, ball_scene.velvet
# files below the folder of measurements, and samples
REAL = {"felt": ("curet/abrdf.dat", 1), "leather": ("curet/abrdf.dat", 5), "krylon blue": (
    "cornell/krylon_blue_RGB.astm", None), "garnet red": ("cornell/garnet_red_RGB.astm", None),
    "silk blue": ("rgl/vch_silk_blue_rgb.bsdf", None)}
COLUMNS = "covered", "all", "FLIP", "1 pixel", "1 degree"
LIMITS = 0.05, 0.10, 0.03, 0.03, 0.03


def materials(names=()):
    """The materials whose names contain one of the names, all without: (name, function that returns a model)."""
    folder = measurements()
    found = {make.__name__: make for make in SYNTHETIC}
    for name, (file, sample) in REAL.items():
        if (folder / file).is_file():
            found[name] = lambda path=folder / file, sample=sample: fitter.fit(
                fitter.load(path, sample), **fitter.PRESETS["Standard"])
        else:
            print(f"left out: {name}, {folder / file} is not there")
    return [(name, make) for name, make in found.items() if not names or any(part in name for part in names)]


def photographs(model, phases=ball_scene.PHASES, noise=NOISE, **settings):
    """`fitter.BallPhotograph`s of a model."""
    return [fitter.BallPhotograph(ball_scene.photograph(model, scene, noise=noise, seed=number), scene.rays(),
                                  scene.camera, scene.centre, scene.radius, scene.lamp, scene.intensity,
                                  scene.lamp_radius, name=f"photograph {number}")
            for number, scene in enumerate(ball_scene.scenes(phases, **settings), start=1)]


def beside(found):
    """Photographs whose ball is said to be a pixel to the right and above its place."""
    return [replace(each, centre=each.centre + _pixel(each) * np.array([1, 0, 1]) / np.sqrt(2)) for each in found]


def turned(found, degrees=1.0, seed=0):
    """Photographs whose lamps are said to stand a degree beside their places, each in a direction of its own."""
    random, moved = np.random.default_rng(seed), []
    for each in found:
        away = each.lamp - each.centre
        aside = np.cross(away, random.standard_normal(3))
        aside *= np.linalg.norm(away) / np.linalg.norm(aside)
        angle = np.radians(degrees)
        moved.append(replace(each, lamp=each.centre + np.cos(angle) * away + np.sin(angle) * aside))
    return moved


def _pixel(photograph):
    """The size of a pixel at the ball, metres."""
    height, width = photograph.rays.shape[:2]
    rays = photograph.rays[height // 2, width // 2 - 1:width // 2 + 1]
    return np.linalg.norm(rays[1] - rays[0]) * np.linalg.norm(photograph.centre - photograph.camera)


def difference(theta_o, truth, found):
    """The root mean square difference of cube roots of cosine-weighted values, over that of the truth."""
    known = cube_root(theta_o, truth)
    return float(np.sqrt(np.mean((cube_root(theta_o, found) - known) ** 2) / np.mean(known ** 2)))


def judged(model, taken=None):
    """The numbers of `COLUMNS` for a model, by photographs of it or those that were taken."""
    taken = photographs(model) if taken is None else taken
    samples, at = fitter.samples_from_ball(taken), directions()
    covered = are_covered(samples, at)
    truth = np.broadcast_to(evaluated(model, at), (len(at[0]), 3))

    def made(of):
        return fitter.fit(of, **fitter.PRESETS["Standard"])

    fit = made(samples)
    values = evaluated(fit, at)
    changed = [evaluated(made(fitter.samples_from_ball(moved)), at) for moved in (beside(taken), turned(taken))]
    changes = [difference(at[2][covered], values[covered], each[covered]) for each in changed]
    scene = ball_scene.at_phase(*ball_scene.UNUSED, lamp_radius=0.02)
    pictures = [ball_scene.photograph(each, scene) for each in (model, fit)]
    flip = image_errors.errors(*pictures, pictures[0].sum(axis=2) > 0)["flip"]
    return (difference(at[2][covered], truth[covered], values[covered]), difference(at[2], truth, values),
            flip, *changes)


def cells(numbers):
    """Numbers as a row of the table has them; one beyond its limit has an asterisk."""
    return ["" if number is None else (f"{number:.3f}" if column == "FLIP" else f"{number:.1%}")
            + "*" * (number > limit) for number, limit, column in zip(numbers, LIMITS, COLUMNS, strict=True)]


def main():
    """Print the table of the materials at hand."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.photographs", description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", metavar="NAME", help="only materials whose names contain one of these")
    parser.add_argument("--lamps", type=int, default=len(ball_scene.PHASES), help="default: %(default)s")
    options = parser.parse_args()
    phases = ball_scene.PHASES if options.lamps == len(ball_scene.PHASES) else np.linspace(
        ball_scene.PHASES[0], ball_scene.PHASES[-1], options.lamps)
    rows = []
    for name, make in materials(options.names):
        model = make()
        rows.append((name, *cells(judged(model, photographs(model, phases)))))
        print(*rows[-1], file=sys.stderr, flush=True)
    show_table("photographs", ("material", *COLUMNS), [*rows, ("to reach", *cells(LIMITS))])


if __name__ == "__main__":
    main()
