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
