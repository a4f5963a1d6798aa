/* The fitted BRDF: a bi-level B-spline, and its transform. The spline is the BRDF itself, or with LOG_RELATIVE the
 * logarithm of the BRDF relative to a prior; see fitter/model/transform.py. */

/* Equal channels share a column of the tables; where all channels are equal, values are floats. */
#if STORED == 1
#  define VALUE float
#  define READ(table, i) table[i]
#else
#  define VALUE color
#  define READ(table, i) color(table[STORED * (i) + CHANNEL_0], table[STORED * (i) + CHANNEL_1], \
                               table[STORED * (i) + CHANNEL_2])
#endif

#include "perfect_hash.h"
#include "coordinates.h"
#include "prior.h"
#include "lattice.h"

/* The tables of a fit as parameters of a function, and as its arguments. */
#if SPARSE
#  define SPARSE_PARAMETERS , float SPECULAR[], int OCCUPANCY[], int DISPLACEMENT[]
#  define SPARSE_TABLES , SPECULAR, OCCUPANCY, DISPLACEMENT
#else
#  define SPARSE_PARAMETERS
#  define SPARSE_TABLES
#endif
#if DAMPED
#  define DAMPING_PARAMETERS , float DAMPING[]
#  define DAMPING_TABLES , DAMPING
#else
#  define DAMPING_PARAMETERS
#  define DAMPING_TABLES
#endif
#define FIT_PARAMETERS float DIFFUSE[] SPARSE_PARAMETERS DAMPING_PARAMETERS
#define FIT DIFFUSE SPARSE_TABLES DAMPING_TABLES

#if DAMPED
/* The factor of one polar angle by which the fit conserves energy: a cubic B-spline of the projected radius. */
VALUE eval_damping(float DAMPING[], vector w)
{
  float at = length(vector(w[0], w[1], 0.0)) / (1.0 + 2.0 * w[2]) * (DAMPING_KNOTS - 1);
  int knot = min((int)at, DAMPING_KNOTS - 2);
  int before = abs(knot - 1);
  int behind = min(knot + 2, DAMPING_KNOTS - 1);
  float b[4];
  bspline_basis(at - knot, b);
  return b[0] * READ(DAMPING, before) + b[1] * READ(DAMPING, knot) + b[2] * READ(DAMPING, knot + 1) +
         b[3] * READ(DAMPING, behind);
}
#endif

/* The fitted BRDF, 1/sr, and 0 where the fit undershoots; directions as in coordinates(). */
color eval_fit(FIT_PARAMETERS, vector wi, vector wo)
{
#if AXES == 4
  float mu[4];
  coordinates(wi, wo, mu);
#else
  vector mu = coordinates(wi, wo);
#endif
  VALUE f = eval_dense_lattice(DIFFUSE, DIFFUSE_CELLS, mu);
#if SPARSE
  f += eval_sparse_lattice(SPECULAR, OCCUPANCY, DISPLACEMENT, SPECULAR_CELLS, mu);
#endif
#if LOG_RELATIVE
  f = min((eval_prior(wi, wo) + PRIOR_OFFSET) * exp(min(f, VALUE(STEEPEST))) - PRIOR_OFFSET, VALUE(PRIOR_CEILING));
#endif
#if DAMPED
  f *= eval_damping(DAMPING, wi) * eval_damping(DAMPING, wo);
#endif
  return max(color(f), color(0.0));
}
