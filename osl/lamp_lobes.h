/* Lobes at lamps: phong_ramps that are flat over a lamp's disk, and carry there what the mixture misses of the fit, or
 * all of the fit where there is no mixture. */

#define LAST_KNOT (KNOTS - 1.0)
#define LOBE_FLAT (LOBE_EDGE_KNOT / LAST_KNOT)      /* a lobe is flat where it has not fallen further */

struct LampLobes {
  vector axis[MAX_LAMPS];
  float exponent[MAX_LAMPS];
  color height[MAX_LAMPS];              /* of the value along the axis */
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
  return cosine <= 0.0 ? 0.0 : min(pow(cosine, exponent), 1.0);
}

/* The sum of all lobes in a direction: what Cycles makes of them. */
color eval_lobes(float FLAT_RAMP[], LampLobes lobes, vector wo, vector w)
{
  color sum = 0.0;
  for (int i = 0; i < lobes.count; i++) {
    vector axis = lobes.axis[i];
    float c = lobe_falloff(axis, lobes.exponent[i], w);
    if (c > LEAST_FALLOFF) {
      int j = min((int)(LAST_KNOT * c), KNOTS - 2);
      vector h = wo + axis;
      sum += lobes.height[i] * (c * mix(FLAT_RAMP[j], FLAT_RAMP[j + 1], LAST_KNOT * c - j) * dot(h, w) / dot(h, axis));
    }
  }
  return sum;
}

/* Whether a direction is in the flat part of the lobe of a small lamp, which alone renders that lamp. */
int covered_by_lobe(LampList lamps, vector w)
{
  for (int i = 0; i < lamps.count; i++) {
    if (lamps.radius[i] < SMALL_LAMP_RADIUS &&
        lobe_falloff(lobe_axis(lamps, i), lobe_exponent(lamps.radius[i]), w) > LOBE_FLAT) {
      return 1;
    }
  }
  return 0;
}

/* What the mixture misses of the fit over a lamp's disk, by its value in the middle and by the table. The mean; or,
 * where it varies much and sampled directions correct the lobe, the least, so that nothing has to be subtracted. */
color missing_over_lamp(float MISSING[], MixtureView view, vector l, float radius, color in_middle, color mixed,
                        int exact)
{
  vector across = perpendicular(l);
  vector along = cross(l, across);
  float out = M_SQRT1_2 * tan(radius);
  color by_table = eval_missing(MISSING, view, l);
  color mean = in_middle;
  color least = in_middle;
  color most = in_middle;
  for (int k = 0; k < LAMP_POINTS; k++) {
    float turn = k * (M_2PI / LAMP_POINTS);
    vector w = normalize(l + out * (cos(turn) * across + sin(turn) * along));
    color there = w[2] > HORIZON ? eval_missing(MISSING, view, w) : -mixed;
    mean += (there - by_table) / LAMP_POINTS;
    least = min(least, there);
    most = max(most, there);
  }
  if (exact) {
    color excess = most - least - SMOOTH_CHANGE * max(least + mixed, color(0.0));
    mean = max(least, mean - max(excess, color(0.0)));
  }
  return mean;
}

/* The fit in the middle of a lamp, times cos theta_i, but no less than `least`; the mixture as fitted is `mixed` there.
 * The fit is evaluated where the camera sees the surface; elsewhere the table and the mixture have it nearly. At a
 * small lamp, which its lobe alone renders, some samples make up for that. */
color fit_at_lamp(FIT_PARAMETERS, float MISSING[], MixtureView view, vector l, int small, color mixed, color least,
                  float u)
{
  float probability = raytype("camera") ? 1.0 : small ? INDIRECT_PROBABILITY : 0.0;
  color fitted = 0.0;
  if (probability < 1.0) {
    fitted = eval_missing(MISSING, view, l) + mixed;
  }
  if (u < probability) {
    fitted += (max(eval_fit(FIT, to_fit(l), to_fit(view.wo)) * l[2], least) - fitted) / probability;
  }
  return fitted;
}

/* Whether a lamp has a lobe. */
int has_lobe(LampList lamps, int lamp)
{
  return lamps.radius[lamp] < MAX_LOBE_RADIUS && lamps.direction[lamp][2] > HORIZON;
}

/* Take some of the lamps by systematic sampling, in proportion to their light. `times` is what a lamp's lobe is
 * multiplied by: how often the lamp is taken, over how often that is expected. Where few closures fit, no light is left
 * to lamps that have no lobe. */
void sample_lobes(LampList lamps, int frugal, point seed, output float times[MAX_LAMPS])
{
  float all_light = 0.0;
  for (int i = 0; i < lamps.count; i++) {
    times[i] = frugal ? lamps.light[i] * has_lobe(lamps, i) : lamps.light[i];
    all_light += times[i];
  }
  int room = frugal ? FRUGAL_LOBES : SAMPLED_LOBES + 1;
  float stride = all_light / (frugal ? FRUGAL_LOBES : SAMPLED_LOBES);
  float next = stride * random(seed, RANDOM_LOBES);
  float passed = 0.0;
  for (int i = 0; i < lamps.count; i++) {
    float taken = 0.0;
    passed += times[i];
    while (passed > next && room > 0) {
      taken += 1.0;
      next += stride;
      room--;
    }
    times[i] = has_lobe(lamps, i) * taken * stride / lamps.light[i];
  }
}

