/// Levels of the mixed form: coefficients over slots, neighbours, and what joins a level to the next.
#include "disc/staggered/staggered_mixed.h"
#include "disc/staggered/staggered_slot.h"

#include <string.h>

/// Slot of the neighbour one cell along an axis, or n.
static LitheIndex neighbor_of(const LthSparseGrid *g, LitheCount slot, int axis, int step) {
  static const int block_step[3] = {1, 3, 9};
  LitheIndex local = (LitheIndex)(slot % g->block_cells), stride = 1;
  LitheCount block = slot / g->block_cells;
  for (int a = 0; a < axis; a++) stride *= g->side;
  LitheIndex at = local / stride % g->side + step;
  if (at >= 0 && at < g->side) return (LitheIndex)(slot + step * stride);
  LitheIndex to =
      g->neighbor[block * g->n_neighbors + g->n_neighbors / 2 + step * block_step[axis]];
  if (to < 0) return (LitheIndex)g->n_slots;
  return (LitheIndex)((LitheCount)to * g->block_cells + local - step * (g->side - 1) * stride);
}

static void find_neighbors(LthMixedLevel *l, int threads) {
  for (int k = 0; k < 2 * l->dim; k++) {
    l->next[k][l->n] = (LitheIndex)l->n;
#pragma omp parallel for schedule(static) num_threads(threads)
    for (LitheCount c = 0; c < l->n; c++)
      l->next[k][c] = neighbor_of(l->grid, c, k / 2, k % 2 ? 1 : -1);
  }
}

LitheStatus lth_mixed_level_allocate(LitheCtx *ctx, LthMixedLevel *l, bool has_mass) {
  const LthSparseGrid *g = l->grid;
  if (g->n_slots >= INT32_MAX - 16)
    LITHE_FAIL(ctx, LITHE_BAD_INPUT,
               "the mixed form: the grid has %lld cells in its blocks, at most %d can be numbered: "
               "take larger cells",
               (long long)g->n_slots, INT32_MAX - 16);
  l->dim = g->dim;
  l->n = g->n_slots;
  l->stride = (l->n + 8) / 8 * 8;
  for (int a = 0; a < 3; a++) l->per_h[a] = 1 / g->h[a];
  for (int k = 0; k < 2 * l->dim; k++) LTH_NEW(ctx, l->next[k], l->n + 1);
  LTH_NEW(ctx, l->mu, l->n + 1);
  LTH_NEW(ctx, l->volume, l->n + 1);
  LTH_NEW(ctx, l->compliance, l->n + 1);
  LTH_NEW(ctx, l->flags, l->n + 1);
  for (int a = 0; a < l->dim; a++) {
    if (has_mass) LTH_NEW(ctx, l->mass[a], l->n + 1);
    LTH_NEW(ctx, l->weight[a], l->n + 1);
  }
  for (int e = l->dim == 3 ? 0 : 2; e < 3; e++) LTH_NEW(ctx, l->shear[e], l->n + 1);
  LTH_NEW(ctx, l->share, l->n + 1);
  LTH_NEW(ctx, l->x, lth_mixed_size(l));
  LTH_NEW(ctx, l->b, lth_mixed_size(l));
  LTH_NEW(ctx, l->r, lth_mixed_size(l));
  find_neighbors(l, lth_threads(ctx));
  return LITHE_OK;
}

void lth_mixed_level_free(LitheCtx *ctx, LthMixedLevel *l) {
  for (int k = 0; k < 6; k++) lth_free(ctx, l->next[k]);
  for (int a = 0; a < 3; a++) {
    lth_free(ctx, l->shear[a]);
    lth_free(ctx, l->mass[a]);
    lth_free(ctx, l->spring[a]);
    lth_free(ctx, l->weight[a]);
    lth_free(ctx, l->face[a][0]);
    lth_free(ctx, l->face[a][1]);
  }
  void *blocks[] = {l->mu,      l->share,   l->volume,  l->compliance, l->flags,   l->cell[0],
                    l->cell[1], l->near[0], l->near[1], l->box,        l->inverse, l->parent,
                    l->child,   l->x,       l->b,       l->r};
  for (size_t i = 0; i < sizeof blocks / sizeof blocks[0]; i++) lth_free(ctx, blocks[i]);
  memset(l, 0, sizeof *l);
}

/// A pressure acts where some face of its cell is free.
static void find_pressures(LthMixedLevel *l) {
  for (LitheCount c = 0; c < l->n; c++) {
    bool any = false;
    for (int a = 0; a < l->dim; a++)
      any |= ((l->flags[c] | l->flags[l->next[2 * a + 1][c]]) & LTH_MIXED_FREE << a) != 0;
    if (any && l->volume[c] > 0) l->flags[c] |= LTH_MIXED_PRESSURE;
  }
}

