/// A plane and a cell: one sign for each point, and the faces as chains below and above.
///
/// As in slice_clip.c every face is a cycle of directed edges. An edge with its ends on different sides is cut in a
/// new point; places where the cycle passes the plane are sorted along the cut and joined in pairs by closing
/// edges, which go to both sides with opposite signs. Points on the plane have the sign 0: an edge between two
/// of them is on the side of the face's inside, and a corner that touches the plane from one side passes it
/// twice, so that closing edges end at it. Whole faces in the plane are where the cell is that they bound. The cap is
/// minus the sum of what all faces leave in the plane on the lower side, so both sides are closed by construction.
#include "mesh/topology_priv.h"

#include <stdlib.h>

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
  t->off_plane = fmax(t->off_plane, reach);
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

// --- new points on edges

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

/// The point in which an edge meets the plane, the same for all that ask.
static LitheStatus cut_edge(LitheCtx *ctx, LthTopology *t, LitheIndex a, LitheIndex b,
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

// --- one face

static LitheStatus add_crossing(LitheCtx *ctx, LthTopologyWork *w, LitheIndex point,
                                LitheIndex sign) {
  LTH_RESERVE(ctx, w->cross, w->cross_cap, w->n_cross + 1);
  w->cross[w->n_cross++] = (TopologyCrossing){{0, 0, 0}, point, sign};
  return LITHE_OK;
}

/// Side of an edge between two points on the plane: that of the face's inside, on its left.
static int side_of_edge(const LthTopology *t, const double normal[3], LitheIndex a, LitheIndex b) {
  double d[3], left[3];
  lth_v3_sub(t->points + 3 * (LitheCount)b, t->points + 3 * (LitheCount)a, d);
  lth_v3_cross(normal, d, left);
  return lth_v3_dot(left, t->work->plane) > 0;
}

/// Note that the cycle goes from one side (0 below, 1 above) to another at a point on the plane. One that comes back to
/// the side that it came from has been at the plane: it passes twice.
static LitheStatus pass(LitheCtx *ctx, LthTopologyWork *w, LitheIndex point, int from, int to) {
  LITHE_TRY(add_crossing(ctx, w, point, from == 0 ? 1 : -1));
  return from == to ? add_crossing(ctx, w, point, from == 0 ? -1 : 1) : LITHE_OK;
}

/// Put the edges of one loop on their sides.
static LitheStatus clip_loop(LitheCtx *ctx, LthTopology *t, LitheIndex face, LitheIndex loop) {
  LthTopologyWork *w = t->work;
  const LthTopologyFace *f = t->faces + face;
  LitheIndex first = t->pool[f->block + loop], last = t->pool[f->block + loop + 1];
  LitheCount corner = f->block + f->n_loops + 1;
  int first_side = -1, at_side = -1;
  for (LitheIndex j = first; j < last; j++) {
    LitheIndex a = t->pool[corner + j], b = t->pool[corner + (j + 1 < last ? j + 1 : first)];
    int8_t sa = w->point_sign[a], sb = w->point_sign[b];
    int side = sa ? sa > 0 : sb ? sb > 0 : side_of_edge(t, f->plane, a, b);
    if (sa == 0 && at_side >= 0) LITHE_TRY(pass(ctx, w, a, at_side, side));
    if (first_side < 0) first_side = side;
    at_side = side;
    if (sa * sb >= 0) {
      LITHE_TRY(lth_topology_chain_add(ctx, &w->chain[side], a, b));
      continue;
    }
    LitheIndex p = 0;
    LITHE_TRY(cut_edge(ctx, t, a, b, &p));
    LITHE_TRY(lth_topology_chain_add(ctx, &w->chain[side], a, p));
    LITHE_TRY(lth_topology_chain_add(ctx, &w->chain[1 - side], p, b));
    LITHE_TRY(add_crossing(ctx, w, p, side == 0 ? 1 : -1));
    at_side = 1 - side;
  }
  LitheIndex begin = t->pool[corner + first];
  return w->point_sign[begin] == 0 ? pass(ctx, w, begin, at_side, first_side) : LITHE_OK;
}

static int compare_crossings(const void *a, const void *b) {
  const TopologyCrossing *x = a, *y = b;
  for (int i = 0; i < 3; i++)
    if (x->key[i] != y->key[i]) return x->key[i] < y->key[i] ? -1 : 1;
  if (x->point != y->point) return x->point < y->point ? -1 : 1;
  return (x->sign > y->sign) - (x->sign < y->sign);
}

/// All points of a cut lie on a line up to rounding, so the coordinate in which they extend most orders them,
/// however flat the face meets the plane.
static void sort_crossings(LthTopology *t) {
  LthTopologyWork *w = t->work;
  double lo[3] = {INFINITY, INFINITY, INFINITY}, hi[3] = {-INFINITY, -INFINITY, -INFINITY};
  for (LitheCount i = 0; i < w->n_cross; i++)
    for (int a = 0; a < 3; a++) {
      double x = t->points[3 * (LitheCount)w->cross[i].point + a];
      lo[a] = fmin(lo[a], x);
      hi[a] = fmax(hi[a], x);
    }
  int order[3] = {0, 1, 2};
  for (int i = 0; i < 2; i++)
    for (int j = 0; j < 2 - i; j++)
      if (hi[order[j]] - lo[order[j]] < hi[order[j + 1]] - lo[order[j + 1]]) {
        int swap = order[j];
        order[j] = order[j + 1];
        order[j + 1] = swap;
      }
  for (LitheCount i = 0; i < w->n_cross; i++)
    for (int a = 0; a < 3; a++)
      w->cross[i].key[a] = t->points[3 * (LitheCount)w->cross[i].point + order[a]];
  qsort(w->cross, (size_t)w->n_cross, sizeof *w->cross, compare_crossings);
}

/// The lower side goes from where it was left to where it was entered again. `is_owner`: the cell is on the inside.
static LitheStatus close_pair(LitheCtx *ctx, LthTopologyWork *w, bool is_owner, LitheIndex up,
                              LitheIndex down) {
  LITHE_TRY(lth_topology_chain_add(ctx, &w->chain[0], up, down));
  LITHE_TRY(lth_topology_chain_add(ctx, &w->chain[1], down, up));
  return lth_topology_chain_add(ctx, &w->cap, is_owner ? down : up, is_owner ? up : down);
}

/// Join crossings in pairs, first in, first out: where rounding swapped neighbours the pairs are still those that
/// belong together, and every point keeps one edge in and one edge out.
static LitheStatus close_cut(LitheCtx *ctx, LthTopology *t, bool is_owner) {
  LthTopologyWork *w = t->work;
  if (w->n_cross > 2) sort_crossings(t);
  LTH_RESERVE(ctx, w->queue, w->queue_cap, w->n_cross);
  LitheCount head = 0, tail = 0;
  LitheIndex sign = 0;
  for (LitheCount i = 0; i < w->n_cross; i++) {
    if (head == tail || w->cross[i].sign == sign) {
      sign = w->cross[i].sign;
      w->queue[tail++] = w->cross[i].point;
      continue;
    }
    LitheIndex other = w->queue[head++];
    LITHE_TRY(close_pair(ctx, w, is_owner, sign > 0 ? other : w->cross[i].point,
                         sign > 0 ? w->cross[i].point : other));
  }
  LITHE_ASSERT(head == tail);
  return LITHE_OK;
}

/// An edge in the plane, of a face below or above: it goes to the cap from below, and it may be a ridge.
static LitheStatus note_edge(LitheCtx *ctx, LthTopology *t, LitheIndex cell, LitheIndex face,
                             int side, bool is_in_plane, LitheIndex a, LitheIndex b) {
  LthTopologyWork *w = t->work;
  bool is_owner = t->faces[face].cell[0] == cell;
  if (side == 0)
    LITHE_TRY(lth_topology_chain_add(ctx, &w->cap, is_owner ? b : a, is_owner ? a : b));
  if (is_in_plane) return LITHE_OK;
  LTH_RESERVE(ctx, w->edges, w->edges_cap, w->n_ridges + 1);
  w->edges[w->n_ridges++] =
      (TopologyEdge){lth_topology_edge_key(a, b), face, (a < b) == is_owner ? 1 : -1};
  return LITHE_OK;
}

static LitheStatus note_edges(LitheCtx *ctx, LthTopology *t, LitheIndex cell, LitheIndex face,
                              int side_of_all, bool is_in_plane) {
  const LthTopologyFace *f = t->faces + face;
  LitheCount corner = f->block + f->n_loops + 1;
  for (LitheIndex l = 0; l < f->n_loops; l++) {
    LitheIndex first = t->pool[f->block + l], last = t->pool[f->block + l + 1];
    for (LitheIndex j = first; j < last; j++) {
      LitheIndex a = t->pool[corner + j], b = t->pool[corner + (j + 1 < last ? j + 1 : first)];
      if (t->work->point_sign[a] || t->work->point_sign[b]) continue;
      int side = side_of_all >= 0 ? side_of_all : side_of_edge(t, f->plane, a, b);
      LITHE_TRY(note_edge(ctx, t, cell, face, side, is_in_plane, a, b));
    }
  }
  return LITHE_OK;
}

static LitheStatus whole_part(LitheCtx *ctx, LthTopology *t, LitheIndex face, int side) {
  LthTopologyWork *w = t->work;
  LTH_RESERVE(ctx, w->parts, w->parts_cap, w->n_parts + 1);
  w->parts[w->n_parts++] = (TopologyPart){.face = face, .side = side, .cell = {-1, -1}};
  return LITHE_OK;
}

static LitheStatus clip_face(LitheCtx *ctx, LthTopology *t, LitheIndex cell, LitheIndex face,
                             bool *is_clean) {
  LthTopologyWork *w = t->work;
  const LthTopologyFace *f = t->faces + face;
  const LitheIndex *corner = lth_topology_loops(t, f) + f->n_loops + 1;
  bool any[2] = {false, false}, is_owner = f->cell[0] == cell;
  LitheIndex n_on = 0;
  for (LitheIndex j = 0; j < f->n_corners; j++) {
    any[0] |= w->point_sign[corner[j]] < 0;
    any[1] |= w->point_sign[corner[j]] > 0;
    n_on += w->point_sign[corner[j]] == 0;
  }
  if (!(any[0] && any[1])) {
    int side = any[1];
    if (!any[0] && !any[1]) side = (lth_v3_dot(f->plane, w->plane) > 0) != is_owner;
    if (n_on > 1) LITHE_TRY(note_edges(ctx, t, cell, face, side, !any[0] && !any[1]));
    return whole_part(ctx, t, face, side);
  }
  w->chain[0].n = w->chain[1].n = w->n_cross = 0;
  for (LitheIndex l = 0; l < t->faces[face].n_loops; l++) LITHE_TRY(clip_loop(ctx, t, face, l));
  LITHE_TRY(close_cut(ctx, t, is_owner));
  if (n_on > 1) LITHE_TRY(note_edges(ctx, t, cell, face, -1, false));
  for (int side = 0; side < 2; side++)
    LITHE_TRY(lth_topology_trace(ctx, t, &w->chain[side], NULL, t->faces[face].plane, face, side,
                                 is_clean));
  return LITHE_OK;
}

static int compare_ridges(const void *a, const void *b) {
  const TopologyEdge *x = a, *y = b;
  if (x->key != y->key) return x->key < y->key ? -1 : 1;
  return (x->direction < y->direction) - (x->direction > y->direction);
}

/// True if the cell fills more than half of the surroundings of the edge between two of its faces; `f` has the edge in
/// the direction from low to high.
static bool is_reflex(const LthTopology *t, LitheIndex cell, const TopologyEdge *f,
                      const TopologyEdge *g) {
  double d[3], c[3],
      sign = lth_topology_side(t, f->node, cell) * lth_topology_side(t, g->node, cell);
  LitheCount low = (LitheCount)(f->key >> 32), high = (LitheCount)(uint32_t)f->key;
  lth_v3_sub(t->points + 3 * high, t->points + 3 * low, d);
  lth_v3_cross(t->faces[f->node].plane, t->faces[g->node].plane, c);
  return sign * lth_v3_dot(c, d) < 0;
}

/// A ridge that touches the plane from one side while the cell goes on beyond it divides the cap, so that
/// what is on its two sides is not connected by it: the cap has the edge in both directions.
static LitheStatus find_dividers(LitheCtx *ctx, LthTopology *t, LitheIndex cell) {
  LthTopologyWork *w = t->work;
  LitheIndex n = w->n_ridges;
  if (n < 2) return LITHE_OK;
  qsort(w->edges, (size_t)n, sizeof *w->edges, compare_ridges);
  for (LitheIndex i = 0, j; i < n; i = j) {
    const TopologyEdge *e = w->edges + i;
    for (j = i + 1; j < n && w->edges[j].key == e->key;) j++;
    bool may_divide = j - i == 2 && e[0].direction == 1 && e[1].direction == -1;
    for (LitheCount k = 0; k < w->cap.n && may_divide; k++)
      may_divide = lth_topology_edge_key(w->cap.edge[2 * k], w->cap.edge[2 * k + 1]) != e->key;
    if (!may_divide || !is_reflex(t, cell, e, e + 1)) continue;
    LitheIndex low = (LitheIndex)(e->key >> 32), high = (LitheIndex)(uint32_t)e->key;
    LITHE_TRY(lth_topology_chain_add(ctx, &w->divider, low, high));
    LITHE_TRY(lth_topology_chain_add(ctx, &w->divider, high, low));
  }
  return LITHE_OK;
}

LitheStatus lth_topology_clip(LitheCtx *ctx, LthTopology *t, LitheIndex cell, bool *is_clean) {
  LthTopologyWork *w = t->work;
  w->n_parts = w->n_loops = w->n_corners = 0;
  w->cap.n = w->divider.n = 0;
  w->n_ridges = 0;
  w->n_fresh = 0;
  for (LitheIndex i = 0; i < t->cells[cell].n_faces; i++)
    LITHE_TRY(clip_face(ctx, t, cell, lth_topology_cell_faces(t, cell)[i], is_clean));
  lth_topology_cancel(&w->cap);
  LITHE_TRY(find_dividers(ctx, t, cell));
  LITHE_TRY(lth_topology_trace(ctx, t, &w->cap, &w->divider, w->plane, -1, 2, is_clean));
  *is_clean &= w->parts[w->n_parts - 1].side == 2; // no cap: nothing was cut
  return LITHE_OK;
}
