/* Sampling incident directions for a tabulated view, from a table that fitter/cycles/sampling_table.py makes.
 *
 * For each view the table holds the cumulative probabilities of RINGS x SECTORS cells of half the hemisphere, evenly
 * spaced in s = sqrt(1 - cos theta_i) and in t = (1 - azimuth / pi)^(2/3). Within a cell, directions are uniform in
 * solid angle. */

#define CELLS (RINGS * SECTORS)

/* The edge at which a sector begins, as a share of pi, counted from the mirror direction. */
float sector_edge(float sector)
{
  float t = sector / SECTORS;
  return t * sqrt(t);
}

/* The cell of a direction. */
int table_cell(vector w)
{
  int ring = min((int)(sqrt(max(0.0, 1.0 - w[2])) * RINGS), RINGS - 1);
  float away = fabs(atan2(w[1], -w[0])) / M_PI;
  int sector = min((int)(pow(away, 2.0 / 3.0) * SECTORS), SECTORS - 1);
  return ring * SECTORS + sector;
}

/* The density, per solid angle, with which `sample_table` returns a direction. */
float pdf_table(float table[], int view, vector w)
{
  int cell = table_cell(w);
  int i = view * CELLS + cell;
  float probability = cell == 0 ? table[i] : table[i] - table[i - 1];
  int ring = cell / SECTORS;
  int sector = cell % SECTORS;
  float width = sector_edge(sector + 1.0) - sector_edge(sector);
  return probability * (RINGS * RINGS / M_2PI) / ((2 * ring + 1) * width);
}

/* A unit vector in the shading frame. */
vector sample_table(float table[], int view, point seed)
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
  float s_squared = (ring * ring + (2 * ring + 1) * random(seed, RANDOM_RING)) / (RINGS * RINGS);
  int sector = low % SECTORS;
  float away = M_PI * mix(sector_edge(sector), sector_edge(sector + 1.0), random(seed, RANDOM_SECTOR));
  float side = random(seed, RANDOM_SIDE) < 0.5 ? -1.0 : 1.0;
  float z = 1.0 - s_squared;
  float r = sqrt(max(0.0, 1.0 - z * z));
  return vector(-r * cos(away), side * r * sin(away), z);
}
