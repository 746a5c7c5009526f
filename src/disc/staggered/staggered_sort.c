/// Blocks and rows of a level sorted by what they hold.
#include "disc/staggered/staggered_fast.h"

#include <math.h>

static bool near_enough(double a, double b) { return fabs(a - b) <= 1e-14 * fabs(b); }

static bool are_near(const double *v, LitheCount at, int side, double value) {
  for (int i = 0; i < side; i++)
    if (!near_enough(v[at + i], value)) return false;
  return true;
}

/// Samples of cells, or of edges, of a row are those of a row that is constant.
static bool has_cells_of(const LthStaggeredLevel *l, LitheIndex row, LitheIndex constant) {
  const int side = l->grid->side;
  const LitheCount at = (LitheCount)row * side, as = (LitheCount)constant * side;
  return row == constant ||
         (are_near(l->mu, at, side, l->mu[as]) && are_near(l->lambda, at, side, l->lambda[as]));
}
static bool has_edges_of(const LthStaggeredLevel *l, LitheIndex row, LitheIndex constant) {
  const int side = l->grid->side;
  const LitheCount at = (LitheCount)row * side, as = (LitheCount)constant * side;
  for (int e = 0; e < 3 && row != constant; e++)
    if (l->shear[e] && !are_near(l->shear[e], at, side, l->mu[as])) return false;
  return true;
}

static bool is_constant(const LthStaggeredLevel *l, LitheIndex row) {
  const LitheCount at = (LitheCount)row * l->grid->side;
  if (!(l->mu[at] > 0) || !are_near(l->mu, at, l->grid->side, l->mu[at]) ||
      !are_near(l->lambda, at, l->grid->side, l->lambda[at]))
    return false;
  for (int e = 0; e < 3; e++)
    if (l->shear[e] && !are_near(l->shear[e], at, l->grid->side, l->mu[at])) return false;
  return true;
}

/// Row of samples of row (j, k) of a block, or of the block before (x = -1) or behind it; j and k may be one beyond.
static LitheIndex row_at(const LthStaggeredLevel *l, LitheIndex block, int x, int j, int k) {
  const LthSparseGrid *g = l->grid;
  const int side = g->side, deep = g->dim == 3 ? side : 1;
  const int dy = j < 0 ? -1 : j >= side, dz = k < 0 ? -1 : k >= deep;
  const LitheIndex to =
      g->neighbor[(LitheCount)block * g->n_neighbors + g->n_neighbors / 2 + 9 * dz + 3 * dy + x];
  if (to < 0) return l->n_rows; // zeros
  return l->row[to * (LitheCount)(side * deep) + (k - dz * deep) * side + j - dy * side];
}

/// All samples that unknowns of row (j, k) of a block touch are those of a constant row: cells of this row and those
/// below, edges of this row and those above.
static bool is_plain(const LthStaggeredLevel *l, LitheIndex block, int j, int k,
                     LitheIndex constant) {
  const int side = l->grid->side;
  const bool deep = l->grid->dim == 3;
  const LitheCount as = (LitheCount)constant * side;
  const LitheIndex own = row_at(l, block, 0, j, k);
  if (!has_cells_of(l, own, constant) || !has_edges_of(l, own, constant) ||
      !has_cells_of(l, row_at(l, block, 0, j - 1, k), constant) ||
      !has_edges_of(l, row_at(l, block, 0, j + 1, k), constant))
    return false;
  if (deep && (!has_cells_of(l, row_at(l, block, 0, j, k - 1), constant) ||
               !has_edges_of(l, row_at(l, block, 0, j, k + 1), constant)))
    return false;
  const LitheCount before = (LitheCount)row_at(l, block, -1, j, k) * side + side - 1;
  const LitheCount behind = (LitheCount)row_at(l, block, 1, j, k) * side;
  return near_enough(l->mu[before], l->mu[as]) && near_enough(l->lambda[before], l->lambda[as]) &&
         near_enough(l->shear[2][behind], l->mu[as]) &&
         (!deep || near_enough(l->shear[1][behind], l->mu[as]));
}

/// Whether an unknown of a row of slots is alive, and whether all are free.
static void read_states(const LthStaggeredLevel *l, LitheCount first, bool *alive, bool *free) {
  *alive = false;
  *free = true;
  for (int a = 0; a < l->grid->dim; a++)
    for (int i = 0; i < l->grid->side; i++) {
      *alive |= l->state[a][first + i] != LTH_UNKNOWN_DEAD;
      *free &= l->state[a][first + i] == LTH_UNKNOWN_FREE;
    }
}

