"""No guard is lost when the code is edited: each is found, and without it the file is another one that still parses."""

import ast

from support.checkout import ROOT
from tools import mutants
from tools.shader_guards import SHADER_GUARDS


def test_every_mutant_of_the_checkout_is_another_text_and_has_tests():
    made = mutants.mutants([*mutants.GUARDED, *dict.fromkeys(guard.path for guard in SHADER_GUARDS)])
    for path in mutants.GUARDED:
        assert any(mutant.path.startswith(path) for mutant in made), path
    for mutant in made:                     # `mutants` raises where a guard of the shader is not there any more
        assert mutant.text != (ROOT / mutant.path).read_text(), mutant.change
        if mutant.path.endswith(".py"):
            ast.parse(mutant.text)
        else:
            assert all((ROOT / name).is_file() for name in mutant.tests if name.endswith(".py")), mutant.path


def test_that_a_block_is_never_entered_only_tests_that_enter_it_can_notice():
    never, always = mutants.python_mutants("addon/a.py", "def f(x):\n    if x:\n        return 1\n    return 2\n")
    inside, past = (mutants.Reaching(1.0, 1.0, place, f"tests/a.py::test_{place}") for place in range(2))
    known = {("addon/a.py", 2): [inside, past], ("addon/a.py", 3): [inside]}
    assert mutants.tests_of(never, known) == ((inside.test,), (), ())
    assert mutants.tests_of(always, known) == ((inside.test, past.test), (), ())
