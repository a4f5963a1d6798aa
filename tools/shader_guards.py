"""The guards of the shader, for `mutants`: where each is, what takes its place, and what it is for."""

from typing import NamedTuple

_OSL, _GUARDS, _RENDERING = "tests/osl/test_shader.py", "tests/osl/test_shader_guards.py", "tests/osl/test_rendering.py"
_FIT = (_OSL, "-k", "evaluates_the_fit and leather or every_part or below_zero or slot")
_EDITED = ("tests/osl/test_edited_shader.py",)
_MIX = ("tests/addon/mix/test_mix.py", "-k", "no_room or beyond")
_TANGENT = ("tests/osl/test_anisotropic_rendering.py", "-k", "tangent or sun-brushed")
_MIXTURE = ("tests/osl/test_mixture.py",)
_ADDED = (_OSL, _GUARDS, "-k", "a_lobe or lamps_are_known or half_below or without_a_size")
_FRAME = (_GUARDS, _RENDERING, "-k", "viewer or turned_away or normal_input or krylon-sun")
_LARGE = (_GUARDS, _RENDERING, "-k", "beside_a_lamp or area and krylon")
_SHARP = (_RENDERING, "-k", "mirror or rough_bounce")
_EVERYWHERE = (_RENDERING, "-k", "foil-world or area and krylon or strength")
_SMALL = (_GUARDS, _RENDERING, "-k", "shader_guards and lamp or krylon-sun or close_together or in_every_pixel")
_FRUGAL = ("tests/osl/test_frugal.py", "-k", "eight_lamps or no_more_lobes")
_REMAINDER = (_GUARDS, _RENDERING, "-k", "shader_guards and lamp or foil-world or area and krylon or leak")
_PROBED = (_GUARDS, "-k", "light_of_a_lamp or stands_at or directions_are or covers or small_lamp_is_as or beyond_its "
                            "or that_were_taken or last_coord or overflows or lamps_are_known")
