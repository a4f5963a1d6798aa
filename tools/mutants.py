"""``make mutants``: with each guard of the extension and of the shader removed in turn, which tests notice?

A mutant is the checkout with one guard taken out, made in a copy; the working tree is not touched. In Python, guards
are found by their form (`python_mutants`); those of the shader are listed (`shader_guards`). For each mutant the tests
that cover its file run until one fails, and a line says which, or that the mutant survived. A survivor is a guard
without a test, or one that protects nothing: docs/robustness.md lists them.

    python -m tools.mutants                                 # all of them: about an hour
    python -m tools.mutants addon/library/batch.py osl/lamps.h      # those of two files
    python -m tools.mutants --every 10                      # every tenth
    python -m tools.mutants --list                          # list, run nothing
"""

import argparse
import ast
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

from support import kept
from support.checkout import ROOT, measurements
from tools.shader_guards import SHADER_GUARDS

# what undoes, bounds or forgives; without it, the block runs by itself
_CONTEXTS = {"new_data_removed_on_error", "restored_on_error", "unmarked_on_error", "locked", "writing", "suppress"}
_NOTHING = '__import__("contextlib").nullcontext()'

_LIMIT = 600                # s, for the tests of one mutant
_USAGE = 4, 5                # how pytest ends where there are no such tests

_FAILING = "tests/addon/work/test_failing_operators.py"
_IMPORT = "tests/addon/importing/test_import.py"
_JOBS = "tests/addon/work/test_jobs.py"
_LIBRARY = "tests/addon/library/test_library.py"
_REUSE = "tests/addon/library/test_reuse.py"
_LAMPS = ("tests/addon/core/test_lamps.py", "-k",
          "any_edits or instanced or hidden or group_has or older_shaders or named or gone or still or bright or layer")
# the tests of each file, those that are likeliest to notice first
TESTS = {
    "addon/core/transaction.py": (_FAILING, "-k", "refit or update or dies"),
    "addon/core/material.py": (_IMPORT, _FAILING, "-k", "refit or update or import or fitting"),
    "addon/work/modal.py": (_JOBS, _IMPORT, _FAILING, "-k",
                            "(operator or escape or begin or without_osl) and not anywhere or folder"),
    "addon/importing/import_data.py": (_IMPORT, _REUSE, _FAILING, "-k",
                                       "import and not folder or linked or dropped or samples_of"),
    "addon/core/library_file.py": (_LIBRARY, "-k", "ours or open_file or second_writer or sav or version"),
    "addon/library/operators.py": (_LIBRARY, _REUSE, _FAILING, "-k",
                                   "saving or saved_again or becomes_an_asset or library_it_is or asset"),
    "addon/library/batch.py": (_LIBRARY, _REUSE, "-k",
                               "cannot_be_read or gone or large or second or ten_files or killed"),
    "addon/work/process.py": (_JOBS,),
    "addon/work/queue.py": (_JOBS,),
    "addon/work/blender_process.py": (_JOBS, _LIBRARY),
    "addon/core/checks.py": ("tests/addon/core/test_checks.py",),
    "addon/core/lamps/__init__.py": _LAMPS,
    "addon/core/lamps/changes.py": _LAMPS,
    "addon/core/lamps/drivers.py": _LAMPS,
    "addon/core/lamps/group.py": _LAMPS,
    "addon/core/lamps/instances.py": _LAMPS,
    "addon/core/lamps/lamp.py": _LAMPS,
    "addon/core/lamps/light_objects.py": _LAMPS,
}


class Mutant(NamedTuple):
    """A checkout without one guard.

    Attributes
    ----------
    path : str
        The file, relative to the checkout.
    line : int
    change : str
        What was taken out, in a line.
    text : str
        The file as it is without.
    tests : tuple of str
        What is run: arguments of pytest.
    """

    path: str
    line: int
    change: str
    text: str
    tests: tuple


def python_mutants(path, text):
    """Those of a Python file, whose text this is: a list of Mutant.

    An `if` whose block leaves (raise, return, continue, break), assigns or yields is never entered, and where it
    returns or continues, always; transactions, locks and `suppress` are left out, `finally` does nothing, `except` lets
    pass.
    """
    changes = sorted(change for node in ast.walk(ast.parse(text)) for change in _changes(node))
    starts = [0]
    for line in text.encode().splitlines(keepends=True):
        starts.append(starts[-1] + len(line))
    made = []
    for (first, last), replacement, what in changes:
        begin, end = (starts[line - 1] + column for line, column in (first, last))
        source = text.encode()
        was = " ".join(source[begin:end].decode().split())
        mutated = (source[:begin] + replacement.encode() + source[end:]).decode()
        made.append(Mutant(path, first[0], f"{what}: {was}", mutated, TESTS.get(path, ("tests",))))
    return made


