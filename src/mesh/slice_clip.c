/// Cut pieces by all planes of one axis at once: edges to sub-edges, closing edges along the cuts.
#include "mesh/slice.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/// A sub-edge and the slab it lies in.
typedef struct SubEdge {
  LitheIndex slab, from, to;
} SubEdge;

/// Where a piece's boundary passes a plane: sign +1 towards the high side.
typedef struct Crossing {
  LitheIndex plane, point, sign;
  double key[2]; ///< position along the cut
} Crossing;

/// One pass and its scratch.
typedef struct Pass {
  Slicer *s;
  int axis;
  LitheIndex *slab; ///< of the points before the pass
  bool *on_plane;   ///< of those points: on the plane below their slab
  LthHash dips;     ///< edges in planes that go through the low side
  LthHash cut;      ///< undirected edge -> its first new point; the others follow, plane by plane
  SlicePieces out;
  SliceCaps caps;
  SubEdge *sub, *sorted;
  Crossing *cross;
  LitheIndex *start, *queue;
  LitheCount n_sub, sub_cap, sorted_cap, n_cross, cross_cap, start_cap, queue_cap;
} Pass;

/// Number of inner planes at or below x: a point on a plane is on its high side.
static LitheIndex slab_of(const double *plane, LitheIndex cells, double x) {
  LitheIndex hi = cells - 1;
  double guess = (x - plane[0]) / (plane[cells] - plane[0]) * cells;
  LitheIndex k = guess > 0 ? (guess < hi ? (LitheIndex)guess : hi) : 0;
  while (k > 0 && plane[k] > x) k--;
  while (k < hi && plane[k + 1] <= x) k++;
  return k;
}

/// The one decision about a point and the planes of an axis, by its coordinate alone.
static LitheStatus classify_points(Pass *p) {
  Slicer *s = p->s;
  LTH_NEW(s->ctx, p->slab, s->n_points);
  LTH_NEW(s->ctx, p->on_plane, s->n_points);
  for (LitheCount i = 0; i < s->n_points; i++) {
    double x = s->point[3 * i + p->axis];
    LitheIndex k = slab_of(s->plane[p->axis], s->cells[p->axis], x + s->reach);
    p->slab[i] = k;
    p->on_plane[i] = k > 0 && x <= s->plane[p->axis][k] + s->reach;
  }
  return LITHE_OK;
}

static uint64_t edge_key(LitheIndex a, LitheIndex b) {
  return lth_hash_pair(a < b ? a : b, a < b ? b : a);
}

static bool is_in_plane(const Pass *p, LitheIndex a, LitheIndex b) {
  return p->on_plane[a] && p->on_plane[b] && p->slab[a] == p->slab[b];
}

/// True if a triangle lies in a plane and its outside is the plane's high side.
static bool is_top(const Pass *p, LitheIndex triangle) {
  const LitheIndex *t = p->s->surface->tris + 3 * (LitheCount)triangle;
  if (!is_in_plane(p, t[0], t[1]) || !is_in_plane(p, t[1], t[2])) return false;
  return lth_slice_loop_area(p->s->point, t, 3, p->axis) > 0;
}

/// True if the interior of a cap, on the left of its edges, is on the low side of the edge a b that lies
/// in a plane.
static bool is_above_cap(const Pass *p, int cap_axis, LitheIndex a, LitheIndex b) {
  bool is_first = (cap_axis + 1) % 3 == p->axis;
  int along = (cap_axis + (is_first ? 2 : 1)) % 3;
  double d = p->s->point[3 * (LitheCount)b + along] - p->s->point[3 * (LitheCount)a + along];
  return is_first ? d > 0 : d < 0;
}

/// A point on a plane is on its high side, but not so the edges with the solid below them: those of faces
/// that look up from the plane, and upper edges of caps. They dip: from their ends through the plane and
/// along its low side. Then whole faces in planes are where the solid is that they bound, and what
/// stands on such a face is not connected by it.
static LitheStatus find_dips(Pass *p) {
  const SlicePieces *in = &p->s->pieces;
  for (LitheCount i = 0; i < in->n; i++) {
    const SlicePiece *piece = in->piece + i;
    bool is_boundary = piece->axis == SLICE_BOUNDARY;
    if (is_boundary && !is_top(p, piece->tag)) continue;
    for (LitheCount j = piece->first; j < piece->first + piece->count; j++) {
      LitheIndex a = in->edge[2 * j], b = in->edge[2 * j + 1], kept = 0;
      if (is_in_plane(p, a, b) && (is_boundary || is_above_cap(p, piece->axis, a, b)))
        LITHE_TRY(lth_hash_insert(p->s->ctx, &p->dips, edge_key(a, b), 0, 0, &kept));
    }
  }
  return LITHE_OK;
}

