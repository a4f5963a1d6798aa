"""Everything that the extension offers, as a ball: ``make contact`` writes build/contact/ (docs/rendering.md).

EEVEE needs OpenGL: Mesa's in software will do (on Debian: libegl-mesa0 and libgl1-mesa-dri). ``--published N`` takes N
of the starter library, evenly; ``--only TEXT ...`` materials whose names contain one of the texts; ``--turn VERSION``
what a release renders, MARKED and a third of the rest. The exit code is 1 where one of MARKED is more conspicuous than
its Principled.
"""

import argparse
import functools
import os
import re
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np

import fitter
from fitter.cycles.node_mixture import node_mixtures
from fitter.formats import list_samples
from fitter.imaging.pictures import srgb
from fitter.library import ready
from fitter.model.published import list_offered
from support import ball_files, checkout, kept, stage

from .black_pixels import three_lamps
from .harness.running import each_of
from .ordinary import principled_material, to_median

OUT = checkout.ROOT / "build" / "contact"
SIZE, SAMPLES, IN_EEVEE = 96, 64, 4          # EEVEE has no noise but at the edges of shadows; 16 take twice as long
DARK, BRIGHT = 0.25, 4.0
FILES = "*.dat", "*.astm", "*.brdf", "*.bsdf", "*.mbsdf"
PUBLISHED = "published:"
EDITED = ("published:gold-metallic-paint", "published:red-fabric", "cornell/krylon_blue.astm",
          "curet/abrdf.dat leather", "rgl/irid_flake_paint1_rgb.bsdf")
EDITS = {"coat": {"coat": 1.0, "coat_width": 0.05}, "gain 8": {"highlight": 8.0}, "width .25": {"width": 0.25},
         "width 4": {"width": 4.0}, "red": {"diffuse": (1, 0.1, 0.1), "highlight": (1, 0.1, 0.1)}}
# hard to render: in each release no more conspicuous than the closest Principled, SMOOTH in Exact before denoising, too
SMOOTH = ("published:hematite", "curet/abrdf.dat velvet", "curet/abrdf.dat aluminum foil",
          "cornell/garnet_red_RGB.astm", "cornell/krylon_blue.astm, width .25", "rgl/irid_flake_paint1_rgb.bsdf")
MARKED = (*SMOOTH, "curet/abrdf.dat moss", "cornell/cayman.astm", "goniometer/IMX455.bsdf",
          "goniometer/carpaint_blue.mbsdf", "rgl/chm_mint_rgb.bsdf", "rgl/cc_green_malachite_rgb.bsdf",
          "rgl/ilm_solo_m_68_rgb.bsdf", "rgl/irid_flake_paint1_rgb.bsdf, width .25",
          "rgl/irid_flake_paint1_rgb.bsdf, gain 8", "rgl/irid_flake_paint1_rgb.bsdf, red")
KNOWN = {"goniometer/IMX455.bsdf": ["Nodes", "Nodes, denoised"]}     # 6 bright pixels, its peak: a Principled has none
MOST_BELOW = 40             # pixels of a tile of Exact before denoising
MORE = 5                    # pixels, dark or bright, than in a Principled's tile
WAYS = ("Exact", "Nodes", "EEVEE", "Principled", "Principled in EEVEE")
# of the columns; EEVEE is not denoised
TITLES = [text for way in WAYS for text in ((way,) if way.endswith("EEVEE") else (way, f"{way}, denoised"))]
ROWS = 10                   # of a sheet
_EXPOSURE = 1.2


