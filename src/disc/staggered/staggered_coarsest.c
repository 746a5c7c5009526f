/// Rows of the staggered operator, and the exact solve on the coarsest level.
#include "disc/staggered/staggered_coarsest.h"
#include "disc/staggered/staggered_slot.h"

#include <string.h>

static void add_entry(const LthStaggeredLevel *l, int b, LitheCount slot, double value,
                      LthStaggeredEntry *entry, int *n) {
  if (slot < 0 || value == 0 || l->state[b][slot] == LTH_UNKNOWN_DEAD) return;
  entry[(*n)++] = (LthStaggeredEntry){slot, b, value};
}

/// Slot of the neighbour at offsets along two axes.
static LitheCount neighbor(const LthSparseGrid *g, const LitheIndex cell[3], int a, int da, int b,
                           int db) {
  LitheIndex c[3] = {cell[0], cell[1], cell[2]};
  c[a] += da;
  c[b] += db;
  return lth_slot_of(g, c[0], c[1], c[2]);
}

// Entries of docs/theory/staggered.md (4), (5): normal stress of the two cells along a, shear of the edges across.
int lth_staggered_row(const LthStaggeredLevel *l, double cm, double ck, int a, LitheCount s,
                      LthStaggeredEntry entry[LTH_STAGGERED_ROW]) {
  const LthSparseGrid *g = l->grid;
  double volume = lth_sparse_grid_cell_volume(g), scale = volume * ck, ia = 1 / g->h[a];
  LitheIndex cell[3];
  lth_cell_of(g, s, cell);
  LitheCount before = lth_slot_along(g, cell, a, -1);
  const LitheCount at = lth_level_at(l, s);
  double here = l->lambda[at], there = lth_level_value(l, l->lambda, before);
  double high = (2 * l->mu[at] + here) * ia * ia;
  double low = (2 * lth_level_value(l, l->mu, before) + there) * ia * ia;
  double centre = high + low;
  int n = 1;
  add_entry(l, a, lth_slot_along(g, cell, a, 1), -scale * high, entry, &n);
  add_entry(l, a, before, -scale * low, entry, &n);
  for (int b = 0; b < g->dim; b++) {
    if (b == a) continue;
    double ib = 1 / g->h[b];
    LitheCount after = lth_slot_along(g, cell, b, 1);
    const double *shear = l->shear[3 - a - b];
    double below = shear[at], above = lth_level_value(l, shear, after);
    centre += (below + above) * ib * ib;
    add_entry(l, a, after, -scale * above * ib * ib, entry, &n);
    add_entry(l, a, lth_slot_along(g, cell, b, -1), -scale * below * ib * ib, entry, &n);
    double f = scale * ia * ib;
    add_entry(l, b, s, f * (here + below), entry, &n);
    add_entry(l, b, after, -f * (here + above), entry, &n);
    add_entry(l, b, before, -f * (there + below), entry, &n);
    add_entry(l, b, neighbor(g, cell, a, -1, b, 1), f * (there + above), entry, &n);
  }
  entry[0] = (LthStaggeredEntry){s, a, scale * centre + volume * cm * l->mass[a][at]};
  return n;
}

static LitheIndex *index_of(const LthStaggeredCoarsest *C, int a, LitheCount slot) {
  return C->index + a * C->level->grid->n_slots + slot;
}

/// Number the free unknowns, slot by slot.
static LitheStatus number_unknowns(LitheCtx *ctx, LthStaggeredCoarsest *C, LitheCount n) {
  const LthSparseGrid *g = C->level->grid;
  LTH_NEW(ctx, C->index, g->dim * g->n_slots);
  LTH_NEW(ctx, C->place, n);
  LTH_NEW(ctx, C->value, n);
  LitheIndex at = 0;
  for (LitheCount s = 0; s < g->n_slots; s++)
    for (int a = 0; a < g->dim; a++) {
      *index_of(C, a, s) = -1;
      if (C->level->level->state[a][s] != LTH_UNKNOWN_FREE) continue;
      C->place[at] = s * g->dim + a;
      *index_of(C, a, s) = at++;
    }
  return LITHE_OK;
}

/// Slot and component of an unknown.
static LitheCount slot_of(const LthStaggeredCoarsest *C, LitheIndex i, int *a) {
  const int dim = C->level->grid->dim;
  *a = (int)(C->place[i] % dim);
  return C->place[i] / dim;
}

/// Columns of a row, ascending; `value` may be NULL.
static int sorted_row(const LthStaggeredCoarsest *C, double cm, double ck, LitheIndex i,
                      LitheIndex col[LTH_STAGGERED_ROW], double value[LTH_STAGGERED_ROW]) {
  LthStaggeredEntry entry[LTH_STAGGERED_ROW];
  int a, n = 0;
  LitheCount slot = slot_of(C, i, &a);
  int n_entries = lth_staggered_row(C->level->level, cm, ck, a, slot, entry);
  for (int e = 0; e < n_entries; e++) {
    LitheIndex c = *index_of(C, entry[e].b, entry[e].slot);
    if (c < 0) continue;
    int at = n++;
    for (; at > 0 && col[at - 1] > c; at--) col[at] = col[at - 1], value[at] = value[at - 1];
    col[at] = c;
    value[at] = entry[e].value;
  }
  return n;
}

