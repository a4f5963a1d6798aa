"""The interface and the manual say the same word for the same thing: the table of CONTRIBUTING.md."""

import ast
import re

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


def where(word):
    """The files that have a word."""
    found = re.compile(rf"\b{re.escape(word)}(?!\w)")
    return [path.relative_to(ROOT).as_posix() for path, text in
            [*((path, path.read_text("utf-8")) for path in PAGES),
             *((path, texts(path.read_text("utf-8"))) for path in SOURCES)] if found.search(" ".join(text.split()))]


def test_the_table_has_words():
    assert ("Units and Conventions", "If the File Does Not Say") in WORDS
    assert len(WORDS) > 10


@pytest.mark.parametrize("word", sorted({word for _, word in WORDS}))
def test_no_text_has_a_word_that_another_has_replaced(word):
    assert where(word) == []


def test_a_word_in_an_f_string_is_noticed():
    assert "Held out" in texts('x = 1\nprint(f"Held out {x}")')


def test_a_word_in_a_tooltip_is_noticed_and_in_what_nobody_is_shown_not():
    assert "polar plot" in texts('class PT(Panel):\n    """A polar plot"""')
    assert texts('"""A polar plot."""\ndef draw():\n    """The polar plot."""') == ""


def test_the_texts_of_presets_verdicts_and_descriptions_are_looked_at():
    seen = "\n".join(texts(path.read_text("utf-8")) for path in SOURCES)
    for text in ("look development", "Not tested between measured angles", "Widest hole", "Fitting shape"):
        assert text in seen
