/// Solids from volumes: where they are, how large, which pieces, and what their voxels are called.
#include "solids.h"

#include "geometry/shape.h"

/// n^3 voxels of size h, turned by R and moved.
static LthVolume *cube_volume(LitheCtx *ctx, LitheIndex n, double h, const double R[9],
                              const double shift[3]) {
  double A[12];
  LthVolume *v = NULL;
  for (int i = 0; i < 3; i++) {
    for (int j = 0; j < 3; j++) A[4 * i + j] = h * (R ? R[3 * i + j] : i == j);
    A[4 * i + 3] = shift[i];
  }
  CHECK_OK(ctx, lth_volume_create(ctx, (LitheIndex[3]){n, n, n}, A, &v));
  return v;
}

static void world(const LthVolume *v, LitheCount p, double x[3]) {
  double at[3] = {(double)(p % v->n[0]), (double)(p / v->n[0] % v->n[1]),
                  (double)(p / v->n[0] / v->n[1])};
  for (int i = 0; i < 3; i++)
    x[i] = v->to_world[4 * i] * at[0] + v->to_world[4 * i + 1] * at[1] +
           v->to_world[4 * i + 2] * at[2] + v->to_world[4 * i + 3];
}

static LthImage *image_of(LitheCtx *ctx, const LthVolume *v, double threshold, const double *labels,
                          LitheIndex n_labels, double width) {
  LthImage *m = NULL;
  CHECK_OK(ctx, lth_image_create(ctx, v, threshold, labels, n_labels, width, &m));
  return m;
}

static LthSurface *surface_of(LitheCtx *ctx, const LthImage *m, double resolution) {
  LthShape shape = {.kind = LTH_SHAPE_IMAGE, .image = m};
  LthSurface *s = NULL;
  CHECK_OK(ctx, lth_shape_tessellate(ctx, &shape, resolution, &s));
  return s;
}

/// A ball of radius 1 as minus the distance from its centre, on voxels that lie askew.
static void a_ball_lands_where_its_map_says(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  double R[9], center[3] = {3, -2, 5}, error[2];
  solid_rotation(1, 2, -1, 0.8, R);
  for (int i = 0; i < 3; i++) R[3 * i + 1] += 0.3 * R[3 * i]; // sheared
  for (int level = 0; level < 2; level++) {
    LitheIndex n = level ? 48 : 24;
    double h = 3.6 / n, shift[3];
    for (int i = 0; i < 3; i++)
      shift[i] = center[i] - 0.5 * h * (n - 1) * (R[3 * i] + R[3 * i + 1] + R[3 * i + 2]);
    LthVolume *v = cube_volume(ctx, n, h, R, shift);
    for (LitheCount p = 0; p < lth_volume_size(v); p++) {
      double x[3];
      world(v, p, x);
      v->values[p] = (float)-lth_v3_distance(x, center);
    }
    LthImage *m = image_of(ctx, v, -1, NULL, 0, 0);
    assert_int_equal(m->n_islands, 1);
    LthSurface *s = surface_of(ctx, m, 0.8 * h);
    error[level] = 0;
    for (LitheIndex p = 0; p < s->n_points; p++)
      error[level] = fmax(error[level], fabs(lth_v3_distance(s->points + 3 * p, center) - 1));
    CHECK_NEAR(solid_volume(s), 4.0 / 3 * M_PI, 2 * h * h * 4 * M_PI);
    lth_surface_destroy(ctx, &s);
    lth_image_destroy(ctx, &m);
    lth_volume_destroy(ctx, &v);
  }
  // trilinear interpolation is of order two; the points that lie 1e-4 of an edge off are far below
  CHECK_AT_MOST(error[1], error[0] / 3);
  CHECK_AT_MOST(error[1], 0.5 * (3.6 / 48) * (3.6 / 48));
  lithe_ctx_destroy(&ctx);
}

/// Labels: 1 in a box of voxels, 2 in its right half, 7 in one voxel apart.
static LthVolume *labelled(LitheCtx *ctx) {
  LthVolume *v = cube_volume(ctx, 12, 0.5, NULL, (double[]){0, 0, 0});
  for (LitheIndex k = 2; k < 8; k++)
    for (LitheIndex j = 2; j < 8; j++)
      for (LitheIndex i = 2; i < 8; i++) v->values[lth_volume_index(v, i, j, k)] = i < 5 ? 1 : 2;
  v->values[lth_volume_index(v, 10, 10, 10)] = 7;
  return v;
}

