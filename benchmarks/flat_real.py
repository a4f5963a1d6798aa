"""Real photographs of flat samples: half of them, or 10, are made into maps, and the others predicted.

The error of a photograph is the root mean square of the texels' over that of the photograph; the mean and the median
over the photographs left out are shown. Texels count that are known in it and in three of those that are used. The lion
and the leaf are in `../shared/data/photographs`; the coin is in the repository larkvi/SimpleRTIDome, in the folder
`examples/v1/cointest`, and given by its path. Where samples are absent a line says so, and the table is without them.
"""

import tempfile
from pathlib import Path

import numpy as np

import fitter
from fitter.photographs.description.parsing import read
from fitter.photographs.flat.maps import sample_frame, texel_points
from fitter.photographs.flat.photograph import observe
from fitter.photographs.flat.reading import read_sample
from support import ball_files
from support.checkout import measurements
from support.evidence import show_table

from .flat_methods import hsh, lambertian, mean_picture, ptm

FEWEST = 3                  # photographs that a normal needs
LEAF = 45, [(225 - 30 * k) % 360 for k in range(12)]       # degrees: nominally
# of the coin, in pixels: left, top, right, bottom
COIN = {"coin, bust": (1170, 540, 1580, 1080), "coin, square": (890, 515, 1720, 1345),
        "coin, whole": (680, 300, 1930, 1560)}
METHODS = {"mean picture, scaled to each": mean_picture, "Lambertian": lambertian, "PTM, 6 terms": ptm,
           "HSH, 9 terms": hsh(3), "HSH, 16 terms": hsh(4)}
METHODS_SHOWN = "ours", *METHODS
LEAST = {"HSH, 9 terms": 9, "HSH, 16 terms": 16}        # photographs


def description(box, texels, lamps):
    """A description of pictures of which a box shows the sample; `lamps` is text."""
    left, top, right, bottom = box
    return (f"texels = {texels}\n[camera]\nposition = 'far'\n[sample]\nwidth = {(right - left) / 1e4}\n"
            f"height = {(bottom - top) / 1e4}\n"
            f"corners = {[[left, bottom], [right, bottom], [right, top], [left, top]]}\n[scale]\nalbedo = 0.3\n{lamps}")


def directions(files, toward):
    return "".join(f"[[photograph]]\nfiles = ['{file}']\ndirection = {[float(x) for x in each]}\n"
                   for file, each in zip(files, toward, strict=True))


def leaf(folder):
    """The twelve lamps of the leaf: files and directions."""
    height, azimuth = np.radians(LEAF[0]), np.radians(LEAF[1])
    toward = np.column_stack([np.cos(height) * np.cos(azimuth), np.cos(height) * np.sin(azimuth),
                              np.full(12, np.sin(height))])
    return [folder / f"{k}_TL.png" for k in range(1, 13)], toward


def sets(coin):
    """Descriptions by name, as text, of what is there; None with the reason in the place of the others."""
    data = measurements() / "photographs"
    if (data / "lion" / "dirs.lp").is_file():
        yield "lion", description((0, 0, 64, 43), 64, f"[lamp]\npositions = '{data / 'lion' / 'dirs.lp'}'\n")
    else:
        print(f"lion: {data / 'lion'} is absent")
    if (data / "leaf").is_dir():
        yield "leaf", description((20, 10, 480, 320), 60, directions(*leaf(data / "leaf")))
    else:
        print(f"leaf: {data / 'leaf'} is absent")
    if not (coin / "output" / "info.json").is_file():
        print(f"coin: {coin} is absent (--coin FOLDER)")
        return
    for name, box in COIN.items():
        yield name, description(box, 50, f"[lamp]\npositions = '{(coin / 'output' / 'info.json').absolute()}'\n")


def errors(expected, values, good):
    """How far each photograph is from what is expected: (p,), of those that show anything."""
    off, size = (np.sqrt((each ** 2 * good[..., None]).sum(axis=(1, 2))) for each in (expected - values, values))
    there = good.sum(axis=1) > 10
    return off[there] / size[there]


def row(name, sample, how):
    """The row of the table for a sample of which half is used, or so many photographs, evenly."""
    frame = sample_frame(sample.corners, sample.photographs)
    seen = observe(sample.photographs, texel_points(sample.corners, sample.shape), frame[2])
    count = len(sample.photographs)
    used = np.arange(0, count, 2) if how == "half" else np.round(np.linspace(0, count - 1, how)).astype(int)
    other = np.setdiff1d(np.arange(count), used)
    light = seen.lit.light.mean(axis=0) @ frame.T
    values, good = np.moveaxis(seen.radiance / seen.lit.brought, 1, 0), seen.good.T
    good = good & (good[used].sum(axis=0) >= FEWEST)
    parts = [(light[which], values[which], good[which]) for which in (used, other)]
    found = {each: errors(method(*parts), *parts[1][1:]) for each, method in METHODS.items()
             if len(used) >= LEAST.get(each, 0)}
    maps = fitter.maps_from_flat([sample.photographs[k] for k in used], sample.corners, sample.shape)
    shown = [maps.radiance(each.camera, each.lamp, each.intensity).reshape(len(seen.good), -1)
             for each in (sample.photographs[k] for k in other)]
    ours = np.array(shown) / np.moveaxis(seen.lit.brought, 1, 0)[other]
    for note in maps.notes:
        print(f"{name}: {note}")
    table = {"ours": errors(ours, *parts[1][1:]), **found}
    cells = {each: f"{np.mean(off):.3f} / {np.median(off):.3f}" for each, off in table.items()}
    return name, f"{len(used)} of {len(good)}", *(cells.get(each, "") for each in METHODS_SHOWN)


def main(coin):
    ball_files.add_openimageio()
    found = []
    with tempfile.TemporaryDirectory() as folder:
        for name, text in sets(coin):
            path = Path(folder, "setup.toml")
            path.write_text(text, "utf-8")
            try:
                sample = read_sample(read(path))
            except fitter.DatasetError as error:        # the others are shown all the same
                print(f"{name}: {error}")
                continue
            for how in ("half", 10):
                found.append(row(name, sample, how))
    show_table("flat-real", ("sample", "photographs", *METHODS_SHOWN), found)
