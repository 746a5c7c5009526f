/// What `lithe mesh` reports: counts, volumes, how closed and how slender elements are.
#include "mesh/mesh.h"
#include "mesh/mesh_measure.h"

#include <math.h>

static LitheStatus count_components(LitheCtx *ctx, const LthMesh *m, LitheIndex *n) {
  LitheIndex *part = NULL;
  LTH_NEW(ctx, part, m->n_cells);
  LitheStatus status = lth_mesh_parts(ctx, m, part, n);
  lth_free(ctx, part);
  return status;
}

static double aspect(const double box[6]) {
  double lo = INFINITY, hi = 0;
  for (int i = 0; i < 3; i++) {
    lo = fmin(lo, box[3 + i] - box[i]);
    hi = fmax(hi, box[3 + i] - box[i]);
  }
  return lo > 0 ? hi / lo : INFINITY;
}

LitheStatus lth_mesh_quality(LitheCtx *ctx, const LthMesh *m, LthMeshQuality *q) {
  *q = (LthMeshQuality){.n_elements = m->n_cells, .n_faces = m->n_faces, .n_merged = m->n_merged};
  LITHE_TRY(count_components(ctx, m, &q->n_components));
  for (LitheIndex f = 0; f < m->n_faces; f++) {
    bool is_inner = m->face_cell[2 * f + 1] >= 0;
    q->n_inner_faces += is_inner;
    q->n_boundary_faces += !is_inner;
    if (!is_inner) q->surface_area += m->face_area[f];
  }
  q->min_volume = m->n_cells > 0 ? INFINITY : 0;
  for (LitheIndex c = 0; c < m->n_cells; c++) {
    double area = 0, gap = lth_mesh_cell_gap(m, c, &area);
    q->volume += m->cell_volume[c];
    q->min_volume = fmin(q->min_volume, m->cell_volume[c]);
    q->max_volume = fmax(q->max_volume, m->cell_volume[c]);
    q->max_gap = fmax(q->max_gap, gap / area);
    q->max_aspect = fmax(q->max_aspect, aspect(m->cell_box + 6 * c));
  }
  return LITHE_OK;
}
