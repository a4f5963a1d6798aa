"""``make bench``: how long fitting, baking and compiling take, on one core; then the tables of `ordinary` and `starts`.

Machines are noisy: each figure is the median of several runs, and never asserted.
"""

import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

os.environ["OPENBLAS_NUM_THREADS"] = "1"    # before NumPy starts them

import fitter
from fitter.cycles.bake import bake
from support import synthetic
from support.evidence import show_table


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
    import _cycles

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "shader.osl"
        path.write_text(source)
        assert _cycles.osl_compile(str(path), str(path.with_suffix(".oso")))


def fitting():
    import bpy  # noqa: F401  (brings _cycles)

    data = synthetic.measurements_or_synthetic()[0]
    path = data / "curet" / "abrdf.dat"
    curet = fitter.load(path, 1)
    krylon = fitter.load(data / "cornell" / "krylon_blue.astm")
    standard = fitter.PRESETS["Standard"]
    krylon_fit, krylon_standard = fitter.fit(krylon), fitter.fit(krylon, **standard)

    rows = [
        ("fit one CURET sample, (4,6,95)", lambda: fitter.fit(curet), 15),
        ("fit krylon RGB, (4,6,95)", lambda: fitter.fit(krylon), 7),
        ("bake krylon RGB, (4,6,95)", lambda: bake(krylon_fit), 5),
        ("bake and compile krylon RGB, (4,6,95)", lambda: compile_source(bake(krylon_fit)), 5),
        ("fit one CURET sample, Standard", lambda: fitter.fit(curet, **standard), 5),
        ("fit krylon RGB, Standard", lambda: fitter.fit(krylon, **standard), 3),
        ("bake and compile krylon RGB, Standard", lambda: compile_source(bake(krylon_standard)), 5)]
    show_table("fitting", ("on one core", "median, s"), [
        (name, f"{seconds(work, runs):.3f}") for name, work, runs in rows])


def main():
    fitting()
    for module in ("ordinary", "starts"):
        subprocess.run([sys.executable, "-m", f"benchmarks.{module}"], check=True)


if __name__ == "__main__":
    sys.exit(main())
