/// Connected parts of a mesh.
#include "base/disjoint_sets.h"
#include "mesh/mesh.h"

LitheStatus lth_mesh_parts(LitheCtx *ctx, const LthMesh *m, LitheIndex *part, LitheIndex *n) {
  LitheIndex *parent = NULL;
  LTH_NEW(ctx, parent, m->n_cells);
  lth_sets_reset(parent, m->n_cells);
  for (LitheIndex f = 0; f < m->n_faces; f++)
    if (m->face_cell[2 * f + 1] >= 0)
      lth_sets_unite(parent, m->face_cell[2 * f], m->face_cell[2 * f + 1]);
  *n = 0;
  for (LitheIndex c = 0; c < m->n_cells; c++) { // the root of a set is its lowest member
    LitheIndex root = lth_sets_root(parent, c);
    part[c] = root == c ? (*n)++ : part[root];
  }
  lth_free(ctx, parent);
  return LITHE_OK;
}
