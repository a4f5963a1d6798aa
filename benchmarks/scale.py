"""``make bench-scale``: a thousand data sets converted, and a hundred measured materials in one scene.

python -m benchmarks.scale [DATA SETS] [MATERIALS] [PRESET] runs with other numbers. Memory is resident memory, as Linux
tells it.
"""

import contextlib
import io
import os
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

import fitter
from support import checkout
from support.checkout import ROOT
from support.synthetic import make_files

MEGABYTE = 1 << 20
PROCESSES = 2


def batch(folder, count, preset):
    """Convert a folder with `measured_brdf convert`, killed half way and run again; print time and memory."""
    data = folder / "data"
    data.mkdir()
    make_files(data, count)
    out = folder / "library.blend"
    command = [sys.executable, ROOT, "convert", data, "-o", out, "--preset", preset, "--processes", str(PROCESSES)]
    print(f"{count} data sets, {preset}, {PROCESSES} processes")
    start = time.perf_counter()
    watch(command, out.with_suffix(".fits"), count, until=count // 2)
    print(f"  killed with {len(list(out.with_suffix('.fits').glob('*.npz')))} fits done; run again:")
    watch(command, out.with_suffix(".fits"), count)
    spent = time.perf_counter() - start
    start = time.perf_counter()
    again = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    assert again.count("up to date") == count
    files = [path.stat().st_size for path in folder.glob("library*.blend")]
    print(f"  {spent / count:.2f} s each; the library has {len(files)} files, {sum(files) / count / 1024:.0f} kB each; "
          f"run again with all up to date: {time.perf_counter() - start:.0f} s")


def watch(command, fits, count, until=None):
    """Run a conversion, and print how far it is, and the memory of its processes, at each quarter; kill it when so many
    fits are done."""
    start = time.perf_counter()
    with tempfile.TemporaryFile("w+") as said:
        process = subprocess.Popen(command, stdout=said, stderr=subprocess.STDOUT, start_new_session=True)
        told, writer, worker = len(list(fits.glob("*.npz"))) * 4 // count, 0, 0
        while process.poll() is None:
            with contextlib.suppress(OSError):
                writer = resident(process.pid)
                worker = max(map(resident, children(process.pid)), default=worker)
            done = len(list(fits.glob("*.npz")))
            if done * 4 // count > told:
                told = done * 4 // count
                print(f"  {done:5} done in {time.perf_counter() - start:6.1f} s; a worker takes "
                      f"{worker / MEGABYTE:.0f} MB, the process that collects {writer / MEGABYTE:.0f} MB", flush=True)
            if until is not None and done >= until:
                os.killpg(process.pid, signal.SIGKILL)
                process.wait()
                return
            time.sleep(0.1)
        said.seek(0)
        assert process.returncode == 0, said.read()
    print(f"  written after {time.perf_counter() - start:.1f} s")


def children(process):
    """The numbers of a process's children."""
    return map(int, Path(f"/proc/{process}/task/{process}/children").read_text().split())


def resident(process="self"):
    """Resident memory of a process in bytes."""
    return int(Path(f"/proc/{process}/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def scene(folder, count, preset):
    """Put measured materials into one scene, render it, and print time and memory."""
    extension = checkout.extension()
    extension.register()
    import bpy

    from support.stage import add_lamp, black_scene, render

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
