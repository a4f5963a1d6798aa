/* The closure mixture: a sum of closures that is close to the fit, and its value in any direction.
 *
 * fitter/cycles/closure_mixture.py fits it, and fitter/shader_constants.py describes a row of its tables. The knots of
 * a row are divided by the weight of their ramp. */

#if CHANNELS == 3
#  define MIXTURE_VALUE color
#  define MIXTURE_READ(i) color(MIXTURE[3 * (i)], MIXTURE[3 * (i) + 1], MIXTURE[3 * (i) + 2])
#else
#  define MIXTURE_VALUE float
#  define MIXTURE_READ(i) MIXTURE[i]
#endif
#define MIXTURE_PARAMETERS float MIXTURE[], float MIXTURE_NUMBERS[]
#define MIXTURE_TABLES MIXTURE, MIXTURE_NUMBERS

/* The mixture for one viewing direction. */
struct MixtureView {
  int view;                 /* the tabulated viewing angle or, for an anisotropic fit, direction */
  int row;                  /* where its row begins */
  vector wo;                /* the viewing direction */
  color scale;              /* factor of the whole mixture */
  int kind[LOBES];          /* PHONG or GGX */
  float shape[LOBES];       /* the exponent, or the roughness */
#if ANISOTROPIC
  float across[LOBES];      /* the roughness along the second principal axis; `shape` is that along the first */
#endif
  vector axis[LOBES];       /* of a phong_ramp; of a microfacet lobe, the normal */
  vector half[LOBES];       /* the normal that gives a phong_ramp its axis */
};

#if ANISOTROPIC
#  define POLAR POLAR_VIEWS
#else
#  define POLAR VIEWS
#endif

/* One of the two tabulated polar angles next to theta_o, by a random number. */
int nearby_view(float theta_o, float u)
{
  float t = max(0.0, 1.0 - theta_o / GRAZING);
  int below = min((int)((POLAR - 1) * (1.0 - pow(t, 2.0 / 3.0))), POLAR - 2);
  float low = 1.0 - below / (POLAR - 1.0);
  float high = 1.0 - (below + 1) / (POLAR - 1.0);
  low = low * sqrt(low);
  high = high * sqrt(high);
  return u * (low - high) < low - t ? below + 1 : below;
}

#include "anisotropic_views.h"
#if !ANISOTROPIC
/* A number of a view; `i` counts those of `shader_constants`. */
float view_number(float MIXTURE_NUMBERS[], int view, int i)
{
  return MIXTURE_NUMBERS[view * NUMBERS + i];
}

/* The direction at an angle theta from the normal, in the plane of incidence, opposite to the viewer. */
vector mirror_side(float theta)
{
  return vector(-sin(theta), 0.0, cos(theta));
}

/* The mixture of a tabulated view, seen from wo. */
void mixture_view(float MIXTURE_NUMBERS[], int view, float theta_o, vector wo, output MixtureView found)
{
  found.view = view;
  found.row = view * ROW;
  found.wo = wo;
  found.scale = 1.0;
  for (int k = 0; k < LOBES; k++) {
    found.kind[k] = (int)view_number(MIXTURE_NUMBERS, view, LOBE_NUMBERS * k);
    found.shape[k] = view_number(MIXTURE_NUMBERS, view, LOBE_NUMBERS * k + 1);
    float angle = view_number(MIXTURE_NUMBERS, view, LOBE_NUMBERS * k + 2);
    if (found.kind[k] == PHONG) {
      found.axis[k] = mirror_side(min(theta_o + angle, STEEPEST_AXIS));
      found.half[k] = normalize(wo + found.axis[k]);
    }
    else {
      found.axis[k] = mirror_side(angle);
      found.half[k] = found.axis[k];
    }
  }
}

void sample_view(float MIXTURE_NUMBERS[], vector wo, point seed, output MixtureView found)
{
  float theta_o = acos(clamp(wo[2], 0.0, 1.0));
  mixture_view(MIXTURE_NUMBERS, nearby_view(theta_o, random(seed, RANDOM_VIEW)), theta_o, wo, found);
}
#endif

/* A ramp at c in [0, 1]; `first` is the entry of its first knot. */
MIXTURE_VALUE eval_ramp(float MIXTURE[], int first, float c)
{
  int j = min((int)((KNOTS - 1.0) * c), KNOTS - 2);
  float t = (KNOTS - 1.0) * c - j;
  return (1.0 - t) * MIXTURE_READ(first + j) + t * MIXTURE_READ(first + j + 1);
}

MIXTURE_VALUE eval_phong_ramp(float MIXTURE[], MixtureView view, int k, vector wi)
{
  float exponent = view.shape[k];
  float falloff = pow(clamp(dot(view.axis[k], wi), 0.0, 1.0), exponent);
  float height = max(dot(view.half[k], wi), 0.0) * (exponent + 2.0) / M_2PI * falloff;
  if (height < LEAST_PHONG) {
    return 0.0;
  }
  return height * eval_ramp(MIXTURE, view.row + KNOTS * (k + 1), falloff);
}

