"""``make test-matrix``: what depends on Blender's version, on the others, and older files opened in the newest.

DEPENDS are run on 4.2, 4.5 and 5.2, in environments `build/env-bpy-VERSION` that are made where they are missing.
`python -m tools.test_matrix tests/addon/core` runs some of the tests; `python -m tools.test_matrix save|open FILE` is
what it does in each Blender with a .blend.
"""

import json
import os
import shutil
import subprocess
import sys
import time
import tomllib
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import NamedTuple

from support.checkout import ROOT

BUILD = ROOT / "build"


class Blender(NamedTuple):
    """A Blender as a Python module, and the packages that it needs."""

    version: str
    python: str
    pins: tuple = ()        # () for the one that pyproject.toml pins for this Python


DEPENDS = ("tests/addon/core", "tests/addon/importing", "tests/osl", "tests/project/test_extension.py",
           "tests/project/test_farm.py")
MATRIX = (Blender("4.2.23", "3.11", ("bpy==4.2.23", "numpy==1.26.4", "OpenImageIO==3.0.6.1")),
          Blender("4.5.15", "3.11", ("bpy==4.5.15", "numpy==1.26.4")),
          Blender("5.2.3", "3.13"))
CHOICES = ("sample", "diffuse_level", "specular_level", "compression")


def main():
    """Print a row for each Blender and each file that the newest opens; the exit code is 1 where something fails."""
    if sys.argv[1:2] in (["save"], ["open"]):
        _blend(*sys.argv[1:])
    environments = {blender: _environment(blender) for blender in MATRIX}
    print(f"{'Blender':8} {'Python':7} {'NumPy':7} {'passed':>6} {'failed':>6} {'skipped':>7} {'s':>5}")
    outcomes = [_test(blender, python, sys.argv[1:] or DEPENDS) for blender, python in environments.items()]
    present = [blender for blender in MATRIX if environments[blender]]
    for blender in present[:-1]:
        outcomes.append(_upgrade(blender, environments[blender], present[-1], environments[present[-1]]))
    return 0 if all(outcomes) else 1


def _environment(blender):
    """The Python of an environment with this Blender, made where there is none; None where its Python is missing."""
    interpreter = _interpreter(blender.python)
    if interpreter is None:
        return None
    if not blender.pins:
        folder = f"build/env-{blender.python}"
        subprocess.run(["make", "--silent", f"{folder}/ready", f"PYTHON={interpreter}"], cwd=ROOT, check=True)
        return ROOT / folder / "bin" / "python"
    folder = BUILD / f"env-bpy-{blender.version}"
    pins = [*blender.pins, *_tools()]
    ready = folder / "ready"
    if not ready.is_file() or ready.read_text().split() != pins:
        python = folder / "bin" / "python"
        subprocess.run([interpreter, "-m", "venv", "--clear", folder], check=True)
        subprocess.run([python, "-m", "pip", "install", "--quiet", *pins], check=True)
        ready.write_text("\n".join(pins))
    return folder / "bin" / "python"


def _interpreter(version):
    """A Python of this version: the one that runs, one on the path, or one of pyenv's."""
    found = [sys.executable, shutil.which(f"python{version}")]
    if shutil.which("pyenv"):
        prefix = subprocess.run(["pyenv", "prefix", version], capture_output=True, text=True, check=False)
        found.append(f"{prefix.stdout.strip()}/bin/python" if prefix.returncode == 0 else None)
    for python in filter(None, found):
        said = subprocess.run([python, "-c", "import sys; print('%d.%d' % sys.version_info[:2])"], capture_output=True,
                              text=True, check=False)
        if said.stdout.strip() == version:
            return python
    return None


def _tools():
    groups = tomllib.loads((ROOT / "pyproject.toml").read_text())["dependency-groups"]
    return [pin for pin in groups["test"] if isinstance(pin, str)]


