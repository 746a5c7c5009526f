/// Smooth parts of triangle surfaces: only boxes near the surface are looked at, each with a list of the triangles that can be
/// the nearest one to any of its places.
#include "geometry/fractions_fill.h"

#include "base/tensor.h"

#include <stdlib.h>

#define ROUNDING 1e-9   ///< of a distance
#define BOX 4           ///< parts along the boxes that get a list
#define LIST_WANTED 250 ///< longer lists are made anew for halves of the box

/// A triangle that may be the nearest one: a ball around it, and how near that is to the box's middle.
typedef struct Candidate {
  LitheIndex tri;
  double center[3], radius, distance;
} Candidate;

typedef struct Near {
  const LthSmoother *smoother;
  const LthFractionFrame *frame;
  const LthBvh *tree;
  const double *low;    ///< corner of the block
  const double *inside; ///< of a part's middle, 1 or 0, as `part`; NULL: by the nearest triangle
  double *part;
  LitheCtx *ctx;
  LitheStatus status;
  Candidate *list;
  LitheIndex n;
  LitheCount cap;
  double middle[3], reach; ///< of a search
} Near;

static void find_corners(const Near *s, LitheIndex tri, const double *corner[3]) {
  const LthSurface *f = s->tree->surface;
  for (int k = 0; k < 3; k++)
    corner[k] = f->points + 3 * (size_t)f->tris[3 * (size_t)tri + (size_t)k];
}

static LitheStatus add_candidate(Near *s, const Candidate *e) {
  LTH_RESERVE(s->ctx, s->list, s->cap, (LitheCount)s->n + 1);
  s->list[s->n++] = *e;
  return LITHE_OK;
}

static bool list_triangle(void *self, LitheIndex tri) {
  Near *s = self;
  Candidate e = {.tri = tri};
  const double *c[3];
  double radius2 = 0;
  find_corners(s, tri, c);
  for (int a = 0; a < 3; a++) e.center[a] = (c[0][a] + c[1][a] + c[2][a]) / 3;
  for (int k = 0; k < 3; k++) {
    double d[3];
    lth_v3_sub(c[k], e.center, d);
    double d2 = lth_v3_dot(d, d);
    if (d2 > radius2) radius2 = d2;
  }
  e.radius = sqrt(radius2);
  e.distance = lth_v3_distance(e.center, s->middle) - e.radius;
  if (e.distance <= s->reach) s->status = add_candidate(s, &e);
  return s->status == LITHE_OK;
}

static int compare_candidates(const void *a, const void *b) {
  const Candidate *p = a, *q = b;
  if (p->distance != q->distance) return p->distance < q->distance ? -1 : 1;
  return (p->tri > q->tri) - (p->tri < q->tri);
}

/// Triangles that are the nearest one to some place within `radius` of the middle, the nearest one to that being at `distance`.
static LitheStatus list_candidates(Near *s, double radius, double distance) {
  s->n = 0;
  s->reach = (distance + 2 * radius) * (1 + ROUNDING);
  lth_bvh_visit(s->tree, s->middle, s->reach, list_triangle, s);
  LITHE_TRY(s->status);
  qsort(s->list, (size_t)s->n, sizeof *s->list, compare_candidates);
  return LITHE_OK;
}

static void try_candidate(const Near *s, const Candidate *e, const double x[3], LthBvhPoint *best) {
  const double *c[3];
  double q[3];
  if (lth_v3_distance(x, e->center) - e->radius > best->distance) return;
  find_corners(s, e->tri, c);
  int part = lth_closest_on_triangle(c[0], c[1], c[2], x, q);
  double distance = lth_v3_distance(x, q);
  if (!(distance < best->distance)) return;
  *best = (LthBvhPoint){.tri = e->tri, .part = part, .distance = distance};
  lth_v3_copy(q, best->point);
}

/// The nearest point of the list, which stands in the order of what is nearest to the middle; *last: where to begin.
static LthBvhPoint nearest(const Near *s, const double x[3], LitheIndex *last) {
  LthBvhPoint best = {.tri = -1, .distance = INFINITY};
  double away = lth_v3_distance(x, s->middle);
  try_candidate(s, &s->list[*last], x, &best);
  for (LitheIndex i = 0; i < s->n && s->list[i].distance - away <= best.distance; i++) {
    double before = best.distance;
    try_candidate(s, &s->list[i], x, &best);
    if (best.distance < before) *last = i;
  }
  return best;
}

