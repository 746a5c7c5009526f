/// One level of a staggered grid from the next finer one: averaged coefficients.
/// Zhu, Sifakis, Teran, Brandt 2010; docs/theory/staggered-multigrid.md, equation (1).
#include "disc/staggered/staggered_hierarchy.h"
#include "disc/staggered/staggered_walls.h"

#include <math.h>
#include <string.h>

/// Cells of a block that hold something: lowest and highest, or false.
static bool solid_box(const LthStaggeredLevel *l, LitheIndex block, LitheIndex low[3],
                      LitheIndex high[3]) {
  const LthSparseGrid *g = l->grid;
  bool any = false;
  LitheCount first = (LitheCount)block * g->block_cells;
  for (LitheCount s = first; s < first + g->block_cells; s++) {
    if (!lth_level_is_live(l, s)) continue;
    LitheIndex c[3];
    lth_sparse_grid_cell(g, s, c);
    for (int a = 0; a < 3; a++) {
      if (!any || c[a] < low[a]) low[a] = c[a];
      if (!any || c[a] > high[a]) high[a] = c[a];
    }
    any = true;
  }
  return any;
}

/// Mark the coarse blocks that hold or touch what a fine block holds.
static void want_blocks(const LthSparseGrid *fine, const LitheIndex low[3],
                        const LitheIndex high[3], const LitheIndex n_block[3], uint8_t *wanted) {
  LitheIndex from[3], to[3];
  int bits = lth_sparse_grid_bits(fine);
  for (int a = 0; a < 3; a++) {
    bool flat = fine->dim == 2 && a == 2;
    LitheIndex first = (low[a] >> 1) - 1, last = (high[a] >> 1) + 1;
    from[a] = flat || first < 0 ? 0 : first >> bits;
    to[a] = flat ? 0 : last >> bits;
    if (to[a] >= n_block[a]) to[a] = n_block[a] - 1;
  }
  for (LitheIndex k = from[2]; k <= to[2]; k++)
    for (LitheIndex j = from[1]; j <= to[1]; j++)
      for (LitheIndex i = from[0]; i <= to[0]; i++)
        wanted[i + (LitheCount)n_block[0] * (j + (LitheCount)n_block[1] * k)] = 1;
}

static LitheStatus coarse_grid(LitheCtx *ctx, const LthStaggeredLevel *fine, LthSparseGrid **grid) {
  LitheStatus status = LITHE_OK;
  const LthSparseGrid *g = fine->grid;
  LitheIndex n[3], n_block[3], low[3] = {0}, high[3] = {0};
  double h[3];
  uint8_t *wanted = NULL;
  for (int a = 0; a < 3; a++) {
    n[a] = g->n[a] / 2 + 1; // a face more than the finest: the last cell's high one has a slot
    h[a] = 2 * g->h[a];
    n_block[a] = lth_sparse_grid_blocks(g->dim, a, n[a]);
  }
  LTH_NEW_OR(done, ctx, wanted, (LitheCount)n_block[0] * n_block[1] * n_block[2]);
  for (LitheIndex b = 0; b < g->n_blocks; b++)
    if (solid_box(fine, b, low, high)) want_blocks(g, low, high, n_block, wanted);
  LITHE_TRY_OR(done, lth_sparse_grid_create(ctx, g->dim, g->origin, h, n, wanted, grid));
done:
  lth_free(ctx, wanted);
  return status;
}

/// No face of a cell, which stands at a slot, is free and some are held: it cannot deform, and says nothing of the body before it.
static bool is_beyond(const LthStaggeredLevel *l, const LitheIndex cell[3], LitheCount slot) {
  bool held = false;
  for (int a = 0; a < l->grid->dim; a++)
    for (int high = 0; high < 2; high++) {
      const LitheCount at = high ? lth_sparse_grid_along(l->grid, cell, a, 1) : slot;
      const int state = lth_level_state(l, a, at);
      if (state == LTH_UNKNOWN_FREE) return false;
      held |= state == LTH_UNKNOWN_HELD;
    }
  return held;
}

