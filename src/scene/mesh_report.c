/// `lithe mesh`: the mesh of a scene without a simulation, as a file and in figures.
#include "io/file.h"
#include "io/vtu.h"
#include "scene/report_grid.h"
#include "scene/scene_public.h"
#include "scene/world.h"

#include <math.h>
#include <stdio.h>
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
  const LthVtuArray arrays[] = {lth_vtk_array("volume", 1, mesh->cell_volume),
                                lth_vtk_array("cell", 1, number)};
  LthVtu vtu = {.mesh = mesh,
                .n_points = (LitheIndex)off[mesh->n_cells],
                .points = points,
                .wide_points = true,
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

static void add_quality(const LthMeshQuality *q, LitheMeshReport *r) {
  bool first = r->elements == 0;
  r->elements += q->n_elements;
  r->faces += q->n_faces;
  r->inner_faces += q->n_inner_faces;
  r->boundary_faces += q->n_boundary_faces;
  r->merged += q->n_merged;
  r->components += q->n_components;
  r->volume += q->volume;
  r->surface_area += q->surface_area;
  r->min_volume = first ? q->min_volume : fmin(r->min_volume, q->min_volume);
  r->max_volume = fmax(r->max_volume, q->max_volume);
  r->max_gap = fmax(r->max_gap, q->max_gap);
  r->max_aspect = fmax(r->max_aspect, q->max_aspect);
}

static LitheStatus write_one(LitheCtx *ctx, const LthBody *body, const char *path) {
  const char *end = strrchr(path, '.'), *wanted = body->staggered ? ".vti" : ".vtu";
  if (!end || strcmp(end, wanted) != 0)
    LITHE_FAIL(ctx, LITHE_BAD_INPUT, "%s: %s; expected a name with %s", path,
               body->staggered ? "fractions of a grid are written as VTI"
                               : "a mesh is written as VTU",
               wanted);
  return body->staggered ? lth_write_fractions(ctx, body, path) : write_mesh(ctx, body->mesh, path);
}

/// "mesh.vtu", or "mesh_NAME.vtu" where there are several bodies.
static LitheStatus write_body(LitheCtx *ctx, const LthBody *body, const char *path) {
  char *named = NULL;
  if (body->scene->n_bodies == 1) return write_one(ctx, body, path);
  size_t stem = strlen(path) - 4, room = strlen(path) + strlen(body->def->name) + 2;
  LTH_NEW(ctx, named, (LitheCount)room);
  snprintf(named, room, "%.*s_%s%s", (int)stem, path, body->def->name,
           body->staggered ? ".vti" : ".vtu");
  LitheStatus status = write_one(ctx, body, named);
  lth_free(ctx, named);
  return status;
}

static LitheStatus add_body(LitheCtx *ctx, const LthBody *body, LitheMeshReport *report) {
  LthMeshQuality quality;
  if (body->staggered) return lth_report_grid(ctx, body, report);
  LITHE_TRY(lth_mesh_quality(ctx, body->mesh, &quality));
  add_quality(&quality, report);
  return LITHE_OK;
}

LitheStatus lithe_mesh(LitheCtx *ctx, const LitheScene *scene, const char *path,
                       LitheMeshReport *report) {
  LitheStatus status = LITHE_OK;
  LthWorld *world = NULL;
  double start = lth_now();
  const char *end = path ? strrchr(path, '.') : NULL;
  if (path && !(end && (strcmp(end, ".vtu") == 0 || strcmp(end, ".vti") == 0)))
    LITHE_FAIL(ctx, LITHE_BAD_INPUT,
               "%s: a mesh is written as VTU, fractions of a grid as VTI; expected a name with "
               ".vtu or .vti",
               path);
  *report = (LitheMeshReport){0};
  LITHE_TRY_OR(done, lth_world_create_meshes(ctx, scene->scene, &world));
  report->seconds = lth_now() - start;
  for (LitheIndex b = 0; b < world->n_bodies; b++) {
    LITHE_TRY_OR(done, add_body(ctx, world->bodies[b], report));
    if (path) LITHE_TRY_OR(done, write_body(ctx, world->bodies[b], path));
  }

done:
  lth_world_destroy(ctx, &world);
  return status;
}
