"""``make bench-scale``: a thousand data sets converted, and a hundred measured materials in one scene.

python -m benchmarks.scale [DATA SETS] [MATERIALS] [PRESET] runs with other numbers. Memory is the resident memory of
the process that did the work, as Linux tells it.
"""

import contextlib
import io
import os
import statistics
import sys
import tempfile
import time
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np

import fitter
from fitter import cli
from fitter.datasets import curet
from tools import checkout
from tools.hard_cases import gloss

MEGABYTE = 1 << 20
PROCESSES = 2


def make_files(folder, count):
    """As many CURET files of one sample each, all different: a list of paths."""
    theta_v, phi_v, theta_i, phi_i = curet.geometry().T
    smooth = gloss(theta_i, theta_v, phi_v - phi_i)
    paths = []
    for number in range(count):
        noise = np.random.default_rng(number).normal(1, 0.05, len(smooth))
        row = " ".join([str(number % 61 + 1), *(f"{value:.3f}" for value in smooth * noise * (1 + number / count))])
        paths.append(folder / f"material{number:04d}.dat")
        paths[-1].write_text(row)
    return paths


def convert(path, preset):
    """Fit and bake one file, as the command line does: which process did it, and its memory in bytes."""
    fit, shader = path.with_suffix(".npz"), path.with_suffix(".osl")
    with contextlib.redirect_stdout(io.StringIO()):
        assert cli.main(["fit", str(path), "--preset", preset, "-o", str(fit)]) == 0
        assert cli.main(["bake", str(fit), "-o", str(shader)]) == 0
    shader.unlink()
    return os.getpid(), resident()


def resident():
    """Resident memory of this process in bytes."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def batch(folder, count, preset):
    """Convert in several processes, and print time and memory on the way."""
    os.environ |= {"OPENBLAS_NUM_THREADS": "1"}
    paths = make_files(folder, count)
    start = time.perf_counter()
    memory, peak = {}, 0
    print(f"{count} data sets, {preset}, {PROCESSES} processes")
    with ProcessPoolExecutor(PROCESSES) as pool:
        for done, (process, used) in enumerate(pool.map(convert, paths, [preset] * count), 1):
            memory[process] = used
            peak = max(peak, used)
            if done * 10 % count < 10 and done * 10 // count in (1, 2, 5, 10):
                print(f"  {done:5} done in {time.perf_counter() - start:6.1f} s, a process takes "
                      f"{max(memory.values()) / MEGABYTE:.0f} MB", flush=True)
    fits = list(folder.glob("*.npz"))
    assert len(fits) == count
    assert all(fitter.Fit.load(fit).coefficient_count for fit in fits[:10])
    print(f"  {(time.perf_counter() - start) / count:.3f} s each; no process took more than {peak / MEGABYTE:.0f} MB; "
          f"a fit is a file of {statistics.median(fit.stat().st_size for fit in fits) / 1024:.0f} kB")


def scene(folder, count, preset):
    """Put measured materials into one scene, render it, and print time and memory."""
    extension = checkout.extension()
    extension.register()
    import bpy

    from demo_scenes.stage import add_lamp, black_scene, render

    stage = black_scene(100, 100, samples=1, span=10)
    add_lamp("SUN", 3.0)
    before, seconds = resident(), []
    known = bpy.ops.measured_brdf.import_data.get_rna_type().properties.keys()
    options = {name: -1 if value is None else value
               for name, value in (fitter.PRESETS[preset] | {"preset": preset}).items() if name in known}
    for number, path in enumerate(make_files(folder, count)):
        bpy.ops.mesh.primitive_plane_add(size=0.9, location=(number % 10 - 4.5, number // 10 - 4.5, 0))
        start = time.perf_counter()
        with contextlib.redirect_stdout(io.StringIO()):
            bpy.ops.measured_brdf.import_data(filepath=str(path), **options)
        seconds.append(time.perf_counter() - start)
    prepared = resident()
    start = time.perf_counter()
    picture = render(stage)
    rendered = time.perf_counter() - start
    blend = folder / "scene.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(blend), compress=True)
    assert np.count_nonzero(picture[..., :3].max(axis=2) > 0.01) > 0.007 * count * picture[..., 0].size
    print(f"{count} measured materials in one scene, {preset}\n"
          f"  preparation {statistics.median(seconds):.2f} s each, {max(seconds):.2f} s at most; the last ten "
          f"{statistics.median(seconds[-10:]):.2f} s\n"
          f"  {(prepared - before) / count / MEGABYTE:.1f} MB of memory each before rendering; one sample of "
          f"100 x 100 pixels in {rendered:.1f} s with all of them compiled\n"
          f"  {(resident() - before) / count / MEGABYTE:.1f} MB each after it; the .blend has "
          f"{blend.stat().st_size / count / MEGABYTE:.2f} MB each, compressed")
    extension.unregister()


def main():
    """Print both tables."""
    data_sets, materials, preset = [*sys.argv[1:], *("1000", "100", "Standard")[len(sys.argv) - 1:]]
    for work, count in ((batch, data_sets), (scene, materials)):
        with tempfile.TemporaryDirectory() as folder:
            work(Path(folder), int(count), preset)


if __name__ == "__main__":
    sys.exit(main())
