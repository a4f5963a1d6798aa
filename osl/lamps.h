/* Lobes at lamps: where a lamp stands, and a phong_ramp that is flat over it. */

#define MAX_LAMPS 32
#define MAX_LOBES 4               /* of more lamps than these, every sample takes two at random */
#define SAMPLED_LOBES 2
#define SMALL_LAMP_RADIUS 0.005   /* radians, as the sun: the fit is taken for constant over a smaller lamp */
#define MAX_HIDDEN_RADIUS 0.06    /* 3.4 degrees: its lobe is all that is seen of a smaller lamp */
#define MAX_LOBE_RADIUS 0.6       /* a larger lamp has no lobe: the mixture is right in the mean over it */
#define MIN_LOBE_RADIUS 0.0122    /* 0.7 degrees, so that a lamp without a size has a lobe that floats can resolve */
#define LOBE_FLAT (1.0 / 7.0)     /* a lobe is flat where it has not fallen further than this */

/* The direction toward a lamp, the angular radius of its disk, and how bright it makes the point, facing it. A sun has
 * a direction for a position and minus its angular radius for a size; extent is (size, strength, unused). */
vector lamp_direction(vector lamp, vector extent, point at, output float radius, output float light)
{
  if (extent[0] < 0.0) {
    radius = -extent[0];
    light = extent[1];
    return normalize(lamp);
  }
  vector toward = lamp - at;
  float distance = max(length(toward), 1e-6);
  radius = distance > extent[0] ? asin(extent[0] / distance) : M_PI_2;
  light = extent[1] / (distance * distance);
  return toward / distance;
}

/* Append a lamp to the lists, in the frame of the surface, if any of it stands above the horizon. */
void note_lamp(vector lamp, vector extent, point at, vector x, vector y, vector z, vector wo, output vector toward[],
               output float radius[], output float light[], output int count)
{
  float r, e;
  vector w = lamp_direction(lamp, extent, at, r, e);
  vector l = vector(dot(w, x), dot(w, y), dot(w, z));
  if (l[2] > -sin(r) && length(wo + l) > 1e-3) {
    toward[count] = l;
    radius[count] = r;
    light[count] = e * max(l[2], 0.1);
    count++;
  }
}

/* cos(angle from the axis) ^ exponent falls to 3/7 at the lamp's edge. */
float lobe_exponent(float radius)
{
  return log(3.0 / 7.0) / log(cos(max(radius, MIN_LOBE_RADIUS)));
}

/* The ramp over c = cos ^ exponent that makes c ramp(c) flat from c = 1 down to 1/7: piecewise linear with knots at
 * j / 7, its mean between two knots, in proportion to solid angle, is 1 (from the axis outward,
 * knot[j] = 14 ln((j + 1) / j) - knot[j + 1]). */
void ramp_knots(output float knot[8])
{
  knot[7] = 1.0;
  for (int j = 6; j > 0; j--) {
    knot[j] = 14.0 * log((j + 1.0) / j) - knot[j + 1];
  }
  knot[0] = 0.0;
}

void flat_ramp(color top, output color ramp[8])
{
  float knot[8];
  ramp_knots(knot);
  for (int j = 0; j < 8; j++) {
    ramp[j] = knot[j] * top;
  }
}

/* cos ^ exponent in direction w. */
float lobe_fall(vector axis, float exponent, vector w)
{
  float cosine = dot(axis, w);
  return cosine <= 0.0 ? 0.0 : min(pow(cosine, exponent), 1.0);
}

/* What Cycles makes of the lobe where it has fallen to c, in direction w, relative to its value on the axis. */
float lobe_shape(vector axis, vector wo, vector w, float c)
{
  float knot[8];
  ramp_knots(knot);
  int j = min((int)(7.0 * c), 6);
  vector h = wo + axis;
  return c * mix(knot[j], knot[j + 1], 7.0 * c - j) * dot(h, w) / dot(h, axis);
}