static LitheStatus create_matrix(LitheCtx *ctx, LthStaggeredCoarsest *C, LitheIndex n) {
  LitheStatus status = LITHE_OK;
  LitheCount *row_off = NULL, *block_off = NULL;
  LitheIndex *col = NULL;
  double value[LTH_STAGGERED_ROW];
  LTH_NEW_OR(done, ctx, row_off, n + 1);
  LTH_NEW_OR(done, ctx, block_off, n + 1);
  LTH_NEW_OR(done, ctx, col, (LitheCount)n * LTH_STAGGERED_ROW);
  for (LitheIndex i = 0; i < n; i++) {
    row_off[i + 1] = i + 1;
    block_off[i + 1] = block_off[i] + sorted_row(C, 1, 1, i, col + block_off[i], value);
  }
  LITHE_TRY_OR(done, lth_block_matrix_create(ctx, n, row_off, block_off, col, &C->A));
done:
  lth_free(ctx, row_off);
  lth_free(ctx, block_off);
  lth_free(ctx, col);
  return status;
}

LitheStatus lth_staggered_coarsest_create(LitheCtx *ctx, const LthFastLevel *level, LitheCount most,
                                          LthStaggeredCoarsest *C) {
  LitheStatus status = LITHE_OK;
  *C = (LthStaggeredCoarsest){.level = level, .engine = lth_engine_find("cholesky")};
  LitheCount n = lth_staggered_count_free(ctx, level->level);
  if (n > most || n == 0 || !C->engine) return LITHE_OK;
  LITHE_TRY_OR(done, number_unknowns(ctx, C, n));
  LITHE_TRY_OR(done, create_matrix(ctx, C, (LitheIndex)n));
  LITHE_TRY_OR(done, C->engine->analyse(ctx, C->A, &C->factor));
done:
  if (status != LITHE_OK) lth_staggered_coarsest_free(ctx, C);
  return status;
}

void lth_staggered_coarsest_free(LitheCtx *ctx, LthStaggeredCoarsest *C) {
  if (C->factor) C->engine->destroy(ctx, &C->factor);
  lth_block_matrix_destroy(ctx, &C->A);
  lth_free(ctx, C->place);
  lth_free(ctx, C->index);
  lth_free(ctx, C->value);
  *C = (LthStaggeredCoarsest){0};
}

/// Values of (cm M + ck K) / unit, with `more` of the diagonal.
static void fill(LthStaggeredCoarsest *C, double cm, double ck, double unit, double more) {
  for (LitheIndex i = 0; i < C->A->n_rows; i++) {
    LitheIndex col[LTH_STAGGERED_ROW];
    double value[LTH_STAGGERED_ROW];
    int n = sorted_row(C, cm, ck, i, col, value);
    for (int e = 0; e < n; e++) {
      LitheCount block = lth_block_matrix_find(C->A, i, col[e]);
      C->A->values[C->A->value_off[block]] = value[e] / unit * (col[e] == i ? 1 + more : 1);
    }
  }
}

// A preconditioner may be a little stiffer than the body where coarse cells leave a motion without energy.
LitheStatus lth_staggered_coarsest_set(LitheCtx *ctx, LthStaggeredCoarsest *C, double cm, double ck,
                                       double unit) {
  if (!C->A) return LITHE_OK;
  fill(C, cm, ck, unit, 0);
  LitheStatus status = C->engine->factorize(ctx, C->factor, C->A);
  if (status != LITHE_NOT_CONVERGED) return status;
  fill(C, cm, ck, unit, 1e-3);
  return C->engine->factorize(ctx, C->factor, C->A);
}

LitheStatus lth_staggered_coarsest_solve(LitheCtx *ctx, LthStaggeredCoarsest *C) {
  const LthFastLevel *L = C->level;
  int a;
  for (LitheIndex i = 0; i < C->A->n_rows; i++) {
    LitheCount slot = slot_of(C, i, &a);
    C->value[i] = *lth_fast_value(L, L->b, slot, a);
  }
  LITHE_TRY(C->engine->solve(ctx, C->factor, C->value, C->value));
  for (LitheIndex q = 0; q < L->n_rows; q++)
    memset(L->x.at + q * L->x.stride, 0, sizeof *L->x.at * (size_t)lth_fast_width(L));
  for (LitheIndex i = 0; i < C->A->n_rows; i++) {
    LitheCount slot = slot_of(C, i, &a);
    *lth_fast_value(L, L->x, slot, a) = (float)C->value[i];
  }
  return LITHE_OK;
}

double lth_staggered_coarsest_bytes(const LthStaggeredCoarsest *C) {
  double bytes, flops;
  C->engine->predict(C->factor, &bytes, &flops);
  return 2 * bytes;
}
