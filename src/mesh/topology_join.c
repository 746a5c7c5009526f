/// What a merge leaves: faces side by side in one plane become one, corners that no edge needs are taken out.
#include "mesh/topology_priv.h"

#include "base/disjoint_sets.h"

#include <stdlib.h>

/// A corner this close to the line between its neighbours, as a share of their distance, is on it.
#define STRAIGHT 1e-13

/// A face as its cell sees it.
typedef struct CellFace {
  LitheIndex across, tag, source, face;
  double plane[4]; ///< outward
} CellFace;

static int compare_planes(const CellFace *x, const CellFace *y) {
  if (x->across != y->across) return x->across < y->across ? -1 : 1;
  if (x->across < 0) {
    if (x->tag != y->tag) return x->tag < y->tag ? -1 : 1;
    if (x->source != y->source) return x->source < y->source ? -1 : 1;
  }
  for (int i = 0; i < 4; i++)
    if (x->plane[i] != y->plane[i]) return x->plane[i] < y->plane[i] ? -1 : 1;
  return 0;
}

static int compare_faces(const void *a, const void *b) {
  const CellFace *x = a, *y = b;
  int order = compare_planes(x, y);
  return order ? order : (x->face > y->face) - (x->face < y->face);
}

static int compare_edges(const void *a, const void *b) {
  const TopologyEdge *x = a, *y = b;
  if (x->key != y->key) return x->key < y->key ? -1 : 1;
  return (x->node > y->node) - (x->node < y->node);
}

/// Unite those of a run of faces that share an edge: work.set.
static LitheStatus connect_run(LitheCtx *ctx, LthTopology *t, const CellFace *run, LitheIndex n) {
  LthTopologyWork *w = t->work;
  LitheIndex n_edges = 0;
  LTH_RESERVE(ctx, w->set, w->set_cap, n);
  lth_sets_reset(w->set, n);
  for (LitheIndex i = 0; i < n; i++) {
    LthFaceView view = lth_topology_face(t, run[i].face);
    for (LitheIndex l = 0; l < view.n_loops; l++) {
      LitheIndex first = view.loop_off[l], last = view.loop_off[l + 1];
      LTH_RESERVE(ctx, w->edges, w->edges_cap, n_edges + last - first);
      for (LitheIndex j = first; j < last; j++)
        w->edges[n_edges++] =
            (TopologyEdge){lth_topology_edge_key(view.loop_point[j],
                                                 view.loop_point[j + 1 < last ? j + 1 : first]),
                           i, 0};
    }
  }
  qsort(w->edges, (size_t)n_edges, sizeof *w->edges, compare_edges);
  for (LitheIndex i = 1; i < n_edges; i++)
    if (w->edges[i].key == w->edges[i - 1].key)
      lth_sets_unite(w->set, w->edges[i].node, w->edges[i - 1].node);
  return LITHE_OK;
}

