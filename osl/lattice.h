/* Cubic B-splines over the dense and the sparse control lattice: Kameya and Lewis 2002, equations 5 to 7.
 *
 * fitter/lattice/dense.py describes the boxes of control points. Cells are counted from the middle of the cube, where
 * single precision is finest. */

/* Uniform cubic B-spline basis. */
void bspline_basis(float s, output float w[4])
{
  float t = 1.0 - s;
  w[0] = t * t * t / 6.0;
  w[1] = (4.0 - 3.0 * s * s * (2.0 - s)) / 6.0;
  w[2] = (4.0 - 3.0 * t * t * (2.0 - t)) / 6.0;
  w[3] = s * s * s / 6.0;
}

/* The cell that holds coordinate mu, counted from the middle cell, and the basis there; mu = 1 is in the last cell. */
int locate_cell(float mu, int cells, output float w[4])
{
  int half = cells / 2;
  float u = mu * (0.5 * cells) + (0.5 * cells - half);
  int cell = clamp((int)floor(u), -half, cells - 1 - half);
  bspline_basis(u - cell, w);
  return cell;
}

/* Control points along kappa_o and lambda_o. */
#define ROWS(cells) ((cells) + 3)
#define COLUMNS(cells) ((cells) - (cells) / 2 + 3)

/* The index of the first of the 4 x 4 x 4 control points that mu reads, and their weights along each axis. */
int first_tap(vector mu, int cells, output float wa[4], output float wb[4], output float wc[4])
{
  int a = max(locate_cell(mu[0], cells, wa), 0);
  int b = locate_cell(mu[1], cells, wb) + cells / 2;
  int c = max(locate_cell(mu[2], cells, wc), 0);
  return (a * ROWS(cells) + b) * COLUMNS(cells) + c;
}

VALUE eval_dense_lattice(float points[], int cells, vector mu)
{
  float wa[4], wb[4], wc[4];
  int tap = first_tap(mu, cells, wa, wb, wc);
  VALUE total = 0.0;
  for (int i = 0; i < 4; i++) {
    for (int j = 0; j < 4; j++) {
      int at = tap + (i * ROWS(cells) + j) * COLUMNS(cells);
      total += wa[i] * wb[j] *
               (wc[0] * READ(points, at) + wc[1] * READ(points, at + 1) + wc[2] * READ(points, at + 2) +
                wc[3] * READ(points, at + 3));
    }
  }
  return total;
}

#if SPARSE
VALUE eval_sparse_lattice(float points[], int occupancy[], int displacement[], int cells, vector mu)
{
  float wa[4], wb[4], wc[4];
  int tap = first_tap(mu, cells, wa, wb, wc);
  VALUE total = 0.0;
  for (int i = 0; i < 4; i++) {
    for (int j = 0; j < 4; j++) {
      int key = tap + (i * ROWS(cells) + j) * COLUMNS(cells);
      int stored = stored_keys(occupancy, key);
      if (stored != 0) {
        float w = wa[i] * wb[j];
        for (int k = 0; k < ROW_TAPS; k++) {
          if (stored & (1 << k)) {
            total += w * wc[k] * READ(points, find_slot(displacement, key + k));
          }
        }
      }
    }
  }
  return total;
}
#endif
