/* Residual sampling: the fit less a mixture below it and the light lobes, carried by one sampled direction. */

#include "fit.h"
#include "mixture.h"
#include "lamps.h"
#include "light_lobes.h"
#include "random.h"
#include "shading_frame.h"

/* How a sample of a shading point carries it. */
struct ResidualPlan {
  int exact;                /* whether this sample has light lobes, and may have a direction */
  float exact_share;        /* how many have */
  int sampled;              /* whether it has a direction */
  float probability;        /* with which a sample has one */
  float toward_lamp;        /* the selection probability of directions about a lamp */
};

/* Of several lamps Cycles takes one at random in a sample. Beside the noise of that it is little, and saves time, that
 * some samples show the mixture alone, and the others as much more of the rest. Small lamps alone have hardly any noise,
 * and of many lamps some are taken already. */
ResidualPlan plan_residual(Mixture mixture, LampList lamps, int many, point seed)
{
  ResidualPlan plan;
  float largest = largest_radius(lamps);
  float size = min(largest / LARGE_LAMP_RADIUS, 1.0);
  plan.exact_share = many || largest == 0.0 ? 1.0 : clamp(1.0 / lamps_alike(lamps), mixture.probability, 1.0);
  plan.exact = random(seed, RANDOM_EXACT) < plan.exact_share;
  float sampled_share = max(mixture.probability / plan.exact_share, size);
  plan.sampled = random(seed, RANDOM_RESIDUAL) < sampled_share;
  plan.probability = plan.exact_share * sampled_share;
  plan.toward_lamp = largest > 0.0 ? mix(LEAST_LAMP_SHARE, LARGE_LAMP_SHARE, size) : 0.0;
  return plan;
}

/* A direction, from the mixture or about a lamp. */
vector sample_residual(Mixture mixture, LampList lamps, ResidualPlan plan, point seed)
{
  vector wi;
  if (random(seed, RANDOM_TOWARD_LAMP) < plan.toward_lamp) {
    int lamp = sample_lamp(lamps, seed);
    wi = sample_cone(lamps.direction[lamp], lamps.radius[lamp], seed);
  }
  else {
    wi = sample_mixture(mixture, seed);
  }
  return wi;
}

/* The sum of the channels. */
float channel_sum(color c)
{
  return c[0] + c[1] + c[2];
}

/* The weights of the mixture's closures that are in the denoiser's albedo. Cycles leaves out narrow lobes there, as long
 * as others have more than a quarter of all weights. */
color denoised_weights(Mixture mixture)
{
  color all = 0.0;
  color narrow = 0.0;
#define ADD_WEIGHT(k, kind) \
  all += mixture.weight[k]; \
  if (kind >= GGX_LOBE && mixture.along[k] * mixture.across[k] <= NARROW_WIDTH * NARROW_WIDTH) { \
    narrow += mixture.weight[k]; \
  }
  EACH_LOBE(ADD_WEIGHT)
  return channel_sum(narrow) < MOST_NARROW * channel_sum(all) ? all - narrow : all;
}

/* What a sampled direction carries, over the pdf. */
struct Carried {
  vector direction;
  color value;
  float corrected;          /* the share that it takes away, or adds, of what other samples show of the whole lamp */
};

/* What is left in the sampled direction besides the mixture and the lobes.
 *
 * Toward a known lamp it corrects what they show. A direction takes away no more than a share of what is shown, and is
 * followed as often as the correction is large in the channel that loses most, so that no sample takes away more than
 * others show of the whole lamp; on bright surfaces, whose weights leave no room for that in the denoiser's albedo, a
 * few times as much. A small correction, and what a direction may not take away, is given to the lobe of the lamp, evenly
 * over the lamp: its mean is right. Elsewhere a direction takes nothing away, as one that meets a light by chance would
 * leave a black pixel: what the mixture has above the fit is given less of what is left instead. */
