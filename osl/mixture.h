/* The mixture: a sum of Cycles' closures that is close to the fit, its value in any direction, and sampling by it.
 *
 * fitter/cycles/node_mixture.py fits it, and closure nodes show the same where there is no OSL; fitter/cycles/bake.py
 * describes its table, and fitter/cycles/node_lobes.py the lobes. Their kinds do not change with the viewing direction:
 * EACH_LOBE(DO) expands DO(number, kind) for each, so that the compiler knows them. */

#if CHANNELS == 3
#  define COLOUR_READ(i) color(MIXTURE[i], MIXTURE[(i) + 1], MIXTURE[(i) + 2])
#else
#  define COLOUR_READ(i) color(MIXTURE[i])
#endif
#define COLOURS (PHASES * CHANNELS)
#define LOBE_ROW (3 + 2 * COLOURS)
#define STOP_ROW (LOBES * LOBE_ROW + LOBES + 2 + 3 * CHANNELS)

struct Mixture {
  vector wo;                /* the viewing direction */
  vector about[LOBES];
  float along[LOBES];       /* widths of a microfacet lobe; of sheen, its roughness */
  float across[LOBES];
  color weight[LOBES];
  color albedo;             /* of the fit */
  color left;               /* what a mixture below the fit leaves of it */
  color balance;            /* times which that makes up for what is above */
  float share[LOBES];       /* of the sampled directions */
  float probability;        /* with which a sample has a direction */
};

/* The first axis of microfacet lobes: it need not be perpendicular to their normals. */
#define FIRST_AXIS vector(1.0, 0.0, 0.0)

/* The kind of a lobe. */
int lobe_kind(int lobe)
{
  int found = DIFFUSE_LOBE;
#define FIND_KIND(k, kind) \
  if (lobe == k) { \
    found = kind; \
  }
  EACH_LOBE(FIND_KIND)
  return found;
}

/* Where a viewing direction is among the tabulated polar angles, which are closer toward the horizon. */
float stop_of(vector wo, output int stop)
{
  float theta = acos(wo[2]);
  float x = (STOPS - 1) * (1.0 - pow(max(1.0 - theta / GRAZING, 0.0), 2.0 / 3.0));
  stop = min((int)x, STOPS - 2);
  /* between stops, linear in the angle */
  float low = 1.0 - stop / (STOPS - 1.0);
  float high = 1.0 - (stop + 1) / (STOPS - 1.0);
  low = GRAZING * (1.0 - low * sqrt(low));
  high = GRAZING * (1.0 - high * sqrt(high));
  return min((theta - low) / (high - low), 1.0);
}

/* A number of the table, between two stops. */
float mixture_number(float MIXTURE[], int at, float t)
{
  return mix(MIXTURE[at], MIXTURE[at + STOP_ROW], t);
}

void mixture_lobe(float MIXTURE[], int at, float t, int k, int kind, float phase, int below, output Mixture found)
{
  float roughness = mixture_number(MIXTURE, at, t);
  float tilt = mixture_number(MIXTURE, at + 1, t);
  float anisotropy = mixture_number(MIXTURE, at + 2, t);
  vector about = tilt * found.wo + vector(0.0, 0.0, 1.0 - tilt);
  float alpha = roughness * roughness;
  float narrow = alpha * (1.0 - fabs(anisotropy));
  float wide = alpha / (1.0 - fabs(anisotropy));
  found.about[k] = normalize(about);
  found.along[k] = kind == SHEEN_LOBE ? roughness : min(anisotropy < 0.0 ? wide : narrow, 1.0);
  found.across[k] = min(anisotropy < 0.0 ? narrow : wide, 1.0);
  int colours = at + 3 + below * COLOURS;
  found.weight[k] = mix(COLOUR_READ(colours), COLOUR_READ(colours + STOP_ROW), t);
#if PHASES == 2
  found.weight[k] = mix(mix(COLOUR_READ(colours + CHANNELS), COLOUR_READ(colours + CHANNELS + STOP_ROW), t),
                        found.weight[k], phase);
#endif
}

