/// Coincident points become one; faces that lie in a grid plane go to the cell that they bound.
#include "mesh/slice.h"

#include <stdlib.h>
#include <string.h>

static uint64_t bits_of(double x) {
  double positive_zero = x + 0.0;
  uint64_t bits = 0;
  memcpy(&bits, &positive_zero, sizeof bits);
  return bits;
}

/// For each point the first one with the same coordinates: first x and y, then their number and z.
static LitheStatus find_twins(Slicer *s, LitheIndex *twin) {
  LthHash columns = {0}, points = {0};
  LitheStatus status = LITHE_OK;
  LITHE_TRY_OR(done, lth_hash_reserve(s->ctx, &columns, s->n_points));
  LITHE_TRY_OR(done, lth_hash_reserve(s->ctx, &points, s->n_points));
  for (LitheIndex i = 0; i < s->n_points; i++) {
    const double *x = s->point + 3 * (LitheCount)i;
    LitheIndex column = 0;
    LITHE_TRY_OR(done, lth_hash_insert(s->ctx, &columns, bits_of(x[0]), bits_of(x[1]), i, &column));
    LITHE_TRY_OR(done,
                 lth_hash_insert(s->ctx, &points, (uint64_t)column, bits_of(x[2]), i, twin + i));
  }
done:
  lth_hash_free(s->ctx, &columns);
  lth_hash_free(s->ctx, &points);
  return status;
}

static int compare_edges(const void *a, const void *b) {
  const LitheIndex *x = a, *y = b;
  LitheIndex xl = x[0] < x[1] ? x[0] : x[1], xh = x[0] ^ x[1] ^ xl;
  LitheIndex yl = y[0] < y[1] ? y[0] : y[1], yh = y[0] ^ y[1] ^ yl;
  if (xl != yl) return xl < yl ? -1 : 1;
  if (xh != yh) return xh < yh ? -1 : 1;
  return (x[0] > y[0]) - (x[0] < y[0]);
}

LitheIndex lth_slice_cancel(LitheIndex *edge, LitheIndex n) {
  LitheIndex kept = 0;
  qsort(edge, (size_t)n, 2 * sizeof *edge, compare_edges);
  for (LitheIndex i = 0, j; i < n; i = j) {
    LitheIndex low = edge[2 * i] < edge[2 * i + 1] ? edge[2 * i] : edge[2 * i + 1];
    LitheIndex high = edge[2 * i] ^ edge[2 * i + 1] ^ low, winding = 0;
    for (j = i; j < n; j++) {
      LitheIndex a = edge[2 * j], b = edge[2 * j + 1];
      if ((a != low || b != high) && (a != high || b != low)) break;
      winding += a < b ? 1 : -1;
    }
    if (low == high) continue;
    for (; winding != 0; winding += winding > 0 ? -1 : 1) {
      edge[2 * kept] = winding > 0 ? low : high;
      edge[2 * kept + 1] = winding > 0 ? high : low;
      kept++;
    }
  }
  return kept;
}

LitheStatus lth_slice_weld(Slicer *s) {
  LitheIndex *twin = NULL;
  LTH_NEW(s->ctx, twin, s->n_points);
  LitheStatus status = LITHE_OK;
  LITHE_TRY_OR(done, find_twins(s, twin));
  for (LitheCount p = 0; p < s->pieces.n; p++) {
    SlicePiece *piece = s->pieces.piece + p;
    LitheIndex *edge = s->pieces.edge + 2 * piece->first;
    bool is_welded = false;
    for (LitheIndex i = 0; i < 2 * piece->count; i++) {
      is_welded |= twin[edge[i]] != edge[i];
      edge[i] = twin[edge[i]];
    }
    if (is_welded) piece->count = lth_slice_cancel(edge, piece->count);
  }
done:
  lth_free(s->ctx, twin);
  return status;
}

/// A boundary piece in the plane of a cap.
typedef struct Transfer {
  LitheIndex cap, piece;
} Transfer;

