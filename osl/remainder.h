/* The remainder: what the fit has besides the mixture and the lobes at lamps, carried by one sampled direction. */

/* How a sample of a shading point carries it. */
struct RemainderPlan {
  int sampled;              /* whether this sample has a direction */
  float probability;        /* with which it has */
  float toward_lamp;        /* the share of the directions that are taken about a lamp */
  float weight;             /* share of a direction in the closure weights of the sample */
};

RemainderPlan plan_remainder(Mixture mixture, LampList lamps, point seed)
{
  RemainderPlan plan;
  float largest = largest_radius(lamps);
  float size = min(largest / LARGE_LAMP_RADIUS, 1.0);
  plan.probability = max(mixture.probability, size * LARGE_LAMP_PROBABILITY);
  plan.weight = max(mixture.picked, size * LARGE_LAMP_WEIGHT);
  plan.toward_lamp = largest > 0.0 ? mix(LEAST_LAMP_SHARE, LARGE_LAMP_SHARE, size) : 0.0;
  plan.sampled = random(seed, RANDOM_REMAINDER) < plan.probability;
  return plan;
}

/* A phong_ramp so narrow that it sends a path in the sampled direction, and no closure where the lobe of a small lamp
 * carries everything. */
closure color remainder_closure(FIT_PARAMETERS, float FLAT_RAMP[], Mixture mixture, LampList lamps, LampLobes lobes,
                                RemainderPlan plan, ShadingFrame frame, color tint, point seed)
{
  closure color made = 0;
  vector wi;
  if (random(seed, RANDOM_TOWARD_LAMP) < plan.toward_lamp) {
    int lamp = sample_lamp(lamps, seed);
    wi = sample_cone(lamps.direction[lamp], lamps.radius[lamp], seed);
  }
  else {
    wi = sample_mixture(mixture, seed);
  }
  if (wi[2] >= HORIZON && !covered_by_lobe(lamps, wi)) {
    float density;
    color mixed = eval_mixture(mixture, wi, density);
    color value = eval_target(FIT, mixture, wi, mixed) - mixed - eval_lobes(FLAT_RAMP, lobes, mixture.wo, wi);
    density *= 1.0 - plan.toward_lamp;
    if (plan.toward_lamp > 0.0) {
      density += plan.toward_lamp * pdf_lamps(lamps, wi);
    }
    vector half = normalize(mixture.wo + wi);
    color albedo = mixture_albedo(mixture);
    float least = LEAST_COLOUR * max(max(albedo[0], albedo[1]), albedo[2]);
    color weight = plan.weight / (1.0 - plan.weight) * max(albedo, color(least));
    color colour = value / weight * ((REMAINDER_EXPONENT + 1.0) /
                                     ((REMAINDER_EXPONENT + 2.0) * plan.probability * density * dot(half, wi)));
    color ramp[KNOTS];
    for (int j = 0; j < KNOTS; j++) {
      ramp[j] = colour;
    }
    weight *= tint;
    made = weight * phong_ramp(to_world(frame, half), REMAINDER_EXPONENT, ramp);
  }
  return made;
}