/* Whether the lobe of a lamp reaches any of the lamps behind it in the list that are `needed`. */
int reaches_needed(LampList lamps, int lamp, int needed[MAX_LAMPS])
{
  float radius = max(lamps.radius[lamp], MIN_LOBE_RADIUS);
  for (int i = lamp + 1; i < lamps.count; i++) {
    if (needed[i] && 1.0 - dot(lamps.direction[lamp], lamps.direction[i]) < LOBE_REACH * radius * radius) {
      return 1;
    }
  }
  return 0;
}

/* The lobes whose heights are needed: of the lamps that are taken, and of those whose lobes reach them. */
void needed_lobes(LampList lamps, float times[MAX_LAMPS], output int needed[MAX_LAMPS])
{
  for (int i = lamps.count - 1; i >= 0; i--) {
    needed[i] = times[i] > 0.0 || (has_lobe(lamps, i) && reaches_needed(lamps, i, needed));
  }
}

/* Leave only the lobes of the lamps that were taken. */
void keep_taken(float times[MAX_LAMPS], output LampLobes lobes)
{
  int kept = 0;
  for (int i = 0; i < lobes.count; i++) {
    if (times[i] > 0.0) {
      lobes.axis[kept] = lobes.axis[i];
      lobes.exponent[kept] = lobes.exponent[i];
      lobes.height[kept] = times[i] * lobes.height[i];
      kept++;
    }
  }
  lobes.count = kept;
}

/* The lobes at the lamps, or at some of many. No lobe takes more than there is: where the mixture exceeds the fit, only
 * that of a small lamp subtracts, since elsewhere the mixture may soon be less; or as much as the mixture was raised
 * by. */
void fit_lamp_lobes(FIT_PARAMETERS, float MIXTURE[], float MISSING[], float FLAT_RAMP[], MixtureView view,
                    LampList lamps, int mixture, int exact, int frugal, point seed, output LampLobes lobes)
{
  int sampled = lamps.count > most_lobes(frugal);
  float times[MAX_LAMPS];
  int needed[MAX_LAMPS];
  if (sampled) {
    sample_lobes(lamps, frugal, seed, times);
    needed_lobes(lamps, times, needed);
  }
  lobes.count = 0;
  for (int i = 0; i < lamps.count; i++) {
    if (sampled ? !needed[i] : !has_lobe(lamps, i)) {
      continue;
    }
    vector l = lamps.direction[i];
    float radius = lamps.radius[i];
    int small = radius < SMALL_LAMP_RADIUS;
    color mixed = 0.0;
    if (mixture || !raytype("camera")) {
      mixed = eval_mixture(MIXTURE, view, l);
    }
    color unscaled = mixed / view.scale;
    mixed *= mixture;
    color height = fit_at_lamp(FIT, MISSING, view, l, small, unscaled, LEAST_OF_MIXTURE * mixed,
                               random(seed, RANDOM_LAMP_POINT + i));
    if (!small) {
      color missing = missing_over_lamp(MISSING, view, l, radius, height - unscaled, unscaled, exact);
      height = unscaled + max(missing, color(0.0));
    }
    height -= mixed;
    /* near other lamps, the lobes before this one carry a part already */
    height -= eval_lobes(FLAT_RAMP, lobes, view.wo, l);
    vector axis = lobe_axis(lamps, i);
    vector half = view.wo + axis;
    lobes.axis[lobes.count] = axis;
    lobes.exponent[lobes.count] = lobe_exponent(radius);
    lobes.height[lobes.count] = height * dot(half, axis) / dot(half, l);
    times[lobes.count] = times[i];
    lobes.count++;
  }
  if (sampled) {
    keep_taken(times, lobes);
  }
}

/* A lobe is picked about as often as it reflects light, and hardly ever where that is little: Cycles finds lamps by
 * sampling them. */
closure color lamp_lobe_closures(float FLAT_RAMP[], LampLobes lobes, ShadingFrame frame, color tint)
{
  closure color sum = 0;
  for (int i = 0; i < lobes.count; i++) {
    vector half = normalize(frame.wo + lobes.axis[i]);
    color height = lobes.height[i];
    float weight = LAMP_LOBE_WEIGHT +
                   LOBE_SOLID_ANGLE / lobes.exponent[i] * (fabs(height[0]) + fabs(height[1]) + fabs(height[2])) / 3.0;
    color top = height * (M_2PI / (weight * dot(half, lobes.axis[i]) * (lobes.exponent[i] + 2.0)));
    color ramp[KNOTS];
    for (int j = 0; j < KNOTS; j++) {
      ramp[j] = FLAT_RAMP[j] * top;
    }
    color tinted = weight * tint;
    sum += tinted * phong_ramp(to_world(frame, half), lobes.exponent[i], ramp);
  }
  return sum;
}
