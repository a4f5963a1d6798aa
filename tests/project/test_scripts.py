"""Benchmarks, tools and demos, which most checks do not run: what they take from modules of the project is there."""

import ast
import importlib
from contextlib import suppress
from types import ModuleType

import pytest

from support.checkout import ROOT

OURS = "benchmarks", "demo_scenes", "fitter", "support", "tools"
APART = "mitsuba_scene",        # needs what only `make test-mitsuba` installs
SCRIPTS = sorted(path for folder in OURS if folder != "fitter" for path in (ROOT / folder).rglob("*.py"))


def members(module, names):
    """What an import of names from a module gives: (name, object or None)."""
    loaded = importlib.import_module(module)
    for name in names:
        if not hasattr(loaded, name) and hasattr(loaded, "__path__"):
            with suppress(ModuleNotFoundError):
                importlib.import_module(f"{module}.{name}")
        yield name, getattr(loaded, name, None)


@pytest.mark.parametrize("path", SCRIPTS, ids=lambda path: str(path.relative_to(ROOT)))
def test_what_a_script_takes_from_the_project_is_there(extension, path):
    if path.stem in APART:
        pytest.skip("needs Mitsuba")
    tree, modules, package = ast.parse(path.read_text("utf-8")), {}, path.relative_to(ROOT).parent.parts
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom):
            parts = [*package[:len(package) + 1 - node.level]] if node.level else []
            module = ".".join([*parts, *filter(None, [node.module])])
            if module.split(".")[0] in OURS:
                names = {each.name: each.asname or each.name for each in node.names if each.name not in APART}
                for name, value in members(module, names):
                    assert value is not None, f"{path}:{node.lineno}: {module} has no {name}"
                    if isinstance(value, ModuleType):
                        modules[names[name]] = value
    assigned = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)}
    assigned |= {node.arg for node in ast.walk(tree) if isinstance(node, ast.arg)}
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id not in assigned:
            module = modules.get(node.value.id)
            assert module is None or hasattr(module, node.attr), f"{path}:{node.lineno}: no {node.value.id}.{node.attr}"
