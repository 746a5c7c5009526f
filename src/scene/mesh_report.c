/// `lithe mesh`: the mesh of a scene without a simulation, as a file and in figures.
#include "io/file.h"
#include "io/vtu.h"
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
  const LthVtuArray arrays[] = {{"volume", 1, mesh->cell_volume}, {"cell", 1, number}};
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

/// "mesh.vtu", or "mesh_NAME.vtu" where there are several bodies.
static LitheStatus write_body(LitheCtx *ctx, const LthBody *body, const char *path) {
  char *named = NULL;
  if (body->scene->n_bodies == 1) return write_mesh(ctx, body->mesh, path);
  size_t stem = strlen(path) - 4, room = strlen(path) + strlen(body->def->name) + 2;
  LTH_NEW(ctx, named, (LitheCount)room);
  snprintf(named, room, "%.*s_%s.vtu", (int)stem, path, body->def->name);
  LitheStatus status = write_mesh(ctx, body->mesh, named);
  lth_free(ctx, named);
  return status;
}

LitheStatus lithe_mesh(LitheCtx *ctx, const LitheScene *scene, const char *path,
                       LitheMeshReport *report) {
  LitheStatus status = LITHE_OK;
  LthWorld *world = NULL;
  double start = lth_now();
  const char *end = path ? strrchr(path, '.') : NULL;
  if (path && !(end && strcmp(end, ".vtu") == 0))
    LITHE_FAIL(ctx, LITHE_BAD_INPUT, "%s: a mesh is written as VTU; expected a name with .vtu",
               path);
  *report = (LitheMeshReport){0};
  LITHE_TRY_OR(done, lth_world_create_meshes(ctx, scene->scene, &world));
  report->seconds = lth_now() - start;
  for (LitheIndex b = 0; b < world->n_bodies; b++) {
    LthMeshQuality quality;
    LITHE_TRY_OR(done, lth_mesh_quality(ctx, world->bodies[b]->mesh, &quality));
    add_quality(&quality, report);
    if (path) LITHE_TRY_OR(done, write_body(ctx, world->bodies[b], path));
  }

done:
  lth_world_destroy(ctx, &world);
  return status;
}
