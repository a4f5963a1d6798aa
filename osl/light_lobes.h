/* Light lobes: phong_ramps that are aligned with a lamp and flat over its disk, and carry there the residual of the
 * mixture. */

#include "fit.h"
#include "mixture.h"
#include "lamps.h"
#include "shading_frame.h"

#define LAST_KNOT (KNOTS - 1.0)
#define LOBE_FLAT (LOBE_EDGE_KNOT / LAST_KNOT)      /* a lobe is flat where it has not fallen further */

struct LightLobes {
  vector axis[MAX_LAMPS];
  float exponent[MAX_LAMPS];
  color height[MAX_LAMPS];              /* of the value along the axis */
  float times[MAX_LAMPS];               /* by which a lobe is multiplied, where some lamps are taken of many */
  int present[MAX_LAMPS];               /* whether a lamp, whose number is that of its lobe, has one */
  int count;
};

/* The axis of the lobe at a lamp: its middle, or beside a small lamp. */
vector lobe_axis(LampList lamps, int lamp)
{
  vector axis = lamps.direction[lamp];
  return lamps.radius[lamp] < SMALL_LAMP_RADIUS ? normalize(axis + LOBE_TILT * perpendicular(axis)) : axis;
}

/* cos(angle from the axis) ^ exponent. */
float lobe_falloff(vector axis, float exponent, vector w)
{
  float cosine = dot(axis, w);
  return cosine <= 0.0 ? 0.0 : pow(cosine, exponent);
}

/* The sum of all lobes in a direction: what Cycles makes of them. */
color eval_lobes(float FLAT_RAMP[], LightLobes lobes, vector wo, vector w)
{
  color sum = 0.0;
  for (int i = 0; i < lobes.count; i++) {
    vector axis = lobes.axis[i];
    float c = lobes.present[i] ? lobe_falloff(axis, lobes.exponent[i], w) : 0.0;
    if (c > LEAST_FALLOFF) {
      int j = clamp((int)(LAST_KNOT * c), 0, KNOTS - 2);
      vector h = wo + axis;
      sum += lobes.height[i] * (c * mix(FLAT_RAMP[j], FLAT_RAMP[j + 1], LAST_KNOT * c - j) * dot(h, w) / dot(h, axis));
    }
  }
  return sum;
}

/* Whether a direction is in the flat part of the lobe of a small lamp, which alone renders that lamp. */
int lobe_covers(LampList lamps, vector w)
{
  for (int i = 0; i < lamps.count; i++) {
    if (lamps.radius[i] < SMALL_LAMP_RADIUS &&
        lobe_falloff(lobe_axis(lamps, i), lobe_exponent(lamps.radius[i]), w) > LOBE_FLAT) {
      return 1;
    }
  }
  return 0;
}

/* Whether a lamp has a lobe. */
int has_lobe(LampList lamps, int lamp)
{
  return lamps.radius[lamp] < MAX_LOBE_RADIUS && lamps.direction[lamp][2] > LEAST_HORIZON_COSINE;
}

/* Take some of the lamps by systematic sampling, in proportion to their light. `times` is what a lamp's lobe is
 * multiplied by: how often the lamp is taken, over how often that is expected. Where few closures fit, no light is left
 * to lamps that have no lobe. */
void sample_lobes(LampList lamps, int closure_limited, point seed, output float times[MAX_LAMPS])
{
  float all_light = 0.0;
  for (int i = 0; i < lamps.count; i++) {
    times[i] = closure_limited ? lamps.light[i] * has_lobe(lamps, i) : lamps.light[i];
    all_light += times[i];
  }
  float stride = all_light / (closure_limited ? CLOSURE_LIMITED_LOBES : SAMPLED_LOBES);
  float next = stride * random(seed, RANDOM_LOBES);
  float passed = 0.0;
  for (int i = 0; i < lamps.count; i++) {
    float taken = 0.0;
    passed += times[i];
    while (passed > next) {
      taken += 1.0;
      next += stride;
    }
    times[i] = has_lobe(lamps, i) * taken * stride / lamps.light[i];
  }
}

/* Whether the lobe of a lamp reaches any of the lamps behind it in the list that are `needed`. */
int reaches_needed(LampList lamps, int lamp, int needed[DIRECTIONS])
{
  float radius = lobe_radius(lamps.radius[lamp]);
  for (int i = lamp + 1; i < lamps.count; i++) {
    if (needed[i] && dot(lamps.direction[lamp], lamps.direction[i]) > cos(LOBE_REACH * radius)) {
      return 1;
    }
  }
  return 0;
}

/* The lobes whose heights are needed: of the lamps that are taken, and of those whose lobes reach them. */
void needed_lobes(LampList lamps, float times[MAX_LAMPS], output int needed[DIRECTIONS])
{
  for (int i = lamps.count - 1; i >= 0; i--) {
    needed[i] = times[i] > 0.0 || (has_lobe(lamps, i) && reaches_needed(lamps, i, needed));
  }
}

