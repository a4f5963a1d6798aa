"""What pages say of the code is so: names and their files, layers, what is free of bpy, numbers, interface labels."""

import ast
import re
from functools import cache

import pytest

from fitter import shader_constants as shader
from fitter.coordinates import half_angle
from fitter.coordinates.half_difference import HALF_DIFFERENCE_SOFTENING
from fitter.cycles import direction_grid, node_mixture
from fitter.methods import gaussian_process, lattices, prior, regression_kriging
from fitter.methods.presets import PRESETS
from fitter.model.microfacet import MAX_PRIOR_LOBES
from support.checkout import ROOT

from . import test_docs
from .test_docs import NOT_OURS, PATH, files, named_in, without_blocks
from .test_layers import LAYERS, imports

PAGES = {path.relative_to(ROOT).as_posix(): path.read_text("utf-8") for path in test_docs.PAGES}
MANUAL = [page for page in PAGES if page in ("README.md", "docs/start.md", "docs/manual.md", "docs/formats.md")
          or page.startswith("docs/manual/")]
CYCLES = {"docs/devices.md"}                # names what is in the sources of Cycles and Blender
IDENTIFIER = re.compile(r"([A-Za-z_]\w*)(\(.*\))?")
OWN = re.compile(r"_\w+|[A-Z][A-Z0-9_]*[A-Z0-9]")       # a constant, or a private name
NOT_NAMES = {"NAME", "FILE", "PRESET"}
SUFFIXES = (".py", ".h", ".osl", ".toml")
BLENDER = {"bpy", "blf", "bmesh", "bpy_extras", "gpu", "gpu_extras", "mathutils", "_cycles"}
# names in Blender that the manual leads through, and words in bold that are no names
BLENDERS_OWN = {"File", "Import", "Edit", "Preferences", "Get Extensions", "the arrow at the top right", "Add-ons",
                "Install from Disk", "Properties", "Material", "Image", "Save As", "F3", "Shift+A", "Color Management",
                "Render properties", "Light", "Light Paths", "Filter Glossy", "External Data", "Unpack Resources",
                "Bake"}
EMPHASISED = {"published fits, not measurements", "exactly", "Untested", "The sphere", "The curves", "The numbers",
              "The lobe", "The normal", "The plot", "Documentation", "Known limits.", "Files", "Materials", "Looking",
              "Editing", "Light", "Engines", "Reuse",
              "Do not mix it with a Principled BSDF, Glass or another measured material there"}


def blocks(text):
    """Paragraphs, items of lists and rows of tables, each of which names files and what is in them."""
    return re.split(r"\n\s*\n|\n(?=\s*(?:[-*]|\d+\.) )|\n(?=\|)", without_blocks(text))


@cache
def words(path):
    return frozenset(re.findall(r"\w+", path.read_text("utf-8"))) if path.is_file() else frozenset().union(
        *(words(each) for each in path.rglob("*") if each.suffix in SUFFIXES))


@cache
def words_of_all():
    """The words of all sources but these two tests, whose examples are names that are not there."""
    folders = [ROOT / name for name in ("addon", "benchmarks", "demo_scenes", "fitter", "osl", "support", "tools")]
    others = [path for path in (ROOT / "tests").rglob("*.py") if path.name not in ("test_docs.py", "test_pages.py")]
    return frozenset().union(*map(words, [*folders, *others, ROOT / "Makefile", ROOT / "pyproject.toml"]))


def names_that_are_not_there(text):
    """The names that no source has, and constants and private names that no file has of those named beside them."""
    found = set()
    for block in blocks(text):
        named = [ROOT / path for name in named_in(block) if PATH.fullmatch(name) and not NOT_OURS.match(name)
                 for path in files(name)]
        beside = frozenset().union(*(words(path) for path in named if path.is_dir() or path.suffix in SUFFIXES))
        for quoted in re.findall(r"`([^`]+)`", block):
            match = IDENTIFIER.fullmatch(" ".join(quoted.split()))
            known = beside if OWN.fullmatch(quoted) and beside else beside | words_of_all()
            if match and match[1] not in known | NOT_NAMES:
                found.add(match[1])
        for name, path in re.findall(r"`([A-Za-z_]\w*)`\s+(?:in|of)\s+`([\w./]+)`", block):
            if PATH.fullmatch(path) and not any(name in words(ROOT / each) for each in files(path)):
                found.add(name)
    return sorted(found)


@pytest.mark.parametrize("page", sorted(PAGES.keys() - CYCLES))
def test_names_are_in_the_files_that_a_page_says_they_are_in(page):
    assert names_that_are_not_there(PAGES[page]) == []


