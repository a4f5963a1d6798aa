"""Imports go downward: the packages of `fitter` and `addon` in layers, and the headers of `osl`, read from sources."""

import ast
import re

import pytest

from support.checkout import ROOT
from support.evidence import BAKED
from tools.evidence import ENTRIES

# from low to high; parts of one layer do not import one another
FITTER = (("arrays", "errors", "interrupts", "shader_constants"),
          ("colours", "least_squares", "progress", "storage"), ("optics",), ("samples",), ("coordinates", "lattice"),
          ("model",), ("quality",), ("methods",), ("imaging",), ("cycles", "formats", "photographs"),
          ("library", "report"),
          ("__init__",), ("cli",), ("__main__",))
ADDON = (("core",), ("work",), ("panel",),
         ("adjust", "baking", "compare", "importing", "inspect", "library", "mix", "photographs", "starter"),
         ("__init__",))
# the rooms of `addon/core`
CORE = (("annotations", "manual", "registration", "versions"), ("blender",), ("storage",), ("lamps",), ("shading",),
        ("libraries",), ("checks", "preferences"), ("__init__",))
# and of `fitter/photographs`
PHOTOGRAPHS = (("description",), ("pictures",), ("rig",), ("ball",), ("flat",),
               ("capture", "report"), ("__init__",))
LAYERS = {"fitter": FITTER, "fitter/photographs": PHOTOGRAPHS, "addon": ADDON, "addon/core": CORE}
FORBIDDEN = {"fitter": {"addon", "benchmarks", "bpy", "bpy_extras", "bmesh", "mathutils", "cycles", "_cycles"},
             "addon": {"benchmarks"}}
# what is run, by those who run it, is not a library for the others; what they share is in `support`
NOT_SHARED = {"support": {"tools", "benchmarks", "demo_scenes", "tests"}, "benchmarks": {"demo_scenes"},
              "tools": {"demo_scenes"}}


