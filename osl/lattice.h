/* Cubic B-splines over the dense and the sparse control lattice: Kameya and Lewis 2002, equations 5 to 7.
 *
 * fitter/lattice/dense.py describes the boxes of control points. Cells are counted from the middle of the cube, where
 * single precision is finest. */

#include "perfect_hash.h"
#include "values.h"

/* Uniform cubic B-spline basis. */
void bspline_basis(float s, output float w[4])
{
  float t = 1.0 - s;
  float sixth = 1.0 / 6.0;
  w[0] = sixth * t * t * t;
  w[1] = 4.0 * sixth - 0.5 * s * s * (2.0 - s);
  w[2] = 4.0 * sixth - 0.5 * t * t * (2.0 - t);
  w[3] = sixth * s * s * s;
}

/* The cell that holds coordinate mu, counted from the middle cell, and the basis there; mu = 1 is in the last cell. The
 * first one is 0 where the coordinate is not negative. */
int locate_cell(float mu, int cells, int first, output float w[4])
{
  int half = cells / 2;
  float u = mu * (0.5 * cells) + (0.5 * cells - half);
  int cell = clamp((int)floor(u), first, cells - 1 - half);
  bspline_basis(u - cell, w);
  return cell;
}

/* Control points along an axis of which all are stored, and along one of which half is, since the coordinate is not
 * negative. */
#define ROWS(cells) ((cells) + 3)
#define COLUMNS(cells) ((cells) - (cells) / 2 + 3)

#if AXES == 4
#  define COORDINATES float mu[4]
/* Control points from one block of 4 x 4 x 4 to the next along the first of four axes. */
#  define BLOCK(cells) (ROWS(cells) * ROWS(cells) * COLUMNS(cells))

/* The index of the first of the four blocks that mu reads, and their weights along each axis. */
int first_tap(COORDINATES, int cells, output float w[4], output float wa[4], output float wb[4], output float wc[4])
{
  int block = locate_cell(mu[0], cells, -(cells / 2), w) + cells / 2;
  int a = locate_cell(mu[1], cells, -(cells / 2), wa) + cells / 2;
  int b = locate_cell(mu[2], cells, -(cells / 2), wb) + cells / 2;
  int c = locate_cell(mu[3], cells, 0, wc);
  return block * BLOCK(cells) + (a * ROWS(cells) + b) * COLUMNS(cells) + c;
}
#else
#  define COORDINATES vector mu

/* The index of the first of the 4 x 4 x 4 control points that mu reads, and their weights along each axis. */
int first_tap(COORDINATES, int cells, output float wa[4], output float wb[4], output float wc[4])
{
  int a = locate_cell(mu[0], cells, 0, wa);
  int b = locate_cell(mu[1], cells, -(cells / 2), wb) + cells / 2;
  int c = locate_cell(mu[2], cells, 0, wc);
  return (a * ROWS(cells) + b) * COLUMNS(cells) + c;
}
#endif

/* The weighted sum of a block of 4 x 4 x 4 control points. */
VALUE dense_block(float points[], int cells, int tap, float wa[4], float wb[4], float wc[4])
{
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

VALUE eval_dense_lattice(float points[], int cells, COORDINATES)
{
  float wa[4], wb[4], wc[4];
#if AXES == 4
  float w[4];
  int tap = first_tap(mu, cells, w, wa, wb, wc);
  VALUE total = 0.0;
  for (int i = 0; i < 4; i++) {
    total += w[i] * dense_block(points, cells, tap + i * BLOCK(cells), wa, wb, wc);
  }
  return total;
#else
  int tap = first_tap(mu, cells, wa, wb, wc);
  return dense_block(points, cells, tap, wa, wb, wc);
#endif
}

#if SPARSE
VALUE sparse_block(float points[], int occupancy[], int displacement[], int cells, int tap, float wa[4], float wb[4],
                   float wc[4])
{
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

VALUE eval_sparse_lattice(float points[], int occupancy[], int displacement[], int cells, COORDINATES)
{
  float wa[4], wb[4], wc[4];
#if AXES == 4
  float w[4];
  int tap = first_tap(mu, cells, w, wa, wb, wc);
  VALUE total = 0.0;
  for (int i = 0; i < 4; i++) {
    total += w[i] * sparse_block(points, occupancy, displacement, cells, tap + i * BLOCK(cells), wa, wb, wc);
  }
  return total;
#else
  int tap = first_tap(mu, cells, wa, wb, wc);
  return sparse_block(points, occupancy, displacement, cells, tap, wa, wb, wc);
#endif
}
#endif
