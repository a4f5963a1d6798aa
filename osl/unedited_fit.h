/* The fitted BRDF before edits: a bi-level B-spline, and its transform. The spline is the BRDF itself, or with
 * LOG_RELATIVE the logarithm of the BRDF relative to a prior; see fitter/model/transform.py. */

#include "values.h"
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
#if WIDENED
#  define BALANCE_PARAMETERS , float BALANCE[]
#  define BALANCE_TABLES , BALANCE
#else
#  define BALANCE_PARAMETERS
#  define BALANCE_TABLES
#endif
#if COATED
#  define COAT_TRANSMITTANCE_PARAMETERS , float COAT_TRANSMITTANCE[]
#  define COAT_TRANSMITTANCE_TABLES , COAT_TRANSMITTANCE
#else
#  define COAT_TRANSMITTANCE_PARAMETERS
#  define COAT_TRANSMITTANCE_TABLES
#endif
#define FIT_PARAMETERS \
  float DIFFUSE[] SPARSE_PARAMETERS DAMPING_PARAMETERS BALANCE_PARAMETERS COAT_TRANSMITTANCE_PARAMETERS
#define FIT DIFFUSE SPARSE_TABLES DAMPING_TABLES BALANCE_TABLES COAT_TRANSMITTANCE_TABLES

float largest(color c)
{
  return max(max(c[0], c[1]), c[2]);
}

#if DAMPED || WIDENED || COATED
/* A factor of one polar angle: a cubic B-spline of the projected radius. */
VALUE eval_factor(float points[], vector w)
{
  float at = length(vector(w[0], w[1], 0.0)) / (1.0 + 2.0 * w[2]) * (DAMPING_KNOTS - 1);
  int knot = min((int)at, DAMPING_KNOTS - 2);
  int before = abs(knot - 1);
  int behind = min(knot + 2, DAMPING_KNOTS - 1);
  float b[4];
  bspline_basis(at - knot, b);
  return b[0] * READ(points, before) + b[1] * READ(points, knot) + b[2] * READ(points, knot + 1) +
         b[3] * READ(points, behind);
}
#endif

/* max(1, x), twice differentiable: the 16-norm of both. */
float smooth_max_one(float x)
{
  float larger = max(x, 1.0);
  float ratio = min(x, 1.0) / larger;
  if (ratio < NEGLIGIBLE_RATIO) {
    return larger;
  }
  ratio *= ratio;
  ratio *= ratio;
  ratio *= ratio;
  return larger * sqrt(sqrt(sqrt(sqrt(1.0 + ratio * ratio))));
}

/* The fit as measured, 1/sr, and 0 where it undershoots; directions as in coordinates(). */
VALUE eval_measured(FIT_PARAMETERS, vector wi, vector wo)
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
  f = (eval_prior(wi, wo) + PRIOR_OFFSET) * exp(min(f, VALUE(LARGEST_EXPONENT))) - PRIOR_OFFSET;
  f /= smooth_max_one(largest(color(f / VALUE(PRIOR_CEILING))));
#  if DESATURATED
  f += RESATURATION * (f - (f[0] + f[1] + f[2]) / 3.0);
#  endif
#endif
#if DAMPED
  f *= eval_factor(DAMPING, wi) * eval_factor(DAMPING, wo);
#endif
  return max(f, VALUE(0.0));
}
