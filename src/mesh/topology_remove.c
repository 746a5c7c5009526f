/// Cells that are taken away.
#include "mesh/topology_priv.h"

static LitheStatus remove_cell(LitheCtx *ctx, LthTopology *t, LitheIndex cell) {
  LITHE_TRY(lth_topology_end_cell(ctx, t, cell));
  for (LitheIndex i = 0; i < t->cells[cell].n_faces; i++) {
    LitheIndex face = lth_topology_cell_faces(t, cell)[i],
               across = lth_topology_across(t, face, cell);
    if (!t->faces[face].is_live) continue; // of a cell that went before
    LITHE_ASSERT(across < 0 || t->work->cell_seen[across] == t->work->cell_stamp);
    LITHE_TRY(lth_topology_end_face(ctx, t, face, -1));
  }
  return LITHE_OK;
}

static void measure(LthTopology *t) {
  t->volume = t->area = 0;
  for (LitheIndex i = 0; i < t->n_cells; i++)
    if (t->cells[i].is_live) t->volume += t->cells[i].volume;
  for (LitheIndex i = 0; i < t->n_faces; i++) {
    const LthTopologyFace *f = t->faces + i;
    if (f->is_live && f->cell[1] < 0 && f->tag > LTH_TAG_CUT) t->area += f->area;
  }
}

LitheStatus lth_topology_remove(LitheCtx *ctx, LthTopology *t, LitheIndex n,
                                const LitheIndex *cells) {
  LITHE_TRY(lth_topology_begin_visit(ctx, t));
  for (LitheIndex i = 0; i < n; i++) lth_topology_visit_cell(t, cells[i]);
  for (LitheIndex i = 0; i < n; i++) LITHE_TRY(remove_cell(ctx, t, cells[i]));
  measure(t);
  return LITHE_OK;
}