/// Values of a cell, or means of them.
typedef struct CellValues {
  double lambda, mu, volume;
} CellValues;

/// Those of the cell at a slot times w.
static void add_cell(const LthStaggeredLevel *l, LitheCount slot, double w, CellValues *sum) {
  sum->lambda += w * lth_level_value(l, l->lambda, slot);
  sum->mu += w * lth_level_value(l, l->mu, slot);
  if (l->volume) sum->volume += lth_level_value(l, l->volume, slot);
}

/// Means of cell values over such a box, of what can deform if something can, as if there were no walls.
static CellValues box_mean(const LthStaggeredLevel *fine, const LitheIndex cell[3], int shifted) {
  LitheIndex low[3], high[3], c[3];
  lth_fine_box(fine->grid->dim, cell, shifted, low, high);
  CellValues sum = {0}, beyond = {0};
  int n = 0, n_beyond = 0;
  for (c[2] = low[2]; c[2] <= high[2]; c[2]++)
    for (c[1] = low[1]; c[1] <= high[1]; c[1]++)
      for (c[0] = low[0]; c[0] <= high[0]; c[0]++, n++) {
        const LitheCount s = lth_sparse_grid_slot(fine->grid, c[0], c[1], c[2]);
        if (is_beyond(fine, c, s)) {
          n_beyond++;
          add_cell(fine, s, 1, &beyond);
        } else if (lth_level_is_live(fine, s)) {
          const LthWallCuts cuts = lth_staggered_wall_cuts(fine, s, -1);
          add_cell(fine, s, 1 / lth_wall_factor(&cuts), &sum);
        }
      }
  const CellValues *all = n_beyond < n ? &sum : &beyond;
  const double share = 1.0 / (n_beyond < n ? n - n_beyond : n);
  return (CellValues){all->lambda * share, all->mu * share, all->volume * share};
}

/// Mass of a coarse face: fine faces in it, and half of those a fine cell to both sides. Held ones may have less than
/// none (staggered_beyond.c).
static double face_mass(const LthStaggeredLevel *fine, const LitheIndex cell[3], int a) {
  static const double along[3] = {0.25, 0.5, 0.25};
  LitheIndex low[3], high[3];
  lth_fine_box(fine->grid->dim, cell, 0, low, high);
  double sum = 0;
  for (int s = 0; s < 3; s++) {
    low[a] = high[a] = 2 * cell[a] + s - 1;
    for (LitheIndex k = low[2]; k <= high[2]; k++)
      for (LitheIndex j = low[1]; j <= high[1]; j++)
        for (LitheIndex i = low[0]; i <= high[0]; i++)
          sum += along[s] * fmax(0, lth_level_value(fine, fine->mass[a],
                                                    lth_sparse_grid_slot(fine->grid, i, j, k)));
  }
  return sum / (fine->grid->dim == 3 ? 4 : 2);
}

static void average_slot(const LthStaggeredLevel *fine, LthStaggeredLevel *coarse, LitheCount s) {
  const LthSparseGrid *g = fine->grid;
  LitheIndex cell[3];
  lth_sparse_grid_cell(coarse->grid, s, cell);
  const CellValues own = box_mean(fine, cell, 0);
  coarse->lambda[s] = own.lambda;
  coarse->mu[s] = own.mu;
  if (fine->volume) coarse->volume[s] = own.volume;
  for (int e = 0; e < 3; e++)
    if (coarse->shear[e]) coarse->shear[e][s] = box_mean(fine, cell, 7 & ~(1 << e)).mu;
  for (int a = 0; a < g->dim; a++) {
    coarse->mass[a][s] = face_mass(fine, cell, a);
    coarse->state[a][s] =
        lth_staggered_coarse_is_held(fine, cell, a) ? LTH_UNKNOWN_HELD : LTH_UNKNOWN_DEAD;
  }
}

