/* The closure mixture: a sum of closures that is close to the fit, and its value in any direction.
 *
 * fitter/closure_mixture.py fits it, and fitter/shader_constants.py describes a row of its table. The knots of a row
 * are divided by the weight of their ramp. */

#if CHANNELS == 3
#  define MIXTURE_VALUE color
#  define MIXTURE_READ(i) color(MIXTURE[3 * (i)], MIXTURE[3 * (i) + 1], MIXTURE[3 * (i) + 2])
#else
#  define MIXTURE_VALUE float
#  define MIXTURE_READ(i) MIXTURE[i]
#endif
#define MIXTURE_NUMBER(i) MIXTURE[CHANNELS * (i)]      /* of an entry that is equal in all channels */

/* The mixture for one viewing direction. */
struct MixtureView {
  int view;         /* the tabulated viewing angle */
  int row;          /* where its row begins */
  vector wo;        /* the viewing direction */
  vector axis;      /* of the phong_ramps */
  vector half;      /* the half vector of wo and axis: the normal that gives a phong_ramp this axis */
};

/* One of the two tabulated views next to theta_o, by a random number. */
int nearby_view(float theta_o, float u)
{
  float t = max(0.0, 1.0 - theta_o / GRAZING);
  int below = min((int)((VIEWS - 1) * (1.0 - pow(t, 2.0 / 3.0))), VIEWS - 2);
  float low = 1.0 - below / (VIEWS - 1.0);
  float high = 1.0 - (below + 1) / (VIEWS - 1.0);
  low = low * sqrt(low);
  high = high * sqrt(high);
  return u * (low - high) < low - t ? below + 1 : below;
}

/* The direction at an angle theta from the normal, in the plane of incidence, opposite to the viewer. */
vector mirror_side(float theta)
{
  return vector(-sin(theta), 0.0, cos(theta));
}

/* The mixture of a tabulated view, seen from wo. `OFFSET` is how far the axes lean from the mirror direction. */
MixtureView mixture_view(float OFFSET[], int view, float theta_o, vector wo)
{
  MixtureView found;
  found.view = view;
  found.row = view * ROW;
  found.wo = wo;
  found.axis = mirror_side(min(theta_o + OFFSET[view], STEEPEST_AXIS));
  found.half = normalize(wo + found.axis);
  return found;
}

MixtureView sample_view(float OFFSET[], vector wo, point seed)
{
  float theta_o = acos(clamp(wo[2], 0.0, 1.0));
  return mixture_view(OFFSET, nearby_view(theta_o, random(seed, RANDOM_VIEW)), theta_o, wo);
}

/* A ramp at c in [0, 1]; `first` is the entry of its first knot. */
MIXTURE_VALUE eval_ramp(float MIXTURE[], int first, float c)
{
  int j = min((int)((KNOTS - 1.0) * c), KNOTS - 2);
  float t = (KNOTS - 1.0) * c - j;
  return (1.0 - t) * MIXTURE_READ(first + j) + t * MIXTURE_READ(first + j + 1);
}

MIXTURE_VALUE eval_phong_ramp(float MIXTURE[], MixtureView view, int ramp, float exponent, vector wi)
{
  float falloff = pow(clamp(dot(view.axis, wi), 0.0, 1.0), exponent);
  float height = max(dot(view.half, wi), 0.0) * (exponent + 2.0) / M_2PI * falloff;
  if (height < LEAST_PHONG) {
    return 0.0;
  }
  return height * MIXTURE_READ(view.row + WEIGHTS + ramp) * eval_ramp(MIXTURE, view.row + KNOTS * ramp, falloff);
}

/* GGX reflection without a Fresnel factor, times cos theta_i. */
float eval_ggx(float alpha, vector wo, vector wi)
{
  vector h = normalize(wo + wi);
  float a2 = alpha * alpha;
  float bottom = h[2] * h[2] * (a2 - 1.0) + 1.0;
  float masking_o = sqrt(1.0 + a2 * (1.0 / (wo[2] * wo[2]) - 1.0));
  float masking_i = sqrt(1.0 + a2 * (1.0 / (wi[2] * wi[2]) - 1.0));
  return a2 / (2.0 * M_PI * bottom * bottom * wo[2] * (masking_o + masking_i));
}

/* The mixture in a direction wi above the horizon, times cos theta_i: what Cycles makes of `mixture_closures`. */
color eval_mixture(float MIXTURE[], MixtureView view, vector wi)
{
  MIXTURE_VALUE sum = MIXTURE_READ(view.row + WEIGHTS) * eval_ramp(MIXTURE, view.row, wi[2]) * (1.0 / M_PI) +
                      eval_phong_ramp(MIXTURE, view, 1, EXPONENT_0, wi) +
                      eval_phong_ramp(MIXTURE, view, 2, EXPONENT_1, wi) +
                      MIXTURE_READ(view.row + MICROFACET) * eval_ggx(ROUGHNESS, view.wo, wi);
  return color(sum);
}

/* The colours of a ramp closure; `first` is the entry of its first knot. */
void ramp_colors(float MIXTURE[], int first, color tint, output color ramp[KNOTS])
{
  for (int j = 0; j < KNOTS; j++) {
    ramp[j] = tint * MIXTURE_READ(first + j);
  }
}

/* The mixture, for Cycles to evaluate and to sample. */
closure color mixture_closures(float MIXTURE[], MixtureView view, ShadingFrame frame, color tint)
{
  vector half = view.half[0] * frame.x + view.half[2] * frame.z;
  color ramp[KNOTS];
  ramp_colors(MIXTURE, view.row, tint, ramp);
  closure color sum = color(MIXTURE_READ(view.row + WEIGHTS)) * diffuse_ramp(frame.z, ramp);
  ramp_colors(MIXTURE, view.row + KNOTS, tint, ramp);
  sum += color(MIXTURE_READ(view.row + WEIGHTS + 1)) * phong_ramp(half, EXPONENT_0, ramp);
  ramp_colors(MIXTURE, view.row + 2 * KNOTS, tint, ramp);
  sum += color(MIXTURE_READ(view.row + WEIGHTS + 2)) * phong_ramp(half, EXPONENT_1, ramp);
  sum += tint * color(MIXTURE_READ(view.row + MICROFACET)) *
         microfacet("ggx", frame.z, vector(0.0), ROUGHNESS, ROUGHNESS, MICROFACET_IOR, 0);
  return sum;
}
