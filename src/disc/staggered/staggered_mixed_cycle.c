/// Cycles of the mixed form over all levels, and what makes and frees these.
#include "disc/staggered/staggered_mixed.h"

#include <string.h>

static LitheStatus create(LitheCtx *ctx, const LthStaggeredLevel *from, double cm, double ck,
                          LthMixedGrid *g) {
  LITHE_TRY(lth_staggered_hierarchy_create(ctx, from, NULL, &g->hierarchy));
  g->pre = g->post = 1;
  for (int i = 0; i < g->hierarchy->n_levels; i++, g->n_levels++) {
    LITHE_TRY(lth_mixed_level_create(ctx, &g->hierarchy->level[i], cm, ck, i > 0, &g->level[i]));
    if (i > 0) LITHE_TRY(lth_mixed_link(ctx, &g->level[i - 1], &g->level[i]));
  }
  return lth_mixed_coarse_create(ctx, &g->level[g->n_levels - 1], &g->coarse);
}

LitheStatus lth_mixed_grid_create(LitheCtx *ctx, const LthStaggeredLevel *from, double cm,
                                  double ck, LthMixedGrid **grid) {
  LTH_NEW(ctx, *grid, 1);
  LitheStatus status = create(ctx, from, cm, ck, *grid);
  if (status != LITHE_OK) lth_mixed_grid_destroy(ctx, grid);
  return status;
}

LitheStatus lth_mixed_grid_update(LitheCtx *ctx, LthMixedGrid *g, double cm, double ck) {
  for (int i = 0; i < g->n_levels; i++)
    lth_mixed_level_update(ctx, &g->hierarchy->level[i], cm, ck, i > 0, &g->level[i]);
  return lth_mixed_coarse_update(ctx, g->coarse, &g->level[g->n_levels - 1]);
}

/// A face's spring holds what follows it: coarse springs are the transposed interpolation of fine ones, as masses are.
LitheStatus lth_mixed_grid_stiffen(LitheCtx *ctx, LthMixedGrid *g, double inertia) {
  bool changed = true;
  for (int i = 0; i < g->n_levels && changed; i++) {
    LthMixedLevel *l = &g->level[i], *next = i + 1 < g->n_levels ? &g->level[i + 1] : NULL;
    LITHE_TRY(lth_mixed_level_stiffen(ctx, &g->hierarchy->level[i], inertia, i > 0, l, &changed));
    if (!changed || !next) continue;
    memset(l->r, 0, sizeof *l->r * (size_t)lth_mixed_size(l));
    for (int a = 0; a < l->dim; a++)
      for (LitheCount c = 0; c < l->n; c++) l->r[a * l->stride + c] = l->spring[a][c];
    lth_mixed_restrict(l, next, lth_threads(ctx));
    memcpy(next->r, next->b, sizeof *next->r * (size_t)lth_mixed_size(next));
  }
  return changed ? lth_mixed_coarse_update(ctx, g->coarse, &g->level[g->n_levels - 1]) : LITHE_OK;
}

static LitheCount level_bytes(const LthMixedLevel *l) {
  const int dim = l->dim, m = 2 * dim + 1;
  LitheCount per_slot = 2 * dim * (LitheCount)sizeof(LitheIndex) + 1 + 4 * (dim + 1);
  per_slot += (LitheCount)sizeof(double) * (3 + (dim == 3 ? 3 : 1) + (l->mass[0] ? dim : 0));
  per_slot += (LitheCount)sizeof(float) * (l->spring[0] ? dim : 0);
  per_slot += (LitheCount)sizeof(double) * 3 * (dim + 1) + 2 * (LitheCount)sizeof(LitheIndex);
  LitheCount listed = l->box_off[LTH_MIXED_COLORS] * (LitheCount)(1 + m * m);
  for (int color = 0; color < 2; color++) {
    listed += l->n_cell[color] + l->n_near[color];
    for (int a = 0; a < dim; a++) listed += l->n_face[a][color];
  }
  return l->n * per_slot + listed * (LitheCount)sizeof(LitheIndex);
}

LitheCount lth_mixed_grid_bytes(const LthMixedGrid *g) {
  LitheCount bytes = lth_staggered_hierarchy_bytes(g->hierarchy);
  for (int i = 0; i < g->n_levels; i++) bytes += level_bytes(&g->level[i]);
  return bytes;
}

void lth_mixed_grid_destroy(LitheCtx *ctx, LthMixedGrid **grid) {
  if (!*grid) return;
  lth_mixed_coarse_destroy(ctx, &(*grid)->coarse);
  for (int i = 0; i < LTH_STAGGERED_MAX_LEVELS; i++) lth_mixed_level_free(ctx, &(*grid)->level[i]);
  lth_staggered_hierarchy_destroy(ctx, &(*grid)->hierarchy);
  lth_free(ctx, *grid);
  *grid = NULL;
}

static void restrict_residual(LthMixedGrid *g, int i, int threads) {
  LthMixedLevel *l = &g->level[i];
  lth_mixed_residual(l, threads, l->b, l->x, l->r);
  lth_mixed_restrict(l, &g->level[i + 1], threads);
}

/// A V-cycle from level i's x.
static LitheStatus descend(LitheCtx *ctx, LthMixedGrid *g, int i) {
  const int threads = lth_threads(ctx);
  LthMixedLevel *l = &g->level[i];
  if (i == g->n_levels - 1) return lth_mixed_coarse_solve(ctx, g->coarse, l);
  for (int k = 0; k < g->pre; k++) lth_mixed_smooth(l, threads);
  restrict_residual(g, i, threads);
  LthMixedLevel *next = &g->level[i + 1];
  memset(next->x, 0, sizeof *next->x * (size_t)lth_mixed_size(next));
  LITHE_TRY(descend(ctx, g, i + 1));
  lth_mixed_prolong(l, next, threads);
  for (int k = 0; k < g->post; k++) lth_mixed_smooth(l, threads);
  return LITHE_OK;
}

LitheStatus lth_mixed_cycle(LitheCtx *ctx, LthMixedGrid *g, bool full) {
  int first = full ? g->n_levels - 1 : 0;
  for (int i = 0; i <= first; i++) {
    LthMixedLevel *l = &g->level[i];
    memset(l->x, 0, sizeof *l->x * (size_t)lth_mixed_size(l));
    if (i < first) restrict_residual(g, i, lth_threads(ctx));
  }
  for (int i = first; i >= 0; i--) {
    if (i < first) lth_mixed_prolong(&g->level[i], &g->level[i + 1], lth_threads(ctx));
    LITHE_TRY(descend(ctx, g, i));
  }
  return LITHE_OK;
}
