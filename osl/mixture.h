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
  /* of microfacet lobes, once they are prepared: wo in the frame of the lobe, 1 over the widths, the density of facets
   * along the normal, what a viewer sees of them, and 1 and Smith's Lambda of wo */
  vector outgoing[LOBES];
  float steep_along[LOBES];
  float steep_across[LOBES];
  float density[LOBES];
  float visible[LOBES];
  float masking[LOBES];
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
  polar_knot = clamp((int)x, 0, POLAR_KNOTS - 2);
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

/* Smith's Lambda of a direction in the frame of a lobe, as a numerator over a denominator. */
float smith(int kind, vector w, float along, float across, output float denominator)
{
  float height = max(w[2], LEAST_COSINE);
  float run2 = w[0] * w[0] * along * along + w[1] * w[1] * across * across;
  float numerator = 0.0;
  denominator = height;
  if (kind == GGX_LOBE) {
    numerator = 0.5 * (sqrt(height * height + run2) - height);
  }
  else if (run2 > height * height / (1.6 * 1.6)) {
    float run = sqrt(run2);
    numerator = run2 - 1.259 * run * height + 0.396 * height * height;
    denominator = (3.535 * run + 2.181 * height) * height;
  }
  return numerator;
}

/* The components of a direction along the axes of a lobe, given its normal. The viewer of an isotropic fit is in the
 * plane of x and z, and so are these normals. */
vector to_lobe(vector axis, vector w)
{
#if ANISOTROPIC
  vector y = normalize(cross(axis, FIRST_AXIS));
  return vector(dot(cross(y, axis), w), dot(y, w), dot(axis, w));
#else
  return vector(axis[2] * w[0] - axis[0] * w[2], w[1], axis[0] * w[0] + axis[2] * w[2]);
#endif
}

/* What microfacet lobes have for all directions. */
void prepare_facets(output Mixture mixture)
{
  for (int k = 0; k < LOBES; k++) {
    int kind = lobe_kind(k);
    if (kind >= GGX_LOBE) {
      float along = mixture.along[k];
      float across = mixture.across[k];
      vector o = to_lobe(mixture.axis[k], mixture.wo);
      float denominator;
      mixture.outgoing[k] = o;
      mixture.steep_along[k] = 1.0 / along;
      mixture.steep_across[k] = 1.0 / across;
      mixture.density[k] = 1.0 / (M_PI * along * across);
      mixture.visible[k] = o[2] > 0.0 ? 0.25 / max(o[2], LEAST_COSINE) : 0.0;
      mixture.masking[k] = 1.0 + smith(kind, o, along, across, denominator) / denominator;
    }
  }
}

/* The value of a microfacet lobe, and the pdf of directions that are sampled by its half vectors; `inverse` is 1 over the
 * length of wo + wi. */
void eval_facets(Mixture mixture, int k, int kind, vector wi, float inverse, output float value, output float pdf)
{
  vector i = to_lobe(mixture.axis[k], wi);
  vector h = inverse * (mixture.outgoing[k] + i);
  float height = max(fabs(h[2]), LEAST_COSINE);
  float inverse_height2 = 1.0 / (height * height);
  float x = h[0] * mixture.steep_along[k];
  float y = h[1] * mixture.steep_across[k];
  float slope2 = (x * x + y * y) * inverse_height2;
  float facets = mixture.density[k] * inverse_height2 * inverse_height2;
  facets *= kind == BECKMANN_LOBE ? exp(-min(slope2, STEEPEST_FACET)) : 1.0 / ((1.0 + slope2) * (1.0 + slope2));
  pdf = 0.5 * facets * fabs(h[2]) * inverse;
  value = 0.0;
  if (i[2] > LEAST_COSINE) {
    float denominator;
    float numerator = smith(kind, i, mixture.along[k], mixture.across[k], denominator);
    value = facets * mixture.visible[k] * denominator / (mixture.masking[k] * denominator + numerator);
  }
}

float eval_sheen(float sigma, vector wo, vector wi, vector h)
{
  float cos_d = max(dot(h, wi), LEAST_LENGTH);
  float masking = min(1.0, 2.0 * max(h[2] / cos_d, 1e-5) * min(max(wo[2], LEAST_COSINE), max(wi[2], 0.0)));
  float sine2 = max(1.0 - h[2] * h[2], LEAST_SINE_2);
  float sigma2 = sigma * sigma;
  float facets = exp(-min(h[2] * h[2] / (sine2 * sigma2), STEEPEST_FACET)) / (M_PI * sigma2 * sine2 * sine2);
  return 0.25 * facets * masking / max(wo[2], LEAST_COSINE);
}

/* The mixture in a direction wi above the horizon, times cos theta_i: what Cycles makes of `mixture_closures`. Also the
 * pdf, per solid angle, with which `sample_mixture` returns it. Its facets are prepared. */
color eval_mixture(Mixture mixture, vector wi, output float pdf)
{
  color sum = 0.0;
  float others = 1.0;
  pdf = 0.0;
  vector half = mixture.wo + wi;
  float inverse = 1.0 / max(length(half), 2.0 * LEAST_LENGTH);
  for (int k = 0; k < LOBES; k++) {
    int kind = lobe_kind(k);
    float value, lobe_pdf;
    if (kind == DIFFUSE_LOBE) {
      value = max(dot(mixture.axis[k], wi), 0.0) / M_PI;
      lobe_pdf = value;
    }
    else if (kind == SHEEN_LOBE) {
      value = eval_sheen(mixture.along[k], mixture.wo, wi, inverse * half);
      lobe_pdf = 0.5 / M_PI;
    }
    else {
      eval_facets(mixture, k, kind, wi, inverse, value, lobe_pdf);
    }
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
      vector y = normalize(cross(mixture.axis[k], FIRST_AXIS));
      vector x = cross(y, mixture.axis[k]);
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
