/* An edit of the fit: its parts scaled, the highlight widened, a clear coat. See fitter/model/edit.py. */

#include "unedited_fit.h"

#if EDITED
VALUE diffuse_part(VALUE f)
{
  VALUE level = EDIT_LEVEL;
  VALUE over = clamp(f - level, VALUE(0.0), level);
  return min(f, 2.0 * level) - 0.5 * over * over / level;
}

#if WIDENED
/* A direction rotated in the plane of the normal and the axis. */
vector rotate_in_plane(vector w, vector axis, float cosine, float sine)
{
  float before = dot(w, axis);
  vector moved = w + (before * cosine + w[2] * sine - before) * axis;
  moved[2] = max(w[2] * cosine - before * sine, LEAST_HORIZON_COSINE);
  return normalize(moved);
}

/* Where the highlight is read, and the density of its half vectors relative to there. OSL divides by 0 to 0, where the
 * half vector is the normal and nothing turns. */
float narrow_directions(vector wi, vector wo, output vector narrow_i, output vector narrow_o)
{
  vector h = wi + wo;
  float run = hypot(h[0], h[1]);
  float slope = run / sqrt(max(h[2] * h[2], LEAST_HEIGHT_2));
  float narrow = slope / EDIT_WIDTH;
  float scale = 1.0 / sqrt((1.0 + slope * slope) * (1.0 + narrow * narrow));
  float cosine = (1.0 + slope * narrow) * scale;
  float sine = (narrow - slope) * scale;
  vector axis = vector(h[0] / run, h[1] / run, 0.0);
  narrow_i = rotate_in_plane(wi, axis, cosine, sine);
  narrow_o = rotate_in_plane(wo, axis, cosine, sine);
  float density = (1.0 + slope * slope) / ((1.0 + narrow * narrow) * EDIT_WIDTH);
  return density * density;
}
#endif

#if COATED
float eval_coat(vector wi, vector wo)
{
  vector h = wi + wo;
  float slope2 = (h[0] * h[0] + h[1] * h[1]) / max(h[2] * h[2], LEAST_HEIGHT_2);
  float steepness = (1.0 + slope2) / (1.0 + slope2 / COAT_ALPHA_2);
  float visibility = 0.5 / max(wo[2] * sqrt(wi[2] * wi[2] * (1.0 - COAT_ALPHA_2) + COAT_ALPHA_2) +
                               wi[2] * sqrt(wo[2] * wo[2] * (1.0 - COAT_ALPHA_2) + COAT_ALPHA_2), LEAST_LENGTH);
  float fresnel = COAT_F0 + (1.0 - COAT_F0) * pow(1.0 - 0.5 * length(h), 5.0);
  return steepness * steepness / (M_PI * COAT_ALPHA_2) * fresnel * visibility;
}
#endif

/* The edited BRDF, 1/sr. */
color eval_edited_fit(FIT_PARAMETERS, vector wi, vector wo)
{
  VALUE f = eval_measured(FIT, wi, wo);
  VALUE diffuse = diffuse_part(f);
  VALUE highlight = f - diffuse;
#if WIDENED
  vector narrow_i;
  vector narrow_o;
  float density = narrow_directions(wi, wo, narrow_i, narrow_o);
  highlight = eval_measured(FIT, narrow_i, narrow_o);
  highlight = (highlight - diffuse_part(highlight)) * density * eval_factor(BALANCE, wi) * eval_factor(BALANCE, wo);
#endif
  color total = EDIT_DIFFUSE * diffuse + EDIT_HIGHLIGHT * highlight;
#if COATED
  total = COAT * eval_coat(wi, wo) + eval_factor(COAT_TRANSMITTANCE, wi) * eval_factor(COAT_TRANSMITTANCE, wo) * total;
#endif
  return total;
}
#endif
