"""``make bench``: how long fitting, baking and compiling take, on one core; then the tables of `rendering`.

Machines are noisy: each figure is the median of several runs, printed beside the project's limit and never asserted.
``python -m benchmarks rendering [--materials ...] [--shapes ...] [--lights ...]`` prints that table or a part of it
alone, and ``--pictures FOLDER`` renders its pictures instead. ``python -m benchmarks denoising`` prints the error of 64
samples before and after OpenImageDenoise, and ``python -m benchmarks ordinary [--scenes ...]`` the table of `ordinary`.
"""

import argparse
import os
import statistics
import sys
import tempfile
import time
from pathlib import Path

if hasattr(os, "sched_setaffinity"):         # Linux; before NumPy starts its threads
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})

import fitter
from fitter.cycles.bake import bake
from support import synthetic


def seconds(work, runs):
    """Median wall time of `work()`, after one run that is not counted."""
    work()
    times = []
    for _ in range(runs):
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return statistics.median(times)


def compile_source(source):
    """Compile OSL source as a script node does."""
    import _cycles

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "shader.osl"
        path.write_text(source)
        assert _cycles.osl_compile(str(path), str(path.with_suffix(".oso")))


def fitting():
    import bpy  # noqa: F401  (brings _cycles)

    data = synthetic.measurements_or_synthetic()[0]
    path = data / "curet" / "abrdf.dat"
    numbers = [number for number, _ in fitter.formats.list_samples(path)]
    curet = [fitter.load(path, number) for number in numbers]
    krylon = fitter.load(data / "cornell" / "krylon_blue.astm")
    standard = fitter.PRESETS["Standard"]
    krylon_fit, krylon_dense, krylon_standard = (fitter.fit(krylon), fitter.fit(krylon, 6, None),
                                                 fitter.fit(krylon, **standard))

    rows = [
        ("fit one CURET sample, (4,6,95)", lambda: fitter.fit(curet[0]), 15, 0.060),
        (f"fit {len(curet)} CURET samples, (4,6,95)", lambda: [fitter.fit(samples) for samples in curet], 3, 4.0),
        ("fit krylon RGB, (4,6,95)", lambda: fitter.fit(krylon), 7, 0.3),
        ("bake krylon RGB, (4,6,95)", lambda: bake(krylon_fit), 5, None),
        ("bake and compile krylon RGB, (4,6,95)", lambda: compile_source(bake(krylon_fit)), 5, 1.5),
        ("bake and compile krylon RGB, level 6", lambda: compile_source(bake(krylon_dense)), 3, 1.5),
        ("fit one CURET sample, Standard", lambda: fitter.fit(curet[0], **standard), 5, None),
        ("fit krylon RGB, Standard", lambda: fitter.fit(krylon, **standard), 3, None),
        ("bake and compile krylon RGB, Standard", lambda: compile_source(bake(krylon_standard)), 5, 1.0),
    ]
    print(f"{'median wall time on one core':42} {'measured':>10} {'limit':>8}")
    for name, work, runs, limit in rows:
        print(f"{name:42} {seconds(work, runs):8.3f} s {'' if limit is None else f'{limit:.3g} s':>8}")


def main():
    parser = argparse.ArgumentParser(prog="benchmarks", description=__doc__.split("\n")[0])
    parser.add_argument("part", nargs="?", choices=("fitting", "rendering", "ordinary", "denoising"),
                        help="all, unless one is named")
    for name in ("materials", "shapes", "lights"):
        parser.add_argument(f"--{name}", nargs="+", default=(), help="rows of the rendering table; all by default")
    parser.add_argument("--scenes", nargs="+", default=(), help="of the table of ordinary scenes; all by default")
    parser.add_argument("--pictures", metavar="FOLDER",
                        help="render the pictures of docs/rendering.md into it instead; with `ordinary`, as well")
    arguments = parser.parse_args()
    if arguments.part in (None, "fitting"):
        fitting()
    from . import ordinary, rendering

    if arguments.part in (None, "ordinary"):
        ordinary.main(arguments.scenes, pictures=arguments.pictures if arguments.part else None)
    if arguments.pictures and arguments.part != "ordinary":
        rendering.pictures(Path(arguments.pictures))
    elif arguments.part in (None, "rendering"):
        rendering.main(arguments.materials, arguments.shapes, arguments.lights)
    if arguments.part in (None, "denoising"):
        rendering.denoising()


if __name__ == "__main__":
    sys.exit(main())
