/* The prior of a fit, 1/sr: a Lambertian and lobes of four kinds; see fitter/model/microfacet.py. */

#include "values.h"

#if LOG_RELATIVE
#if PRIOR_ANISOTROPIC
/* (slope / width)^2 along both axes of a lobe, and 1, by the same of widths of 1. */
float steepness(float x, float y, float c, float s, float inverse_along, float inverse_across)
{
  float along = (c * x + s * y) * inverse_along;
  float across = (c * y - s * x) * inverse_across;
  return (1.0 + along * along + across * across) / (1.0 + x * x + y * y);
}

float cone(float t, float gamma)
{
  return pow(1.0 + t * t, -gamma);
}

/* The length of a direction whose part in the surface is scaled by the roughness along each axis of a lobe. */
float smith_length(vector w, float c, float s, float m, float m_across)
{
  float along = (c * w[0] + s * w[1]) * m;
  float across = (c * w[1] - s * w[0]) * m_across;
  return sqrt(w[2] * w[2] + along * along + across * across);
}
#endif

VALUE eval_prior(vector wi, vector wo)
{
  vector h = wi + wo;
  float height2 = max(h[2] * h[2], LEAST_HEIGHT_2);
#if PRIOR_ANISOTROPIC
  float slope_x = h[0] / sqrt(height2);
  float slope_y = h[1] / sqrt(height2);
#endif
  float slope2 = (h[0] * h[0] + h[1] * h[1]) / height2;
  float difference = 1.0 - 0.5 * length(h);
  float grazing = pow(difference, 5.0);
  VALUE b = PRIOR_KD;
#define LOBE(ks, inverse_alpha2, gamma, f0, m2) \
  b += ks * (pow(1.0 + slope2 * inverse_alpha2, -gamma) * (f0 + (1.0 - f0) * grazing) * 0.5 / \
             (wo[2] * sqrt(wi[2] * wi[2] * (1.0 - m2) + m2) + wi[2] * sqrt(wo[2] * wo[2] * (1.0 - m2) + m2) + DENSEST));
/* of two widths, along the azimuth whose cosine and sine are c and s and across it; see longer() */
#define ANISOTROPIC_LOBE(ks, c, s, inverse_along, inverse_across, gamma, f0, m, m_across) \
  b += ks * (pow(steepness(slope_x, slope_y, c, s, inverse_along, inverse_across), -gamma) * \
             (f0 + (1.0 - f0) * grazing) * 0.5 / \
             (wo[2] * smith_length(wi, c, s, m, m_across) + wi[2] * smith_length(wo, c, s, m, m_across) + DENSEST));
#define FIBRE(ks, c, s, inverse_alpha, dip, gamma, f0) \
  b += ks * (0.5 * (cone((c * h[0] + s * h[1] - dip * h[2]) * inverse_alpha, gamma) + \
                    cone((c * h[0] + s * h[1] + dip * h[2]) * inverse_alpha, gamma)) * \
             (f0 + (1.0 - f0) * difference) / (wi[2] + wo[2] - wi[2] * wo[2] + DENSEST));
#define RETRO(ks, inverse_alpha2, gamma, f0) \
  b += ks * (pow(1.0 + back2 / height2 * inverse_alpha2, -gamma) * (f0 + (1.0 - f0) * 0.25 * (back2 + height2)));
#define SHEEN(ks, inverse_alpha2, f0) \
  b += ks * (exp(-inverse_alpha2 / max(slope2, LEAST_SLOPE_2)) * (f0 + (1.0 - f0) * difference) / \
             (wi[2] + wo[2] - wi[2] * wo[2] + DENSEST));
#if PRIOR_RETRO
  vector back = wi - wo;
  float back2 = back[0] * back[0] + back[1] * back[1];
#endif
  PRIOR_LOBES
  return b;
}
#endif
