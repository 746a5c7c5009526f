/// Pieces of facets: faces of the boundary that lie in one triangle of the surface, joined to as few polygons as can be.
#include "mesh/skin_priv.h"

#include <stdlib.h>

/// Lists of items by key: offsets from counts, then the items in order.
static LitheStatus list_by_key(LitheCtx *ctx, LitheIndex n_keys, LitheIndex n,
                               LitheIndex (*key)(const SkinWork *w, LitheIndex i),
                               const SkinWork *w, LitheIndex **off, LitheIndex **item) {
  LTH_NEW(ctx, *off, (LitheCount)n_keys + 2);
  LitheIndex *at = *off;
  for (LitheIndex i = 0; i < n; i++)
    if (key(w, i) >= 0) at[key(w, i) + 2]++;
  for (LitheIndex k = 0; k < n_keys; k++) at[k + 2] += at[k + 1];
  LTH_NEW(ctx, *item, at[n_keys + 1]);
  for (LitheIndex i = 0; i < n; i++)
    if (key(w, i) >= 0) (*item)[at[key(w, i) + 1]++] = i;
  return LITHE_OK;
}

static LitheIndex facet_of_face(const SkinWork *w, LitheIndex face) {
  const LthTopologyFace *f = w->t->faces + face;
  return lth_skin_is_boundary(f) ? lth_skin_facet(w, f) : -1;
}

static LitheIndex poly_of_facet(const SkinWork *w, LitheIndex facet) {
  return w->skin->facet_poly[facet];
}

typedef struct Edge {
  LitheIndex from, to;
} Edge;

static int compare_undirected(const void *a, const void *b) {
  const Edge *p = a, *q = b;
  LitheIndex p0 = p->from < p->to ? p->from : p->to, p1 = p->from < p->to ? p->to : p->from,
             q0 = q->from < q->to ? q->from : q->to, q1 = q->from < q->to ? q->to : q->from;
  if (p0 != q0) return p0 < q0 ? -1 : 1;
  if (p1 != q1) return p1 < q1 ? -1 : 1;
  return (p->from > q->from) - (p->from < q->from);
}

static int compare_directed(const void *a, const void *b) {
  const Edge *p = a, *q = b;
  if (p->from != q->from) return p->from < q->from ? -1 : 1;
  return (p->to > q->to) - (p->to < q->to);
}

/// All edges of the pieces, less those that meet an opposite one.
static LitheStatus sum_edges(LitheCtx *ctx, SkinWork *w, LitheIndex facet) {
  w->n_edges = 0;
  for (LitheIndex i = w->piece_off[facet]; i < w->piece_off[facet + 1]; i++) {
    LthFaceView f = lth_topology_face(w->t, w->piece[i]);
    LitheIndex cell = w->t->faces[w->piece[i]].cell[0];
    LTH_RESERVE(ctx, w->edge, w->edge_cap, 2 * ((LitheCount)w->n_edges + f.loop_off[f.n_loops]));
    for (LitheIndex l = 0; l < f.n_loops; l++)
      for (LitheIndex k = f.loop_off[l]; k < f.loop_off[l + 1]; k++) {
        LitheIndex next = k + 1 < f.loop_off[l + 1] ? k + 1 : f.loop_off[l];
        w->edge[2 * w->n_edges] = lth_skin_node(w, f.loop_point[k], cell);
        w->edge[2 * w->n_edges++ + 1] = lth_skin_node(w, f.loop_point[next], cell);
      }
  }
  Edge *edge = (Edge *)w->edge;
  LitheIndex n = 0;
  qsort(edge, (size_t)w->n_edges, sizeof *edge, compare_undirected);
  for (LitheIndex i = 0, j; i < w->n_edges; i = j) {
    LitheIndex forth = 0, back = 0;
    Edge like = edge[i];
    for (j = i; j < w->n_edges && (compare_directed(edge + j, &like) == 0 ||
                                   (edge[j].from == like.to && edge[j].to == like.from));
         j++)
      forth += edge[j].from == like.from, back += edge[j].from != like.from;
    for (; forth > back; forth--) edge[n++] = like;
    for (; back > forth; back--) edge[n++] = (Edge){like.to, like.from};
  }
  w->n_edges = n;
  qsort(edge, (size_t)n, sizeof *edge, compare_directed);
  return LITHE_OK;
}

static LitheIndex find_from(const SkinWork *w, LitheIndex from) {
  LitheIndex low = 0, high = w->n_edges - 1;
  while (low < high) {
    LitheIndex middle = low + (high - low) / 2;
    if (w->edge[2 * middle] < from)
      low = middle + 1;
    else
      high = middle;
  }
  return low;
}

static bool has_forks(const SkinWork *w) {
  for (LitheIndex i = 1; i < w->n_edges; i++)
    if (w->edge[2 * i] == w->edge[2 * i - 2]) return true;
  return false;
}