/// Make one face of the set of a run with this root, unless its loops do not come out.
static LitheStatus join_set(LitheCtx *ctx, LthTopology *t, LitheIndex cell, const CellFace *run,
                            LitheIndex n, LitheIndex root) {
  LthTopologyWork *w = t->work;
  TopologyChain *chain = &w->chain[0];
  double area = 0, joined = 0;
  bool is_clean = true;
  chain->n = 0;
  for (LitheIndex i = root; i < n; i++) {
    if (lth_sets_root(w->set, i) != root) continue;
    bool is_out = t->faces[run[i].face].cell[0] == cell;
    LthFaceView view = lth_topology_face(t, run[i].face);
    area += t->faces[run[i].face].area;
    for (LitheIndex l = 0; l < view.n_loops; l++)
      for (LitheIndex j = view.loop_off[l]; j < view.loop_off[l + 1]; j++) {
        LitheIndex a = view.loop_point[j],
                   b = view.loop_point[j + 1 < view.loop_off[l + 1] ? j + 1 : view.loop_off[l]];
        LITHE_TRY(lth_topology_chain_add(ctx, chain, is_out ? a : b, is_out ? b : a));
      }
  }
  w->n_parts = w->n_loops = w->n_corners = 0;
  LITHE_TRY(lth_topology_trace(ctx, t, chain, NULL, run[root].plane, -1, 0, &is_clean));
  for (LitheIndex p = 0; p < w->n_parts; p++) {
    LthFaceView view = {t->points, w->loop_off + w->parts[p].first_loop, w->corner,
                        w->parts[p].n_loops, run[root].plane};
    double centroid[3], a = lth_face_area_centroid(&view, centroid);
    is_clean &= a > 0;
    joined += a;
  }
  if (!is_clean || w->n_parts != 1 || !(fabs(joined - area) <= 1e-12 * area)) return LITHE_OK;
  LthTopologyFace like = {.cell = {cell, run[root].across},
                          .tag = t->faces[run[root].face].tag,
                          .source = t->faces[run[root].face].source};
  memcpy(like.plane, run[root].plane, sizeof like.plane);
  for (LitheIndex i = root; i < n; i++)
    if (lth_sets_root(w->set, i) == root) LITHE_TRY(lth_topology_end_face(ctx, t, run[i].face, -1));
  LitheIndex made = 0;
  if (like.cell[1] >= 0) LITHE_TRY(lth_topology_note_change(ctx, t, like.cell[1]));
  return lth_topology_add_face(ctx, t, &like, w->parts[0].n_loops,
                               w->loop_off + w->parts[0].first_loop, w->corner, false, &made);
}

static LitheStatus join_run(LitheCtx *ctx, LthTopology *t, LitheIndex cell, const CellFace *run,
                            LitheIndex n) {
  if (n < 2) return LITHE_OK;
  LITHE_TRY(connect_run(ctx, t, run, n));
  for (LitheIndex i = 0; i < n; i++) {
    LitheIndex size = 0;
    if (lth_sets_root(t->work->set, i) != i) continue;
    for (LitheIndex j = i; j < n; j++) size += lth_sets_root(t->work->set, j) == i;
    if (size > 1) LITHE_TRY(join_set(ctx, t, cell, run, n, i));
  }
  return LITHE_OK;
}

LitheStatus lth_topology_join_faces(LitheCtx *ctx, LthTopology *t, LitheIndex cell) {
  LitheStatus status = LITHE_OK;
  CellFace *list = NULL;
  LitheIndex n = 0;
  LTH_NEW_OR(done, ctx, list, t->cells[cell].n_faces);
  for (LitheIndex i = 0; i < t->cells[cell].n_faces; i++) {
    LitheIndex face = lth_topology_cell_faces(t, cell)[i];
    const LthTopologyFace *f = t->faces + face;
    if (f->is_line) continue;
    list[n] = (CellFace){lth_topology_across(t, face, cell), f->tag, f->source, face, {0}};
    for (int k = 0; k < 4; k++)
      list[n].plane[k] = lth_topology_side(t, face, cell) * f->plane[k] + 0.0;
    n++;
  }
  qsort(list, (size_t)n, sizeof *list, compare_faces);
  for (LitheIndex i = 0, j; i < n; i = j) {
    for (j = i + 1; j < n && compare_planes(list + i, list + j) == 0;) j++;
    LITHE_TRY_OR(done, join_run(ctx, t, cell, list + i, j - i));
  }
done:
  lth_free(ctx, list);
  return status;
}

// --- corners

/// A corner and its neighbours in a loop, in the order of their numbers.
typedef struct Corner {
  LitheIndex point, low, high;
  bool is_stale; ///< of the first of a point's corners: they have other neighbours by now
} Corner;

static int compare_corners(const void *a, const void *b) {
  const Corner *x = a, *y = b;
  if (x->point != y->point) return x->point < y->point ? -1 : 1;
  if (x->low != y->low) return x->low < y->low ? -1 : 1;
  return (x->high > y->high) - (x->high < y->high);
}

