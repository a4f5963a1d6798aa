"""Does another checkout render the same pictures, and how fast?

    python -m tools.same_pictures OTHER                     # pictures of both, pixel by pixel
    python -m tools.same_pictures OTHER --times 7           # their render times instead, seven of each in turn
    python -m tools.same_pictures OTHER --only krylon sun   # only scenes whose names contain all these words

Each checkout renders in a process of its own, which fits, bakes and compiles with its own code and stays alive, so that
times alternate between the two. Scenes, seeds and measurements are those of this checkout. The exit code is 1 where a
picture differs in a single bit.
"""

import argparse
import importlib
import importlib.util
import inspect
import json
import math
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

SIZE = 48                   # pixels
SAMPLES = 16
TIMED_SAMPLES = 192
SEED = 2
LAMP = (-3.0, 0.0, 2.0)
TURN = (0.0, -math.atan2(3, 2), 0.0)

FITS = {
    "foil Paper": ("foil", {}),
    "foil Standard": ("foil", "Standard"),
    "krylon Paper": ("krylon", {}),
    "krylon Standard": ("krylon", "Standard"),
    "krylon dense": ("krylon", {"diffuse_level": 4, "specular_level": None}),
    "cayman Standard": ("cayman", "Standard"),
}
FILES = {"foil": (("curet/abrdf.dat", "15"),),
         "krylon": (("cornell/krylon_blue_RGB.astm", None), ("cornell/krylon_blue.astm", None)),
         "cayman": (("cornell/cayman.astm", None),)}


class Scene(NamedTuple):
    """What is rendered: a fit of FITS on a sphere, under a light of LIGHTS, with inputs of the node group."""

    fit: str
    light: str
    inputs: dict = {}       # noqa: RUF012  (never written)

    @property
    def name(self) -> str:
        """What the scene shows, in words."""
        return ", ".join([self.fit, self.light, *(f"{name} {value}" for name, value in self.inputs.items())])


_FAST = {"Exact": False}
SCENES = [
    *(Scene("foil Standard", light) for light in ("sun", "sun without a size", "point", "area", "area and sun",
                                                  "32 points", "even world", "sky", "mesh light")),
    *(Scene("krylon Standard", light) for light in ("sun", "point", "area", "area and sun", "32 points", "even world",
                                                    "even world and sun", "sky", "mesh light")),
    *(Scene("krylon Standard", light, _FAST) for light in ("sun", "area", "32 points", "even world")),
    Scene("krylon Standard", "area and sun", {"Tint": (0.9, 0.5, 0.2, 1.0), "Strength": 0.7}),
    Scene("foil Standard", "point", {"Normal": (0.3, 0.1, 0.8)}),
    Scene("foil Standard", "point", {"Normal": (-0.8, 0.2, -0.3)}),         # turned away from the viewer
    *(Scene(fit, light) for fit in ("foil Paper", "krylon Paper", "krylon dense", "cayman Standard")
      for light in ("point", "even world")),
    Scene("cayman Standard", "area"),
]
TIMED = [Scene("foil Standard", "even world"), Scene("foil Standard", "area"), Scene("krylon Standard", "even world"),
         Scene("krylon Standard", "sun"), Scene("krylon Standard", "area"), Scene("krylon Standard", "32 points"),
         Scene("krylon Standard", "area", _FAST)]


# In the process of a checkout: `stage`, `fitter` and the extension are that checkout's.

def _module(*names: str):
    """The first of these modules that the checkout has: its place now, then its place in older checkouts."""
    for name in names[:-1]:
        if importlib.util.find_spec(name.rpartition(".")[0]) is not None and importlib.util.find_spec(name) is not None:
            return importlib.import_module(name)
    return importlib.import_module(names[-1])


def _stage():
    return _module("support.stage", "demo_scenes.stage")


def _checkout():
    return _module("support.checkout", "tools.checkout")


