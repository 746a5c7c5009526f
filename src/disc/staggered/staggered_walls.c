/// Where held sides begin, carried from level to level: a coarse difference is taken over the way that fine ones leave.
#include "disc/staggered/staggered_walls.h"

#include <math.h>

#define FARTHEST 4 // fine steps after which no wall is looked for

static int place_of(int a, int b) {
  const int e = 3 - a - b;
  return a == b ? a : (e + 1) % 3 == a ? 3 + 2 * e : 4 + 2 * e;
}

/// Is one of the two unknowns of the difference of component a along b held, the other not? `low` is that with the lower place.
static bool differs(const LthStaggeredLevel *l, int a, int b, LitheCount slot,
                    const LitheIndex cell[3], bool *low_is_held) {
  const LitheCount other = lth_sparse_grid_along(l->grid, cell, b, a == b ? 1 : -1);
  const bool here = lth_level_state(l, a, slot) == LTH_UNKNOWN_HELD,
             there = lth_level_state(l, a, other) == LTH_UNKNOWN_HELD;
  *low_is_held = a == b ? here : there;
  return here != there;
}

static bool differs_anywhere(const LthStaggeredLevel *l, LitheCount slot) {
  LitheIndex cell[3];
  bool low;
  lth_sparse_grid_cell(l->grid, slot, cell);
  for (int a = 0; a < l->grid->dim; a++)
    for (int b = 0; b < l->grid->dim; b++)
      if (differs(l, a, b, slot, cell, &low)) return true;
  return false;
}

/// Blocks with a held unknown in them or beside them.
static bool is_near_held(const LthSparseGrid *g, const uint8_t *held, LitheIndex block) {
  const LitheIndex *to = g->neighbor + (LitheCount)block * g->n_neighbors;
  for (int i = 0; i < g->n_neighbors; i++)
    if (to[i] >= 0 && held[to[i]]) return true;
  return false;
}

static bool holds_any(const LthStaggeredLevel *l, LitheIndex block) {
  const LitheCount first = (LitheCount)block * l->grid->block_cells;
  for (int a = 0; a < l->grid->dim; a++)
    for (LitheCount s = first; s < first + l->grid->block_cells; s++)
      if (l->state[a][s] == LTH_UNKNOWN_HELD) return true;
  return false;
}

/// Count the walls of a block, or (`to`) write their slots.
static LitheIndex list_block(const LthStaggeredLevel *l, LitheIndex block, LthStaggeredWall *to) {
  const LitheCount first = (LitheCount)block * l->grid->block_cells;
  LitheIndex n = 0;
  for (LitheCount s = first; s < first + l->grid->block_cells; s++) {
    if (!differs_anywhere(l, s)) continue;
    if (to) to[n].slot = s;
    n++;
  }
  return n;
}

LitheStatus lth_staggered_walls_create(LitheCtx *ctx, const LthStaggeredLevel *l,
                                       LthStaggeredWalls **walls) {
  LitheStatus status = LITHE_OK;
  const LthSparseGrid *g = l->grid;
  uint8_t *held = NULL;
  *walls = NULL;
  LTH_NEW_OR(done, ctx, held, g->n_blocks);
  LTH_NEW_OR(done, ctx, *walls, 1);
  LTH_NEW_OR(done, ctx, (*walls)->first, (LitheCount)g->n_blocks + 1);
  LitheIndex *first = (*walls)->first;
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheIndex b = 0; b < g->n_blocks; b++) held[b] = holds_any(l, b);
#pragma omp parallel for schedule(dynamic, 4) num_threads(lth_threads(ctx))
  for (LitheIndex b = 0; b < g->n_blocks; b++)
    first[b + 1] = is_near_held(g, held, b) ? list_block(l, b, NULL) : 0;
  for (LitheIndex b = 0; b < g->n_blocks; b++) first[b + 1] += first[b];
  LTH_NEW_OR(done, ctx, (*walls)->at, first[g->n_blocks]);
#pragma omp parallel for schedule(dynamic, 4) num_threads(lth_threads(ctx))
  for (LitheIndex b = 0; b < g->n_blocks; b++)
    if (first[b + 1] > first[b]) list_block(l, b, (*walls)->at + first[b]);
