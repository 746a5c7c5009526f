/// The coarsest level of the mixed form, solved directly: pressures are eliminated with a last bit of
/// compressibility, so that a definite matrix of displacements is left.
#include "disc/staggered/staggered_mixed.h"
#include "la/engine.h"

#include <string.h>

#define SOFT 1e-6      // of mu / lambda that every cell has at least
#define ENTRIES 15     // of a row: itself, 2 along, 4 across, 8 of the other components
#define MOST_2D 400000 // unknowns that a factor is made for
#define MOST_3D 60000
#define SWEEPS 12 // where no factor is made

struct LthMixedCoarse {
  LthBlockMatrix *K;
  const LthEngine *engine;
  LthFactor *factor;
  LitheIndex *row; ///< of a face, component by component, or -1          (dim (n + 1))
  LitheIndex n;
  double *f; ///< (n)
};

/// V^2 over the compliance: V lambda as the coarsest level has it.
static double stiffness(const LthMixedLevel *l, LitheIndex c) {
  const double V = l->volume[c];
  return V > 0 ? V * V / (l->compliance[c] + SOFT * V * V / l->mu[c]) : 0;
}

typedef struct Row {
  int n;
  LitheIndex col[ENTRIES];
  double value[ENTRIES];
} Row;

static void add(const LthMixedLevel *l, const LthMixedCoarse *k, int a, LitheIndex c, double value,
                Row *row) {
  const LitheIndex col = k->row[a * (l->n + 1) + c];
  if (col < 0) return;
  int at = row->n++;
  for (; at > 0 && row->col[at - 1] > col; at--) {
    row->col[at] = row->col[at - 1];
    row->value[at] = row->value[at - 1];
  }
  row->col[at] = col;
  row->value[at] = value;
}

/// What another component's faces give to the row of axis a: those of the two cells beside it.
static void add_cross(const LthMixedLevel *l, const LthMixedCoarse *k, int a, int b, LitheIndex c,
                      Row *row) {
  const double *shear = l->shear[3 - a - b], per_ab = l->per_h[a] * l->per_h[b];
  const LitheIndex low = l->next[2 * a][c], above = l->next[2 * b + 1][c];
  const LitheIndex low_above = l->next[2 * b + 1][low];
  const double near = stiffness(l, c), far = stiffness(l, low);
  add(l, k, b, c, (near + shear[c]) * per_ab, row);
  add(l, k, b, above, -(near + shear[above]) * per_ab, row);
  add(l, k, b, low, -(far + shear[c]) * per_ab, row);
  add(l, k, b, low_above, (far + shear[above]) * per_ab, row);
}

static void make_row(const LthMixedLevel *l, const LthMixedCoarse *k, int a, LitheIndex c,
                     Row *row) {
  const LitheIndex low = l->next[2 * a][c], high = l->next[2 * a + 1][c];
  const double aa = l->per_h[a] * l->per_h[a];
  const double near = (2 * l->mu[c] + stiffness(l, c)) * aa,
               far = (2 * l->mu[low] + stiffness(l, low)) * aa;
  row->n = 0;
  add(l, k, a, c, lth_mixed_diagonal(l, a, c) + (stiffness(l, c) + stiffness(l, low)) * aa, row);
  add(l, k, a, high, -near, row);
  add(l, k, a, low, -far, row);
  for (int b = 0; b < l->dim; b++) {
    if (b == a) continue;
    const double *shear = l->shear[3 - a - b], bb = l->per_h[b] * l->per_h[b];
    const LitheIndex below = l->next[2 * b][c], above = l->next[2 * b + 1][c];
    add(l, k, a, below, -shear[c] * bb, row);
    add(l, k, a, above, -shear[above] * bb, row);
    add_cross(l, k, a, b, c, row);
  }
}

static void number_rows(const LthMixedLevel *l, LthMixedCoarse *k) {
  for (int a = 0; a < l->dim; a++) k->row[a * (l->n + 1) + l->n] = -1;
  for (LitheIndex c = 0; c < l->n; c++)
    for (int a = 0; a < l->dim; a++)
      k->row[a * (l->n + 1) + c] = l->flags[c] & LTH_MIXED_FREE << a ? k->n++ : -1;
}

static LitheStatus make_pattern(LitheCtx *ctx, const LthMixedLevel *l, LthMixedCoarse *k) {
  LitheStatus status = LITHE_OK;
  LitheCount *row_off = NULL, *block_off = NULL, at = 0;
  LitheIndex *col = NULL, rows = 0;
  LTH_NEW_OR(done, ctx, row_off, k->n + 1);
  LTH_NEW_OR(done, ctx, block_off, k->n + 1);
  LTH_NEW_OR(done, ctx, col, (LitheCount)k->n * ENTRIES);
  for (LitheIndex c = 0; c < l->n; c++)
    for (int a = 0; a < l->dim; a++) {
      Row row;
      if (k->row[a * (l->n + 1) + c] < 0) continue;
      make_row(l, k, a, c, &row);
      memcpy(col + at, row.col, sizeof *col * (size_t)row.n);
      at += row.n;
      rows++;
      row_off[rows] = rows;
      block_off[rows] = at;
    }
  LITHE_TRY_OR(done, lth_block_matrix_create(ctx, k->n, row_off, block_off, col, &k->K));
done:
  lth_free(ctx, row_off);
  lth_free(ctx, block_off);
  lth_free(ctx, col);
  return status;
}

