/// Finding rims, and a bound by the law of Biot and Savart: a tree over the edges, far ones together.
#include "geometry/wrap_rim.h"

#include "base/tensor.h"

#include <stdlib.h>

#define STACK_MAX 96

/// --- building ---

/// An edge as a triangle runs through it: +1 from its lower point to its higher one.
typedef struct Side {
  LitheIndex low, high;
  int sense;
} Side;

static int compare_sides(const void *a, const void *b) {
  const Side *p = a, *q = b;
  if (p->low != q->low) return p->low < q->low ? -1 : 1;
  return (p->high > q->high) - (p->high < q->high);
}

/// Keep the edges that are left over, `sense` the number of times; returns how many they are.
static LitheIndex keep_left_over(Side *sides, LitheIndex n) {
  LitheIndex kept = 0;
  for (LitheIndex i = 0, j; i < n; i = j) {
    int sum = 0;
    for (j = i; j < n && compare_sides(&sides[i], &sides[j]) == 0; j++) sum += sides[j].sense;
    if (sum != 0) sides[kept++] = (Side){sides[i].low, sides[i].high, abs(sum)};
  }
  return kept;
}

static LitheIndex list_sides(const LthSurface *s, Side *sides) {
  LitheIndex n = 3 * s->n_tris;
  for (LitheIndex h = 0; h < n; h++) {
    LitheIndex p = s->tris[h], q = s->tris[h / 3 * 3 + (h % 3 + 1) % 3];
    sides[h] = p < q ? (Side){p, q, 1} : (Side){q, p, -1};
  }
  qsort(sides, (size_t)n, sizeof *sides, compare_sides);
  return keep_left_over(sides, n);
}

static LitheStatus make_tree(LitheCtx *ctx, LthRim *r, const LthSurface *s, const Side *sides) {
  LitheStatus status = LITHE_OK;
  double *boxes = NULL;
  LTH_NEW_OR(done, ctx, boxes, 6 * (LitheCount)r->n);
  for (LitheIndex e = 0; e < r->n; e++)
    for (int a = 0; a < 3; a++) {
      double p = s->points[3 * (size_t)sides[e].low + (size_t)a],
             q = s->points[3 * (size_t)sides[e].high + (size_t)a];
      boxes[6 * (size_t)e + (size_t)a] = fmin(p, q);
      boxes[6 * (size_t)e + 3 + (size_t)a] = fmax(p, q);
    }
  LITHE_TRY_OR(done, lth_bvh_create_boxes(ctx, r->n, boxes, &r->bvh));
  LTH_NEW_OR(done, ctx, r->ends, 6 * (LitheCount)r->n);
  LTH_NEW_OR(done, ctx, r->weight, r->n);
  LTH_NEW_OR(done, ctx, r->length, r->bvh->n_nodes);
  for (LitheIndex i = 0; i < r->n; i++) {
    const Side *side = &sides[r->bvh->item[i]];
    lth_v3_copy(s->points + 3 * (size_t)side->low, r->ends + 6 * (size_t)i);
    lth_v3_copy(s->points + 3 * (size_t)side->high, r->ends + 6 * (size_t)i + 3);
    r->weight[i] = side->sense;
  }
done:
  lth_free(ctx, boxes);
  return status;
}

static void sum_lengths(LthRim *r) {
  const LthBvh *t = r->bvh;
  for (LitheIndex node = t->n_nodes - 1; node >= 0; node--) { // children come behind their parents
    if (t->right[node] >= 0) {
      r->length[node] = r->length[node + 1] + r->length[t->right[node]];
      continue;
    }
    for (LitheIndex i = t->first[node]; i < t->first[node] + t->count[node]; i++)
      r->length[node] += r->weight[i] * lth_v3_distance(r->ends + 6 * i, r->ends + 6 * i + 3);
  }
}

LitheStatus lth_rim_create(LitheCtx *ctx, const LthSurface *raw, LthRim **rim) {
  LitheStatus status = LITHE_OK;
  Side *sides = NULL;
  LthRim *r = NULL;
  *rim = NULL;
  LTH_NEW_OR(done, ctx, r, 1);
  LTH_NEW_OR(done, ctx, sides, 3 * (LitheCount)raw->n_tris);
  r->n = list_sides(raw, sides);
  if (r->n == 0) goto done;
  LITHE_TRY_OR(done, make_tree(ctx, r, raw, sides));
  sum_lengths(r);
done:
  lth_free(ctx, sides);
  if (status != LITHE_OK) lth_rim_destroy(ctx, &r);
  *rim = r;
  return status;
}

void lth_rim_destroy(LitheCtx *ctx, LthRim **rim) {
  if (!rim || !*rim) return;
  LthRim *r = *rim;
  lth_bvh_destroy(ctx, &r->bvh);
  lth_free(ctx, r->ends);
  lth_free(ctx, r->length);
  lth_free(ctx, r->weight);
  lth_free(ctx, r);
  *rim = NULL;
}

/// --- asking ---

static double distance_to_edge(const double *ends, const double x[3]) {
  double along[3], from[3];
  lth_v3_sub(ends + 3, ends, along);
  lth_v3_sub(x, ends, from);
  double length2 = lth_v3_dot(along, along);
  double t = length2 > 0 ? fmin(fmax(lth_v3_dot(from, along) / length2, 0), 1) : 0;
  lth_v3_axpy(-t, along, from);
  return lth_v3_norm(from);
}

/// Edges of a leaf: int dl / r^2 is at most the length over the distance squared, and pi over the distance.
static double leaf_sum(const LthRim *r, LitheIndex node, const double x[3], double radius) {
  const LthBvh *t = r->bvh;
  double sum = 0;
  for (LitheIndex i = t->first[node]; i < t->first[node] + t->count[node]; i++) {
    const double *ends = r->ends + 6 * (size_t)i;
    double d = distance_to_edge(ends, x) - radius;
    if (!(d > 0)) return INFINITY;
    sum += r->weight[i] * fmin(lth_v3_distance(ends, ends + 3) / (d * d), M_PI / d);
  }
  return sum;
}

double lth_rim_slope(const LthRim *r, const double x[3], double radius) {
  LitheIndex stack[STACK_MAX];
  const LthBvh *t = r->bvh;
  double sum = 0;
  int top = 0;
  if (r->n == 0) return 0;
  stack[top++] = 0;
  while (top > 0 && sum < INFINITY) {
    LitheIndex node = stack[--top];
    const double *box = t->box + 6 * (size_t)node;
    double d = sqrt(lth_box_distance2(box, x)) - radius;
    if (d > lth_v3_distance(box, box + 3)) {
      sum += r->length[node] / (d * d);
    } else if (t->right[node] < 0) {
      sum += leaf_sum(r, node, x, radius);
    } else {
      LITHE_ASSERT(top + 2 <= STACK_MAX);
      stack[top++] = t->right[node];
      stack[top++] = node + 1;
    }
  }
  return sum / (4 * M_PI);
}