/// Samples that coarse ones are means of, at a place, are those at another.
static bool are_alike(const LthStaggeredLevel *l, LitheCount at, LitheCount other) {
  const double *all[] = {l->lambda, l->mu, l->volume, l->mass[0], l->mass[1], l->mass[2]};
  for (size_t v = 0; v < sizeof all / sizeof *all; v++)
    if (all[v] && all[v][at] != all[v][other]) return false;
  return true;
}

static bool is_constant(const LthStaggeredLevel *l, LitheIndex row) {
  const LitheCount first = (LitheCount)row * l->grid->side;
  for (int i = 1; i < l->grid->side; i++)
    if (!are_alike(l, first + i, first)) return false;
  return true;
}

/// Faces of a slot are free where it is solid, else dead.
static bool is_inner(const LthStaggeredLevel *l, LitheCount slot) {
  const int state = lth_level_is_live(l, slot) ? LTH_UNKNOWN_FREE : LTH_UNKNOWN_DEAD;
  for (int a = 0; a < l->grid->dim; a++)
    if (l->state[a][slot] != state) return false;
  return true;
}

static LitheIndex plain_of(const LthStaggeredLevel *l, const uint8_t *constant, LitheCount row) {
  if (!constant[l->row[row]]) return -1;
  for (int i = 0; i < l->grid->side; i++)
    if (!is_inner(l, row * l->grid->side + i)) return -1;
  return lth_level_is_live(l, row * l->grid->side) ? l->row[row] : l->n_rows;
}

/// Rows of samples of rows of slots that are constant, and whose faces are all free, or dead where nothing is solid (then the
/// row of zeros); else -1. NULL where rows that are alike do not share samples.
static LitheStatus list_plain(LitheCtx *ctx, const LthStaggeredLevel *l, LitheIndex **plain) {
  LitheStatus status = LITHE_OK;
  const LitheCount n = l->grid->n_slots / l->grid->side;
  uint8_t *constant = NULL;
  *plain = NULL;
  if (!lth_staggered_level_is_packed(l)) return LITHE_OK;
  LTH_NEW_OR(done, ctx, constant, l->n_rows);
  LTH_NEW_OR(done, ctx, *plain, n);
  for (LitheIndex r = 0; r < l->n_rows; r++) constant[r] = is_constant(l, r);
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheCount r = 0; r < n; r++) (*plain)[r] = plain_of(l, constant, r);
done:
  lth_free(ctx, constant);
  return status;
}

/// Whether the cell at the end of a row next to a plain one, if it is not plain itself, goes on like that.
static bool goes_on(const LthStaggeredLevel *fine, LitheCount slot, LitheIndex plain) {
  return is_inner(fine, slot) &&
         are_alike(fine, lth_level_at(fine, slot), (LitheCount)plain * fine->grid->side);
}

/// The plain row that all fine rows are which the cells of a coarse row touch, with the cells beside them; -1: there is none.
/// `cell` is the first one of the coarse row.
static LitheIndex plain_around(const LthStaggeredLevel *fine, const LitheIndex *plain,
                               const LitheIndex cell[3]) {
  const LthSparseGrid *g = fine->grid;
  const int side = g->side, mask = side - 1, deep = g->dim == 3;
  static const int order[4] = {0, 1, -1,
                               2}; // blocks along x: what is under the row, then what is beside
  LitheIndex same = -1;
  for (LitheIndex k = deep ? 2 * cell[2] - 1 : 0; k <= (deep ? 2 * cell[2] + 2 : 0); k++)
    for (LitheIndex j = 2 * cell[1] - 1; j <= 2 * cell[1] + 2; j++)
      for (int x = 0; x < 4; x++) {
        const LitheIndex block = lth_sparse_grid_block_of(g, 2 * cell[0] + order[x] * side, j, k);
        const LitheCount row = block * (LitheCount)(g->block_cells / side) +
                               (deep ? (k & mask) * side : 0) + (j & mask);
        const LitheIndex here = block < 0 ? fine->n_rows : plain[row];
        if (same < 0) same = here;
        const bool beside = order[x] < 0 || order[x] > 1;
        if (same < 0) return -1;
        if (here == same) continue;
        const LitheCount slot = row * side + (order[x] < 0 ? mask : 0);
        if (!beside || block < 0 || !goes_on(fine, slot, same)) return -1;
      }
  return same;
}

