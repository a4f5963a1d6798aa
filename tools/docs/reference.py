"""The reference pages: the public names of `fitter`, the operators as Blender has registered them, the commands."""

import argparse
import inspect
import os
import re
from collections import Counter
from collections.abc import Iterator

import bpy

import fitter
from fitter import cli
from fitter.formats.reading import OPTIONS
from fitter.methods.presets import PRESET_DESCRIPTIONS, PRESETS
from support.checkout import extension

_OPERATORS = """# Operators

What scripts and shortcuts call, as Blender {blender} registers it. All of them need the extension, not a window; those
that fit return when the fit is there if they are called by scripts, and go on in the background from the interface.
"""
_MANY = 4       # operators that share an argument
_PYTHON = """# Python

`fitter` needs NumPy only, not Blender: `import fitter` in a checkout. Angles are in radians, reflectance in 1/sr, and
arrays have one row a pair of directions. [Five-minute start](../start.md#in-scripts) has the shortest example.

```{eval-rst}
.. py:module:: fitter
```
"""
_COMMANDS = """# Command line

The text of `--help`. `python -m fitter` needs Python and NumPy; `measured_brdf` needs Blender or the `bpy` module, and
in a checkout of the project is `python .`.
"""


def python() -> str:
    """Every public name of `fitter`, with its docstring."""
    kinds: dict[str, list[str]] = {"Functions": [], "Classes": [], "Exceptions": [], "Data": []}
    for name in fitter.__all__:
        value = getattr(fitter, name)
        if not inspect.isclass(value):
            kinds["Functions" if callable(value) else "Data"].append(name)
        else:
            kinds["Exceptions" if issubclass(value, Exception) else "Classes"].append(name)
    parts = [_PYTHON]
    directives = {"Functions": "autofunction", "Classes": "autoclass", "Exceptions": "autoexception", "Data": "py:data"}
    for kind, names in kinds.items():
        parts.append(f"\n## {kind}\n")
        for name in sorted(names, key=str.lower):
            options = {"Classes": "\n   :members:", "Data": "\n   :module: fitter"}.get(kind, "")
            target = name if kind == "Data" else f"fitter.{name}"
            parts.append(f"\n```{{eval-rst}}\n.. {directives[kind]}:: {target}{options}\n```\n")
            parts.append(_TABLES.get(name, str)())
    return "".join(parts)


def _presets() -> str:
    rows = "".join(f"| {name} | {meaning}. | `{PRESETS[name]}` |\n" for name, meaning in PRESET_DESCRIPTIONS.items())
    return f"\nNamed keyword arguments of `fit`.\n\n| Key | For | Value |\n| --- | --- | --- |\n{rows}"


def _options() -> str:
    rows = "".join(f"| `{name}` | {', '.join(f'`{value!r}`' for value in option.values) or 'text'} | "
                   f"`{option.default!r}` | {_sentence(option.tooltip)} |\n" for name, option in OPTIONS.items())
    return f"\nIts options:\n\n| Option | Values | Default | Meaning |\n| --- | --- | --- | --- |\n{rows}"


_TABLES = {"PRESETS": _presets, "load": _options}
"""What stands below a name."""


def operators() -> str:
    """Every operator that the extension registers, with its arguments; those of many operators once, at the end."""
    known = {name: getattr(bpy.ops.measured_brdf, name).get_rna_type() for name in sorted(dir(bpy.ops.measured_brdf))}
    counts = Counter(row for rna in known.values() for row in _arguments(rna).items())
    shared = {name: text for (name, text), count in counts.items() if count >= _MANY}
    parts = [_OPERATORS.format(blender=".".join(map(str, bpy.app.version[:2])))]
    for name, rna in known.items():
        parts.append(f"\n## {name}\n\n**{_text(rna.name)}**. {_sentence(rna.description)}\n")
        arguments = _arguments(rna)
        own = {key: text for key, text in arguments.items() if shared.get(key) != text}
        rest = ", ".join(f"`{key}`" for key in arguments if key not in own)
        shown = ", ".join([*own, *(["..."] if rest else [])])
        parts.append(f"\n```python\nbpy.ops.measured_brdf.{name}({shown})\n```\n\n")
        parts += [f"- {text}\n" for text in own.values()]
        parts.append(f"- {rest}: [as elsewhere](#shared-arguments)\n" if rest else "")
    parts.append("\n## Shared arguments\n\n")
    return "".join([*parts, *(f"- {text}\n" for text in shared.values())])


def _arguments(rna: bpy.types.Struct) -> dict[str, str]:
    return {argument.identifier: _argument(argument) for argument in rna.properties
            if argument.identifier not in ("rna_type", "filter_glob")}


def _argument(argument: bpy.types.Property) -> str:
    """An argument of an operator: its name, default, meaning and choices."""
    default = "" if argument.type in {"COLLECTION", "POINTER"} else _default(argument)
    meaning = _sentence(argument.description or (argument.name if argument.name != argument.identifier else ""))
    if argument.type == "ENUM":
        choices = ", ".join(f"`{item.identifier}`" for item in argument.enum_items)
        meaning += f" One of {choices}." if choices else ""
    elif argument.type in {"INT", "FLOAT"} and argument.hard_max < 1e6:
        meaning += f" From {argument.hard_min:g} to {argument.hard_max:g}."
    return f"`{argument.identifier}`{' = ' + default if default else ''}{': ' if meaning else ''}{meaning.strip()}"


def _default(argument: bpy.types.Property) -> str:
    if argument.type == "ENUM" and not len(argument.enum_items):
        value: object = ""          # its items depend on what is open
    elif argument.type == "ENUM":
        value = sorted(argument.default_flag) if argument.is_enum_flag else argument.default
    elif getattr(argument, "is_array", False):
        value = tuple(float(f"{number:.6g}") for number in argument.default_array)
    else:
        value = float(f"{argument.default:.6g}") if argument.type == "FLOAT" else argument.default
    return "" if value == "" and argument.type == "ENUM" else f"`{value!r}`".replace('"', "'")


def _sentence(text: str) -> str:
    text = _text(text)
    return text if not text or text.endswith((".", "?", "!")) else text + "."


def _text(text: str) -> str:
    """Text of the interface, as Markdown."""
    return re.sub(r"([\\`*_{}\[\]<>|$])", r"\\\1", " ".join(text.split()))


def command_line() -> str:
    """The help of every command."""
    from measured_brdf.addon.work import command

    parts = [_COMMANDS]
    for title, parser in (("fitter", cli.build_parser()), ("measured_brdf", command.build_parser())):
        parts.append(f"\n## {title}\n\n```text\n{_help(parser)}```\n")
        for name, sub in _commands(parser):
            parts.append(f"\n### {title} {name}\n\n```text\n{_help(sub)}```\n")
    return "".join(parts)


def _commands(parser: argparse.ArgumentParser) -> Iterator[tuple[str, argparse.ArgumentParser]]:
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            yield from ((shown.dest, action.choices[shown.dest]) for shown in action._choices_actions)


def _help(parser: argparse.ArgumentParser) -> str:
    """The help, of the same width on every terminal and without its colours."""
    os.environ["COLUMNS"], os.environ["NO_COLOR"] = "88", "1"
    return parser.format_help()


def pages() -> dict[str, str]:
    """The text of each page, by its name."""
    package = extension()
    package.register()
    try:
        return {"reference/python.md": python(), "reference/operators.md": operators(),
                "reference/command_line.md": command_line()}
    finally:
        package.unregister()
