/// The boundary of a mesh as a surface.
#include "mesh/mesh.h"

#include <string.h>

/// Number the points of the boundary in the order of the mesh; `point` (n_points) gets index + 1, 0 inside.
static void number_points(const LthMesh *m, LitheIndex *point, LthSoup *s, LitheCount *n_corners) {
  for (LitheIndex f = 0; f < m->n_faces; f++) {
    if (m->face_cell[2 * f + 1] >= 0) continue;
    LitheIndex begin = m->loop_off[m->face_loop_off[f]], end = m->loop_off[m->face_loop_off[f] + 1];
    for (LitheIndex i = begin; i < end; i++) point[m->loop_point[i]] = 1;
    *n_corners += end - begin;
    s->n_polys++;
  }
  for (LitheIndex p = 0; p < m->n_points; p++)
    if (point[p]) point[p] = ++s->n_points;
}

static LitheStatus fill(LitheCtx *ctx, const LthMesh *m, LitheIndex *point, LthSoup *s) {
  LitheCount n = 0;
  LitheIndex k = 0;
  number_points(m, point, s, &n);
  LTH_NEW(ctx, s->points, 3 * (LitheCount)s->n_points);
  LTH_NEW(ctx, s->poly_off, (LitheCount)s->n_polys + 1);
  LTH_NEW(ctx, s->poly_point, n);
  for (LitheIndex p = 0; p < m->n_points; p++)
    if (point[p])
      memcpy(s->points + 3 * (LitheCount)(point[p] - 1), m->points + 3 * (LitheCount)p,
             3 * sizeof *s->points);
  for (LitheIndex f = 0; f < m->n_faces; f++) {
    if (m->face_cell[2 * f + 1] >= 0) continue;
    LitheIndex begin = m->loop_off[m->face_loop_off[f]], end = m->loop_off[m->face_loop_off[f] + 1];
    for (LitheIndex i = begin; i < end; i++)
      s->poly_point[s->poly_off[k] + i - begin] = point[m->loop_point[i]] - 1;
    s->poly_off[k + 1] = s->poly_off[k] + end - begin;
    k++;
  }
  return LITHE_OK;
}

LitheStatus lth_mesh_boundary_soup(LitheCtx *ctx, const LthMesh *mesh, LthSoup **soup) {
  LitheStatus status = LITHE_OK;
  LitheIndex *point = NULL;
  *soup = NULL;
  LTH_NEW_OR(done, ctx, *soup, 1);
  LTH_NEW_OR(done, ctx, point, mesh->n_points);
  LITHE_TRY_OR(done, fill(ctx, mesh, point, *soup));
done:
  lth_free(ctx, point);
  if (status != LITHE_OK) lth_soup_destroy(ctx, soup);
  return status;
}
