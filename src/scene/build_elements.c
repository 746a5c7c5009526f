/// Elements of conforming bodies: of a box's grid, of voxels, or of all grid cells that the body touches.
#include "scene/body.h"

#include "mesh/grid_fill.h"

LitheStatus lth_build_elements(LitheCtx *ctx, LthBody *body, const LthGrid *grid, bool tetrahedra,
                               const uint8_t *keep) {
  const LthSceneBody *def = body->def;
  bool serendipity = def->hexahedron != LTH_HEXAHEDRON_27;
  LITHE_TRY(lth_element_mesh_grid(ctx, grid, def->degree, serendipity, tetrahedra, keep,
                                  &body->elements));
  if (def->hexahedron != LTH_HEXAHEDRON_20R || tetrahedra || def->degree != 2) return LITHE_OK;
  LTH_NEW(ctx, body->elements->reduced, body->elements->n_elements);
  for (LitheIndex e = 0; e < body->elements->n_elements; e++) body->elements->reduced[e] = 1;
  return LITHE_OK;
}

/// Cells at least half full, known from the exact slices.
static LitheStatus choose_voxels(LitheCtx *ctx, const LthBody *body, const LthGrid *grid,
                                 const LthMesh *slices, uint8_t *keep) {
  LitheIndex n_cells = grid->cells[0] * grid->cells[1] * grid->cells[2], n = 0, dropped;
  LITHE_TRY(lth_grid_voxels(ctx, grid, slices, keep, &dropped));
  for (LitheIndex k = 0; k < n_cells; k++) n += keep[k];
  if (n == 0)
    LITHE_FAIL(ctx, LITHE_BAD_INPUT,
               "%s.method: no cell of the grid is half full, so no voxel stands for the body; use "
               "smaller cells, or `mesh: embedded`",
               body->def->place);
  if (dropped > 0)
    lth_warn(ctx,
             "%s.method: %d voxels hang on the others by edges or corners only and are left out: "
             "thin parts of the shape need smaller cells, or `mesh: embedded`",
             body->def->path, dropped);
  return LITHE_OK;
}

LitheStatus lth_build_voxels(LitheCtx *ctx, LthBody *body, const LthGrid *grid) {
  LitheStatus status = LITHE_OK;
  LthMesh *slices = NULL;
  uint8_t *keep = NULL;
  LITHE_TRY_OR(done, lth_build_slices(ctx, body, grid, 0, &slices));
  LTH_NEW_OR(done, ctx, keep, (LitheCount)grid->cells[0] * grid->cells[1] * grid->cells[2]);
  LITHE_TRY_OR(done, choose_voxels(ctx, body, grid, slices, keep));
  LITHE_TRY_OR(done, lth_build_elements(ctx, body, grid, false, keep));
  status = lth_mesh_from_elements(ctx, body->elements, "voxels", &body->mesh);
done:
  lth_mesh_destroy(ctx, &slices);
  lth_free(ctx, keep);
  return status;
}

/// Element of each cell of the slices: touched grid cells are numbered in their order.
static LitheStatus number_touched(LitheCtx *ctx, LthBody *body, LitheIndex n_cells, uint8_t *keep) {
  LitheIndex *number = NULL, n = 0;
  LTH_NEW(ctx, number, n_cells);
  for (LitheIndex c = 0; c < body->mesh->n_cells; c++) keep[body->cell_element[c]] = 1;
  for (LitheIndex k = 0; k < n_cells; k++)
    if (keep[k]) number[k] = n++;
  for (LitheIndex c = 0; c < body->mesh->n_cells; c++)
    body->cell_element[c] = number[body->cell_element[c]];
  lth_free(ctx, number);
  return LITHE_OK;
}

LitheStatus lth_build_covering(LitheCtx *ctx, LthBody *body, const LthGrid *grid) {
  LitheStatus status = LITHE_OK;
  LitheIndex n_cells = grid->cells[0] * grid->cells[1] * grid->cells[2];
  uint8_t *keep = NULL;
  LITHE_TRY_OR(done, lth_build_slices(ctx, body, grid, 0, &body->mesh));
  LTH_NEW_OR(done, ctx, keep, n_cells);
  LTH_NEW_OR(done, ctx, body->cell_element, body->mesh->n_cells);
  lth_grid_cells(grid, body->mesh, body->cell_element);
  LITHE_TRY_OR(done, number_touched(ctx, body, n_cells, keep));
  status = lth_build_elements(ctx, body, grid, false, keep);
done:
  lth_free(ctx, keep);
  return status;
}
