"""What the documentation names is there: files, modules and what they define, commands, links, pictures, tables."""

import ast
import re
import shlex
from fnmatch import fnmatchcase
from functools import cache

import pytest

from fitter.formats import FORMATS
from support.checkout import ROOT
from support.evidence import digest
from tools import evidence
from tools.docs.pages import REFERENCE
from tools.window.__main__ import names

PAGES = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").glob("*.md"), *(ROOT / "docs" / "manual").glob("*.md")])
SHADER = sorted((ROOT / "osl").iterdir())
TOP = {"addon", "benchmarks", "demo_scenes", "docs", "fitter", "osl", "support", "tests", "tools"}
GENERATED = {"baked_constants.h", "baked_tables.h", "lamp_parameters.h"}      # by the baker
# files of users, of Blender, of Cycles' source and of the build, and examples of names
NOT_OURS = re.compile(r"(build|docs/html|shared|\.\.|/tmp|src|intern|curet|cornell)/|.*[*{<]|(.*/)?(test_)?NAME(\W|$)"
                      r"|.*LIBRARY|(?i:setup)\.toml")
EXTENSIONS = r"(?:py|md|h|osl|toml|csv)"
PATH = re.compile(rf"[\w./-]+\.{EXTENSIONS}|[\w.-]+(?:/[\w.-]+)*/")
DOTTED = re.compile(r"[A-Za-z_]\w*(?:\.[A-Za-z_]\w*)+(?<!\.blend)(?<!\.npz)(?<!\.dat)(?<!\.astm)(?<!\.png)(?<!\.jpg)")


def without_blocks(text):
    """A page without its blocks of code."""
    return re.sub(r"^```.*?^```$", "", text, flags=re.DOTALL | re.MULTILINE)


def backticked(text):
    """What stands in backticks, outside blocks of code."""
    return [" ".join(quoted.split()) for quoted in re.findall(r"`([^`]+)`", without_blocks(text))]


def named_in(text):
    """The paths and dotted names among what stands in backticks, a command's arguments too, without (...) and ::..."""
    for quoted in backticked(text):
        for word in quoted.split():
            yield re.sub(r"(\(.*|::.*|[,;:])$", "", word)


def files(name):
    """The files of the checkout that a path means: from the root, or by its end where it has no folder of the root."""
    found = ROOT / name
    if found.exists() or name.split("/")[0] in TOP:
        return [found] if found.exists() else []
    return [path for path in tree() if path.endswith("/" + name.rstrip("/"))]


@cache
def tree():
    """All files and folders below those of the root, as paths with slashes."""
    return [path.as_posix() for top in sorted(TOP) for path in (ROOT / top).rglob("*")]


def missing_paths(text):
    """The paths of ours that a text names and the tree does not have."""
    names = {name for name in named_in(text) if PATH.fullmatch(name) and not NOT_OURS.match(name)}
    return sorted(name for name in names - GENERATED if not files(name))


@cache
def definitions(path):
    """The names that a Python file defines or imports, and those of each class."""
    found, classes = set(), {}
    for node in ast.parse(path.read_text("utf-8")).body:
        found |= _names(node)
        if isinstance(node, ast.ClassDef):
            classes[node.name] = set().union(*map(_names, node.body))
            classes[node.name] |= {part.attr for part in ast.walk(node) if isinstance(part, ast.Attribute)
                                   and isinstance(part.value, ast.Name) and part.value.id == "self"}
    return found, classes


def _names(node):
    if isinstance(node, ast.ClassDef | ast.FunctionDef):
        return {node.name}
    if isinstance(node, ast.Import | ast.ImportFrom):
        return {alias.asname or alias.name for alias in node.names}
    if isinstance(node, ast.If):
        return set().union(*map(_names, [*node.body, *node.orelse]))
    targets = node.targets if isinstance(node, ast.Assign) else [node.target] if isinstance(node, ast.AnnAssign) else []
    return {part.id for target in targets for part in ast.walk(target) if isinstance(part, ast.Name)}


