/* Tables over incident directions for a tabulated view: two to sample them, which fitter/cycles/sampling_table.py
 * makes, and one of what the mixture misses. Those of an anisotropic fit are in half_vector_table.h.
 *
 * For each view the first hold the cumulative probabilities of RINGS x SECTORS cells about the mirror direction of wo,
 * evenly spaced in the square root of the angle from it, up to the horizon beyond the viewer, and in the turn about it.
 * Within a cell, directions are uniform in solid angle. */

#if !ANISOTROPIC
#define CELLS (RINGS * SECTORS)

/* The angle from the normal to the direction about which the cells lie. */
float table_mirror(vector wo)
{
  return min(acos(clamp(wo[2], 0.0, 1.0)), STEEPEST_AXIS);
}

/* The cosine at which a ring begins; `farthest` is the angle at which the last one ends. */
float ring_cosine(float farthest, int ring)
{
  return cos(farthest * (ring * ring) / (RINGS * RINGS));
}

/* Where a direction is: its distance from the mirror direction in rings, and its turn about it in sectors. */
void table_place(vector wo, vector w, output float x, output float y)
{
  float mirror = table_mirror(wo);
  vector axis = mirror_side(mirror);
  vector onward = mirror_side(mirror + M_PI_2);
  float delta = 2.0 * asin(clamp(0.5 * length(w - axis), 0.0, 1.0));
  x = sqrt(delta / (M_PI_2 + mirror)) * RINGS;
  y = fabs(atan2(w[1], dot(w, onward))) / M_PI * SECTORS;
}

/* The cell of a direction, among those of all views. */
int table_cell(int view, vector wo, vector w)
{
  float x, y;
  table_place(wo, w, x, y);
  return view * CELLS + min((int)x, RINGS - 1) * SECTORS + min((int)y, SECTORS - 1);
}

/* The density, per solid angle, with which `sample_table` returns a direction. */
float pdf_table(float table[], int view, vector wo, vector w)
{
  float farthest = M_PI_2 + table_mirror(wo);
  int i = table_cell(view, wo, w);
  int ring = (i - view * CELLS) / SECTORS;
  float probability = i == view * CELLS ? table[i] : table[i] - table[i - 1];
  return probability * SECTORS / (M_2PI * (ring_cosine(farthest, ring) - ring_cosine(farthest, ring + 1)));
}

/* A unit vector in the shading frame. It may be below the horizon. */
vector sample_table(float table[], int view, vector wo, point seed)
{
  float u = random(seed, RANDOM_CELL);
  int low = 0;
  int high = CELLS - 1;
  while (low < high) {
    int middle = (low + high) / 2;
    if (u < table[view * CELLS + middle]) {
      high = middle;
    }
    else {
      low = middle + 1;
    }
  }
  int ring = low / SECTORS;
  int sector = low % SECTORS;
  float mirror = table_mirror(wo);
  float farthest = M_PI_2 + mirror;
  float z = mix(ring_cosine(farthest, ring), ring_cosine(farthest, ring + 1), random(seed, RANDOM_RING));
  float turn = M_PI * (sector + random(seed, RANDOM_SECTOR)) / SECTORS;
  float side = random(seed, RANDOM_SIDE) < 0.5 ? -1.0 : 1.0;
  float r = sqrt(max(0.0, 1.0 - z * z));
  vector axis = mirror_side(mirror);
  vector onward = mirror_side(mirror + M_PI_2);
  return z * axis + r * (cos(turn) * onward + vector(0.0, side * sin(turn), 0.0));
}
#endif

#if CHANNELS == 3
#  define MISSING_READ(i) color(MISSING[3 * (i)], MISSING[3 * (i) + 1], MISSING[3 * (i) + 2])
#else
#  define MISSING_READ(i) MISSING[i]
#endif

#if !ANISOTROPIC
/* About what the fit has beyond the mixture, times cos theta_i: bilinear between the middles of cells. */
color eval_missing(float MISSING[], MixtureView view, vector w)
{
  float x, y;
  table_place(view.wo, w, x, y);
  x = clamp(x - 0.5, 0.0, RINGS - 1.0);
  y = clamp(y - 0.5, 0.0, SECTORS - 1.0);
  int ring = min((int)x, RINGS - 2);
  int sector = min((int)y, SECTORS - 2);
  float s = x - ring;
  float t = y - sector;
  int i = view.view * CELLS + ring * SECTORS + sector;
  return color((1.0 - s) * ((1.0 - t) * MISSING_READ(i) + t * MISSING_READ(i + 1)) +
               s * ((1.0 - t) * MISSING_READ(i + SECTORS) + t * MISSING_READ(i + SECTORS + 1)));
}
#endif
