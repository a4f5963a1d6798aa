/* Lobes at lamps: phong_ramps that are flat over a lamp's disk and carry what the mixture misses there in the mean. */

#define LAST_KNOT (KNOTS - 1.0)
#define LOBE_FLAT (LOBE_FLAT_KNOT / LAST_KNOT)      /* a lobe is flat where it has not fallen further */

struct LampLobes {
  vector axis[MAX_LOBES];
  float exponent[MAX_LOBES];
  color height[MAX_LOBES];              /* of the value along the axis, for this sample */
  color mean_height[MAX_LOBES];         /* and its expectation over the choice of a kind of sample */
  int count;
};

/* The exponent with which cos(angle from the axis) ^ exponent falls to the lobe's edge knot at the lamp's edge. */
float lobe_exponent(float radius)
{
  return log(LOBE_EDGE_KNOT / LAST_KNOT) / log(cos(max(radius, MIN_LOBE_RADIUS)));
}

/* The ramp over c = cos ^ exponent that makes c ramp(c) flat from c = 1 down to the first knot. It is piecewise linear,
 * with knots at j / 7, and its mean between two knots, weighted by solid angle, is 1: from the axis outward,
 * knot[j] = 14 ln((j + 1) / j) - knot[j + 1]. */
void flat_knots(output float knot[KNOTS])
{
  knot[KNOTS - 1] = 1.0;
  for (int j = KNOTS - 2; j > 0; j--) {
    knot[j] = 2.0 * LAST_KNOT * log((j + 1.0) / j) - knot[j + 1];
  }
  knot[0] = 0.0;
}

void flat_ramp(color top, output color ramp[KNOTS])
{
  float knot[KNOTS];
  flat_knots(knot);
  for (int j = 0; j < KNOTS; j++) {
    ramp[j] = knot[j] * top;
  }
}

/* cos(angle from the axis) ^ exponent. */
float lobe_falloff(vector axis, float exponent, vector w)
{
  float cosine = dot(axis, w);
  return cosine <= 0.0 ? 0.0 : min(pow(cosine, exponent), 1.0);
}

/* What Cycles makes of a lobe in a direction w, where it has fallen to c, relative to its value along the axis. */
float eval_lobe(vector axis, vector wo, vector w, float c)
{
  float knot[KNOTS];
  flat_knots(knot);
  int j = min((int)(LAST_KNOT * c), KNOTS - 2);
  vector h = wo + axis;
  return c * mix(knot[j], knot[j + 1], LAST_KNOT * c - j) * dot(h, w) / dot(h, axis);
}

/* Lobe i of the list, relative to its value along the axis. */
float eval_lobe_of(LampLobes lobes, int i, vector wo, vector w)
{
  return eval_lobe(lobes.axis[i], wo, w, lobe_falloff(lobes.axis[i], lobes.exponent[i], w));
}

/* Whether a direction is in the flat part of the lobe of a small lamp, which alone renders that lamp. */
int covered_by_lobe(LampList lamps, vector w)
{
  for (int i = 0; i < lamps.count; i++) {
    if (lamps.radius[i] < MAX_HIDDEN_RADIUS &&
        lobe_falloff(lamps.direction[i], lobe_exponent(lamps.radius[i]), w) > LOBE_FLAT) {
      return 1;
    }
  }
  return 0;
}

/* The means over a lamp's disk of the fit and of the mixture, both times cos theta_i; parts below the horizon count
 * as 0. The points are random where the lobe alone renders the lamp, so that the mean is right in expectation.
 * Elsewhere any height is right, as the remainder makes up for it: then a fixed triangle adds no noise. */
void mean_over_lamp(FIT_PARAMETERS, float MIXTURE[], MixtureView view, LampList lamps, int lamp, int exact, point seed,
                    output color fitted, output color mixed)
{
  vector l = lamps.direction[lamp];
  float radius = lamps.radius[lamp];
  fitted = 0.0;
  mixed = 0.0;
  if (radius < SMALL_LAMP_RADIUS) {
    if (l[2] > HORIZON) {
      fitted = eval_fit(FIT, l, view.wo) * l[2];
      mixed = eval_mixture(MIXTURE, view, l);
    }
  }
  else {
    int hidden = radius < MAX_HIDDEN_RADIUS;
    int points = hidden ? HIDDEN_LAMP_POINTS : LAMP_POINTS;
    vector u = perpendicular(l);
    vector v = cross(l, u);
    int anywhere = hidden || !exact;
    float out = tan(radius) * (anywhere ? sqrt(random(seed, RANDOM_DISK_RADIUS + lamp)) : M_SQRT1_2);
    float turn = anywhere ? M_2PI * random(seed, RANDOM_DISK_AZIMUTH + lamp) : 0.0;
    for (int k = 0; k < points; k++) {
      vector w = normalize(l + out * (cos(turn) * u + sin(turn) * v));
      turn += M_2PI / points;
      if (w[2] > HORIZON) {
        fitted += eval_fit(FIT, w, view.wo) * w[2];
        mixed += eval_mixture(MIXTURE, view, w);
      }
    }
    fitted /= points;
    mixed /= points;
  }
}

/* The lobes at the lamps. Of many lamps, systematic sampling takes some, in proportion to their light; the height of a
 * lobe is divided by the expected number of times that its lamp is taken. */
void fit_lamp_lobes(FIT_PARAMETERS, float MIXTURE[], MixtureView view, LampList lamps, RemainderPlan plan, int exact,
                    point seed, output LampLobes lobes)
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
    float scale = lamps.radius[i] < MAX_LOBE_RADIUS;
    if (lamps.count > MAX_LOBES) {
      float taken = 0.0;
      passed += lamps.light[i];
      while (passed > next && lobes.count + taken < SAMPLED_LOBES + 1) {
        taken += 1.0;
        next += stride;
      }
      scale *= taken * stride / lamps.light[i];
    }
    if (scale == 0.0) {
      continue;
    }
    color fitted, mixed;
    mean_over_lamp(FIT, MIXTURE, view, lamps, i, exact, seed, fitted, mixed);
    color height = fitted - plan.mixture * mixed;
    color mean_height = fitted - plan.mean_mixture * mixed;
    /* near other lamps, the lobes before this one carry a part already */
    for (int k = 0; k < lobes.count; k++) {
      float value = eval_lobe_of(lobes, k, view.wo, lamps.direction[i]);
      height -= lobes.height[k] * value;
      mean_height -= lobes.mean_height[k] * value;
    }
    lobes.axis[lobes.count] = lamps.direction[i];
    lobes.exponent[lobes.count] = lobe_exponent(lamps.radius[i]);
    lobes.height[lobes.count] = height * scale;
    lobes.mean_height[lobes.count] = mean_height * scale;
    lobes.count++;
  }
}

closure color lamp_lobe_closures(LampLobes lobes, ShadingFrame frame, color tint)
{
  closure color sum = 0;
  for (int i = 0; i < lobes.count; i++) {
    vector half = normalize(frame.wo + lobes.axis[i]);
    color top = tint * lobes.height[i] *
                (M_2PI / (LAMP_LOBE_WEIGHT * dot(half, lobes.axis[i]) * (lobes.exponent[i] + 2.0)));
    color ramp[KNOTS];
    flat_ramp(top, ramp);
    sum += LAMP_LOBE_WEIGHT * phong_ramp(to_world(frame, half), lobes.exponent[i], ramp);
  }
  return sum;
}