static void fill_parts(const Near *s, const int at[3], int size) {
  const LthFractionFrame *f = s->frame;
  LitheIndex last = 0;
  for (int k = at[2]; k < at[2] + size; k++)
    for (int j = at[1]; j < at[1] + size; j++)
      for (int i = at[0]; i < at[0] + size; i++) {
        int place[3] = {i, j, k};
        double x[3];
        for (int a = 0; a < 3; a++) x[a] = s->low[a] + 0.5 * f->h[a] * (place[a] + 0.5);
        LthBvhPoint closest = nearest(s, x, &last);
        LitheIndex p = lth_fraction_place(f, i, j, k);
        double d = !s->inside           ? lth_bvh_gap(s->tree, x, &closest, NULL)
                   : s->inside[p] > 0.5 ? -closest.distance
                                        : closest.distance;
        s->part[p] = lth_fraction_profile(d / s->smoother->width);
      }
}

/// A box whose places are all farther than the width from the surface.
static void fill_one_side(const Near *s, const int at[3], int size) {
  const LthFractionFrame *f = s->frame;
  LthBvhPoint closest;
  bool is_in = s->inside && s->inside[lth_fraction_place(f, at[0], at[1], at[2])] > 0.5;
  if (!s->inside && lth_bvh_closest(s->tree, s->middle, INFINITY, NULL, NULL, &closest))
    is_in = lth_bvh_gap(s->tree, s->middle, &closest, NULL) < 0;
  if (!is_in) return;
  for (int k = at[2]; k < at[2] + size; k++)
    for (int j = at[1]; j < at[1] + size; j++)
      for (int i = at[0]; i < at[0] + size; i++) s->part[lth_fraction_place(f, i, j, k)] = 1;
}

/// Parts [at, at + size) of the block.
static LitheStatus fill_box(Near *s, const int at[3], int size) {
  LthBvhPoint closest;
  double half[3];
  for (int a = 0; a < 3; a++) {
    half[a] = 0.25 * s->frame->h[a] * size;
    s->middle[a] = s->low[a] + 0.5 * s->frame->h[a] * at[a] + half[a];
  }
  double radius = lth_v3_norm(half), reach = (radius + s->smoother->width) * (1 + ROUNDING);
  if (!lth_bvh_closest(s->tree, s->middle, reach, NULL, NULL, &closest)) {
    fill_one_side(s, at, size);
    return LITHE_OK;
  }
  if (size <= BOX) {
    LITHE_TRY(list_candidates(s, radius, closest.distance));
    if (s->n <= LIST_WANTED || size == 1) {
      fill_parts(s, at, size);
      return LITHE_OK;
    }
  }
  for (int q = 0; q < 8; q++) {
    int to[3];
    for (int a = 0; a < 3; a++) to[a] = at[a] + (q >> a & 1) * size / 2;
    LITHE_TRY(fill_box(s, to, size / 2));
  }
  return LITHE_OK;
}

/// Are the middles of the parts of a wrapped surface inside?                          (as row->part)
static LitheStatus find_inside(LitheCtx *ctx, const LthProbe *probe, const LthFractionFrame *f,
                               const LthFractionRow *row, double **inside) {
  LTH_NEW(ctx, *inside, (LitheCount)row->n * f->block_cells * f->n_parts);
  return lth_fraction_fill_wrap(ctx, probe, 2, f, row, *inside);
}

LitheStatus lth_fraction_fill_near(const LthSmoother *smoother, LitheCtx *ctx,
                                   const LthFractionFrame *f, const LthFractionRow *row) {
  LitheStatus status = LITHE_OK;
  const LthShape *shape = smoother->probe->shape;
  bool is_wrapped = shape->kind == LTH_SHAPE_WRAP;
  Near s = {.smoother = smoother, .frame = f, .ctx = ctx};
  double *inside = NULL, low[3];
  s.tree = is_wrapped ? shape->wrap->bvh : shape->bvh;
  s.low = low;
  if (is_wrapped) LITHE_TRY_OR(done, find_inside(ctx, smoother->probe, f, row, &inside));
  for (LitheIndex m = 0; m < row->n; m++) {
    LitheCount first = (LitheCount)m * f->block_cells * f->n_parts;
    lth_fraction_corner(f, row->at[m], row->j, row->k, low);
    s.part = row->part + first;
    if (inside) s.inside = inside + first;
    LITHE_TRY_OR(done, fill_box(&s, (int[3]){0, 0, 0}, 2 * f->side));
  }
done:
  lth_free(ctx, s.list);
  lth_free(ctx, inside);
  return status;
}
