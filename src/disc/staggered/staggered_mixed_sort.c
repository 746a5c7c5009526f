/// Who is relaxed how on a level of the mixed form: interior faces and cells by red and black, boxes by color.
#include "disc/staggered/staggered_mixed.h"
#include "disc/staggered/staggered_slot.h"

#include <math.h>
#include <string.h>

#define FULL (1 - 1e-6)
#define LOOSE 1e-4
#define SAME 0.05 // relative difference of stiffness that the interior tolerates within two cells

/// A cell of which nothing is cut or held.
static bool is_whole(const LthMixedLevel *l, LitheIndex c) {
  if (!(l->volume[c] >= FULL)) return false;
  for (int a = 0; a < l->dim; a++)
    if (!(l->flags[c] & l->flags[l->next[2 * a + 1][c]] & LTH_MIXED_FREE << a)) return false;
  return true;
}

/// low, high (n + 1): least and largest stiffness within one cell along each axis; low = 0 where something is not
/// whole.
static void spread(const LthMixedLevel *l, int threads, double *low, double *high,
                   double *scratch) {
  const size_t bytes = sizeof *low * (size_t)(l->n + 1);
  for (int a = 0; a < l->dim; a++) {
    memcpy(scratch, low, bytes);
#pragma omp parallel for schedule(static) num_threads(threads)
    for (LitheIndex c = 0; c < l->n; c++)
      low[c] = fmin(scratch[c], fmin(scratch[l->next[2 * a][c]], scratch[l->next[2 * a + 1][c]]));
    memcpy(scratch, high, bytes);
#pragma omp parallel for schedule(static) num_threads(threads)
    for (LitheIndex c = 0; c < l->n; c++)
      high[c] = fmax(scratch[c], fmax(scratch[l->next[2 * a][c]], scratch[l->next[2 * a + 1][c]]));
  }
}

static LitheStatus find_interior(LitheCtx *ctx, LthMixedLevel *l) {
  LitheStatus status = LITHE_OK;
  double *low = NULL, *high = NULL, *scratch = NULL;
  LTH_NEW_OR(done, ctx, low, l->n + 1);
  LTH_NEW_OR(done, ctx, high, l->n + 1);
  LTH_NEW_OR(done, ctx, scratch, l->n + 1);
  for (LitheIndex c = 0; c < l->n; c++) {
    bool whole = is_whole(l, c);
    low[c] = whole ? l->mu[c] : 0;
    high[c] = whole ? l->mu[c] : 0;
  }
  const int rings = l->dim == 3 ? 1 : 2; // a second one costs more boxes than cycles in 3D
  for (int ring = 0; ring < rings; ring++) spread(l, lth_threads(ctx), low, high, scratch);
  for (LitheIndex c = 0; c < l->n; c++)
    if (low[c] > 0 && high[c] <= (1 + SAME) * low[c]) l->flags[c] |= LTH_MIXED_INTERIOR;
done:
  lth_free(ctx, low);
  lth_free(ctx, high);
  lth_free(ctx, scratch);
  return status;
}

static int parity(const LthMixedLevel *l, LitheIndex c) {
  LitheIndex at[3];
  lth_cell_of(l->grid, c, at);
  return (at[0] + at[1] + at[2]) & 1;
}

/// Boxes of one color neither share unknowns nor see each other's.
static int box_color(const LthMixedLevel *l, LitheIndex c) {
  LitheIndex at[3];
  lth_cell_of(l->grid, c, at);
  return l->dim == 3 ? (at[0] + 2 * at[1] + 3 * at[2]) % 7 : (at[0] + 2 * at[1]) % 5;
}

static bool is_interior(const LthMixedLevel *l, LitheIndex c) {
  return (l->flags[c] & LTH_MIXED_INTERIOR) != 0;
}

static bool is_interior_face(const LthMixedLevel *l, int a, LitheIndex c) {
  return is_interior(l, c) && is_interior(l, l->next[2 * a][c]);
}

static bool is_near(const LthMixedLevel *l, LitheIndex c) {
  for (int k = 0; k < 2 * l->dim; k++)
    if (is_interior(l, l->next[k][c])) return true;
  return false;
}

static LitheStatus list_interior(LitheCtx *ctx, LthMixedLevel *l) {
  for (int pass = 0; pass < 2; pass++) {
    LitheIndex n_face[3][2] = {{0}}, n_cell[2] = {0}, n_near[2] = {0};
    for (LitheIndex c = 0; c < l->n; c++) {
      const bool inside = is_interior(l, c),
                 near = (l->flags[c] & LTH_MIXED_PRESSURE) && is_near(l, c);
      if (!inside && !near) continue;
      const int color = parity(l, c);
      for (int a = 0; a < l->dim; a++) {
        if (!is_interior_face(l, a, c)) continue;
        if (pass) l->face[a][color][n_face[a][color]] = c;
        n_face[a][color]++;
      }
      if (pass && inside) l->cell[color][n_cell[color]] = c;
      if (pass && near) l->near[color][n_near[color]] = c;
      n_cell[color] += inside;
      n_near[color] += near;
    }
    for (int color = 0; color < 2 && !pass; color++) {
      for (int a = 0; a < l->dim; a++) LTH_NEW(ctx, l->face[a][color], n_face[a][color]);
      LTH_NEW(ctx, l->cell[color], n_cell[color]);
      LTH_NEW(ctx, l->near[color], n_near[color]);
    }
    memcpy(l->n_face, n_face, sizeof n_face);
    memcpy(l->n_cell, n_cell, sizeof n_cell);
    memcpy(l->n_near, n_near, sizeof n_near);
  }
  return LITHE_OK;
}

