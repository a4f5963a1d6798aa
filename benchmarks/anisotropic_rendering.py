"""What an anisotropic fit costs to render, beside the isotropic one of the same samples.

    python -m benchmarks.anisotropic_rendering [--materials ...] [--lights ...]

Prints, for the Standard fits of each material, the light that the mixture misplaces, in the mean and at the worst view,
the processor time of baking, the time of compiling, the size of a .blend and the time of an evaluation in OSL; and
then, for a sphere under each light, processor time and noise as ratios of the anisotropic fit's to the isotropic one's.
Times are the least of several, since the machine does other work too. The two do not look alike: the noise of a streak
is not that of a round highlight.
"""

import argparse
import tempfile
import time
from dataclasses import replace
from functools import partial
from pathlib import Path

import fitter
from fitter.cycles.bake import bake
from fitter.cycles.node_mixture import node_mixtures
from fitter.samples import RGB, Samples
from support import checkout
from support.anisotropic import ANISOTROPIC, rotations

from . import osl_times, rendering
from .report.times import interleaved

MATERIALS = ("brushed b", "lacquered b", "woven b", "rgl/synthetic_aniso_rgb.bsdf")
LIGHTS = ("world", "2 m area", "sun", "0.1 m point", "32 points")
REPEATS = 3
# as in `osl_times`, from all azimuths
_LOOP = osl_times._LOOP.replace("vector(sqrt(1.0 - zo * zo), 0.0, zo)",
                                "sqrt(1.0 - zo * zo) * vector(cos(2.7 * k), sin(2.7 * k), 0.0) + vector(0.0, 0.0, zo)")
_NOTHING, _EVALUATE = "total += wi[0] + wo[0] + wi[1];", "color f = eval_fit(FIT, wi, wo); total += f[0];"
_FEW, _MANY = 1, 101


def samples_of(name):
    """The samples of a material: of an analytic truth at 16 rotations, or of a file."""
    truth = next((each for each in ANISOTROPIC if each.name == name), None)
    if truth is None:
        return fitter.load(checkout.measurements() / name)
    directions = rotations(16)
    return Samples(*directions, truth.evaluate(*directions), RGB, truth.name, isotropic=False)


def least(work, clock):
    """The least time of some calls, seconds."""
    times = []
    for _ in range(REPEATS):
        start = clock()
        work()
        times.append(clock() - start)
    return min(times)


def nanoseconds(fits):
    """Of an evaluation in OSL, for each fit."""
    work = [(fit, _EVALUATE) for fit in fits] + [(fits[0], _NOTHING)]
    found = interleaved({(number, count): lambda fit=fit, code=code, count=count: _evaluate(fit, code, count)
                         for number, (fit, code) in enumerate(work) for count in (_FEW, _MANY)}, REPEATS)
    each = [1e9 * (found[number, _MANY] - found[number, _FEW]) / (osl_times.PIXELS * (_MANY - _FEW))
            for number in range(len(work))]
    return [time - each[-1] for time in each[:-1]]


def _evaluate(fit, code, count):
    scene = osl_times.probe_scene(fit, _LOOP % (count, code), osl_times.PIXELS)
    scene.render.threads_mode, scene.render.threads = "FIXED", 1
    osl_times.render(scene)


def costs(name, fits, folder):
    """Print the line of each fit; returns their .blend files."""
    from measured_brdf.addon.core.compiler import compile_shader

    libraries = []
    for kind, fit, evaluation in zip(("isotropic", "anisotropic"), fits, nanoseconds(fits), strict=True):
        nodes = node_mixtures(fit)
        mixture, source = nodes.cycles, bake(fit, mixture=nodes.cycles)
        libraries.append(rendering._library(fit, folder / f"{kind}.blend"))
        print(f"{name[-22:]:23}{kind:12} {mixture.error:6.1%} {mixture.worst:6.1%} "
              f"{least(lambda fit=fit: bake(fit), time.process_time):7.2f} s "
              f"{least(partial(compile_shader, source, nodes), time.perf_counter):7.2f} s "
              f"{libraries[-1].stat().st_size / 1e6:7.1f} MB {evaluation:7.0f} ns", flush=True)
    return libraries


def pictures(name, libraries, lights):
    """Print the line of each light."""
    for light in lights:
        ratios = []
        for nodes in (False, True):
            ways = [[rendering.measure("sphere", light, partial(_material, path, nodes)) for _ in range(REPEATS)]
                    for path in libraries]
            seconds = [min(each.seconds for each in way) for way in ways]
            noise = [way[0].noise for way in ways]
            ratios += [seconds[1] / seconds[0], noise[1] / noise[0]]
        print(f"{name[-22:]:23}{light:12} " + " ".join(f"{ratio:7.2f}x" for ratio in ratios), flush=True)


def _material(path, nodes, _integral):
    return rendering.measured(path, nodes)


def main():
    parser = argparse.ArgumentParser(prog="benchmarks.anisotropic_rendering", description=__doc__.split("\n")[0])
    parser.add_argument("--materials", nargs="+", default=MATERIALS)
    parser.add_argument("--lights", nargs="*", default=LIGHTS)
    chosen = parser.parse_args()
    checkout.extension().register()
    from measured_brdf.addon.core import osl_support

    assert not osl_support.missing()
    lines = []
    with tempfile.TemporaryDirectory() as folder:
        print(f"{'':35} {'misplaced':>13} {'bake':>9} {'compile':>9} {'.blend':>10} {'evaluation':>10}")
        for name in chosen.materials:
            samples = samples_of(name)
            fits = [fitter.fit(replace(samples, isotropic=isotropic), **fitter.PRESETS["Standard"])
                    for isotropic in (True, False)]
            here = Path(folder) / str(len(lines))
            here.mkdir()
            lines.append((name, costs(name, fits, here)))
        print(f"\n{'':36}{'Exact':^16} {'Nodes':^18}\n{'':35} {'time':>8} {'noise':>8} {'time':>8} {'noise':>8}")
        for name, libraries in lines:
            pictures(name, libraries, chosen.lights)


if __name__ == "__main__":
    main()
