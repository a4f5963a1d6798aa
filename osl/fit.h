/* The fitted BRDF with its edit. */

#include "unedited_fit.h"
#include "edit.h"

/* The edited BRDF, 1/sr; directions as in coordinates(). */
color eval_fit(FIT_PARAMETERS, vector wi, vector wo)
{
#if EDITED
  return eval_edited_fit(FIT, wi, wo);
#else
  return color(eval_measured(FIT, wi, wo));
#endif
}
