/// What is claimed of surfaces that are closed by construction.
#pragma once

#include "check.h"

#include "base/tensor.h"
#include "geometry/surface_clean.h"

static inline const double *tri_point(const LthSurface *s, LitheIndex t, int k) {
  return s->points + 3 * s->tris[3 * t + k];
}

typedef struct Half {
  LitheIndex from, to;
} Half;

static inline int compare_halves(const void *a, const void *b) {
  const Half *p = a, *q = b;
  if (p->from != q->from) return p->from < q->from ? -1 : 1;
  return (p->to > q->to) - (p->to < q->to);
}

/// Every directed edge once, and its opposite once; every point used; no edge of no length.
static inline void check_closed(const LthSurface *s) {
  LitheIndex n = 3 * s->n_tris;
  Half *halves = calloc((size_t)n, sizeof *halves);
  char *used = calloc((size_t)s->n_points, 1);
  for (LitheIndex h = 0; h < n; h++) {
    halves[h] = (Half){s->tris[h], s->tris[h / 3 * 3 + (h % 3 + 1) % 3]};
    used[s->tris[h]] = 1;
  }
  qsort(halves, (size_t)n, sizeof *halves, compare_halves);
  for (LitheIndex h = 0; h < n; h++) {
    Half opposite = {halves[h].to, halves[h].from};
    assert_non_null(bsearch(&opposite, halves, (size_t)n, sizeof *halves, compare_halves));
    if (h > 0) assert_int_not_equal(compare_halves(&halves[h - 1], &halves[h]), 0);
  }
  for (LitheIndex p = 0; p < s->n_points; p++) assert_true(used[p]);
  for (LitheIndex t = 0; t < s->n_tris; t++)
    for (int k = 0; k < 3; k++)
      assert_true(lth_v3_distance(tri_point(s, t, k), tri_point(s, t, (k + 1) % 3)) > 0);
  free(halves);
  free(used);
}

/// Pairs of triangles that have more in common than corners and sides, by exact predicates.
static inline LitheIndex count_crossings(LitheCtx *ctx, const LthSurface *s) {
  LthDefects defects = {0};
  LthCleaner c = {.ctx = ctx,
                  .name = "surface",
                  .defects = &defects,
                  .n_points = s->n_points,
                  .points = s->points,
                  .n_tris = s->n_tris,
                  .tris = s->tris};
  LthBvh *bvh = NULL;
  double *boxes = calloc((size_t)s->n_tris, 6 * sizeof *boxes);
  for (LitheIndex t = 0; t < s->n_tris; t++) lth_clean_box(&c, s->tris + 3 * t, boxes + 6 * t);
  CHECK_OK(ctx, lth_bvh_create_boxes(ctx, s->n_tris, boxes, &bvh));
  CHECK_OK(ctx, lth_clean_find_crossings(&c, boxes, bvh));
  LitheIndex n = c.n_pairs;
  lth_bvh_destroy(ctx, &bvh);
  lth_free(ctx, c.pair);
  lth_defects_free(ctx, &defects);
  free(boxes);
  return n;
}
