/// Ear clipping (Meisters 1975) with exact orientation tests.
#include "geometry/polygon.h"

#include "base/tensor.h"
#include "geometry/predicates.h"

/// Up to this many corners the ear with the shortest diagonal is taken, which avoids slivers.
#define CHOOSY_MAX 64
#define SPIKE 1e-13 ///< tangent of an angle that is rounding of places which cuts have made

typedef struct Ring {
  const double *points;
  const LitheIndex *corner;
  LthPolygonWork *work;
} Ring;

void lth_polygon_work_free(LitheCtx *ctx, LthPolygonWork *work) {
  lth_free(ctx, work->xy);
  lth_free(ctx, work->next);
  lth_free(ctx, work->prev);
  lth_free(ctx, work->is_reflex);
  *work = (LthPolygonWork){0};
}

void lth_polygon_normal(const double *points, LitheIndex n, const LitheIndex *corner,
                        double normal[3]) {
  const double *origin = points + 3 * (size_t)corner[0];
  double a[3], b[3], cross[3];
  normal[0] = normal[1] = normal[2] = 0;
  for (LitheIndex i = 1; i + 1 < n; i++) {
    lth_v3_sub(points + 3 * (size_t)corner[i], origin, a);
    lth_v3_sub(points + 3 * (size_t)corner[i + 1], origin, b);
    lth_v3_cross(a, b, cross);
    lth_v3_add(normal, cross, normal);
  }
}

/// Drop the coordinate along which the normal is longest, so that the ring turns counter-clockwise;
/// false where the polygon has no area.
static bool project(const Ring *ring, LitheIndex n) {
  double normal[3];
  lth_polygon_normal(ring->points, n, ring->corner, normal);
  int axis = 0;
  for (int i = 1; i < 3; i++)
    if (fabs(normal[i]) > fabs(normal[axis])) axis = i;
  if (!(fabs(normal[axis]) > 0)) return false;
  int u = (axis + 1) % 3, v = (axis + 2) % 3;
  if (normal[axis] < 0) {
    int swap = u;
    u = v;
    v = swap;
  }
  for (LitheIndex i = 0; i < n; i++) {
    const double *x = ring->points + 3 * (size_t)ring->corner[i];
    ring->work->xy[2 * i] = x[u];
    ring->work->xy[2 * i + 1] = x[v];
  }
  return true;
}

static int turn(const Ring *ring, LitheIndex i, LitheIndex j, LitheIndex k) {
  const double *xy = ring->work->xy;
  return lth_orient2d(xy + 2 * i, xy + 2 * j, xy + 2 * k);
}

static bool same_place(const Ring *ring, LitheIndex i, LitheIndex j) {
  const double *xy = ring->work->xy;
  return xy[2 * i] == xy[2 * j] && xy[2 * i + 1] == xy[2 * j + 1];
}

/// A convex corner whose triangle holds no other corner, not even on its border.
static bool is_ear(const Ring *ring, LitheIndex i) {
  const LthPolygonWork *w = ring->work;
  if (w->is_reflex[i]) return false;
  LitheIndex p = w->prev[i], q = w->next[i];
  for (LitheIndex k = w->next[q]; k != p; k = w->next[k]) {
    // corners that coincide with the triangle's own belong to bridges towards holes
    if (!w->is_reflex[k] || same_place(ring, k, p) || same_place(ring, k, i) ||
        same_place(ring, k, q))
      continue;
    if (turn(ring, p, i, k) >= 0 && turn(ring, i, q, k) >= 0 && turn(ring, q, p, k) >= 0)
      return false;
  }
  return true;
}

static double diagonal(const Ring *ring, LitheIndex i) {
  LitheIndex p = ring->work->prev[i], q = ring->work->next[i];
  return lth_v3_distance(ring->points + 3 * (size_t)ring->corner[p],
                         ring->points + 3 * (size_t)ring->corner[q]);
}

