/// Exact fractions: volumes to rounding, whichever way the axes lie, of surfaces, primitives, combinations, voxels.
#include "ctx_fixture.h"
#include "fraction_grid.h"
#include "soup_maker.h"

#include "base/tensor.h"
#include "geometry/fractions.h"
#include "geometry/shape.h"

static const LthFractionDef exact = {.method = LTH_FRACTIONS_EXACT};

static LthFractions *create(LitheCtx *ctx, const LthShape *shape) {
  LthFractions *f = NULL;
  CHECK_OK(ctx, lth_fractions_create(ctx, shape, 3, origin, h, n, &exact, &f));
  return f;
}

/// Two shapes have the same parts; axis a of the first is axis axes[a] of the second.
static void check_same(const LthFractions *f, const LthFractions *g, const int axes[3],
                       const int shift[3], double tolerance) {
  for (int c = 0; c < 40 * 40 * 40; c++) {
    int at[3] = {c % 40, c / 40 % 40, c / 1600}, to[3];
    bool is_in = true;
    for (int a = 0; a < 3; a++) {
      to[axes[a]] = at[a] + shift[a];
      is_in = is_in && at[a] + shift[a] >= 0 && at[a] + shift[a] < 40;
    }
    if (is_in) CHECK_NEAR(part_at(g, to), part_at(f, at), tolerance);
  }
}

static const int same_axes[3] = {0, 1, 2}, no_shift[3] = {0, 0, 0};

/// A surface as a prepared shape.
static LthShape prepared(LitheCtx *ctx, const LthSurface *s) {
  LthShape mesh = {.kind = LTH_SHAPE_MESH, .surface = s};
  CHECK_OK(ctx, lth_shape_prepare(ctx, &mesh));
  return mesh;
}

static void parts_of_a_surface_sum_up_to_its_volume(void **state) {
  Fixture *x = *state;
  LthSurface *s = NULL;
  CHECK_OK(x->ctx, lth_shape_tessellate(x->ctx, &shell, 0.15, &s)); // two shells
  LthShape mesh = prepared(x->ctx, s);
  LthFractions *f = create(x->ctx, &mesh);
  CHECK_NEAR(f->volume, lth_surface_volume(s), 1e-12 * lth_surface_volume(s));
  lth_fractions_destroy(x->ctx, &f);
  lth_shape_free(x->ctx, &mesh);
  lth_surface_destroy(x->ctx, &s);
}

static void surfaces_look_the_same_along_all_axes(void **state) {
  Fixture *x = *state;
  LthSurface *s = NULL;
  CHECK_OK(x->ctx, lth_shape_tessellate(x->ctx, &shell, 0.2, &s));
  LthShape mesh = prepared(x->ctx, s);
  LthFractions *f = create(x->ctx, &mesh);
  lth_shape_free(x->ctx, &mesh);

  // x becomes y, y becomes z, z becomes x
  for (LitheIndex p = 0; p < s->n_points; p++) {
    double *q = s->points + 3 * p, z = q[2];
    q[2] = q[1], q[1] = q[0], q[0] = z;
  }
  mesh = prepared(x->ctx, s);
  LthFractions *g = create(x->ctx, &mesh);
  check_same(f, g, (int[3]){1, 2, 0}, no_shift, 1e-11);
  lth_fractions_destroy(x->ctx, &f);
  lth_fractions_destroy(x->ctx, &g);
  lth_shape_free(x->ctx, &mesh);
  lth_surface_destroy(x->ctx, &s);
}

static void shifted_surfaces_have_shifted_parts(void **state) {
  Fixture *x = *state;
  LthShape ball = {.kind = LTH_SHAPE_SPHERE, .a = {-0.1, 0.02, 0.05}, .radius = 0.5};
  LthSurface *s = NULL;
  CHECK_OK(x->ctx, lth_shape_tessellate(x->ctx, &ball, 0.2, &s));
  LthShape mesh = prepared(x->ctx, s);
  LthFractions *f = create(x->ctx, &mesh);
  lth_shape_free(x->ctx, &mesh);
  for (LitheIndex p = 0; p < s->n_points; p++) s->points[3 * p] += 0.3, s->points[3 * p + 2] -= 0.1;
  mesh = prepared(x->ctx, s);
  LthFractions *g = create(x->ctx, &mesh);
  check_same(f, g, same_axes, (int[3]){6, 0, -2}, 1e-11);
  lth_fractions_destroy(x->ctx, &f);
  lth_fractions_destroy(x->ctx, &g);
  lth_shape_free(x->ctx, &mesh);
  lth_surface_destroy(x->ctx, &s);
}