done:
  lth_free(ctx, held);
  if (status != LITHE_OK) lth_staggered_walls_destroy(ctx, walls);
  return status;
}

void lth_staggered_walls_destroy(LitheCtx *ctx, LthStaggeredWalls **walls) {
  if (!*walls) return;
  lth_free(ctx, (*walls)->first);
  lth_free(ctx, (*walls)->at);
  lth_free(ctx, *walls);
  *walls = NULL;
}

LitheCount lth_staggered_walls_bytes(const LthSparseGrid *g, const LthStaggeredWalls *walls) {
  if (!walls) return 0;
  return (LitheCount)sizeof *walls + 4 * ((LitheCount)g->n_blocks + 1) +
         (LitheCount)sizeof *walls->at * walls->first[g->n_blocks];
}

/// The wall at a slot, or NULL.
static const LthStaggeredWall *find(const LthStaggeredLevel *l, LitheCount slot) {
  if (!l->walls || slot < 0) return NULL;
  const LitheCount block = slot / l->grid->block_cells;
  LitheIndex low = l->walls->first[block], high = l->walls->first[block + 1];
  while (low < high) {
    const LitheIndex middle = low + (high - low) / 2;
    const LitheCount at = l->walls->at[middle].slot;
    if (at == slot) return &l->walls->at[middle];
    if (at < slot)
      low = middle + 1;
    else
      high = middle;
  }
  return NULL;
}

static LthWallCuts cuts_of(const LthStaggeredWall *wall, int dim, int edge) {
  LthWallCuts c = {0};
  const int first = edge < 0 ? 0 : 3 + 2 * edge, n = edge < 0 ? dim : 2;
  for (int i = first; i < first + n; i++)
    if (wall->way[i] > 0) lth_wall_cut(&c, wall->way[i]);
  return c;
}

LthWallCuts lth_staggered_wall_cuts(const LthStaggeredLevel *l, LitheCount slot, int edge) {
  const LthStaggeredWall *wall = find(l, slot);
  return wall ? cuts_of(wall, l->grid->dim, edge) : (LthWallCuts){0};
}

double lth_staggered_wall_way(const LthStaggeredLevel *l, int a, int b, const LitheIndex from[3],
                              const LitheIndex to[3]) {
  const LitheIndex *at = (a == b) == (from[b] < to[b]) ? from : to;
  const LthStaggeredWall *wall = find(l, lth_sparse_grid_slot(l->grid, at[0], at[1], at[2]));
  const double way = wall ? wall->way[place_of(a, b)] : 0;
  return way > 0 ? way : 1;
}

double lth_staggered_wall_distance(const LthStaggeredLevel *l, int a, const LitheIndex cell[3]) {
  double sum = 0;
  for (int b = 0; b < l->grid->dim; b++) {
    double least = INFINITY;
    for (int to = -1; to <= 1; to += 2) {
      LitheIndex at[3] = {cell[0], cell[1], cell[2]}, next[3] = {cell[0], cell[1], cell[2]};
      int state = LTH_UNKNOWN_FREE;
      for (int step = 0; step < FARTHEST && state == LTH_UNKNOWN_FREE; step++, at[b] += to) {
        next[b] = at[b] + to;
        state = lth_level_state(l, a, lth_sparse_grid_slot(l->grid, next[0], next[1], next[2]));
        if (state == LTH_UNKNOWN_HELD)
          least = fmin(least, step + lth_staggered_wall_way(l, a, b, at, next));
      }
    }
    sum += 1 / (least * least);
  }
  return sum > 0 ? 1 / sqrt(sum) : 0;
}

