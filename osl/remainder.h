/* The remainder: what the fit has besides the mixture and the lobes, carried by one sampled direction. */

/* The sampling tables as parameters of a function, and as its arguments: for the remainder beside the mixture, and for
 * all that is reflected, where the direction stands in for the mixture. */
#define SAMPLING_PARAMETERS float SAMPLING_REMAINDER[], float SAMPLING_REFLECTED[]
#define SAMPLING SAMPLING_REMAINDER, SAMPLING_REFLECTED

/* A direction, from the table or toward a large lamp. */
vector sample_remainder(SAMPLING_PARAMETERS, int view, RemainderPlan plan, Cone large, point seed)
{
  vector wi;
  if (large.radius > 0.0 && random(seed, RANDOM_TOWARD_LAMP) < LARGE_LAMP_SHARE) {
    wi = sample_cone(large, seed);
  }
  else if (plan.replaces) {
    wi = sample_table(SAMPLING_REFLECTED, view, seed);
  }
  else {
    wi = sample_table(SAMPLING_REMAINDER, view, seed);
  }
  return wi;
}

/* The density, per solid angle, with which `sample_remainder` returns a direction. */
float pdf_remainder(SAMPLING_PARAMETERS, int view, RemainderPlan plan, Cone large, vector wi)
{
  float table_share = 1.0;
  float in_cone = 0.0;
  if (large.radius > 0.0) {
    table_share = 1.0 - LARGE_LAMP_SHARE;
    in_cone = LARGE_LAMP_SHARE * pdf_cone(large, wi);
  }
  float in_table = plan.replaces ? pdf_table(SAMPLING_REFLECTED, view, wi) : pdf_table(SAMPLING_REMAINDER, view, wi);
  return table_share * in_table + in_cone;
}

/* The fit less the expected mixture and lobes, times cos theta_i. */
color eval_remainder(FIT_PARAMETERS, float MIXTURE[], MixtureView view, LampLobes lobes, RemainderPlan plan, vector wi)
{
  color value = eval_fit(FIT, wi, view.wo) * wi[2] - plan.mean_mixture * eval_mixture(MIXTURE, view, wi);
  for (int i = 0; i < lobes.count; i++) {
    value -= lobes.mean_height[i] * eval_lobe_of(lobes, i, view.wo, wi);
  }
  return value;
}

/* A phong_ramp so narrow that it sends a path in the sampled direction, and no closure where the lobe of a small lamp
 * carries everything. */
closure color remainder_closure(FIT_PARAMETERS, float MIXTURE[], SAMPLING_PARAMETERS, MixtureView view, LampList lamps,
                                LampLobes lobes, RemainderPlan plan, Cone large, ShadingFrame frame, color tint,
                                point seed)
{
  closure color made = 0;
  vector wi = sample_remainder(SAMPLING, view.view, plan, large, seed);
  if (wi[2] >= HORIZON && !covered_by_lobe(lamps, wi)) {
    color value = eval_remainder(FIT, MIXTURE, view, lobes, plan, wi);
    float density = pdf_remainder(SAMPLING, view.view, plan, large, wi);
    vector half = normalize(view.wo + wi);
    float weight = MIXTURE_NUMBER(view.row + TOTAL_WEIGHT) * (large.radius > 0.0 ? LARGE_LAMP_WEIGHT : 1.0);
    color colour = tint * value *
                   ((REMAINDER_EXPONENT + 1.0) /
                    ((REMAINDER_EXPONENT + 2.0) * weight * plan.probability * density * dot(half, wi)));
    color ramp[KNOTS];
    for (int j = 0; j < KNOTS; j++) {
      ramp[j] = colour;
    }
    made = weight * phong_ramp(to_world(frame, half), REMAINDER_EXPONENT, ramp);
  }
  return made;
}
