"""Compiles OSL source without a script node, so that the open file is not touched; and makes what the compiler writes
shorter, for the same shader: it is most of what a material takes in a .blend."""

import hashlib
import re
import tempfile
from collections import Counter
from pathlib import Path
from typing import NamedTuple

from ....fitter.cycles.node_mixture import Nodes
from ..blender import osl_support
from ..storage.outcomes import Surface

_MOST_SOURCE = 1 << 24      # bytes: the OSL compiler reads no more, and finds an error in the middle of a table
# the source once more, folders of this machine, hints for messages of errors and of lifetimes, which OSL works out
# again when it loads a shader, and what it takes for granted: that an instruction writes its first argument and reads
# the others
_NOT_NEEDED = re.compile(r'^[ \t]*#.*\n|[ \t]*%(?:filename\{"[^"]*"\}|(?:line|read|write)\{[^}]*\}|argrw\{"wr*"\})',
                         re.MULTILINE)
_LONG_TABLE = re.compile(r"^const\tfloat\[\d{3,}\]\t\S+\t(.*)$", re.MULTILINE)
_FIGURES = 7                # of the numbers in tables: single precision has 6 to 9
_VARIABLE = re.compile(r"^(?:temp|local|const)\t[^\t]+\t((?:\$|___\d)[\w$]*)(?!.*%)", re.MULTILINE)
_BYTECODE_WORD = re.compile(r'"(?:[^"\\]|\\.)*"|[\w$.]*[A-Za-z_$][\w$.]*')
_DIGITS = "0123456789abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"


class CompileError(RuntimeError):
    """This Blender could not compile the baked shader; the message says why."""


class Shader(NamedTuple):
    """OSL source, what the compiler made of it, and the closure nodes of the same fit, which is kept beside them."""

    source: str
    bytecode: str               # empty where this Blender was built without OSL
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


def compact(text: str) -> str:
    """The same shader in fewer characters: variables get short names, the shortest where they are used most; parameters
    and structures keep theirs. Numbers of tables are rounded, by at most 5e-7."""
    text = _LONG_TABLE.sub(lambda table: table[0].replace(table[1], _round_table(table[1])), _NOT_NEEDED.sub("", text))
    variables = set(_VARIABLE.findall(text))
    counts = Counter(word for word in _BYTECODE_WORD.findall(text) if word in variables)
    names = {word: f"${_number(place)}" for place, (word, _) in enumerate(counts.most_common())}
    renamed = _BYTECODE_WORD.sub(lambda word: names.get(word[0], word[0]), text)
    return re.sub(r"[ \t]+$", "", renamed, flags=re.MULTILINE)


def _round_table(numbers: str) -> str:
    return " ".join(re.sub(r"^(-?)0\.", r"\1.", f"{float(number):.{_FIGURES}g}") for number in numbers.split())


def _number(place: int) -> str:
    """A number in base 62."""
    digits = _DIGITS[place % len(_DIGITS)]
    return digits if place < len(_DIGITS) else _number(place // len(_DIGITS)) + digits
