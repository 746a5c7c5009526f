/// Slicing the surfaces that Lithe itself makes of primitives, combinations and formulas.
#include "check.h"
#include "geometry/shape.h"
#include "mesh/mesh.h"
#include "slice_checks.h"

static double gyroid(const void *self, const double x[3], double t) {
  (void)self;
  (void)t;
  double r = lth_v3_norm(x) - 1, s = 5;
  double f =
      sin(s * x[0]) * cos(s * x[1]) + sin(s * x[1]) * cos(s * x[2]) + sin(s * x[2]) * cos(s * x[0]);
  return fmax(r, fabs(f) - 0.6);
}

static void tessellated_shapes_are_sliced_exactly(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthShape parts[2] = {
      {.kind = LTH_SHAPE_BOX, .a = {-1, -0.5, -0.5}, .b = {1, 0.5, 0.5}},
      {.kind = LTH_SHAPE_CYLINDER, .a = {0, -2, 0}, .b = {0, 2, 0}, .radius = 0.3}};
  LthShape shapes[] = {
      {.kind = LTH_SHAPE_CYLINDER, .a = {0, 0, -1}, .b = {0, 0, 1}, .radius = 0.5},
      {.kind = LTH_SHAPE_CAPSULE, .a = {0, 0, -1}, .b = {0.5, 0, 1}, .radius = 0.5},
      {.kind = LTH_SHAPE_SHELL, .radius = 1, .inner = 0.9},
      {.kind = LTH_SHAPE_DIFFERENCE, .children = parts, .n_children = 2},
      {.kind = LTH_SHAPE_UNION, .children = parts, .n_children = 2},
      {.kind = LTH_SHAPE_IMPLICIT,
       .value = {.eval = gyroid},
       .box = {-1.1, -1.1, -1.1, 1.1, 1.1, 1.1}},
  };
  for (size_t i = 0; i < sizeof shapes / sizeof shapes[0]; i++) {
    LthSurface *s = NULL;
    CHECK_OK(ctx, lth_shape_tessellate(ctx, shapes + i, 0.1, &s));
    for (int cells = 3; cells <= 8; cells += 5) {
      LthGrid g = cubic_grid(s, cells);
      LthMesh *m = NULL;
      CHECK_OK(ctx, lth_mesh_slice(ctx, s, &g, 0, &m));
      check_sliced(ctx, s, m, 1);
      check_cell_volumes(s, &g, m, 1e-11);
      lth_mesh_destroy(ctx, &m);
      CHECK_OK(ctx, lth_mesh_slice(ctx, s, &g, 0.1, &m));
      check_sliced(ctx, s, m, 1);
      lth_mesh_destroy(ctx, &m);
    }
    lth_surface_destroy(ctx, &s);
  }
  lithe_ctx_destroy(&ctx);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(tessellated_shapes_are_sliced_exactly),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
