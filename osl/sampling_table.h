/* Drawing an incident direction for a given view, from the table of fitter/draw_table.py.
 *
 * For each view the table holds the cumulated probabilities of DRAW_RINGS x DRAW_SECTORS cells of half the hemisphere,
 * evenly spaced in s = sqrt(1 - cos theta_i) and in t = (1 - azimuth / pi)^(2/3); within a cell directions are even in
 * solid angle. */

/* The k-th random number of a shading point, in [0, 1): P is jittered by the pixel filter. */
float random(point seed, float k)
{
  float u = (float)hashnoise(seed, k);
  return u;
}

/* Where sectors begin, as a share of pi away from the mirror direction. */
float sector_edge(float sector)
{
  float t = sector / DRAW_SECTORS;
  return t * sqrt(t);
}

/* The density per solid angle with which `draw_direction` draws from a cell. */
float cell_density(float table[], int view, int cell)
{
  int i = view * DRAW_CELLS + cell;
  float probability = cell == 0 ? table[i] : table[i] - table[i - 1];
  int ring = cell / DRAW_SECTORS;
  int sector = cell % DRAW_SECTORS;
  float wide = sector_edge(sector + 1.0) - sector_edge(sector);
  return probability * (DRAW_RINGS * DRAW_RINGS / M_2PI) / ((2 * ring + 1) * wide);
}

/* The cell that a direction lies in. */
int cell_of(vector w)
{
  int ring = min((int)(sqrt(max(0.0, 1.0 - w[2])) * DRAW_RINGS), DRAW_RINGS - 1);
  float away = fabs(atan2(w[1], -w[0])) / M_PI;
  int sector = min((int)(pow(away, 2.0 / 3.0) * DRAW_SECTORS), DRAW_SECTORS - 1);
  return ring * DRAW_SECTORS + sector;
}

/* A unit vector in the frame where wo has azimuth 0. */
vector draw_direction(float table[], int view, point seed)
{
  float u = random(seed, 2.0);
  int low = 0;
  int high = DRAW_CELLS - 1;
  while (low < high) {
    int middle = (low + high) / 2;
    if (u < table[view * DRAW_CELLS + middle]) {
      high = middle;
    }
    else {
      low = middle + 1;
    }
  }
  int ring = low / DRAW_SECTORS;
  float s_squared = (ring * ring + (2 * ring + 1) * random(seed, 3.0)) / (DRAW_RINGS * DRAW_RINGS);
  int sector = low % DRAW_SECTORS;
  float away = M_PI * mix(sector_edge(sector), sector_edge(sector + 1.0), random(seed, 4.0));
  float side = random(seed, 5.0) < 0.5 ? -1.0 : 1.0;
  float z = 1.0 - s_squared;
  float r = sqrt(max(0.0, 1.0 - z * z));
  return vector(-r * cos(away), side * r * sin(away), z);
}

/* A direction toward a cone's disk, even in solid angle. */
vector draw_in_cone(vector axis, float radius, point seed)
{
  float z = 1.0 - random(seed, 8.0) * (1.0 - cos(radius));
  float r = sqrt(max(0.0, 1.0 - z * z));
  float azimuth = M_2PI * random(seed, 9.0);
  vector u = normalize(cross(axis, fabs(axis[2]) < 0.9 ? vector(0.0, 0.0, 1.0) : vector(1.0, 0.0, 0.0)));
  return z * axis + r * (cos(azimuth) * u + sin(azimuth) * cross(axis, u));
}
