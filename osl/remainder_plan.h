/* Whether a sample of a shading point includes a direction for the remainder, which costs an evaluation of the fit. */

struct RemainderPlan {
  int sampled;              /* whether this sample has such a direction */
  int replaces;             /* whether the direction stands in for the mixture, rather than adding to it */
  float probability;        /* with which `sampled` is 1 */
  float mixture;            /* the factor of the mixture in this sample, 0 or 1 */
  float mean_mixture;       /* and its expectation */
};

/* In even light the direction carries all of the fit and the mixture is left out, which gives both kinds of sample the
 * same expected value. Elsewhere the mixture stays, since Cycles samples it where the light is bright, and the
 * direction carries the difference to the fit. */
RemainderPlan plan_remainder(float MIXTURE[], MixtureView view, LampList lamps, Cone large, int exact, int even,
                             point seed)
{
  RemainderPlan plan;
  plan.replaces = even && large.radius == 0.0 && lamps.count <= MAX_LOBES;
  plan.probability = 0.0;
  if (exact) {
    plan.probability = plan.replaces ? REPLACING_PROBABILITY :
                                       REMAINDER_RATE * MIXTURE_NUMBER(view.row + REMAINDER_SHARE);
    if (large.radius > 0.0) {
      plan.probability = max(plan.probability, LARGE_LAMP_PROBABILITY);
    }
  }
  plan.sampled = random(seed, RANDOM_REMAINDER) < plan.probability;
  plan.mixture = plan.sampled && plan.replaces ? 0.0 : 1.0;
  plan.mean_mixture = plan.replaces ? 1.0 - plan.probability : 1.0;
  return plan;
}
