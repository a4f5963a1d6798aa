"""Saved fits made to exhaust memory, or to smuggle numbers into a shader that are not finite there.

Each is a fit that is in order but for one thing. What `python -m fitter info` and `bake` make of them is printed by
`hostile_files`.
"""

import functools
import io
import json
import struct
import tempfile
import zipfile
from pathlib import Path

import numpy as np

from .made_fits import MADE_FITS

MEGABYTE = 1 << 20


@functools.cache
def _members():
    """The members of a valid fit with lobes and a sparse lattice, as `numpy.savez` writes them: {name: bytes}."""
    fit = MADE_FITS["Rusinkiewicz, stretched by 33, all lobes, damped"]
    with tempfile.TemporaryDirectory() as folder:
        fit.save(Path(folder) / "fit.npz")
        with zipfile.ZipFile(Path(folder) / "fit.npz") as file:
            return {name: file.read(name) for name in file.namelist()}


def in_order():
    return _zip()


def _zip(changes=None, method=zipfile.ZIP_DEFLATED, comment=b"", extra=()):
    """The fit with some members changed, and others besides."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", method) as file:
        for name, content in [*(_members() | (changes or {})).items(), *extra]:
            file.writestr(name, content)
        file.comment = comment
    return stream.getvalue()


def _npy(array):
    stream = io.BytesIO()
    np.save(stream, array)
    return stream.getvalue()


def _header(**changes):
    header = json.loads(str(np.load(io.BytesIO(_members()["header.npy"]))))
    return {"header.npy": _npy(np.array(json.dumps(header | changes)))}


def _filled(name, number):
    array = np.load(io.BytesIO(_members()[f"{name}.npy"]))
    return {f"{name}.npy": _npy(np.full_like(array, number))}


def _claiming(kind, count, content):
    """An array file of version 1.0 that claims `count` numbers."""
    text = repr({"descr": kind, "fortran_order": False, "shape": (count,)}).encode().ljust(117) + b"\n"
    return b"\x93NUMPY\x01\x00" + len(text).to_bytes(2, "little") + text + content


def _long_header(megabytes):
    text = b"{'descr': '<f4', 'fortran_order': False, 'shape': (1,)}".ljust(megabytes * MEGABYTE)
    return b"\x93NUMPY\x02\x00" + len(text).to_bytes(4, "little") + text + bytes(4)


def _in_zip64():
    """A directory as large as it likes, to which the record of a zip64 points."""
    content = _zip()
    start = len(content) - 22
    size, offset = struct.unpack("<2L", content[start + 12:start + 20])
    record = struct.pack("<4sQ2H2L4Q", b"PK\6\6", 44, 45, 45, 0, 0, len(_members()), len(_members()), size, offset)
    locator = struct.pack("<4sLQL", b"PK\6\7", 0, start, 1)
    return content[:start] + record + locator + content[start:]


CONTENTS = {
    "a header of 100 MB": lambda: _zip({"diffuse.npy": _long_header(100)}),
    "a header of 65,535 brackets": lambda: _zip({"diffuse.npy": b"\x93NUMPY\x01\x00\xff\xff" + b"[" * 65535}),
    "60,000 members": lambda: _zip(extra=[(f"a{n}.npy", b"") for n in range(60_000)]),
    "a name of 60,000 letters": lambda: _zip(extra=[("a" * 60_000 + ".npy", b"")]),
    "a name that is a path": lambda: _zip(extra=[("../../evil.npy", _members()["diffuse.npy"])]),
    "the directory of a zip64": _in_zip64,
    "a comment of 65,535 letters": lambda: _zip(comment=b"PK\5\6" * 16_383),
    "bzip2: 40 MB of zeros": lambda: _zip({"diffuse.npy": bytes(40 * MEGABYTE)}, zipfile.ZIP_BZIP2),
    "LZMA: 40 MB of zeros": lambda: _zip({"diffuse.npy": bytes(40 * MEGABYTE)}, zipfile.ZIP_LZMA),
    "an array of 300 MB": lambda: _zip({"diffuse.npy": _claiming("<f4", 75 << 20, bytes(300 * MEGABYTE))}),
    "an array that claims 4 TB": lambda: _zip({"diffuse.npy": _claiming("<f4", 1 << 40, b"")}),
    "three arrays of 120 MB": lambda: _zip({f"{name}.npy": _claiming("<f4", 30 << 20, bytes(120 * MEGABYTE))
                                            for name in ("diffuse", "keys", "coefficients")}),
    "60,000,000 keys": lambda: _zip({"keys.npy": _claiming("<u4", 60_000_000, bytes(240_000_000))}),
    "text of 200 MB": lambda: _zip({"header.npy": _claiming("<U52428800", 1, bytes(200 * MEGABYTE))}),
    "100,000 channels": lambda: _zip(_header(channels=["R"] * 100_000, columns=[0] * 100_000)),
    "an offset of 1e300": lambda: _zip(_header(offset=1e300)),
    "an offset of 1e-320": lambda: _zip(_header(offset=1e-320)),
    "an offset that is text": lambda: _zip(_header(offset="1")),
    "a width of 1e-30": lambda: _zip(_filled("prior_alpha", 1e-30)),
    "a tail of 1e6": lambda: _zip(_filled("prior_gamma", 1e6)),
    "a reflectance of 2 at normal incidence": lambda: _zip(_filled("prior_f0", 2.0)),
    "a lobe of 1e38": lambda: _zip(_filled("prior_ks", 1e38)),
    "a ceiling of 1e-320": lambda: _zip(_filled("prior_ceiling", 1e-320)),
    "a stretch of 1e9": lambda: _zip(_header(stretch=1e9)),
    "a softening radius of 1e-30": lambda: _zip(_header(softening=1e-30)),
    "a lobe of an unknown kind": lambda: _zip(_header(lobes=["mirror", "retro", "velvet"])),
    "100,000 lobes": lambda: _zip(_header(lobes=["mirror"] * 100_000)),
    "a damping of 1e30": lambda: _zip(_filled("damping", 1e30)),
    "a damping that amplifies": lambda: _zip(_filled("damping", 1.001)),
    "coefficients of 3e38": lambda: _zip(_filled("coefficients", 3e38)),
    "coefficients that are not numbers": lambda: _zip(_filled("diffuse", np.nan)),
}
