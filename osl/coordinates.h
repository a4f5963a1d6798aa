/* The coordinates of a pair of directions in which a fit is smooth. The directions are unit vectors in a frame whose z
 * axis is the normal, and whose x axis is the tangent of an anisotropic fit; each coordinate is in [-1, 1]. */

#if HALF_DIFFERENCE || RUSINKIEWICZ
/* The half vector (x, y) with more room near the mirror direction; see fitter/coordinates/stretch.py. OSL divides by 0
 * to 0, where x and y are 0 too. */
vector stretch_half_vector(float d, float x, float y)
{
#if STRETCHED
  float radius = hypot(x, y);
  float t = STRETCH * radius;
  float factor = STRETCH_SCALE * log(t + sqrt(1.0 + t * t)) / radius;
  return vector(d, x * factor, y * factor);
#else
  return vector(d, x, y);
#endif
}
#endif

#if AXES == 4
/* The second vector is reflected to its stored half. */
void fold_difference(float half_x, float half_y, float difference_x, float difference_y, output float mu[4])
{
  float side = difference_y < 0.0 ? -1.0 : 1.0;
  mu[0] = half_x;
  mu[1] = half_y;
  mu[2] = side * difference_x;
  mu[3] = side * difference_y;
}
#endif

#if HALF_DIFFERENCE
/* Half and difference coordinates (d, x, y); see fitter/coordinates/half_difference.py. */
vector coordinates(vector wi, vector wo)
{
  vector q_i = vector(wi[0], wi[1], 0.0) / (1.0 + 2.0 * wi[2]);
  vector q_o = vector(wo[0], wo[1], 0.0) / (1.0 + 2.0 * wo[2]);
  vector half = 0.5 * (q_i + q_o);
  vector difference = 0.5 * (q_i - q_o);
  float difference2 = dot(difference, difference);
  float d2 = hypot(SOFTENING_2, sqrt(1.0 - SOFTENING_2 * SOFTENING_2) * difference2);
  float d = sqrt(d2);
  float outer = half[0] * difference[1] - half[1] * difference[0];
  float softened = SOFTENING_2 * sqrt((1.0 - difference2 * difference2) / (d2 + difference2)) * length(half);
  return stretch_half_vector(d, dot(half, difference) / d, hypot(outer, softened) / d);
}
#elif RUSINKIEWICZ
/* Half and difference angles (d, x, y); see fitter/coordinates/rusinkiewicz.py. */
vector coordinates(vector wi, vector wo)
{
  vector sum = wi + wo;
  vector difference = wi - wo;
  float sum2 = max(dot(sum, sum), LEAST_HEIGHT_2);
  float sin2_d = 0.25 * dot(difference, difference);
  float s2 = hypot(SOFTENING_2, sqrt(1.0 - SOFTENING_2 * SOFTENING_2) * sin2_d);
  float s = sqrt(s2);
  float common = 0.25 * sum2 * (1.0 + sin2_d);
  float over = SOFTENING_2 * sqrt(common / (s2 + sin2_d));
  float outer = wi[0] * wo[1] - wi[1] * wo[0];
  float spread = s * (sqrt(sum2) + 2.0 * sum[2]);
  return stretch_half_vector(s / (1.0 + 2.0 * sqrt((1.0 - SOFTENING_2 * SOFTENING_2) * common / (1.0 + s2))),
                             0.5 * sqrt(sum2) * (wo[2] - wi[2]) / spread,
                             hypot(hypot(sum[0], sum[1]) * over, outer) / spread);
}
#elif HALF_ANGLE
/* The half angle, and the difference vector (h, x, y); see fitter/coordinates/half_angle.py. */
vector coordinates(vector wi, vector wo)
{
  vector sum = wi + wo;
  float size = sqrt(max(dot(sum, sum), LEAST_HEIGHT_2));
  float spread = size + 2.0 * sum[2];
  float along = hypot(sum[0], sum[1]);
  float r = along / spread;
  float kept = r * r / (r * r + SOFTENING_2);
  /* the difference vector toward the normal, and across it: each is found from what is exact there */
  float d = 0.5 * length(wi - wo) / (1.0 + size);
  float x = clamp(0.5 * (wo[2] - wi[2]) * size / (along * (1.0 + size)), -d, d);
  float y = sqrt((d - kept * x) * (d + kept * x));
  if (kept > MOSTLY) {
    y = hypot(fabs(wi[0] * wo[1] - wi[1] * wo[0]) / (along * (1.0 + size)), x * sqrt((1.0 - kept) * (1.0 + kept)));
  }
#if STRETCHED
  float t = STRETCH * r;
  r = STRETCH_SCALE * log(t + sqrt(1.0 + t * t));
#endif
  float room = 1.0;
#if BACK_STRETCHED
  float v = BACK_STRETCH * d;
  room = BACK_STRETCH_SCALE * log(v + sqrt(1.0 + v * v)) / d;     /* by 0, where x and y are 0 too, it is 0 */
#endif
  return vector(r, room * kept * x, room * y);
}
#elif ANISOTROPIC_RUSINKIEWICZ
/* Half and difference vectors; see fitter/coordinates/anisotropic_rusinkiewicz.py. */
void coordinates(vector wi, vector wo, output float mu[4])
{
  vector sum = wi + wo;
  float sum_length = sqrt(max(dot(sum, sum), LEAST_HEIGHT_2));
  vector h = sum / sum_length;
  vector d = (wi - (0.5 * sum_length + wi[2]) / (1.0 + h[2]) * h) / (1.0 + sum_length);
  h = h / (1.0 + 2.0 * h[2]);
  float x = STRETCH_ALONG * (ROTATION_COSINE * h[0] + ROTATION_SINE * h[1]);
  float y = STRETCH_ACROSS * (ROTATION_COSINE * h[1] - ROTATION_SINE * h[0]);
  float radius = hypot(x, y);
  float factor = STRETCH_SCALE * log(radius + sqrt(1.0 + radius * radius)) / radius;
  fold_difference(x * factor, y * factor, ROTATION_COSINE * d[0] + ROTATION_SINE * d[1],
                  ROTATION_COSINE * d[1] - ROTATION_SINE * d[0], mu);
}
#elif ANISOTROPIC_NUSSELT
/* Half sum and half difference of projected directions; see fitter/coordinates/anisotropic_nusselt.py. */
void coordinates(vector wi, vector wo, output float mu[4])
{
  fold_difference(0.5 * (wi[0] + wo[0]), 0.5 * (wi[1] + wo[1]), 0.5 * (wi[0] - wo[0]), 0.5 * (wi[1] - wo[1]), mu);
}
#else
/* Nusselt coordinates (2 kappa_i - 1, 2 kappa_o - 1, 2 lambda_o - 1); see fitter/coordinates/nusselt.py. At normal
 * incidence wi has no azimuth and takes that of wo. */
vector coordinates(vector wi, vector wo)
{
  float sin_i = hypot(wi[0], wi[1]);
  if (sin_i < LEAST_LENGTH) {
    return vector(0.0, hypot(wo[0], wo[1]), 0.0);
  }
  return vector(sin_i, (wi[0] * wo[0] + wi[1] * wo[1]) / sin_i, fabs(wi[0] * wo[1] - wi[1] * wo[0]) / sin_i);
}
#endif