def _test(blender, python, arguments):
    """Run the tests and print a row: whether all passed. A Python that is not there fails nothing."""
    name = f"{blender.version:8} {blender.python:7}"
    if python is None:
        print(f"{name} no Python {blender.python} here")
        return True
    numpy = subprocess.run([python, "-c", "import numpy; print(numpy.__version__)"], capture_output=True, text=True,
                           check=True).stdout.strip()
    report, log = (BUILD / f"test-{blender.version}.{kind}" for kind in ("xml", "log"))
    report.unlink(missing_ok=True)
    start = time.perf_counter()
    with open(log, "w") as output:
        done = subprocess.run([python, "-m", "pytest", "-p", "no:cacheprovider", "-n", "auto", "--dist", "loadfile",
                               "-m", "not release", f"--junitxml={report}", *arguments], cwd=ROOT, stdout=output,
                              stderr=subprocess.STDOUT, check=False)
    seconds = time.perf_counter() - start
    if not report.is_file():
        print(f"{name} {numpy:7} ended with code {done.returncode}: {log.relative_to(ROOT)}")
        return False
    count = {kind: sum(int(suite.get(kind)) for suite in ElementTree.parse(report).iter("testsuite"))
             for kind in ("tests", "failures", "errors", "skipped")}
    failed = count["failures"] + count["errors"]
    print(f"{name} {numpy:7} {count['tests'] - failed - count['skipped']:6} {failed:6} {count['skipped']:7} "
          f"{seconds:5.0f}" + (f"  {log.relative_to(ROOT)}" if done.returncode else ""), flush=True)
    return done.returncode == 0


def _upgrade(old, old_python, new, new_python):
    """Save a file in one Blender, render and refit it in another, and print what came of it."""
    blend = BUILD / f"saved-in-{old.version}.blend"
    said = []
    for python, task in ((old_python, "save"), (new_python, "open")):
        done = subprocess.run([python, "-m", "tools.test_matrix", task, blend], cwd=ROOT, capture_output=True,
                              text=True, check=False)
        if done.returncode:
            print(f"saved in {old.version}, {task} failed: {done.stderr.strip().splitlines()[-1:]}")
            return False
        said.append(json.loads(done.stdout.splitlines()[-1]))
    saved, opened = said
    same = abs(opened["mean"] / saved["mean"] - 1) < 0.02 and opened["choices"] == saved["choices"]
    print(f"saved in {old.version}, opened in {new.version}: mean of the picture {saved['mean']:.5f}, "
          f"{opened['mean']:.5f}; fitted again there {opened['refitted']:.5f}{'' if same else '  DIFFERENT'}")
    return same


def _blend(task, path):
    """Save a .blend with a measured material, or open it and fit the material again: print what is found as JSON."""
    import bpy

    from support import checkout, stage
    from tools import fuzz

    def read_scene(scene):
        settings = next(item.active_material for item in scene.objects if item.type == "MESH").measured_brdf
        return {"mean": float(stage.render(scene)[..., :3].mean()),
                "choices": [getattr(settings, name) for name in CHOICES]}

    checkout.extension().register()
    if task == "save":
        scene = stage.black_scene(32, 32, samples=64, span=2)
        stage.add_lamp("POINT", 100, (2, 1, 4), shadow_soft_size=0)
        stage.add_sphere()
        measurements = Path(path).with_suffix(".astm")
        measurements.write_bytes(fuzz.seeds()["astm, made"])
        bpy.ops.measured_brdf.import_data(filepath=str(measurements), diffuse_level=3, specular_level=5,
                                          compression=90.0)
        bpy.ops.wm.save_as_mainfile(filepath=path)
        told = read_scene(scene)
    else:
        bpy.ops.wm.open_mainfile(filepath=path)
        told = read_scene(bpy.context.scene)
        assert bpy.ops.measured_brdf.fit() == {"FINISHED"}
        told["refitted"] = read_scene(bpy.context.scene)["mean"]
    print("\n" + json.dumps(told), flush=True)
    os._exit(0)         # bpy 4.2 as a module does not survive an end of its own (`support.stage.EXITS`)


if __name__ == "__main__":
    sys.exit(main())