/// Boxes as surfaces have the parts of boxes: also with faces between parts, and thinner than a part.
static void boxes_of_triangles_are_boxes(void **state) {
  Fixture *x = *state;
  LthShape boxes[] = {
      {.kind = LTH_SHAPE_BOX, .a = {-0.5, -0.4, -0.3}, .b = {0.5, 0.7, 0.55}},
      {.kind = LTH_SHAPE_BOX, .a = {-0.513, -0.421, -0.3}, .b = {0.5, 0.7, 0.5701}},
      {.kind = LTH_SHAPE_BOX, .a = {-0.013, -0.8, -0.81}, .b = {-0.012, 0.8, 0.79}},
      {.kind = LTH_SHAPE_BOX, .a = {-0.713, -0.8, 0.111}, .b = {0.612, 0.81, 0.112}},
  };
  for (size_t k = 0; k < sizeof boxes / sizeof *boxes; k++) {
    LthSurface *s = NULL;
    CHECK_OK(x->ctx, lth_shape_tessellate(x->ctx, &boxes[k], 0, &s));
    LthShape mesh = prepared(x->ctx, s);
    LthFractions *f = create(x->ctx, &mesh), *g = create(x->ctx, &boxes[k]);
    double volume = 1;
    for (int a = 0; a < 3; a++) volume *= boxes[k].b[a] - boxes[k].a[a];
    CHECK_NEAR(g->volume, volume, 1e-12 * volume);
    check_same(f, g, same_axes, no_shift, 2e-12);
    lth_fractions_destroy(x->ctx, &f);
    lth_fractions_destroy(x->ctx, &g);
    lth_shape_free(x->ctx, &mesh);
    lth_surface_destroy(x->ctx, &s);
  }
}

static void faces_between_cells_leave_nothing_cut(void **state) {
  Fixture *x = *state;
  LthShape box = {.kind = LTH_SHAPE_BOX, .a = {-0.5, -0.4, -0.3}, .b = {0.5, 0.7, 0.6}};
  LthSurface *s = NULL;
  CHECK_OK(x->ctx, lth_shape_tessellate(x->ctx, &box, 0, &s));
  LthShape mesh = prepared(x->ctx, s);
  LthFractions *f = create(x->ctx, &mesh);
  LitheCount full = 0;
  for (LitheCount slot = 0; slot < f->grid->n_slots; slot++) {
    assert_true(f->cell[slot] < LTH_CELL_CUT);
    full += f->cell[slot] == LTH_CELL_FULL;
  }
  assert_int_equal(full, 10 * 11 * 9);
  lth_fractions_destroy(x->ctx, &f);
  lth_shape_free(x->ctx, &mesh);
  lth_surface_destroy(x->ctx, &s);
}

/// Shares of samples are within a few lattice steps of a surface of what is exact.
static void samples_of_surfaces_agree_with_plain_ones(void **state) {
  Fixture *x = *state;
  LthSurface *s = NULL;
  CHECK_OK(x->ctx, lth_shape_tessellate(x->ctx, &shell, 0.3, &s));
  LthShape mesh = prepared(x->ctx, s);
  LthFractionDef def = {.method = LTH_FRACTIONS_SAMPLES, .samples = 6};
  LthFractions *f = NULL;
  CHECK_OK(x->ctx, lth_fractions_create(x->ctx, &mesh, 3, origin, h, n, &def, &f));
  for (int c = 0; c < 40 * 40 * 40; c += 31) {
    int at[3] = {c % 40, c / 40 % 40, c / 1600}, count = 0;
    for (int q = 0; q < 27; q++) {
      int place[3] = {q % 3, q / 3 % 3, q / 9};
      double y[3];
      for (int a = 0; a < 3; a++) y[a] = origin[a] + h[a] * (3 * at[a] + place[a] + 0.5) / 6;
      count += lth_shape_value(&mesh, y) <= 0;
    }
    CHECK_NEAR(part_at(f, at), count / 27.0, 1e-12);
  }
  lth_fractions_destroy(x->ctx, &f);
  lth_shape_free(x->ctx, &mesh);
  lth_surface_destroy(x->ctx, &s);
}

