"""Compiles OSL source without a script node, so that the open file is not touched."""

import hashlib
import tempfile
from pathlib import Path
from typing import NamedTuple

from ....fitter.cycles.node_mixture import Nodes
from ..blender import osl_support
from ..storage.outcomes import Surface
from .bytecode import compact

_MOST_SOURCE = 1 << 24      # bytes: the OSL compiler reads no more, and finds an error in the middle of a table


class CompileError(RuntimeError):
    """This Blender could not compile the baked shader; the message says why."""


class Shader(NamedTuple):
    """OSL source, what the compiler made of it, and the closure nodes of the same fit, which is kept beside them.

    The bytecode is empty where this Blender was built without OSL: materials then have closure nodes alone.
    """

    source: str
    bytecode: str
    nodes: Nodes
    fit: bytes = b""            # as `Fit.to_bytes` returns it; empty where nothing will ask for it

    @property
    def bytecode_hash(self) -> str:
        """Cycles tells shaders apart by it."""
        return hashlib.md5(self.bytecode.encode(), usedforsecurity=False).hexdigest()


def compile_surface(surface: Surface) -> Shader:
    """Compile what a material shows. Raises CompileError."""
    return compile_shader(surface.source, surface.nodes, surface.kept)


def compile_shader(source: str, nodes: Nodes, fit: bytes = b"") -> Shader:
    """Compile OSL source, to go with closure nodes and a fit. Raises CompileError."""
    return Shader(source, "" if osl_support.reason_unavailable() else _bytecode(source), nodes, fit)


def _bytecode(source: str) -> str:
    """What the OSL compiler makes of source text. Raises CompileError."""
    import _cycles

    size = len(source.encode("utf-8"))
    if size > _MOST_SOURCE:
        raise CompileError(f"The shader's tables take {size / 1e6:.0f} MB of text, at most {_MOST_SOURCE / 1e6:.0f} MB "
                           "can be compiled: choose a lower level, or a compression that drops more")
    try:
        with tempfile.TemporaryDirectory(prefix="measured_brdf_") as folder:
            written, compiled = Path(folder, "shader.osl"), Path(folder, "shader.oso")
            written.write_text(source, "utf-8")
            if not _cycles.osl_compile(str(written), str(compiled)) or not compiled.is_file():
                raise CompileError("The OSL compiler rejected the shader; the console shows its errors")
            bytecode = compiled.read_text("utf-8")
    except OSError as error:
        raise CompileError(f"The OSL compiler rejected the shader: {error.filename or 'temporary files'}: "
                           f"{error.strerror or error}") from error
    if not bytecode:
        raise CompileError("The OSL compiler wrote an empty file; the disk may be full")
    return compact(bytecode)
