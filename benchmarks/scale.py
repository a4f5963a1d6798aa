"""Data sets converted, and measured materials in one scene: seconds and memory.

python -m benchmarks.scale [DATA SETS] [MATERIALS] [PRESET] takes 40, 40 and Standard by default. Memory is resident
memory, as Linux tells it.
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
from support.evidence import show_table
from support.synthetic import make_files

MEGABYTE = 1 << 20
PROCESSES = 2


def batch(folder, count, preset):
    """Convert a folder with `measured_brdf convert`, killed half way and run again."""
    data = folder / "data"
    data.mkdir()
    make_files(data, count)
    out = folder / "library.blend"
    command = [sys.executable, ROOT, "convert", data, "-o", out, "--preset", preset, "--processes", str(PROCESSES)]
    start = time.perf_counter()
    watch(command, out.with_suffix(".fits"), until=count // 2)
    worker, writer = watch(command, out.with_suffix(".fits"))
    spent = time.perf_counter() - start
    start = time.perf_counter()
    again = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    assert again.count("up to date") == count
    size = sum(path.stat().st_size for path in folder.glob("library*.blend"))
    show_table("scale-convert", (f"{count} data sets, {preset}, {PROCESSES} processes, killed half way", ""), [
        ("each, s", f"{spent / count:.2f}"), ("all up to date, s", f"{time.perf_counter() - start:.1f}"),
        ("a process that fits, MB", round(worker / MEGABYTE)), ("the one that collects, MB", round(writer / MEGABYTE)),
        ("the library, kB each", round(size / count / 1024))])


def watch(command, fits, until=None):
    """Run a conversion, or kill it when so many fits are done: the most memory of a child and of the process itself."""
    with tempfile.TemporaryFile("w+") as said:
        process = subprocess.Popen(command, stdout=said, stderr=subprocess.STDOUT, start_new_session=True)
        writer = worker = 0
        while process.poll() is None:
            with contextlib.suppress(OSError):
                writer = max(writer, resident(process.pid))
                worker = max(worker, *map(resident, children(process.pid)), 0)
            if until is not None and len(list(fits.glob("*.npz"))) >= until:
                os.killpg(process.pid, signal.SIGKILL)
                process.wait()
                return worker, writer
            time.sleep(0.1)
        said.seek(0)
        assert process.returncode == 0, said.read()
    return worker, writer


def children(process):
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
    show_table("scale-scene", (f"{count} measured materials in one scene, {preset}", ""), [
        ("prepared, s each", f"{statistics.median(seconds):.2f}"), ("at most, s", f"{max(seconds):.2f}"),
        ("before rendering, MB each", f"{(prepared - before) / count / MEGABYTE:.1f}"),
        ("after it, MB each", f"{(resident() - before) / count / MEGABYTE:.1f}"),
        ("the first sample of 100 x 100 pixels, with all compiled, s", f"{rendered:.1f}"),
        ("the .blend, compressed, kB each", round(blend.stat().st_size / count / 1024))])
    extension.unregister()


def main():
    data_sets, materials, preset = [*sys.argv[1:], *("40", "40", "Standard")[len(sys.argv) - 1:]]
    for work, count in ((batch, data_sets), (scene, materials)):
        with tempfile.TemporaryDirectory() as folder:
            work(Path(folder), int(count), preset)


if __name__ == "__main__":
    sys.exit(main())