static void fill(const LthMixedLevel *l, const LthMixedCoarse *k) {
  for (LitheIndex c = 0; c < l->n; c++)
    for (int a = 0; a < l->dim; a++) {
      Row row;
      const LitheIndex i = k->row[a * (l->n + 1) + c];
      if (i < 0) continue;
      make_row(l, k, a, c, &row);
      memcpy(k->K->values + k->K->block_off[i], row.value, sizeof *row.value * (size_t)row.n);
    }
}

LitheStatus lth_mixed_coarse_update(LitheCtx *ctx, LthMixedCoarse *k, const LthMixedLevel *l) {
  if (!k->factor) return LITHE_OK;
  fill(l, k);
  LitheStatus status = k->engine->factorize(ctx, k->factor, k->K);
  if (status != LITHE_NOT_CONVERGED) return status;
  // parts that hang together by corners alone: sweeps leave them where they are
  k->engine->destroy(ctx, &k->factor);
  return LITHE_OK;
}

void lth_mixed_coarse_destroy(LitheCtx *ctx, LthMixedCoarse **coarse) {
  LthMixedCoarse *k = *coarse;
  if (!k) return;
  if (k->factor) k->engine->destroy(ctx, &k->factor);
  lth_block_matrix_destroy(ctx, &k->K);
  lth_free(ctx, k->row);
  lth_free(ctx, k->f);
  lth_free(ctx, k);
  *coarse = NULL;
}

static LitheStatus create(LitheCtx *ctx, const LthMixedLevel *l, LthMixedCoarse *k) {
  LTH_NEW(ctx, k->row, l->dim * (LitheCount)(l->n + 1));
  number_rows(l, k);
  if (k->n > (l->dim == 3 ? MOST_3D : MOST_2D)) return LITHE_OK;
  LTH_NEW(ctx, k->f, k->n);
  k->engine = lth_engine_find("cholesky");
  LITHE_TRY(make_pattern(ctx, l, k));
  LITHE_TRY(k->engine->analyse(ctx, k->K, &k->factor));
  return lth_mixed_coarse_update(ctx, k, l);
}

LitheStatus lth_mixed_coarse_create(LitheCtx *ctx, const LthMixedLevel *l,
                                    LthMixedCoarse **coarse) {
  LTH_NEW(ctx, *coarse, 1);
  LitheStatus status = create(ctx, l, *coarse);
  if (status != LITHE_OK) lth_mixed_coarse_destroy(ctx, coarse);
  return status;
}

/// g over the softened compliance: what the constraint's right-hand side weighs in the momentum rows.
static double load_pressure(const LthMixedLevel *l, LitheIndex c) {
  const double V = l->volume[c];
  if (!(l->flags[c] & LTH_MIXED_PRESSURE)) return 0;
  return l->b[l->dim * l->stride + c] * stiffness(l, c) / (V * V);
}

LitheStatus lth_mixed_coarse_solve(LitheCtx *ctx, LthMixedCoarse *k, LthMixedLevel *l) {
  const int dim = l->dim;
  if (!k->factor) {
    for (int i = 0; i < SWEEPS; i++) lth_mixed_smooth(l, lth_threads(ctx));
    return LITHE_OK;
  }
  for (LitheIndex c = 0; c < l->n; c++)
    for (int a = 0; a < dim; a++) {
      const LitheIndex row = k->row[a * (l->n + 1) + c], low = l->next[2 * a][c];
      if (row < 0) continue;
      double load = l->volume[low] * load_pressure(l, low) - l->volume[c] * load_pressure(l, c);
      k->f[row] = l->b[a * l->stride + c] + load * l->per_h[a];
    }
  LITHE_TRY(k->engine->solve(ctx, k->factor, k->f, k->f));
  for (LitheIndex c = 0; c < l->n; c++)
    for (int a = 0; a < dim; a++) {
      const LitheIndex row = k->row[a * (l->n + 1) + c];
      if (row >= 0) l->x[a * l->stride + c] = k->f[row];
    }
  for (LitheIndex c = 0; c < l->n; c++) {
    const double V = l->volume[c];
    if (!(l->flags[c] & LTH_MIXED_PRESSURE)) continue;
    l->x[dim * l->stride + c] =
        stiffness(l, c) / V * lth_mixed_divergence(l, c, l->x) - load_pressure(l, c);
  }
  return LITHE_OK;
}