static LitheStatus trace(LitheCtx *ctx, SkinWork *w) {
  LTH_RESERVE(ctx, w->is_used, w->used_cap, w->n_edges + 1);
  LTH_RESERVE(ctx, w->loop_off, w->loop_off_cap, w->n_edges + 1);
  LTH_RESERVE(ctx, w->loop_node, w->loop_node_cap, w->n_edges + 1);
  memset(w->is_used, 0, sizeof *w->is_used * (size_t)w->n_edges);
  w->n_loops = w->n_corners = w->loop_off[0] = 0;
  for (LitheIndex i = 0; i < w->n_edges; i++) {
    if (w->is_used[i]) continue;
    for (LitheIndex e = i; !w->is_used[e]; e = find_from(w, w->edge[2 * e + 1])) {
      w->is_used[e] = true;
      w->loop_node[w->n_corners++] = w->edge[2 * e];
    }
    w->loop_off[++w->n_loops] = w->n_corners;
  }
  return LITHE_OK;
}

/// Twice the area of a loop about the facet's normal.
static double loop_area(const SkinWork *w, LitheIndex loop, const double normal[3]) {
  double sum = 0, a[3], b[3], cross[3];
  const double *x0 = lth_skin_place(w, w->loop_node[w->loop_off[loop]]);
  for (LitheIndex k = w->loop_off[loop] + 1; k + 1 < w->loop_off[loop + 1]; k++) {
    lth_v3_sub(lth_skin_place(w, w->loop_node[k]), x0, a);
    lth_v3_sub(lth_skin_place(w, w->loop_node[k + 1]), x0, b);
    lth_v3_cross(a, b, cross);
    sum += lth_v3_dot(cross, normal);
  }
  return sum;
}

/// A loop that passes both sides of a cut goes round its end within the facet.
static bool passes_twice(const SkinWork *w, LitheIndex loop) {
  for (LitheIndex i = w->loop_off[loop]; i < w->loop_off[loop + 1]; i++)
    for (LitheIndex j = i + 1; w->loop_node[i] >= w->t->n_points && j < w->loop_off[loop + 1]; j++)
      if (lth_skin_point(w, w->loop_node[i]) == lth_skin_point(w, w->loop_node[j])) return true;
  return false;
}

LitheStatus lth_skin_outline(LitheCtx *ctx, SkinWork *w, LitheIndex facet, bool *is_simple) {
  LITHE_TRY(sum_edges(ctx, w, facet));
  *is_simple = !has_forks(w);
  if (!*is_simple) return LITHE_OK;
  LITHE_TRY(trace(ctx, w));
  const double *normal = w->t->faces[w->piece[w->piece_off[facet]]].plane;
  for (LitheIndex l = 0; l < w->n_loops && *is_simple; l++)
    *is_simple = !passes_twice(w, l) && (w->n_loops == 1 || loop_area(w, l, normal) > 0);
  return LITHE_OK;
}

/// Whether a cut reaches any piece of a facet.
static bool is_touched(const SkinWork *w, LitheIndex facet) {
  for (LitheIndex i = w->piece_off[facet]; i < w->piece_off[facet + 1]; i++) {
    LthFaceView f = lth_topology_face(w->t, w->piece[i]);
    for (LitheIndex k = 0; k < f.loop_off[f.n_loops]; k++)
      if (w->cut_point[f.loop_point[k]] > 0) return true;
  }
  return false;
}

static void keep_points(SkinWork *w, LitheIndex facet) {
  for (LitheIndex i = w->piece_off[facet]; i < w->piece_off[facet + 1]; i++) {
    LthFaceView f = lth_topology_face(w->t, w->piece[i]);
    for (LitheIndex k = 0; k < f.loop_off[f.n_loops]; k++) w->is_kept[f.loop_point[k]] = true;
  }
}

LitheStatus lth_skin_find_facets(LitheCtx *ctx, SkinWork *w) {
  const LthSkin *skin = w->skin;
  LITHE_TRY(
      list_by_key(ctx, skin->n_facets, w->t->n_faces, facet_of_face, w, &w->piece_off, &w->piece));
  LITHE_TRY(list_by_key(ctx, skin->first->n_polys, skin->n_facets, poly_of_facet, w, &w->facet_off,
                        &w->facet));
  LTH_NEW(ctx, w->in_parts, skin->n_facets);
  for (LitheIndex k = 0; k < skin->n_facets; k++) {
    bool is_simple = true;
    if (!is_touched(w, k)) continue;
    LITHE_TRY(lth_skin_outline(ctx, w, k, &is_simple));
    w->in_parts[k] = !is_simple;
    if (!is_simple) keep_points(w, k);
  }
  return LITHE_OK;
}
