"""Reference pictures without Cycles' closures: a shader computes the integrals itself.

Under direct light the shader samples directions toward the light, looks along them with `trace`, and emits the sum of
fit * cosine * radiance / density. Under indirect light every path continues in a sampled direction: the closure is a
mirror, turned to reflect it there. Directions in an even world and of paths are those by which a measured material
samples its remainder.
"""

import math

import bpy

from fitter.cycles.bake import bake
from support import stage

DIRECTIONS = 24             # for a shading point

_HEAD = """
#include "baked_constants.h"
#include "random.h"
#include "shading_frame.h"
#include "fit.h"
#include "mixture.h"

shader reference(output closure color Result = 0)
{
#include "baked_tables.h"
  /* as the measured material does: interpolated normals may turn away from the viewer */
  float facing = dot(N, I);
  vector z = facing < 1e-3 ? normalize(N + (1e-3 - facing) * I) : N;
  vector x = normalize(I - dot(I, z) * z);
  vector y = cross(z, x);
  vector wo = vector(dot(I, x), dot(I, y), dot(I, z));
  Mixture mixture;
  mixture_of(MIXTURE, wo, 0, mixture);
  float density;
  color mixed;
"""

_INTEGRATE = _HEAD + """
  color sum = 0.0;
  for (int k = 0; k < COUNT; k++) {
    float u = (float)hashnoise(P, 3.0 * k);
    float v = (float)hashnoise(P, 3.0 * k + 1.0);
    float choice = (float)hashnoise(P, 3.0 * k + 2.0);
    vector w = 0.0;
    float light = 0.0;      /* radiance over density */
    LIGHT
    vector wi = vector(dot(w, x), dot(w, y), dot(w, z));
    if (wi[2] > 0.0 && dot(w, Ng) > 0.0 && !trace(P, w)) {
      sum += eval_fit(FIT, wi, wo) * (wi[2] * light / COUNT);
    }
  }
  Result = sum * emission();
}
"""

_DRAW = _HEAD + """
  vector wi = sample_mixture(mixture, P);
  vector w = wi[0] * x + wi[1] * y + wi[2] * z;
  if (wi[2] > 0.0 && dot(w, Ng) > 0.0) {
    mixed = eval_mixture(mixture, wi, density);
    color weight = eval_fit(FIT, wi, wo) * (wi[2] / density);
    Result = weight * reflection(normalize(I + w));
  }
}
"""

CONE = """
    vector axis = normalize(AXIS);
    vector side = normalize(cross(axis, fabs(axis[2]) < 0.9 ? vector(0.0, 0.0, 1.0) : vector(1.0, 0.0, 0.0)));
    float height = 1.0 - u * (1.0 - COSINE);
    float r = sqrt(max(0.0, 1.0 - height * height));
    w = height * axis + r * (cos(M_2PI * v) * side + sin(M_2PI * v) * cross(axis, side));
"""


def _cone(axis, cosine):
    """OSL that draws w in a cone, from two expressions."""
    return CONE.replace("AXIS", axis).replace("COSINE", cosine)


def world(strength=1.0):
    """An even world: sampled by the mixture, since highlights are narrow."""
    return f"""
    vector even = sample_mixture(mixture, P + 17.3 * k);
    w = even[0] * x + even[1] * y + even[2] * z;
    mixed = eval_mixture(mixture, even, density);
    light = {strength} / density;"""


def bright_spot(axis, half_angle, strength, around):
    """An even world with a disk that is brighter by `strength` in its centre, and by less toward its edge."""
    cosine = math.cos(half_angle)
    return (f"if (choice < 0.5) {{ {world(2 * around)} }}"
            f"else {{ {_cone(_vector(axis), repr(cosine))} "
            f"light = 2.0 * {strength} * M_2PI * (height - {cosine!r}); }}")


def sun(toward, angle, irradiance):
    """A sun of an angular diameter."""
    return _cone(_vector(toward), repr(math.cos(angle / 2))) + f"light = {irradiance};"


def balls(places, radius, power):
    """Point lamps of one power: glowing balls, one of which is taken at random."""
    choices = "".join(f"if (choice >= {number / len(places)}) lamp = point{tuple(map(float, place))};"
                      for number, place in enumerate(places))
    return f"""
    point lamp = 0.0;
    {choices}
    float distance = length(lamp - P);
    {_cone("lamp - P", f"sqrt(max(0.0, 1.0 - {radius} * {radius} / (distance * distance)))")}
    light = {len(places)} * {power} / (4.0 * M_PI * distance * distance);"""


def square(center, facing, side, power):
    """A square area lamp that faces along a direction in the xz plane."""
    return f"""
    vector across = vector(0.0, 1.0, 0.0);
    vector front = normalize({_vector(facing)});
    vector offset = (u - 0.5) * across + (v - 0.5) * cross(front, across);
    vector away = point{tuple(map(float, center))} + {side} * offset - P;
    float distance = length(away);
    w = away / distance;
    light = {power} / M_PI * max(0.0, -dot(w, front)) / (distance * distance);"""


def _vector(values):
    return f"vector{tuple(map(float, values))}"


def material(fit, mixture, light=None):
    """A material that emits the integral over a light or, without a light, continues paths in sampled directions."""
    template = _DRAW if light is None else _INTEGRATE.replace("LIGHT", light).replace("COUNT", str(DIRECTIONS))
    text = bpy.data.texts.new("reference.osl")
    text.from_string(bake(fit, template, mixture))
    made, script, surface = stage.blank_material("Reference", "ShaderNodeScript")
    script.mode, script.script = "INTERNAL", text
    if "Result" not in script.outputs:
        raise RuntimeError("the reference does not compile")
    made.node_tree.links.new(script.outputs["Result"], surface)
    return made
