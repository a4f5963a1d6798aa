"""Compiling OSL source without a node, so that nothing of the open file is touched meanwhile."""

import hashlib
import re
import tempfile
from pathlib import Path
from typing import NamedTuple

from . import osl_support

_OPTIONS = re.compile(r"^# options: .*\n", re.MULTILINE)        # folders of the machine that compiled


class CompileError(RuntimeError):
    """The baked shader could not be compiled here; the message says why."""


class Shader(NamedTuple):
    """OSL source and what the compiler made of it."""

    source: str
    bytecode: str

    @property
    def bytecode_hash(self):
        """By which Cycles tells shaders apart."""
        return hashlib.md5(self.bytecode.encode(), usedforsecurity=False).hexdigest()


def compile_shader(source):
    """Compile OSL source: str to Shader. Raises CompileError."""
    reason = osl_support.missing()
    if reason:
        raise CompileError(reason)
    import _cycles

    try:
        with tempfile.TemporaryDirectory(prefix="measured_brdf_") as folder:
            written, compiled = Path(folder, "shader.osl"), Path(folder, "shader.oso")
            written.write_text(source, "utf-8")
            if not _cycles.osl_compile(str(written), str(compiled)) or not compiled.is_file():
                raise CompileError("The OSL compiler refused the shader; its complaints are in the console")
            bytecode = compiled.read_text("utf-8")
    except OSError as error:
        raise CompileError(f"The OSL compiler refused the shader: {error.filename or 'temporary files'}: "
                           f"{error.strerror or error}") from error
    if not bytecode:
        raise CompileError("The OSL compiler refused the shader: it wrote nothing, perhaps for want of disk space")
    return Shader(source, _OPTIONS.sub("", bytecode))
