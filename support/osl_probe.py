"""OSL code run inside Cycles, once for each pixel; the picture holds its results."""

import math

import bpy
import numpy as np

from fitter.cycles.bake import bake

from .mixtures import any_mixture
from .stage import black_scene, blank_material, render

PROBE = """
#include "baked_constants.h"
#include "random.h"
#include "shading_frame.h"
#include "fit.h"
#include "mixture.h"
#include "lamps.h"
#include "light_lobes.h"
#include "residual.h"
%s
shader probe(output closure color Result = 0)
{
#include "baked_tables.h"
%s
  int pixel = (int)floor(P[1]) * %d + (int)floor(P[0]);
  color out = 0.0;
  %s
  Result = out * emission();
}
"""


def probe_osl(fit, code, count, functions="", mixture=None, **tables):
    """Run OSL code inside Cycles, once a pixel, as `probe_scene` has it: (count, 3) float32."""
    scene = probe_scene(fit, code, count, functions, mixture, **tables)
    return render(scene)[::-1, :, :3].reshape(-1, 3)[:count]


def probe_scene(fit, code, count, functions="", mixture=None, **tables):
    """A scene whose picture runs OSL code once for each of so many pixels. Replaces whatever file is open.

    The code reads `pixel`, the tables of the fit and of the mixture, which is any where none is given, and more tables
    by their names; it calls the project's OSL headers, and these functions. It writes `out`, which is not negative.
    """
    from measured_brdf.addon.core.blender import osl_support

    assert not osl_support.reason_unavailable()
    width = max(4, math.ceil(math.sqrt(count)))       # Blender renders no smaller pictures
    arrays = "".join(_exactly(name, np.ravel(table)) for name, table in tables.items())
    source = bake(fit, PROBE % (functions, arrays, width, code), any_mixture(fit) if mixture is None else mixture)
    scene = black_scene(width, width, samples=1, span=width)
    scene.camera.location = (width / 2, width / 2, 10)
    scene.cycles.pixel_filter_type = "BOX"
    bpy.ops.mesh.primitive_plane_add(size=2 * width, location=(width / 2, width / 2, 0))
    text = bpy.data.texts.new("probe.osl")
    text.from_string(source)
    material, script, surface = blank_material("probe", "ShaderNodeScript")
    script.mode, script.script = "INTERNAL", text
    assert "Result" in script.outputs, "the probe does not compile"
    material.node_tree.links.new(script.outputs["Result"], surface)
    bpy.context.object.data.materials.append(material)
    return scene


def _exactly(name, numbers):
    """The declaration of an array, with all digits of single precision."""
    kind, form = ("int", "%d") if np.issubdtype(numbers.dtype, np.integer) else ("float", "%.9g")
    return f"  {kind} {name}[{len(numbers)}] = {{\n" + ",\n".join(form % number for number in numbers) + "};\n"
