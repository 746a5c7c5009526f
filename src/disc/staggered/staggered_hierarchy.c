/// Coarser and coarser levels until one is small, or would no longer resolve the body.
#include "disc/staggered/staggered_hierarchy.h"
#include "disc/staggered/staggered_loose.h"
#include "disc/staggered/staggered_walls.h"

/// How much of a cell is filled: of the finest level's cells all or nothing.
static LitheStatus filling_of(LitheCtx *ctx, const LthStaggeredLevel *l, float **filling) {
  LTH_NEW(ctx, *filling, l->grid->n_slots);
  for (LitheCount s = 0; s < l->grid->n_slots; s++) (*filling)[s] = lth_level_is_live(l, s);
  return LITHE_OK;
}

static LitheStatus coarsen_filling(LitheCtx *ctx, const LthSparseGrid *fine,
                                   const LthSparseGrid *coarse, float **filling) {
  float *mean;
  LTH_NEW(ctx, mean, coarse->n_slots);
  int deep = fine->dim == 3;
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheCount s = 0; s < coarse->n_slots; s++) {
    LitheIndex c[3];
    lth_sparse_grid_cell(coarse, s, c);
    double sum = 0;
    for (int q = 0; q < (deep ? 8 : 4); q++) {
      LitheCount child = lth_sparse_grid_slot(fine, 2 * c[0] + (q & 1), 2 * c[1] + (q >> 1 & 1),
                                              2 * c[2] + (q >> 2));
      if (child >= 0) sum += (*filling)[child];
    }
    mean[s] = (float)(sum / (deep ? 8 : 4));
  }
  lth_free(ctx, *filling);
  *filling = mean;
  return LITHE_OK;
}

/// One level more, unless it is of no use: `more` says so.
static LitheStatus add_level(LitheCtx *ctx, LthStaggeredHierarchy *H, double thin_fraction,
                             float **filling, bool *more) {
  LitheStatus status = LITHE_OK;
  const LthStaggeredLevel *fine = &H->level[H->n_levels - 1];
  LthStaggeredLevel coarse = {0};
  LthSparseGrid *grid = NULL;
  double share = 0;
  *more = false;
  LITHE_TRY_OR(done, lth_staggered_coarsen(ctx, fine, &grid, &coarse));
  LITHE_TRY_OR(done, coarsen_filling(ctx, fine->grid, grid, filling));
  LITHE_TRY_OR(done, lth_staggered_thin_share(ctx, grid, *filling, &share, NULL));
  LitheCount n_free = lth_staggered_count_free(ctx, &coarse);
  H->stopped_thin = share > thin_fraction;
  *more = !H->stopped_thin && n_free > 0 && n_free < H->n_free[H->n_levels - 1];
  if (!*more) goto done;
  H->level[H->n_levels] = coarse;
  H->n_free[H->n_levels++] = n_free;
  grid = NULL;
  coarse = (LthStaggeredLevel){0};
done:
  lth_staggered_level_free(ctx, &coarse);
  lth_sparse_grid_destroy(ctx, &grid);
  return status;
}

/// The coarsest level is solved exactly: what coarsening has left hanging by thin features would make it singular.
static LitheStatus settle_last(LitheCtx *ctx, LthStaggeredHierarchy *H) {
  LthLoose loose;
  if (H->n_levels == 1) return LITHE_OK;
  LthStaggeredLevel *last = &H->level[H->n_levels - 1];
  LITHE_TRY(lth_staggered_drop_loose(ctx, last, &loose));
  H->n_free[H->n_levels - 1] = lth_staggered_count_free(ctx, last);
  return LITHE_OK;
}

LitheStatus lth_staggered_hierarchy_create(LitheCtx *ctx, const LthStaggeredLevel *fine,
                                           const LthCoarsenDef *def,
                                           LthStaggeredHierarchy **hierarchy) {
  LitheStatus status = LITHE_OK;
  LitheCount enough = def && def->enough > 0 ? def->enough : 1500;
  double thin_fraction = def && def->thin_fraction > 0 ? def->thin_fraction : 0.05;
  float *filling = NULL;
  LTH_NEW(ctx, *hierarchy, 1);
  LthStaggeredHierarchy *H = *hierarchy;
  H->level[0] = *fine;
  H->n_free[0] = lth_staggered_count_free(ctx, fine);
  H->n_levels = 1;
  LITHE_TRY_OR(done, filling_of(ctx, fine, &filling));
  bool more = true;
  while (more && H->n_free[H->n_levels - 1] > enough && H->n_levels < LTH_STAGGERED_MAX_LEVELS)
    LITHE_TRY_OR(done, add_level(ctx, H, thin_fraction, &filling, &more));
  LITHE_TRY_OR(done, settle_last(ctx, H));
  for (int l = 1; lth_staggered_level_is_packed(fine) && l < H->n_levels; l++)
    LITHE_TRY_OR(done, lth_staggered_level_pack(ctx, &H->level[l]));
done:
  lth_free(ctx, filling);
  if (status != LITHE_OK) lth_staggered_hierarchy_destroy(ctx, hierarchy);
  return status;
}

void lth_staggered_hierarchy_destroy(LitheCtx *ctx, LthStaggeredHierarchy **hierarchy) {
  if (!*hierarchy) return;
  for (int l = 1; l < (*hierarchy)->n_levels; l++) {
    LthSparseGrid *grid = (LthSparseGrid *)(*hierarchy)->level[l].grid;
    lth_staggered_level_free(ctx, &(*hierarchy)->level[l]);
    lth_sparse_grid_destroy(ctx, &grid);
  }
  lth_free(ctx, *hierarchy);
  *hierarchy = NULL;
}

LitheCount lth_staggered_hierarchy_bytes(const LthStaggeredHierarchy *H) {
  LitheCount bytes = 0;
  for (int l = 1; l < H->n_levels; l++) {
    const LthSparseGrid *g = H->level[l].grid;
    bytes += lth_staggered_level_bytes(&H->level[l]);
    bytes += lth_staggered_walls_bytes(g, H->level[l].walls);
    bytes += g->n_blocks * (LitheCount)sizeof(LitheIndex) * (3 + g->n_neighbors);
  }
  return bytes;
}