/* Leave only the lobes of the lamps that were taken. */
void keep_sampled_lobes(output LightLobes lobes)
{
  for (int i = 0; i < lobes.count; i++) {
    lobes.present[i] = lobes.times[i] > 0.0;
    lobes.height[i] = lobes.times[i] * lobes.height[i];
  }
}

/* What a mixture below the fit leaves of it at the lamps that have lobes, in all or some of many, and in a sampled
 * direction. */
struct Evaluated {
  int count;                            /* directions; the last one is sampled */
  int needed[DIRECTIONS];
  vector direction[DIRECTIONS];
  color mixed[DIRECTIONS];              /* the mixture */
  color residual[DIRECTIONS];           /* times cos theta_i */
  float pdf;                            /* with which `sample_mixture` returns the last one */
};

/* Evaluate it, in one place, as a compiler makes code of all that a function calls. `needed` is given. */
void evaluate_all(FIT_PARAMETERS, Mixture mixture, output Evaluated all)
{
  for (int i = 0; i < all.count; i++) {
    if (all.needed[i]) {
      vector w = all.direction[i];
      color mixed = eval_mixture(mixture, w, all.pdf);
      all.mixed[i] = mixed;
      all.residual[i] = eval_fit(FIT, to_fit(w), to_fit(mixture.wo)) * w[2] - mixed;
    }
  }
}

/* The lobes at the lamps, or at some of many: as high as what is left in the middle of the lamp. Those of lamps that are
 * not small reflect no more than all that is left, as a peak may be narrower than the lamp, and take away no more than a
 * share of the mixture, as toward the lamp's edge that may be less. */
void fit_light_lobes(float FLAT_RAMP[], LampList lamps, Evaluated all, Mixture mixture, float times[MAX_LAMPS],
                     output LightLobes lobes)
{
  vector wo = mixture.wo;
  for (int i = 0; i < lamps.count; i++) {
    lobes.count = i;
    lobes.present[i] = all.needed[i];
    lobes.times[i] = times[i];
    if (all.needed[i]) {
      vector l = lamps.direction[i];
      float radius = lamps.radius[i];
      color height = all.residual[i];
      lobes.exponent[i] = lobe_exponent(radius);
      if (radius >= SMALL_LAMP_RADIUS) {
        height = clamp(height, -MOST_TAKEN * all.mixed[i],
                       mixture.residual * (MOST_GIVEN * lobes.exponent[i] / LOBE_SOLID_ANGLE));
        /* over a lamp near the horizon the fit falls to 0 */
        float raised = min(l[2] / (LOBE_RAISED * sin(radius)), 1.0);
        height *= raised * raised;
      }
      /* near other lamps, the lobes before this one carry a part already */
      height -= eval_lobes(FLAT_RAMP, lobes, wo, l);
      vector axis = lobe_axis(lamps, i);
      vector half = wo + axis;
      lobes.axis[i] = axis;
      lobes.height[i] = height * dot(half, axis) / dot(half, l);
    }
  }
  lobes.count = lamps.count;
}

/* Give the lobe of a lamp a value in one direction, over the pdf of that direction, evenly: what the directions in the
 * middle of the lamp have, up to as large a part as the lamp fills, stands for all of it. It takes away MOST_SPREAD times
 * what is shown at most. False where no lobe has the direction, or where it is multiplied. */
int spread_over_lamp(LampList lamps, vector w, color value, color shown, output LightLobes lobes)
{
  for (int i = 0; i < lobes.count; i++) {
    float radius = lamps.radius[i];
    float cosine = dot(lobes.axis[i], w);
    if (lobes.present[i] && radius >= SMALL_LAMP_RADIUS && lamps.core[i] > 0.0 && lobes.times[i] == 1.0 &&
        cosine > cos(radius)) {
      float edge = cos(lamps.core[i] * radius);
      if (cosine > edge) {
        lobes.height[i] += max(value / (M_2PI * (1.0 - edge)), -MOST_SPREAD * max(shown, 0.0));
      }
      return 1;
    }
  }
  return 0;
}

/* `share` is how many samples have lobes. A lobe is hardly ever followed: Cycles finds lamps by sampling them, and the
 * weights of all closures are the denoiser's albedo. */
closure color light_lobe_closures(float FLAT_RAMP[], LightLobes lobes, float share, ShadingFrame frame, color tint)
{
  closure color sum = 0;
  for (int i = 0; i < lobes.count; i++) {
    if (lobes.present[i]) {
      vector half = normalize(frame.wo + lobes.axis[i]);
      color height = lobes.height[i] / share;
      float weight = LIGHT_LOBE_WEIGHT;
      color top = height * (M_2PI / (weight * dot(half, lobes.axis[i]) * (lobes.exponent[i] + 2.0)));
      color ramp[KNOTS];
      for (int j = 0; j < KNOTS; j++) {
        ramp[j] = FLAT_RAMP[j] * top;
      }
      color tinted = weight * tint;
      sum += tinted * phong_ramp(to_world(frame, half), lobes.exponent[i], ramp);
    }
  }
  return sum;
}
