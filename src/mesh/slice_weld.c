/// Coincident points become one, and what has no extent cancels.
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