def _lights() -> dict[str, Callable[[], object]]:
    import bpy

    stage = _stage()

    def world():
        stage.background(bpy.context.scene, 1)

    def sun(angle=0.01):
        stage.add_lamp("SUN", 1, rotation=(0, -math.radians(60), 0), angle=angle)

    def point():
        stage.add_lamp("POINT", 100, LAMP, shadow_soft_size=0.1)

    def area():
        stage.add_lamp("AREA", 100, LAMP, TURN, shape="SQUARE", size=2)

    def points():
        for number, turn in enumerate(np.arange(32) / 32 * 2 * math.pi):
            place = (3 * math.cos(turn), 3 * math.sin(turn), 1 + number % 4)
            stage.add_lamp("POINT", 5 + number % 3, place, shadow_soft_size=0.1)

    def sky():
        tree = bpy.context.scene.world.node_tree
        texture = tree.nodes.new("ShaderNodeTexSky")
        tree.nodes["Background"].inputs["Strength"].default_value = 0.2
        tree.links.new(texture.outputs["Color"], tree.nodes["Background"].inputs["Color"])

    def mesh():
        bpy.context.scene.cycles.max_bounces = 3
        bpy.ops.mesh.primitive_plane_add(size=2, location=LAMP, rotation=(0, TURN[1] + math.pi, 0))
        material, shader, surface = stage.blank_material("Panel", "ShaderNodeEmission")
        shader.inputs["Strength"].default_value = 20
        material.node_tree.links.new(shader.outputs[0], surface)
        bpy.context.object.data.materials.append(material)

    return {"even world": world, "sun": sun, "sun without a size": lambda: sun(0), "point": point, "area": area,
            "area and sun": lambda: (area(), sun()), "even world and sun": lambda: (world(), sun(0)),
            "32 points": points, "sky": sky, "mesh light": mesh}


def _fit(name: str):
    import fitter

    checkout = _checkout()

    material, settings = FITS[name]
    for path, sample in FILES[material]:
        if (checkout.measurements() / path).is_file():
            samples = fitter.load(checkout.measurements() / path, sample)
            return fitter.fit(samples, **(fitter.PRESETS[settings] if isinstance(settings, str) else settings))
    return None


def _shader(name: str):
    """A fit of FITS, baked and compiled; None where its measurements are absent."""
    compiler = _module("measured_brdf.addon.materials.compiler", "measured_brdf.addon.compiler")
    bake = _module("measured_brdf.fitter.cycles.bake", "measured_brdf.fitter.bake").bake

    fit = _fit(name)
    if fit is None:
        return None
    if len(inspect.signature(compiler.compile_shader).parameters) == 1:          # older checkouts had no closure nodes
        return compiler.compile_shader(bake(fit))
    nodes = _module("measured_brdf.fitter.cycles.node_mixture", "measured_brdf.fitter.node_mixture")
    return compiler.compile_shader(bake(fit), nodes.node_mixtures(fit))


def _build(scene: Scene, shader, samples: int):
    """The Blender scene, ready to be rendered."""
    import bpy

    node_group = _module("measured_brdf.addon.materials.node_group", "measured_brdf.addon.node_group")
    stage = _stage()

    built = stage.black_scene(SIZE, SIZE, samples, span=2)
    built.cycles.seed = SEED
    built.cycles.max_bounces = 0
    built.render.threads_mode, built.render.threads = "FIXED", 1
    built.render.use_persistent_data = True         # compiles the shader once, where a scene is rendered again
    material, group, surface = stage.blank_material("Measured", "ShaderNodeGroup")
    alone = len(inspect.signature(node_group.create).parameters) == 1        # older checkouts took the fit before it
    group.node_tree = node_group.create(*([shader] if alone else [None, shader]))
    material.node_tree.links.new(group.outputs["BSDF"], surface)
    material.cycles.use_bump_map_correction = False
    for name, value in scene.inputs.items():
        if name == "Normal":            # unconnected, it has no value
            vector = material.node_tree.nodes.new("ShaderNodeCombineXYZ")
            for socket, number in zip(vector.inputs, value, strict=True):
                socket.default_value = number
            material.node_tree.links.new(vector.outputs[0], group.inputs[name])
        else:
            group.inputs[name].default_value = value
    stage.add_sphere().data.materials.append(material)
    # Blender adds up vertex normals in the order in which its threads get to them; those of faces are always the same
    bpy.ops.object.shade_flat()
    _lights()[scene.light]()
    return bpy.context.scene


def _serve() -> None:
    """Render what is asked for, a line of JSON at a time, until there is nothing more to read."""
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)                       # where Blender reports its progress
    stage, checkout = _stage(), _checkout()

    checkout.extension().register()
    shaders = {}
    for line in sys.stdin:
        asked = json.loads(line)
        scene = Scene(**asked["scene"])
        if scene.fit not in shaders:
            shaders[scene.fit] = _shader(scene.fit)
        answer = {"absent": shaders[scene.fit] is None}
        if not answer["absent"]:
            if not asked["again"]:
                built = _build(scene, shaders[scene.fit], asked["samples"])
            start = time.process_time()
            picture = stage.render(built)
            answer["seconds"] = time.process_time() - start
            np.save(asked["file"], picture)
        print(json.dumps(answer), file=answers, flush=True)


# In the process that compares.

