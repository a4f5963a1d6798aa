/* The tabulated views of an anisotropic fit, and its microfacet lobes; fitter/cycles/anisotropic_mixture.py makes them.
 *
 * A view is a direction: the normal, or one of POLAR_VIEWS - 1 polar angles and of AZIMUTHS azimuths in the principal
 * axes of the surface. Where half a turn of the surface changes nothing, there are twice as many azimuths as are stored,
 * and the second half are those turned by it. */

#if ANISOTROPIC
#if HALF_TURN
#  define AZIMUTHS (2 * AZIMUTH_VIEWS)
#else
#  define AZIMUTHS AZIMUTH_VIEWS
#endif

/* Where a view is stored. */
int stored_view(int view)
{
#if HALF_TURN
  return view == 0 ? 0 : 1 + (view - 1) / AZIMUTHS * AZIMUTH_VIEWS + (view - 1) % AZIMUTH_VIEWS;
#else
  return view;
#endif
}

/* Whether a view is half a turn from where it is stored. */
int half_turned(int view)
{
#if HALF_TURN
  return view > 0 && (view - 1) % AZIMUTHS >= AZIMUTH_VIEWS;
#else
  return 0;
#endif
}

/* Numbers of a lobe besides those of `shader_constants`: the roughness along the second principal axis, and what its
 * normal leans along both. */
#define MORE_NUMBERS 3

/* A number of a view; `i` counts those of `shader_constants`, and then more of each lobe. */
float view_number(float MIXTURE_NUMBERS[], int view, int i)
{
  return MIXTURE_NUMBERS[stored_view(view) * (NUMBERS + MORE_NUMBERS * LOBES) + i];
}

/* The direction at an angle theta from the normal, in the plane of that and the viewer, opposite to it. A viewer on the
 * normal has no such plane: OSL normalises 0 to 0. */
vector mirror_side(vector wo, float theta)
{
  return cos(theta) * vector(0.0, 0.0, 1.0) - sin(theta) * normalize(vector(wo[0], wo[1], 0.0));
}

/* The mixture of a tabulated view, seen from wo, whose polar angle is theta_o. */
void mixture_view(float MIXTURE_NUMBERS[], int view, float theta_o, vector wo, output MixtureView found)
{
  int stored = stored_view(view);
  int number = stored * (NUMBERS + MORE_NUMBERS * LOBES);
  found.view = view;
  found.row = stored * ROW;
  found.wo = wo;
  found.scale = 1.0;
  for (int k = 0; k < LOBES; k++) {
    int first = number + LOBE_NUMBERS * k;
    int more = number + NUMBERS + MORE_NUMBERS * k;
    found.kind[k] = (int)MIXTURE_NUMBERS[first];
    found.shape[k] = MIXTURE_NUMBERS[first + 1];
    found.across[k] = MIXTURE_NUMBERS[more];
    float angle = MIXTURE_NUMBERS[first + 2];
    if (found.kind[k] == PHONG) {
      found.axis[k] = mirror_side(wo, min(theta_o + angle, STEEPEST_AXIS));
      found.half[k] = normalize(wo + found.axis[k]);
    }
    else {
      vector lean = vector(MIXTURE_NUMBERS[more + 1], MIXTURE_NUMBERS[more + 2], 0.0);
      found.axis[k] = normalize(mirror_side(wo, angle) + (half_turned(view) ? -lean : lean));
      found.half[k] = found.axis[k];
    }
  }
}

/* One of the two tabulated azimuths next to that of wo, by a random number. */
int nearby_azimuth(vector wo, float u)
{
  int azimuth = (int)floor(atan2(wo[1], wo[0]) / M_2PI * AZIMUTHS + u);
  return azimuth < 0 ? azimuth + AZIMUTHS : azimuth % AZIMUTHS;
}

/* One of the four tabulated views around wo. */
void sample_view(float MIXTURE_NUMBERS[], vector wo, point seed, output MixtureView found)
{
  float theta_o = acos(clamp(wo[2], 0.0, 1.0));
  int view = nearby_view(theta_o, random(seed, RANDOM_VIEW));
  if (view > 0) {
    view = 1 + (view - 1) * AZIMUTHS + nearby_azimuth(wo, random(seed, RANDOM_AZIMUTH));
  }
  mixture_view(MIXTURE_NUMBERS, view, theta_o, wo, found);
}

/* GGX reflection of two widths about a normal without a Fresnel factor, times the cosine of that normal and wi. The
 * first axis of the frame, projected, is that of the first width. */
float eval_ggx(float along, float across, vector about, vector wo, vector wi)
{
  float cos_o = dot(about, wo);
  float cos_i = dot(about, wi);
  float value = 0.0;
  if (cos_o > HORIZON && cos_i > HORIZON) {
    vector second = normalize(vector(0.0, about[2], -about[1]));
    vector first = cross(second, about);
    vector h = wo + wi;
    vector stretched = vector(dot(first, h) / along, dot(second, h) / across, dot(about, h));
    float bottom = dot(stretched, stretched) / dot(h, h);
    vector scaled_o = vector(along * dot(first, wo), across * dot(second, wo), cos_o);
    vector scaled_i = vector(along * dot(first, wi), across * dot(second, wi), cos_i);
    float masking_o = length(scaled_o) / cos_o;
    float masking_i = length(scaled_i) / cos_i;
    value = 1.0 / (2.0 * M_PI * along * across * bottom * bottom * cos_o * (masking_o + masking_i));
  }
  return value;
}
#endif
