"""Files made to hang, to exhaust memory or to confuse, on every path that a user may send them.

Each path runs in a process of its own, so that processor time and peak memory are the operating system's figures; those
of the same path with a file of one row, or with a fit that is in order, are subtracted.
"""

import json
import os
import struct
import threading
import time
import zlib
from pathlib import Path

import numpy as np

from fitter.storage import npz
from support import hostile_fits, mbsdf_files, tensor_files
from support.checkout import run_python

MEGABYTE = 1 << 20
LARGE = 16 * MEGABYTE       # as much as is read
_VARS = b"VARS theta_i,phi_i,theta_s,phi_s,R,G,B\n"
_ROW = b"1,1,1,1,1,1,1\n"


def _filled(pattern, head=b"", tail=b"", size=LARGE):
    """Bytes of a given size made of one pattern."""
    return head + pattern * ((size - len(head) - len(tail)) // len(pattern)) + tail


def _pbrt(pattern, tail=b""):
    """A .brdf file of whole rows of 7 numbers, each number one pattern."""
    head = b"3\n400 550 700\n"
    return _filled(pattern * 7, head, tail)


def _merl(number):
    return struct.pack("<3i", 90, 90, 180) + struct.pack("<d", number) * (3 * 90 * 90 * 180)


def _rgl(**change):
    return tensor_files.pack(tensor_files.material() | change)


def _rgl_of(elements):
    """An RGL file whose table claims so many numbers for its first array."""
    content = _rgl()
    return content[:38] + struct.pack("<Q", elements) + content[46:]


def _zemax(azimuths, radials, value=b"1 "):
    """A Zemax file with so many angles, and a value for each pair."""
    head = b"".join(b"%b 1\n0\n" % name for name in (b"SampleRotation", b"AngleOfIncidence"))
    head += b"".join(b"%b %d\n%b\n" % (name, count, b"1 " * count) for name, count in
                     ((b"ScatterAzimuth", azimuths), (b"ScatterRadial", radials)))
    return (b"Symmetry PlaneSymmetrical\nSpectralContent Monochrome\nScatterType BRDF\n" + head + b"DataBegin\nTIS 1\n"
            + (value * radials + b"\n") * azimuths + b"DataEnd\n")


def _saved(count):
    header = {"format": "measured-brdf-samples", "version": 1, "name": "", "source": "", "notes": [],
              "channels": list("RGB"), "isotropic": True}
    return npz.to_bytes({"samples": np.array(json.dumps(header)), "directions": np.full((4, count), 0.5, np.float32),
                         "values": np.full((count, 3), 0.2, np.float32)})


def _inflating_mat():
    """A MATLAB file whose 4 MB inflate to 4 GB."""
    deflater = zlib.compressobj(9)
    zeros = bytes(16 * MEGABYTE)
    packed = b"".join(deflater.compress(zeros) for _ in range(256)) + deflater.flush()
    return b"MATLAB 5.0 MAT-file".ljust(124) + b"\0\1IM" + (15).to_bytes(4, "little") + len(packed).to_bytes(
        4, "little") + packed


CONTENTS = {
    "200 MB of digits": lambda: _filled(b"1", size=200 * MEGABYTE),
    "digits, as large as is read": lambda: _filled(b"1"),
    "digits on lines": lambda: _filled(b"1\n"),
    "CURET: one endless line": lambda: _filled(b"12 ", b"1 "),
    "CURET: sample 1 again and again": lambda: _filled(b"1 " * 206 + b"\n"),
    "ASTM: rows of single digits": lambda: _filled(_ROW, _VARS),
    "ASTM: the last angle too large": lambda: _filled(_ROW, _VARS, b"9,1,1,1,1,1,1"),
    "ASTM: the last number not one": lambda: _filled(_ROW, _VARS, b"1,1,1,1,1,1,x"),
    "ASTM: a row without end": lambda: _filled(b"11,", _VARS),
    "ASTM: millions of variables": lambda: _filled(b",R1", _VARS.strip()),
    "ASTM: millions of keywords": lambda: _filled(b"NUM_POINTS 1\nA\n", b"", _VARS + _ROW),
    "ASTM: nothing but line ends": lambda: _filled(b"\r\n\r", _VARS),
    "ASTM: blanks": lambda: _filled(b" ", _VARS),
    "pbrt: single digits": lambda: _pbrt(b"1 "),
    "pbrt: two digits a line": lambda: _pbrt(b"1\n"),
    "pbrt: a comment after each": lambda: _pbrt(b"1#\n"),
    "pbrt: one comment, the last angle too large": lambda: _pbrt(b"1 ", b"# \n9 1 1 1 1 1 1"),
    "pbrt: a comment after each, the last not a number": lambda: _pbrt(b"1#\n", b"1 1 1 1 1 1 x"),
    "pbrt: nothing but comments": lambda: _filled(b"#\n", b"", b"3\n"),
    "MATLAB: 4 MB that inflate to 4 GB": _inflating_mat,
    "MERL: every cell above the horizon": lambda: _merl(1.0),
    "MERL: nothing measured": lambda: _merl(-1.0),
    "MERL: numbers too large": lambda: _merl(1e300),
    "RGL: an array of 10^12 numbers": lambda: _rgl_of(10**12),
    "RGL: an array of 2^64 numbers": lambda: _rgl_of(2**64 - 1),
    "RGL: 16 MB of microfacets": lambda: _rgl(ndf=np.ones((2, 2 << 20), "f4")),
    "RGL: half a million azimuths": lambda: _rgl(phi_i=np.linspace(-3.1, 3.1, 500_000, dtype="f4")),
    "RGL: an azimuth of 1e30": lambda: tensor_files.pack(tensor_files.anisotropic(tensor_files.material())
                                                         | {"phi_i": np.array([-1e30, 0, 1e30], "f4")}),
    "RGL: 5,000 azimuths of two angles": lambda: tensor_files.pack(tensor_files.anisotropic(
        tensor_files.material(angles=(0.1, 1.3)), np.linspace(-180, 180, 5000))),
    "UTIA: numbers as large as doubles get": lambda: struct.pack("<d", 1.7e308) * (3 * 288 * 288),
    "UTIA: a BRDF of 0.3": lambda: struct.pack("<d", 0.3) * (3 * 288 * 288),
    "Zemax: half a million rotations": lambda: _zemax(1, 1).replace(
        b"SampleRotation 1\n0\n", b"SampleRotation 500000\n%b\n" % (b"1 " * 500_000)),
    "Zemax: a million values": lambda: _zemax(1000, 1000),
    "Zemax: half a million azimuths": lambda: _zemax(500_000, 1),
    "Zemax: a million radial angles, the last value not a number": lambda: _zemax(1, 1_000_000, b"1 ")[:-12] + b"x\n"
                                                                          b"DataEnd\n",
    "Zemax: lines TIS": lambda: _filled(b"TIS 1\n", _zemax(1, 1)[:-12], b"DataEnd\n", 4 * MEGABYTE),
    "MBSDF: a million values": lambda: mbsdf_files.made((100, 100, 100, 1), values=np.ones(1_000_000)),
    "saved samples: all that a small file may hold": lambda: _saved(580_000),
    "saved samples: 4 million of one value": lambda: _saved(4_000_000),
    "table: rows": lambda: _filled(_ROW, b"#angles:rad\n" + _VARS[5:], size=LARGE // 2),
    "table: rotations of a symmetry": lambda: (
        b"#symmetry: 180 and mirror\n#angles: degrees\ntheta_i,phi_i,theta_o,phi_o,BRDF\n"
        + b"".join(b"%d,%d,%d,%d,%d\n" % (20 + turn % 4, turn % 360, theta, turn % 360 + 180, 1 + turn % 90)
                   for turn in range(6000) for theta in range(70))),
    "table: empty cells": lambda: _filled(b",,,,,,\n", b"#angles:rad\n" + _VARS[5:], size=LARGE // 2),
    "table: empty lines, the last row not a number": lambda: _filled(b"\n", _VARS[5:], b"1,1,1,1,1,1,x\n", LARGE // 2),
    "table: a comment with each row": lambda: _filled(b"#\n", _VARS[5:], size=LARGE // 2),
    "table: a million names": lambda: _filled(b"R,", b"theta_i,", b"\n1\n", LARGE // 2),
    "UTF-16": lambda: _filled(_ROW, _VARS, size=MEGABYTE).decode().encode("utf-16"),
    "noise": lambda: os.urandom(LARGE),
}
SPECIAL = ("a folder", "a pipe that nobody writes to", "a device without end", "a link to itself",
           "a file that grows while it is read", "a name of 5,000 letters")


PATHS = ("info", "panel", "fit", "bake")


def report(folder):
    """Print a table of measurements and one of saved fits: time, memory, and what came of each."""
    base = _run(_made(folder, b"3\n400 550 700 1 1 1 1 1 1 1"), PATHS[:3], folder)
    print("each cell: s, memory / file\n    MB" + "".join(f"  {name:>12}" for name in PATHS) + "  file")
    for name, content in CONTENTS.items():
        path = _made(folder, content())
        _print_row(name, path, _run(path, PATHS[:3], folder), base, "x", 1 / path.stat().st_size)
    for name in SPECIAL:
        path, stop = _special(name, folder)
        _print_row(name, path, _run(path, PATHS[:3], folder), base, "", 0)
        stop.set()
    base = _run(_made(folder, hostile_fits.in_order()), ("info", "bake"), folder)
    print("\neach cell: s, MB of memory\n    MB" + "".join(f"  {name:>12}" for name in PATHS) + "  saved fit")
    for name, content in hostile_fits.CONTENTS.items():
        path = _made(folder, content())
        _print_row(name, path, _run(path, ("info", "bake"), folder), base, " MB", 1e-6)


def _run(path, names, folder):
    """Put a file through several paths, and through the baker the fit that comes of it: {path: (s, bytes, said)}."""
    fit = folder / "fit.npz"
    fit.unlink(missing_ok=True)
    found = {name: _measured(name, path, folder) for name in names}
    if fit.exists():
        found["bake"] = _measured("bake", fit, folder)
    return found


def _print_row(name, path, found, base, unit, scale):
    try:
        size = path.stat().st_size / 1e6 if path.is_file() else 0
    except OSError:
        size = 0
    cells = []
    for entry in PATHS:
        seconds, memory, _ = found.get(entry, (None, None, None))
        cells.append("" if seconds is None else f"{max(seconds - base[entry][0], 0):.1f} "
                     f"{max(memory - base[entry][1], 0) * scale:.1f}{unit}")
    print(f"{size:6.1f}" + "".join(f"  {cell:>12}" for cell in cells) + f"  {name}: {found['info'][2]}", flush=True)


def _made(folder, content):
    path = folder / "hostile.dat"
    path.write_bytes(content)
    return path


def _special(name, folder):
    """Make one of SPECIAL: its path, and an event that ends what is going on with it."""
    stop = threading.Event()
    path = folder / name.replace(" ", "-")
    if name == "a folder":
        path.mkdir()
    elif name.startswith("a pipe"):
        os.mkfifo(path)
    elif name.startswith("a device"):
        path = Path("/dev/zero")
    elif name.startswith("a link"):
        path.symlink_to(path)
    elif name.startswith("a file that grows"):
        path.write_bytes(_filled(_ROW, _VARS, size=8 * MEGABYTE))
        threading.Thread(target=_grow, args=(path, stop)).start()
    else:
        path = folder / ("x" * 5000)
    return path, stop


def _grow(path, stop):
    with open(path, "ab", buffering=0) as stream:
        while not stop.is_set():
            stream.write(_ROW)
            time.sleep(1e-4)


def _measured(name, path, folder):
    """Processor seconds and peak bytes of one path, and the first line of what it said."""
    done = run_python("-c", _MEASURED, name, path, folder / "fit.npz", timeout=120)
    assert "Traceback" not in done.stderr, done.stderr
    *said, seconds, memory, code = done.stdout.split("\n")[:-1]
    assert code in {"0", "1"}, done.stderr
    text = done.stderr.removeprefix(f"error: {path}").lstrip(": ").rstrip() or next(
        (line.strip() for line in said if "direction pairs" in line), said[0] if said else "")
    return float(seconds), int(memory) * 1024, text.splitlines()[0][:100]


_MEASURED = """
import re, sys, time
from pathlib import Path
name, path, fit = sys.argv[1:]
if name == "panel":
    from support import panel_work
    code = panel_work.main(path)
else:
    from fitter import cli
    code = cli.main({"info": ["info", path], "fit": ["fit", path, "--preset", "Draft", "-o", fit],
                     "bake": ["bake", path, "-o", fit + ".osl"]}[name])
status = open("/proc/self/status").read()       # the peak since exec: getrusage has that of the parent in it
print(time.process_time(), re.search("VmHWM: *([0-9]+)", status.replace("\\t", " "))[1], code, sep="\\n")
"""
