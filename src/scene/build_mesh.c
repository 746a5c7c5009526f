/// Shape and resolution -> grid -> polyhedral mesh.
#include "scene/staggered_body.h"

#include "base/tensor.h"

/// Cells along an axis; a body thinner than half a cell still gets one.
static LitheIndex at_least_one(double cells) {
  if (!(cells > 1)) return 1;
  return cells < 1e9 ? (LitheIndex)cells : 1000000000;
}

LitheStatus lth_build_grid(LitheCtx *ctx, const LthSceneBody *def, const double min[3],
                           const double max[3], LthGrid *grid) {
  const LthResolution *r = &def->resolution;
  double longest = fmax(max[0] - min[0], fmax(max[1] - min[1], max[2] - min[2]));
  lth_v3_copy(min, grid->min);
  lth_v3_copy(max, grid->max);
  for (int a = 0; a < 3; a++) {
    double side = max[a] - min[a];
    if (r->cell_size >
        0) // no cell larger than asked for; rounding of a whole number of cells forgiven
      grid->cells[a] = at_least_one(ceil(side / r->cell_size * (1 - 1e-9)));
    else if (r->cells[1] > 0)
      grid->cells[a] = r->cells[a];
    else
      grid->cells[a] = at_least_one(floor(side / longest * r->cells[0] + 0.5));
  }
  if (r->has_grid) *grid = r->grid;
  if ((double)grid->cells[0] * grid->cells[1] * grid->cells[2] > 1e8)
    LITHE_FAIL(ctx, LITHE_BAD_INPUT,
               "%s.method: a grid of %d x %d x %d cells is more than this version takes (1e8); use "
               "fewer cells",
               def->place, grid->cells[0], grid->cells[1], grid->cells[2]);
  return LITHE_OK;
}

/// Edge of a cube of a cell's volume.
static double cell_edge(const LthGrid *grid) {
  double volume = 1;
  for (int a = 0; a < 3; a++) volume *= (grid->max[a] - grid->min[a]) / grid->cells[a];
  return cbrt(volume);
}

/// A grid of its own has to hold the body: cells at its rim would reach on without an end.
static LitheStatus check_covers(LitheCtx *ctx, const LthBody *body, const LthGrid *grid) {
  const LthSurface *s = body->surface;
  double low[3], high[3];
  bool is_covered = true;
  if (!body->def->resolution.has_grid) return LITHE_OK;
  lth_surface_bounds(s, low, high);
  for (int a = 0; a < 3; a++) {
    double rounding = 1e-9 * (high[a] - low[a]);
    is_covered =
        is_covered && low[a] >= grid->min[a] - rounding && high[a] <= grid->max[a] + rounding;
  }
  if (is_covered) return LITHE_OK;
  LITHE_FAIL(ctx, LITHE_BAD_INPUT,
             "%s.method.grid: it does not hold the body, which reaches from (%g, %g, %g) to (%g, "
             "%g, %g); got a grid from (%g, %g, %g) to (%g, %g, %g)",
             body->def->place, low[0], low[1], low[2], high[0], high[1], high[2], grid->min[0],
             grid->min[1], grid->min[2], grid->max[0], grid->max[1], grid->max[2]);
}

LitheStatus lth_build_slices(LitheCtx *ctx, LthBody *body, const LthGrid *grid, double sliver,
                             LthMesh **mesh) {
  const LthSceneBody *def = body->def;
  double resolution = def->shape_resolution > 0 ? def->shape_resolution : cell_edge(grid) / 4;
  LITHE_TRY(lth_shape_tessellate(ctx, &def->shape, resolution, &body->surface));
  LITHE_TRY(check_covers(ctx, body, grid));
  return lth_mesh_slice(ctx, body->surface, grid, sliver, mesh);
}

static LitheStatus build_boxes(LitheCtx *ctx, LthBody *body, const LthGrid *grid,
                               const double min[3], const double max[3]) {
  const LthSceneBody *def = body->def;
  if (def->shape.kind != LTH_SHAPE_BOX)
    LITHE_FAIL(
        ctx, LITHE_BAD_INPUT,
        "%s.method.mesh: hexahedra and tetrahedra fill boxes only; use `slice` for other shapes",
        def->place);
  for (int a = 0; a < 3; a++) {
    double low = min[a], high = max[a], rounding = 1e-9 * (high - low);
    if (fabs(grid->min[a] - low) > rounding || fabs(grid->max[a] - high) > rounding)
      LITHE_FAIL(
          ctx, LITHE_BAD_INPUT,
          "%s.method.grid: hexahedra and tetrahedra fill the whole grid, so it has to be the "
          "box: got %g to %g along %c where the box has %g to %g; or use `mesh: slice`",
          def->place, grid->min[a], grid->max[a], "xyz"[a], low, high);
  }
  bool is_tetrahedra = def->mesh_kind == LTH_MESH_TETRAHEDRA;
  if (def->method_kind == LTH_METHOD_CG)
    LITHE_TRY(lth_build_elements(ctx, body, grid, is_tetrahedra, NULL));
  if (is_tetrahedra) return lth_mesh_tetrahedra(ctx, grid, &body->mesh);
  return lth_mesh_hexahedra(ctx, grid, &body->mesh);
}

static void measure_box(LthBody *body) {
  lth_mesh_bounds(body->mesh, body->box, body->box + 3);
  for (int a = 0; a < 3; a++) body->size = fmax(body->size, body->box[3 + a] - body->box[a]);
  body->cell_size = body->mesh->cell_size;
}

/// The elements of a file, which the scene owns, as polyhedra.
static LitheStatus build_file(LitheCtx *ctx, LthBody *body) {
  const LthSceneBody *def = body->def;
  if (!def->elements)
    LITHE_FAIL(ctx, LITHE_BAD_INPUT, "%s.method.mesh: its file was not opened", def->place);
  body->elements = def->elements;
  LITHE_TRY(lth_mesh_from_elements(ctx, def->elements, def->elements_file, &body->mesh));
  measure_box(body);
  return LITHE_OK;
}

LitheStatus lth_build_mesh(LitheCtx *ctx, LthBody *body) {
  double min[3], max[3];
  LthGrid grid;
  lth_progress(ctx, "meshing", -1);
  bool is_flat = body->scene->dimension == 2;
  if (body->def->mesh_kind == LTH_MESH_FILE) return build_file(ctx, body);
  lth_shape_bounds(&body->def->shape, min, max);
  if (!(min[0] < max[0] && min[1] < max[1] && (is_flat || min[2] < max[2])))
    LITHE_FAIL(ctx, LITHE_BAD_INPUT, "%s.shape: it is empty: %s", body->def->place,
               body->def->shape.kind == LTH_SHAPE_WRAP
                   ? "the file's surface winds round no place by half; close more of it"
                   : "its parts have no space in common; move or enlarge them");
  if (body->def->method_kind == LTH_METHOD_STAGGERED) return lth_build_fractions(ctx, body);
  LITHE_TRY(lth_build_grid(ctx, body->def, min, max, &grid));
  switch (body->def->mesh_kind) {
  case LTH_MESH_SLICE:
    LITHE_TRY(lth_build_slices(ctx, body, &grid, body->def->sliver, &body->mesh));
    break;
  case LTH_MESH_VOXELS:
    LITHE_TRY(lth_build_voxels(ctx, body, &grid));
    break;
  case LTH_MESH_EMBEDDED:
    LITHE_TRY(lth_build_covering(ctx, body, &grid));
    break;
  default:
    LITHE_TRY(build_boxes(ctx, body, &grid, min, max));
  }
  measure_box(body);
  return LITHE_OK;
}