/// Samples of a coarse row from those of a plain one.
static void copy_row(const LthStaggeredLevel *fine, LitheIndex plain, LthStaggeredLevel *coarse,
                     LitheCount first) {
  const LitheCount from = (LitheCount)plain * fine->grid->side;
  for (LitheCount s = first; s < first + coarse->grid->side; s++) {
    coarse->lambda[s] = fine->lambda[from];
    coarse->mu[s] = fine->mu[from];
    if (fine->volume) coarse->volume[s] = fine->volume[from];
    for (int e = 0; e < 3; e++)
      if (coarse->shear[e]) coarse->shear[e][s] = fine->mu[from];
    for (int a = 0; a < fine->grid->dim; a++) coarse->mass[a][s] = fine->mass[a][from];
  }
}

static void average_row(const LthStaggeredLevel *fine, const LitheIndex *plain,
                        LthStaggeredLevel *coarse, LitheCount first) {
  LitheIndex cell[3];
  lth_sparse_grid_cell(coarse->grid, first, cell);
  const LitheIndex same = plain ? plain_around(fine, plain, cell) : -1;
  if (same >= 0)
    copy_row(fine, same, coarse, first);
  else
    for (int i = 0; i < coarse->grid->side; i++) average_slot(fine, coarse, first + i);
}

/// Arrays of a coarse level: the same ones that the fine level has.
static LitheStatus alloc_like(LitheCtx *ctx, const LthStaggeredLevel *fine,
                              const LthSparseGrid *grid, LthStaggeredLevel *coarse) {
  LitheStatus status = LITHE_OK;
  LITHE_TRY_OR(done, lth_staggered_level_alloc(ctx, grid, coarse));
  if (fine->volume) LTH_NEW_OR(done, ctx, coarse->volume, grid->n_slots);
done:
  if (status != LITHE_OK) lth_staggered_level_free(ctx, coarse);
  return status;
}

/// Averaged coefficients and held faces; all others are dead.
static LitheStatus average_level(LitheCtx *ctx, const LthStaggeredLevel *fine,
                                 LthStaggeredLevel *coarse) {
  const int side = coarse->grid->side;
  LitheIndex *plain;
  LITHE_TRY(list_plain(ctx, fine, &plain));
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheCount s = 0; s < coarse->grid->n_slots; s += side) average_row(fine, plain, coarse, s);
  lth_free(ctx, plain);
  return LITHE_OK;
}

LitheStatus lth_staggered_coarsen(LitheCtx *ctx, const LthStaggeredLevel *fine,
                                  LthSparseGrid **grid, LthStaggeredLevel *coarse) {
  LitheStatus status = LITHE_OK;
  LITHE_TRY_OR(done, coarse_grid(ctx, fine, grid));
  LITHE_TRY_OR(done, alloc_like(ctx, fine, *grid, coarse));
  LITHE_TRY_OR(done, average_level(ctx, fine, coarse));
  lth_staggered_rule_a(ctx, coarse);
  LITHE_TRY_OR(done, lth_staggered_walls_coarsen(ctx, fine, coarse));
done:
  if (status != LITHE_OK) {
    lth_staggered_level_free(ctx, coarse);
    lth_sparse_grid_destroy(ctx, grid);
  }
  return status;
}