/// True where a comes before b in the order of coordinates.
static bool is_before(const double *a, const double *b) {
  for (int i = 0; i < 3; i++)
    if (a[i] != b[i]) return a[i] < b[i];
  return false;
}

/// Point of the segment a b on the plane x[axis] = value: from the nearer end, so that it is an end
/// exactly where that end is on the plane, and never outside the box of the ends.
static void intersect(const double *a, const double *b, int axis, double value, double x[3]) {
  double da = value - a[axis], db = b[axis] - value, d = b[axis] - a[axis];
  bool near_b = fabs(db) < fabs(da);
  double t = near_b ? db / d : da / d;
  for (int i = 0; i < 3; i++) {
    double lo = a[i] < b[i] ? a[i] : b[i], hi = a[i] < b[i] ? b[i] : a[i];
    x[i] = near_b ? b[i] - t * (b[i] - a[i]) : a[i] + t * (b[i] - a[i]);
    if (!(x[i] >= lo)) x[i] = lo;
    if (x[i] > hi) x[i] = hi;
  }
  x[axis] = value;
}

/// The first of `n` new points of an edge: existing ones, or room for them. `*is_new` says which.
static LitheStatus edge_points(Pass *p, LitheIndex a, LitheIndex b, LitheIndex n, LitheIndex *first,
                               bool *is_new) {
  Slicer *s = p->s;
  if (s->n_points + n >= INT32_MAX)
    LITHE_FAIL(s->ctx, LITHE_UNSUPPORTED, "slicing: more than 2^31 points; use larger cells");
  LitheIndex fresh = (LitheIndex)s->n_points;
  LITHE_TRY(lth_hash_insert(s->ctx, &p->cut, edge_key(a, b), 0, fresh, first));
  *is_new = *first == fresh;
  if (!*is_new) return LITHE_OK;
  LTH_RESERVE(s->ctx, s->point, s->point_cap, 3 * (s->n_points + n));
  s->n_points += n;
  return LITHE_OK;
}

/// First of the points in which the edge {a, b} meets planes low + 1 .. high. They depend on the
/// coordinates of the ends only, so coincident edges are cut in coincident points. An end on a plane is
/// its own cut, unmoved.
static LitheStatus cut_edge(Pass *p, LitheIndex a, LitheIndex b, LitheIndex low, LitheIndex high,
                            LitheIndex *first) {
  bool is_new = false;
  LITHE_TRY(edge_points(p, a, b, high - low, first, &is_new));
  if (!is_new) return LITHE_OK;
  double *point = p->s->point;
  const double *x = point + 3 * (LitheCount)a, *y = point + 3 * (LitheCount)b;
  bool swap = is_before(y, x);
  for (LitheIndex k = low + 1; k <= high; k++) {
    double *cut = point + 3 * (LitheCount)(*first + (k - low - 1));
    intersect(swap ? y : x, swap ? x : y, p->axis, p->s->plane[p->axis][k], cut);
    if (p->on_plane[a] && p->slab[a] == k) memcpy(cut, x, 3 * sizeof *cut);
    if (p->on_plane[b] && p->slab[b] == k) memcpy(cut, y, 3 * sizeof *cut);
  }
  return LITHE_OK;
}

static LitheStatus add_sub(Pass *p, LitheIndex slab, LitheIndex from, LitheIndex to) {
  LTH_RESERVE(p->s->ctx, p->sub, p->sub_cap, p->n_sub + 1);
  p->sub[p->n_sub++] = (SubEdge){slab, from, to};
  return LITHE_OK;
}

static LitheStatus add_crossing(Pass *p, LitheIndex plane, LitheIndex point, LitheIndex sign) {
  LTH_RESERVE(p->s->ctx, p->cross, p->cross_cap, p->n_cross + 1);
  p->cross[p->n_cross++] = (Crossing){plane, point, sign, {0, 0}};
  return LITHE_OK;
}