#if !ANISOTROPIC
/* GGX reflection about a normal without a Fresnel factor, times the cosine of that normal and wi. */
float eval_ggx(float alpha, vector about, vector wo, vector wi)
{
  float cos_o = dot(about, wo);
  float cos_i = dot(about, wi);
  float value = 0.0;
  if (cos_o > HORIZON && cos_i > HORIZON) {
    float cos_h = dot(about, normalize(wo + wi));
    float a2 = alpha * alpha;
    float bottom = cos_h * cos_h * (a2 - 1.0) + 1.0;
    float masking_o = sqrt(1.0 + a2 * (1.0 / (cos_o * cos_o) - 1.0));
    float masking_i = sqrt(1.0 + a2 * (1.0 / (cos_i * cos_i) - 1.0));
    value = a2 / (2.0 * M_PI * bottom * bottom * cos_o * (masking_o + masking_i));
  }
  return value;
}
#endif

/* The mixture in a direction wi above the horizon, times cos theta_i: what Cycles makes of `mixture_closures`. */
color eval_mixture(float MIXTURE[], MixtureView view, vector wi)
{
  MIXTURE_VALUE sum = MIXTURE_READ(view.row + WEIGHTS) * eval_ramp(MIXTURE, view.row, wi[2]) * (1.0 / M_PI);
  for (int k = 0; k < LOBES; k++) {
    MIXTURE_VALUE lobe;
    if (view.kind[k] == GGX) {
#if ANISOTROPIC
      lobe = eval_ggx(view.shape[k], view.across[k], view.axis[k], view.wo, wi);
#else
      lobe = eval_ggx(view.shape[k], view.axis[k], view.wo, wi);
#endif
    }
    else {
      lobe = eval_phong_ramp(MIXTURE, view, k, wi);
    }
    sum += MIXTURE_READ(view.row + WEIGHTS + 1 + k) * lobe;
  }
  return view.scale * color(sum);
}

/* What the fit reflects: the sum of the mixture's closure weights, raised to the albedo of the fit. */
color reflected_albedo(float MIXTURE[], MixtureView view)
{
  MIXTURE_VALUE sum = 0.0;
  for (int k = 0; k <= LOBES; k++) {
    sum += MIXTURE_READ(view.row + WEIGHTS + k);
  }
  return color(MIXTURE_READ(view.row + ALBEDO_SCALE) * sum);
}

/* The colours of a ramp closure; `first` is the entry of its first knot. */
void ramp_colors(float MIXTURE[], int first, color scale, output color ramp[KNOTS])
{
  for (int j = 0; j < KNOTS; j++) {
    ramp[j] = scale * MIXTURE_READ(first + j);
  }
}

/* The mixture, for Cycles to evaluate and to sample. Its closure weights add to about `share` of the albedo, which they
 * tell a denoiser, times the tint. That of a microfacet lobe is its value, so that the others make up for it.
 *
 * Here and elsewhere a variable for the weight stands before each closure: OSL makes such a weight a part of its
 * closure, and any other a closure of its own, for which GPUs have little room. */
closure color mixture_closures(float MIXTURE[], MixtureView view, ShadingFrame frame, float share, color tint)
{
  color ramps = MIXTURE_READ(view.row + WEIGHTS);
  color microfacets = 0.0;
  for (int k = 0; k < LOBES; k++) {
    color weight = MIXTURE_READ(view.row + WEIGHTS + 1 + k);
    if (view.kind[k] == GGX) {
      microfacets += weight;
    }
    else {
      ramps += weight;
    }
  }
  color raised = MIXTURE_READ(view.row + ALBEDO_SCALE) * (ramps + microfacets);
  raised = max((share * raised - view.scale * microfacets) / ramps, LEAST_RAMP_SHARE * raised / ramps);
  color scale = view.scale / raised;
  color ramp[KNOTS];
  ramp_colors(MIXTURE, view.row, scale, ramp);
  color weight = tint * raised * MIXTURE_READ(view.row + WEIGHTS);
  closure color sum = weight * diffuse_ramp(frame.z, ramp);
  for (int k = 0; k < LOBES; k++) {
    weight = tint * MIXTURE_READ(view.row + WEIGHTS + 1 + k);
#if ANISOTROPIC
    vector about = to_world(frame, view.half[k]);
    vector along = frame.x;
    float across = view.across[k];
#else
    vector about = view.half[k][0] * frame.x + view.half[k][2] * frame.z;
    vector along = 0.0;
    float across = view.shape[k];
#endif
    if (view.kind[k] == GGX) {
      weight *= view.scale;
      sum += weight * microfacet("ggx", about, along, view.shape[k], across, MICROFACET_IOR, 0);
    }
    else {
      ramp_colors(MIXTURE, view.row + KNOTS * (k + 1), scale, ramp);
      weight *= raised;
      sum += weight * phong_ramp(about, view.shape[k], ramp);
    }
  }
  return sum;
}