@cache
def python_files():
    """The Python files that pages name."""
    return [path for top in sorted(TOP - {"tests", "docs", "osl"}) for path in (ROOT / top).rglob("*.py")]


@cache
def dotted():
    """The Python files by their modules' names."""
    return {path.relative_to(ROOT).with_suffix("").as_posix().replace("/", ".").removesuffix(".__init__"): path
            for path in python_files()}


def modules(parts):
    """The files of the module of this dotted name, from the root or from a package of ours."""
    name = ".".join(parts)
    return [path for known, path in dotted().items() if known == name or known.endswith("." + name)]


def is_known(name):
    """Whether a dotted name is in the tree; None where it is none of ours."""
    *before, last = name.split(".")
    if modules([*before, last]):
        return True
    if found := modules(before):
        return any(last in definitions(path)[0] for path in found)
    classes = [classes[before[-1]] for path in python_files() for classes in [definitions(path)[1]]
               if before[-1] in classes and (len(before) == 1 or path in modules(before[:-1]))]
    if classes:
        return any(last in names for names in classes)
    return False if before[0] in ("fitter", "addon", "support", "tools", "benchmarks", "demo_scenes") else None


def unknown_names(text):
    """The dotted names of ours that a text names and the tree does not have."""
    return sorted({name for name in named_in(text)
                   if DOTTED.fullmatch(name) and not PATH.fullmatch(name) and is_known(name) is False})


def commands(text):
    """What a page says to run: lines of blocks of code, without comments, and what stands in backticks."""
    fenced = "".join(re.findall(r"^```(?!text|python)\w*\n(.*?)^```$", text, re.DOTALL | re.MULTILINE))
    lines = [*fenced.splitlines(), *re.findall(r"^ {4}(\S.*)$", text, re.MULTILINE)]
    for line in (*(re.sub(r"\s+#.*", "", line) for line in lines), *backticked(text)):
        if match := re.match(r"(?:\w+=\S+ )*(make [a-z][\w-]*|python -m .*)$", line.strip()):
            yield match[1]


def missing_commands(text):
    """The commands that a page says to run and that do not exist: targets, modules, options, tests, `-k`."""
    return [command for command in commands(text) if not exists(command)]


def exists(command):
    """Whether a command is a target of make, runs tests that are there, or a module of ours with such options."""
    kind, *words = shlex.split(command)
    if kind == "make":
        return re.search(rf"^{re.escape(words[0])}:", (ROOT / "Makefile").read_text("utf-8"), re.MULTILINE) is not None
    if "NAME" in words[1] or ("NAME" in command and words[1] == "pytest"):        # of a walk
        return True
    if words[1] == "pytest":
        return has_tests(words[2:])
    module = words[1].replace(".", "/").replace("measured_brdf", "addon/work/command")
    found = [path for path in (ROOT / f"{module}.py", ROOT / module / "__main__.py") if path.is_file()]
    if words[1] == "fitter":
        found = [ROOT / "fitter" / "cli.py"]
        if words[2:] and not words[2].startswith("-") and f'add_parser("{words[2]}"' not in found[0].read_text("utf-8"):
            return False
    options = {word.partition("=")[0].lstrip("-") for word in words[2:] if word.startswith("--")} - {"help"}
    known = frozenset().union(*(words_of(path) for path in [*found, ROOT / "benchmarks" / "harness" / "running.py",
                                                            ROOT / "fitter" / "formats" / "reading.py",
                                                            ROOT / "addon" / "library" / "command.py"]))
    return bool(found) and any(word in words_of(found[0]) for word in ("main", "__main__")) and all(
        set(option.split("-")) <= known for option in options)


def has_tests(arguments):
    """Whether pytest would find what it is given, and a test for each word of `-k`."""
    paths, expression = [], ""
    for before, word in zip(["", *arguments], arguments, strict=False):
        if before == "-k":
            expression = word
        elif not word.startswith("-") and before not in ("-m", "-n"):
            paths.append(ROOT / word.partition("::")[0])
    if not all(path.exists() for path in paths):
        return False
    named = " ".join(" ".join(re.findall(r"def (test_\w+)", file.read_text("utf-8"))) + file.name for path in paths
                     for file in ([path] if path.is_file() else path.rglob("test_*.py")))
    return all(word in named for word in re.findall(r"\w+", expression) if word not in ("and", "or", "not"))


