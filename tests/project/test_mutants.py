"""The mutation run itself: mutants change what they say, and none is lost when the code is edited."""

import ast
import contextlib

from support.checkout import ROOT
from tools import mutants
from tools.shader_guards import SHADER_GUARDS

SOURCE = """
def positive(x):
    if x < 0:
        raise ValueError("é")
    if x > 9: x = 9
    return x

def undone(log):
    with restored_on_error(log):
        try:
            log.append(positive(-1))
        except ValueError:
            log.append("caught")
        finally:
            log.append("cleaned up")
    return log
"""


def run(text):
    """What the functions of a text do: (positive(-1), positive(10), undone([]))."""
    @contextlib.contextmanager
    def restored_on_error(log):
        log.append("begun")
        yield

    names = {"restored_on_error": restored_on_error}
    exec(text, names)
    found = []
    for call in ("positive(-1)", "positive(10)", "undone([])"):
        try:
            found.append(eval(call, names))
        except ValueError:
            found.append("ValueError")
    return tuple(found)


def test_each_guard_of_python_is_removed_and_nothing_else_changes():
    assert run(SOURCE) == ("ValueError", 9, ["begun", "caught", "cleaned up"])
    found = {mutant.change.partition(":")[0] + str(mutant.line): run(mutant.text)
             for mutant in mutants.python_mutants("example.py", SOURCE)}
    assert found == {
        "never3": (-1, 9, ["begun", -1, "cleaned up"]),
        "never5": ("ValueError", 10, ["begun", "caught", "cleaned up"]),
        "without9": ("ValueError", 9, ["caught", "cleaned up"]),
        "except, without13": ("ValueError", 9, "ValueError"),
        "finally, without15": ("ValueError", 9, ["begun", "caught"]),
    }


def test_every_mutant_of_the_checkout_is_another_text_and_has_tests():
    paths = [*mutants.TESTS, *dict.fromkeys(guard.path for guard in SHADER_GUARDS)]
    made = mutants.mutants(paths)           # raises where a guard of the shader is not there any more
    assert len({mutant.path for mutant in made}) == len(paths)
    for mutant in made:
        assert mutant.text != (ROOT / mutant.path).read_text(), mutant.change
        assert all((ROOT / name).is_file() for name in mutant.tests if name.endswith(".py")), mutant.path
        if mutant.path.endswith(".py"):
            ast.parse(mutant.text)
