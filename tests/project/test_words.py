"""The interface and the manual say the same word for the same thing: the table of CONTRIBUTING.md."""

import ast
import re
from functools import cache

import pytest

from support.checkout import ROOT

_TABLE = (ROOT / "CONTRIBUTING.md").read_text("utf-8").partition("| Say | Not |")[2].partition("\n\n")[0]
WORDS = [(say, word) for say, instead in re.findall(r"^\| ([^|-]+?) \| ([^|]+?) \|$", _TABLE, re.MULTILINE)
         for word in instead.split(", ")]
PAGES = [ROOT / "README.md", *(ROOT / "docs").rglob("*.md")]
SOURCES = sorted(path for name in ("addon", "fitter") for path in (ROOT / name).rglob("*.py"))


def texts(source):
    """The texts in a module: those in f-strings too, as what stands around the values. The docstring of a class may be
    a tooltip; nobody is shown those of modules and functions, which are left out."""
    nodes = list(ast.walk(ast.parse(source)))
    unseen = {id(node.body[0].value) for node in nodes if isinstance(node, ast.Module | ast.FunctionDef)
              and node.body and isinstance(node.body[0], ast.Expr)}
    return "\n".join(node.value for node in nodes
                     if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in unseen)


@cache
def shown():
    """What is read by users: {file: text in one line}."""
    found = {path: path.read_text("utf-8") for path in PAGES}
    found |= {path: texts(path.read_text("utf-8")) for path in SOURCES}
    return {path.relative_to(ROOT).as_posix(): " ".join(text.split()) for path, text in found.items()}


def where(word):
    """The files that have a word."""
    found = re.compile(rf"\b{re.escape(word)}(?!\w)")
    return [path for path, text in shown().items() if found.search(text)]


@pytest.mark.parametrize("word", sorted({word for _, word in WORDS}))
def test_no_text_has_a_word_that_another_has_replaced(word):
    assert where(word) == []