/// Axis of the grid plane below the piece's cell that the piece's whole triangle lies in, facing down
/// from the cell's point of view as its outer side, that is towards +axis; -1 if there is none.
static int facing_axis(const Slicer *s, const SlicePiece *piece) {
  if (piece->axis != SLICE_BOUNDARY || piece->count == 0) return -1;
  const LitheIndex *tri = s->surface->tris + 3 * (LitheCount)piece->tag;
  const double *a = s->point + 3 * (LitheCount)tri[0], *b = s->point + 3 * (LitheCount)tri[1],
               *c = s->point + 3 * (LitheCount)tri[2];
  for (int i = 0; i < 3; i++) {
    int u = (i + 1) % 3, v = (i + 2) % 3;
    double plane = s->plane[i][piece->slab[i]];
    if (piece->slab[i] == 0 || a[i] != plane || b[i] != plane || c[i] != plane) continue;
    return (b[u] - a[u]) * (c[v] - a[v]) - (b[v] - a[v]) * (c[u] - a[u]) > 0 ? i : -1;
  }
  return -1;
}

static LitheStatus index_caps(Slicer *s, LthHash *caps) {
  for (LitheCount p = 0; p < s->pieces.n; p++) {
    const SlicePiece *piece = s->pieces.piece + p;
    LitheIndex kept = 0;
    if (piece->axis != SLICE_BOUNDARY)
      LITHE_TRY(lth_hash_insert(s->ctx, caps, lth_hash_pair(piece->slab[0], piece->slab[1]),
                                lth_hash_pair(piece->slab[2], piece->axis), (LitheIndex)p, &kept));
  }
  return LITHE_OK;
}

/// Move facing pieces to the cell below, and list the caps that they are to be subtracted from.
static LitheStatus collect_transfers(Slicer *s, Transfer **list, LitheCount *n) {
  LthHash caps = {0};
  LitheCount cap = 0;
  LitheStatus status = LITHE_OK;
  for (LitheCount p = 0; p < s->pieces.n; p++) {
    SlicePiece *piece = s->pieces.piece + p;
    int axis = facing_axis(s, piece);
    if (axis < 0) continue;
    if (caps.n == 0) LITHE_TRY_OR(done, index_caps(s, &caps));
    LitheIndex slab[3] = {piece->slab[0], piece->slab[1], piece->slab[2]};
    slab[axis]--;
    LitheIndex found =
        lth_hash_find(&caps, lth_hash_pair(slab[0], slab[1]), lth_hash_pair(slab[2], axis));
    if (found < 0) continue;
    LTH_RESERVE_OR(done, s->ctx, *list, cap, *n + 1);
    (*list)[(*n)++] = (Transfer){found, (LitheIndex)p};
    piece->slab[axis]--;
  }
done:
  lth_hash_free(s->ctx, &caps);
  return status;
}

static int compare_transfers(const void *a, const void *b) {
  const Transfer *x = a, *y = b;
  if (x->cap != y->cap) return x->cap < y->cap ? -1 : 1;
  return (x->piece > y->piece) - (x->piece < y->piece);
}

/// cap -= pieces: the cap's edges and the pieces' reversed ones, written anew at the end of the list.
static LitheStatus subtract(Slicer *s, const Transfer *list, LitheCount n) {
  SlicePieces *all = &s->pieces;
  SlicePiece *cap = all->piece + list[0].cap;
  LitheCount count = cap->count, first = all->n_edges;
  for (LitheCount i = 0; i < n; i++) count += all->piece[list[i].piece].count;
  LTH_RESERVE(s->ctx, all->edge, all->edge_cap, 2 * (first + count));
  memcpy(all->edge + 2 * first, all->edge + 2 * cap->first,
         2 * (size_t)cap->count * sizeof *all->edge);
  LitheIndex *out = all->edge + 2 * (first + cap->count);
  for (LitheCount i = 0; i < n; i++) {
    const SlicePiece *piece = all->piece + list[i].piece;
    for (LitheCount j = piece->first; j < piece->first + piece->count; j++) {
      *out++ = all->edge[2 * j + 1];
      *out++ = all->edge[2 * j];
    }
  }
  cap->first = first;
  cap->count = lth_slice_cancel(all->edge + 2 * first, (LitheIndex)count);
  all->n_edges = first + cap->count;
  return LITHE_OK;
}

LitheStatus lth_slice_settle_coplanar(Slicer *s) {
  Transfer *list = NULL;
  LitheCount n = 0;
  LitheStatus status = LITHE_OK;
  LITHE_TRY_OR(done, collect_transfers(s, &list, &n));
  if (n > 0) qsort(list, (size_t)n, sizeof *list, compare_transfers);
  for (LitheCount i = 0, j; i < n; i = j) {
    for (j = i + 1; j < n && list[j].cap == list[i].cap;) j++;
    LITHE_TRY_OR(done, subtract(s, list + i, j - i));
  }
done:
  lth_free(s->ctx, list);
  return status;
}
