/// Embedding: rows of weights for all points, and what is done with them at run time.
#include "embed/embedding.h"

#include "base/tensor.h"

static void add_row(const double *values, const double *weight, const LitheIndex *sample,
                    LitheCount n, double sum[3]) {
  double x = 0, y = 0, z = 0;
  for (LitheCount e = 0; e < n; e++) {
    const double *v = values + 4 * (size_t)sample[e];
    x += weight[e] * v[0];
    y += weight[e] * v[1];
    z += weight[e] * v[2];
  }
  sum[0] += x, sum[1] += y, sum[2] += z;
}

void lth_embedding_sample(const LthEmbedding *e, int threads, const double *coef, double *values) {
#pragma omp parallel for schedule(static) num_threads(threads) if (e->n_samples > 2000)
  for (LitheIndex i = 0; i < e->n_samples; i++) {
    double sum[3] = {0, 0, 0}, *v = values + 4 * (size_t)i;
    for (LitheCount k = e->sample_off[i]; k < e->sample_off[i + 1]; k++)
      lth_sample_add(e, k, coef + 3 * (size_t)e->sample_func[k], sum);
    lth_v3_copy(sum, v);
    v[3] = 0;
  }
}

void lth_embedding_from_samples(const LthEmbedding *e, LitheIndex p, const double *values,
                                double value[3]) {
  value[0] = value[1] = value[2] = 0;
  add_row(values, e->weight + e->off[p], e->sample + e->off[p], e->off[p + 1] - e->off[p], value);
}

void lth_embedding_apply(const LthEmbedding *e, int threads, const double *u, double *positions) {
  lth_embedding_sample(e, threads, u, e->sample_value);
#pragma omp parallel for schedule(static) num_threads(threads)
  for (LitheIndex p = 0; p < e->n_points; p++) {
    double *x = positions + 3 * (size_t)p;
    lth_v3_copy(e->rest + 3 * (size_t)p, x);
    add_row(e->sample_value, e->weight + e->off[p], e->sample + e->off[p],
            e->off[p + 1] - e->off[p], x);
  }
}

void lth_embedding_point(const LthEmbedding *e, LitheIndex p, const double *u, double value[3]) {
  value[0] = value[1] = value[2] = 0;
  for (LitheCount i = e->off[p]; i < e->off[p + 1]; i++) {
    LitheIndex s = e->sample[i];
    double sum[3] = {0, 0, 0};
    for (LitheCount k = e->sample_off[s]; k < e->sample_off[s + 1]; k++)
      lth_sample_add(e, k, u + 3 * (size_t)e->sample_func[k], sum);
    lth_v3_axpy(e->weight[i], sum, value);
  }
}

void lth_embedding_add_force(const LthEmbedding *e, LitheIndex p, const double force[3],
                             double *f) {
  for (LitheCount i = e->off[p]; i < e->off[p + 1]; i++) {
    LitheIndex s = e->sample[i];
    double share[3] = {e->weight[i] * force[0], e->weight[i] * force[1], e->weight[i] * force[2]};
    for (LitheCount k = e->sample_off[s]; k < e->sample_off[s + 1]; k++)
      lth_sample_add(e, k, share, f + 3 * (size_t)e->sample_func[k]);
  }
}

void lth_embedding_weights(const LthEmbedding *e, LitheIndex p, double *weights) {
  memset(weights, 0, sizeof *weights * (size_t)e->n_funcs);
  for (LitheCount i = e->off[p]; i < e->off[p + 1]; i++) {
    LitheIndex s = e->sample[i];
    for (LitheCount k = e->sample_off[s]; k < e->sample_off[s + 1]; k++)
      weights[e->sample_func[k]] += e->weight[i] * e->sample_weight[k * e->sample_width];
  }
}

LitheStatus lth_embedding_set_area(LitheCtx *ctx, LthEmbedding *e, LitheIndex n_polys,
                                   const LitheIndex *poly_off, const LitheIndex *poly_point) {
  if (!e->area) LTH_NEW(ctx, e->area, e->n_points);
  memset(e->area, 0, sizeof *e->area * (size_t)e->n_points);
  for (LitheIndex p = 0; p < n_polys; p++) {
    const LitheIndex *point = poly_point + poly_off[p];
    const LitheIndex n = poly_off[p + 1] - poly_off[p];
    double sum[3] = {0, 0, 0};
    for (LitheIndex i = 1; i + 1 < n; i++) {
      double a[3], b[3], cross[3];
      lth_v3_sub(e->rest + 3 * (size_t)point[i], e->rest + 3 * (size_t)point[0], a);
      lth_v3_sub(e->rest + 3 * (size_t)point[i + 1], e->rest + 3 * (size_t)point[0], b);
      lth_v3_cross(a, b, cross);
      lth_v3_axpy(0.5, cross, sum);
    }
    for (LitheIndex i = 0; i < n; i++) e->area[point[i]] += lth_v3_norm(sum) / n;
  }
  return LITHE_OK;
}

void lth_embedding_destroy(LitheCtx *ctx, LthEmbedding **embedding) {
  if (!embedding || !*embedding) return;
  LthEmbedding *e = *embedding;
  lth_free(ctx, e->rest);
  lth_free(ctx, e->off);
  lth_free(ctx, e->sample);
  lth_free(ctx, e->weight);
  lth_free(ctx, e->sample_point);
  lth_free(ctx, e->sample_off);
  lth_free(ctx, e->sample_func);
  lth_free(ctx, e->sample_weight);
  lth_free(ctx, e->sample_row_off);
  lth_free(ctx, e->sample_row);
  lth_free(ctx, e->cell);
  lth_free(ctx, e->area);
  lth_free(ctx, e->sample_value);
  lth_free(ctx, e);
  *embedding = NULL;
}