/* The mixture seen from wo: as close to the fit as it gets, or hardly above it anywhere. */
void mixture_of(float MIXTURE[], vector wo, int below, output Mixture found)
{
  int stop;
  float t = stop_of(wo, stop);
  found.wo = wo;
  float phase = wo[0] * wo[0] / max(wo[0] * wo[0] + wo[1] * wo[1], LEAST_LENGTH * LEAST_LENGTH);
  int at = stop * STOP_ROW;
  for (int k = 0; k < LOBES; k++) {
    mixture_lobe(MIXTURE, at + k * LOBE_ROW, t, k, lobe_kind(k), phase, below, found);
    found.share[k] = mixture_number(MIXTURE, at + LOBES * LOBE_ROW + k, t);
  }
  at += LOBES * LOBE_ROW + LOBES + 1;
  found.probability = mixture_number(MIXTURE, at, t);
  found.albedo = mix(COLOUR_READ(at + 1), COLOUR_READ(at + 1 + STOP_ROW), t);
  at += CHANNELS;
  found.left = mix(COLOUR_READ(at + 1), COLOUR_READ(at + 1 + STOP_ROW), t);
  at += CHANNELS;
  found.balance = mix(COLOUR_READ(at + 1), COLOUR_READ(at + 1 + STOP_ROW), t);
}

/* Smith's Lambda of a direction in the frame of a lobe. */
float smith(int kind, vector w, float along, float across)
{
  float height = max(w[2], LEAST_COSINE);
  float slope2 = (w[0] * w[0] * along * along + w[1] * w[1] * across * across) / (height * height);
  float lambda = 0.5 * (sqrt(1.0 + slope2) - 1.0);
  if (kind == BECKMANN_LOBE) {
    float a = 1.0 / sqrt(max(slope2, LEAST_SLOPE_2));
    lambda = a < 1.6 ? (1.0 - 1.259 * a + 0.396 * a * a) / (3.535 * a + 2.181 * a * a) : 0.0;
  }
  return lambda;
}

/* The axes of a lobe, given its normal. */
void lobe_axes(vector about, output vector x, output vector y)
{
  y = normalize(cross(about, FIRST_AXIS));
  x = cross(y, about);
}

/* The value of a microfacet lobe, and the density of directions that are sampled by its half vectors. */
void eval_facets(int kind, vector about, float along, float across, vector wo, vector wi, output float value,
                 output float density)
{
  vector h = normalize(wo + wi);
  vector x, y;
  lobe_axes(about, x, y);
  float cos_h = max(fabs(dot(about, h)), LEAST_COSINE);
  float slope_x = dot(x, h) / along;
  float slope_y = dot(y, h) / across;
  float slope2 = (slope_x * slope_x + slope_y * slope_y) / (cos_h * cos_h);
  float facets = kind == BECKMANN_LOBE ? exp(-min(slope2, STEEPEST_FACET)) : 1.0 / ((1.0 + slope2) * (1.0 + slope2));
  facets /= M_PI * along * across * cos_h * cos_h * cos_h * cos_h;
  density = facets * fabs(dot(about, h)) / (4.0 * max(dot(wo, h), LEAST_LENGTH));
  vector o = vector(dot(x, wo), dot(y, wo), dot(about, wo));
  vector i = vector(dot(x, wi), dot(y, wi), dot(about, wi));
  value = 0.0;
  if (o[2] > 0.0 && i[2] > LEAST_COSINE) {
    value = facets / (4.0 * max(o[2], LEAST_COSINE) *
                      (1.0 + smith(kind, o, along, across) + smith(kind, i, along, across)));
  }
}

float eval_sheen(float sigma, vector wo, vector wi)
{
  vector h = normalize(wo + wi);
  float cos_d = max(dot(h, wi), LEAST_LENGTH);
  float masking = min(1.0, 2.0 * max(h[2] / cos_d, 1e-5) * min(max(wo[2], LEAST_COSINE), max(wi[2], 0.0)));
  float sine2 = max(1.0 - h[2] * h[2], LEAST_SINE_2);
  float sigma2 = sigma * sigma;
  float facets = exp(-min(h[2] * h[2] / (sine2 * sigma2), STEEPEST_FACET)) / (M_PI * sigma2 * sine2 * sine2);
  return 0.25 * facets * masking / max(wo[2], LEAST_COSINE);
}