static bool is_straight(const LthTopology *t, const Corner *c) {
  const double *x = t->points + 3 * (LitheCount)c->point, *a = t->points + 3 * (LitheCount)c->low,
               *b = t->points + 3 * (LitheCount)c->high;
  double ab[3], ax[3], off[3];
  lth_v3_sub(b, a, ab);
  lth_v3_sub(x, a, ax);
  lth_v3_cross(ab, ax, off);
  double length2 = lth_v3_dot(ab, ab), along = lth_v3_dot(ab, ax);
  double tolerance = fmax(STRAIGHT * sqrt(length2), 4 * t->rounding);
  return along > 0 && along < length2 && lth_v3_norm(off) <= tolerance * sqrt(length2);
}

/// Count where a point stands in the faces around its edges; -1 where it has other neighbours somewhere or a face
/// would lose its third corner. The faces that have it go to work.list, `*n` of them.
static LitheStatus count_uses(LitheCtx *ctx, LthTopology *t, LitheIndex cell, const Corner *c,
                              LitheIndex *uses, LitheIndex *n) {
  LthTopologyWork *w = t->work;
  LitheIndex n_cells = 0;
  *uses = *n = 0;
  LITHE_TRY(lth_topology_begin_visit(ctx, t));
  lth_topology_visit_cell(t, cell);
  LTH_RESERVE(ctx, w->fresh, w->fresh_cap, 1);
  w->fresh[n_cells++] = cell;
  for (LitheIndex k = 0; k < n_cells; k++)
    for (LitheIndex i = 0; i < t->cells[w->fresh[k]].n_faces; i++) {
      LitheIndex face = lth_topology_cell_faces(t, w->fresh[k])[i], before = *uses;
      if (!lth_topology_visit_face(t, face)) continue;
      LthFaceView view = lth_topology_face(t, face);
      for (LitheIndex l = 0; l < view.n_loops; l++)
        for (LitheIndex j = view.loop_off[l], first = j, last = view.loop_off[l + 1]; j < last;
             j++) {
          if (view.loop_point[j] != c->point) continue;
          LitheIndex a = view.loop_point[j > first ? j - 1 : last - 1],
                     b = view.loop_point[j + 1 < last ? j + 1 : first];
          bool is_same = (a == c->low && b == c->high) || (a == c->high && b == c->low);
          if (!is_same || last - first < 4) {
            *uses = -1;
            return LITHE_OK;
          }
          ++*uses;
        }
      if (*uses == before) continue;
      LTH_RESERVE(ctx, w->list, w->list_cap, *n + 1);
      w->list[(*n)++] = face;
      LitheIndex across = lth_topology_across(t, face, w->fresh[k]);
      if (across < 0 || !lth_topology_visit_cell(t, across)) continue;
      LTH_RESERVE(ctx, w->fresh, w->fresh_cap, n_cells + 1);
      w->fresh[n_cells++] = across;
    }
  return LITHE_OK;
}

static LitheStatus drop_from_face(LitheCtx *ctx, LthTopology *t, LitheIndex face,
                                  LitheIndex point) {
  LthTopologyWork *w = t->work;
  LthFaceView view = lth_topology_face(t, face);
  LitheIndex n = 0;
  LTH_RESERVE(ctx, w->raw_off, w->raw_off_cap, view.n_loops + 1);
  LTH_RESERVE(ctx, w->raw_corner, w->raw_corner_cap, view.loop_off[view.n_loops]);
  w->raw_off[0] = 0;
  for (LitheIndex l = 0; l < view.n_loops; l++) {
    for (LitheIndex j = view.loop_off[l]; j < view.loop_off[l + 1]; j++)
      if (view.loop_point[j] != point) w->raw_corner[n++] = view.loop_point[j];
    w->raw_off[l + 1] = n;
  }
  return lth_topology_set_loops(ctx, t, face, view.n_loops, w->raw_off, w->raw_corner);
}