static void copy(LthMixedLevel *l, const LthStaggeredLevel *from) {
  for (LitheCount c = 0; c < l->n; c++) {
    l->mu[c] = from->mu[c];
    l->volume[c] = from->volume[c];
    l->compliance[c] = from->compliance[c];
    for (int e = 0; e < 3; e++)
      if (l->shear[e]) l->shear[e][c] = from->shear[e][c];
    for (int a = 0; a < l->dim; a++) {
      if (from->state[a][c] == LTH_UNKNOWN_FREE) l->flags[c] |= LTH_MIXED_FREE << a;
      if (from->state[a][c] == LTH_UNKNOWN_HELD) l->flags[c] |= LTH_MIXED_HELD << a;
    }
  }
}

/// A strip of single cells has no shear sample, so that its faces would slide: on coarse levels, where features
/// may be as thin, such a face is tied to where it is.
static void tie_strips(LthMixedLevel *l) {
  for (LitheIndex c = 0; c < l->n; c++)
    for (int a = 0; a < l->dim; a++) {
      if (!(l->flags[c] & LTH_MIXED_FREE << a)) continue;
      for (int b = 0; b < l->dim; b++) {
        if (b == a) continue;
        const double *shear = l->shear[3 - a - b];
        if (shear[c] > 0 || shear[l->next[2 * b + 1][c]] > 0) continue;
        l->mass[a][c] += 0.01 * (l->mu[c] + l->mu[l->next[2 * a][c]]) * l->per_h[b] * l->per_h[b];
      }
    }
}

static void set_masses(LthMixedLevel *l, const LthStaggeredLevel *from, double inertia,
                       bool is_coarse) {
  for (int a = 0; a < l->dim && l->mass[a]; a++)
    for (LitheCount c = 0; c < l->n; c++)
      l->mass[a][c] = inertia * from->mass[a][c] + (l->spring[a] ? l->spring[a][c] : 0);
  if (is_coarse) tie_strips(l);
}

void lth_mixed_level_update(LitheCtx *ctx, const LthStaggeredLevel *from, double cm, double ck,
                            bool is_coarse, LthMixedLevel *l) {
  set_masses(l, from, cm / ck, is_coarse);
  lth_mixed_invert_boxes(ctx, l, NULL);
}

LitheStatus lth_mixed_level_stiffen(LitheCtx *ctx, const LthStaggeredLevel *from, double inertia,
                                    bool is_coarse, LthMixedLevel *l, bool *changed) {
  *changed = false;
  for (int a = 0; a < l->dim; a++) {
    if (!l->spring[a]) LTH_NEW(ctx, l->spring[a], l->n + 1);
    if (!l->mass[a]) LTH_NEW(ctx, l->mass[a], l->n + 1);
    double *mark = l->r + a * l->stride;
    for (LitheCount c = 0; c < l->n; c++) {
      const float now = (float)mark[c];
      mark[c] = now != l->spring[a][c];
      *changed |= now != l->spring[a][c];
      l->spring[a][c] = now;
    }
  }
  if (!*changed) return LITHE_OK;
  set_masses(l, from, inertia, is_coarse);
  lth_mixed_invert_boxes(ctx, l, l->r);
  return LITHE_OK;
}

LitheStatus lth_mixed_level_create(LitheCtx *ctx, const LthStaggeredLevel *from, double cm,
                                   double ck, bool is_coarse, LthMixedLevel *l) {
  l->grid = from->grid;
  LITHE_TRY(lth_mixed_level_allocate(ctx, l, cm != 0 || is_coarse));
  copy(l, from);
  set_masses(l, from, cm / ck, is_coarse);
  find_pressures(l);
  return lth_mixed_level_sort(ctx, l);
}

LitheStatus lth_mixed_link(LitheCtx *ctx, LthMixedLevel *fine, LthMixedLevel *coarse) {
  const int parts = 1 << fine->dim;
  LTH_NEW(ctx, fine->parent, fine->n + 1);
  LTH_NEW(ctx, coarse->child, (coarse->n + 1) * parts);
  for (LitheCount i = 0; i < (coarse->n + 1) * parts; i++) coarse->child[i] = (LitheIndex)fine->n;
  fine->parent[fine->n] = (LitheIndex)coarse->n;
  for (LitheCount slot = 0; slot < fine->n; slot++) {
    LitheIndex c[3];
    lth_cell_of(fine->grid, slot, c);
    LitheCount to = lth_slot_of(coarse->grid, c[0] / 2, c[1] / 2, c[2] / 2);
    fine->parent[slot] = (LitheIndex)(to < 0 ? coarse->n : to);
    if (to < 0) continue;
    int part = (c[0] & 1) | (c[1] & 1) << 1 | (fine->dim == 3 ? (c[2] & 1) << 2 : 0);
    coarse->child[to * parts + part] = (LitheIndex)slot;
  }
  lth_mixed_weigh(fine, coarse);
  return LITHE_OK;
}
