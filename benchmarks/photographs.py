"""How true materials are that photographs of a ball make: synthetic ones of known reflectances, and real ones.

    python -m benchmarks.photographs [NAME ...]     some minutes; the names of materials choose

docs/manual/measure-your-own.md says what the columns are. Of the real gray ball nobody knows the truth: each of its
twelve photographs is predicted by a fit to ten of the others, and judged by the radiance at the pixels that would be
measured.
"""

import argparse
import os
import sys

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")      # before NumPy starts them

from dataclasses import replace

import numpy as np

import fitter
from fitter.methods.prior import lambertian
from fitter.photographs.ball import measuring
from fitter.photographs.ball.coverage import are_covered
from fitter.photographs.ball.measuring import gather_samples, place_photographs, scale_samples
from fitter.photographs.ball.photograph import measure_pixels
from fitter.photographs.description.parsing import parse
from fitter.quality.cross_validation import cube_root
from fitter.samples import choice, subset
from support import ball_files, ball_scene
from support.checkout import measurements
from support.evidence import show_table

from .dense import image_errors
from .dense.sphere import evaluated
from .harness.judging import directions
from .report.baselines import ggx

NOISE = 0.01
SYNTHETIC = ball_scene.matte, ball_scene.satin, ball_scene.glossy, ball_scene.velvet
# files below the folder of measurements, and samples
REAL = {"felt": ("curet/abrdf.dat", 1), "leather": ("curet/abrdf.dat", 5), "krylon blue": (
    "cornell/krylon_blue_RGB.astm", None), "garnet red": ("cornell/garnet_red_RGB.astm", None),
    "silk blue": ("rgl/vch_silk_blue_rgb.bsdf", None)}
COLUMNS = "covered", "all", "FLIP", "1 pixel", "1 degree"
LIMITS = 0.05, 0.10, 0.03, 0.03, 0.03
GRAY_BALL = "gray ball"
LEFT_OUT = (0, 1), (2, 7), (3, 8), (4, 9), (5, 10), (6, 11)     # lamps that stand apart
PREDICTED = 0.05            # error of the gray ball's photographs that were left out: at most
_ALBEDO = 0.5               # a guess, which scales all photographs alike
_PIXELS, _OF_LOBES = 6000, 4000     # of a photograph that are predicted, and to which a lobe is fitted


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


def photographs(model, phases=ball_scene.PHASES, **settings):
    return [fitter.BallPhotograph(ball_scene.photograph(model, scene, noise=NOISE, seed=number), scene.rays(),
                                  scene.camera, scene.centre, scene.radius, scene.lamp, scene.intensity,
                                  scene.lamp_radius, name=f"photograph {number}")
            for number, scene in enumerate(ball_scene.scenes(phases, **settings), start=1)]


def shift_balls(found):
    """Photographs whose ball is said to be a pixel to the right and above its place."""
    return [replace(each, centre=each.centre + _pixel(each) * np.array([1, 0, 1]) / np.sqrt(2)) for each in found]


def turn_lamps(found):
    """Photographs whose lamps are said to stand a degree beside their places, each in a direction of its own."""
    random, moved, angle = np.random.default_rng(0), [], np.radians(1.0)
    for each in found:
        away = each.lamp - each.centre
        aside = np.cross(away, random.standard_normal(3))
        aside *= np.linalg.norm(away) / np.linalg.norm(aside)
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


def judged(model):
    """The numbers of `COLUMNS` for a model, by photographs of it."""
    taken, at = photographs(model), directions()
    samples = fitter.samples_from_ball(taken)
    covered = are_covered(samples, at)
    truth = np.broadcast_to(evaluated(model, at), (len(at[0]), 3))

    def made(of):
        return fitter.fit(of, **fitter.PRESETS["Standard"])

    fit = made(samples)
    values = evaluated(fit, at)
    changed = [evaluated(made(fitter.samples_from_ball(moved)), at) for moved in (
        shift_balls(taken), turn_lamps(taken))]
    changes = [difference(at[2][covered], values[covered], each[covered]) for each in changed]
    scene = ball_scene.at_phase(*ball_scene.UNUSED, lamp_radius=0.02)
    pictures = [ball_scene.photograph(each, scene) for each in (model, fit)]
    flip = image_errors.errors(*pictures, pictures[0].sum(axis=2) > 0)["flip"]
    return (difference(at[2][covered], truth[covered], values[covered]), difference(at[2], truth, values),
            flip, *changes)