/// --- primitives and combinations ---

static void primitives_have_their_volumes(void **state) {
  Fixture *x = *state;
  LthShape can = {
      .kind = LTH_SHAPE_CYLINDER, .a = {-0.5, 0.3, -0.4}, .b = {0.5, -0.2, 0.5}, .radius = 0.3};
  double length = lth_v3_distance(can.a, can.b), volume = M_PI * 0.09 * length;
  LthFractions *f = create(x->ctx, &can);
  CHECK_NEAR(f->volume, volume, 1e-10 * volume);
  lth_fractions_destroy(x->ctx, &f);
  can.kind = LTH_SHAPE_CAPSULE;
  volume += 4 * M_PI / 3 * 0.027;
  f = create(x->ctx, &can);
  CHECK_NEAR(f->volume, volume, 1e-10 * volume);
  lth_fractions_destroy(x->ctx, &f);
  f = create(x->ctx, &shell);
  volume = 4 * M_PI / 3 * (pow(0.8, 3) - pow(0.55, 3));
  CHECK_NEAR(f->volume, volume, 1e-10 * volume);
  lth_fractions_destroy(x->ctx, &f);
}

static void combinations_have_their_volumes(void **state) {
  Fixture *x = *state;
  LthShape two[2] = {{.kind = LTH_SHAPE_SPHERE, .a = {-0.25, 0.01, 0.02}, .radius = 0.5},
                     {.kind = LTH_SHAPE_SPHERE, .a = {0.25, 0.01, 0.02}, .radius = 0.5}};
  double ball = 4 * M_PI / 3 * 0.125,
         lens = M_PI / 12 * (4 * 0.5 + 0.5) * 0.25; // (4 r + d)(2 r - d)^2
  LthShape tree = {.kind = LTH_SHAPE_UNION, .children = two, .n_children = 2};
  double want[3] = {2 * ball - lens, lens, ball - lens};
  for (int k = 0; k < 3; k++) {
    tree.kind = (LthShapeKind)(LTH_SHAPE_UNION + k);
    LthFractions *f = create(x->ctx, &tree);
    // halved boxes along the circle where they meet: parts there are right to 1e-4
    CHECK_NEAR(f->volume, want[k], 1e-6);
    lth_fractions_destroy(x->ctx, &f);
  }
}

static void a_drilled_block_is_right_but_at_its_edges_to_rounding(void **state) {
  Fixture *x = *state;
  LthShape two[2] = {
      {.kind = LTH_SHAPE_BOX, .a = {-0.7, -0.6, -0.5}, .b = {0.7, 0.6, 0.5}},
      {.kind = LTH_SHAPE_CYLINDER, .a = {0.1, 0, -0.9}, .b = {0.1, 0, 0.9}, .radius = 0.4}};
  LthShape tree = {.kind = LTH_SHAPE_DIFFERENCE, .children = two, .n_children = 2};
  double volume = 1.4 * 1.2 * 1 - M_PI * 0.16;
  LthFractions *f = create(x->ctx, &tree);
  CHECK_NEAR(f->volume, volume, 1e-9); // faces of the block lie between parts: no part has both
  lth_fractions_destroy(x->ctx, &f);
}

static void a_surface_in_a_combination_keeps_its_parts(void **state) {
  Fixture *x = *state;
  LthShape box = {.kind = LTH_SHAPE_BOX, .a = {-0.71, -0.63, -0.52}, .b = {0.7, 0.6, 0.5}};
  LthSurface *s = NULL;
  CHECK_OK(x->ctx, lth_shape_tessellate(x->ctx, &box, 0, &s));
  LthShape two[2] = {prepared(x->ctx, s),
                     {.kind = LTH_SHAPE_SPHERE, .a = {0.1, 0.03, 0.02}, .radius = 0.4}};
  LthShape tree = {.kind = LTH_SHAPE_DIFFERENCE, .children = two, .n_children = 2};
  LthFractions *f = create(x->ctx, &tree);
  CHECK_NEAR(f->volume, 1.41 * 1.23 * 1.02 - 4 * M_PI / 3 * 0.064, 1e-10);
  lth_fractions_destroy(x->ctx, &f);
  lth_shape_free(x->ctx, &two[0]);
  lth_surface_destroy(x->ctx, &s);
}

