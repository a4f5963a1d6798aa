"""The guards of the shader, for `mutants`: where each is, what takes its place, and what it is for."""

from typing import NamedTuple

_OSL, _GUARDS, _RENDERING = "tests/osl/test_shader.py", "tests/osl/test_shader_guards.py", "tests/osl/test_rendering.py"
_FIT = (_OSL, "-k", "evaluates_the_fit and leather or version_2 or below_zero or slot")
_DRAW = (_OSL, _GUARDS, "-k", "drawn or cell")
_MIXTURE = (_OSL, _GUARDS, "-k", "mixture")
_NOTED = (_OSL, _GUARDS, "-k", "a_lobe or lamps_are_known or half_below or without_a_size")
_FRAME = (_GUARDS, _RENDERING, "-k", "viewer or turned_away or normal_input or sun-foil")
_LARGE = (_RENDERING, "-k", "area and foil")
_EVEN = (_GUARDS, _RENDERING, "-k", "adds_no_noise or fast_is_the or world-foil or area and foil")
_SMALL = (_GUARDS, _RENDERING, "-k", "shader_guards and lamp or sun-foil or close_together or more_lamps")
_DRAWN = (_GUARDS, _RENDERING, "-k", "shader_guards and lamp or world-foil or area and foil or leak")


class ShaderGuard(NamedTuple):
    """A guard, by its text, which is in the file once."""

    path: str
    text: str
    replacement: str
    why: str
    tests: tuple


def _of(path, tests, *guards):
    return [ShaderGuard(path, *guard, tests) for guard in guards]


