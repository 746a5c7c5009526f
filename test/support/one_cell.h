/// A mesh of one polyhedron.
#pragma once

#include "check.h"
#include "mesh/mesh.h"
#include "polyhedra.h"

/// A mesh of the one cell `solid`.
static inline LthMesh *test_one_cell(LitheCtx *ctx, const TestSolid *solid) {
  LitheIndex face_cell[2 * TEST_SOLID_LOOPS];
  for (int f = 0; f < solid->n_faces; f++) face_cell[2 * f] = 0, face_cell[2 * f + 1] = -1;
  LthMeshDef def = {.n_points = solid->n_points,
                    .n_faces = solid->n_faces,
                    .n_cells = 1,
                    .points = solid->points,
                    .face_loop_off = solid->face_loop_off,
                    .loop_off = solid->loop_off,
                    .loop_point = solid->loop_point,
                    .face_cell = face_cell,
                    .cell_size = 1};
  LthMesh *mesh = NULL;
  CHECK_OK(ctx, lth_mesh_create(ctx, &def, &mesh));
  return mesh;
}
