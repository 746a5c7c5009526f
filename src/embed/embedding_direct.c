/// Points that follow a continuous discretisation by its own functions.
#include "embed/weights.h"

#include <string.h>

/// One sample for every function, with weight one.
static LitheStatus make_samples(LitheCtx *ctx, const LthDisc *disc, LthEmbedding *e) {
  LitheIndex n = e->n_samples = disc->n_funcs;
  LTH_NEW(ctx, e->sample_point, 3 * (LitheCount)n);
  LTH_NEW(ctx, e->sample_value, 4 * (LitheCount)n);
  LTH_NEW(ctx, e->sample_off, (LitheCount)n + 1);
  LTH_NEW(ctx, e->sample_func, n);
  LTH_NEW(ctx, e->sample_weight, n);
  LTH_NEW(ctx, e->sample_row_off, (LitheCount)n + 1);
  LTH_NEW(ctx, e->sample_row, n);
  disc->table->rest(disc, e->sample_point);
  LitheIndex row = 0;
  for (LitheIndex i = 0; i < n; i++) {
    while (disc->row_func[row + 1] <= i) row++;
    e->sample_off[i + 1] = e->sample_row_off[i + 1] = i + 1;
    e->sample_func[i] = i;
    e->sample_weight[i] = 1;
    e->sample_row[i] = row;
  }
  return LITHE_OK;
}

/// Rows of weights: first their lengths, then they themselves.
static LitheStatus make_rows(LitheCtx *ctx, const LthDisc *disc, LthEmbedding *e) {
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheIndex p = 0; p < e->n_points; p++) {
    LitheIndex func[LTH_DISC_MAX_FUNCS];
    double phi[3 * LTH_DISC_MAX_FUNCS];
    e->off[p + 1] = disc->table->eval(disc, e->cell[p], e->rest + 3 * (size_t)p, func, phi);
  }
  for (LitheIndex p = 0; p < e->n_points; p++) e->off[p + 1] += e->off[p];
  LTH_NEW(ctx, e->sample, e->off[e->n_points]);
  LTH_NEW(ctx, e->weight, e->off[e->n_points]);
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheIndex p = 0; p < e->n_points; p++) {
    double phi[3 * LTH_DISC_MAX_FUNCS];
    int n =
        disc->table->eval(disc, e->cell[p], e->rest + 3 * (size_t)p, e->sample + e->off[p], phi);
    for (int i = 0; i < n; i++) e->weight[e->off[p] + i] = phi[3 * i];
  }
  return LITHE_OK;
}

/// Components with functions of their own: every point is a sample of its own, which it follows alone.
static LitheStatus make_split(LitheCtx *ctx, const LthDisc *disc, LthEmbedding *e) {
  const LitheIndex n = e->n_samples = e->n_points;
  e->sample_width = 3;
  LTH_NEW(ctx, e->sample, n);
  LTH_NEW(ctx, e->weight, n);
  LTH_NEW(ctx, e->sample_point, 3 * (LitheCount)n);
  LTH_NEW(ctx, e->sample_value, 4 * (LitheCount)n);
  LTH_NEW(ctx, e->sample_off, (LitheCount)n + 1);
  LTH_NEW(ctx, e->sample_row_off, (LitheCount)n + 1);
  memcpy(e->sample_point, e->rest, sizeof *e->rest * 3 * (size_t)n);
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheIndex p = 0; p < n; p++) {
    LitheIndex func[LTH_DISC_MAX_FUNCS];
    double phi[3 * LTH_DISC_MAX_FUNCS];
    e->sample_off[p + 1] = disc->table->eval(disc, e->cell[p], e->rest + 3 * (size_t)p, func, phi);
    e->sample[p] = p;
    e->weight[p] = 1;
    e->off[p + 1] = p + 1;
  }
  for (LitheIndex p = 0; p < n; p++) e->sample_off[p + 1] += e->sample_off[p];
  memcpy(e->sample_row_off, e->sample_off, sizeof *e->sample_off * ((size_t)n + 1));
  LTH_NEW(ctx, e->sample_func, e->sample_off[n]);
  LTH_NEW(ctx, e->sample_row, e->sample_off[n]);
  LTH_NEW(ctx, e->sample_weight, 3 * e->sample_off[n]);
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheIndex p = 0; p < n; p++)
    disc->table->eval(disc, e->cell[p], e->rest + 3 * (size_t)p, e->sample_func + e->sample_off[p],
                      e->sample_weight + 3 * e->sample_off[p]);
  // a block row is one function
  memcpy(e->sample_row, e->sample_func, sizeof *e->sample_func * (size_t)e->sample_off[n]);
  return LITHE_OK;
}

/// Cells of all points, of a discretisation that has no mesh.
static LitheStatus find_cells(LitheCtx *ctx, const LthDisc *disc, LthEmbedding *e) {
  LTH_NEW(ctx, e->cell, e->n_points);
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheIndex p = 0; p < e->n_points; p++)
    e->cell[p] = disc->table->find_cell(disc, e->rest + 3 * (size_t)p, NULL);
  return LITHE_OK;
}

static LitheStatus build(LitheCtx *ctx, const LthDisc *disc, const double *points,
                         const LitheIndex *point_cell, LthEmbedding *e) {
  LTH_NEW(ctx, e->rest, 3 * (LitheCount)e->n_points);
  LTH_NEW(ctx, e->off, (LitheCount)e->n_points + 1);
  memcpy(e->rest, points, sizeof *points * 3 * (size_t)e->n_points);
  if (disc->is_split) {
    LITHE_TRY(find_cells(ctx, disc, e));
    return make_split(ctx, disc, e);
  }
  LITHE_TRY(lth_embedding_find_cells(ctx, e, point_cell));
  LITHE_TRY(make_samples(ctx, disc, e));
  return make_rows(ctx, disc, e);
}

LitheStatus lth_embedding_create_direct(LitheCtx *ctx, const LthDisc *disc, LitheIndex n,
                                        const double *points, const LitheIndex *point_cell,
                                        LthEmbedding **embedding) {
  LTH_NEW(ctx, *embedding, 1);
  LthEmbedding *e = *embedding;
  e->mesh = disc->mesh;
  e->n_funcs = disc->n_funcs;
  e->n_rows = disc->n_rows;
  e->row_func = disc->row_func;
  e->n_points = n;
  e->sample_width = 1;
  LitheStatus status = build(ctx, disc, points, point_cell, e);
  if (status != LITHE_OK) lth_embedding_destroy(ctx, embedding);
  return status;
}