class Checkout:
    """The process of a checkout. Renders on demand."""

    def __init__(self, folder: Path, data: Path, scratch: Path):
        environment = os.environ | {"PYTHONPATH": str(folder), "MEASURED_BRDF_DATA": str(data.resolve()),
                                    "OPENBLAS_NUM_THREADS": "1", "PYTHONDONTWRITEBYTECODE": "1"}
        # -P: the modules beside this file are those of another checkout
        self._process = subprocess.Popen([sys.executable, "-P", __file__, "--serve"], cwd=folder, env=environment,
                                         stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
                                         text=True)
        self._file = scratch / "picture.npy"

    def render(self, scene: Scene, samples: int, again: bool = False) -> tuple[NDArray[np.float32], float] | None:
        """A picture (height, width, 4) and the processor seconds that it took; None where measurements are absent.

        `again` renders the last scene once more, for which Cycles compiles nothing.
        """
        question = {"scene": scene._asdict(), "samples": samples, "file": str(self._file), "again": again}
        print(json.dumps(question), file=self._process.stdin, flush=True)
        line = self._process.stdout.readline()
        if not line:
            raise RuntimeError(f"{scene.name}: the process of the checkout ended")
        answer = json.loads(line)
        return None if answer["absent"] else (np.load(self._file), answer["seconds"])

    def close(self) -> None:
        """End the process."""
        self._process.stdin.close()
        self._process.wait()


def compare(ours: Checkout, other: Checkout, scenes: list[Scene]) -> bool:
    """Print a line for each scene: whether all pictures are equal to the last bit."""
    equal = True
    width = max(len(scene.name) for scene in scenes)
    for scene in scenes:
        rendered = [checkout.render(scene, SAMPLES) for checkout in (other, ours)]
        if None in rendered:
            print(f"{scene.name:{width}}  measurements are absent")
            continue
        before, after = (picture for picture, _ in rendered)
        same = np.array_equal(before, after)
        difference = np.abs(after - before)[..., :3]
        largest = "" if same else (f": by up to {difference.max() / before[..., :3].max():.2g} of the largest value, "
                                   f"{np.count_nonzero(difference.any(axis=2))} of {SIZE * SIZE} pixels, mean "
                                   f"{after[..., :3].mean() / before[..., :3].mean() - 1:+.2g}")
        print(f"{scene.name:{width}}  {'equal to the last bit' if same else 'differs'}{largest}", flush=True)
        equal &= same
    return equal


def time_them(ours: Checkout, other: Checkout, scenes: list[Scene], repeats: int) -> None:
    """Print the ratio of render times for each scene, ours to the other's, the two measured in turn.

    Other work on the machine can only add to a time, so that the least is the nearest to what a shader takes.
    """
    width = max(len(scene.name) for scene in scenes)
    least, ratios = [], []
    for scene in scenes:
        if None in [checkout.render(scene, TIMED_SAMPLES) for checkout in (other, ours)]:
            continue
        before, after = [], []
        for _ in range(repeats):
            before.append(other.render(scene, TIMED_SAMPLES, again=True)[1])
            after.append(ours.render(scene, TIMED_SAMPLES, again=True)[1])
        least.append(min(after) / min(before))
        ratios.append(statistics.median(np.divide(after, before)))
        print(f"{scene.name:{width}}  least {min(before):.3f} s -> {min(after):.3f} s, ratio {least[-1]:.3f}; "
              f"median of the ratios in turn {ratios[-1]:.3f}", flush=True)
    if ratios:
        print(f"median of all scenes: {statistics.median(least):.3f} of the least times, "
              f"{statistics.median(ratios):.3f} of the medians")


def main() -> int:
    """Compare the pictures, and on request the times, of two checkouts."""
    parser = argparse.ArgumentParser(prog="python -m tools.same_pictures", description=__doc__.split("\n")[0])
    parser.add_argument("other", type=Path, nargs="?", help="another checkout")
    parser.add_argument("--times", type=int, default=0, metavar="N", help="measure render times instead, N of each")
    parser.add_argument("--only", nargs="+", default=(), metavar="WORD", help="scenes whose names contain all of these")
    parser.add_argument("--serve", action="store_true", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.serve:
        _serve()
        return 0
    if arguments.other is None:
        parser.error("name another checkout")
    from support.checkout import ROOT
    from support.synthetic import measurements_or_synthetic

    chosen, timed = ([scene for scene in scenes if all(word in scene.name for word in arguments.only)]
                     for scenes in (SCENES, TIMED))
    data = measurements_or_synthetic()[0]
    with tempfile.TemporaryDirectory() as folder:
        ours, other = (Checkout(path.resolve(), data, Path(folder)) for path in (ROOT, arguments.other))
        try:
            if arguments.times:
                time_them(ours, other, timed, arguments.times)
                return 0
            equal = compare(ours, other, chosen)
        finally:
            ours.close()
            other.close()
    return 0 if equal else 1


if __name__ == "__main__":
    sys.exit(main())
