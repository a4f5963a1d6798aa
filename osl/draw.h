/* Drawing an incident direction for a given outgoing one, from the table of fitter/draw_table.py.
 *
 * For each of DRAW_VIEWS outgoing angles the table holds the cumulated probabilities of DRAW_RINGS x DRAW_SECTORS
 * cells of equal area that divide half of the unit disk, onto which the hemisphere projects. A density on that disk is
 * a density per projected solid angle, so the cosine is already in it. */

/* The k-th random number of a shading point, in [0, 1): P is jittered by the pixel filter. */
float random(point seed, float k)
{
  float u = hashnoise(seed, k);
  return u;
}

/* Probability of a cell. */
float cell_probability(float table[], int view, int cell)
{
  int i = view * DRAW_CELLS + cell;
  return cell == 0 ? table[i] : table[i] - table[i - 1];
}

/* A unit vector in the frame where wo has azimuth 0, and the density with which it was drawn, 1 / projected sr. */
vector draw_direction(float table[], float theta_o, point seed, output float density)
{
  /* between two tabulated angles, draw from either */
  float at = clamp(theta_o * (2.0 * (DRAW_VIEWS - 1) / M_PI), 0.0, DRAW_VIEWS - 1.0);
  int view = min((int)at, DRAW_VIEWS - 2);
  float between = at - view;
  int drawn = random(seed, 1.0) < between ? view + 1 : view;

  float u = random(seed, 2.0);
  int low = 0;
  int high = DRAW_CELLS - 1;
  while (low < high) {
    int middle = (low + high) / 2;
    if (u < table[drawn * DRAW_CELLS + middle]) {
      high = middle;
    }
    else {
      low = middle + 1;
    }
  }
  density = (DRAW_CELLS / M_PI) *
            mix(cell_probability(table, view, low), cell_probability(table, view + 1, low), between);

  float r_squared = (low / DRAW_SECTORS + random(seed, 3.0)) / DRAW_RINGS;
  float azimuth = (low % DRAW_SECTORS + random(seed, 4.0)) * (M_PI / DRAW_SECTORS);
  float r = sqrt(r_squared);
  float side = random(seed, 5.0) < 0.5 ? -1.0 : 1.0;
  return vector(r * cos(azimuth), side * r * sin(azimuth), sqrt(max(0.0, 1.0 - r_squared)));
}
