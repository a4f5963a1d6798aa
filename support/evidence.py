"""Tables as pages have them, and a digest of the files that they measure, which tells their age (`tools.evidence`).

A table is Markdown between marks with its name, as it is printed and as it stands in a page.
"""

import ast
import hashlib
import io
import re
import tokenize

from .checkout import ROOT

BEGIN, END = "<!-- evidence: {} -->", "<!-- /evidence -->"
FITS = ("fitter/arrays.py", "fitter/colours.py", "fitter/coordinates", "fitter/optics/fresnel.py", "fitter/lattice",
        "fitter/least_squares.py", "fitter/methods", "fitter/model",
        "fitter/quality/cross_validation.py", "fitter/quality/physics.py", "fitter/samples.py",
        "fitter/shader_constants.py", "fitter/optics/subsurface.py")
"""What the errors of fits depend on."""
BAKED = (*FITS, "fitter/cycles", "osl")
"""What shaders and closures depend on."""
SHADER = (*BAKED, "addon/core/shading/closure_nodes.py", "addon/core/lamps", "addon/core/shading/node_group.py")
"""What rendered pictures depend on."""
_SUFFIXES = {".py", ".osl", ".h", ".csv"}


def show(name, text):
    """Print a table, or a number of a sentence, under the name that its mark in a page has."""
    print(f"{BEGIN.format(name)}{text}{END}", flush=True)


def show_table(name, header, rows):
    """Print a table of rows under its name."""
    show(name, f"\n\n{table(header, rows)}\n")


def table(header, rows):
    """A Markdown table; columns of numbers are aligned to the right.

    Examples
    --------
    >>> print(table(("material", "bytes"), [("felt", 16384), ("a|b", None)]), end="")
    | material | bytes |
    | --- | ---: |
    | felt | 16,384 |
    | a\\|b |  |
    """
    rows = [*rows]
    text = [[_cell(value) for value in row] for row in rows]
    rule = ["---:" if rows and _is_number(value) else "---" for value in (rows[0] if rows else header)]
    return "\n".join("| " + " | ".join(row) + " |" for row in [list(header), rule, *text]) + "\n"


def _is_number(value):
    if isinstance(value, str):          # a number that was formatted already
        return value.strip("*%x+-.,0123456789e ") == "" and any(map(str.isdigit, value))
    return isinstance(value, int | float) and not isinstance(value, bool)


def _cell(value):
    if value is None:
        return ""
    if isinstance(value, float):
        return f"{value:,.0f}" if abs(value) >= 1000 else f"{value:.3g}"
    return f"{value:,}" if isinstance(value, int) else re.sub(r"([|*])", r"\\\1", str(value))


def digest(measured):
    """A digest of files, and of the sources in folders, as paths from the root: what they do, not how they are told.

    Comments and docstrings of Python are left out. Raises FileNotFoundError where a path is not there.
    """
    found = hashlib.sha256()
    for path in sorted({each for name in measured for each in _files(ROOT / name)}):
        text = path.read_text("utf-8")
        text = bare(text) if path.suffix == ".py" else text
        found.update(f"{path.relative_to(ROOT).as_posix()}\0{text}\0".encode())
    return found.hexdigest()[:8]


def _files(path):
    if path.is_dir():
        return [each for each in path.rglob("*") if each.suffix in _SUFFIXES and each.is_file()]
    return [path]


def bare(text):
    """A Python source without comments, docstrings and blank lines.

    Examples
    --------
    >>> bare('x = "#"  # why\\n\\ndef f():\\n    \\'\\'\\'Of f.\\'\\'\\'\\n    return x\\n')
    'x = "#"\\ndef f():\\n    return x\\n'
    """
    lines = text.splitlines()
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type == tokenize.COMMENT:
            row, column = token.start
            lines[row - 1] = lines[row - 1][:column]
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef) and ast.get_docstring(node, False) is not None:
            told = node.body[0]
            lines[told.lineno - 1:told.end_lineno] = [""] * (told.end_lineno - told.lineno + 1)
    return "".join(f"{line.rstrip()}\n" for line in lines if line.strip())
