/// Caps: pieces in grid planes, each the opposite of the closing edges that the cuts of a cell left.
#include "mesh/slice.h"

void lth_slice_free_pieces(LitheCtx *ctx, SlicePieces *pieces) {
  lth_free(ctx, pieces->piece);
  lth_free(ctx, pieces->edge);
  *pieces = (SlicePieces){0};
}

void lth_slice_free_caps(LitheCtx *ctx, SliceCaps *caps) {
  lth_hash_free(ctx, &caps->index);
  lth_free(ctx, caps->slab);
  lth_free(ctx, caps->edge);
  *caps = (SliceCaps){0};
}

LitheStatus lth_slice_add_piece(LitheCtx *ctx, SlicePieces *pieces, const SlicePiece *piece) {
  if (pieces->n >= INT32_MAX - 1)
    LITHE_FAIL(ctx, LITHE_UNSUPPORTED, "slicing: more than 2^31 face pieces; use larger cells");
  LTH_RESERVE(ctx, pieces->piece, pieces->cap, pieces->n + 1);
  SlicePiece *added = pieces->piece + pieces->n++;
  *added = *piece;
  added->first = pieces->n_edges;
  added->count = 0;
  return LITHE_OK;
}

LitheStatus lth_slice_add_edge(LitheCtx *ctx, SlicePieces *pieces, LitheIndex from, LitheIndex to) {
  LTH_RESERVE(ctx, pieces->edge, pieces->edge_cap, 2 * (pieces->n_edges + 1));
  pieces->edge[2 * pieces->n_edges] = from;
  pieces->edge[2 * pieces->n_edges + 1] = to;
  pieces->n_edges++;
  pieces->piece[pieces->n - 1].count++;
  return LITHE_OK;
}

/// The cap above the cell `slab` across `axis`; slabs of later axes are not known yet.
static LitheStatus find_cap(LitheCtx *ctx, SliceCaps *caps, int axis, const LitheIndex slab[3],
                            LitheIndex *cap) {
  LitheIndex key[3] = {0, 0, 0};
  for (int i = 0; i <= axis; i++) key[i] = slab[i];
  LITHE_TRY(lth_hash_insert(ctx, &caps->index, lth_hash_pair(key[0], key[1]), (uint64_t)key[2],
                            (LitheIndex)caps->n, cap));
  if (*cap < caps->n) return LITHE_OK;
  LTH_RESERVE(ctx, caps->slab, caps->slab_cap, 3 * (caps->n + 1));
  for (int i = 0; i < 3; i++) caps->slab[3 * caps->n + i] = key[i];
  caps->n++;
  return LITHE_OK;
}

static LitheStatus add_cap_edge(LitheCtx *ctx, SliceCaps *caps, int axis, const LitheIndex slab[3],
                                LitheIndex from, LitheIndex to) {
  LitheIndex cap = 0;
  LITHE_TRY(find_cap(ctx, caps, axis, slab, &cap));
  LTH_RESERVE(ctx, caps->edge, caps->edge_cap, caps->n_edges + 1);
  caps->edge[caps->n_edges++] = (SliceCapEdge){cap, from, to};
  return LITHE_OK;
}

LitheStatus lth_slice_cap_edge(LitheCtx *ctx, SliceCaps *caps, const SlicePiece *piece, int axis,
                               LitheIndex plane, LitheIndex from, LitheIndex to) {
  LitheIndex slab[3] = {piece->slab[0], piece->slab[1], piece->slab[2]};
  slab[axis] = plane - 1;
  LITHE_TRY(add_cap_edge(ctx, caps, axis, slab, to, from));
  if (piece->axis == SLICE_BOUNDARY) return LITHE_OK;

  // the cell on a cap's high side sees the cap from behind
  slab[piece->axis]++;
  return add_cap_edge(ctx, caps, axis, slab, from, to);
}

LitheStatus lth_slice_close_caps(LitheCtx *ctx, SliceCaps *caps, int axis, SlicePieces *pieces) {
  LitheCount *start = NULL;
  SliceCapEdge *sorted = NULL;
  LitheStatus status = LITHE_OK;
  LTH_NEW_OR(done, ctx, start, caps->n + 1);
  LTH_NEW_OR(done, ctx, sorted, caps->n_edges);
  for (LitheCount i = 0; i < caps->n_edges; i++) start[caps->edge[i].cap + 1]++;
  for (LitheCount c = 0; c < caps->n; c++) start[c + 1] += start[c];
  for (LitheCount i = 0; i < caps->n_edges; i++) sorted[start[caps->edge[i].cap]++] = caps->edge[i];
  for (LitheCount i = 0; i < caps->n_edges; i++) {
    LitheIndex c = sorted[i].cap;
    if (i == 0 || c != sorted[i - 1].cap) {
      const LitheIndex *slab = caps->slab + 3 * (LitheCount)c;
      SlicePiece piece = {.tag = -1, .axis = axis, .slab = {slab[0], slab[1], slab[2]}};
      LITHE_TRY_OR(done, lth_slice_add_piece(ctx, pieces, &piece));
    }
    LITHE_TRY_OR(done, lth_slice_add_edge(ctx, pieces, sorted[i].from, sorted[i].to));
  }
done:
  lth_free(ctx, start);
  lth_free(ctx, sorted);
  return status;
}