@cache
def words_of(path):
    """The words of a file."""
    return frozenset(re.findall(r"[A-Za-z_0-9]+", path.read_text("utf-8")))


def drawn_names(text):
    """The dotted names in drawings, which are blocks of text, that the tree does not have."""
    drawings = re.findall(r"^```text\n(.*?)^```$", text, re.DOTALL | re.MULTILINE)
    return [name for drawing in drawings for name in DOTTED.findall(drawing) if not is_known(name)]


def missing_links(page, text):
    """The relative links and pictures of a page that lead nowhere, and those to headings that it does not have."""
    missing = []
    for link in re.findall(r"\]\(([^)\s]+)\)", without_blocks(text)):
        if re.match(r"[a-z]+:", link):
            continue
        name, _, heading = link.partition("#")
        if name.removesuffix(".md").removeprefix("../") in REFERENCE:       # written with the site
            continue
        target = page.parent / name if name else page
        if not target.exists() or (heading and heading not in anchors(target.read_text("utf-8"))):
            missing.append(link)
    return missing


def anchors(text):
    """The headings of a page as links name them on GitHub."""
    return {re.sub(r"[^\w -]", "", heading.lower()).strip().replace(" ", "-")
            for heading in re.findall(r"^#+ (.*)$", text, re.MULTILINE)}


def shader_comments(path):
    """The comments of a shader, each file that they name in backticks, as elsewhere."""
    comments = "\n".join(re.findall(r"/\*.*?\*/", path.read_text("utf-8"), re.DOTALL))
    return re.sub(rf"(?<![`\w/])((?:fitter|addon|osl)/[\w/]+\.{EXTENSIONS})", r"`\1`", comments)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_what_a_page_names_is_there(page):
    text = page.read_text("utf-8")
    assert missing_links(page, text) == []
    assert missing_paths(text) == []
    assert unknown_names(text) == []
    assert missing_commands(text) == []
    assert drawn_names(text) == []


@pytest.mark.parametrize("path", SHADER, ids=lambda path: path.name)
def test_files_that_the_shaders_comments_name_are_there(path):
    comments = shader_comments(path)
    assert missing_paths(comments) == []
    assert unknown_names(comments) == []


@pytest.mark.parametrize(("find", "text", "found"), [
    (missing_paths, "`fitter/lattice.py` is now `fitter/lattice/dense.py`", ["fitter/lattice.py"]),
    (missing_paths, "tables of `draw_table.py`, `addon/lamps/`, `dense.py`", ["addon/lamps/", "draw_table.py"]),
    (missing_paths, "`python -m tools.x`, `../shared/data`, `build/demo/*.png`, `fitter/formats/NAME.py`", []),
    (unknown_names, "`fitter.load`, `Fit.evaluate`, `methods.fit`, `bpy.ops.x.y`, `image.pixels`", []),
    (unknown_names, "`fitter.loaded`, `Fit.evaluated`, `methods.fitted`", ["Fit.evaluated", "fitter.loaded",
                                                                           "methods.fitted"]),
    (lambda text: missing_links(ROOT / "README.md", text), "![a](docs/none.png) [b](docs/manual.md#no-such) [c](#x)"
     " [d](docs/manual.md#fit) [e](https://example.org)", ["docs/none.png", "docs/manual.md#no-such", "#x"]),
])
def test_what_is_not_there_is_found(find, text, found):
    assert find(text) == found


def test_the_page_of_formats_lists_every_format():
    page = (ROOT / "docs" / "formats.md").read_text("utf-8")
    for known in FORMATS:
        assert known.name in page, known.name
        assert any(extension in page for extension in known.extensions), known.extensions


