/// Rule A on one level: which unknowns and shear samples live (docs/theory/staggered.md, "Rule A, and what hangs loose").
#include "disc/staggered/staggered_hierarchy.h"

/// Free where a face touches a cell that holds something.
static void revive(LthStaggeredLevel *l, LitheCount s) {
  LitheIndex cell[3];
  lth_sparse_grid_cell(l->grid, s, cell);
  for (int a = 0; a < l->grid->dim; a++) {
    if (l->state[a][s] == LTH_UNKNOWN_HELD) continue;
    bool alive = lth_level_is_live(l, s) ||
                 lth_level_is_live(l, lth_sparse_grid_along(l->grid, cell, a, -1));
    l->state[a][s] = alive ? LTH_UNKNOWN_FREE : LTH_UNKNOWN_DEAD;
    if (!alive) l->mass[a][s] = 0;
  }
}

/// True where one of the four faces around an edge along axis e is dead.
static bool edge_is_dead(const LthStaggeredLevel *l, LitheCount s, const LitheIndex cell[3],
                         int e) {
  int a = (e + 1) % 3, b = (e + 2) % 3;
  return !l->state[a][s] || !l->state[b][s] ||
         !lth_level_state(l, a, lth_sparse_grid_along(l->grid, cell, b, -1)) ||
         !lth_level_state(l, b, lth_sparse_grid_along(l->grid, cell, a, -1));
}

void lth_staggered_rule_a(LitheCtx *ctx, LthStaggeredLevel *l) {
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheCount s = 0; s < l->grid->n_slots; s++) revive(l, s);
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheCount s = 0; s < l->grid->n_slots; s++) {
    LitheIndex cell[3];
    lth_sparse_grid_cell(l->grid, s, cell);
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