/// All faces of a block have the mass of the first one.
static bool has_one_mass(const LthStaggeredLevel *l, LitheIndex block) {
  const LthSparseGrid *g = l->grid;
  const LitheIndex rows = g->block_cells / g->side;
  const double rho = l->mass[0][lth_level_at(l, (LitheCount)block * g->block_cells)];
  for (LitheCount r = block * (LitheCount)rows; r < (block + 1) * (LitheCount)rows; r++)
    for (int a = 0; a < g->dim; a++)
      if (!are_near(l->mass[a], (LitheCount)l->row[r] * g->side, g->side, rho)) return false;
  return true;
}

/// All rows of a block have the samples and the mass of its first one.
static bool is_uniform(const LthStaggeredLevel *l, LitheIndex block) {
  const int side = l->grid->side, rows = l->grid->block_cells / side;
  const LitheIndex constant = l->row[block * (LitheCount)rows];
  if (!is_constant(l, constant)) return false;
  for (int r = 0; r < rows; r++)
    if (!is_plain(l, block, r % side, r / side, constant)) return false;
  return has_one_mass(l, block);
}

/// Which rows of a block are alive, and what kind it is.
static void sort_block(LthFastLevel *L, LitheIndex block) {
  const LthStaggeredLevel *l = L->level;
  const int side = L->grid->side, rows = L->grid->block_cells / side;
  bool all_free = true;
  for (int r = 0; r < rows; r++) {
    bool alive, free;
    read_states(l, (block * (LitheCount)rows + r) * side, &alive, &free);
    L->alive[block] |= (uint64_t)alive << r;
    all_free &= free;
  }
  L->kind[block] = !L->alive[block]                   ? LTH_BLOCK_EMPTY
                   : all_free && is_uniform(l, block) ? LTH_BLOCK_UNIFORM
                                                      : LTH_BLOCK_GENERAL;
}

/// Give places in vectors to rows that are alive, block by block, from 1 on.
static LitheStatus number_rows(LitheCtx *ctx, LthFastLevel *L) {
  const LthSparseGrid *g = L->grid;
  const LitheIndex rows = g->block_cells / g->side;
  LTH_NEW(ctx, L->row, (LitheCount)g->n_blocks * rows);
  LTH_NEW(ctx, L->first, (LitheCount)g->n_blocks + 1);
  L->n_rows = 1;
  for (LitheIndex b = 0; b < g->n_blocks; b++) {
    L->first[b] = L->n_rows;
    for (LitheIndex r = 0; r < rows; r++) {
      const LitheCount at = (LitheCount)b * rows + r;
      if (L->alive[b] >> r & 1) L->row[at] = L->n_rows++;
    }
  }
  L->first[g->n_blocks] = L->n_rows;
  LTH_NEW(ctx, L->local, L->n_rows);
  for (LitheCount r = 0; r < (LitheCount)g->n_blocks * rows; r++)
    if (L->row[r] > 0) L->local[L->row[r]] = (uint8_t)(r % rows);
  return LITHE_OK;
}

LitheStatus lth_fast_level_sort(LitheCtx *ctx, LthFastLevel *L) {
  LitheIndex n = L->grid->n_blocks;
  LTH_NEW(ctx, L->kind, n);
  LTH_NEW(ctx, L->alive, n);
  LTH_NEW(ctx, L->number, n);
  LTH_NEW(ctx, L->scaled, n);
  LTH_NEW(ctx, L->same_scale, n);
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheIndex b = 0; b < n; b++) sort_block(L, b);
  for (LitheIndex b = 0; b < n; b++) L->n_active += L->kind[b] != LTH_BLOCK_EMPTY;
  LTH_NEW(ctx, L->active, L->n_active);
  LITHE_TRY(number_rows(ctx, L));
  LitheIndex at = 0;
  for (LitheIndex b = 0; b < n; b++) {
    L->number[b] = -1;
    L->scaled[b] = -1;
    L->same_scale[b] = 1;
    if (L->kind[b] != LTH_BLOCK_EMPTY) L->active[at++] = b;
    if (L->kind[b] != LTH_BLOCK_GENERAL) continue;
    L->number[b] = L->n_general;
    L->n_general += L->first[b + 1] - L->first[b];
  }
  return LITHE_OK;
}