/// Lead an edge in a plane along its low side, through twins of its ends.
static LitheStatus dip_edge(Pass *p, LitheIndex a, LitheIndex b) {
  LitheIndex k = p->slab[a], first = 0;
  bool is_new = false;
  LITHE_TRY(edge_points(p, a, b, 2, &first, &is_new));
  LitheIndex twin_a = a < b ? first : first + 1, twin_b = a < b ? first + 1 : first;
  for (int i = 0; i < 3 && is_new; i++) {
    p->s->point[3 * (LitheCount)twin_a + i] = p->s->point[3 * (LitheCount)a + i];
    p->s->point[3 * (LitheCount)twin_b + i] = p->s->point[3 * (LitheCount)b + i];
  }
  LITHE_TRY(add_sub(p, k, a, twin_a));
  LITHE_TRY(add_crossing(p, k, twin_a, -1));
  LITHE_TRY(add_sub(p, k - 1, twin_a, twin_b));
  LITHE_TRY(add_crossing(p, k, twin_b, 1));
  return add_sub(p, k, twin_b, b);
}

static LitheStatus split_edge(Pass *p, LitheIndex a, LitheIndex b) {
  LitheIndex slab_a = p->slab[a], slab_b = p->slab[b];
  if (slab_a == slab_b) {
    bool dips = is_in_plane(p, a, b) && lth_hash_find(&p->dips, edge_key(a, b), 0) >= 0;
    return dips ? dip_edge(p, a, b) : add_sub(p, slab_a, a, b);
  }
  bool up = slab_a < slab_b;
  LitheIndex low = up ? slab_a : slab_b, high = up ? slab_b : slab_a, first = 0, from = a;
  LITHE_TRY(cut_edge(p, a, b, low, high, &first));
  for (LitheIndex i = 0; i < high - low; i++) {
    LitheIndex plane = up ? low + 1 + i : high - i;
    LitheIndex point = first + (plane - low - 1);
    LITHE_TRY(add_sub(p, up ? plane - 1 : plane, from, point));
    LITHE_TRY(add_crossing(p, plane, point, up ? 1 : -1));
    from = point;
  }
  return add_sub(p, slab_b, from, b);
}

static int compare_crossings(const void *a, const void *b) {
  const Crossing *x = a, *y = b;
  if (x->plane != y->plane) return x->plane < y->plane ? -1 : 1;
  for (int i = 0; i < 2; i++)
    if (x->key[i] != y->key[i]) return x->key[i] < y->key[i] ? -1 : 1;
  return (x->point > y->point) - (x->point < y->point);
}

/// Sort crossings by plane, and along each cut. All points of a cut lie on a line up to rounding, so
/// the coordinate in which the piece extends most orders them, however flat the piece meets the plane.
static void sort_crossings(Pass *p) {
  int u = (p->axis + 1) % 3, v = (p->axis + 2) % 3;
  double lo[2] = {INFINITY, INFINITY}, hi[2] = {-INFINITY, -INFINITY};
  for (LitheCount i = 0; i < p->n_cross; i++) {
    Crossing *c = p->cross + i;
    for (int k = 0; k < 2; k++) {
      c->key[k] = p->s->point[3 * (LitheCount)c->point + (k ? v : u)];
      lo[k] = fmin(lo[k], c->key[k]);
      hi[k] = fmax(hi[k], c->key[k]);
    }
  }
  if (hi[1] - lo[1] > hi[0] - lo[0])
    for (LitheCount i = 0; i < p->n_cross; i++) {
      double swap = p->cross[i].key[0];
      p->cross[i].key[0] = p->cross[i].key[1];
      p->cross[i].key[1] = swap;
    }
  qsort(p->cross, (size_t)p->n_cross, sizeof *p->cross, compare_crossings);
}

static LitheStatus close_pair(Pass *p, const SlicePiece *piece, LitheIndex plane, LitheIndex up,
                              LitheIndex down) {
  LITHE_TRY(add_sub(p, plane - 1, up, down));
  LITHE_TRY(add_sub(p, plane, down, up));
  return lth_slice_cap_edge(p->s->ctx, &p->caps, piece, p->axis, plane, up, down);
}

/// Join the crossings of one plane, sorted along the cut, by closing edges. Each up-crossing is joined
/// to a down-crossing first in, first out: where rounding swapped neighbours the pairs are still those
/// that belong together, and every point keeps one edge in and one edge out.
static LitheStatus close_plane(Pass *p, const SlicePiece *piece, const Crossing *cross,
                               LitheCount n) {
  LTH_RESERVE(p->s->ctx, p->queue, p->queue_cap, n);
  LitheCount head = 0, tail = 0;
  LitheIndex sign = 0;
  for (LitheCount i = 0; i < n; i++) {
    if (head == tail || cross[i].sign == sign) {
      sign = cross[i].sign;
      p->queue[tail++] = cross[i].point;
      continue;
    }
    LitheIndex other = p->queue[head++];
    LITHE_TRY(close_pair(p, piece, cross[i].plane, sign > 0 ? other : cross[i].point,
                         sign > 0 ? cross[i].point : other));
  }
  LITHE_ASSERT(head == tail);
  return LITHE_OK;
}

