/// New corners on the edges of neighbours: all faces around an edge get the point in which it was cut.
#include "mesh/topology_priv.h"

/// A face's loops with the new points of its edges in raw_corner and raw_off; false where there are none.
static LitheStatus divide_loops(LitheCtx *ctx, LthTopology *t, LitheIndex face, bool *is_divided) {
  LthTopologyWork *w = t->work;
  const LthTopologyFace *f = t->faces + face;
  const LitheIndex *off = lth_topology_loops(t, f), *corner = off + f->n_loops + 1;
  LitheIndex n = 0;
  LTH_RESERVE(ctx, w->raw_corner, w->raw_corner_cap, 2 * (LitheCount)f->n_corners);
  LTH_RESERVE(ctx, w->raw_off, w->raw_off_cap, f->n_loops + 1);
  w->raw_off[0] = 0;
  *is_divided = false;
  for (LitheIndex l = 0; l < f->n_loops; l++) {
    for (LitheIndex j = off[l]; j < off[l + 1]; j++) {
      LitheIndex a = corner[j], b = corner[j + 1 < off[l + 1] ? j + 1 : off[l]], p = -1;
      w->raw_corner[n++] = a;
      if (w->point_stamp[a] == w->stamp && w->point_stamp[b] == w->stamp &&
          w->point_sign[a] * w->point_sign[b] < 0)
        p = lth_topology_find_cut(t, a, b);
      if (p < 0) continue;
      w->raw_corner[n++] = p;
      *is_divided = true;
    }
    w->raw_off[l + 1] = n;
  }
  return LITHE_OK;
}

static LitheStatus divide_cell(LitheCtx *ctx, LthTopology *t, LitheIndex cell, LitheIndex split,
                               LitheIndex *n_list) {
  LthTopologyWork *w = t->work;
  for (LitheIndex i = 0; i < t->cells[cell].n_faces; i++) {
    LitheIndex face = lth_topology_cell_faces(t, cell)[i];
    const LthTopologyFace *f = t->faces + face;
    bool is_divided = false;
    if (!lth_topology_visit_face(t, face) || f->cell[0] == split || f->cell[1] == split) continue;
    LITHE_TRY(divide_loops(ctx, t, face, &is_divided));
    if (!is_divided) continue;
    LITHE_TRY(
        lth_topology_set_loops(ctx, t, face, t->faces[face].n_loops, w->raw_off, w->raw_corner));
    LitheIndex across = lth_topology_across(t, face, cell);
    if (across < 0 || !lth_topology_visit_cell(t, across)) continue;
    LTH_RESERVE(ctx, w->list, w->list_cap, *n_list + 1);
    w->list[(*n_list)++] = across;
  }
  return LITHE_OK;
}

LitheStatus lth_topology_divide_edges(LitheCtx *ctx, LthTopology *t, LitheIndex cell) {
  LthTopologyWork *w = t->work;
  LitheIndex n = 0;
  if (w->n_cuts == 0) return LITHE_OK;
  LITHE_TRY(lth_topology_begin_visit(ctx, t));
  lth_topology_visit_cell(t, cell);
  for (LitheIndex p = 0; p < w->n_parts; p++) {
    const TopologyPart *part = w->parts + p;
    if (part->face < 0 || part->n_loops == 0) continue;
    LitheIndex across = lth_topology_across(t, part->face, cell);
    if (across < 0 || !lth_topology_visit_cell(t, across)) continue;
    LTH_RESERVE(ctx, w->list, w->list_cap, n + 1);
    w->list[n++] = across;
  }
  for (LitheIndex i = 0; i < n; i++) LITHE_TRY(divide_cell(ctx, t, w->list[i], cell, &n));
  return LITHE_OK;
}