/// Fine cells from where a coarse unknown is, in one of the lines of fine ones that it stands for, to what is held; -1: it is not near.
static double way_along(const LthStaggeredLevel *l, int a, int b, LitheIndex at[3], int to) {
  double way = a == b ? 0 : 0.5;
  int state = lth_level_state(l, a, lth_sparse_grid_slot(l->grid, at[0], at[1], at[2]));
  if (a != b &&
      state == LTH_UNKNOWN_HELD) { // the wall is between this one and the other of the pair
    LitheIndex other[3] = {at[0], at[1], at[2]};
    other[b] -= to;
    if (lth_level_state(l, a, lth_sparse_grid_slot(l->grid, other[0], other[1], other[2])) !=
        LTH_UNKNOWN_FREE)
      return -1;
    return lth_staggered_wall_way(l, a, b, other, at) - 0.5;
  }
  if (state != LTH_UNKNOWN_FREE) return -1;
  for (int step = 0; step < FARTHEST; step++) {
    LitheIndex next[3] = {at[0], at[1], at[2]};
    next[b] += to;
    state = lth_level_state(l, a, lth_sparse_grid_slot(l->grid, next[0], next[1], next[2]));
    if (state == LTH_UNKNOWN_HELD) return way + lth_staggered_wall_way(l, a, b, at, next);
    if (state == LTH_UNKNOWN_DEAD) return -1;
    at[b] = next[b];
    way++;
  }
  return -1;
}

/// The way from the free coarse unknown of a cell along b to what is held, in coarse cells: the mean of the lines.
static double coarse_way(const LthStaggeredLevel *fine, int a, int b, const LitheIndex cell[3],
                         int to) {
  double sum = 0;
  int n = 0;
  for (int q = 0; q < 8; q++) {
    LitheIndex at[3];
    bool counts = true;
    for (int d = 0; d < 3; d++) {
      const bool is_side = d != a && d != b && d < fine->grid->dim;
      at[d] = d < fine->grid->dim ? 2 * cell[d] + (is_side && (q >> d & 1)) : 0;
      counts &= is_side || !(q >> d & 1);
    }
    if (!counts) continue;
    if (a != b) at[b] += to > 0;
    const double way = way_along(fine, a, b, at, to);
    if (way > -1) sum += way, n++;
  }
  return n > 0 ? fmax(0.5 * sum / n, LTH_WALL_SHORTEST) : 1;
}

static void find_ways(const LthStaggeredLevel *fine, const LthStaggeredLevel *coarse,
                      LthStaggeredWall *wall) {
  LitheIndex cell[3];
  lth_sparse_grid_cell(coarse->grid, wall->slot, cell);
  for (int a = 0; a < coarse->grid->dim; a++)
    for (int b = 0; b < coarse->grid->dim; b++) {
      bool low_is_held;
      if (!differs(coarse, a, b, wall->slot, cell, &low_is_held)) continue;
      LitheIndex from[3] = {cell[0], cell[1], cell[2]};
      from[b] += a == b ? low_is_held : !low_is_held ? -1 : 0;
      if (lth_level_state(coarse, a,
                          lth_sparse_grid_slot(coarse->grid, from[0], from[1], from[2])) ==
          LTH_UNKNOWN_FREE)
        wall->way[place_of(a, b)] = (float)coarse_way(fine, a, b, from, low_is_held ? -1 : 1);
    }
}

static void stiffen(LthStaggeredLevel *l, const LthStaggeredWall *wall) {
  const LthWallCuts c = cuts_of(wall, l->grid->dim, -1);
  const double factor = lth_wall_factor(&c);
  l->lambda[wall->slot] *= factor;
  l->mu[wall->slot] *= factor;
  for (int e = 0; e < 3; e++) {
    if (!l->shear[e]) continue;
    const LthWallCuts cut = cuts_of(wall, l->grid->dim, e);
    l->shear[e][wall->slot] *= lth_wall_factor(&cut);
  }
}

LitheStatus lth_staggered_walls_coarsen(LitheCtx *ctx, const LthStaggeredLevel *fine,
                                        LthStaggeredLevel *coarse) {
  LITHE_TRY(lth_staggered_walls_create(ctx, coarse, &coarse->walls));
  LthStaggeredWalls *w = coarse->walls;
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheIndex i = 0; i < w->first[coarse->grid->n_blocks]; i++) {
    find_ways(fine, coarse, &w->at[i]);
    stiffen(coarse, &w->at[i]);
  }
  return LITHE_OK;
}
