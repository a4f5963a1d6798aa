/* The mixture: a sum of Cycles' closures that is close to the fit, its value in any direction, and sampling by it.
 *
 * fitter/cycles/node_mixture.py fits it, and closure nodes show the same where there is no OSL; fitter/cycles/bake.py
 * describes its table, and fitter/cycles/node_lobes.py the lobes. Their kinds do not change with the viewing direction:
 * EACH_LOBE(DO) expands DO(number, kind) for each, so that the compiler knows them. */

#include "random.h"
#include "shading_frame.h"

#if CHANNELS == 3
#  define COLOUR_READ(i) color(MIXTURE[i], MIXTURE[(i) + 1], MIXTURE[(i) + 2])
#else
#  define COLOUR_READ(i) color(MIXTURE[i])
#endif
#define COLOURS (AZIMUTHAL_TERMS * CHANNELS)
#define LOBE_ROW (3 + 2 * COLOURS)
#define POLAR_KNOT_ROW (LOBES * LOBE_ROW + LOBES + 2 + 3 * CHANNELS)

struct Mixture {
  vector wo;                /* the viewing direction */
  vector axis[LOBES];       /* the normal of a lobe */
  float along[LOBES];       /* widths of a microfacet lobe; of sheen, its roughness */
  float across[LOBES];
  color weight[LOBES];
  color albedo;             /* of the fit */
  color residual;           /* albedo of the fit less a mixture below it */
  color balance;            /* times which that makes up for what is above */
  float selection_probability[LOBES];   /* of each lobe, for a sampled direction */
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
float locate_polar_knot(vector wo, output int polar_knot)
{
  float theta = acos(wo[2]);
  float x = (POLAR_KNOTS - 1) * (1.0 - pow(max(1.0 - theta / GRAZING, 0.0), 2.0 / 3.0));
  polar_knot = min((int)x, POLAR_KNOTS - 2);
  /* between knots, linear in the angle */
  float low = 1.0 - polar_knot / (POLAR_KNOTS - 1.0);
  float high = 1.0 - (polar_knot + 1) / (POLAR_KNOTS - 1.0);
  low = GRAZING * (1.0 - low * sqrt(low));
  high = GRAZING * (1.0 - high * sqrt(high));
  return min((theta - low) / (high - low), 1.0);
}

/* A number of the table, interpolated between two polar knots. */
float mixture_number(float MIXTURE[], int at, float t)
{
  return mix(MIXTURE[at], MIXTURE[at + POLAR_KNOT_ROW], t);
}

void mixture_lobe(float MIXTURE[], int at, float t, int k, int kind, float azimuthal_term, int below,
                  output Mixture mixture)
{
  float roughness = mixture_number(MIXTURE, at, t);
  float tilt = mixture_number(MIXTURE, at + 1, t);
  float anisotropy = mixture_number(MIXTURE, at + 2, t);
  vector axis = tilt * mixture.wo + vector(0.0, 0.0, 1.0 - tilt);
  float alpha = roughness * roughness;
  float narrow = alpha * (1.0 - fabs(anisotropy));
  float wide = alpha / (1.0 - fabs(anisotropy));
  mixture.axis[k] = normalize(axis);
  mixture.along[k] = kind == SHEEN_LOBE ? roughness : min(anisotropy < 0.0 ? wide : narrow, 1.0);
  mixture.across[k] = min(anisotropy < 0.0 ? narrow : wide, 1.0);
  int colours = at + 3 + below * COLOURS;
  mixture.weight[k] = mix(COLOUR_READ(colours), COLOUR_READ(colours + POLAR_KNOT_ROW), t);
#if AZIMUTHAL_TERMS == 2
  mixture.weight[k] = mix(mix(COLOUR_READ(colours + CHANNELS), COLOUR_READ(colours + CHANNELS + POLAR_KNOT_ROW), t),
                          mixture.weight[k], azimuthal_term);
#endif
}

/* The mixture seen from wo: as close to the fit as it gets, or hardly above it anywhere. */
void interpolate_mixture(float MIXTURE[], vector wo, int below, output Mixture mixture)
{
  int polar_knot;
  float t = locate_polar_knot(wo, polar_knot);
  mixture.wo = wo;
  float azimuthal_term = wo[0] * wo[0] / max(wo[0] * wo[0] + wo[1] * wo[1], LEAST_LENGTH * LEAST_LENGTH);
  int at = polar_knot * POLAR_KNOT_ROW;
  for (int k = 0; k < LOBES; k++) {
    mixture_lobe(MIXTURE, at + k * LOBE_ROW, t, k, lobe_kind(k), azimuthal_term, below, mixture);
    mixture.selection_probability[k] = mixture_number(MIXTURE, at + LOBES * LOBE_ROW + k, t);
  }
  at += LOBES * LOBE_ROW + LOBES + 1;
  mixture.probability = mixture_number(MIXTURE, at, t);
  mixture.albedo = mix(COLOUR_READ(at + 1), COLOUR_READ(at + 1 + POLAR_KNOT_ROW), t);
  at += CHANNELS;
  mixture.residual = mix(COLOUR_READ(at + 1), COLOUR_READ(at + 1 + POLAR_KNOT_ROW), t);
  at += CHANNELS;
  mixture.balance = mix(COLOUR_READ(at + 1), COLOUR_READ(at + 1 + POLAR_KNOT_ROW), t);
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
void lobe_axes(vector axis, output vector x, output vector y)
{
  y = normalize(cross(axis, FIRST_AXIS));
  x = cross(y, axis);
}

/* The value of a microfacet lobe, and the pdf of directions that are sampled by its half vectors. */
void eval_facets(int kind, vector axis, float along, float across, vector wo, vector wi, output float value,
                 output float pdf)
{
  vector h = normalize(wo + wi);
  vector x, y;
  lobe_axes(axis, x, y);
  float cos_h = max(fabs(dot(axis, h)), LEAST_COSINE);
  float slope_x = dot(x, h) / along;
  float slope_y = dot(y, h) / across;
  float slope2 = (slope_x * slope_x + slope_y * slope_y) / (cos_h * cos_h);
  float facets = kind == BECKMANN_LOBE ? exp(-min(slope2, STEEPEST_FACET)) : 1.0 / ((1.0 + slope2) * (1.0 + slope2));
  facets /= M_PI * along * across * cos_h * cos_h * cos_h * cos_h;
  pdf = facets * fabs(dot(axis, h)) / (4.0 * max(dot(wo, h), LEAST_LENGTH));
  vector o = vector(dot(x, wo), dot(y, wo), dot(axis, wo));
  vector i = vector(dot(x, wi), dot(y, wi), dot(axis, wi));
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

/* A lobe with a white colour, and the pdf of directions that are sampled by it; wi is above the horizon. */
void eval_lobe(int kind, vector axis, float along, float across, vector wo, vector wi, output float value,
               output float pdf)
{
  if (kind == DIFFUSE_LOBE) {
    value = max(dot(axis, wi), 0.0) / M_PI;
    pdf = value;
  }
  else if (kind == SHEEN_LOBE) {
    value = eval_sheen(along, wo, wi);
    pdf = 0.5 / M_PI;
  }
  else {
    eval_facets(kind, axis, along, across, wo, wi, value, pdf);
  }
}

/* The mixture in a direction wi above the horizon, times cos theta_i: what Cycles makes of `mixture_closures`. Also the
 * pdf, per solid angle, with which `sample_mixture` returns it. */
color eval_mixture(Mixture mixture, vector wi, output float pdf)
{
  color sum = 0.0;
  float others = 1.0;
  pdf = 0.0;
  float value, lobe_pdf;
  for (int k = 0; k < LOBES; k++) {
    eval_lobe(lobe_kind(k), mixture.axis[k], mixture.along[k], mixture.across[k], mixture.wo, wi, value, lobe_pdf);
    sum += value * mixture.weight[k];
    pdf += lobe_pdf * mixture.selection_probability[k];
    others -= mixture.selection_probability[k];
  }
  pdf += others * 0.5 / M_PI;
  return sum;
}

/* A direction whose cosine with an axis is z. */
vector spherical_direction(vector axis, float z, float azimuth)
{
  vector x = perpendicular(axis);
  float r = sqrt(1.0 - z * z);
  return z * axis + r * (cos(azimuth) * x + sin(azimuth) * cross(axis, x));
}

/* A direction by the pdf of a lobe, or evenly over the hemisphere. It may be below the horizon. */
vector sample_mixture(Mixture mixture, point seed)
{
  float u = random(seed, RANDOM_LOBE);
  float v = random(seed, RANDOM_RING);
  float azimuth = M_2PI * random(seed, RANDOM_AZIMUTH);
  vector wi = spherical_direction(vector(0.0, 0.0, 1.0), v, azimuth);
  int k = 0;
  while (k < LOBES && u >= mixture.selection_probability[k]) {
    u -= mixture.selection_probability[k];
    k++;
  }
  if (k < LOBES) {
    int kind = lobe_kind(k);
    if (kind == DIFFUSE_LOBE) {
      wi = spherical_direction(mixture.axis[k], sqrt(1.0 - v), azimuth);
    }
    else if (kind != SHEEN_LOBE) {
      vector x, y;
      lobe_axes(mixture.axis[k], x, y);
      float slope = sqrt(kind == BECKMANN_LOBE ? -log(1.0 - v) : v / (1.0 - v));
      vector h = normalize(mixture.axis[k] + slope * (mixture.along[k] * cos(azimuth) * x +
                                                      mixture.across[k] * sin(azimuth) * y));
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
    vector axis = to_world(frame, mixture.axis[k]); \
    color weight = tint * mixture.weight[k]; \
    ADD_##kind(k) \
  }
#define ADD_DIFFUSE_LOBE(k) sum += weight * diffuse(axis);
#define ADD_SHEEN_LOBE(k) sum += weight * ashikhmin_velvet(axis, mixture.along[k]);
#define ADD_GGX_LOBE(k) \
  sum += weight * microfacet("ggx", axis, frame.x, mixture.along[k], mixture.across[k], MICROFACET_IOR, 0);
#define ADD_BECKMANN_LOBE(k) \
  sum += weight * microfacet("beckmann", axis, frame.x, mixture.along[k], mixture.across[k], MICROFACET_IOR, 0);
  EACH_LOBE(ADD_CLOSURE)
  return sum;
}
