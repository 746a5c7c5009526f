/// `lithe mesh`: the mesh of a scene without a simulation, as a file and in figures.
#include "io/file.h"
#include "io/vtu.h"
#include "scene/body.h"
#include "scene/scene_public.h"

#include <string.h>

/// Cell arrays of a mesh on its own: volume and number.
static LitheStatus write_mesh(LitheCtx *ctx, const LthMesh *mesh, const char *path) {
  LitheStatus status = LITHE_OK;
  LitheCount *off = NULL;
  LitheIndex *mesh_point = NULL;
  double *points = NULL, *number = NULL;
  LITHE_TRY_OR(done, lth_vtu_cell_points(ctx, mesh, &off, &mesh_point));
  LTH_NEW_OR(done, ctx, points, 3 * off[mesh->n_cells]);
  LTH_NEW_OR(done, ctx, number, mesh->n_cells);
  for (LitheCount i = 0; i < off[mesh->n_cells]; i++)
    for (int a = 0; a < 3; a++) points[3 * i + a] = mesh->points[3 * (LitheCount)mesh_point[i] + a];
  for (LitheIndex c = 0; c < mesh->n_cells; c++) number[c] = c;
  const LthVtuArray arrays[] = {{"volume", 1, mesh->cell_volume}, {"cell", 1, number}};
  LthVtu vtu = {.mesh = mesh,
                .n_points = (LitheIndex)off[mesh->n_cells],
                .points = points,
                .cell_point_off = off,
                .cell_mesh_point = mesh_point,
                .cell_arrays = arrays,
                .n_cell_arrays = 2};
  LITHE_TRY_OR(done, lth_vtu_write(ctx, path, &vtu));

done:
  lth_free(ctx, off);
  lth_free(ctx, mesh_point);
  lth_free(ctx, points);
  lth_free(ctx, number);
  return status;
}

static LitheMeshReport report_from(const LthMeshQuality *q, double seconds) {
  return (LitheMeshReport){.elements = q->n_elements,
                           .faces = q->n_faces,
                           .inner_faces = q->n_inner_faces,
                           .boundary_faces = q->n_boundary_faces,
                           .merged = q->n_merged,
                           .components = q->n_components,
                           .volume = q->volume,
                           .surface_area = q->surface_area,
                           .min_volume = q->min_volume,
                           .max_volume = q->max_volume,
                           .max_gap = q->max_gap,
                           .max_aspect = q->max_aspect,
                           .seconds = seconds};
}

LitheStatus lithe_mesh(LitheCtx *ctx, const LitheScene *scene, const char *path,
                       LitheMeshReport *report) {
  LitheStatus status = LITHE_OK;
  LthBody body = {.scene = scene->scene, .def = scene->scene->bodies};
  LthMeshQuality quality;
  double start = lth_now();
  const char *end = path ? strrchr(path, '.') : NULL;
  if (path && !(end && strcmp(end, ".vtu") == 0))
    LITHE_FAIL(ctx, LITHE_BAD_INPUT, "%s: a mesh is written as VTU; expected a name with .vtu",
               path);
  LITHE_TRY_OR(done, lth_build_mesh(ctx, &body));
  double seconds = lth_now() - start;
  LITHE_TRY_OR(done, lth_mesh_quality(ctx, body.mesh, &quality));
  if (path) LITHE_TRY_OR(done, write_mesh(ctx, body.mesh, path));
  *report = report_from(&quality, seconds);

done:
  lth_mesh_destroy(ctx, &body.mesh);
  lth_surface_destroy(ctx, &body.surface);
  return status;
}
