/* The lamps that a shading point sees: where they are, how large, and how bright. */

struct LampList {
  vector direction[MAX_LAMPS];      /* in the shading frame */
  float radius[MAX_LAMPS];          /* angular, of the lamp's disk */
  float light[MAX_LAMPS];           /* about what it adds to the irradiance of the point; only ratios matter */
  int count;
};

/* A lamp's direction from a point, the angular radius of its disk, and its irradiance at normal incidence. For a sun,
 * `lamp` is a direction and its size minus its angular radius; `extent` is (size, strength, unused). */
vector lamp_direction(vector lamp, vector extent, point at, output float radius, output float light)
{
  if (extent[0] < 0.0) {
    radius = -extent[0];
    light = extent[1];
    return normalize(lamp);
  }
  vector toward = lamp - at;
  float distance = max(length(toward), LEAST_DISTANCE);
  radius = distance > extent[0] ? asin(extent[0] / distance) : M_PI_2;
  light = extent[1] / (distance * distance);
  return toward / distance;
}

/* Append a lamp to the list if any part of it is above the horizon. */
void add_lamp(vector lamp, vector extent, point at, ShadingFrame frame, output LampList lamps)
{
  float radius, light;
  vector w = to_local(frame, lamp_direction(lamp, extent, at, radius, light));
  if (w[2] > -sin(radius) && length(frame.wo + w) > LEAST_HALF_VECTOR) {
    lamps.direction[lamps.count] = w;
    lamps.radius[lamps.count] = radius;
    lamps.light[lamps.count] = light * max(w[2], LEAST_LAMP_COSINE);
    lamps.count++;
  }
}

/* A cone of directions; its radius is an angle, and 0 stands for no cone. */
struct Cone {
  vector axis;
  float radius;
};

/* One of the large lamps, with a probability in proportion to its light. */
Cone sample_large_lamp(LampList lamps, point seed)
{
  Cone chosen;
  chosen.axis = 0.0;
  chosen.radius = 0.0;
  float light = 0.0;
  for (int i = 0; i < lamps.count; i++) {
    if (lamps.radius[i] >= MAX_HIDDEN_RADIUS) {
      light += lamps.light[i];
      if (random(seed, RANDOM_LARGE_LAMP + i) * light <= lamps.light[i]) {
        chosen.axis = lamps.direction[i];
        chosen.radius = min(lamps.radius[i], M_PI_2);
      }
    }
  }
  return chosen;
}

/* A direction within a cone, uniform in solid angle. */
vector sample_cone(Cone cone, point seed)
{
  float z = 1.0 - random(seed, RANDOM_CONE_HEIGHT) * (1.0 - cos(cone.radius));
  float r = sqrt(max(0.0, 1.0 - z * z));
  float azimuth = M_2PI * random(seed, RANDOM_CONE_AZIMUTH);
  vector u = perpendicular(cone.axis);
  return z * cone.axis + r * (cos(azimuth) * u + sin(azimuth) * cross(cone.axis, u));
}

/* The density, per solid angle, with which `sample_cone` returns a direction. */
float pdf_cone(Cone cone, vector w)
{
  return dot(w, cone.axis) >= cos(cone.radius) ? 1.0 / (M_2PI * (1.0 - cos(cone.radius))) : 0.0;
}
