/// The exact solve on the coarsest level.
#include "disc/staggered/staggered_coarsest.h"

#include <string.h>

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
