/* The tables of sampling_table.h for an anisotropic fit, over half vectors in the principal axes.
 *
 * They hold HALF_RINGS x HALF_SECTORS cells of half vectors about the normal, whose slopes have been divided by
 * PRINCIPAL_STRETCH along the first axis and multiplied by it along the second: evenly spaced in the square root of the
 * angle from the normal, up to the last one that is reached, and in azimuth. fitter/cycles/half_vector_grid.py describes
 * them. Within a cell, stretched half vectors are uniform in solid angle. */

#if ANISOTROPIC
#define CELLS (HALF_RINGS * HALF_SECTORS)
/* Entries of a view in MISSING: the unit of its values, and those. */
#define MISSING_ROW (CELLS * CHANNELS + 1)

/* The angle from the normal at which the last ring ends. */
float farthest_ring(vector wo)
{
  float largest = 0.5 * (M_PI_2 + acos(clamp(wo[2], 0.0, 1.0)));
  return atan2(PRINCIPAL_STRETCH * sin(largest), cos(largest));
}

/* The cosine at which a ring begins. */
float ring_cosine(float farthest, int ring)
{
  return cos(farthest * (ring * ring) / (HALF_RINGS * HALF_RINGS));
}

/* Where a direction is: in rings, and in sectors, which begin half a turn later for a view that is half a turn from
 * where it is stored. Returns the solid angle of directions over that of stretched half vectors. */
float table_place(int view, vector wo, vector w, output float x, output float y)
{
  vector h = normalize(wo + w);
  vector stretched = vector(h[0] / PRINCIPAL_STRETCH, h[1] * PRINCIPAL_STRETCH, h[2]);
  x = sqrt(atan2(hypot(stretched[0], stretched[1]), stretched[2]) / farthest_ring(wo)) * HALF_RINGS;
  y = (atan2(stretched[1], stretched[0]) / M_2PI + 0.5 * half_turned(view)) * HALF_SECTORS;
  if (y < 0.0) {
    y += HALF_SECTORS;
  }
  float size = length(stretched);
  return 4.0 * dot(wo, h) * size * size * size;
}

/* The density, per solid angle, with which `sample_table` returns a direction. */
float pdf_table(float table[], int view, vector wo, vector w)
{
  float x, y;
  float size = table_place(view, wo, w, x, y);
  float farthest = farthest_ring(wo);
  int ring = min((int)x, HALF_RINGS - 1);
  int first = stored_view(view) * CELLS;
  int i = first + ring * HALF_SECTORS + min((int)y, HALF_SECTORS - 1);
  float probability = i == first ? table[i] : table[i] - table[i - 1];
  return probability / PROBABILITY_UNITS * HALF_SECTORS /
         (M_2PI * (ring_cosine(farthest, ring) - ring_cosine(farthest, ring + 1)) * size);
}

/* A unit vector in the shading frame. It may be below the horizon. */
vector sample_table(float table[], int view, vector wo, point seed)
{
  float u = PROBABILITY_UNITS * random(seed, RANDOM_CELL);
  int first = stored_view(view) * CELLS;
  int low = 0;
  int high = CELLS - 1;
  while (low < high) {
    int middle = (low + high) / 2;
    if (u < table[first + middle]) {
      high = middle;
    }
    else {
      low = middle + 1;
    }
  }
  int ring = low / HALF_SECTORS;
  float farthest = farthest_ring(wo);
  float z = mix(ring_cosine(farthest, ring), ring_cosine(farthest, ring + 1), random(seed, RANDOM_RING));
  float turn = M_2PI * ((low % HALF_SECTORS + random(seed, RANDOM_SECTOR)) / HALF_SECTORS - 0.5 * half_turned(view));
  float r = sqrt(max(0.0, 1.0 - z * z));
  vector h = normalize(vector(r * cos(turn) * PRINCIPAL_STRETCH, r * sin(turn) / PRINCIPAL_STRETCH, z));
  return 2.0 * dot(wo, h) * h - wo;
}

#if CHANNELS == 3
#  define MISSING_CELL(i) color(MISSING[first + 3 * (i) + 1], MISSING[first + 3 * (i) + 2], MISSING[first + 3 * (i) + 3])
#else
#  define MISSING_CELL(i) MISSING[first + (i) + 1]
#endif

/* About what the fit has beyond the mixture, times cos theta_i: bilinear between the middles of cells. */
color eval_missing(float MISSING[], MixtureView view, vector w)
{
  float x, y;
  table_place(view.view, view.wo, w, x, y);
  x = clamp(x - 0.5, 0.0, HALF_RINGS - 1.0);
  y -= 0.5;
  int ring = min((int)x, HALF_RINGS - 2);
  int before = (int)floor(y);
  float s = x - ring;
  float t = y - before;
  int sector = (before + HALF_SECTORS) % HALF_SECTORS;
  int next = (before + 1) % HALF_SECTORS;
  int first = stored_view(view.view) * MISSING_ROW;
  int i = ring * HALF_SECTORS;
  MIXTURE_VALUE inner = (1.0 - t) * MISSING_CELL(i + sector) + t * MISSING_CELL(i + next);
  i += HALF_SECTORS;
  MIXTURE_VALUE outer = (1.0 - t) * MISSING_CELL(i + sector) + t * MISSING_CELL(i + next);
  return color(MISSING[first] * mix(inner, outer, s));
}
#endif
