/// A plane in hand: one sign for each point, and one new point for each edge that it cuts.
#include "mesh/topology_priv.h"

#define REACH_SHARE 1e-13
#define REACH_ULPS 32

void lth_topology_plane(const LthTopology *t, const LthPlane *plane, double out[4]) {
  double d[3];
  lth_v3_copy(plane->normal, out);
  lth_v3_normalize(out);
  lth_v3_sub(plane->point, t->origin, d);
  out[3] = lth_v3_dot(out, d);
}

double lth_topology_reach(const LthTopology *t, LitheIndex cell, const double plane[4]) {
  const double *box = t->cells[cell].box;
  double size[3];
  lth_v3_sub(box + 3, box, size);
  double ulp = t->rounding + 0x1p-52 * fabs(plane[3]);
  return fmax(REACH_SHARE * lth_v3_norm(size), REACH_ULPS * ulp);
}

void lth_topology_forget_cuts(LthTopology *t) {
  t->work->cut_now++;
  t->work->n_cuts = 0;
}

void lth_topology_take_plane(LthTopology *t, const double plane[4], double reach) {
  LthTopologyWork *w = t->work;
  memcpy(w->plane, plane, sizeof w->plane);
  w->reach = reach;
  w->stamp++;
  lth_topology_forget_cuts(t);
}

static LitheStatus room_for_points(LitheCtx *ctx, LthTopology *t) {
  LthTopologyWork *w = t->work;
  LTH_RESERVE(ctx, w->point_stamp, w->point_stamp_cap, t->n_points);
  LTH_RESERVE(ctx, w->point_sign, w->point_sign_cap, t->n_points);
  LTH_RESERVE(ctx, w->point_height, w->point_height_cap, t->n_points);
  return LITHE_OK;
}

static int8_t sign_of(LthTopology *t, LitheIndex point) {
  LthTopologyWork *w = t->work;
  if (w->point_stamp[point] == w->stamp) return w->point_sign[point];
  double d[3];
  lth_v3_sub(t->points + 3 * (LitheCount)point, t->origin, d);
  double height = lth_v3_dot(w->plane, d) - w->plane[3];
  w->point_stamp[point] = w->stamp;
  w->point_height[point] = height;
  w->point_sign[point] = (int8_t)((height > w->reach) - (height < -w->reach));
  return w->point_sign[point];
}

LitheStatus lth_topology_classify(LitheCtx *ctx, LthTopology *t, LitheIndex cell, int *side) {
  bool any[2] = {false, false};
  LITHE_TRY(room_for_points(ctx, t));
  const LthTopologyCell *c = t->cells + cell;
  for (LitheIndex i = 0; i < c->n_faces; i++) {
    const LthTopologyFace *f = t->faces + t->pool[c->block + i];
    const LitheIndex *corner = lth_topology_loops(t, f) + f->n_loops + 1;
    for (LitheIndex j = 0; j < f->n_corners; j++) {
      int8_t sign = sign_of(t, corner[j]);
      any[0] |= sign < 0;
      any[1] |= sign > 0;
    }
  }
  *side = any[0] && any[1] ? 0 : any[1] ? 1 : -1;
  return LITHE_OK;
}

static LitheCount slot_of(const LthTopologyWork *w, uint64_t key) {
  uint64_t h = key * 0x9E3779B97F4A7C15u;
  LitheCount mask = w->cut_cap - 1, i = (LitheCount)((h ^ h >> 32) & (uint64_t)mask);
  while (w->cut_stamp[i] == w->cut_now && w->cut_key[i] != key) i = (i + 1) & mask;
  return i;
}

LitheIndex lth_topology_find_cut(const LthTopology *t, LitheIndex a, LitheIndex b) {
  const LthTopologyWork *w = t->work;
  if (w->n_cuts == 0) return -1;
  LitheCount i = slot_of(w, lth_topology_edge_key(a, b));
  return w->cut_stamp[i] == w->cut_now ? w->cut_point[i] : -1;
}