def _changes(node):
    """Changes of one node: ((line, column), (line, column)), replacement, what it is."""
    if isinstance(node, ast.If) and _guards(node.body[-1]):
        yield _span(node.test), "False", "never"
        named = any(isinstance(part, ast.NamedExpr) for part in ast.walk(node.test))
        if isinstance(node.body[-1], ast.Return | ast.Continue) and not named:
            yield _span(node.test), "True", "always"
    elif isinstance(node, ast.Call) and _name(node.func) in _CONTEXTS:
        yield _span(node), _NOTHING, "without"
    elif isinstance(node, ast.Try) and node.finalbody:
        yield _span(*node.finalbody), "pass", "finally, without"
    elif isinstance(node, ast.ExceptHandler):
        yield _span(*node.body), "raise", "except, without"


def _guards(last):
    """Whether a block that ends with this statement leaves, assigns or yields."""
    leaving = ast.Raise | ast.Return | ast.Continue | ast.Break | ast.Assign | ast.AugAssign
    return isinstance(last, leaving) or (isinstance(last, ast.Expr) and isinstance(last.value, ast.Yield))


def _span(*nodes):
    return (nodes[0].lineno, nodes[0].col_offset), (nodes[-1].end_lineno, nodes[-1].end_col_offset)


def _name(function):
    return function.attr if isinstance(function, ast.Attribute) else getattr(function, "id", None)


def shader_mutants(path, text):
    """Those of a file of the shader, as `shader_guards` lists them: a list of Mutant."""
    made = []
    for guard in SHADER_GUARDS:
        if guard.path == path:
            if text.count(guard.text) != 1:
                raise ValueError(f"{path}: {text.count(guard.text)} times, expected once: {guard.text!r}")
            line = text[:text.index(guard.text)].count("\n") + 1
            change = " ".join(f"{guard.text} -> {guard.replacement} ({guard.why})".split())
            made.append(Mutant(path, line, change,
                               text.replace(guard.text, guard.replacement), guard.tests))
    return made


def mutants(paths):
    """Those of some files: a list of Mutant."""
    return [mutant for path in paths
            for mutant in (python_mutants if path.endswith(".py") else shader_mutants)(path, (ROOT / path).read_text())]


def copy_checkout(folder):
    """Copy the files that git knows, or would, as they are in the working tree."""
    listed = subprocess.run(["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"], cwd=ROOT,
                            capture_output=True, text=True, check=True).stdout.split("\0")
    for name in filter(None, listed):
        if (ROOT / name).is_file():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, folder / name)


def run_tests(folder, tests):
    """What the tests of a copy say: an empty string where all pass, else the first that fails, or how they ended."""
    environment = os.environ | {"MEASURED_BRDF_DATA": str(measurements().resolve()), "PYTHONDONTWRITEBYTECODE": "1",
                                "MEASURED_BRDF_KEPT": str(kept.FOLDER)}
    command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", "--tb=line", *tests]
    try:
        done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, timeout=_LIMIT,
                              check=False)
    except subprocess.TimeoutExpired:
        return f"none within {_LIMIT} s"
    if done.returncode == 0:
        return ""
    if done.returncode in _USAGE:
        raise RuntimeError(f"{' '.join(tests)}: no tests to run")
    failed = re.search(r"^(?:FAILED|ERROR) (.+?)(?: - .*)?$", done.stdout, re.MULTILINE)
    return failed[1] if failed else f"pytest ended with code {done.returncode}"


def main():
    """Print a line for each mutant, and a summary. It says something only where the tests pass without a mutation."""
    parser = argparse.ArgumentParser(prog="python -m tools.mutants", description="Which tests notice a missing guard?")
    parser.add_argument("paths", nargs="*", metavar="FILE", help="files to mutate, relative to the checkout")
    parser.add_argument("--every", type=int, default=1, metavar="N", help="only every N-th mutant")
    parser.add_argument("--list", action="store_true", help="list the mutants, run nothing")
    chosen = parser.parse_args()
    made = mutants(chosen.paths or [*TESTS, *dict.fromkeys(guard.path for guard in SHADER_GUARDS)])[::chosen.every]
    if chosen.list:
        for mutant in made:
            print(f"{mutant.path}:{mutant.line} {mutant.change}")
        return 0
    survivors = 0
    with tempfile.TemporaryDirectory(prefix="mutants_") as name:
        folder = Path(name)
        copy_checkout(folder)
        for mutant in made:
            original = (folder / mutant.path).read_text()
            (folder / mutant.path).write_text(mutant.text)
            failed = run_tests(folder, mutant.tests)
            (folder / mutant.path).write_text(original)
            if not failed:
                survivors += 1
            print(f"{'killed  ' if failed else 'SURVIVED'} {mutant.path}:{mutant.line} {mutant.change}"
                  f"{f'  by {failed}' if failed else ''}", flush=True)
    print(f"{len(made)} mutants, {len(made) - survivors} killed, {survivors} survived")
    return 0


if __name__ == "__main__":
    sys.exit(main())
