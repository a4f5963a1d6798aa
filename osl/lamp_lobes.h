/* Lobes at lamps: phong_ramps that are flat over a lamp's disk, and carry there what the mixture misses of the fit, or
 * all of the fit where there is no mixture. */

#define LAST_KNOT (KNOTS - 1.0)
#define LOBE_FLAT (LOBE_EDGE_KNOT / LAST_KNOT)      /* a lobe is flat where it has not fallen further */

struct LampLobes {
  vector axis[MAX_LOBES];
  float exponent[MAX_LOBES];
  color height[MAX_LOBES];              /* of the value along the axis */
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

/* The lobes at the lamps. Of many lamps, systematic sampling takes some, in proportion to their light; the height of a
 * lobe is divided by the expected number of times that its lamp is taken. No lobe takes more than there is: where the
 * mixture exceeds the fit, only that of a small lamp subtracts, since elsewhere the mixture may soon be less; or as
 * much as the mixture was raised by. */
void fit_lamp_lobes(FIT_PARAMETERS, float MIXTURE[], float MISSING[], float FLAT_RAMP[], MixtureView view,
                    LampList lamps, int mixture, int exact, point seed, output LampLobes lobes)
{
  lobes.count = 0;
  float all_light = 0.0;
  for (int i = 0; i < lamps.count; i++) {
    all_light += lamps.light[i];
  }
  float stride = all_light / SAMPLED_LOBES;
  float next = stride * random(seed, RANDOM_LOBES);
  float passed = 0.0;
  for (int i = 0; i < lamps.count; i++) {
    vector l = lamps.direction[i];
    float radius = lamps.radius[i];
    float times = radius < MAX_LOBE_RADIUS && l[2] > HORIZON;
    if (lamps.count > MAX_LOBES) {
      float taken = 0.0;
      passed += lamps.light[i];
      while (passed > next && lobes.count + taken < SAMPLED_LOBES + 1) {
        taken += 1.0;
        next += stride;
      }
      times *= taken * stride / lamps.light[i];
    }
    if (times == 0.0) {
      continue;
    }
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
    lobes.height[lobes.count] = times * height * dot(half, axis) / dot(half, l);
    lobes.count++;
  }
}

/* A lobe is picked about as often as it reflects light, and hardly ever where that is little: Cycles finds lamps by
 * sampling them. */
closure color lamp_lobe_closures(float FLAT_RAMP[], LampLobes lobes, ShadingFrame frame)
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
    sum += weight * phong_ramp(to_world(frame, half), lobes.exponent[i], ramp);
  }
  return sum;
}