static LitheStatus close_cuts(Pass *p, const SlicePiece *piece) {
  if (p->n_cross > 2) sort_crossings(p);
  for (LitheCount i = 0, j; i < p->n_cross; i = j) {
    for (j = i + 1; j < p->n_cross && p->cross[j].plane == p->cross[i].plane;) j++;
    LITHE_TRY(close_plane(p, piece, p->cross + i, j - i));
  }
  return LITHE_OK;
}

/// Write the sub-edges out as one piece for each slab (counting sort by slab).
static LitheStatus emit_slabs(Pass *p, const SlicePiece *piece) {
  LitheIndex low = INT32_MAX, high = -1;
  for (LitheCount i = 0; i < p->n_sub; i++) {
    if (p->sub[i].slab < low) low = p->sub[i].slab;
    if (p->sub[i].slab > high) high = p->sub[i].slab;
  }
  LitheIndex n = high - low + 1;
  LTH_RESERVE(p->s->ctx, p->start, p->start_cap, n + 1);
  LTH_RESERVE(p->s->ctx, p->sorted, p->sorted_cap, p->n_sub);
  for (LitheIndex k = 0; k <= n; k++) p->start[k] = 0;
  for (LitheCount i = 0; i < p->n_sub; i++) p->start[p->sub[i].slab - low + 1]++;
  for (LitheIndex k = 0; k < n; k++) p->start[k + 1] += p->start[k];
  for (LitheCount i = 0; i < p->n_sub; i++) p->sorted[p->start[p->sub[i].slab - low]++] = p->sub[i];
  for (LitheCount i = 0; i < p->n_sub; i++) {
    if (i == 0 || p->sorted[i].slab != p->sorted[i - 1].slab) {
      SlicePiece out = *piece;
      out.slab[p->axis] = p->sorted[i].slab;
      LITHE_TRY(lth_slice_add_piece(p->s->ctx, &p->out, &out));
    }
    LITHE_TRY(lth_slice_add_edge(p->s->ctx, &p->out, p->sorted[i].from, p->sorted[i].to));
  }
  return LITHE_OK;
}

static LitheStatus split_piece(Pass *p, const SlicePiece *piece) {
  const LitheIndex *edge = p->s->pieces.edge + 2 * piece->first;
  p->n_sub = p->n_cross = 0;
  for (LitheIndex i = 0; i < piece->count; i++)
    LITHE_TRY(split_edge(p, edge[2 * i], edge[2 * i + 1]));
  LITHE_TRY(close_cuts(p, piece));
  return emit_slabs(p, piece);
}

static LitheStatus split_all(Pass *p) {
  static const char *const phase[3] = {"slicing x", "slicing y", "slicing z"};
  const SlicePieces *in = &p->s->pieces;
  for (LitheCount i = 0; i < in->n; i++) {
    if (i % 8192 == 0) {
      if (lth_cancelled(p->s->ctx)) LITHE_FAIL(p->s->ctx, LITHE_INTERRUPTED, "interrupted");
      lth_progress(p->s->ctx, phase[p->axis], (double)i / (double)in->n);
    }
    LITHE_TRY(split_piece(p, in->piece + i));
  }
  return lth_slice_close_caps(p->s->ctx, &p->caps, p->axis, &p->out);
}

LitheStatus lth_slice_pass(Slicer *s, int axis) {
  Pass p = {.s = s, .axis = axis};
  LitheStatus status = LITHE_OK;
  LITHE_TRY_OR(done, classify_points(&p));
  LITHE_TRY_OR(done, find_dips(&p));
  LITHE_TRY_OR(done, split_all(&p));
  SlicePieces swap = s->pieces;
  s->pieces = p.out;
  p.out = swap;
done:
  lth_slice_free_pieces(s->ctx, &p.out);
  lth_slice_free_caps(s->ctx, &p.caps);
  lth_hash_free(s->ctx, &p.cut);
  lth_hash_free(s->ctx, &p.dips);
  void *blocks[] = {p.slab, p.on_plane, p.sub, p.sorted, p.cross, p.start, p.queue};
  for (int i = 0; i < 7; i++) lth_free(s->ctx, blocks[i]);
  return status;
}
