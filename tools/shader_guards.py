"""The guards of the shader, for `mutants`: where each is, what takes its place, and what it is for."""

from typing import NamedTuple

_OSL, _GUARDS, _RENDERING = "tests/osl/test_shader.py", "tests/osl/test_shader_guards.py", "tests/osl/test_rendering.py"
_FIT = (_OSL, "-k", "evaluates_the_fit and leather or every_part or version_2 or below_zero or slot")
_SAMPLING = (_OSL, _GUARDS, "-k", "drawn or cell")
_MIXTURE = (_OSL, _GUARDS, "-k", "mixture")
_ADDED = (_OSL, _GUARDS, "-k", "a_lobe or lamps_are_known or half_below or without_a_size")
_FRAME = (_GUARDS, _RENDERING, "-k", "viewer or turned_away or normal_input or sun-foil")
_LARGE = (_RENDERING, "-k", "area and foil")
_EVEN = (_GUARDS, _RENDERING, "-k", "adds_no_noise or fast_is_the or world-foil or area and foil")
_SMALL = (_GUARDS, _RENDERING, "-k", "shader_guards and lamp or sun-foil or close_together or more_lamps")
_REMAINDER = (_GUARDS, _RENDERING, "-k", "shader_guards and lamp or world-foil or area and foil or leak")


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
         ("slot >= KEY_COUNT ? slot - KEY_COUNT : slot", "slot", "displaced slots wrap around")),
    *_of("osl/prior.h", _FIT,
         ("max(h[2] * h[2], LEAST_HEIGHT_2)", "h[2] * h[2]", "both directions grazing"),
         ("min(0.5 * length(h), 1.0)", "0.5 * length(h)", "rounding at retro-reflection"),
         ("max(slope2, LEAST_SLOPE_2)", "slope2", "no sheen in the mirror direction")),
    *_of("osl/coordinates.h", _FIT,
         ("sqrt(max(1.0 - difference2 * difference2, 0.0) / (d2 + difference2))",
          "sqrt((1.0 - difference2 * difference2) / (d2 + difference2))", "rounding where directions are opposite"),
         ("if (d < LEAST_LENGTH)", "if (0)", "retro-reflection without softening"),
         ("if (sin_i < LEAST_LENGTH)", "if (0)", "normal incidence")),
    *_of("osl/lattice.h", _FIT,
         ("clamp((int)floor(u), -half, cells - 1 - half)", "(int)floor(u)", "coordinates of 1 are in the last cell"),
         ("max(locate_cell(mu[0], cells, wa), 0)", "locate_cell(mu[0], cells, wa)", "the half that is stored"),
         ("max(locate_cell(mu[2], cells, wc), 0)", "locate_cell(mu[2], cells, wc)", "the half that is stored"),
         ("if (stored & (1 << k))", "if (1)", "control points that are not stored")),
    *_of("osl/fit.h", _FIT,
         ("exp(min(f, VALUE(STEEPEST)))", "exp(f)", "overflow between the samples"),
         ("min((eval_prior(wi, wo) + PRIOR_OFFSET) * exp(min(f, VALUE(STEEPEST))) - PRIOR_OFFSET, "
          "VALUE(PRIOR_CEILING))",
          "(eval_prior(wi, wo) + PRIOR_OFFSET) * exp(min(f, VALUE(STEEPEST))) - PRIOR_OFFSET",
          "the ceiling between the samples"),
         ("max(color(f), color(0.0))", "color(f)", "values below 0")),
    *_of("osl/sampling_table.h", _SAMPLING,
         ("i == view * CELLS ? table[i] : table[i] - table[i - 1]", "table[i] - table[i - 1]",
          "the first cell of a view"),
         ("clamp(0.5 * length(w - axis), 0.0, 1.0)", "0.5 * length(w - axis)",
          "rounding opposite the mirror direction"),
         ("min((int)x, RINGS - 1) * SECTORS", "(int)x * SECTORS",
          "the last ring reaches the horizon behind the viewer"),
         ("min((int)y, SECTORS - 1);\n}", "(int)y;\n}", "a turn of 180 degrees is in the last sector"),
         ("sqrt(max(0.0, 1.0 - z * z))", "sqrt(1.0 - z * z)", "rounding")),
    *_of("osl/sampling_table.h", _MIXTURE,
         ("x = clamp(x - 0.5, 0.0, RINGS - 1.0);", "x -= 0.5;", "before the middle of the first ring"),
         ("y = clamp(y - 0.5, 0.0, SECTORS - 1.0);", "y -= 0.5;", "before the middle of the first sector"),
         ("min((int)x, RINGS - 2)", "(int)x", "beyond the middle of the last ring"),
         ("min((int)y, SECTORS - 2)", "(int)y", "beyond the middle of the last sector")),
    *_of("osl/mixture.h", _MIXTURE,
         ("max(0.0, 1.0 - theta_o / GRAZING)", "1.0 - theta_o / GRAZING", "views beyond the last"),
         ("min((int)((POLAR - 1) * (1.0 - pow(t, 2.0 / 3.0))), POLAR - 2)",
          "(int)((POLAR - 1) * (1.0 - pow(t, 2.0 / 3.0)))", "views beyond the last"),
         ("min((int)((KNOTS - 1.0) * c), KNOTS - 2)", "(int)((KNOTS - 1.0) * c)", "the last knot"),
         ("clamp(dot(view.axis[k], wi), 0.0, 1.0)", "dot(view.axis[k], wi)", "directions behind a lobe"),
         ("max(dot(view.half[k], wi), 0.0)", "dot(view.half[k], wi)", "directions below the half vector's horizon"),
         ("if (height < LEAST_PHONG)", "if (0)", "what Cycles leaves out of a lobe")),
    *_of("osl/mixture.h", _FRAME,
         ("acos(clamp(wo[2], 0.0, 1.0))", "acos(wo[2])", "rounding at the normal"),
         ("min(theta_o + angle, STEEPEST_AXIS)", "theta_o + angle", "lobes below the horizon")),
    *_of("osl/lamps.h", _ADDED,
         ("max(light * max(w[2], LEAST_LAMP_COSINE), LEAST_LAMP_LIGHT)", "light * max(w[2], LEAST_LAMP_COSINE)",
          "lamps whose strength is 0"),
         ("max(length(toward), LEAST_DISTANCE)", "length(toward)", "a point inside a lamp without a size"),
         ("distance > extent[0] ? asin(extent[0] / distance) : M_PI_2", "asin(extent[0] / distance)",
          "a point inside a lamp"),
         ("w[2] > -sin(radius) && length(frame.wo + w) > LEAST_HALF_VECTOR",
          "length(frame.wo + w) > LEAST_HALF_VECTOR", "lamps below the horizon"),
         ("w[2] > -sin(radius) && length(frame.wo + w) > LEAST_HALF_VECTOR",
          "w[2] > 0.0 && length(frame.wo + w) > LEAST_HALF_VECTOR", "lamps that stand half below the horizon"),
         ("w[2] > -sin(radius) && length(frame.wo + w) > LEAST_HALF_VECTOR", "w[2] > -sin(radius)",
          "lamps opposite to the viewer"),
         ("light * max(w[2], LEAST_LAMP_COSINE)", "light * w[2]", "light of lamps on the horizon")),
    *_of("osl/lamps.h", _SAMPLING,
         ("sqrt(max(0.0, 1.0 - z * z))", "sqrt(1.0 - z * z)", "rounding")),
    *_of("osl/lamps.h", _LARGE,
         ("if (random(seed, RANDOM_LAMP + i) * light <= lamps.light[i])", "if (1)", "one of the lamps, by its light"),
         ("return largest < SMALL_LAMP_RADIUS ? 0.0 : largest;", "return largest;",
          "small lamps are left to their lobes")),
    *_of("osl/lamps.h", _ADDED,
         ("clamp(radius, MIN_LOBE_RADIUS, MAX_LOBE_RADIUS)", "radius", "lobes of lamps without a size")),
    *_of("osl/lamp_lobes.h", _ADDED,
         ("cosine <= 0.0 ? 0.0 : min(pow(cosine, exponent), 1.0)", "min(pow(cosine, exponent), 1.0)",
          "directions behind a lobe"),
         ("cosine <= 0.0 ? 0.0 : min(pow(cosine, exponent), 1.0)", "cosine <= 0.0 ? 0.0 : pow(cosine, exponent)",
          "rounding on the axis"),
         ("min((int)(LAST_KNOT * c), KNOTS - 2)", "(int)(LAST_KNOT * c)", "the last knot")),
    *_of("osl/lamp_lobes.h", _SMALL,
         ("radius < MAX_LOBE_RADIUS && l[2] > HORIZON", "l[2] > HORIZON", "large lamps have no lobe"),
         ("radius < MAX_LOBE_RADIUS && l[2] > HORIZON", "radius < MAX_LOBE_RADIUS",
          "lamps whose middle is below the horizon"),
         ("if (lamps.count > MAX_LOBES)", "if (0)", "no more lobes than there is room for"),
         ("passed > next && lobes.count + taken < SAMPLED_LOBES + 1", "passed > next", "room for so many lobes"),
         ("if (times == 0.0)", "if (0)", "lamps that were not taken"),
         ('raytype("camera") ? 1.0 : small ? INDIRECT_PROBABILITY : 0.0', "1.0",
          "the fit is evaluated seldom where it shows less"),
         ("w[2] > HORIZON ? eval_missing(MISSING, view, w) : -mixed", "eval_missing(MISSING, view, w)",
          "the part of a lamp below the horizon"),
         ("if (exact) {", "if (0) {", "no lobe above a highlight that is smaller than its lamp"),
         ("unscaled + max(missing, color(0.0))", "unscaled + missing", "lobes do not subtract more than there is"),
         ("max(eval_fit(FIT, to_fit(l), to_fit(view.wo)) * l[2], least)",
          "eval_fit(FIT, to_fit(l), to_fit(view.wo)) * l[2]",
          "nothing is left of a mixture where the fit is 0"),
         ("normalize(axis + LOBE_TILT * perpendicular(axis))", "axis", "cosines that round to more than 1"),
         ("times * height * dot(half, axis) / dot(half, l)", "times * height", "a lobe is right beside its axis"),
         ("height -= eval_lobes(FLAT_RAMP, lobes, view.wo, l);", "", "lobes that overlap are not counted twice"),
         ("float weight = LAMP_LOBE_WEIGHT +", "float weight = 1.0 +", "lobes are hardly ever followed")),
    *_of("osl/lamp_lobes.h", _REMAINDER,
         ("lamps.radius[i] < SMALL_LAMP_RADIUS &&", "", "only small lamps are covered by their lobe"),
         (" > LOBE_FLAT)", " > 0.0)", "a lobe covers its flat part")),
    *_of("osl/shading_frame.h", _FRAME,
         ("length(shading_normal) > LEAST_NORMAL ? normalize(shading_normal) : surface_normal", "surface_normal",
          "the Normal input"),
         ("length(shading_normal) > LEAST_NORMAL ? normalize(shading_normal) : surface_normal",
          "normalize(shading_normal)", "an unconnected Normal"),
         ("if (facing < LEAST_FACING)", "if (0)", "normals that are turned away from the viewer"),
         ("if (length(tangent) < LEAST_TANGENT)", "if (0)", "a viewer on the normal"),
         ("sqrt(max(0.0, 1.0 - cosine * cosine))", "sqrt(1.0 - cosine * cosine)", "rounding at the normal")),
    *_of("osl/shading_frame.h", (*_SMALL[:-1], f"{_SMALL[-1]} or drawn or viewer"),
         ("fabs(axis[2]) < NEARLY_PARALLEL ? vector(0.0, 0.0, 1.0) : vector(1.0, 0.0, 0.0)", "vector(0.0, 0.0, 1.0)",
          "a lamp above the point, a viewer on the normal")),
    *_of("osl/measured_brdf.osl", _LARGE,
         ("if (Lamps >= n)", "if (1)", "lamps that the scene does not have")),
    *_of("osl/measured_brdf.osl", _EVEN,
         ("if (plan.mixture) {", "if (1) {", "the mixture gives way to the sampled direction")),
    *_of("osl/remainder_plan.h", _EVEN,
         ("exact && even && largest == 0.0 && lamps.count <= MAX_LOBES",
          "exact && largest == 0.0 && lamps.count <= MAX_LOBES", "the mixture is left out only in even light"),
         ("exact && even && largest == 0.0 && lamps.count <= MAX_LOBES", "exact && even && lamps.count <= MAX_LOBES",
          "the mixture stays where a lamp has a size"),
         ("exact && even && largest == 0.0 && lamps.count <= MAX_LOBES", "exact && even && largest == 0.0",
          "the mixture stays where lobes are sampled"),
         ("if (exact)", "if (1)", "Fast samples no remainder"),
         ("largest > 0.0 ? mix", "1 ? mix", "no lamp to sample directions about")),
    *_of("osl/remainder.h", _LARGE,
         ("random(seed, RANDOM_TOWARD_LAMP) < plan.toward_lamp", "plan.toward_lamp > 0.0",
          "directions are not sampled about lamps alone"),
         ("float density = (1.0 - plan.toward_lamp) * in_table;", "float density = in_table;",
          "the share of the table beside lamps")),
    *_of("osl/remainder.h", _REMAINDER,
         ("wi[2] >= HORIZON && !covered_by_lobe(lamps, wi)", "!covered_by_lobe(lamps, wi)",
          "directions below the horizon"),
         ("wi[2] >= HORIZON && !covered_by_lobe(lamps, wi)", "wi[2] >= HORIZON",
          "no remainder at small lamps"),
         (" - eval_lobes(FLAT_RAMP, lobes, view.wo, wi);", ";", "what lobes carry is not sampled again")),
]
