/// Polyhedra of mesh files: faces that are not turned alike are turned.
#include "io/element_builder.h"

#include <stdlib.h>

/// An edge of a face, from its lower to its higher node.
typedef struct Edge {
  LitheIndex low, high, face;
  int along; ///< +1: the face runs from low to high
} Edge;

static int compare_edges(const void *pa, const void *pb) {
  const Edge *a = pa, *b = pb;
  if (a->low != b->low) return a->low < b->low ? -1 : 1;
  if (a->high != b->high) return a->high < b->high ? -1 : 1;
  return (a->face > b->face) - (a->face < b->face);
}

static bool is_same_edge(const Edge *a, const Edge *b) {
  return a->low == b->low && a->high == b->high;
}

/// All edges of the faces in the order of their nodes; starts of the faces.
static LitheIndex list_edges(const LitheIndex *faces, LitheIndex *start, Edge *edges) {
  LitheIndex n = 0, at = 1;
  for (LitheIndex f = 0; f < faces[0]; f++) {
    LitheIndex count = faces[at];
    const LitheIndex *v = faces + at + 1;
    start[f] = at;
    for (LitheIndex i = 0; i < count; i++) {
      LitheIndex p = v[i], q = v[i + 1 < count ? i + 1 : 0];
      if (p != q) edges[n++] = p < q ? (Edge){p, q, f, 1} : (Edge){q, p, f, -1};
    }
    at += 1 + count;
  }
  qsort(edges, (size_t)n, sizeof *edges, compare_edges);
  return n;
}

static bool are_turned_alike(const Edge *edges, LitheIndex n) {
  for (LitheIndex i = 0, j; i < n; i = j) {
    int sum = 0;
    for (j = i; j < n && is_same_edge(edges + i, edges + j); j++) sum += edges[j].along;
    if (sum != 0) return false;
  }
  return true;
}

/// Spread the turn (+1, -1) of the faces that have one over edges between two faces; false at rest.
static bool spread(const Edge *edges, LitheIndex n, int8_t *turn) {
  bool has_moved = false;
  for (LitheIndex i = 0, j; i < n; i = j) {
    for (j = i; j < n && is_same_edge(edges + i, edges + j); j++) continue;
    if (j != i + 2) continue;
    LitheIndex a = edges[i].face, b = edges[i + 1].face;
    int8_t opposite = edges[i].along == edges[i + 1].along ? -1 : 1;
    if (turn[a] && !turn[b])
      turn[b] = (int8_t)(opposite * turn[a]), has_moved = true;
    else if (turn[b] && !turn[a])
      turn[a] = (int8_t)(opposite * turn[b]), has_moved = true;
  }
  return has_moved;
}

static void reverse(LitheIndex *face) {
  LitheIndex n = face[0], *v = face + 1;
  for (LitheIndex i = 0; i < n / 2; i++) {
    LitheIndex swap = v[i];
    v[i] = v[n - 1 - i];
    v[n - 1 - i] = swap;
  }
}

LitheStatus lth_polyhedron_orient(LitheCtx *ctx, LitheIndex *faces) {
  LitheStatus status = LITHE_OK;
  LitheIndex n_corners = 0, at = 1, *start = NULL;
  int8_t *turn = NULL;
  Edge *edges = NULL;
  for (LitheIndex f = 0; f < faces[0]; f++) {
    n_corners += faces[at];
    at += 1 + faces[at];
  }
  LTH_NEW_OR(done, ctx, edges, n_corners);
  LTH_NEW_OR(done, ctx, start, faces[0]);
  LTH_NEW_OR(done, ctx, turn, faces[0]);
  LitheIndex n = list_edges(faces, start, edges);
  if (are_turned_alike(edges, n)) goto done;
  for (LitheIndex f = 0; f < faces[0]; f++) {
    if (turn[f]) continue;
    turn[f] = 1;
    while (spread(edges, n, turn)) continue;
  }
  for (LitheIndex f = 0; f < faces[0]; f++)
    if (turn[f] < 0) reverse(faces + start[f]);
done:
  lth_free(ctx, edges);
  lth_free(ctx, start);
  lth_free(ctx, turn);
  return status;
}