@pytest.mark.parametrize(("text", "found"), [
    ("1. `fitter/shader_constants.py`: `KNOTS` and `GRAZING`\n2. `_choose` and `fit(samples)`", []),
    ("1. `fitter/shader_constants.py`: `EXPONENT_9`, which no source has; `nowhere_defined`",
     ["EXPONENT_9", "nowhere_defined"]),
    ("| `_choose` of `fitter/cycles/bake.py` |\n| `_choose` of `fitter/cycles/node_mixture.py` |", ["_choose"]),
    ("`_choose` in `fitter/cycles/bake.py`, beside `fitter/cycles/node_mixture.py`", ["_choose"])])
def test_a_name_that_is_not_there_is_noticed(text, found):
    assert names_that_are_not_there(text) == found


def layers_of(text):
    """The parts of each package of `LAYERS` that the page's tables have, a set for each row."""
    found = {package: [] for package in LAYERS}
    for row in re.findall(r"^\| (`(?:fitter|addon)/[^|]*) \| [^|]* \|$", text.partition("\n## Layers")[2].partition(
            "\n## ")[0], re.MULTILINE):
        named = [name.removesuffix(".py").strip("/").rpartition("/") for name in re.findall(r"`([^`]+)`", row)]
        found[named[0][0]].append({name for _, _, name in named})
    return found


def out_of_order(rows, layers):
    """Which names rows lack or have too many, and which pairs stand the other way round than in the layers."""
    height = {name: number for number, layer in enumerate(layers) for name in layer if not name.startswith("__")}
    place = {name: number for number, row in enumerate(rows) for name in row}
    wrong = sorted(height.keys() ^ place.keys())
    return wrong + [(low, high) for low in place for high in place if low in height and high in height
                    and height[low] < height[high] and place[low] > place[high]]


def test_the_page_has_the_layers_that_the_imports_keep():
    found = layers_of(PAGES["docs/architecture.md"])
    assert {package: out_of_order(rows, LAYERS[package]) for package, rows in found.items()} == {
        package: [] for package in LAYERS}


def at_import(source):
    """What of a source runs when it is imported, without what is for type checkers."""
    body = [node for node in ast.parse(source).body if not isinstance(node, ast.FunctionDef | ast.ClassDef)
            and not (isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test))]
    return ast.unparse(ast.Module(body, []))


@cache
def without_bpy():
    """The modules of `addon` that import nothing of Blender's, nor does what they import; `addon` itself left out,
    which worker processes do not import."""
    sources = {path.relative_to(ROOT).as_posix(): path for path in (ROOT / "addon").rglob("*.py")}
    modules = {name.removesuffix(".py").removesuffix("/__init__").replace("/", "."): name for name in sources}
    imported = {}
    for name, path in sources.items():
        found = list(imports(name, at_import(path.read_text("utf-8"))))
        parts = {".".join(module[:end]) for module in found for end in range(2, len(module) + 1)}
        imported[name] = {modules[part] for part in parts & modules.keys()} | {
            module[0] for module in found if module[0] in BLENDER}
    need = set(BLENDER)
    while more := {name for name in sources if name not in need and imported[name] & need}:
        need |= more
    return {name for name in sources if name not in need and not name.endswith("__init__.py")}


def test_what_the_page_calls_free_of_bpy_is():
    sentence = re.search(r"\n\nFree of `bpy`.*?\n\n", PAGES["docs/architecture.md"], re.DOTALL)[0]
    said = {name for name in named_in(sentence) if name.endswith(".py")}
    assert len(said) > 5
    assert said - without_bpy() == set()
    assert {name for name in without_bpy() if name.startswith("addon/work/")} - said == set()


def test_an_import_of_bpy_through_another_module_is_noticed():
    assert "addon/work/process.py" not in without_bpy()             # imports bpy
    assert "addon/inspect/inspection.py" not in without_bpy()      # imports surface.py, which does
    assert "addon/core/annotations.py" in without_bpy()                  # for type checkers only


def count(number):
    return f"{number:,}"