/* A lobe with a white colour, and the density of directions that are sampled by it; wi is above the horizon. */
void eval_lobe(int kind, vector about, float along, float across, vector wo, vector wi, output float value,
               output float density)
{
  if (kind == DIFFUSE_LOBE) {
    value = max(dot(about, wi), 0.0) / M_PI;
    density = value;
  }
  else if (kind == SHEEN_LOBE) {
    value = eval_sheen(along, wo, wi);
    density = 0.5 / M_PI;
  }
  else {
    eval_facets(kind, about, along, across, wo, wi, value, density);
  }
}

/* The mixture in a direction wi above the horizon, times cos theta_i: what Cycles makes of `mixture_closures`. Also the
 * density, per solid angle, with which `sample_mixture` returns it. */
color eval_mixture(Mixture mixture, vector wi, output float density)
{
  color sum = 0.0;
  float others = 1.0;
  density = 0.0;
  float value, pdf;
  for (int k = 0; k < LOBES; k++) {
    eval_lobe(lobe_kind(k), mixture.about[k], mixture.along[k], mixture.across[k], mixture.wo, wi, value, pdf);
    sum += value * mixture.weight[k];
    density += pdf * mixture.share[k];
    others -= mixture.share[k];
  }
  density += others * 0.5 / M_PI;
  return sum;
}

/* A direction whose cosine with an axis is z. */
vector around(vector axis, float z, float turn)
{
  vector x = perpendicular(axis);
  float r = sqrt(1.0 - z * z);
  return z * axis + r * (cos(turn) * x + sin(turn) * cross(axis, x));
}

/* A direction by the density of a lobe, or evenly over the hemisphere. It may be below the horizon. */
vector sample_mixture(Mixture mixture, point seed)
{
  float u = random(seed, RANDOM_LOBE);
  float v = random(seed, RANDOM_RING);
  float turn = M_2PI * random(seed, RANDOM_TURN);
  vector wi = around(vector(0.0, 0.0, 1.0), v, turn);
  int k = 0;
  while (k < LOBES && u >= mixture.share[k]) {
    u -= mixture.share[k];
    k++;
  }
  if (k < LOBES) {
    int kind = lobe_kind(k);
    if (kind == DIFFUSE_LOBE) {
      wi = around(mixture.about[k], sqrt(1.0 - v), turn);
    }
    else if (kind != SHEEN_LOBE) {
      vector x, y;
      lobe_axes(mixture.about[k], x, y);
      float slope = sqrt(kind == BECKMANN_LOBE ? -log(1.0 - v) : v / (1.0 - v));
      vector h = normalize(mixture.about[k] + slope * (mixture.along[k] * cos(turn) * x +
                                                       mixture.across[k] * sin(turn) * y));
      wi = 2.0 * dot(mixture.wo, h) * h - mixture.wo;
    }
  }
  return wi;
}

/* The mixture, for Cycles to evaluate and to sample.
 *
 * Here and elsewhere a variable for the weight stands before each closure: OSL makes such a weight a part of its
 * closure, and any other a closure of its own, for which GPUs have little room. Each closure has a variable of its own:
 * of one that is written again OSL's optimizer leaves the last value to all. */
closure color mixture_closures(Mixture mixture, ShadingFrame frame, color tint)
{
  closure color sum = 0;
#define ADD_CLOSURE(k, kind) { \
    vector about = to_world(frame, mixture.about[k]); \
    color weight = tint * mixture.weight[k]; \
    ADD_##kind(k) \
  }
#define ADD_DIFFUSE_LOBE(k) sum += weight * diffuse(about);
#define ADD_SHEEN_LOBE(k) sum += weight * ashikhmin_velvet(about, mixture.along[k]);
#define ADD_GGX_LOBE(k) \
  sum += weight * microfacet("ggx", about, frame.x, mixture.along[k], mixture.across[k], MICROFACET_IOR, 0);
#define ADD_BECKMANN_LOBE(k) \
  sum += weight * microfacet("beckmann", about, frame.x, mixture.along[k], mixture.across[k], MICROFACET_IOR, 0);
  EACH_LOBE(ADD_CLOSURE)
  return sum;
}
