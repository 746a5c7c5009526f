/// The faces of a cell as chains below and above a plane, and the cap.
///
/// As in slice_clip.c every face is a cycle of directed edges. An edge with its ends on different sides is cut in a
/// new point; places where the cycle passes the plane are sorted along the cut and joined in pairs by closing
/// edges, which go to both sides with opposite signs. Points on the plane have the sign 0: an edge between two
/// of them is on the side of the face's inside, and a corner that touches the plane from one side passes it
/// twice, so that closing edges end at it. Whole faces in the plane are where the cell is that they bound. The cap is
/// minus the sum of what all faces leave in the plane on the lower side, so both sides are closed by construction.
#include "mesh/topology_priv.h"

#include <stdlib.h>

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
    LITHE_TRY(lth_topology_cut_edge(ctx, t, a, b, &p));
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
