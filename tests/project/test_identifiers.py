"""Functions are verbs or what they return, and a name means one thing: the identifiers of fitter, addon and osl.

`old_names.txt` has those that were named otherwise before these tests; it only shrinks.
"""

import ast
import re
from collections import defaultdict

import pytest

import fitter
from support.checkout import ROOT

PREPOSITIONS = frozenset((
    "about", "above", "across", "after", "along", "around", "at", "before", "behind", "below", "beside", "between",
    "beyond", "by", "from", "in", "inside", "into", "near", "of", "off", "on", "out", "over", "past", "through",
    "to", "toward", "towards", "under", "upon", "with", "within", "without"))
BEGINNINGS = PREPOSITIONS - {"from", "on", "to"}    # `from_bytes` and `to_bytes` convert, `on_load` is a handler
PARTICIPLES = frozenset((
    "apart", "are", "brought", "descended", "done", "drawn", "far", "found", "frugal", "given", "grey", "grown",
    "held", "hidden", "is", "kept", "known", "left", "lit", "lost", "made", "misses", "pull", "said", "seen",
    "shares", "shown", "steep", "stiffness", "stops", "taken", "tilt", "told", "unknown", "unseen", "upright",
    "worth", "written"))
NO_PARTICIPLES = frozenset(["principled", *fitter.__all__])     # a BSDF's name, and what others call
OF_EACH = frozenset(("FORMAT", "ENTRIES", "IN_FILE_MENU", "TOPICS"))      # every format, every slice has one
MODULES = sorted(path for name in ("addon", "fitter") for path in (ROOT / name).rglob("*.py"))
HEADERS = sorted((ROOT / "osl").iterdir())


def is_bare(name):
    """Whether a function is named by a preposition or a bare participle, or as that of something."""
    words = name.strip("_").split("_")
    if len(words) == 1:
        return words[0] not in NO_PARTICIPLES and (
            words[0] in PREPOSITIONS | PARTICIPLES or re.search("[^e]ed$", words[0]) is not None)
    return words[0] in BEGINNINGS or words[-1] == "of"


def functions(source):
    """The names of the functions and methods of a module."""
    return [node.name for node in ast.walk(ast.parse(source)) if isinstance(node, ast.FunctionDef)]


def shader_functions(source):
    """The names of the functions of a header."""
    return re.findall(r"^(?:closure )?\w+ (\w+)\(", source, re.MULTILINE)


def classes(source):
    """The names of the classes of a module."""
    return [node.name for node in ast.walk(ast.parse(source)) if isinstance(node, ast.ClassDef)]


def constants(source):
    """The constants of a module, without the underscore of private ones: {name: value, as it is written}."""
    found = {}
    for node in ast.parse(source).body:
        if isinstance(node, ast.Assign | ast.AnnAssign) and node.value is not None:
            target, = node.targets if isinstance(node, ast.Assign) else [node.target]
            pairs = [(target, node.value)]
            if isinstance(target, ast.Tuple) and isinstance(node.value, ast.Tuple):
                pairs = zip(target.elts, node.value.elts, strict=True)
            found |= {name.id.strip("_"): ast.unparse(value) for name, value in pairs
                      if isinstance(name, ast.Name) and name.id.isupper()}
    return found


def shader_constants(source):
    """The constants of a header, as `constants` has them."""
    return dict(re.findall(r"^#define ([A-Z]\w*) ([^ \\\n][^\\\n]*)$", source, re.MULTILINE))


def old_names(sources):
    """What breaks the rules in sources, {path: text}, as `old_names.txt` has it."""
    found, defined, valued = set(), defaultdict(list), defaultdict(set)
    for path, source in sources.items():
        in_python = path.endswith(".py")
        names = functions(source) if in_python else shader_functions(source)
        found |= {f"{path} {name}" for name in names if is_bare(name)}
        for name in classes(source) if in_python else ():
            defined[name].append(path)
        for name, value in (constants(source) if in_python else shader_constants(source)).items():
            valued[name].add(value)
    found |= {f"class {name}" for name, paths in defined.items() if len(paths) > 1}
    return found | {f"constant {name}" for name, values in valued.items() if len(values) > 1 and name not in OF_EACH}


def test_names_that_break_the_rules_are_those_of_the_list_which_only_shrinks():
    sources = {path.relative_to(ROOT).as_posix(): path.read_text("utf-8") for path in (*MODULES, *HEADERS)}
    listed = (ROOT / "tests" / "project" / "old_names.txt").read_text("utf-8").splitlines()
    found = old_names(sources)
    assert listed == sorted(set(listed))
    assert sorted(found - set(listed)) == [], "rename these"
    assert sorted(set(listed) - found) == [], "delete these lines of old_names.txt"


@pytest.mark.parametrize(("sources", "found"), [
    ({"fitter/a.py": "def _between(x): pass\nclass A:\n    def fitted(self):\n        def in_words(): pass"},
     {"fitter/a.py _between", "fitter/a.py fitted", "fitter/a.py in_words"}),
    ({"fitter/a.py": "def fit(): pass\ndef from_bytes(): pass\ndef need(): pass\ndef reflected_light(): pass"}, set()),
    ({"osl/a.h": "vector turned(vector w)\nfloat pdf(vector w)\nclosure color shown(color c)"},
     {"osl/a.h turned", "osl/a.h shown"}),
    ({"fitter/a.py": "class Measured: pass", "addon/b.py": "class Measured: pass"}, {"class Measured"}),
    ({"fitter/a.py": "MOST, LEAST = 1, 2", "fitter/b.py": "MOST: int = 3\nLEAST = 2"}, {"constant MOST"}),
    ({"fitter/a.py": "_MOST = 1", "addon/b.py": "MOST = 2", "addon/c.py": "FORMAT = 1", "addon/d.py": "FORMAT = 2"},
     {"constant MOST"}),
    ({"fitter/a.py": "MOST = 1", "osl/b.h": "#define MOST (LEAST - 1.0)     /* so */\n#define GET(k) 1"},
     {"constant MOST"}),
])
def test_a_name_that_breaks_the_rules_is_noticed(sources, found):
    assert old_names(sources) == found