_DOTS = ("tests/benchmarks/test_black_pixels.py", "-k", "far_below")
_HALF = (_GUARDS, "-k", "half_below")


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
         ("max(slope2, LEAST_SLOPE_2)", "slope2", "no sheen in the mirror direction")),
    *_of("osl/coordinates.h", _FIT,
         ("if (sin_i < LEAST_LENGTH)", "if (0)", "normal incidence")),
    *_of("osl/lattice.h", _FIT,
         ("if (stored & (1 << k))", "if (1)", "control points that are not stored")),
    *_of("osl/unedited_fit.h", _FIT,
         ("  f /= smooth_max_one(largest(color(f / VALUE(PRIOR_CEILING))));\n", "", "the ceiling between the samples"),
         ("max(f, VALUE(0.0))", "f", "values below 0")),
    *_of("osl/edit.h", _EDITED,
         ("max(w[2] * cosine - before * sine, LEAST_HORIZON_COSINE)", "w[2] * cosine - before * sine",
          "directions that are turned below the horizon"),
         ("sqrt(max(h[2] * h[2], LEAST_HEIGHT_2))", "h[2]", "both directions grazing"),
         ("(h[0] * h[0] + h[1] * h[1]) / max(h[2] * h[2], LEAST_HEIGHT_2)",
          "(h[0] * h[0] + h[1] * h[1]) / (h[2] * h[2])", "a coat where both directions are grazing"),
         ("COAT_ALPHA_2) + COAT_ALPHA_2), LEAST_LENGTH)", "COAT_ALPHA_2) + COAT_ALPHA_2), 0.0)",
          "a narrow coat where both directions are grazing")),
    *_of("osl/mix.osl", _MIX,
         ("if (Frugal || Mixed > MOST_MIXED)", "if (Mixed > MOST_MIXED)", "closures of two on a GPU"),
         ("if (Frugal || Mixed > MOST_MIXED)", "if (Frugal)", "closures of three"),
         ("clamp(Factor, 0.0, 1.0)", "Factor", "masks beyond black and white")),
    *_of("osl/mixture.h", _MIXTURE,
         ("min((theta - low) / (high - low), 1.0)", "(theta - low) / (high - low)", "views beyond the last stop"),
         ("min(anisotropy < 0.0 ? wide : narrow, 1.0)", "(anisotropy < 0.0 ? wide : narrow)",
          "no lobe is wider than closures are"),
         ("min(anisotropy < 0.0 ? narrow : wide, 1.0)", "(anisotropy < 0.0 ? narrow : wide)",
          "no lobe is wider than closures are"),
         ("else if (run2 > height * height / (1.6 * 1.6))", "else",
          "facets hide little where a direction is far from the horizon"),
         ("if (i[2] > LEAST_COSINE)", "if (1)", "directions below the horizon of a lobe"),
         ("o[2] > 0.0 ? 0.25 / max(o[2], LEAST_COSINE) : 0.0", "0.25 / max(o[2], LEAST_COSINE)",
          "viewers below the horizon of a lobe"),
         ("value = max(dot(mixture.axis[k], wi), 0.0) / M_PI;", "value = dot(mixture.axis[k], wi) / M_PI;",
          "directions below the horizon of a diffuse lobe"),
         ("  if (k < LOBES) {", "  {", "directions that follow no lobe")),
    *_of("osl/lamps.h", _ADDED,
         ("if (light > 0.0 && w[2] > -sin(radius))", "if (w[2] > -sin(radius))", "lamps whose strength is 0"),
         ("if (light > 0.0 && w[2] > -sin(radius))", "if (light > 0.0)", "lamps below the horizon"),
         ("if (light > 0.0 && w[2] > -sin(radius))", "if (light > 0.0 && w[2] > 0.0)",
          "lamps that stand half below the horizon")),
    *_of("osl/lamps.h", _SMALL,
         ("clamp(radius + LOBE_MARGIN, MIN_LOBE_RADIUS, MAX_LOBE_RADIUS)", "radius + LOBE_MARGIN",
          "lobes of lamps without a size")),
    *_of("osl/light_lobes.h", _SMALL,
         ("normalize(axis + LOBE_TILT * perpendicular(axis))", "axis", "cosines that round to more than 1"),
         ("height -= eval_lobes(FLAT_RAMP, lobes, wo, l);", "",
          "lobes that overlap are not counted twice"),
         ("float weight = LIGHT_LOBE_WEIGHT;", "float weight = 1.0;", "lobes are hardly ever followed")),
    *_of("osl/light_lobes.h", _FRUGAL,
         ("times[i] > 0.0 || (has_lobe(lamps, i) && reaches_needed(lamps, i, needed))", "times[i] > 0.0",
          "a lobe before those that were taken may reach them"),
         ("closure_limited ? lamps.light[i] * has_lobe(lamps, i) : lamps.light[i]", "lamps.light[i]",
          "the only lobe is not left to a lamp that has none")),
    *_of("osl/shading_frame.h", _FRAME,
         ("length(shading_normal) > LEAST_NORMAL ? normalize(shading_normal) : surface_normal", "surface_normal",
          "the Normal input"),
         ("length(shading_normal) > LEAST_NORMAL ? normalize(shading_normal) : surface_normal",
          "normalize(shading_normal)", "an unconnected Normal"),
         ("if (facing < LEAST_FACING)", "if (0)", "normals that are turned away from the viewer"),
         ("if (length(tangent) < LEAST_TANGENT)", "if (0)", "a viewer on the normal")),
    *_of("osl/shading_frame.h", _TANGENT,
         ("length(Tangent) > LEAST_TANGENT ? Tangent : MeshTangent", "Tangent", "an unconnected Tangent"),
         ("length(Tangent) > LEAST_TANGENT ? Tangent : MeshTangent", "MeshTangent", "the Tangent input")),
    *_of("osl/shading_frame.h", (*_SMALL[:-1], f"{_SMALL[-1]} or drawn or viewer"),
         ("fabs(axis[2]) < NEARLY_PARALLEL ? vector(0.0, 0.0, 1.0) : vector(1.0, 0.0, 0.0)", "vector(0.0, 0.0, 1.0)",
          "a lamp above the point, a viewer on the normal")),
    *_of("osl/measured_brdf.osl", _SHARP,
         ('(Everywhere || raytype("camera") || raytype("singular"))', '(Everywhere || raytype("camera"))',
          "what is seen in a mirror is exact"),
         ('(Everywhere || raytype("camera") || raytype("singular"))', "1",
          "after a rough bounce the mixture stands in")),
    *_of("osl/residual.h", _DOTS,
         ("mixture.balance * max(all.residual[last], 0.0)", "all.residual[last]",
          "a sampled direction takes nothing away from lights that the shader does not know")),
    *_of("osl/lamps.h", _HALF,
         ("above = max(above, clamp(0.5 + 0.5 * lamps.direction[i][2] / sin(radius), 0.0, 1.0));", "",
          "toward known lamps it may")),
    *_of("osl/residual.h", _EVERYWHERE,
         ("if (plan.sampled)", "if (1)", "some samples have a direction, and make up for the others")),
    *_of("osl/residual.h", _LARGE,
         ("random(seed, RANDOM_TOWARD_LAMP) < plan.toward_lamp", "plan.toward_lamp > 0.0",
          "directions are not sampled about lamps alone"),
         ("(1.0 - plan.toward_lamp) * all.pdf", "all.pdf",
          "the share of the mixture's directions beside lamps")),
    *_of("osl/residual.h", _REMAINDER,
         ("all.direction[last][2] >= LEAST_HORIZON_COSINE && !lobe_covers(lamps, all.direction[last])",
          "!lobe_covers(lamps, all.direction[last])",
          "directions below the horizon"),
         ("all.direction[last][2] >= LEAST_HORIZON_COSINE && !lobe_covers(lamps, all.direction[last])",
          "all.direction[last][2] >= LEAST_HORIZON_COSINE",
          "no residual at small lamps"),
         ("color lobed = eval_lobes(FLAT_RAMP, lobes, mixture.wo, wi);", "color lobed = 0.0;",
          "what lobes carry is not sampled again")),
    *_of("osl/lattice.h", _PROBED,
         ("clamp((int)floor(u), first, cells - 1 - half)", "(int)floor(u)", "coordinates of 1 are in the last cell")),
    *_of("osl/unedited_fit.h", _PROBED,
         ("exp(min(f, VALUE(LARGEST_EXPONENT)))", "exp(f)", "overflow between the samples")),
    *_of("osl/mixture.h", _PROBED,
         ("clamp((int)x, 0, POLAR_KNOTS - 2)", "(int)x", "the last stop, and views beyond it")),
    *_of("osl/lamps.h", _PROBED,
         ("return widest < SMALL_LAMP_RADIUS ? 0.0 : widest;", "return widest;",
          "small lamps are left to their lobes"),
         ("light * max(w[2], LEAST_LAMP_COSINE)", "light * w[2]", "light of lamps on the horizon")),
    *_of("osl/light_lobes.h", _PROBED,
         ("cosine <= 0.0 ? 0.0 : pow(cosine, exponent)", "pow(cosine, exponent)", "directions behind a lobe"),
         ("clamp((int)(LAST_KNOT * c), 0, KNOTS - 2)", "(int)(LAST_KNOT * c)", "the last knot"),
         ("lamps.radius[lamp] < MAX_LOBE_RADIUS && lamps.direction[lamp][2] > LEAST_HORIZON_COSINE",
          "lamps.direction[lamp][2] > LEAST_HORIZON_COSINE", "large lamps have no lobe"),
         ("lamps.radius[lamp] < MAX_LOBE_RADIUS && lamps.direction[lamp][2] > LEAST_HORIZON_COSINE",
          "lamps.radius[lamp] < MAX_LOBE_RADIUS", "lamps whose middle is below the horizon"),
         ("height * dot(half, axis) / dot(half, l)", "height", "a lobe is right beside its axis"),
         ("lobes.present[i] = lobes.times[i] > 0.0;", "lobes.present[i] = 1;", "lamps that were not taken"),
         ("lamps.radius[i] < SMALL_LAMP_RADIUS &&", "", "only small lamps are covered by their lobe"),
         (" > LOBE_FLAT)", " > 0.0)", "a lobe covers its flat part")),
    *_of("osl/residual.h", _PROBED,
         ("largest > 0.0 ? mix", "1 ? mix", "no lamp to sample directions about")),
    *_of("osl/residual.h", (_GUARDS, "-k", "nothing_is_subtracted"),
         ("many || largest == 0.0 ? 1.0", "many ? 1.0", "small lamps alone have hardly any noise")),
    *_of("osl/light_lobes.h", (_RENDERING, "-k", "two_area"),
         ("lobes.height[i] / share", "lobes.height[i]", "some samples have lobes, and make up for the others")),
    *_of("osl/lamps.h", (_OSL, "-k", "directions_about"),
         ("if (random(seed, RANDOM_LAMP + i) * light <= lamps.light[i])", "if (1)", "one of the lamps, by its light")),
]