def imports(path, source):
    """What a file imports, as tuples of names: ``('fitter', 'lattice', 'dense')``."""
    package = path.split("/")[:-1]
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            yield from (tuple(alias.name.split(".")) for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and not node.level:
            yield tuple((node.module or "").split("."))
        elif isinstance(node, ast.ImportFrom):
            base = (*package[:len(package) - node.level + 1], *(node.module.split(".") if node.module else ()))
            yield from ((*base, alias.name) for alias in node.names)


def is_in(package, module):
    """Whether a module, as a tuple of names, is below a package of `LAYERS`."""
    names = tuple(package.split("/"))
    return module[:len(names)] == names


def part(package, module):
    """The entry of `LAYERS` that a module below a package belongs to."""
    names, below = {name for layer in LAYERS[package] for name in layer}, module[package.count("/") + 1:]
    return below[0] if below and below[0] in names else "__init__"


def violations(path, source):
    """The imports of a file that go upward or sideways, in each package that it is in."""
    module = tuple(path.removesuffix(".py").split("/"))
    wrong = [".".join(imported) for imported in imports(path, source) if imported[0] in FORBIDDEN[module[0]]]
    for package, layers in LAYERS.items():
        if not is_in(package, module):
            continue
        height = {name: number for number, layer in enumerate(layers) for name in layer}
        own = part(package, module)
        for imported in imports(path, source):
            other = part(package, imported) if is_in(package, imported) else own
            if other != own and height[other] >= height[own]:
                wrong.append(".".join(imported))
    return wrong


def not_shared(path, source):
    """The imports of a file from a package that it should know nothing of."""
    forbidden = NOT_SHARED[path.split("/")[0]]
    return [".".join(imported) for imported in imports(path, source) if imported[0] in forbidden]


SOURCES = sorted({str(path.relative_to(ROOT).as_posix()) for package in LAYERS
                  for path in (ROOT / package).rglob("*.py")})


# what takes fits and makes none, and of what fits and bakes that on which no number depends
NO_FITS = "fitter/methods/editing.py", "fitter/methods/tolerance.py", "fitter/cycles/metallic_roughness.py"
NO_NUMBERS = ("fitter/errors.py", "fitter/storage/files.py", "fitter/storage/npz.py", "fitter/progress.py",
              "fitter/quality/albedo.py")


@pytest.mark.parametrize(("first", "known", "least"), [
    (("fitter/methods", "fitter/cycles"), BAKED, 30),
    (("fitter/photographs/flat/maps.py",), ENTRIES["flat"].measured, 15),
    (("fitter/photographs/ball/measuring.py",), ENTRIES["photographs"].measured, 15),
])
def test_what_evidence_and_kept_fits_depend_on_is_all_that_makes_their_numbers(first, known, least):
    files = [path.relative_to(ROOT).as_posix() for name in first
             for path in ([ROOT / name] if name.endswith(".py") else (ROOT / name).rglob("*.py"))]
    files = [path for path in files if path not in NO_FITS]
    for path in files:          # it grows
        for imported in imports(path, (ROOT / path).read_text("utf-8")):
            module = "/".join(imported)
            files += [each for each in (f"{module}.py", f"{module.rpartition('/')[0]}.py", f"{module}/__init__.py")
                      if (ROOT / each).is_file() and each not in files]
    assert len(files) > least
    assert [path for path in files if not path.startswith((*known, *NO_NUMBERS))] == []


def test_modules_import_only_lower_layers():
    wrong = {path: violations(path, (ROOT / path).read_text("utf-8")) for path in SOURCES}
    assert {path: imported for path, imported in wrong.items() if imported} == {}


def test_photographs_can_be_taken_out():
    """Nothing imports them but the command line, the public names and their slice of the add-on."""
    importers = {path for path in SOURCES for imported in imports(path, (ROOT / path).read_text("utf-8"))
                 if is_in("fitter/photographs", imported) and not path.startswith("fitter/photographs/")}
    assert {path for path in importers if not path.startswith("addon/photographs/")} == {
        "fitter/__init__.py", "fitter/cli.py"}


def cycles(imported):
    """The modules that import themselves by way of others, for types too, of {module: modules that it imports}."""
    reached = {module: set(each) for module, each in imported.items()}
    for _ in imported:      # paths grow by one import each time
        reached = {module: each.union(*(reached[other] for other in each)) for module, each in reached.items()}
    return [module for module in imported if module in reached[module]]


def test_no_module_imports_itself_by_way_of_others():
    modules = {path.removesuffix(".py").removesuffix("/__init__"): path for path in SOURCES}
    for package in ("fitter", "addon"):
        known = {module for module in modules if module.startswith(f"{package}/")}
        imported = {}
        for module in known:
            names = imports(modules[module], (ROOT / modules[module]).read_text("utf-8"))
            found = {"/".join(each) if "/".join(each) in known else "/".join(each[:-1]) for each in names}
            imported[module] = (found & known) - {module}
        assert sum(map(len, imported.values())) > 200
        assert cycles(imported) == []


def test_a_cycle_of_imports_is_noticed():
    assert cycles({"fit": {"fit_file", "edit"}, "fit_file": {"npz"}, "edit": set(), "npz": {"fit"}}) == [
        "fit", "fit_file", "npz"]
    assert cycles({"fit": {"fit_file"}, "fit_file": set()}) == []


def test_every_file_and_folder_has_a_layer():
    for package, layers in LAYERS.items():
        found = {item.stem for item in (ROOT / package).iterdir()
                 if item.suffix == ".py" or (item / "__init__.py").exists()}
        assert found == {name for layer in layers for name in layer}


def test_formats_know_samples_and_no_fit():
    known = ("arrays", "colours", "coordinates", "errors", "formats", "model.published", "samples", "storage")
    for path in SOURCES:
        if path.startswith("fitter/formats/"):
            for module in imports(path, (ROOT / path).read_text("utf-8")):
                name = ".".join(module[1:]) + "."
                assert module[0] != "fitter" or name.startswith(tuple(f"{each}." for each in known)), (path, module)


def test_what_is_shared_is_imported_from_support():
    for package in NOT_SHARED:
        for path in (ROOT / package).rglob("*.py"):
            assert not_shared(path.relative_to(ROOT).as_posix(), path.read_text("utf-8")) == [], path


@pytest.mark.parametrize("path", ["addon/core/storage/outcomes.py",
                                  "addon/photographs/work.py", "addon/starter/thumbnails.py", "addon/starter/work.py",
                                  *(f"addon/work/{name}.py" for name in (
                                      "discovery", "job", "recent", "shared", "tasks", "worker"))])
def test_what_worker_processes_import_does_not_need_blender(path):
    assert "bpy" not in {module[0] for module in imports(path, (ROOT / path).read_text("utf-8"))}


def header_faults(headers):
    """Of headers, {name: text}: what includes back, and names of others that are used and not included."""
    code = {name: re.sub(r"/\*.*?\*/", "", text, flags=re.DOTALL) for name, text in headers.items()}
    direct = {name: [each for each in re.findall(r'#include "(\w+\.h)"', text) if each in headers]
              for name, text in code.items()}
    includes = {name: set(each) for name, each in direct.items()}
    for _ in headers:       # paths grow by one include each time
        includes = {name: each.union(*(includes[other] for other in each)) for name, each in includes.items()}
    defines = {name: set(re.findall(r"^(?:# *define |struct |(?:closure )?\w+ (?=\w+\())(\w+)", text, re.MULTILINE))
               for name, text in code.items()}
    faults = [f"{name} includes itself" for name in headers if name in includes[name]]
    for name, text in code.items():
        words = set(re.findall(r"\w+", re.sub(r"#include.*", "", text))) - defines[name]
        faults += [f"{name} uses {word} of {other}" for other in sorted(headers.keys() - includes[name] - {name})
                   for word in sorted(words & defines[other])]
    return faults


def test_headers_of_the_shader_include_what_they_use_and_none_includes_back():
    assert header_faults({path.name: path.read_text("utf-8") for path in (ROOT / "osl").iterdir()}) == []


@pytest.mark.parametrize(("headers", "faults"), [
    ({"a.h": "float a()\n", "b.h": '#include "a.h"\nfloat b() { a(); }'}, []),
    ({"a.h": "#define A 1\n", "b.h": "float b() { return A; }"}, ["b.h uses A of a.h"]),
    ({"a.h": "struct A {\n", "b.h": '#include "a.h"\n', "c.h": '#include "b.h"\nfloat c(A one)'}, []),
    ({"a.h": '#include "b.h"\n', "b.h": '#include "a.h"\n'}, ["a.h includes itself", "b.h includes itself"]),
    ({"a.h": "float a()\n", "b.h": "/* as a() */"}, []),
])
def test_a_header_that_includes_too_little_or_itself_is_noticed(headers, faults):
    assert header_faults(headers) == faults


@pytest.mark.parametrize(("path", "source", "wrong"), [
    ("fitter/lattice/dense.py", "from ..methods import fit", ["fitter.methods.fit"]),
    ("fitter/lattice/dense.py", "def f():\n    from .. import methods", ["fitter.methods"]),
    ("fitter/model/fit.py", "from .. import load", ["fitter.load"]),
    ("fitter/cycles/bake.py", "from ..formats import load", ["fitter.formats.load"]),
    ("fitter/samples.py", "import bpy", ["bpy"]),
    ("fitter/cli.py", "from benchmarks import report", ["benchmarks"]),
    ("fitter/samples.py", "from ..addon import versions", ["addon.versions"]),
    ("addon/core/lamps/world_lights.py", "from ...work import queue", ["addon.work.queue"]),
    ("addon/core/lamps/world_lights.py", "from ..shading import material", ["addon.core.shading.material"]),
    ("addon/core/storage/paths.py", "from ..lamps import update", ["addon.core.lamps.update"]),
    ("addon/mix/operators.py", "from ..adjust import settings", ["addon.adjust.settings"]),
    ("addon/panel/main.py", "from ..work import modal\nfrom ...fitter import load\nimport bpy", []),
    ("fitter/model/fit.py", "import numpy as np\nfrom . import npz\nfrom ..arrays import FloatArray", []),
])
def test_an_import_of_a_higher_layer_is_noticed(path, source, wrong):
    assert violations(path, source) == wrong


@pytest.mark.parametrize(("path", "source", "wrong"), [
    ("benchmarks/rims.py", "from demo_scenes.__main__ import suzanne", ["demo_scenes.__main__"]),
    ("tools/fuzz.py", "def f():\n    import demo_scenes.title", ["demo_scenes.title"]),
    ("support/stage.py", "from benchmarks import ordinary", ["benchmarks"]),
    ("support/stage.py", "from tests.conftest import glossy", ["tests.conftest"]),
    ("tools/mutants.py", "from tools.shader_guards import SHADER_GUARDS\nfrom support import stage", []),
])
def test_an_import_of_what_is_not_shared_is_noticed(path, source, wrong):
    assert not_shared(path, source) == wrong
