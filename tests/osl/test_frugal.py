"""Where few closures fit, as on GPUs: one lobe for all lamps, and in the mean the same picture; here on the CPU."""

import itertools
import re

import numpy as np
import pytest

import fitter
from fitter.shader_constants import CLOSURE_LIMITED_LOBES
from support import stage
from support.anisotropic import brushed_fit
from support.cases import quick, release
from support.osl_probe import probe_osl
from support.spheres import reflected

from .test_rendering import POWER, mean_colour, mean_under_point, sphere_scene
from .test_shader_guards import leaning, plane


@pytest.fixture(scope="module")
def fits(curet, standard):
    return {"foil": fitter.fit(curet("aluminum foil")), "krylon": standard("krylon_blue_RGB")}


@pytest.fixture
def frugal(extension, monkeypatch):
    """Say whether scenes are rendered on a GPU."""
    return lambda value: monkeypatch.setattr(extension.addon.core.lamps, "renders_on_gpu", lambda scene: value)


def places(count):
    """Where lamps stand: on a spiral, each other one close to the one before it."""
    turn = np.arange(count) // 2 * 2.4
    height = 1 + np.arange(count) // 2 * 3 % 4
    apart = np.arange(count) % 2 * 0.01
    return np.stack([3 * np.cos(turn + apart), 3 * np.sin(turn + apart), height], axis=1)


def powers(count):
    return POWER * (1 + np.arange(count) * 5 % 7) / count


@pytest.mark.parametrize(("material", "count"), quick(
    itertools.product(["foil", "krylon"], [1, 2, 4, 32]), ("krylon", 4)))
def test_one_lobe_for_all_lamps_gives_the_mean_of_numerical_integration(blender, fits, frugal, material, count):
    lamps = list(zip(places(count), powers(count), strict=True))
    expected = sum(mean_under_point(fits[material], resolution=200, at=place) * power / POWER for place, power in lamps)
    for value in (True, False):
        frugal(value)
        scene = sphere_scene(fits[material], 14 * max(count, 4))      # so many that noise is a third of the bound
        for place, power in lamps:
            stage.add_lamp("POINT", power, place, shadow_soft_size=0)
        ratio = mean_colour(scene) / expected
        print(f"{material}, {count} lamps, frugal {value}: rendered / integrated = {ratio}")
        assert ratio == pytest.approx([1, 1, 1], abs=0.01)


@release
def test_one_lobe_for_lamps_with_and_without_a_size_gives_the_same_mean(blender, fits, frugal):
    means = []
    for value in (False, True):
        frugal(value)
        scene = sphere_scene(fits["krylon"], 114)
        stage.background(scene, 0.1)
        stage.add_lamp("SUN", 1, rotation=stage.rotation_toward((-3, 0, 2)), angle=0)
        stage.add_lamp("POINT", 100, (2, -2, 2), shadow_soft_size=0.2)
        stage.add_lamp("AREA", 100, (3, 1, 2), stage.rotation_toward((3, 1, 2)), shape="SQUARE", size=1)
        stage.add_lamp("AREA", 200, (0, 0, 1.5), shape="SQUARE", size=6)          # too large for a lobe
        means.append(mean_colour(scene))
    assert means[1] == pytest.approx(means[0], rel=0.01)


@pytest.mark.parametrize(("radii", "frugal", "counts"), quick([
    ([0.001] * 6, 1, {1}),
    ([0.001] * 6, 0, {2}),
    ([0.2] * 6, 1, {1}),                        # their lobes reach one another
    ([0.001] * 3, 1, {1}),
    ([0.001] * 3, 0, {3}),
    ([0.001, 1.0, 1.0], 1, {1}),                # the others are too large for a lobe, and brighter
    ([1.0, 1.0], 1, {0}),
], ([0.001] * 6, 1, {1}), ([0.001] * 6, 0, {2}), ([0.001, 1.0, 1.0], 1, {1})))
def test_no_more_lobes_are_left_than_fit_and_the_only_one_has_a_lamp(blender, fits, radii, frugal, counts):
    code = f"""
      LampList lamps;
      lamps.count = {len(radii)};
      for (int i = 0; i < lamps.count; i++) {{
        lamps.direction[i] = normalize(vector(0.3 * i - 0.5, 0.2, 1.0));
        lamps.radius[i] = RADIUS[i];
        lamps.light[i] = 1.0 + i;
      }}
      float times[MAX_LAMPS];
      for (int i = 0; i < lamps.count; i++) {{
        times[i] = has_lobe(lamps, i);
      }}
      if (lamps.count > max_light_lobes({frugal})) {{
        sample_lobes(lamps, {frugal}, point(0.37 * pixel, 0.0, 1.0), times);
      }}
      out = 0;
      for (int i = 0; i < lamps.count; i++) {{
        out += times[i] > 0.0 ? 1 : 0;
      }}"""
    found = probe_osl(fits["foil"], code, 1000, RADIUS=np.array(radii))
    assert set(np.round(found[:, 0]).astype(int)) == counts