/// Does the ring turn back here on the way that it came? So it does where a part is clipped that touches the rest in one corner, in
/// the middle of an edge: to rounding, it may then turn either way.
static bool is_spike(const Ring *ring, LitheIndex i) {
  const double *xy = ring->work->xy;
  LitheIndex p = ring->work->prev[i], q = ring->work->next[i];
  double e[2] = {xy[2 * i] - xy[2 * p], xy[2 * i + 1] - xy[2 * p + 1]};
  double f[2] = {xy[2 * q] - xy[2 * i], xy[2 * q + 1] - xy[2 * i + 1]};
  return fabs(e[0] * f[1] - e[1] * f[0]) < -SPIKE * (e[0] * f[0] + e[1] * f[1]);
}

/// The ear to clip next among `left` corners from `start` on, -1 if there is none.
static LitheIndex find_ear(const Ring *ring, LitheIndex left, LitheIndex start) {
  LitheIndex best = -1, i = start;
  double shortest = INFINITY;
  for (LitheIndex k = 0; k < left; k++, i = ring->work->next[i]) {
    if (is_spike(ring, i)) return i;
    if (!is_ear(ring, i)) continue;
    if (left > CHOOSY_MAX) return i;
    double length = diagonal(ring, i);
    if (length < shortest) {
      shortest = length;
      best = i;
    }
  }
  return best;
}

static void update_reflex(const Ring *ring, LitheIndex i) {
  LthPolygonWork *w = ring->work;
  w->is_reflex[i] = turn(ring, w->prev[i], i, w->next[i]) <= 0;
}

/// Cut off corner i; its triangle goes to `tri`.
static void clip(const Ring *ring, LitheIndex i, LitheIndex *tri) {
  LthPolygonWork *w = ring->work;
  LitheIndex p = w->prev[i], q = w->next[i];
  tri[0] = ring->corner[p];
  tri[1] = ring->corner[i];
  tri[2] = ring->corner[q];
  w->next[p] = q;
  w->prev[q] = p;
}

static void clip_all(const Ring *ring, LitheIndex n, LitheIndex *tris) {
  LthPolygonWork *w = ring->work;
  bool has_plane = project(ring, n), has_ears = has_plane;
  for (LitheIndex i = 0; i < n; i++) {
    w->next[i] = i + 1 < n ? i + 1 : 0;
    w->prev[i] = i > 0 ? i - 1 : n - 1;
  }
  for (LitheIndex i = 0; has_plane && i < n; i++) update_reflex(ring, i);

  LitheIndex at = 0;
  for (LitheIndex left = n; left >= 3; left--) {
    LitheIndex ear = has_ears && left > 3 ? find_ear(ring, left, at) : -1;
    if (ear < 0 && left > 3) has_ears = false;
    if (ear < 0) ear = w->next[at];
    LitheIndex p = w->prev[ear], q = w->next[ear];
    clip(ring, ear, tris + 3 * (size_t)(n - left));
    if (has_ears) update_reflex(ring, p), update_reflex(ring, q);
    // a fan keeps its hub, ears move on
    at = has_ears ? q : p;
  }
}

LitheStatus lth_polygon_triangulate(LitheCtx *ctx, LthPolygonWork *work, const double *points,
                                    LitheIndex n, const LitheIndex *corner, LitheIndex *tris) {
  if (n == 3) {
    for (int i = 0; i < 3; i++) tris[i] = corner[i];
    return LITHE_OK;
  }
  LTH_RESERVE(ctx, work->xy, work->xy_cap, 2 * (LitheCount)n);
  LTH_RESERVE(ctx, work->next, work->next_cap, n);
  LTH_RESERVE(ctx, work->prev, work->prev_cap, n);
  LTH_RESERVE(ctx, work->is_reflex, work->reflex_cap, n);
  Ring ring = {points, corner, work};
  clip_all(&ring, n, tris);
  return LITHE_OK;
}
