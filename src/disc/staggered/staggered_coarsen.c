/// One level of a staggered grid from the next finer one: averaged coefficients, rule A again.
/// Zhu, Sifakis, Teran, Brandt 2010; docs/theory/staggered-multigrid.md.
#include "disc/staggered/staggered_hierarchy.h"
#include "disc/staggered/staggered_slot.h"
#include "disc/staggered/staggered_walls.h"

#include <math.h>
#include <string.h>

static int state_at(const uint8_t *state, LitheCount slot) {
  return slot < 0 ? LTH_UNKNOWN_DEAD : state[slot];
}

static bool is_solid(const LthStaggeredLevel *l, LitheCount slot) {
  return lth_level_value(l, l->mu, slot) > 0 || lth_level_value(l, l->lambda, slot) > 0;
}

/// Cells of a block that hold something: lowest and highest, or false.
static bool solid_box(const LthStaggeredLevel *l, LitheIndex block, LitheIndex low[3],
                      LitheIndex high[3]) {
  const LthSparseGrid *g = l->grid;
  bool any = false;
  LitheCount first = (LitheCount)block * g->block_cells;
  for (LitheCount s = first; s < first + g->block_cells; s++) {
    if (!is_solid(l, s)) continue;
    LitheIndex c[3];
    lth_cell_of(g, s, c);
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
  int bits = lth_side_bits(fine);
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

/// Low and high (inclusive) fine cells under a coarse box: that of a cell, and shifted by half a coarse cell towards
/// lower places along the axes in `shifted`.
static void fine_box(int dim, const LitheIndex cell[3], int shifted, LitheIndex low[3],
                     LitheIndex high[3]) {
  for (int a = 0; a < 3; a++) {
    bool flat = dim == 2 && a == 2;
    low[a] = flat ? 0 : 2 * cell[a] - (shifted >> a & 1);
    high[a] = flat ? 0 : low[a] + 1;
  }
}

/// No face of a cell is free and some are held: it cannot deform, and says nothing of the body before it.
static bool is_beyond(const LthStaggeredLevel *l, const LitheIndex cell[3]) {
  bool held = false;
  for (int a = 0; a < l->grid->dim; a++)
    for (int high = 0; high < 2; high++) {
      const int state = state_at(l->state[a], lth_slot_along(l->grid, cell, a, high));
      if (state == LTH_UNKNOWN_FREE) return false;
      held |= state == LTH_UNKNOWN_HELD;
    }
  return held;
}

/// Mean of cell values over such a box, of what can deform if something can, as if there were no walls.
static double box_mean(const LthStaggeredLevel *fine, const double *v, const LitheIndex cell[3],
                       int shifted) {
  LitheIndex low[3], high[3], c[3];
  fine_box(fine->grid->dim, cell, shifted, low, high);
  double sum = 0, beyond = 0;
  int n = 0, n_beyond = 0;
  for (c[2] = low[2]; c[2] <= high[2]; c[2]++)
    for (c[1] = low[1]; c[1] <= high[1]; c[1]++)
      for (c[0] = low[0]; c[0] <= high[0]; c[0]++, n++) {
        const LitheCount s = lth_slot_of(fine->grid, c[0], c[1], c[2]);
        if (is_beyond(fine, c)) {
          n_beyond++;
          beyond += lth_level_value(fine, v, s);
        } else if (lth_level_value(fine, v, s) != 0) {
          const LthWallCuts cuts = lth_staggered_wall_cuts(fine, s, -1);
          sum += lth_level_value(fine, v, s) / (v == fine->volume ? 1 : lth_wall_factor(&cuts));
        }
      }
  return n_beyond < n ? sum / (n - n_beyond) : beyond / n;
}

/// Compliance of a coarse cell whose pressure stands for pressures in proportion to the stiffness of finer cells:
/// one that jumps with mu would otherwise be thrown onto the soft side.
static double compliance_mean(const LthStaggeredLevel *fine, const LthStaggeredLevel *coarse,
                              const LitheIndex cell[3], LitheCount to) {
  LitheIndex low[3], high[3];
  const double mu = coarse->volume[to] > 0 ? coarse->mu[to] / coarse->volume[to] : 1;
  double sum = 0;
  fine_box(fine->grid->dim, cell, 0, low, high);
  for (LitheIndex k = low[2]; k <= high[2]; k++)
    for (LitheIndex j = low[1]; j <= high[1]; j++)
      for (LitheIndex i = low[0]; i <= high[0]; i++) {
        LitheCount s = lth_slot_of(fine->grid, i, j, k);
        if (s < 0 || !(fine->volume[s] > 0)) continue;
        const LthWallCuts cuts = lth_staggered_wall_cuts(fine, s, -1);
        const double factor = lth_wall_factor(&cuts);
        double part = fine->mu[s] / factor / fine->volume[s] / mu;
        sum += part * part * fine->compliance[s] * factor;
      }
  return sum / (fine->grid->dim == 3 ? 8 : 4);
}

/// Mass of a coarse face: fine faces in it, and half of those a fine cell to both sides. Held ones may have less than
/// none (staggered_beyond.c).
static double face_mass(const LthStaggeredLevel *fine, const LitheIndex cell[3], int a) {
  static const double along[3] = {0.25, 0.5, 0.25};
  LitheIndex low[3], high[3];
  fine_box(fine->grid->dim, cell, 0, low, high);
  double sum = 0;
  for (int s = 0; s < 3; s++) {
    low[a] = high[a] = 2 * cell[a] + s - 1;
    for (LitheIndex k = low[2]; k <= high[2]; k++)
      for (LitheIndex j = low[1]; j <= high[1]; j++)
        for (LitheIndex i = low[0]; i <= high[0]; i++)
          sum += along[s] *
                 fmax(0, lth_level_value(fine, fine->mass[a], lth_slot_of(fine->grid, i, j, k)));
  }
  return sum / (fine->grid->dim == 3 ? 4 : 2);
}

/// A fine face on a coarse one's plane is held; or it is dead and the next one, which no coarse plane meets, is held:
/// there the body ends half a coarse cell before.
static bool column_is_held(const LthStaggeredLevel *fine, const LitheIndex cell[3], int a) {
  const uint8_t *state = fine->state[a];
  int here = state_at(state, lth_slot_of(fine->grid, cell[0], cell[1], cell[2]));
  if (here != LTH_UNKNOWN_DEAD) return here == LTH_UNKNOWN_HELD;
  return state_at(state, lth_slot_along(fine->grid, cell, a, 1)) == LTH_UNKNOWN_HELD ||
         state_at(state, lth_slot_along(fine->grid, cell, a, -1)) == LTH_UNKNOWN_HELD;
}

/// How far the fine face of a cell is before a wall, in cells; behind it less than 0. Neighbours beside it in the coarse face tell.
static double before_wall(const LthStaggeredLevel *fine, const LitheIndex cell[3], int a) {
  const bool held = column_is_held(fine, cell, a);
  double before = held ? -1 : 1.5;
  for (int b = 0; b < fine->grid->dim; b++) {
    if (b == a) continue;
    LitheIndex beside[3] = {cell[0], cell[1], cell[2]};
    beside[b] ^= 1;
    const int state =
        state_at(fine->state[a], lth_slot_of(fine->grid, beside[0], beside[1], beside[2]));
    if (held && state == LTH_UNKNOWN_FREE)
      before = fmax(before, lth_staggered_wall_way(fine, a, b, beside, cell) - 1);
    if (!held && state == LTH_UNKNOWN_HELD)
      before = fmin(before, lth_staggered_wall_way(fine, a, b, cell, beside));
  }
  return before;
}

/// Are the other components held beside the held fine face of a cell, too?
static bool is_clamped(const LthStaggeredLevel *fine, const LitheIndex cell[3], int a) {
  for (int b = 0; b < fine->grid->dim; b++) {
    bool held = b == a;
    for (int q = 0; q < 4 && !held; q++) { // the faces across b at both cells of this face
      LitheIndex at[3] = {cell[0], cell[1], cell[2]};
      at[a] -= q & 1;
      at[b] += q >> 1;
      held = state_at(fine->state[b], lth_slot_of(fine->grid, at[0], at[1], at[2])) ==
             LTH_UNKNOWN_HELD;
    }
    if (!held) return false;
  }
  return true;
}

/// Does the held fine face of a cell hold what nothing behind it would hold on the coarse level, where it shares a coarse face with a free one?
static bool holds_alone(const LthStaggeredLevel *fine, const LitheIndex cell[3], int a) {
  for (int b = 0; b < fine->grid->dim; b++) {
    if (b == a) continue;
    const int away = cell[b] & 1 ? 1 : -1; // from the other face of the pair
    int state[3];
    for (int k = 0; k < 3; k++) {
      LitheIndex at[3] = {cell[0], cell[1], cell[2]};
      at[b] += away * (k == 0 ? -1 : k);
      state[k] = state_at(fine->state[a], lth_slot_of(fine->grid, at[0], at[1], at[2]));
    }
    if (state[0] == LTH_UNKNOWN_FREE &&
        (state[1] != LTH_UNKNOWN_HELD || state[2] == LTH_UNKNOWN_FREE))
      return true;
  }
  return false;
}

/// Is what a held fine face holds sure to be held on the coarse level, too, where this face is given up? Holds of some components
/// may be as thin as one face: where the middle of a coarse face missed them, the coarse level would have a motion that nothing holds.
static bool is_thick(const LthStaggeredLevel *fine, const LitheIndex cell[3], int a) {
  return is_clamped(fine, cell, a) && !holds_alone(fine, cell, a);
}

/// Is the middle of the fine faces that make up a coarse one behind a wall? One held face is enough where a hold is thin, and in
/// the mixed form: where stiffness jumps its smoother does not bear corrections that are cut.
static bool face_is_held(const LthStaggeredLevel *fine, const LitheIndex cell[3], int a) {
  LitheIndex low[3], high[3], c[3];
  bool any = false, thick = true;
  double before = 0;
  fine_box(fine->grid->dim, cell, 0, low, high);
  high[a] = low[a];
  for (c[2] = low[2]; c[2] <= high[2]; c[2]++)
    for (c[1] = low[1]; c[1] <= high[1]; c[1]++)
      for (c[0] = low[0]; c[0] <= high[0]; c[0]++) {
        if (!column_is_held(fine, c, a)) continue;
        any = true;
        thick &= is_thick(fine, c, a);
      }
  if (!any || !thick || fine->compliance) return any;
  for (c[2] = low[2]; c[2] <= high[2]; c[2]++)
    for (c[1] = low[1]; c[1] <= high[1]; c[1]++)
      for (c[0] = low[0]; c[0] <= high[0]; c[0]++) before += before_wall(fine, c, a);
  return before <= 0;
}

static void average_slot(const LthStaggeredLevel *fine, LthStaggeredLevel *coarse, LitheCount s) {
  const LthSparseGrid *g = fine->grid;
  LitheIndex cell[3];
  lth_cell_of(coarse->grid, s, cell);
  coarse->lambda[s] = box_mean(fine, fine->lambda, cell, 0);
  coarse->mu[s] = box_mean(fine, fine->mu, cell, 0);
  if (fine->volume) coarse->volume[s] = box_mean(fine, fine->volume, cell, 0);
  if (fine->compliance) coarse->compliance[s] = compliance_mean(fine, coarse, cell, s);
  for (int e = 0; e < 3; e++)
    if (coarse->shear[e]) coarse->shear[e][s] = box_mean(fine, fine->mu, cell, 7 & ~(1 << e));
  for (int a = 0; a < g->dim; a++) {
    coarse->mass[a][s] = face_mass(fine, cell, a);
    coarse->state[a][s] = face_is_held(fine, cell, a) ? LTH_UNKNOWN_HELD : LTH_UNKNOWN_DEAD;
  }
}

/// Free where a face touches a cell that holds something.
static void revive(LthStaggeredLevel *l, LitheCount s) {
  LitheIndex cell[3];
  lth_cell_of(l->grid, s, cell);
  for (int a = 0; a < l->grid->dim; a++) {
    if (l->state[a][s] == LTH_UNKNOWN_HELD) continue;
    bool alive = is_solid(l, s) || is_solid(l, lth_slot_along(l->grid, cell, a, -1));
    l->state[a][s] = alive ? LTH_UNKNOWN_FREE : LTH_UNKNOWN_DEAD;
    if (!alive) l->mass[a][s] = 0;
  }
}

/// True where one of the four faces around an edge along axis e is dead.
static bool edge_is_dead(const LthStaggeredLevel *l, LitheCount s, const LitheIndex cell[3],
                         int e) {
  int a = (e + 1) % 3, b = (e + 2) % 3;
  return !l->state[a][s] || !l->state[b][s] ||
         !state_at(l->state[a], lth_slot_along(l->grid, cell, b, -1)) ||
         !state_at(l->state[b], lth_slot_along(l->grid, cell, a, -1));
}

void lth_staggered_rule_a(LitheCtx *ctx, LthStaggeredLevel *l) {
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheCount s = 0; s < l->grid->n_slots; s++) revive(l, s);
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheCount s = 0; s < l->grid->n_slots; s++) {
    LitheIndex cell[3];
    lth_cell_of(l->grid, s, cell);
    for (int e = 0; e < 3; e++)
      if (l->shear[e] && l->shear[e][s] != 0 && edge_is_dead(l, s, cell, e)) l->shear[e][s] = 0;
  }
}

