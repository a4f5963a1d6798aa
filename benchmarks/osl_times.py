"""Evaluation times inside Cycles OSL: the paper's Figure 2.

A shader evaluates a model many times a pixel; the time of a picture with few evaluations is taken from that of one with
many, and that of the directions themselves from both. Times are the processor's, for one thread renders.
``python -m benchmarks.osl_times`` prints those of the presets for three channels.
"""

from dataclasses import replace

import fitter
from support.checkout import extension, measurements
from support.osl_probe import probe_scene
from support.stage import render

from . import baselines_osl
from .report.baselines import koenderink, lafortune
from .report.methods import BASELINES
from .report.times import METHODS_TIMED, interleaved

PIXELS = 128 ** 2
FEW, MANY = 1, 401          # evaluations a pixel
REPEATS = 3
NOTHING = "directions alone"
_EVALUATE = "color f = eval_fit(FIT, wi, wo); total += f[0];"
_EVALUATE_ALL = "color f = eval_fit(FIT, wi, wo); total += f[0] + f[1] + f[2];"
_IDLE = "total += wi[0] + wo[0] + wi[1];"

_LOOP = """
  float total = 0.0;
  for (int k = 0; k < %d; k++) {
    /* evenly spread, and uniform in projected solid angle */
    float at = pixel + 0.5;
    float zi = sqrt(mod(0.8191725 * k + 0.6180340 * at, 1.0));
    float zo = sqrt(mod(0.6710436 * k + 0.7548777 * at, 1.0));
    float turn = M_PI * mod(0.5497005 * k + 0.5698403 * at, 1.0);
    float ri = sqrt(1.0 - zi * zi);
    vector wi = vector(ri * cos(turn), ri * sin(turn), zi);
    vector wo = vector(sqrt(1.0 - zo * zo), 0.0, zo);
    %s
  }
  out = 1e-6 * max(total, 0.0);
"""


def table(samples, repeats=REPEATS):
    """Nanoseconds a call on one core: a list of dict.

    Parameters
    ----------
    samples : Samples
        Only its first channel is fitted.
    """
    grey = replace(samples, values=samples.values[:, :1], channels=("grey",))
    fits = {name: make(grey) for name, make in METHODS_TIMED.items() if name not in BASELINES}
    small = fitter.fit(grey, 0, None)               # a probe must bake something
    probes = {name: (fit, "", _EVALUATE) for name, fit in fits.items()} | {
        "Koenderink 8": (small, baselines_osl.koenderink(koenderink.fit(grey)), "total += koenderink(wi, wo);"),
        "Lafortune 3": (small, baselines_osl.lafortune(lafortune.fit(grey)), "total += lafortune(wi, wo);"),
        NOTHING: (small, "", _IDLE)}
    return _timed(probes, repeats)


def of_presets(samples, repeats=REPEATS):
    """As `table`, of the presets, for all channels of RGB samples."""
    fits = {name: fitter.fit(samples, **preset) for name, preset in fitter.PRESETS.items()}
    return _timed({name: (fit, "", _EVALUATE_ALL) for name, fit in fits.items()} | {
        NOTHING: (fits["Draft"], "", _IDLE)}, repeats)


def _timed(probes, repeats):
    """Nanoseconds a call of probes, each by its name (fit, functions, statement): rows as `table` returns them."""
    found = interleaved({(name, count): lambda probe=probe, count=count: _render(*probe, count)
                         for name, probe in probes.items() for count in (FEW, MANY)}, repeats)
    calls = PIXELS * (MANY - FEW)
    each = {name: 1e9 * (found[name, MANY] - found[name, FEW]) / calls for name in probes}
    return [{"method": name, "nanoseconds": each[name] - each[NOTHING]} for name in probes if name != NOTHING]


def _render(fit, functions, statement, count):
    scene = probe_scene(fit, _LOOP % (count, statement), PIXELS, functions)
    scene.render.threads_mode, scene.render.threads = "FIXED", 1
    render(scene)


def main():
    extension().register()
    from measured_brdf.addon.core import osl_support

    assert not osl_support.missing()
    for stem in ("krylon_blue_RGB", "garnet_red_RGB"):
        path = measurements() / "cornell" / f"{stem}.astm"
        for row in of_presets(fitter.load(path)):
            print(f"{stem:16} {row['method']:10} {row['nanoseconds']:5.0f} ns", flush=True)


if __name__ == "__main__":
    main()