/// The rows and columns of a box: faces low x, high x, low y, ... then the pressure. Unknowns that are not free have
/// a diagonal alone.
static void box_matrix(const LthMixedLevel *l, LitheIndex c, double *A) {
  const int dim = l->dim, m = 2 * dim + 1, p = 2 * dim;
  memset(A, 0, sizeof *A * (size_t)(m * m));
  for (int i = 0; i < p; i++) {
    const int a = i / 2;
    const LitheIndex f = i % 2 ? l->next[2 * a + 1][c] : c;
    A[i * m + i] = lth_mixed_diagonal(l, a, f);
    A[i * m + (i ^ 1)] = -2 * l->mu[c] * l->per_h[a] * l->per_h[a];
    A[i * m + p] = A[p * m + i] = (i % 2 ? 1 : -1) * l->volume[c] * l->per_h[a];
    for (int k = 0; k < p; k++) {
      const int b = k / 2;
      if (b == a) continue;
      // the edge where the two faces meet
      LitheIndex e = i % 2 ? l->next[2 * a + 1][c] : c;
      if (k % 2) e = l->next[2 * b + 1][e];
      double sign = (i % 2) == (k % 2) ? 1 : -1;
      A[i * m + k] = sign * l->shear[3 - a - b][e] * l->per_h[a] * l->per_h[b];
    }
  }
  A[p * m + p] = -l->compliance[c];
  for (int i = 0; i < p; i++) {
    const LitheIndex f = i % 2 ? l->next[i][c] : c;
    if (l->flags[f] & LTH_MIXED_FREE << i / 2) continue;
    for (int k = 0; k < m; k++) A[i * m + k] = A[k * m + i] = 0;
  }
}

/// Symmetric scaling to a unit diagonal, that of the pressure by what the faces give it.
static void box_scales(const double *A, int m, double *scale) {
  const int p = m - 1;
  double S = -A[p * m + p];
  for (int i = 0; i < p; i++) {
    scale[i] = A[i * m + i] > 0 ? 1 / sqrt(A[i * m + i]) : 0;
    S += A[i * m + p] * A[i * m + p] * scale[i] * scale[i];
  }
  scale[p] = S > 0 ? 1 / sqrt(S) : 0;
}

/// inverse = A^-1 by Gauss-Jordan elimination with faces first: A's faces are definite, so no exchange is needed.
/// Unknowns without a scale get zero rows.
static void invert_box(double *A, int m, float *inverse) {
  double scale[7], B[7][14];
  box_scales(A, m, scale);
  memset(B, 0, sizeof B);
  for (int i = 0; i < m; i++) {
    for (int k = 0; k < m; k++) B[i][k] = A[i * m + k] * scale[i] * scale[k];
    B[i][i] *= 1 + (i < m - 1 ? LOOSE : 0); // the faces of a lone cell hold nothing
    if (!(scale[i] > 0)) B[i][i] = 1;
    B[i][m + i] = 1;
  }
  for (int i = 0; i < m; i++) {
    const double pivot = 1 / B[i][i];
    for (int k = 0; k < 2 * m; k++) B[i][k] *= pivot;
    for (int row = 0; row < m; row++) {
      if (row == i) continue;
      const double factor = B[row][i];
      for (int k = 0; k < 2 * m; k++) B[row][k] -= factor * B[i][k];
    }
  }
  for (int i = 0; i < m; i++)
    for (int k = 0; k < m; k++) inverse[i * m + k] = (float)(B[i][m + k] * scale[i] * scale[k]);
}

/// Some face of a cell's box, or beside it, is marked.
static bool is_marked(const LthMixedLevel *l, LitheIndex c, const double *mark) {
  bool any = false;
  for (int a = 0; a < l->dim; a++)
    any |= mark[a * l->stride + c] != 0 || mark[a * l->stride + l->next[2 * a + 1][c]] != 0;
  return any;
}

void lth_mixed_invert_boxes(LitheCtx *ctx, LthMixedLevel *l, const double *mark) {
  const int m = 2 * l->dim + 1;
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheIndex i = 0; i < l->box_off[LTH_MIXED_COLORS]; i++) {
    double A[49];
    if (mark && !is_marked(l, l->box[i], mark)) continue;
    box_matrix(l, l->box[i], A);
    invert_box(A, m, l->inverse + (LitheCount)i * m * m);
  }
}

static LitheStatus make_boxes(LitheCtx *ctx, LthMixedLevel *l) {
  const int m = 2 * l->dim + 1;
  LitheIndex n = 0;
  for (LitheIndex c = 0; c < l->n; c++)
    n += (l->flags[c] & LTH_MIXED_PRESSURE) && !is_interior(l, c);
  LTH_NEW(ctx, l->box, n);
  LTH_NEW(ctx, l->inverse, (LitheCount)n * m * m);
  n = 0;
  for (int color = 0; color < LTH_MIXED_COLORS; color++) {
    l->box_off[color] = n;
    for (LitheIndex c = 0; c < l->n; c++)
      if ((l->flags[c] & LTH_MIXED_PRESSURE) && !is_interior(l, c) && box_color(l, c) == color)
        l->box[n++] = c;
  }
  l->box_off[LTH_MIXED_COLORS] = n;
  lth_mixed_invert_boxes(ctx, l, NULL);
  return LITHE_OK;
}

LitheStatus lth_mixed_level_sort(LitheCtx *ctx, LthMixedLevel *l) {
  LITHE_TRY(find_interior(ctx, l));
  LITHE_TRY(list_interior(ctx, l));
  return make_boxes(ctx, l);
}