LitheCount lth_staggered_count_free(LitheCtx *ctx, const LthStaggeredLevel *l) {
  LitheCount n = 0;
  for (int a = 0; a < l->grid->dim; a++) {
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx)) reduction(+ : n)
    for (LitheCount s = 0; s < l->grid->n_slots; s++) n += l->state[a][s] == LTH_UNKNOWN_FREE;
  }
  return n;
}

/// Arrays of a coarse level: the same ones that the fine level has.
static LitheStatus alloc_like(LitheCtx *ctx, const LthStaggeredLevel *fine,
                              const LthSparseGrid *grid, LthStaggeredLevel *coarse) {
  LitheStatus status = LITHE_OK;
  LITHE_TRY_OR(done, lth_staggered_level_alloc(ctx, grid, coarse));
  if (fine->volume) LTH_NEW_OR(done, ctx, coarse->volume, grid->n_slots);
  if (fine->compliance) LTH_NEW_OR(done, ctx, coarse->compliance, grid->n_slots);
done:
  if (status != LITHE_OK) lth_staggered_level_free(ctx, coarse);
  return status;
}

LitheStatus lth_staggered_coarsen(LitheCtx *ctx, const LthStaggeredLevel *fine,
                                  LthSparseGrid **grid, LthStaggeredLevel *coarse) {
  LITHE_TRY(coarse_grid(ctx, fine, grid));
  LitheStatus status = alloc_like(ctx, fine, *grid, coarse);
  if (status != LITHE_OK) {
    lth_sparse_grid_destroy(ctx, grid);
    return status;
  }
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheCount s = 0; s < coarse->grid->n_slots; s++) average_slot(fine, coarse, s);
  lth_staggered_rule_a(ctx, coarse);
  return lth_staggered_walls_coarsen(ctx, fine, coarse);
}
