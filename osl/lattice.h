/* The bi-level B-spline fit: coordinates, the dense and the sparse control lattice, and the prior.
 *
 * Kameya and Lewis 2002, equations 5 to 7. The lattices are the boxes that fitter/lattice/dense.py describes; constants
 * in capitals come from the baker. A lattice of M cells an axis has half = M / 2 (whole number) and odd = 0.5 for M = 1,
 * else 0: coordinates are counted from the middle of the cube, where single precision is finest. */

/* Equal channels share a column of the tables; where all do, values are read and summed as floats. */
#if STORED == 1
#  define VALUE float
#  define READ(table, i) table[i]
#else
#  define VALUE color
#  define READ(table, i) color(table[STORED * (i) + CHANNEL_0], table[STORED * (i) + CHANNEL_1], \
                               table[STORED * (i) + CHANNEL_2])
#endif

#if PRIOR
/* Half and difference coordinates (d, x, y) of two unit vectors in a frame whose z axis is the normal; see
 * fitter/coordinates/half_difference.py. */
vector coordinates(vector wi, vector wo)
{
  vector q_i = vector(wi[0], wi[1], 0.0) / (1.0 + 2.0 * wi[2]);
  vector q_o = vector(wo[0], wo[1], 0.0) / (1.0 + 2.0 * wo[2]);
  vector half = 0.5 * (q_i + q_o);
  vector difference = 0.5 * (q_i - q_o);
  float apart2 = dot(difference, difference);
  float d2 = hypot(SOFTENING_2, sqrt(1.0 - SOFTENING_2 * SOFTENING_2) * apart2);
  float d = sqrt(d2);
  if (d < 1e-7) {
    return vector(0.0, length(half), 0.0);
  }
  float outer = half[0] * difference[1] - half[1] * difference[0];
  float rest = SOFTENING_2 * sqrt(max(1.0 - apart2 * apart2, 0.0) / (d2 + apart2)) * length(half);
  return vector(d, dot(half, difference) / d, hypot(outer, rest) / d);
}

/* A Lambertian and lobes of microfacets; see fitter/model/microfacet.py. */
VALUE prior(vector wi, vector wo)
{
  vector h = wi + wo;
  float slope2 = (h[0] * h[0] + h[1] * h[1]) / max(h[2] * h[2], 1e-12);
  float grazing = pow(1.0 - min(0.5 * length(h), 1.0), 5.0);
  VALUE b = PRIOR_KD;
#define LOBE(ks, inverse_alpha2, gamma, f0, m2) \
  b += ks * (pow(1.0 + slope2 * inverse_alpha2, -gamma) * (f0 + (1.0 - f0) * grazing) * 0.5 / \
             (wo[2] * sqrt(wi[2] * wi[2] * (1.0 - m2) + m2) + wi[2] * sqrt(wo[2] * wo[2] * (1.0 - m2) + m2) + DENSEST));
  PRIOR_LOBES
  return b;
}
#else
/* (2 kappa_i - 1, 2 kappa_o - 1, 2 lambda_o - 1) of two unit vectors in a frame whose z axis is the normal. At normal
 * incidence, where the azimuth of wi means nothing, it is taken to be that of wo. */
vector coordinates(vector wi, vector wo)
{
  float sin_i = hypot(wi[0], wi[1]);
  if (sin_i < 1e-7) {
    return vector(0.0, hypot(wo[0], wo[1]), 0.0);
  }
  return vector(sin_i, (wi[0] * wo[0] + wi[1] * wo[1]) / sin_i, fabs(wi[0] * wo[1] - wi[1] * wo[0]) / sin_i);
}
#endif

/* Uniform cubic B-spline basis. */
void basis(float s, output float w[4])
{
  float t = 1.0 - s;
  w[0] = t * t * t / 6.0;
  w[1] = (4.0 - 3.0 * s * s * (2.0 - s)) / 6.0;
  w[2] = (4.0 - 3.0 * t * t * (2.0 - t)) / 6.0;
  w[3] = s * s * s / 6.0;
}

/* The cell that holds coordinate mu, counted from the middle cell, and the basis there; mu = 1 is in the last cell. */
int locate(float mu, int cells, output float w[4])
{
  int half = cells / 2;
  float u = mu * (0.5 * cells) + (0.5 * cells - half);
  int cell = clamp((int)floor(u), -half, cells - 1 - half);
  basis(u - cell, w);
  return cell;
}

/* Control points along kappa_o and lambda_o. */
#define ROWS(cells) ((cells) + 3)
#define COLUMNS(cells) ((cells) - (cells) / 2 + 3)

/* Where the 4 x 4 x 4 control points begin that are read at mu, and their weights along each axis. */
int first_tap(vector mu, int cells, output float wa[4], output float wb[4], output float wc[4])
{
  int a = max(locate(mu[0], cells, wa), 0);
  int b = locate(mu[1], cells, wb) + cells / 2;
  int c = max(locate(mu[2], cells, wc), 0);
  return (a * ROWS(cells) + b) * COLUMNS(cells) + c;
}

VALUE dense_lattice(float points[], int cells, vector mu)
{
  float wa[4], wb[4], wc[4];
  int tap = first_tap(mu, cells, wa, wb, wc);
  VALUE total = 0.0;
  for (int i = 0; i < 4; i++) {
    for (int j = 0; j < 4; j++) {
      int at = tap + (i * ROWS(cells) + j) * COLUMNS(cells);
      total += wa[i] * wb[j] *
               (wc[0] * READ(points, at) + wc[1] * READ(points, at + 1) + wc[2] * READ(points, at + 2) +
                wc[3] * READ(points, at + 3));
    }
  }
  return total;
}

#if SPARSE
VALUE sparse_lattice(float points[], int keys[], int displacement[], int cells, vector mu)
{
  float wa[4], wb[4], wc[4];
  int tap = first_tap(mu, cells, wa, wb, wc);
  VALUE total = 0.0;
  for (int i = 0; i < 4; i++) {
    for (int j = 0; j < 4; j++) {
      int key = tap + (i * ROWS(cells) + j) * COLUMNS(cells);
      float w = wa[i] * wb[j];
      for (int k = 0; k < 4; k++) {
        int slot = find_slot(keys, displacement, key + k);
        if (slot >= 0) {
          total += w * wc[k] * READ(points, slot);
        }
      }
    }
  }
  return total;
}
#endif

#if SPARSE
#  define FIT_TABLES float diffuse_points[], float specular_points[], int keys[], int displacement[]
#  define FIT DIFFUSE, SPECULAR, KEYS, DISPLACEMENT
#else
#  define FIT_TABLES float diffuse_points[]
#  define FIT DIFFUSE
#endif

/* The fitted BRDF in 1 / sr, where the fit undershoots 0; directions as in coordinates(). */
color fitted_brdf(FIT_TABLES, vector wi, vector wo)
{
  vector mu = coordinates(wi, wo);
  VALUE f = dense_lattice(diffuse_points, DIFFUSE_CELLS, mu);
#if SPARSE
  f += sparse_lattice(specular_points, keys, displacement, SPECULAR_CELLS, mu);
#endif
#if PRIOR
  f = min((prior(wi, wo) + PRIOR_OFFSET) * exp(min(f, VALUE(STEEPEST))) - PRIOR_OFFSET, VALUE(PRIOR_CEILING));
#endif
  return max(color(f), color(0.0));
}