Carried carry_residual(float FLAT_RAMP[], Mixture mixture, Evaluated all, LampList lamps, ResidualPlan plan,
                       output LightLobes lobes)
{
  int last = all.count - 1;
  vector wi = all.direction[last];
  color lobed = eval_lobes(FLAT_RAMP, lobes, mixture.wo, wi);
  color value = all.residual[last] - lobed;
  float pdf = (1.0 - plan.toward_lamp) * all.pdf;
  if (plan.toward_lamp > 0.0) {
    pdf += plan.toward_lamp * pdf_lamps(lamps, wi);
  }
  pdf *= plan.probability;
  Carried carried;
  carried.direction = wi;
  carried.corrected = 0.0;
  float solid_angle;
  float above = visible_lamp_fraction(lamps, wi, solid_angle);
  if (above > 0.0) {
    color shown = all.mixed[last] + lobed;
    /* what other samples show of the whole lamp, in the mean */
    color whole = shown * (solid_angle * pdf);
    carried.corrected = min(max(largest(-value / whole),
                                channel_sum(fabs(value)) / max(channel_sum(whole), LEAST_WEIGHT)), 1.0);
    int is_small = channel_sum(fabs(value)) < SMALL_CORRECTION * channel_sum(shown);
    color followed = is_small ? color(0.0) : max(value, -min(carried.corrected * whole, MOST_CORRECTED * above * shown));
    int is_spread = spread_over_lamp(lamps, wi, (value - followed) * (plan.exact_share / (pdf * above)), shown, lobes);
    if (is_spread || !is_small) {
      value = followed;
    }
  }
  else {
    value = mixture.balance * max(all.residual[last], 0.0) - lobed;
  }
  carried.value = value / pdf;
  return carried;
}

/* A phong_ramp so narrow that it sends a path in the sampled direction. What carries more is followed more often; in the
 * mean the weights of all closures are the albedo of the fit, which is the denoiser's. */
closure color residual_closure(Mixture mixture, Carried carried, ResidualPlan plan, ShadingFrame frame, color tint)
{
  vector half = normalize(mixture.wo + carried.direction);
  color room = (1.0 - CORRECTION_WEIGHT * plan.toward_lamp) * mixture.albedo - denoised_weights(mixture);
  color usual = max(room, LEAST_FOLLOWED * mixture.albedo) / plan.probability;
  float size = channel_sum(fabs(carried.value)) * plan.probability / max(channel_sum(mixture.residual), LEAST_WEIGHT);
  float followed = clamp((1.0 - largest(mixture.albedo)) / BRIGHT, LEAST_CORRECTION, 1.0);
  color weight = max(size * usual, mixture.albedo * (followed * carried.corrected));
  weight = max(weight, color(max(LEAST_COLOUR * largest(weight), LEAST_WEIGHT)));
  color colour = carried.value / weight *
                 ((RESIDUAL_EXPONENT + 1.0) / ((RESIDUAL_EXPONENT + 2.0) * dot(half, carried.direction)));
  color ramp[KNOTS];
  for (int j = 0; j < KNOTS; j++) {
    ramp[j] = colour;
  }
  color tinted = weight * tint;
  return tinted * phong_ramp(to_world(frame, half), RESIDUAL_EXPONENT, ramp);
}

/* What the fit has besides a mixture below it: light lobes, and a direction in some samples. A direction needs no
 * closure where the lobe of a small lamp carries everything. `crowded` is whether there may be more lamps than lobes, a
 * constant, as code takes time to compile. */
closure color exact_closures(FIT_PARAMETERS, float FLAT_RAMP[], LampList lamps, int crowded, int closure_limited,
                             ShadingFrame frame, color tint, point seed, output Mixture mixture)
{
  closure color sum = 0;
  int many = crowded && lamps.count > max_light_lobes(closure_limited);
  ResidualPlan plan = plan_residual(mixture, lamps, many, seed);
  if (plan.exact) {
    Evaluated all;
    LightLobes lobes;
    float times[MAX_LAMPS];
    if (many) {
      sample_lobes(lamps, closure_limited, seed, times);
      needed_lobes(lamps, times, all.needed);
    }
    for (int i = 0; i < lamps.count; i++) {
      all.direction[i] = lamps.direction[i];
      if (!many) {
        all.needed[i] = has_lobe(lamps, i);
        times[i] = 1.0;
      }
    }
    int last = lamps.count;
    all.count = last + 1;
    all.needed[last] = 0;
    if (plan.sampled) {
      all.direction[last] = sample_residual(mixture, lamps, plan, seed);
      all.needed[last] = all.direction[last][2] >= LEAST_HORIZON_COSINE && !lobe_covers(lamps, all.direction[last]);
    }
    prepare_facets(mixture);
    evaluate_all(FIT, mixture, all);
    fit_light_lobes(FLAT_RAMP, lamps, all, mixture, times, lobes);
    if (many) {
      keep_sampled_lobes(lobes);
    }
    if (all.needed[last]) {
      Carried carried = carry_residual(FLAT_RAMP, mixture, all, lamps, plan, lobes);
      if (carried.value != color(0.0)) {
        sum = residual_closure(mixture, carried, plan, frame, tint);
      }
    }
    sum = sum + light_lobe_closures(FLAT_RAMP, lobes, plan.exact_share, frame, tint);
  }
  return sum;
}
