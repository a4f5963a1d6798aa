/* The closure mixture of fitter/cycles/closure_mixture.py: what Cycles will make of the closures, for any direction.
 *
 * Constants in capitals come from the baker. A row of the table, one a view, holds RAMPS x 8 knots, divided by their
 * ramp's weight, then the weights of the ramps and of the microfacet lobe, their sum, and how often to draw. */

#if CHANNELS == 3
#  define MIXTURE_VALUE color
#  define MIXTURE_READ(i) color(MIXTURE[3 * (i)], MIXTURE[3 * (i) + 1], MIXTURE[3 * (i) + 2])
#else
#  define MIXTURE_VALUE float
#  define MIXTURE_READ(i) MIXTURE[i]
#endif

#define STEEPEST_AXIS 1.501      /* for an axis: 86 degrees */

/* A direction in the plane of incidence, theta from the normal, on the mirror side. */
vector mirror_side(float theta)
{
  return vector(-sin(theta), 0.0, cos(theta));
}

/* One of the two tabulated views on either side of theta_o, by a random number. */
int view_beside(float theta_o, float u)
{
  float t = max(0.0, 1.0 - theta_o / GRAZING);
  int below = min((int)((VIEWS - 1) * (1.0 - pow(t, 2.0 / 3.0))), VIEWS - 2);
  float low = 1.0 - below / (VIEWS - 1.0);
  float high = 1.0 - (below + 1) / (VIEWS - 1.0);
  low = low * sqrt(low);
  high = high * sqrt(high);
  return u * (low - high) < low - t ? below + 1 : below;
}

/* A ramp at c in [0, 1], from knot `first` of the table on. */
MIXTURE_VALUE ramp_at(float MIXTURE[], int first, float c)
{
  int j = min((int)(7.0 * c), 6);
  float t = 7.0 * c - j;
  return (1.0 - t) * MIXTURE_READ(first + j) + t * MIXTURE_READ(first + j + 1);
}

MIXTURE_VALUE phong_value(float MIXTURE[], int row, int ramp, vector axis, vector h, float exponent, vector wi)
{
  float fall = pow(clamp(dot(axis, wi), 0.0, 1.0), exponent);
  float height = max(dot(h, wi), 0.0) * (exponent + 2.0) / M_2PI * fall;
  if (height < 1e-7) {
    return 0.0;
  }
  return height * MIXTURE_READ(row + WEIGHTS + ramp) * ramp_at(MIXTURE, row + 8 * ramp, fall);
}

/* GGX reflection without a Fresnel factor, times cos theta_i. */
float microfacet_value(float alpha, vector wo, vector wi)
{
  vector h = normalize(wo + wi);
  float a2 = alpha * alpha;
  float bottom = h[2] * h[2] * (a2 - 1.0) + 1.0;
  float masking_o = sqrt(1.0 + a2 * (1.0 / (wo[2] * wo[2]) - 1.0));
  float masking_i = sqrt(1.0 + a2 * (1.0 / (wi[2] * wi[2]) - 1.0));
  return a2 / (2.0 * M_PI * bottom * bottom * wo[2] * (masking_o + masking_i));
}

/* The mixture in direction wi above the horizon, cosine included. `axis` and `h` are those of the Phong lobes. */
color mixture_value(float MIXTURE[], int row, vector axis, vector h, vector wo, vector wi)
{
  MIXTURE_VALUE sum = MIXTURE_READ(row + WEIGHTS) * ramp_at(MIXTURE, row, wi[2]) * (1.0 / M_PI) +
                      phong_value(MIXTURE, row, 1, axis, h, EXPONENT_0, wi) +
                      phong_value(MIXTURE, row, 2, axis, h, EXPONENT_1, wi) +
                      MIXTURE_READ(row + MICROFACET) * microfacet_value(ROUGHNESS, wo, wi);
  return color(sum);
}

void read_ramp(float MIXTURE[], int first, color tint, output color ramp[8])
{
  for (int j = 0; j < 8; j++) {
    ramp[j] = tint * MIXTURE_READ(first + j);
  }
}
