/* How a sample of a shading point carries what Cycles' own sampling leaves. */

struct RemainderPlan {
  int mixture;              /* whether there is a mixture */
  int sampled;              /* whether this sample has a direction */
  float probability;        /* with which it has */
  float toward_lamp;        /* the share of the directions that are taken about a lamp */
  float weight;             /* share of a direction in the closure weights of the sample */
};

/* Where all light but that of a few small lamps is even, sampled directions carry all that the lobes leave of the fit,
 * and there is no mixture. Elsewhere there is one, since Cycles samples it where the light is bright, and some samples
 * have a direction, for the difference to the fit. */
RemainderPlan plan_remainder(float MIXTURE_NUMBERS[], int view, LampList lamps, int exact, int even, int frugal,
                             point seed)
{
  RemainderPlan plan;
  float largest = largest_radius(lamps);
  plan.mixture = !(exact && even && largest == 0.0 && lamps.count <= most_lobes(frugal));
  plan.probability = 0.0;
  plan.toward_lamp = 0.0;
  plan.weight = 0.0;
  if (exact) {
    float size = min(largest / LARGE_LAMP_RADIUS, 1.0);
    if (!plan.mixture) {
      plan.probability = 1.0;
      plan.weight = 1.0;
    }
    else {
      plan.probability = max(view_number(MIXTURE_NUMBERS, view, REMAINDER_PROBABILITY), size * LARGE_LAMP_PROBABILITY);
      plan.weight = max(view_number(MIXTURE_NUMBERS, view, REMAINDER_WEIGHT), size * LARGE_LAMP_WEIGHT);
      plan.toward_lamp = largest > 0.0 ? mix(LEAST_LAMP_SHARE, LARGE_LAMP_SHARE, size) : 0.0;
    }
  }
  plan.sampled = random(seed, RANDOM_REMAINDER) < plan.probability;
  return plan;
}