static double torus(const void *self, const double x[3], double t) {
  (void)self, (void)t;
  double ring = hypot(x[0], x[1]) - 0.6;
  return 3 * (ring * ring + x[2] * x[2] - 0.04); // no distance
}

static void implicit_shapes_come_near(void **state) {
  Fixture *x = *state;
  LthShape shape = {.kind = LTH_SHAPE_IMPLICIT,
                    .value = {.eval = torus},
                    .box = {-0.9, -0.9, -0.3, 0.9, 0.9, 0.3}};
  double volume = 2 * M_PI * M_PI * 0.6 * 0.04;
  LthFractions *f = create(x->ctx, &shape);
  // planes instead of a surface with radius 0.2, in boxes of 1/4 of h: h^2 / 384 / r of a part at the surface
  CHECK_NEAR(f->volume, volume, 2e-3 * volume);
  lth_fractions_destroy(x->ctx, &f);
}

/// --- images and wrapped surfaces ---

static void voxels_that_are_cells_are_full_or_empty(void **state) {
  Fixture *x = *state;
  // voxel axes turned: voxel (i, j, k) is cell (j, k, 19 - i)
  double to_world[12] = {0, 0.1, 0, -0.95, 0, 0, 0.1, -0.95, -0.1, 0, 0, 0.95}, label = 7;
  LthVolume *v = NULL;
  LthImage *m = NULL;
  uint64_t seed = 3;
  CHECK_OK(x->ctx, lth_volume_create(x->ctx, n, to_world, &v));
  for (LitheCount p = 0; p < lth_volume_size(v); p++)
    v->values[p] = test_random(&seed) < 0.3 ? 7 : 2;
  CHECK_OK(x->ctx, lth_image_create(x->ctx, v, 0, &label, 1, 0, &m));
  LthShape shape = {.kind = LTH_SHAPE_IMAGE, .image = m};
  for (int method = 0; method < 2; method++) {
    LthFractionDef def = {.method = method ? LTH_FRACTIONS_SAMPLES : LTH_FRACTIONS_EXACT,
                          .samples = 2};
    LthFractions *f = NULL;
    CHECK_OK(x->ctx, lth_fractions_create(x->ctx, &shape, 3, origin, h, n, &def, &f));
    for (LitheIndex k = 0; k < 20; k++)
      for (LitheIndex j = 0; j < 20; j++)
        for (LitheIndex i = 0; i < 20; i++) {
          bool is_in = v->values[lth_volume_index(v, 19 - k, i, j)] == 7;
          for (int q = 0; q < 8; q++) {
            int at[3] = {2 * i + (q & 1), 2 * j + (q >> 1 & 1), 2 * k + (q >> 2)};
            assert_true(part_at(f, at) == (is_in ? 1 : 0));
          }
        }
    lth_fractions_destroy(x->ctx, &f);
  }
  lth_image_destroy(x->ctx, &m);
  lth_volume_destroy(x->ctx, &v);
}

static void voxels_beside_cells_keep_their_volume(void **state) {
  Fixture *x = *state;
  double to_world[12] = {0.13, 0, 0, -0.7, 0, 0.11, 0, -0.6, 0, 0, 0.17, -0.5};
  LitheIndex size[3] = {9, 8, 7};
  LthVolume *v = NULL;
  LthImage *m = NULL;
  uint64_t seed = 5;
  int count = 0;
  CHECK_OK(x->ctx, lth_volume_create(x->ctx, size, to_world, &v));
  for (LitheCount p = 0; p < lth_volume_size(v); p++) {
    v->values[p] = test_random(&seed) < 0.5;
    count += v->values[p] > 0;
  }
  CHECK_OK(x->ctx, lth_image_create(x->ctx, v, 0.5, NULL, 0, 0, &m));
  LthShape shape = {.kind = LTH_SHAPE_IMAGE, .image = m};
  LthFractions *f = create(x->ctx, &shape);
  CHECK_NEAR(f->volume, count * 0.13 * 0.11 * 0.17, 1e-12);
  lth_fractions_destroy(x->ctx, &f);
  lth_image_destroy(x->ctx, &m);
  lth_volume_destroy(x->ctx, &v);
}