# a page, what it says around a number, and the number
NUMBERS = (
    ("docs/rendering.md", r"hands the shader up to (\d+) lamps", shader.MAX_LAMPS),
    ("docs/rendering.md", r"Of more than (\w+) lamps above the horizon", {4: "four"}.get(shader.MAX_LOBES)),
    ("docs/rendering.md", r"numbers for each of (\d+) polar angles", direction_grid.OUTGOING_COUNT),
    ("docs/rendering.md", r"and up to\s+(\w+) others, of `diffuse`", {6: "six"}.get(node_mixture.CYCLES.lobes)),
    ("docs/fitting.md", r"A Gaussian process takes ([\d,]+) samples",
     count(regression_kriging.MAX_GAUSSIAN_PROCESS_SAMPLES)),
    ("docs/fitting.md", r"softening radius of ([\d.]+)", HALF_DIFFERENCE_SOFTENING),
    ("docs/fitting.md", r"at most (\w+) lobes", {3: "three"}.get(MAX_PRIOR_LOBES)),
    ("docs/fitting.md", r"likelihood of (\d+) samples", regression_kriging._SEARCHED),
    ("docs/fitting.md", r"([\d,]+) directions between", count(lattices._BETWEEN)),
    ("docs/fitting.md", r"Of more than ([\d,]+) samples", count(regression_kriging.MAX_GAUSSIAN_PROCESS_SAMPLES)),
    ("docs/fitting.md", r"a softening radius delta of ([\d.]+\d)", half_angle.RELATIVE_SOFTENING),
    ("docs/fitting.md", r"or to ([\d,]+) of them", count(lattices.MAX_STRATIFIED)),
    ("docs/fitting.md", r"At most ([\d,]+) control points of a lattice", count(lattices._MOST_UNKNOWNS)),
    ("docs/fitting.md", r"one of (\w+) starts", {7: "seven"}.get(len(prior._STARTS))),
    ("docs/fitting.md", r"Standard` is D = 4, S = 5 and C = ([\d.]+\d)", PRESETS["Standard"]["compression"]),
    *(("docs/fitting.md", rf"\| {name} \|[^|]*\| ([^|]*) \|", ", ".join(f"{value:g}" for value in values))
      for name, values in (("stretch", regression_kriging._TRIED_STRETCHES), ("length", gaussian_process.LENGTHS),
                           ("noise", gaussian_process.NOISES))))


def numbers_said(text, pattern):
    found = re.search(pattern.replace(" ", r"\s+"), text)
    return None if found is None else found[1]


@pytest.mark.parametrize(("page", "pattern", "number"), NUMBERS, ids=[number[1] for number in NUMBERS])
def test_a_page_has_the_number_that_the_code_has(page, pattern, number):
    assert numbers_said(PAGES[page], pattern) == str(number)


@cache
def labels():
    """The texts of the interface, as far as sources have them in one piece."""
    found = set()
    for path in [*(ROOT / "addon").rglob("*.py"), ROOT / "fitter" / "methods" / "presets.py",
                 *(ROOT / "fitter" / "quality" / f"{name}.py" for name in ("describe", "verdict"))]:
        tree = ast.parse(path.read_text("utf-8"))
        documented = [node for node in ast.walk(tree) if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef)]
        comments = {id(node.body[0].value) for node in documented if isinstance(node.body[0], ast.Expr)}
        texts = {node.value for node in ast.walk(tree) if isinstance(node, ast.Constant)
                 and isinstance(node.value, str) and id(node) not in comments}
        found |= {part.removesuffix("...") for text in texts if len(text) < 60
                  for part in (text, *re.split(r"[.:] ", text)) if part[:1].isupper()}
    return found


def unknown_labels(text):
    """The words in bold, and the steps of a way through menus (A > B), that neither we nor Blender have."""
    text = re.sub(r"^ {4}.*$", "", without_blocks(text), flags=re.MULTILINE)
    known = {label.strip() for label in labels() | BLENDERS_OWN}
    folded = {label.casefold() for label in known}
    bold = {" ".join(step.split()) for words in re.findall(r"\*\*([^*]+)\*\*", text)
            for step in words.split(" > ")} - EMPHASISED
    unknown = {words for words in bold if words.removesuffix("...").casefold() not in folded}
    flat = " ".join(re.sub(r"\*\*|`", "", text).split())
    for sign in re.finditer(r" > ", flat):
        before, after = flat[:sign.start()], flat[sign.end():]
        if not any(before.endswith(label) for label in known):
            unknown.add(before[-20:])
        label = max((each for each in known if re.match(re.escape(each) + r"(?!\w)", after)), key=len, default=None)
        if label is None or (after.startswith(f"{label} (") and any(each.startswith(f"{label} (") for each in known)):
            unknown.add(after[:30])
    return unknown


@pytest.mark.parametrize("page", MANUAL)
def test_the_manual_names_what_the_interface_has(page):
    assert unknown_labels(PAGES[page]) == set()


def test_a_label_that_the_interface_lacks_is_noticed():
    assert unknown_labels("**Enable OSL**, **exactly**, File > Import > Measured BRDFs (folder).") == set()
    assert unknown_labels("    code\n\nPress **Enable OSL2**.") == {"Enable OSL2"}
    assert unknown_labels("File > Import > Measured BRDF (CURET, pbrt-v2) reads") == {"Measured BRDF (CURET, pbrt-v2)"}
