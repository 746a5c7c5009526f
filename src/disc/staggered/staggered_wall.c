/// Where a held side begins between two unknowns: a difference across it is taken over the way that is left, by the
/// stiffness of the samples that read it (docs/theory/staggered.md, "Held unknowns").
#include "disc/staggered/staggered_priv.h"
#include "disc/staggered/staggered_walls.h"

#define STEPS 10 // halvings of the way between two unknowns

/// Differences of a sample that a wall cuts.
typedef struct Cuts {
  LthWallCuts ways;
  double filled; ///< sum of the fractions of the samples on the other side of their free unknowns
} Cuts;

/// The first wall that holds component a at x.
static const LthStaggeredHold *find_wall(const LthStaggered *s, int a, const double x[3]) {
  for (LitheIndex k = 0; k < s->n_holds; k++) {
    const LthStaggeredHold *hold = &s->holds[k];
    if (hold->fixed[a] && hold->selects(hold->self, x)) return hold->is_wall ? hold : NULL;
  }
  return NULL;
}

/// Share of the way from the free unknown to the held one that is free; -1 where no wall holds it.
static double free_way(const LthStaggered *s, int a, LitheCount from, LitheCount to) {
  double x0[3], x1[3], x[3], low = 0, high = 1;
  lth_staggered_slot_place(s, from, a, x0);
  lth_staggered_slot_place(s, to, a, x1);
  const LthStaggeredHold *wall = find_wall(s, a, x1);
  if (!wall) return -1;
  for (int i = 0; i < STEPS; i++) {
    double middle = 0.5 * (low + high);
    for (int b = 0; b < 3; b++) x[b] = x0[b] + middle * (x1[b] - x0[b]);
    *(wall->selects(wall->self, x) ? &high : &low) = middle;
  }
  return fmax(high, LTH_WALL_SHORTEST);
}

/// Fraction of the box of a sample: of a cell where e is -1, else of an edge along axis e.
static double sample_fraction(const LthStaggered *s, const LthFractions *f, LitheCount slot,
                              int e) {
  int a = (e + 1) % 3, b = (e + 2) % 3;
  double sum = 0;
  if (slot < 0) return 0;
  if (e < 0) return lth_fractions_cell(f, slot);
  for (int q = 0; q < f->n_parts; q++) {
    int d[3] = {0};
    d[a] = -(q >> a & 1);
    d[b] = -(q >> b & 1);
    LitheCount cell = lth_sparse_grid_step(s->grid, slot, d);
    if (cell >= 0) sum += lth_fractions_part(f, cell, q);
  }
  return sum / f->n_parts;
}

/// Count the difference of component a along axis b that the sample at a slot reads, where one of its unknowns is held; returns
/// the share of the way that is free, or 0.
static double add_difference(const LthStaggered *s, int a, int b, int e, LitheCount sample,
                             LitheCount low, LitheCount high, Cuts *c) {
  const uint8_t *state = s->level.state[a];
  if (low < 0 || high < 0) return 0;
  bool held = state[high] == LTH_UNKNOWN_HELD;
  if (held == (state[low] == LTH_UNKNOWN_HELD)) return 0;
  double way = free_way(s, a, held ? low : high, held ? high : low);
  if (way < 0) return 0;
  int d[3] = {0};
  d[b] = held ? -1 : 1;
  lth_wall_cut(&c->ways, way);
  c->filled += sample_fraction(s, s->fractions, lth_sparse_grid_step(s->grid, sample, d), e);
  return way;
}

/// The sample stands for the way that is left. What is beyond the wall says nothing of how wide the body is there: the
/// sample next to it does, or where the body ends before it what of the sample is the body's own.
static double factor_of(const LthStaggered *s, LitheCount slot, int e, const Cuts *c,
                        double *filled) {
  double now = sample_fraction(s, s->fractions, slot, e);
  *filled = c->filled / c->ways.n;
  if (*filled == 0) *filled = sample_fraction(s, s->own ? s->own : s->fractions, slot, e);
  return now > 0 ? lth_wall_factor(&c->ways) * *filled / now : 0;
}

static void stiffen_cell(LthStaggered *s, const LitheIndex cell[3], LthStaggeredWall *wall) {
  LthStaggeredLevel *level = &s->level;
  const LitheCount slot = wall->slot;
  Cuts c = {0};
  double filled;
  for (int a = 0; a < s->dim; a++)
    wall->way[a] = (float)add_difference(s, a, a, -1, slot, slot,
                                         lth_sparse_grid_along(s->grid, cell, a, 1), &c);
  if (c.ways.n == 0) return;
  const double factor = factor_of(s, slot, -1, &c, &filled);
  level->lambda[slot] *= factor;
  level->mu[slot] *= factor;
  level->volume[slot] = filled;
}

static void stiffen_edge(LthStaggered *s, const LitheIndex cell[3], int e, LthStaggeredWall *wall) {
  const int a = (e + 1) % 3, b = (e + 2) % 3;
  const LitheCount slot = wall->slot;
  Cuts c = {0};
  double filled;
  wall->way[3 + 2 * e] = (float)add_difference(
      s, a, b, e, slot, lth_sparse_grid_along(s->grid, cell, b, -1), slot, &c);
  wall->way[4 + 2 * e] = (float)add_difference(
      s, b, a, e, slot, lth_sparse_grid_along(s->grid, cell, a, -1), slot, &c);
  if (c.ways.n > 0) s->level.shear[e][slot] *= factor_of(s, slot, e, &c, &filled);
}

LitheStatus lth_staggered_stiffen_walls(LitheCtx *ctx, LthStaggered *s) {
  bool any = false;
  for (LitheIndex k = 0; k < s->n_holds; k++) any |= s->holds[k].is_wall;
  if (!any || s->model != LTH_MATERIAL_LINEAR) return LITHE_OK;
  LITHE_TRY(lth_staggered_walls_create(ctx, &s->level, &s->level.walls));
  const LthStaggeredWalls *w = s->level.walls;
#pragma omp parallel for schedule(dynamic, 64) num_threads(lth_threads(ctx))
  for (LitheIndex i = 0; i < w->first[s->grid->n_blocks]; i++) {
    LthStaggeredWall *wall = &w->at[i];
    LitheIndex cell[3];
    lth_sparse_grid_cell(s->grid, wall->slot, cell);
    if (lth_level_is_live(&s->level, wall->slot)) stiffen_cell(s, cell, wall);
    for (int e = lth_staggered_first_edge(s); e < 3; e++)
      if (s->level.shear[e][wall->slot] > 0) stiffen_edge(s, cell, e, wall);
  }
  return LITHE_OK;
}