static void boxes_that_cross_are_united(void **state) {
  Fixture *x = *state;
  SoupMaker *maker = calloc(1, sizeof *maker);
  LthWrap *wrap = NULL;
  LthShape two[2] = {{.kind = LTH_SHAPE_BOX, .a = {-0.62, -0.4, -0.3}, .b = {0.24, 0.53, 0.31}},
                     {.kind = LTH_SHAPE_BOX, .a = {-0.21, -0.71, -0.55}, .b = {0.61, 0.22, 0.12}}};
  for (int k = 0; k < 2; k++) soup_box(maker, two[k].a, two[k].b, false);
  CHECK_OK(x->ctx, lth_wrap_create(x->ctx, soup_finish(maker), "boxes", &wrap));
  LthShape shape = {.kind = LTH_SHAPE_WRAP, .wrap = wrap};
  LthShape tree = {.kind = LTH_SHAPE_UNION, .children = two, .n_children = 2};
  LthFractions *f = create(x->ctx, &shape), *g = create(x->ctx, &tree);
  double volume = 0.86 * 0.93 * 0.61 + 0.82 * 0.93 * 0.67 - 0.45 * 0.62 * 0.42;
  CHECK_NEAR(g->volume, volume, 2e-5);
  CHECK_NEAR(f->volume, volume, 2e-3 * volume); // planes and, at edges, 4 samples along a part
  check_same(f, g, same_axes, no_shift, 0.3);
  lth_fractions_destroy(x->ctx, &f);
  lth_fractions_destroy(x->ctx, &g);
  lth_wrap_destroy(x->ctx, &wrap);
  free(maker);
}

/// Samples of a part that are inside by a wrap's own tests, less those that the fractions have.
static int missed(const LthFractions *f, const LthWrap *wrap, const int at[3]) {
  int count = 0;
  for (int q = 0; q < 8; q++) {
    double y[3];
    for (int a = 0; a < 3; a++) y[a] = origin[a] + h[a] * (2 * at[a] + (q >> a & 1) + 0.5) / 4;
    count += lth_wrap_inside(wrap, y);
  }
  return abs(count - (int)lround(8 * part_at(f, at)));
}

static void samples_of_wrapped_surfaces_are_their_inside_tests(void **state) {
  Fixture *x = *state;
  LthShape ball = {.kind = LTH_SHAPE_SPHERE, .a = {0.1, 0.02, 0.05}, .radius = 0.6};
  LthSurface *s = NULL;
  LthFractionDef def = {.method = LTH_FRACTIONS_SAMPLES, .samples = 4};
  CHECK_OK(x->ctx, lth_shape_tessellate(x->ctx, &ball, 0.3, &s));
  for (int torn = 0; torn < 2; torn++) {
    SoupMaker *maker = calloc(1, sizeof *maker);
    LthWrap *wrap = NULL;
    LthFractions *f = NULL;
    int sum = 0;
    for (LitheIndex p = 0; p < s->n_points; p++)
      soup_point(maker, s->points[3 * p], s->points[3 * p + 1], s->points[3 * p + 2]);
    for (LitheIndex t = 0; t < s->n_tris; t++) // with `torn` a hole of a fifth
      if (!torn || t % 20 < 16)
        soup_triangle(maker, s->tris[3 * t], s->tris[3 * t + 1], s->tris[3 * t + 2]);
    if (!torn)
      soup_box(maker, (double[3]){-0.21, -0.71, -0.55}, (double[3]){0.61, 0.22, 0.12}, false);
    CHECK_OK(x->ctx, lth_wrap_create(x->ctx, soup_finish(maker), "ball", &wrap));
    LthShape shape = {.kind = LTH_SHAPE_WRAP, .wrap = wrap};
    CHECK_OK(x->ctx, lth_fractions_create(x->ctx, &shape, 3, origin, h, n, &def, &f));
    for (int c = 0; c < 40 * 40 * 40; c += 37)
      sum += missed(f, wrap, (int[3]){c % 40, c / 40 % 40, c / 1600});
    // next to holes one number at the middle of a part may be taken for whole
    CHECK_AT_MOST(sum, torn ? 3 : 0);
    lth_fractions_destroy(x->ctx, &f);
    lth_wrap_destroy(x->ctx, &wrap);
    free(maker);
  }
  lth_surface_destroy(x->ctx, &s);
}

