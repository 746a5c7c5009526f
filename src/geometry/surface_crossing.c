/// Finding triangles that cross: pairs whose boxes overlap, from the bounding volume tree.
#include "geometry/predicates.h"
#include "geometry/surface_clean.h"
#include "geometry/tri_tri.h"

#define STACK_MAX 128
#define SMALL 1000            ///< triangles for which waking threads would cost more than it gains
#define CROSSINGS_MAX 1000000 ///< pairs counted at most

typedef struct Search {
  const LthCleaner *c;
  const LthBvh *bvh;
  const double *boxes; ///< of the triangles (n_tris x 6)
  const bool *is_flat; ///< triangles without area, left out
} Search;

static bool pair_crosses(const Search *s, LitheIndex a, LitheIndex b) {
  return !s->is_flat[b] && lth_boxes_meet(s->boxes + 6 * (size_t)a, s->boxes + 6 * (size_t)b) &&
         lth_triangles_cross(s->c->points, s->c->tris + 3 * (size_t)a, s->c->tris + 3 * (size_t)b);
}

/// Triangles with a higher number that cross `tri`: the first `cap` go into `found` (may be NULL with
/// cap 1, which stops at the first). Returns their number.
static LitheIndex search_tree(const Search *s, LitheIndex tri, LitheIndex cap, LitheIndex *found) {
  const LthBvh *bvh = s->bvh;
  const double *box = s->boxes + 6 * (size_t)tri;
  LitheIndex stack[STACK_MAX], top = 0, n = 0;
  stack[top++] = 0;
  while (top > 0) {
    LitheIndex node = stack[--top];
    if (!lth_boxes_meet(bvh->box + 6 * (size_t)node, box)) continue;
    if (bvh->right[node] >= 0) {
      LITHE_ASSERT(top + 2 <= STACK_MAX);
      stack[top++] = bvh->right[node];
      stack[top++] = node + 1;
      continue;
    }
    for (LitheIndex i = 0; i < bvh->count[node]; i++) {
      LitheIndex other = bvh->item[bvh->first[node] + i];
      if (other <= tri || !pair_crosses(s, tri, other)) continue;
      if (found) found[n] = other;
      if (++n == cap) return n;
    }
  }
  return n;
}

static LitheStatus record(LthCleaner *c, LitheIndex a, LitheIndex b) {
  double segment[6];
  if (c->n_pairs < LTH_DEFECTS_KEPT) {
    LTH_RESERVE(c->ctx, c->pair, c->pair_cap, 2 * ((LitheCount)c->n_pairs + 1));
    c->pair[2 * c->n_pairs] = a;
    c->pair[2 * c->n_pairs++ + 1] = b;
  }
  if (c->defects->count[LTH_DEFECT_CROSSING] < LTH_DEFECTS_KEPT)
    lth_triangles_crossing(c->points, c->tris + 3 * (size_t)a, c->tris + 3 * (size_t)b, segment);
  else
    for (int i = 0; i < 6; i++) segment[i] = 0;
  return lth_defects_add(c->ctx, c->defects, LTH_DEFECT_CROSSING, segment, segment + 3);
}

/// First all triangles in parallel for a yes or no, then those with a crossing one by one, in order.
static LitheStatus search_all(LthCleaner *c, const Search *s, bool *is_crossed) {
  LitheStatus status = LITHE_OK;
  LitheIndex *found = NULL, n_tris = c->n_tris;
#pragma omp parallel for schedule(static) num_threads(lth_threads(c->ctx)) if (n_tris > SMALL)
  for (LitheIndex t = 0; t < n_tris; t++)
    is_crossed[t] = !s->is_flat[t] && !lth_cancelled(c->ctx) && search_tree(s, t, 1, NULL) > 0;
  if (lth_cancelled(c->ctx)) LITHE_FAIL(c->ctx, LITHE_INTERRUPTED, "%s: interrupted", c->name);

  LTH_NEW_OR(done, c->ctx, found, n_tris);
  for (LitheIndex t = 0; t < n_tris; t++) {
    LitheIndex left = CROSSINGS_MAX - c->defects->count[LTH_DEFECT_CROSSING];
    if (left <= 0) break;
    if (!is_crossed[t]) continue;
    LitheIndex n = search_tree(s, t, left, found);
    for (LitheIndex i = 0; i < n; i++) LITHE_TRY_OR(done, record(c, t, found[i]));
  }
done:
  lth_free(c->ctx, found);
  return status;
}

LitheStatus lth_clean_find_crossings(LthCleaner *c, const double *boxes, const LthBvh *bvh) {
  LitheStatus status = LITHE_OK;
  bool *is_flat = NULL, *is_crossed = NULL;
  c->n_pairs = 0;
  LTH_NEW_OR(done, c->ctx, is_flat, c->n_tris);
  LTH_NEW_OR(done, c->ctx, is_crossed, c->n_tris);
  for (LitheIndex t = 0; t < c->n_tris; t++) {
    const LitheIndex *p = c->tris + 3 * (size_t)t;
    is_flat[t] =
        lth_collinear(lth_clean_point(c, p[0]), lth_clean_point(c, p[1]), lth_clean_point(c, p[2]));
  }
  LITHE_TRY_OR(done, search_all(c, &(Search){c, bvh, boxes, is_flat}, is_crossed));
done:
  lth_free(c->ctx, is_flat);
  lth_free(c->ctx, is_crossed);
  return status;
}