def gray_ball(folder):
    """The real photographs, with the ball and the lamps at their places: `fitter.BallPhotograph`s."""
    shots = [{"files": [str(folder / f"gray.{number}.png")], "chrome": str(folder / f"chrome.{number}.png")}
             for number in range(12)]
    described = {"camera": {"position": "far", "encoding": "linear"}, "scale": {"albedo": _ALBEDO},
                 "ball": {"centre": "outline", "mask": str(folder / "gray.mask.png")},
                 "chrome": {"mask": str(folder / "chrome.mask.png")}, "photograph": shots}
    return place_photographs(measuring.read_photographs(parse(described, folder / "none.toml"))[0], GRAY_BALL)


def predicted(taken):
    """The error of each photograph that a fit to others predicts: {method: errors}."""
    ways = {"Standard": lambda samples: fitter.fit(samples, **fitter.PRESETS["Standard"]),
            "one GGX lobe": lambda samples: ggx.fit(subset(samples, choice(len(samples), _OF_LOBES))),
            "Lambert": lambda samples: lambertian(samples.values)}
    found = {name: [] for name in ways}
    for left_out in LEFT_OUT:
        measured_scale = gather_samples(
            [each for number, each in enumerate(taken) if number not in left_out], GRAY_BALL, "")
        samples, *_ = scale_samples(measured_scale, _ALBEDO)
        times = measured_scale.values.sum() / samples.values.sum()
        for name, way in ways.items():
            model = way(samples)
            found[name] += [_unseen(model, times, taken[number]) for number in left_out]
            print(left_out, name, *np.round(found[name][-2:], 4), file=sys.stderr, flush=True)
    return found


def _unseen(model, times, photograph):
    """The error of the radiance of a photograph by a model in units that are so many times smaller."""
    truth = measure_pixels(photograph)
    some = choice(len(truth.reflectance), _PIXELS)
    light = truth.seen.irradiance[some, None]
    seen = truth.reflectance[some] * light
    wrong = times * evaluated(model, [each[some] for each in truth.seen.directions]) * light - seen
    return float(np.sqrt(np.mean(wrong ** 2) / np.mean(seen ** 2)))


def cells(numbers):
    """Numbers as a row of the table has them; one beyond its limit has an asterisk."""
    return [(f"{number:.3f}" if column == "FLIP" else f"{number:.1%}") + "*" * (number > limit)
            for number, limit, column in zip(numbers, LIMITS, COLUMNS, strict=True)]


def main():
    parser = argparse.ArgumentParser(prog="python -m benchmarks.photographs", description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", metavar="NAME", help="only materials whose names contain one of these")
    options = parser.parse_args()
    rows = []
    for name, make in materials(options.names):
        rows.append((name, *cells(judged(make()))))
        print(*rows[-1], file=sys.stderr, flush=True)
    if rows:
        show_table("photographs", ("material", *COLUMNS), [*rows, ("to reach", *cells(LIMITS))])
    folder = measurements() / "photographs" / "gray_ball"
    if not folder.is_dir():
        print(f"left out: {GRAY_BALL}, {folder} is not there")
    elif not options.names or any(part in GRAY_BALL for part in options.names):
        ball_files.add_openimageio()
        found = [(name, *(f"{each:.3f}" for each in (np.mean(of), min(of), max(of))))
                 for name, of in predicted(gray_ball(folder)).items()]
        found.append(("to reach", f"{PREDICTED:.3f}", "", ""))
        show_table("gray-ball", ("fitted by", "mean", "least", "largest"), found)


if __name__ == "__main__":
    main()