def test_every_picture_is_made_by_an_entry_of_the_evidence():
    rows = {name: command for name, command, _ in evidence._ROW.findall(evidence.PICTURES.read_text("utf-8"))}
    made = {picture: entry.command for entry in evidence.ENTRIES.values() for picture in entry.pictures}
    assert rows.keys() == made.keys()
    assert all(made[name].startswith(command) for name, command in rows.items())
    pictures = [path.relative_to(ROOT / "docs").as_posix() for kind in ("png", "jpg", "svg", "webp")
                for path in (ROOT / "docs").rglob(f"*.{kind}") if "html" not in path.relative_to(ROOT / "docs").parts]
    assert [name for name in pictures if not any(fnmatchcase(name, pattern) for pattern in rows)] == []
    shown = {(page.parent / link).resolve() for page in PAGES
             for link in re.findall(r"!\[[^\]]*\]\(([^)\s]+)\)", page.read_text("utf-8"))}
    assert {name for name in pictures if name.endswith(".png")} - {
        path.relative_to(ROOT / "docs").as_posix() for path in shown} == set()
    window = {path.stem for path in (ROOT / "docs" / "manual").glob("*.png") if f"manual/{path.name}" not in rows}
    assert window <= set(names())


def test_every_mark_is_of_an_entry_and_every_table_stands_somewhere():
    stated = [name for page in evidence.PAGES for name, _ in evidence.states(page.read_text("utf-8"))]
    tables = [table for entry in evidence.ENTRIES.values() for table in entry.tables]
    assert set(stated) == set(tables)
    assert len(tables) == len(set(tables))
    for page in evidence.PAGES:             # at the beginning of a line, a mark ends its paragraph
        assert re.findall(r"^<!-- evidence: [^>]*-->(?!\n)", page.read_text("utf-8"), re.MULTILINE) == [], page
    for entry in evidence.ENTRIES.values():
        assert entry.measured
        assert missing_commands(f"`{entry.command}`") == []
        assert all((ROOT / path).exists() for path in entry.measured)


def test_a_table_is_written_between_its_marks_and_is_old_when_its_files_change(tmp_path, monkeypatch):
    page = "a <!-- evidence: x 12ab -->1<!-- /evidence --> b\n<!-- evidence: y -->\n\n2\n<!-- /evidence -->\n"
    new = evidence.written(page, evidence.printed("noise <!-- evidence: y -->\n\n3\n<!-- /evidence -->"), "cd34")
    assert new == page.replace("y -->", "y cd34 -->").replace("2\n", "3\n")
    assert evidence.states(new) == [("x", "12ab"), ("y", "cd34")]
    source = tmp_path / "a.py"
    source.write_text("x = 1\n")
    monkeypatch.setattr("support.evidence.ROOT", tmp_path)
    before = digest(["a.py"])
    source.write_text('"""What it is."""\n\nx = 1  # one\n')
    assert digest(["a.py"]) == before
    source.write_text("x = 2\n")
    assert digest(["a.py"]) != before


@pytest.mark.parametrize(("command", "exists"), [
    ("make test", True), ("make tests", False), ("python -m demo_scenes.title --out x", True),
    ("python -m demo_scenes.titles", False), ("python -m demo_scenes.title --outs x", False),
    ("python -m support.sheet docs", False), ("python -m fitter fit x.astm --preset Draft", True),
    ("python -m fitter fits x", False), ("python -m benchmarks.held_out --half chosen --sets felt", True),
    ('python -m pytest tests/osl/test_mixture.py -k "mixture or densit"', True),
    ("python -m pytest tests/osl/test_mixture.py -k nothing_like_it", False),
    ("python -m pytest tests/none.py", False)])
def test_a_command_that_is_not_there_is_noticed(command, exists):
    assert (missing_commands(f"`{command}`") == []) == exists
    assert (missing_commands(f"text\n\n    {command}      # why\n") == []) == exists


def test_names_in_a_drawing_are_those_of_the_code():
    assert drawn_names("```text\n  |  methods.fit\n  |  materials.compiler.compile_shader\n```") == [
        "materials.compiler.compile_shader"]
