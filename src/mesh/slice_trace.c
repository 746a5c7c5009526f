/// Cycles of edges to loops of points.
#include "mesh/slice.h"

#include "base/tensor.h"

#include <math.h>
#include <stdlib.h>

/// Edges of one cycle in the order of their starts.
typedef struct Tracer {
  const Slicer *s;
  int axis;
  LitheIndex *edge; ///< (n x 2)
  bool *used;
  LitheIndex n;
} Tracer;

static int compare_starts(const void *a, const void *b) {
  const LitheIndex *x = a, *y = b;
  if (x[0] != y[0]) return x[0] < y[0] ? -1 : 1;
  return (x[1] > y[1]) - (x[1] < y[1]);
}

static void sort_edges(LitheIndex *edge, LitheIndex n) {
  if (n > 12) {
    qsort(edge, (size_t)n, 2 * sizeof *edge, compare_starts);
    return;
  }
  for (LitheIndex i = 1; i < n; i++) {
    LitheIndex a = edge[2 * i], b = edge[2 * i + 1], j = i;
    for (; j > 0 && (edge[2 * j - 2] > a || (edge[2 * j - 2] == a && edge[2 * j - 1] > b)); j--) {
      edge[2 * j] = edge[2 * j - 2];
      edge[2 * j + 1] = edge[2 * j - 1];
    }
    edge[2 * j] = a;
    edge[2 * j + 1] = b;
  }
}

/// First edge that starts at a point.
static LitheIndex first_from(const Tracer *t, LitheIndex point) {
  LitheIndex lo = 0, hi = t->n;
  while (lo < hi) {
    LitheIndex mid = (lo + hi) / 2;
    if (t->edge[2 * mid] < point)
      lo = mid + 1;
    else
      hi = mid;
  }
  return lo;
}

/// Clockwise angle from looking back along a b to looking on along b c, in (0, 2 pi]; the smallest is
/// the sharpest left turn.
static double turn(const Tracer *t, LitheIndex a, LitheIndex b, LitheIndex c) {
  int u = (t->axis + 1) % 3, v = (t->axis + 2) % 3;
  double in[3], out[3];
  lth_v3_sub(t->s->point + 3 * (LitheCount)a, t->s->point + 3 * (LitheCount)b, in);
  lth_v3_sub(t->s->point + 3 * (LitheCount)c, t->s->point + 3 * (LitheCount)b, out);
  double angle = atan2(out[u] * in[v] - out[v] * in[u], out[u] * in[u] + out[v] * in[v]);
  return angle > 0 ? angle : angle + 2 * M_PI;
}

/// The edge to follow after edge e, -1 where the loop that began with `start` closes.
static LitheIndex next_edge(const Tracer *t, LitheIndex e, LitheIndex start) {
  LitheIndex at = t->edge[2 * e + 1], first = first_from(t, at), best = start;
  double best_turn = INFINITY;
  bool is_only = first + 1 == t->n || (first < t->n && t->edge[2 * first + 2] != at);
  if (is_only) return first == start ? -1 : first;
  for (LitheIndex i = first; i < t->n && t->edge[2 * i] == at; i++) {
    if (t->used[i] && i != start) continue;
    double angle = t->axis < 3 ? turn(t, t->edge[2 * e], at, t->edge[2 * i + 1]) : (double)i;
    if (angle >= best_turn) continue;
    best_turn = angle;
    best = i;
  }
  return best == start ? -1 : best;
}

LitheStatus lth_slice_add_loop_point(Slicer *s, LitheIndex point) {
  SliceParts *parts = &s->parts;
  LTH_RESERVE(s->ctx, parts->point, parts->point_cap, parts->n_points + 1);
  parts->point[parts->n_points++] = point;
  return LITHE_OK;
}

LitheStatus lth_slice_end_loop(Slicer *s) {
  SliceParts *parts = &s->parts;
  if (parts->n_points >= INT32_MAX)
    LITHE_FAIL(s->ctx, LITHE_UNSUPPORTED, "slicing: more than 2^31 corners; use larger cells");
  LTH_RESERVE(s->ctx, parts->off, parts->off_cap, parts->n_loops + 2);
  parts->off[++parts->n_loops] = (LitheIndex)parts->n_points;
  return LITHE_OK;
}

static LitheStatus trace_all(Slicer *s, Tracer *t) {
  for (LitheIndex start = 0; start < t->n; start++) {
    if (t->used[start]) continue;
    for (LitheIndex e = start; e >= 0; e = next_edge(t, e, start)) {
      t->used[e] = true;
      LITHE_TRY(lth_slice_add_loop_point(s, t->edge[2 * e]));
    }
    LITHE_TRY(lth_slice_end_loop(s));
  }
  return LITHE_OK;
}

#define SMALL_CYCLE 64

LitheStatus lth_slice_trace(Slicer *s, int axis, const LitheIndex *edge, LitheIndex n) {
  LitheIndex small_edge[2 * SMALL_CYCLE];
  bool small_used[SMALL_CYCLE];
  Tracer t = {.s = s, .axis = axis, .n = n, .edge = small_edge, .used = small_used};
  LitheStatus status = LITHE_OK;
  if (n > SMALL_CYCLE) {
    t.edge = NULL, t.used = NULL;
    LTH_NEW_OR(done, s->ctx, t.edge, 2 * (LitheCount)n);
    LTH_NEW_OR(done, s->ctx, t.used, n);
  }
  for (LitheIndex i = 0; i < 2 * n; i++) t.edge[i] = edge[i];
  for (LitheIndex i = 0; i < n; i++) t.used[i] = false;
  sort_edges(t.edge, n);
  LITHE_TRY_OR(done, trace_all(s, &t));
done:
  if (n > SMALL_CYCLE) {
    lth_free(s->ctx, t.edge);
    lth_free(s->ctx, t.used);
  }
  return status;
}

double lth_slice_loop_area(const double *points, const LitheIndex *loop, LitheIndex n, int axis) {
  int u = (axis + 1) % 3, v = (axis + 2) % 3;
  const double *o = points + 3 * (LitheCount)loop[0];
  double twice = 0;
  for (LitheIndex i = 1; i + 1 < n; i++) {
    const double *a = points + 3 * (LitheCount)loop[i], *b = points + 3 * (LitheCount)loop[i + 1];
    twice += (a[u] - o[u]) * (b[v] - o[v]) - (a[v] - o[v]) * (b[u] - o[u]);
  }
  return twice / 2;
}

void lth_slice_area_vector(const double *points, const LitheIndex *loop, LitheIndex n,
                           double vector[3]) {
  for (int axis = 0; axis < 3; axis++) vector[axis] = lth_slice_loop_area(points, loop, n, axis);
}