/// Corners of a cell's faces at marked points.
static LitheStatus list_corners(LitheCtx *ctx, const LthTopology *t, LitheIndex cell,
                                Corner **corners, LitheCount *cap, LitheIndex *n) {
  const LitheIndex *is_marked = t->work->mesh_point;
  *n = 0;
  for (LitheIndex i = 0; i < t->cells[cell].n_faces; i++) {
    LthFaceView view = lth_topology_face(t, lth_topology_cell_faces(t, cell)[i]);
    for (LitheIndex l = 0; l < view.n_loops; l++)
      for (LitheIndex j = view.loop_off[l], first = j, last = view.loop_off[l + 1]; j < last; j++) {
        if (!is_marked[view.loop_point[j]]) continue;
        LitheIndex a = view.loop_point[j > first ? j - 1 : last - 1],
                   b = view.loop_point[j + 1 < last ? j + 1 : first];
        LTH_RESERVE(ctx, *corners, *cap, (LitheCount)*n + 1);
        (*corners)[(*n)++] = (Corner){view.loop_point[j], a < b ? a : b, a < b ? b : a, false};
      }
  }
  if (*n > 0) qsort(*corners, (size_t)*n, sizeof **corners, compare_corners);
  return LITHE_OK;
}

/// Note that a point has other neighbours than its corners in the list say.
static void mark_stale(Corner *corners, LitheIndex n, LitheIndex point) {
  LitheIndex low = 0, high = n;
  while (low < high) {
    LitheIndex middle = low + (high - low) / 2;
    if (corners[middle].point < point)
      low = middle + 1;
    else
      high = middle;
  }
  if (low < n && corners[low].point == point) corners[low].is_stale = true;
}

/// Take out what can be taken out of a list of all corners, but for neighbours of what was: `*again` is true where there are any.
static LitheStatus drop_listed(LitheCtx *ctx, LthTopology *t, LitheIndex cell, Corner *corners,
                               LitheIndex n, bool *again) {
  for (LitheIndex i = 0, j; i < n; i = j) {
    const Corner *c = corners + i;
    bool is_same = !c->is_stale;
    for (j = i; j < n && corners[j].point == c->point; j++)
      is_same &= corners[j].low == c->low && corners[j].high == c->high;
    if (!is_same || c->low == c->high || c->point < t->n_surface_points || !is_straight(t, c))
      continue;
    LitheIndex uses = 0, n_faces = 0;
    LITHE_TRY(count_uses(ctx, t, cell, c, &uses, &n_faces));
    if (uses != t->point_use[c->point]) continue;
    for (LitheIndex k = 0; k < n_faces; k++)
      LITHE_TRY(drop_from_face(ctx, t, t->work->list[k], c->point));
    mark_stale(corners, n, c->low);
    mark_stale(corners, n, c->high);
    *again = true;
  }
  return LITHE_OK;
}

LitheStatus lth_topology_drop_corners(LitheCtx *ctx, LthTopology *t, LitheIndex cell,
                                      LitheIndex n_points, const LitheIndex *points) {
  LitheStatus status = LITHE_OK;
  Corner *corners = NULL;
  LitheCount cap = 0;
  LitheIndex n = 0;
  LTH_RESERVE(ctx, t->work->mesh_point, t->work->mesh_point_cap, t->n_points);
  for (LitheIndex i = 0; i < n_points; i++) t->work->mesh_point[points[i]] = 1;
  for (bool again = true; again;) {
    again = false;
    LITHE_TRY_OR(done, list_corners(ctx, t, cell, &corners, &cap, &n));
    LITHE_TRY_OR(done, drop_listed(ctx, t, cell, corners, n, &again));
  }
done:
  for (LitheIndex i = 0; i < n_points; i++) t->work->mesh_point[points[i]] = 0;
  lth_free(ctx, corners);
  return status;
}
