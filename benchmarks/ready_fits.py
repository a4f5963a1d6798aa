"""What the starter library takes: ``python -m benchmarks.ready_fits``.

First the levels of its fits: bytes, and errors at directions that are no samples, as the RMSE of the cube root of
values times cosine in percent of its mean; for materials by which the levels were chosen, and for others. Then what
`make zip` has built, and the processor's time for a click, from the operator to a compiled material on an object; with
and without it.
"""

import os
import sys
import time

import numpy as np

import fitter
from fitter import methods, published, ready
from support import checkout

LEVELS = {"Standard": (4, 5, 98.2), "Draft": (3, 5, 99.0), "library": (3, 4, 95.0), "coarser": (2, 4, 97.0),
          "dense only": (3, None, 0.0)}
STEP = 12                   # of the materials, in alphabetical order
COUNT = 4000                # directions
CLICKED = ("red-plastic", "pink-felt", "pearl-paint", "cherry-235")
STEEPEST = np.radians(80)


def main():
    """Print the tables."""
    names = sorted(each.name for each in published.offered())
    print("| Materials | Levels | kB | RMSE, % | at worst |")
    print("| --- | --- | --- | --- | --- |")
    for half, start in (("chosen by", 0), ("others", STEP // 2)):
        found = {name: fits_of(name) for name in names[start::STEP]}
        for label in LEVELS:
            sizes, errors = zip(*(each[label] for each in found.values()), strict=True)
            print(f"| {len(found)}, {half} | {label} | {np.mean(sizes) / 1000:.1f} | {100 * np.mean(errors):.2f} | "
                  f"{100 * max(errors):.2f} |", flush=True)
    print()
    built = ready.FOLDER.parent
    for what, paths in (("fits", [*ready.FOLDER.glob("*.npz")]), (".blend", [*built.glob("*.blend")]),
                        ("zip", [*(checkout.ROOT / "build").glob("measured_brdf-*.zip")])):
        print(f"{what}: {len(paths)} files, {sum(path.stat().st_size for path in paths) / 1e6:.2f} MB")
    print(f"click, of a fit that is there: {click():.2f} s", flush=True)
    sys.modules["measured_brdf.fitter.ready"].is_there = lambda _name: False
    print(f"click, of one that is made first: {click():.2f} s", flush=True)
    os._exit(0)             # Blender as a module is slow to end


def fits_of(name):
    """{label: (bytes, error)} for each of the levels."""
    model, samples = published.find(name).model, fitter.load_published(name)
    random = np.random.default_rng(2012)
    theta_i, theta_o = np.arccos(np.sqrt(random.uniform(np.cos(STEEPEST) ** 2, 1, (2, COUNT))))
    near = random.random(COUNT) < 0.5       # half of them at the highlight
    theta_o = np.where(near, np.abs(theta_i + np.sqrt(2 / model.b) * random.standard_cauchy(COUNT)), theta_o)
    phi_o = np.where(near, np.pi, random.uniform(0, 2 * np.pi, COUNT))
    kept = theta_o < STEEPEST
    at = theta_i[kept], np.zeros(kept.sum()), theta_o[kept], phi_o[kept]
    expected, prepared, found = seen(model, at), methods.prepare(samples, "kriging"), {}
    for label, (diffuse, specular, compression) in LEVELS.items():
        fit = fitter.fit(samples, diffuse, specular, compression, method="kriging", **prepared)
        error = np.sqrt(np.mean((seen(fit, at) - expected) ** 2)) / expected.mean()
        found[label] = len(fit.to_bytes()), error
    return found


def seen(model, at):
    """The cube root of values times cosine."""
    return np.cbrt(model.evaluate(*at) * np.cos(at[2])[:, None])


def click():
    """Seconds of the processor, in the mean of some materials."""
    import bpy

    extension = checkout.extension()
    if not hasattr(bpy.types.Material, "measured_brdf"):
        extension.register()
        extension.addon.core.osl_support.missing()
    taken = []
    for name in CLICKED:
        bpy.ops.wm.read_factory_settings(use_empty=True)
        bpy.ops.mesh.primitive_cube_add()
        start = time.process_time()
        bpy.ops.measured_brdf.use_published("INVOKE_DEFAULT", name=name)
        taken.append(time.process_time() - start)
        assert bpy.context.object.active_material.measured_brdf.coefficients
    return float(np.mean(taken))


if __name__ == "__main__":
    sys.exit(main())