SHADER_GUARDS = [
    *_of("osl/perfect_hash.h", _FIT,
         ("if (slot >= KEY_COUNT)", "if (0)", "displaced slots wrap around"),
         ("keys[slot] == key ? slot : -1", "slot", "keys that are not stored")),
    *_of("osl/lattice.h", _FIT,
         ("max(h[2] * h[2], 1e-12)", "h[2] * h[2]", "both directions grazing"),
         ("min(0.5 * length(h), 1.0)", "0.5 * length(h)", "rounding at retro-reflection"),
         ("sqrt(max(1.0 - apart2 * apart2, 0.0) / (d2 + apart2))", "sqrt((1.0 - apart2 * apart2) / (d2 + apart2))",
          "rounding where directions are opposite"),
         ("if (d < 1e-7)", "if (0)", "retro-reflection without softening"),
         ("if (sin_i < 1e-7)", "if (0)", "normal incidence"),
         ("clamp((int)floor(u), -half, cells - 1 - half)", "(int)floor(u)", "coordinates of 1 are in the last cell"),
         ("max(locate(mu[0], cells, wa), 0)", "locate(mu[0], cells, wa)", "the half that is stored"),
         ("max(locate(mu[2], cells, wc), 0)", "locate(mu[2], cells, wc)", "the half that is stored"),
         ("if (slot >= 0)", "if (1)", "control points that are not stored"),
         ("exp(min(f, VALUE(STEEPEST)))", "exp(f)", "overflow between the samples"),
         ("min((prior(wi, wo) + PRIOR_OFFSET) * exp(min(f, VALUE(STEEPEST))) - PRIOR_OFFSET, VALUE(PRIOR_CEILING))",
          "(prior(wi, wo) + PRIOR_OFFSET) * exp(min(f, VALUE(STEEPEST))) - PRIOR_OFFSET",
          "the ceiling between the samples"),
         ("max(color(f), color(0.0))", "color(f)", "values below 0")),
    *_of("osl/draw.h", _DRAW,
         ("cell == 0 ? table[i] : table[i] - table[i - 1]", "table[i] - table[i - 1]", "the first cell of a view"),
         ("sqrt(max(0.0, 1.0 - w[2]))", "sqrt(1.0 - w[2])", "rounding at the normal"),
         ("min((int)(sqrt(max(0.0, 1.0 - w[2])) * DRAW_RINGS), DRAW_RINGS - 1)",
          "(int)(sqrt(max(0.0, 1.0 - w[2])) * DRAW_RINGS)", "the horizon is in the last ring"),
         ("min((int)(pow(away, 2.0 / 3.0) * DRAW_SECTORS), DRAW_SECTORS - 1)",
          "(int)(pow(away, 2.0 / 3.0) * DRAW_SECTORS)", "retro-reflection is in the last sector"),
         ("float r = sqrt(max(0.0, 1.0 - z * z));\n  return", "float r = sqrt(1.0 - z * z);\n  return", "rounding"),
         ("float r = sqrt(max(0.0, 1.0 - z * z));\n  float azimuth", "float r = sqrt(1.0 - z * z);\n  float azimuth",
          "rounding"),
         ("fabs(axis[2]) < 0.9 ? vector(0.0, 0.0, 1.0) : vector(1.0, 0.0, 0.0)", "vector(0.0, 0.0, 1.0)",
          "a lamp above the point")),
    *_of("osl/mixture.h", _MIXTURE,
         ("max(0.0, 1.0 - theta_o / GRAZING)", "1.0 - theta_o / GRAZING", "views beyond the last"),
         ("min((int)((VIEWS - 1) * (1.0 - pow(t, 2.0 / 3.0))), VIEWS - 2)",
          "(int)((VIEWS - 1) * (1.0 - pow(t, 2.0 / 3.0)))", "views beyond the last"),
         ("min((int)(7.0 * c), 6)", "(int)(7.0 * c)", "the last knot"),
         ("clamp(dot(axis, wi), 0.0, 1.0)", "dot(axis, wi)", "directions behind a lobe"),
         ("max(dot(h, wi), 0.0)", "dot(h, wi)", "directions below the half vector's horizon"),
         ("if (height < 1e-7)", "if (0)", "what Cycles leaves out of a lobe")),
    *_of("osl/lamps.h", _NOTED,
         ("max(length(toward), 1e-6)", "length(toward)", "a point inside a lamp without a size"),
         ("distance > extent[0] ? asin(extent[0] / distance) : M_PI_2", "asin(extent[0] / distance)",
          "a point inside a lamp"),
         ("l[2] > -sin(r) && length(wo + l) > 1e-3", "length(wo + l) > 1e-3", "lamps below the horizon"),
         ("l[2] > -sin(r) && length(wo + l) > 1e-3", "l[2] > 0.0 && length(wo + l) > 1e-3",
          "lamps that stand half below the horizon"),
         ("l[2] > -sin(r) && length(wo + l) > 1e-3", "l[2] > -sin(r)", "lamps opposite to the viewer"),
         ("e * max(l[2], 0.1)", "e * l[2]", "light of lamps on the horizon"),
         ("max(radius, MIN_LOBE_RADIUS)", "radius", "lobes of lamps without a size"),
         ("cosine <= 0.0 ? 0.0 : min(pow(cosine, exponent), 1.0)", "min(pow(cosine, exponent), 1.0)",
          "directions behind a lobe"),
         ("cosine <= 0.0 ? 0.0 : min(pow(cosine, exponent), 1.0)", "cosine <= 0.0 ? 0.0 : pow(cosine, exponent)",
          "rounding on the axis"),
         ("min((int)(7.0 * c), 6)", "(int)(7.0 * c)", "the last knot")),
    *_of("osl/measured_brdf.osl", _FRAME,
         ("length(Normal) > 1e-3 ? normalize(Normal) : N", "N", "the Normal input"),
         ("length(Normal) > 1e-3 ? normalize(Normal) : N", "normalize(Normal)", "an unconnected Normal"),
         ("if (facing < 1e-3)", "if (0)", "normals that are turned away from the viewer"),
         ("if (length(x_axis) < 1e-6)", "if (0)", "a viewer on the normal"),
         ("fabs(z_axis[0]) < 0.5 ? vector(1.0, 0.0, 0.0) : vector(0.0, 1.0, 0.0)", "vector(1.0, 0.0, 0.0)",
          "a viewer on the normal along x"),
         ("sqrt(max(0.0, 1.0 - dot(I, z_axis) * dot(I, z_axis)))", "sqrt(1.0 - dot(I, z_axis) * dot(I, z_axis))",
          "rounding at the normal"),
         ("acos(clamp(wo[2], 0.0, 1.0))", "acos(wo[2])", "rounding at the normal"),
         ("min(theta_o + OFFSET[view], STEEPEST_AXIS)", "theta_o + OFFSET[view]", "lobes below the horizon")),
    *_of("osl/measured_brdf.osl", _LARGE,
         ("if (Lamps >= n)", "if (1)", "lamps that the scene does not have"),
         ("if (radius[i] >= MAX_HIDDEN_RADIUS)", "if (1)", "small lamps are not drawn at"),
         ("if (random(P, 100.0 + i) * large_light <= light[i])", "if (1)", "one of the large lamps, by its light"),
         ("min(radius[i], M_PI_2)", "radius[i]", "a point inside a lamp")),
    *_of("osl/measured_brdf.osl", _EVEN,
         ("Even && large_radius == 0.0 && lamps <= MAX_LOBES", "large_radius == 0.0 && lamps <= MAX_LOBES",
          "the mixture is left out only in even light"),
         ("Even && large_radius == 0.0 && lamps <= MAX_LOBES", "Even && lamps <= MAX_LOBES",
          "the mixture stays where a large lamp is"),
         ("Even && large_radius == 0.0 && lamps <= MAX_LOBES", "Even && large_radius == 0.0",
          "the mixture stays where lobes are sampled"),
         ("if (Exact)", "if (1)", "Fast draws nothing"),
         ("often = max(often, AT_LEAST)", "often = often", "large lamps are drawn at often"),
         ("drawing && replacing ? 0.0 : 1.0", "1.0", "the mixture gives way to the drawn direction"),
         ("replacing ? 1.0 - often : 1.0", "1.0", "the mixture's part in the mean"),
         ("if (kept > 0.0)", "if (1)", "the mixture gives way to the drawn direction")),
    *_of("osl/measured_brdf.osl", _SMALL,
         ("radius[i] < MAX_LOBE_RADIUS", "1", "large lamps have no lobe"),
         ("if (lamps > MAX_LOBES)", "if (0)", "no more lobes than there is room for"),
         ("passed > next && lobes + taken < SAMPLED_LOBES + 1", "passed > next", "room for so many lobes"),
         ("if (share == 0.0)", "if (0)", "lamps that were not taken"),
         ("if (radius[i] < SMALL_LAMP_RADIUS)", "if (0)", "small lamps are evaluated at the middle"),
         ("if (l[2] > 1e-4)", "if (1)", "small lamps below the horizon"),
         ("if (w[2] > 1e-4)", "if (1)", "the part of a lamp below the horizon"),
         ("fabs(l[2]) < 0.9 ? vector(0.0, 0.0, 1.0) : vector(1.0, 0.0, 0.0)", "vector(0.0, 0.0, 1.0)",
          "a lamp above the point"),
         ("int hidden = radius[i] < MAX_HIDDEN_RADIUS;", "int hidden = 0;", "points anywhere on a small lamp's disk"),
         ("int anywhere = hidden || !Exact;", "int anywhere = hidden;", "points anywhere on the disk, for Fast"),
         ("here -= height[k] * shape;", "", "lobes that overlap are not counted twice"),
         ("usual -= mean_height[k] * shape;", "", "lobes that overlap are not counted twice, in the mean"),
         ("#define LAMP_WEIGHT 2e-4", "#define LAMP_WEIGHT 1.0", "lobes are hardly ever followed")),
    *_of("osl/measured_brdf.osl", _LARGE,
         ("large_radius > 0.0 && random(P, 7.5) < TOWARD_LAMP", "large_radius > 0.0",
          "not only large lamps are drawn at"),
         ("in_table = 1.0 - TOWARD_LAMP;", "", "the share of the table beside a large lamp"),
         ("if (dot(wi, large) >= cos(large_radius))", "if (1)", "density within the cone only")),
    *_of("osl/measured_brdf.osl", _DRAWN,
         ("int covered = wi[2] < 1e-4;", "int covered = 0;", "directions below the horizon"),
         ("radius[i] < MAX_HIDDEN_RADIUS && lobe_fall", "lobe_fall", "only small lamps are covered by their lobe"),
         (" > LOBE_FLAT)", " > 0.0)", "a lobe covers its flat part"),
         ("if (!covered)", "if (1)", "nothing is drawn at small lamps"),
         ("rest -= mean_height[i] * lobe_shape(lobe[i], wo, wi, lobe_fall(lobe[i], exponent[i], wi));", "",
          "what lobes carry is not drawn again"),
         ("(large_radius > 0.0 ? 1.5 : 1.0)", "1.0", "drawn directions at large lamps are followed oftener")),
]
