"""What the documentation names is there: files, modules and what they define, targets of make, links and pictures."""

import ast
import re
from fnmatch import fnmatchcase
from functools import cache

import pytest

from fitter.formats import FORMATS
from support.checkout import ROOT
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
DOTTED = re.compile(r"[A-Za-z_]\w*(?:\.[A-Za-z_]\w*)+(?<!\.blend)(?<!\.npz)(?<!\.dat)(?<!\.astm)(?<!\.png)")


def backticked(text):
    """What stands in backticks, outside blocks of code."""
    text = re.sub(r"^```.*?^```$", "", text, flags=re.DOTALL | re.MULTILINE)
    return [" ".join(quoted.split()) for quoted in re.findall(r"`([^`]+)`", text)]


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


def missing_targets(text):
    """The targets of `make` that a text names and the Makefile does not have."""
    known = set(re.findall(r"^([\w-]+):", (ROOT / "Makefile").read_text("utf-8"), re.MULTILINE))
    commands = re.findall(r"^(?:    |`|.*`)make ([a-z][\w-]*)", text, re.MULTILINE)
    commands += re.findall(r"`make ([a-z][\w-]*)", text)
    return sorted(set(commands) - known)


def missing_links(page, text):
    """The relative links and pictures of a page that lead nowhere, and those to headings that it does not have."""
    missing = []
    for link in re.findall(r"\]\(([^)\s]+)\)", re.sub(r"^```.*?^```$", "", text, flags=re.DOTALL | re.MULTILINE)):
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
    assert missing_paths(text) == []
    assert unknown_names(text) == []
    assert missing_targets(text) == []
    assert missing_links(page, text) == []


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
    (missing_targets, "    make demos  # x\n`make test`, `make tests` or make do", ["demos", "tests"]),
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


def picture_commands(text):
    """The command of each pattern of pictures in the table of `docs/pictures.md`."""
    return dict(re.findall(r"^\| `([^`]+)` \| `([^`]+)` \|$", text, re.MULTILINE))


def unexplained_pictures(commands, pictures):
    """The pictures without a command, and the patterns without a picture."""
    found = {pattern: [name for name in pictures if fnmatchcase(name, pattern)] for pattern in commands}
    explained = {name for names in found.values() for name in names}
    return sorted(set(pictures) - explained), sorted(pattern for pattern, names in found.items() if not names)


def command_exists(command):
    """Whether a command of the table is a target of make, or a module of ours with a ``main``."""
    kind, *arguments = command.split()
    if kind == "make":
        return not missing_targets(f"`make {arguments[0]}`")
    module = arguments[1].replace(".", "/")
    paths = [path for path in (ROOT / f"{module}.py", ROOT / module / "__main__.py") if path.is_file()]
    return kind == "python" and arguments[0] == "-m" and any("main" in definitions(path)[0] for path in paths)


def test_every_picture_is_made_by_a_command():
    commands = picture_commands((ROOT / "docs" / "pictures.md").read_text("utf-8"))
    pictures = [path.relative_to(ROOT / "docs").as_posix() for kind in ("png", "jpg", "svg", "webp")
                for path in (ROOT / "docs").rglob(f"*.{kind}") if "html" not in path.relative_to(ROOT / "docs").parts]
    assert len(pictures) > 30
    assert unexplained_pictures(commands, pictures) == ([], [])
    assert [command for command in commands.values() if not command_exists(command)] == []


def test_every_picture_of_the_window_has_a_driver():
    commands = picture_commands((ROOT / "docs" / "pictures.md").read_text("utf-8"))
    pictures = {path.stem for path in (ROOT / "docs" / "manual").glob("*.png") if f"manual/{path.name}" not in commands}
    assert pictures <= set(names())


def test_every_picture_is_shown_on_a_page():
    shown = {(page.parent / link).resolve() for page in PAGES
             for link in re.findall(r"!\[[^\]]*\]\(([^)\s]+)\)", page.read_text("utf-8"))}
    pictures = {path for path in (ROOT / "docs").rglob("*.png") if "html" not in path.relative_to(ROOT / "docs").parts}
    assert pictures - shown == set()


@pytest.mark.parametrize(("command", "exists"), [
    ("make title", True), ("make titles", False), ("python -m demo_scenes.title docs/title.png", True),
    ("python -m demo_scenes.titles docs/title.png", False), ("python -m demo_scenes", True),
    ("python -m support.sheet docs", False), ("convert a.png b.png", False),
])
def test_a_command_that_is_not_there_is_noticed(command, exists):
    assert command_exists(command) == exists


def test_a_picture_without_a_command_is_noticed():
    commands = picture_commands("| `a.png` | `make title` |\n| `b/*.png` | `make gallery` |\n")
    assert unexplained_pictures(commands, ["a.png", "c.png"]) == (["c.png"], ["b/*.png"])
