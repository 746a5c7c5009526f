/// Making polygons with holes, and their signed distance. The sign at corners is that of the mean of both
/// normals (Baerentzen and Aanaes 2005, in the plane).
#include "geometry/loops.h"

#include "geometry/loops_check.h"
#include "geometry/predicates.h"

#include <math.h>

void lth_loops_destroy(LitheCtx *ctx, LthLoops **loops) {
  if (!loops || !*loops) return;
  lth_bvh_destroy(ctx, &(*loops)->bvh);
  lth_free(ctx, (*loops)->first);
  lth_free(ctx, (*loops)->next);
  lth_free(ctx, (*loops)->prev);
  lth_free(ctx, (*loops)->points);
  lth_free(ctx, *loops);
  *loops = NULL;
}

static const double *corner(const LthLoops *l, LitheIndex i) { return l->points + 2 * (size_t)i; }

/// Twice the area of a loop, about its first corner.
double lth_loop_area2(const LthLoops *l, LitheIndex loop) {
  const double *o = corner(l, l->first[loop]);
  double sum = 0;
  for (LitheIndex i = l->first[loop]; i < l->first[loop + 1]; i++) {
    const double *p = corner(l, i), *q = corner(l, l->next[i]);
    sum += (p[0] - o[0]) * (q[1] - o[1]) - (p[1] - o[1]) * (q[0] - o[0]);
  }
  return sum;
}

static void reverse(LthLoops *l, LitheIndex loop) {
  for (LitheIndex i = l->first[loop], j = l->first[loop + 1] - 1; i < j; i++, j--)
    for (int a = 0; a < 2; a++) {
      double kept = l->points[2 * (size_t)i + (size_t)a];
      l->points[2 * (size_t)i + (size_t)a] = l->points[2 * (size_t)j + (size_t)a];
      l->points[2 * (size_t)j + (size_t)a] = kept;
    }
}

/// Corners without those that repeat the one before, and links between them.
static LitheStatus copy_corners(LitheCtx *ctx, const LitheIndex *first, const double *points,
                                LthLoops *l) {
  LTH_NEW(ctx, l->first, l->n_loops + 1);
  LTH_NEW(ctx, l->points, 2 * (LitheCount)first[l->n_loops] + 1);
  LTH_NEW(ctx, l->next, first[l->n_loops] + 1);
  LTH_NEW(ctx, l->prev, first[l->n_loops] + 1);
  for (LitheIndex k = 0; k < l->n_loops; k++) {
    LitheIndex begin = l->n_points;
    for (LitheIndex i = first[k]; i < first[k + 1]; i++) {
      const double *x = points + 2 * (size_t)i;
      const double *before = points + 2 * (size_t)(i == first[k] ? first[k + 1] - 1 : i - 1);
      if (x[0] == before[0] && x[1] == before[1]) continue;
      double *kept = l->points + 2 * (size_t)l->n_points++;
      kept[0] = x[0], kept[1] = x[1];
    }
    l->first[k + 1] = l->n_points;
    for (LitheIndex i = begin; i < l->n_points; i++) {
      l->next[i] = i + 1 < l->n_points ? i + 1 : begin;
      l->prev[i] = i > begin ? i - 1 : l->n_points - 1;
    }
  }
  return LITHE_OK;
}

static LitheStatus build_tree(LitheCtx *ctx, LthLoops *l) {
  double *boxes = NULL;
  LTH_NEW(ctx, boxes, 6 * (LitheCount)l->n_points);
  for (LitheIndex i = 0; i < l->n_points; i++) {
    const double *p = corner(l, i), *q = corner(l, l->next[i]);
    for (int a = 0; a < 2; a++) {
      boxes[6 * (size_t)i + (size_t)a] = fmin(p[a], q[a]);
      boxes[6 * (size_t)i + 3 + (size_t)a] = fmax(p[a], q[a]);
    }
  }
  LitheStatus status = lth_bvh_create_boxes(ctx, l->n_points, boxes, &l->bvh);
  lth_free(ctx, boxes);
  return status;
}

/// Turn every loop the right way round and sum up areas.
static LitheStatus orient(LitheCtx *ctx, LthLoops *l) {
  for (int a = 0; a < 2; a++) l->box[a] = INFINITY, l->box[2 + a] = -INFINITY;
  for (LitheIndex i = 0; i < l->n_points; i++)
    for (int a = 0; a < 2; a++) {
      l->box[a] = fmin(l->box[a], corner(l, i)[a]);
      l->box[2 + a] = fmax(l->box[2 + a], corner(l, i)[a]);
    }
  for (LitheIndex k = 0; k < l->n_loops; k++) {
    LitheIndex n = l->first[k + 1] - l->first[k];
    if (n < 3)
      LITHE_FAIL(ctx, LITHE_BAD_INPUT,
                 "loop %d of the polygon has %d different corners; expected "
                 "at least three",
                 k + 1, n);
    double area2 = lth_loop_area2(l, k);
    if (!isfinite(area2))
      LITHE_FAIL(ctx, LITHE_BAD_INPUT, "loop %d of the polygon is too large for an area", k + 1);
    if (area2 == 0) continue; // lth_loops_check() tells why
    if ((area2 > 0) != (k == 0)) reverse(l, k);
    l->area += (k == 0 ? 0.5 : -0.5) * fabs(area2);
  }
  return LITHE_OK;
}

