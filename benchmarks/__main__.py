"""``make bench``: how long fitting, baking and compiling take, on one core.

Machines are noisy: each figure is the median of several runs, and the limits of the project are printed beside it,
never asserted.
"""

import os
import statistics
import sys
import tempfile
import time
from pathlib import Path

if hasattr(os, "sched_setaffinity"):         # Linux; before NumPy starts its threads
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})

import fitter
from demo_scenes import synthetic
from fitter.bake import bake


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


def main():
    import bpy  # noqa: F401  (brings _cycles)

    data = synthetic.measurements_or_synthetic()[0]
    path = data / "curet" / "abrdf.dat"
    numbers = [number for number, _ in fitter.datasets.list_samples(path)]
    curet = [fitter.load(path, number) for number in numbers]
    krylon = fitter.load(data / "cornell" / "krylon_blue.astm")
    krylon_fit, krylon_dense = fitter.fit(krylon), fitter.fit(krylon, 6, None)

    rows = [
        ("fit one CURET sample, (4,6,95)", lambda: fitter.fit(curet[0]), 15, 0.060),
        (f"fit {len(curet)} CURET samples, (4,6,95)", lambda: [fitter.fit(samples) for samples in curet], 3, 4.0),
        ("fit krylon RGB, (4,6,95)", lambda: fitter.fit(krylon), 7, 0.3),
        ("bake krylon RGB, (4,6,95)", lambda: bake(krylon_fit), 5, None),
        ("bake and compile krylon RGB, (4,6,95)", lambda: compile_source(bake(krylon_fit)), 5, 1.5),
        ("bake and compile krylon RGB, level 6", lambda: compile_source(bake(krylon_dense)), 3, 1.5),
    ]
    print(f"{'median wall time on one core':42} {'measured':>10} {'limit':>8}")
    for name, work, runs, limit in rows:
        print(f"{name:42} {seconds(work, runs):8.3f} s {'' if limit is None else f'{limit:.3g} s':>8}")


if __name__ == "__main__":
    sys.exit(main())