def materials(published=None):
    """What is offered: by name, a function that returns a fit; of the starter library so many, at even distances in its
    list."""
    found = {}
    names = [each.name for each in list_offered()]
    for name in names[::max(len(names) // published, 1)] if published else names:
        found[PUBLISHED + name] = functools.partial(_fit, ready.ARGUMENTS, fitter.load_published, name)
    data = checkout.measurements()
    standard = fitter.PRESETS["Standard"]
    for path in sorted(path for pattern in FILES for path in data.glob(f"*/{pattern}")):
        name = path.relative_to(data).as_posix()
        for sample, title in list_samples(path) or [(None, "")]:
            found[f"{name} {title}".rstrip()] = functools.partial(_fit, standard, fitter.load, path, sample)
    for name in filter(found.get, EDITED):
        for edit, arguments in EDITS.items():
            found[f"{name}, {edit}"] = functools.partial(_edited, found[name], arguments)
    return found


def in_turn(names, version):
    """MARKED of the names, and a third of the others, which the numbers of a version choose."""
    turn = sum(map(int, re.findall(r"\d+", version)))
    others = [name for name in names if name not in MARKED]
    return {*MARKED} & {*names} | {*others[turn % 3::3]}


def _fit(settings, load, *arguments):
    return fitter.fit(load(*arguments), **settings)


def _edited(fit, arguments):
    return fitter.edited(fit(), **arguments)


@dataclass(frozen=True)
class Tile:
    """A picture of SAMPLES samples, and how many pixels of it are conspicuous."""

    picture: np.ndarray         # (SIZE, SIZE, 3), scene-linear
    dark: int                   # pixels darker than DARK of their surroundings
    bright: int                 # brighter than BRIGHT times them
    below: int                  # below zero


def tile(picture):
    over = to_median(np.maximum(picture, 0).mean(axis=-1))
    return Tile(picture, int((over < DARK).sum()), int((over > BRIGHT).sum()), int((picture < 0).any(axis=-1).sum()))


def tiles(fit, name):
    """Render a fit in all WAYS: by way, (as it is, denoised), of EEVEE (as it is,)."""
    made = scene()
    measured = stage.material_for(fit, node_mixtures(fit))
    stage.add_eevee_output(measured)
    like = principled_material(fit, name)
    found = {}
    for way in WAYS:
        stage.set_input(measured, "Nodes", way == "Nodes")
        bpy.data.objects["Sphere"].data.materials.clear()
        bpy.data.objects["Sphere"].data.materials.append(like if way.startswith("Principled") else measured)
        found[way] = tuple(map(tile, _rendered(made, way.endswith("EEVEE"))))
    return found


def _rendered(made, in_eevee):
    """The picture as it is, and in Cycles denoised, of one render: (SIZE, SIZE, 3) each."""
    import OpenImageIO

    made.render.image_settings.media_type = "IMAGE" if in_eevee else "MULTI_LAYER_IMAGE"
    if in_eevee:
        return stage.render_in_eevee(made, IN_EEVEE)[..., :3],
    with tempfile.TemporaryDirectory() as folder:
        made.render.filepath = str(Path(folder) / "picture.exr")
        bpy.ops.render.render(write_still=True)
        parts = [OpenImageIO.ImageBuf(made.render.filepath, number, 0)
                 for number in range(OpenImageIO.ImageBuf(made.render.filepath).nsubimages)]
        passes = {part.spec().channelnames[0].split(".")[1]: part.get_pixels()[..., :3].astype(float) for part in parts}
    return passes["Noisy Image"], passes["Combined"]


def scene():
    """A unit ball without a material on a grey floor; two area lamps, a small spot and a dim sky."""
    made = stage.black_scene(SIZE, SIZE, SAMPLES, span=1)
    made.render.film_transparent, made.cycles.use_denoising = False, True
    bpy.context.view_layer.cycles.denoising_store_passes = True
    made.cycles.sample_clamp_indirect = 10          # as Cycles has it by default
    made.cycles.max_bounces = made.cycles.diffuse_bounces = made.cycles.glossy_bounces = 4
    stage.background(made, 0.1, (0.7, 0.8, 1.0))
    three_lamps()
    bpy.ops.mesh.primitive_plane_add(size=40, location=(0, 0, -1))
    grey = stage.simple_material("Floor", "ShaderNodeBsdfDiffuse", {"Color": (0.25, 0.25, 0.25, 1)})
    bpy.context.object.data.materials.append(grey)
    stage.add_sphere()
    stage.look((0, -7, 2), (0, 0, -0.1), 95)
    return made


def conspicuous(name, found):
    """Which titles of a MARKED material are more conspicuous than its Principled: a list."""
    said = []
    for way in ("Exact", "Nodes"):
        for title, ours, like in zip((way, f"{way}, denoised"), found[way], found["Principled"], strict=True):
            if title == "Exact" and name not in SMOOTH:
                worse = ours.below > MOST_BELOW
            else:
                worse = ours.below > like.below or max(ours.dark - like.dark, ours.bright - like.bright) > MORE
            said += [title] * worse
    return said


def counts(found):
    """The counts of each way: as they are, then denoised, each dark, bright, below zero: three of each of TITLES."""
    return np.array([[each.dark, each.bright, each.below] for way in WAYS for each in found[way]]).ravel()


def in_columns(numbers):
    return "  ".join("{:4} {:3} {:3}".format(*each) for each in numbers.reshape(-1, 3))


def _draw(rows, path):
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(len(rows), len(TITLES), figsize=(16, 1.5 * len(rows) + 0.2), squeeze=False)
    figure.subplots_adjust(0.12, 0, 1, 1 - 0.2 / (1.5 * len(rows) + 0.2), 0.02, 0.02)
    for line, (name, found) in zip(axes, rows, strict=True):
        shown = [each for way in WAYS for each in found[way]]
        for place, each in zip(line, shown, strict=True):
            place.imshow(srgb(_EXPOSURE * each.picture), interpolation="nearest")
            place.axis("off")
        line[0].text(-6, SIZE / 2, name.replace("/", "/\n").replace(", ", ",\n"), ha="right", va="center", fontsize=8)
    for place, title in zip(axes[0], TITLES, strict=True):
        place.set_title(title, fontsize=8, pad=2)
    figure.savefig(path, dpi=100)
    pyplot.close(figure)


@functools.cache
def _offered(published):
    """Of `materials`, in a process that can render them."""
    checkout.extension().register()
    ball_files.add_openimageio()
    kept.keep("fitter")
    return materials(published)


def _row(published, name):
    fit, start = _offered(published)[name], time.perf_counter()
    return name, tiles(fit(), name), time.perf_counter() - start


def each_with_blender(work, things, jobs):
    """As `each_of`, of work that imports Blender.

    Processes take the path over, and in the folders that Blender adds to it is another `bpy`.
    """
    path = sys.path
    sys.path = [each for each in path if "bpy" not in Path(each).parts]
    try:
        yield from each_of(work, things, jobs)
    finally:
        sys.path = path


def main():
    """Render all, print the table, and write it and the sheets; return 1 where one of MARKED is conspicuous."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--published", type=int)
    parser.add_argument("--only", nargs="*", default=[""])
    parser.add_argument("--turn", metavar="VERSION")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--out", type=Path, default=OUT)
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    chosen = [name for name in materials(options.published) if any(text in name for text in options.only)]
    if options.turn:
        turn = in_turn(chosen, options.turn)
        chosen = [name for name in chosen if name in turn]
    rows, total, failed = [], np.zeros(3 * len(TITLES), int), False
    made = each_with_blender(functools.partial(_row, options.published), chosen, options.jobs)
    with open(options.out / "counts.txt", "w", encoding="utf-8") as table:
        titles = "".join(f"{title.split(', ')[-1][:12]:14}" for title in TITLES)
        _say(table, f"{'dark, bright, below zero':45}{titles}")
        for number, (name, found, seconds) in enumerate(made, start=1):
            rows.append((name, found))
            counted = counts(found)
            total += counted
            _say(table, f"{name:43}{in_columns(counted)}   {seconds:4.0f} s")
            if name in MARKED and (worse := conspicuous(name, found)) != KNOWN.get(name, []):
                failed = True
                _say(table, f"{'':43}more conspicuous than the Principled: {'; '.join(worse) or 'nothing now'}")
            if len(rows) == ROWS or number == len(chosen):
                _draw(rows, options.out / f"{(number - 1) // ROWS + 1:02}.png")
                rows = []
        _say(table, f"{'all':43}{in_columns(total)}")
    return int(failed)


def _say(table, line):
    for stream in (table, sys.stdout):
        print(line, file=stream, flush=True)


if __name__ == "__main__":
    sys.exit(main())
