"""``make mutants``: with each guard of the extension and of the shader removed in turn, which tests notice?

A mutant is a copy of the checkout with one guard taken out. In Python, guards are found by their form
(`python_mutants`); those of the shader are listed (`shader_guards`). For each the tests that can notice run, quick and
narrow ones first, until one fails; a line says which, or that the mutant SURVIVED (a guard without a test, or one that
protects nothing), or LATE (one that loops, or a busy machine). Which tests reach which line `tools.reached` finds.

    python -m tools.mutants                                 # all of them
    python -m tools.mutants addon/library/batch.py osl/lamps.h      # those of two files
    python -m tools.mutants --list                          # list, run nothing
"""

import argparse
import ast
import compileall
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections import Counter, defaultdict
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from pathlib import Path
from py_compile import PycInvalidationMode
from queue import Queue
from typing import NamedTuple

from support import kept
from support.checkout import ROOT, measurements
from tools import reached as reaching
from tools.shader_guards import SHADER_GUARDS

# what undoes, bounds or forgives; without it, the block runs by itself
_CONTEXTS = {"new_data_removed_on_error", "restored_on_error", "unmarked_on_error", "locked", "writing", "suppress"}
_NOTHING = '__import__("contextlib").nullcontext()'

_SECONDS = 8, 40, 200       # of the tests that can notice: those that run first, more, and all that run
_LIMIT = 150, 200, 600      # s, for each of these; tests wait up to a minute for what does not come
_USAGE = 4, 5                # how pytest ends where there are no such tests

GUARDED = ("addon/core/blender/transaction.py", "addon/core/checks.py", "addon/core/lamps",
           "addon/core/libraries/library_file.py", "addon/core/shading/material.py", "addon/importing/import_data.py",
           "addon/library/batch.py", "addon/library/operators.py", "addon/work/blender_process.py",
           "addon/work/modal.py", "addon/work/process.py", "addon/work/queue.py")
# of what other processes run, which the map does not see
_JOBS, _LIBRARY = "tests/addon/work/test_jobs.py", "tests/addon/library/test_library.py"
UNSEEN = {"addon/core/libraries/library_file.py": (_LIBRARY,), "addon/library/batch.py": (_LIBRARY,),
          "addon/work/blender_process.py": (_JOBS,), "addon/work/process.py": (_JOBS,)}


class Mutant(NamedTuple):
    """A checkout without one guard.

    `reached` are the lines of a statement that runs in each test that can notice: of an `if` that is never entered,
    what it begins with.
    """

    path: str                   # of the file, relative to the checkout
    line: int
    change: str                 # what was taken out, in a line
    text: str                   # the file as it is without
    tests: tuple                # arguments of pytest; of Python, the map says it
    reached: range = range(0)


def python_mutants(path, text):
    """Those of a Python file, whose text this is: a list of Mutant.

    An `if` whose block leaves (raise, return, continue, break), assigns or yields is never entered, and where it
    returns or continues, always; what it asks is asked. Transactions, locks and `suppress` are left out, `finally` does
    nothing, `except` lets pass.
    """
    changes = sorted((change for node in ast.walk(ast.parse(text)) for change in _changes(node)),
                     key=lambda change: change[:2])
    source, starts = text.encode(), [0]
    for line in source.splitlines(keepends=True):
        starts.append(starts[-1] + len(line))
    made = []
    for (first, last), replacement, what, noticed in changes:
        begin, end = (starts[line - 1] + column for line, column in (first, last))
        was = " ".join(source[begin:end].decode().split())
        mutated = (source[:begin] + replacement.encode() + source[end:]).decode()
        made.append(Mutant(path, first[0], f"{what}: {was}", mutated, (),
                           range(noticed.lineno, noticed.end_lineno + 1)))
    return made


