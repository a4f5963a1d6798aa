/* The lamps that a shading point sees: where they are, how large, and how bright. */

#include "mixture.h"
#include "random.h"
#include "shading_frame.h"

struct LampList {
  vector direction[MAX_LAMPS];      /* in the shading frame */
  float radius[MAX_LAMPS];          /* angular, of the disk about the lamp */
  float core[MAX_LAMPS];            /* the radius of a disk of the lamp's area, in that */
  float light[MAX_LAMPS];           /* about what it adds to the irradiance of the point; only ratios matter */
  int count;
};

/* A lamp's direction from a point, the angular radius of its disk, and its irradiance at normal incidence. For a sun,
 * `lamp` is a direction and its size minus its angular radius; `extent` is (size, strength, core). */
vector lamp_direction(vector lamp, vector extent, point at, output float radius, output float light)
{
  if (extent[0] < 0.0) {
    radius = -extent[0];
    light = extent[1];
    return normalize(lamp);
  }
  vector toward = lamp - at;
  float distance = length(toward);
  radius = asin(extent[0] / distance);
  light = extent[1] / (distance * distance);
  return toward / distance;
}

/* Append a lamp to the list if it shines and any part of it is above the horizon. One that does not may be dark in a
 * frame, or not there: another scene may have more lamps, and an object that points to no carrier reads zeros. */
void add_lamp(vector lamp, vector extent, point at, ShadingFrame frame, output LampList lamps)
{
  float radius, light;
  vector w = to_local(frame, lamp_direction(lamp, extent, at, radius, light));
  if (light > 0.0 && w[2] > -sin(radius)) {
    int number = clamp(lamps.count, 0, MAX_LAMPS - 1);
    lamps.direction[number] = w;
    lamps.radius[number] = radius;
    lamps.core[number] = extent[2];
    lamps.light[number] = light * max(w[2], LEAST_LAMP_COSINE);
    lamps.count = number + 1;
  }
}

/* The angular radius up to which the lobe at a lamp is flat. */
float lobe_radius(float radius)
{
  return clamp(radius + LOBE_MARGIN, MIN_LOBE_RADIUS, MAX_LOBE_RADIUS);
}

/* The exponent with which cos(angle from the axis) ^ exponent falls there to the edge knot. */
float lobe_exponent(float radius)
{
  return log(LOBE_EDGE_KNOT / (KNOTS - 1.0)) / log(cos(lobe_radius(radius)));
}

/* Up to how many lamps each have a lobe; of more, some are taken at random. */
int max_light_lobes(int closure_limited)
{
  return closure_limited ? CLOSURE_LIMITED_LOBES : MAX_LOBES;
}

/* The radius of the largest lamp, and 0 if all are small. */
float largest_radius(LampList lamps)
{
  float widest = 0.0;
  for (int i = 0; i < lamps.count; i++) {
    widest = max(widest, lamps.radius[i]);
  }
  return widest < SMALL_LAMP_RADIUS ? 0.0 : widest;
}

/* How many lamps of equal light would differ as these do: 1 where one of them has nearly all. */
float lamps_alike(LampList lamps)
{
  float light = 0.0;
  float squared = 0.0;
  for (int i = 0; i < lamps.count; i++) {
    light += lamps.light[i];
    squared += lamps.light[i] * lamps.light[i];
  }
  return lamps.count > 1 ? light * light / squared : 1.0;
}

/* One of the lamps that are not small, of which there must be one, with a probability in proportion to its light. */
int sample_lamp(LampList lamps, point seed)
{
  int chosen = 0;
  float light = 0.0;
  for (int i = 0; i < lamps.count; i++) {
    if (lamps.radius[i] >= SMALL_LAMP_RADIUS) {
      light += lamps.light[i];
      if (random(seed, RANDOM_LAMP + i) * light <= lamps.light[i]) {
        chosen = i;
      }
    }
  }
  return chosen;
}

/* The fraction of a lamp's disk above the horizon, where the lamp is not small and a direction meets it or the reach of
 * its lobe; else 0. Also the solid angle of its disk. */
float visible_lamp_fraction(LampList lamps, vector w, output float solid_angle)
{
  float above = 0.0;
  solid_angle = M_2PI;
  for (int i = 0; i < lamps.count; i++) {
    float radius = lamps.radius[i];
    if (radius >= SMALL_LAMP_RADIUS &&
        dot(w, lamps.direction[i]) > cos(LOBE_REACH * max(lobe_radius(radius), radius))) {
      above = max(above, clamp(0.5 + 0.5 * lamps.direction[i][2] / sin(radius), 0.0, 1.0));
      solid_angle = min(solid_angle, M_2PI * (1.0 - cos(radius)));
    }
  }
  return above;
}

/* A direction about a lamp, evenly in the cone where its lobe is flat. It may be below the horizon. */
vector sample_cone(vector axis, float radius, point seed)
{
  float z = 1.0 - random(seed, RANDOM_CONE_HEIGHT) * (1.0 - cos(lobe_radius(radius)));
  return spherical_direction(axis, z, M_2PI * random(seed, RANDOM_CONE_AZIMUTH));
}

/* The pdf, per solid angle, of a direction from `sample_cone` about a lamp from `sample_lamp`. */
float pdf_lamps(LampList lamps, vector w)
{
  float pdf = 0.0;
  float light = 0.0;
  for (int i = 0; i < lamps.count; i++) {
    if (lamps.radius[i] >= SMALL_LAMP_RADIUS) {
      light += lamps.light[i];
      float cosine = cos(lobe_radius(lamps.radius[i]));
      if (dot(w, lamps.direction[i]) > cosine) {
        pdf += lamps.light[i] / (M_2PI * (1.0 - cosine));
      }
    }
  }
  return pdf / light;
}