@pytest.mark.parametrize("value", quick([True, False], True))
def test_eight_lamps_in_one_place_give_the_light_of_one(blender, fits, frugal, value):
    """Some of them have a lobe, and what it carries is counted once: where the mixture is not the fit."""
    frugal(value)
    fit = fits["foil"]
    normal, toward = leaning(70), leaning(10)
    scene = plane(fit, 256, normal)
    for _ in range(8):
        stage.add_lamp("SUN", 1 / 8, rotation=stage.rotation_toward(toward), angle=0)
    expected = np.broadcast_to(reflected(fit, normal[None], toward[None])[0], 3)
    assert mean_colour(scene) == pytest.approx(expected, rel=0.02)


# a GPU's 1024 bytes: id and weight, 16, and the parameters that Cycles has (src/kernel/osl/closures_template.h)
BYTES = {"diffuse": 32, "ashikhmin_velvet": 32, "microfacet": 64, "phong_ramp": 128}
SUM, POOL = 24, 1024


def bytecode_of(fit):
    tree = stage.group_node(stage.osl_material_for(fit)).node_tree
    return next(node for node in tree.nodes if node.type == "SCRIPT").bytecode


@pytest.mark.parametrize("name", quick(["foil", "krylon", "brushed"], "foil", "brushed"))
def test_the_closures_of_a_material_fit_where_few_do(blender, fits, name):
    """All closures of the bytecode at once, each time a sum with those before: there is one lobe at a lamp."""
    bytecode = bytecode_of(brushed_fit() if name == "brushed" else fits[name])
    strings = dict(re.findall(r'^const\s+string\s+(\S+)\s+"(\w+)"', bytecode, re.MULTILINE))
    kinds = [strings[name] for name in re.findall(r"^\s+closure\s+\S+ (\S+)", bytecode, re.MULTILINE)]
    assert CLOSURE_LIMITED_LOBES == 1
    assert kinds.count("phong_ramp") == 2, "a lobe and a sampled direction"
    total = sum(BYTES[kind] for kind in kinds) + SUM * (len(kinds) - 1)
    print(f"{name}: {', '.join(kinds)}: {total} bytes")
    assert total <= 864 < POOL, "the most that a fit takes"


def test_no_weight_stands_beside_its_closure(blender, fits):
    """A weight that is not a part of its closure takes 24 of a GPU's 1024 bytes."""
    bytecode = bytecode_of(fits["foil"])
    operations = [line for line in bytecode.splitlines() if not line.startswith("#")]
    colors = set(re.findall(r"^\w+\s+color\s+(\S+)", bytecode, re.MULTILINE))
    closures = set(re.findall(r"^\w+\s+closure color\s+(\S+)", bytecode, re.MULTILINE))
    weighted = 0
    for made, after in itertools.pairwise(operations):
        if found := re.match(r"\s+closure\s+(\S+)", made):
            product = re.match(r"\s+mul\s+\S+ (\S+) (\S+)", after)
            assert product, "a weight that is worked out after its closure, or none"
            assert product[1] == found[1]
            assert product[2] in colors
            weighted += 1
    products = re.findall(r"^\s+mul\s+(\S+)", bytecode, re.MULTILINE)
    assert weighted == sum(name in closures for name in products) > 0, "a product of what is not a single closure"