def _changes(node):
    """Changes of one node: ((line, column), (line, column)), replacement, what it is, what a test that notices runs."""
    if isinstance(node, ast.If) and _guards(node.body[-1]) and not _is_of_a_version(node.test):
        condition = ast.unparse(node.test)
        yield _span(node.test), f"({condition}) and False", "never", node.body[0]
        if isinstance(node.body[-1], ast.Return | ast.Continue):
            yield _span(node.test), f"({condition}) or True", "always", node.test
    elif isinstance(node, ast.Call) and _name(node.func) in _CONTEXTS:
        yield _span(node), _NOTHING, "without", node
    elif isinstance(node, ast.Try) and node.finalbody:
        yield _span(*node.finalbody), "pass", "finally, without", node.finalbody[0]
    elif isinstance(node, ast.ExceptHandler):
        yield _span(*node.body), "raise", "except, without", node.body[0]


def _guards(last):
    """Whether a block that ends with this statement leaves, assigns or yields."""
    leaving = ast.Raise | ast.Return | ast.Continue | ast.Break | ast.Assign | ast.AugAssign
    return isinstance(last, leaving) or (isinstance(last, ast.Expr) and isinstance(last.value, ast.Yield))


def _is_of_a_version(test):
    """Whether a condition holds in some versions of Blender: `tools.test_matrix` has the others.

    Since 5.0 every material has a node tree.
    """
    return isinstance(test, ast.Compare) and (
        ast.unparse(test.left) == "bpy.app.version" or ast.unparse(test) == "material.node_tree is None")


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
    """Those of some files and folders: a list of Mutant."""
    shader = {guard.path for guard in SHADER_GUARDS}
    files = [path for path in paths if (ROOT / path).is_file()]
    files += [each for path in paths for file in sorted((ROOT / path).rglob("*"))
              if (each := file.relative_to(ROOT).as_posix()).endswith(".py") or each in shader]
    return [mutant for path in files
            for mutant in (python_mutants if path.endswith(".py") else shader_mutants)(path, (ROOT / path).read_text())]


class Reaching(NamedTuple):
    """A test that reaches a line of a file.

    Its cost are its seconds over the share of the lines that it reaches that are of the file: what is quick and looks
    at little else is the likeliest to notice soon.
    """

    cost: float
    seconds: float
    place: int                  # among all tests
    test: str

    @property
    def file(self):
        """The file of the test."""
        return self.test.partition("::")[0]


def reached():
    """Which tests reach a line: {(file, line): [Reaching, ...]}; found once for the code."""
    path = reaching.path()
    if not path.is_file():
        subprocess.run([sys.executable, "-m", "pytest", "-p", "tools.reached", "-n", "auto", "--dist", "loadfile", "-q",
                        "-m", "not release", "tests/addon"], cwd=ROOT, check=False)
    found = defaultdict(list)
    for place, record in enumerate(map(json.loads, path.read_text("utf-8").splitlines())):
        seconds, of_file = record["seconds"], record["lines"]
        for file, lines in of_file.items():
            cost = seconds * sum(map(len, of_file.values())) / len(lines)
            for line in lines:
                found[file, line].append(Reaching(cost, seconds, place, record["test"]))
    return found


def tests_of(mutant, known):
    """The tests of a mutant, as arguments of pytest: of those that can notice those of the least cost, and others where
    these notice nothing; a tuple for each of _SECONDS, all empty where no test can.

    They run file by file in their order there, as they do in the suite: some may depend on it.
    """
    reaching_it = sorted({each for line in mutant.reached for each in known.get((mutant.path, line), ())})
    if mutant.tests or not reaching_it:
        return (), (), mutant.tests or UNSEEN.get(mutant.path, ())
    seconds, batches = 0.0, [[] for _ in _SECONDS]
    for each in reaching_it:
        seconds += each.seconds
        batch = sum(seconds > most for most in _SECONDS)
        if batch < len(batches):
            batches[batch].append(each)
    files = {file: number for number, file in enumerate(dict.fromkeys(each.file for each in reaching_it))}
    return tuple(tuple(each.test for each in sorted(batch, key=lambda each: (files[each.file], each.place)))
                 for batch in batches)