/// --- all methods ---

static void any_number_of_threads_gives_the_same_bits(void **state) {
  Fixture *x = *state;
  LthSurface *s = NULL;
  CHECK_OK(x->ctx, lth_shape_tessellate(x->ctx, &shell, 0.3, &s));
  LthShape two[2] = {prepared(x->ctx, s),
                     {.kind = LTH_SHAPE_SPHERE, .a = {0.5, 0.03, 0.02}, .radius = 0.4}};
  LthShape tree = {.kind = LTH_SHAPE_UNION, .children = two, .n_children = 2};
  double coarse[3] = {0.2, 0.2, 0.2};
  LitheIndex few[3] = {10, 10, 10};
  for (int method = LTH_FRACTIONS_EXACT; method <= LTH_FRACTIONS_SMOOTH; method++) {
    LthFractionDef def = {.method = (LthFractionMethod)method, .samples = 4};
    LthFractions *f[3] = {NULL};
    for (int t = 0; t < 3; t++) {
      lth_set_threads(x->ctx, t == 2 ? 7 : t + 1);
      CHECK_OK(x->ctx, lth_fractions_create(x->ctx, &tree, 3, origin, coarse, few, &def, &f[t]));
      assert_int_equal(f[t]->grid->n_blocks, f[0]->grid->n_blocks);
      LitheCount n_values = f[0]->first[f[0]->grid->n_blocks] * f[0]->n_parts;
      assert_memory_equal(f[t]->cell, f[0]->cell, (size_t)f[0]->grid->n_slots * sizeof *f[0]->cell);
      assert_memory_equal(f[t]->part, f[0]->part, (size_t)n_values * sizeof *f[0]->part);
      assert_true(f[t]->volume == f[0]->volume);
    }
    for (int t = 0; t < 3; t++) lth_fractions_destroy(x->ctx, &f[t]);
  }
  lth_shape_free(x->ctx, &two[0]);
  lth_surface_destroy(x->ctx, &s);
}

static void the_forecast_is_enough(void **state) {
  Fixture *x = *state;
  LthShape thin = {.kind = LTH_SHAPE_SHELL, .radius = 0.9, .inner = 0.88};
  double area = 4 * M_PI * (0.81 + 0.88 * 0.88), volume = 4 * M_PI / 3 * (0.729 - pow(0.88, 3));
  for (int method = LTH_FRACTIONS_EXACT; method <= LTH_FRACTIONS_SAMPLES; method++) {
    LthFractionDef def = {.method = (LthFractionMethod)method, .samples = 4};
    LthFractions *f = NULL;
    LitheCount before = lth_alloc_bytes(x->ctx);
    CHECK_OK(x->ctx, lth_fractions_create(x->ctx, &thin, 3, origin, h, n, &def, &f));
    CHECK_AT_MOST((double)(lth_alloc_bytes(x->ctx) - before),
                  (double)lth_fractions_forecast(3, h, n, area, volume));
    lth_fractions_destroy(x->ctx, &f);
  }
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, setup, teardown)

int main(void) {
  const struct CMUnitTest tests[] = {
      TEST(parts_of_a_surface_sum_up_to_its_volume),
      TEST(surfaces_look_the_same_along_all_axes),
      TEST(shifted_surfaces_have_shifted_parts),
      TEST(boxes_of_triangles_are_boxes),
      TEST(faces_between_cells_leave_nothing_cut),
      TEST(samples_of_surfaces_agree_with_plain_ones),
      TEST(primitives_have_their_volumes),
      TEST(combinations_have_their_volumes),
      TEST(a_drilled_block_is_right_but_at_its_edges_to_rounding),
      TEST(a_surface_in_a_combination_keeps_its_parts),
      TEST(implicit_shapes_come_near),
      TEST(voxels_that_are_cells_are_full_or_empty),
      TEST(voxels_beside_cells_keep_their_volume),
      TEST(boxes_that_cross_are_united),
      TEST(samples_of_wrapped_surfaces_are_their_inside_tests),
      TEST(any_number_of_threads_gives_the_same_bits),
      TEST(the_forecast_is_enough),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
