/// Points that follow the mean of the elements that they bound: what contact of parts needs, which never reads across a cut.
#include "embed/embedding.h"

#include <string.h>

static LitheStatus make_lists(LitheCtx *ctx, const LthDgSpace *space, const LitheIndex *cell_off,
                              const LitheIndex *cells, LthEmbedding *e) {
  const LitheIndex n = e->n_points;
  LitheCount at = 0;
  LTH_NEW(ctx, e->off, (LitheCount)n + 1);
  LTH_NEW(ctx, e->sample, n);
  LTH_NEW(ctx, e->weight, n);
  LTH_NEW(ctx, e->cell, n);
  LTH_NEW(ctx, e->sample_value, 4 * (LitheCount)n);
  LTH_NEW(ctx, e->sample_off, (LitheCount)n + 1);
  LTH_NEW(ctx, e->sample_row_off, (LitheCount)n + 1);
  LTH_NEW(ctx, e->sample_row, cell_off[n]);
  memcpy(e->sample_row, cells, sizeof *cells * (size_t)cell_off[n]);
  for (LitheIndex p = 0; p < n; p++) {
    e->sample[p] = p, e->weight[p] = 1, e->off[p + 1] = p + 1;
    e->cell[p] = cells[cell_off[p]];
    e->sample_row_off[p + 1] = cell_off[p + 1];
    for (LitheIndex i = cell_off[p]; i < cell_off[p + 1]; i++)
      at += space->func_off[cells[i] + 1] - space->func_off[cells[i]];
    e->sample_off[p + 1] = at;
  }
  LTH_NEW(ctx, e->sample_func, at);
  LTH_NEW(ctx, e->sample_weight, at);
  return LITHE_OK;
}

/// One sample for each point: eq. 30 there.
static void fill(LitheCtx *ctx, const LthDisc *disc, LthEmbedding *e) {
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheIndex p = 0; p < e->n_points; p++) {
    LitheCount at = e->sample_off[p], first = e->sample_row_off[p], end = e->sample_row_off[p + 1];
    for (LitheCount i = first; i < end; i++) {
      double phi[3 * LTH_DISC_MAX_FUNCS];
      int n = disc->table->eval(disc, e->sample_row[i], e->rest + 3 * (size_t)p,
                                e->sample_func + at, phi);
      for (int k = 0; k < n; k++) e->sample_weight[at + k] = phi[3 * k] / (double)(end - first);
      at += n;
    }
  }
}

LitheStatus lth_embedding_create_average(LitheCtx *ctx, const LthDisc *disc,
                                         const LthDgSpace *space, LitheIndex n,
                                         const double *points, const LitheIndex *cell_off,
                                         const LitheIndex *cells, LthEmbedding **embedding) {
  LitheStatus status = LITHE_OK;
  LthEmbedding *e = NULL;
  *embedding = NULL;
  LTH_NEW(ctx, e, 1);
  e->mesh = disc->mesh;
  e->n_funcs = disc->n_funcs, e->n_rows = disc->n_rows;
  e->row_func = disc->row_func;
  e->n_points = e->n_samples = n;
  e->sample_width = 1;
  LTH_NEW_OR(done, ctx, e->rest, 3 * (LitheCount)n);
  LTH_NEW_OR(done, ctx, e->sample_point, 3 * (LitheCount)n);
  memcpy(e->rest, points, sizeof *points * 3 * (size_t)n);
  memcpy(e->sample_point, points, sizeof *points * 3 * (size_t)n);
  LITHE_TRY_OR(done, make_lists(ctx, space, cell_off, cells, e));
  fill(ctx, disc, e);
done:
  if (status != LITHE_OK) lth_embedding_destroy(ctx, &e);
  *embedding = e;
  return status;
}