def copy_checkout(folder):
    """Copy the files that git knows, or would, as they are in the working tree.

    With their byte code, which holds where the text has the hash that it was made of, however fast a text was changed:
    a start of pytest with one test takes 1.6 s of a processor with it and as `run_tests` calls it, 3.0 otherwise.
    """
    listed = subprocess.run(["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"], cwd=ROOT,
                            capture_output=True, text=True, check=True).stdout.split("\0")
    for name in filter(None, listed):
        if (ROOT / name).is_file():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, folder / name)
    compileall.compile_dir(folder, quiet=1, invalidation_mode=PycInvalidationMode.CHECKED_HASH)


def run_tests(folder, tests, limit):
    """What the tests of a copy say: an empty string where all pass, else the first that fails, or how they ended.

    Raises subprocess.TimeoutExpired after `limit` seconds.
    """
    environment = os.environ | {"MEASURED_BRDF_DATA": str(measurements().resolve()), "PYTHONDONTWRITEBYTECODE": "1",
                                "MEASURED_BRDF_KEPT": str(kept.FOLDER)}
    command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", "-p", "no:hypothesispytest",
               "--assert=plain", "--tb=line", "-m", "not release", *tests]
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, timeout=limit,
                          check=False)
    if done.returncode == 0:
        return ""
    if done.returncode in _USAGE:
        raise RuntimeError(f"{' '.join(tests)}: no tests to run")
    failed = re.search(r"^(?:FAILED|ERROR) (.+?)(?: - .*)?$", done.stdout, re.MULTILINE)
    return failed[1] if failed else f"pytest ended with code {done.returncode}"


@cache
def passes(folder, test):
    """Whether a test passes by itself in a copy without a mutation."""
    return not run_tests(folder, (test,), _LIMIT[-1])


def outcome(mutant, known, folders, whole):
    """What the tests say of a mutant, made in one of the copies of the checkout, which are taken from a queue.

    `whole` is a copy without a mutation: what fails in it too has noticed nothing.
    """
    batches = tests_of(mutant, known)
    if not any(batches):
        return "UNREACHED", ""
    folder = folders.get()
    original = (folder / mutant.path).read_text()
    try:
        (folder / mutant.path).write_text(mutant.text)
        for tests, limit in zip(batches, _LIMIT, strict=True):
            while tests and (failed := run_tests(folder, tests, limit)):
                if "::" not in failed or passes(whole, failed):
                    return "killed", failed
                tests = (*tests, "--deselect", failed)
    except subprocess.TimeoutExpired as late:
        return "LATE", f"{late.timeout} s"
    finally:
        (folder / mutant.path).write_text(original)
        folders.put(folder)
    return "SURVIVED", f"{sum(map(len, batches))} tests"


def main():
    """Print a line for each mutant, and a summary. It says something only where the tests pass without a mutation."""
    parser = argparse.ArgumentParser(prog="python -m tools.mutants", description="Which tests notice a missing guard?")
    parser.add_argument("paths", nargs="*", metavar="FILE", help="files to mutate, relative to the checkout")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="copies that are tested at once")
    parser.add_argument("--list", action="store_true", help="list the mutants, run nothing")
    chosen = parser.parse_args()
    made = mutants(chosen.paths or [*GUARDED, *dict.fromkeys(guard.path for guard in SHADER_GUARDS)])
    if chosen.list:
        for mutant in made:
            print(f"{mutant.path}:{mutant.line} {mutant.change}")
        return 0
    known, counted = {} if all(mutant.tests for mutant in made) else reached(), Counter()
    with tempfile.TemporaryDirectory(prefix="mutants_") as name, ThreadPoolExecutor(chosen.jobs) as pool:
        folders = Queue()
        whole = Path(name) / "whole"
        copy_checkout(whole)
        for number in range(chosen.jobs):
            folder = Path(name) / str(number)
            shutil.copytree(whole, folder)
            folders.put(folder)
        for mutant, (said, by) in zip(made, pool.map(lambda each: outcome(each, known, folders, whole), made),
                                      strict=True):
            counted[said] += 1
            print(f"{said:9} {mutant.path}:{mutant.line} {mutant.change}  {by}", flush=True)
    print(f"{len(made)} mutants: {', '.join(f'{count} {said}' for said, count in counted.items())}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
