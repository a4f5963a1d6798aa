/* The remainder: what the fit has besides the mixture and the lobes, carried by one sampled direction. */

/* The sampling tables as parameters of a function, and as its arguments: for the remainder beside the mixture, and for
 * all that is reflected, where the direction stands in for the mixture. */
#define SAMPLING_PARAMETERS float SAMPLING_REMAINDER[], float SAMPLING_REFLECTED[]
#define SAMPLING SAMPLING_REMAINDER, SAMPLING_REFLECTED

/* A direction, from the table or about a lamp. */
vector sample_remainder(SAMPLING_PARAMETERS, MixtureView view, LampList lamps, RemainderPlan plan, point seed)
{
  vector wi;
  if (random(seed, RANDOM_TOWARD_LAMP) < plan.toward_lamp) {
    int lamp = sample_lamp(lamps, seed);
    wi = sample_cone(lamps.direction[lamp], lamps.radius[lamp], seed);
  }
  else if (!plan.mixture) {
    wi = sample_table(SAMPLING_REFLECTED, view.view, view.wo, seed);
  }
  else {
    wi = sample_table(SAMPLING_REMAINDER, view.view, view.wo, seed);
  }
  return wi;
}

/* The density, per solid angle, with which `sample_remainder` returns a direction. */
float pdf_remainder(SAMPLING_PARAMETERS, MixtureView view, LampList lamps, RemainderPlan plan, vector wi)
{
  float in_table = !plan.mixture ? pdf_table(SAMPLING_REFLECTED, view.view, view.wo, wi) :
                                   pdf_table(SAMPLING_REMAINDER, view.view, view.wo, wi);
  float density = (1.0 - plan.toward_lamp) * in_table;
  if (plan.toward_lamp > 0.0) {
    density += plan.toward_lamp * pdf_lamps(lamps, wi);
  }
  return density;
}

/* The fit less the mixture and the lobes, times cos theta_i. */
color eval_remainder(FIT_PARAMETERS, float MIXTURE[], float FLAT_RAMP[], MixtureView view, LampLobes lobes,
                     RemainderPlan plan, vector wi)
{
  color value = eval_fit(FIT, to_fit(wi), to_fit(view.wo)) * wi[2] - eval_lobes(FLAT_RAMP, lobes, view.wo, wi);
  if (plan.mixture) {
    value -= eval_mixture(MIXTURE, view, wi);
  }
  return value;
}

/* A phong_ramp so narrow that it sends a path in the sampled direction, and no closure where the lobe of a small lamp
 * carries everything. */
closure color remainder_closure(FIT_PARAMETERS, float MIXTURE[], float FLAT_RAMP[], SAMPLING_PARAMETERS,
                                MixtureView view, LampList lamps, LampLobes lobes, RemainderPlan plan,
                                ShadingFrame frame, color tint, point seed)
{
  closure color made = 0;
  vector wi = sample_remainder(SAMPLING, view, lamps, plan, seed);
  if (wi[2] >= HORIZON && !covered_by_lobe(lamps, wi)) {
    color value = eval_remainder(FIT, MIXTURE, FLAT_RAMP, view, lobes, plan, wi);
    float density = pdf_remainder(SAMPLING, view, lamps, plan, wi);
    vector half = normalize(view.wo + wi);
    color weight = plan.weight * reflected_albedo(MIXTURE, view);
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