static void labels_select_voxels_and_islands_are_found(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthVolume *v = labelled(ctx);
  LthImage *m = image_of(ctx, v, 0, (double[]){1, 2, 7}, 3, 0);
  assert_int_equal(m->n_islands, 2);
  assert_int_equal(m->island_size[0], 216);
  assert_int_equal(m->island_size[1], 1);
  CHECK_NEAR(m->box[0], 0.75, 1e-12);
  CHECK_NEAR(m->box[3], 5.25, 1e-12);
  LthSurface *s = surface_of(ctx, m, 0.1);
  assert_int_equal(s->n_shells, 2);
  lth_surface_destroy(ctx, &s);

  lth_image_drop(m, (bool[]){true, false});
  s = surface_of(ctx, m, 0.1);
  assert_int_equal(s->n_shells, 1);
  // 27 less bevelled edges and corners: 12 edges of 3 m lose at most h^2 / 8 of their section
  CHECK_NEAR(solid_volume(s), 27, 36 * 0.25 / 8 + 0.05);
  lth_surface_destroy(ctx, &s);

  // next to the surface the label is that of the solid, not of the nothing outside
  assert_true(lth_image_label(m, (double[]){0.76, 2, 2}) == 1);
  assert_true(lth_image_label(m, (double[]){3.7, 2, 2}) == 2);
  assert_true(lth_image_label(m, (double[]){2.2, 2, 2}) == 1);
  assert_true(lth_image_label(m, (double[]){2.3, 2, 2}) == 2);
  lth_image_destroy(ctx, &m);
  lth_volume_destroy(ctx, &v);
  lithe_ctx_destroy(&ctx);
}

static void values_are_linear_between_voxels_and_constant_beyond(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthVolume *v = cube_volume(ctx, 4, 0.25, NULL, (double[]){1, 1, 1});
  for (LitheCount p = 0; p < 64; p++) {
    double x[3];
    world(v, p, x);
    v->values[p] = (float)(8 * x[0] - 4 * x[1] + 16 * x[2]);
  }
  uint64_t seed = 3;
  for (int k = 0; k < 100; k++) {
    double x[3];
    for (int i = 0; i < 3; i++) x[i] = 1 + 0.75 * test_random(&seed);
    CHECK_NEAR(lth_volume_value(v, x), 8 * x[0] - 4 * x[1] + 16 * x[2], 1e-5);
  }
  assert_true(lth_volume_value(v, (double[]){-9, 1, 1}) == (double)v->values[0]);
  assert_true(lth_volume_value(v, (double[]){99, 99, 99}) == (double)v->values[63]);
  lth_volume_destroy(ctx, &v);
  lithe_ctx_destroy(&ctx);
}

/// A Gaussian keeps sums and adds its variance.
static void smoothing_has_the_width_it_says(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthVolume *v = cube_volume(ctx, 31, 0.1, NULL, (double[]){-1.5, -1.5, -1.5});
  float *values = lth_alloc(ctx, lth_volume_size(v), sizeof *values);
  values[lth_volume_index(v, 15, 15, 15)] = 1;
  CHECK_OK(ctx, lth_volume_smooth(ctx, v, 0.25, values));
  double sum = 0, second = 0;
  for (LitheCount p = 0; p < lth_volume_size(v); p++) {
    double x[3];
    world(v, p, x);
    sum += (double)values[p];
    second += (double)values[p] * x[1] * x[1];
  }
  CHECK_NEAR(sum, 1, 1e-5);
  CHECK_NEAR(sqrt(second), 0.25, 0.01); // cut off at three standard deviations
  lth_free(ctx, values);
  lth_volume_destroy(ctx, &v);
  lithe_ctx_destroy(&ctx);
}

static void nothing_selected_tells_the_range(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthVolume *v = labelled(ctx);
  LthImage *m = NULL;
  assert_int_equal(lth_image_create(ctx, v, 7, NULL, 0, 0, &m), LITHE_BAD_INPUT);
  assert_string_equal(lithe_ctx_message(ctx),
                      "no voxel is above the threshold of 7: values are from 0 to 7");
  assert_int_equal(lth_image_create(ctx, v, 0, (double[]){5}, 1, 0, &m), LITHE_BAD_INPUT);
  assert_string_equal(lithe_ctx_message(ctx), "no voxel has the label 5: values are from 0 to 7");
  assert_null(m);
  lth_volume_destroy(ctx, &v);
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_ball_lands_where_its_map_says),
      cmocka_unit_test(labels_select_voxels_and_islands_are_found),
      cmocka_unit_test(values_are_linear_between_voxels_and_constant_beyond),
      cmocka_unit_test(smoothing_has_the_width_it_says),
      cmocka_unit_test(nothing_selected_tells_the_range),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