static LitheStatus grow_cuts(LitheCtx *ctx, LthTopologyWork *w) {
  LthTopologyWork old = *w;
  LitheStatus status = LITHE_OK;
  w->cut_cap = old.cut_cap ? 2 * old.cut_cap : 64;
  w->cut_key = NULL, w->cut_point = NULL, w->cut_stamp = NULL;
  LTH_NEW_OR(done, ctx, w->cut_key, w->cut_cap);
  LTH_NEW_OR(done, ctx, w->cut_point, w->cut_cap);
  LTH_NEW_OR(done, ctx, w->cut_stamp, w->cut_cap);
  if (w->cut_now == 0) w->cut_now = old.cut_now = 1;
  for (LitheCount i = 0; i < old.cut_cap; i++) {
    if (old.cut_stamp[i] != old.cut_now) continue;
    LitheCount j = slot_of(w, old.cut_key[i]);
    w->cut_key[j] = old.cut_key[i];
    w->cut_point[j] = old.cut_point[i];
    w->cut_stamp[j] = w->cut_now;
  }
done:
  lth_free(ctx, old.cut_key);
  lth_free(ctx, old.cut_point);
  lth_free(ctx, old.cut_stamp);
  if (status != LITHE_OK) w->cut_cap = 0;
  return status;
}

static bool is_before(const double *a, const double *b) {
  for (int i = 0; i < 3; i++)
    if (a[i] != b[i]) return a[i] < b[i];
  return false;
}

/// Point of the segment a b where heights are as given: from the end nearer to the plane, never outside the box
/// of the ends, and by coordinates alone, so that coincident edges are cut in coincident points.
static void intersect(const double *a, const double *b, double ha, double hb, double x[3]) {
  bool near_b = fabs(hb) < fabs(ha);
  double s = near_b ? hb / (hb - ha) : ha / (ha - hb);
  for (int i = 0; i < 3; i++) {
    double lo = fmin(a[i], b[i]), hi = fmax(a[i], b[i]);
    x[i] = near_b ? b[i] - s * (b[i] - a[i]) : a[i] + s * (b[i] - a[i]);
    if (!(x[i] >= lo)) x[i] = lo;
    if (x[i] > hi) x[i] = hi;
  }
}

/// A point on an edge lies on the planes of the edge and on the one that cuts it. An edge lies on a plane less than
/// its ends at most; ends that share no plane make the point count for more than it is, which is harmless.
static uint8_t rank_on_edge(const LthTopology *t, LitheIndex a, LitheIndex b) {
  uint8_t p = t->point_rank[a], q = t->point_rank[b], low = p < q ? p : q;
  return low < 3 ? (uint8_t)(low + 1) : low;
}

LitheStatus lth_topology_cut_edge(LitheCtx *ctx, LthTopology *t, LitheIndex a, LitheIndex b,
                                  LitheIndex *point) {
  LthTopologyWork *w = t->work;
  if (2 * (w->n_cuts + 1) > w->cut_cap) LITHE_TRY(grow_cuts(ctx, w));
  LitheCount slot = slot_of(w, lth_topology_edge_key(a, b));
  *point = w->cut_point[slot];
  if (w->cut_stamp[slot] == w->cut_now) return LITHE_OK;
  double x[3];
  const double *p = t->points + 3 * (LitheCount)a, *q = t->points + 3 * (LitheCount)b;
  if (is_before(q, p))
    intersect(q, p, w->point_height[b], w->point_height[a], x);
  else
    intersect(p, q, w->point_height[a], w->point_height[b], x);
  LITHE_TRY(lth_topology_add_point(ctx, t, x, point));
  t->point_rank[*point] = rank_on_edge(t, a, b);
  LTH_RESERVE(ctx, w->fresh, w->fresh_cap, w->n_fresh + 1);
  w->fresh[w->n_fresh++] = *point;
  LITHE_TRY(room_for_points(ctx, t));
  w->point_stamp[*point] = w->stamp;
  w->point_sign[*point] = 0;
  w->point_height[*point] = 0;
  w->cut_key[slot] = lth_topology_edge_key(a, b);
  w->cut_point[slot] = *point;
  w->cut_stamp[slot] = w->cut_now;
  w->n_cuts++;
  return LITHE_OK;
}