LitheStatus lth_loops_create(LitheCtx *ctx, LitheIndex n_loops, const LitheIndex *first,
                             const double *points, LthLoops **loops) {
  LitheStatus status = LITHE_OK;
  LthLoops *l = NULL;
  *loops = NULL;
  LTH_NEW(ctx, l, 1);
  l->n_loops = n_loops;
  LITHE_TRY_OR(done, copy_corners(ctx, first, points, l));
  LITHE_TRY_OR(done, orient(ctx, l));
  LITHE_TRY_OR(done, build_tree(ctx, l));
  LITHE_TRY_OR(done, lth_loops_check(ctx, l));
done:
  if (status != LITHE_OK) lth_loops_destroy(ctx, &l);
  *loops = l;
  return status;
}

/// Point of edge i nearest to x and its parameter in [0, 1].
static double nearest_on_edge(const LthLoops *l, LitheIndex i, const double x[2],
                              double nearest[2]) {
  const double *p = corner(l, i), *q = corner(l, l->next[i]);
  double d[2] = {q[0] - p[0], q[1] - p[1]}, length2 = d[0] * d[0] + d[1] * d[1];
  double s = ((x[0] - p[0]) * d[0] + (x[1] - p[1]) * d[1]) / length2;
  s = !(s > 0) ? 0 : s < 1 ? s : 1;
  // from the nearer end, so that ends come out to the bit
  for (int a = 0; a < 2; a++) nearest[a] = s < 0.5 ? p[a] + s * d[a] : q[a] - (1 - s) * d[a];
  return s;
}

static double edge_distance2(void *self, LitheIndex item, const double x[3], double limit) {
  (void)limit;
  double q[2];
  nearest_on_edge(self, item, x, q);
  return (x[0] - q[0]) * (x[0] - q[0]) + (x[1] - q[1]) * (x[1] - q[1]);
}

/// Outward normal of an edge, of length 1.
static void edge_normal(const LthLoops *l, LitheIndex i, double normal[2]) {
  const double *p = corner(l, i), *q = corner(l, l->next[i]);
  double length = hypot(q[0] - p[0], q[1] - p[1]);
  normal[0] = (q[1] - p[1]) / length;
  normal[1] = (p[0] - q[0]) / length;
}

/// Side of a corner on which x lies: positive outside.
static double corner_side(const LthLoops *l, LitheIndex i, const double x[2], double normal[2]) {
  double before[2], behind[2];
  edge_normal(l, l->prev[i], before);
  edge_normal(l, i, behind);
  double sum[2] = {before[0] + behind[0], before[1] + behind[1]};
  double length = hypot(sum[0], sum[1]);
  for (int a = 0; a < 2; a++) normal[a] = length > 0 ? sum[a] / length : behind[a];
  return (x[0] - corner(l, i)[0]) * sum[0] + (x[1] - corner(l, i)[1]) * sum[1];
}

double lth_loops_distance(const LthLoops *l, const double x[2], double nearest[2],
                          double normal[2]) {
  double place[3] = {x[0], x[1], 0}, distance2 = INFINITY, q[2], n[2];
  LitheIndex edge =
      lth_bvh_nearest(l->bvh, place, edge_distance2, (void *)(uintptr_t)l, &distance2);
  LITHE_ASSERT(edge >= 0);
  double s = nearest_on_edge(l, edge, x, q), side;
  if (s > 0 && s < 1) {
    edge_normal(l, edge, n);
    side = -lth_orient2d(corner(l, edge), corner(l, l->next[edge]), x);
    if (side == 0) distance2 = 0;
  } else {
    side = corner_side(l, s > 0 ? l->next[edge] : edge, x, n);
  }
  double distance = distance2 > 0 ? hypot(x[0] - q[0], x[1] - q[1]) : 0;
  for (int a = 0; a < 2 && distance > 0; a++) n[a] = (side > 0 ? 1 : -1) * (x[a] - q[a]) / distance;
  for (int a = 0; a < 2 && nearest; a++) nearest[a] = q[a];
  for (int a = 0; a < 2 && normal; a++) normal[a] = n[a];
  return side > 0 ? distance : -distance;
}
