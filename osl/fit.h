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
#  define FIT_PARAMETERS float DIFFUSE[], float SPECULAR[], int KEYS[], int DISPLACEMENT[]
#  define FIT DIFFUSE, SPECULAR, KEYS, DISPLACEMENT
#else
#  define FIT_PARAMETERS float DIFFUSE[]
#  define FIT DIFFUSE
#endif

/* The fitted BRDF, 1/sr, and 0 where the fit undershoots; directions as in coordinates(). */
color eval_fit(FIT_PARAMETERS, vector wi, vector wo)
{
  vector mu = coordinates(wi, wo);
  VALUE f = eval_dense_lattice(DIFFUSE, DIFFUSE_CELLS, mu);
#if SPARSE
  f += eval_sparse_lattice(SPECULAR, KEYS, DISPLACEMENT, SPECULAR_CELLS, mu);
#endif
#if LOG_RELATIVE
  f = min((eval_prior(wi, wo) + PRIOR_OFFSET) * exp(min(f, VALUE(STEEPEST))) - PRIOR_OFFSET, VALUE(PRIOR_CEILING));
#endif
  return max(color(f), color(0.0));
}
