/// Fractions of wrapped surfaces: exact where the surface is closed, flat caps in flat holes, what is wound twice counts once.
#include "fraction_grid.h"
#include "soup_maker.h"

#include "base/tensor.h"
#include "geometry/fractions.h"
#include "geometry/shape.h"

typedef struct Fixture {
  LitheCtx *ctx;
  SoupMaker *maker;
  LthWrap *wrap;
  LthShape shape;
} Fixture;

static int setup(void **state) {
  Fixture *f = calloc(1, sizeof *f);
  f->ctx = test_ctx();
  f->maker = calloc(1, sizeof *f->maker);
  *state = f;
  return 0;
}

static int teardown(void **state) {
  Fixture *f = *state;
  lth_wrap_destroy(f->ctx, &f->wrap);
  bool leaked = lth_alloc_bytes(f->ctx) != 0;
  lithe_ctx_destroy(&f->ctx);
  free(f->maker);
  free(f);
  return leaked;
}

static const LthShape *finish(Fixture *x) {
  CHECK_OK(x->ctx, lth_wrap_create(x->ctx, soup_finish(x->maker), "soup", &x->wrap));
  x->shape = (LthShape){.kind = LTH_SHAPE_WRAP, .wrap = x->wrap};
  return &x->shape;
}

/// The triangles of a shape but for those about a direction within an angle (cosine); every `turned`-th the wrong way.
static void add(Fixture *x, const LthSurface *s, const double away[3], double cosine, int turned) {
  for (LitheIndex p = 0; p < s->n_points; p++)
    soup_point(x->maker, s->points[3 * p], s->points[3 * p + 1], s->points[3 * p + 2]);
  for (LitheIndex t = 0; t < s->n_tris; t++) {
    const LitheIndex *p = s->tris + 3 * t;
    if (lth_v3_dot(s->points + 3 * p[0], away) > cosine * lth_v3_norm(s->points + 3 * p[0]))
      continue;
    bool is_turned = turned > 0 && t % turned == 0;
    soup_triangle(x->maker, p[0], p[is_turned ? 2 : 1], p[is_turned ? 1 : 2]);
  }
}

static LthFractions *create(LitheCtx *ctx, const LthShape *shape, LthFractionMethod method) {
  LthFractionDef def = {.method = method, .samples = 4};
  LthFractions *f = NULL;
  CHECK_OK(ctx, lth_fractions_create(ctx, shape, 3, origin, h, n, &def, &f));
  return f;
}

/// Largest difference of parts, and the number of parts with any.
static double largest_difference(const LthFractions *f, const LthFractions *g, int *count) {
  double largest = 0;
  *count = 0;
  for (int c = 0; c < 40 * 40 * 40; c++) {
    const int at[3] = {c % 40, c / 40 % 40, c / 1600};
    double d = fabs(part_at(f, at) - part_at(g, at));
    *count += d > 1e-9;
    largest = fmax(largest, d);
  }
  return largest;
}

static const double nowhere[3] = {0, 0, 0};

static void closed_surfaces_are_as_exact_as_strict_ones(void **state) {
  Fixture *x = *state;
  LthSurface *s = NULL;
  int count;
  CHECK_OK(x->ctx, lth_shape_tessellate(x->ctx, &shell, 0.3, &s));
  add(x, s, nowhere, 1, 3); // a third of the triangles is turned over; there is a cavity
  LthShape mesh = {.kind = LTH_SHAPE_MESH, .surface = s};
  CHECK_OK(x->ctx, lth_shape_prepare(x->ctx, &mesh));
  const LthShape *wrapped = finish(x);
  for (int method = LTH_FRACTIONS_EXACT; method <= LTH_FRACTIONS_SMOOTH; method++) {
    LthFractions *f = create(x->ctx, &mesh, (LthFractionMethod)method),
                 *g = create(x->ctx, wrapped, (LthFractionMethod)method);
    CHECK_AT_MOST(largest_difference(f, g, &count), 1e-10);
    lth_fractions_destroy(x->ctx, &f);
    lth_fractions_destroy(x->ctx, &g);
  }
  lth_shape_free(x->ctx, &mesh);
  lth_surface_destroy(x->ctx, &s);
}

static void holes_change_parts_near_them_alone(void **state) {
  Fixture *x = *state;
  LthShape ball = {.kind = LTH_SHAPE_SPHERE, .a = {0.03, -0.02, 0.01}, .radius = 0.8};
  LthSurface *s = NULL;
  CHECK_OK(x->ctx, lth_shape_tessellate(x->ctx, &ball, 0.15, &s));
  add(x, s, (double[3]){0.48, 0.6, 0.64}, 0.96, 0); // a hole of 16 degrees around it
  LthShape mesh = {.kind = LTH_SHAPE_MESH, .surface = s};
  CHECK_OK(x->ctx, lth_shape_prepare(x->ctx, &mesh));
  LthFractions *f = create(x->ctx, &mesh, LTH_FRACTIONS_EXACT),
               *g = create(x->ctx, finish(x), LTH_FRACTIONS_EXACT);
  for (int c = 0; c < 40 * 40 * 40; c++) {
    const int at[3] = {c % 40, c / 40 % 40, c / 1600};
    double place[3];
    for (int a = 0; a < 3; a++) place[a] = -1 + 0.05 * (at[a] + 0.5);
    bool is_near = 0.48 * place[0] + 0.6 * place[1] + 0.64 * place[2] > 0.85 * lth_v3_norm(place);
    if (!is_near) CHECK_NEAR(part_at(g, at), part_at(f, at), 1e-9);
  }
  // the cap that is missing: pi h^2 (r - h / 3), h = r (1 - cos), about flat over the hole (jagged by triangles of 0.15)
  double high = 0.8 * 0.04, cap = M_PI * high * high * (0.8 - high / 3);
  CHECK_NEAR(f->volume - g->volume, cap, 0.6 * cap);
  lth_fractions_destroy(x->ctx, &f);
  lth_fractions_destroy(x->ctx, &g);
  lth_shape_free(x->ctx, &mesh);
  lth_surface_destroy(x->ctx, &s);
}

/// The number of a box without a lid is one half all over its opening, which is where the file's box ends.
static void a_box_without_a_lid_is_full_up_to_it(void **state) {
  Fixture *x = *state;
  double low[3] = {-0.62, -0.41, -0.33}, high[3] = {0.24, 0.53, 0.57};
  LitheIndex first = soup_box(x->maker, low, high, false);
  (void)first;
  x->maker->soup.n_polys--; // the last quad is the side at high x
  LthFractions *f = create(x->ctx, finish(x), LTH_FRACTIONS_EXACT);
  double volume = 0.86 * 0.94 * 0.9;
  // parts around the rim take 4 places along them: half a part's eighth along a rim of 3.68
  CHECK_NEAR(f->volume, volume, 3.68 * 0.05 * 0.05 / 4 + 0.94 * 0.9 * 0.05 * 0.02);
  lth_fractions_destroy(x->ctx, &f);
}

static void what_is_wound_twice_counts_once(void **state) {
  Fixture *x = *state;
  double low[2][3] = {{-0.62, -0.4, -0.3}, {-0.21, -0.71, -0.55}},
         high[2][3] = {{0.24, 0.53, 0.31}, {0.61, 0.22, 0.12}};
  LthShape two[2];
  int count;
  for (int k = 0; k < 2; k++) {
    soup_box(x->maker, low[k], high[k], false);
    two[k] = (LthShape){.kind = LTH_SHAPE_BOX};
    lth_v3_copy(low[k], two[k].a);
    lth_v3_copy(high[k], two[k].b);
  }
  LthShape tree = {.kind = LTH_SHAPE_UNION, .children = two, .n_children = 2};
  LthFractions *f = create(x->ctx, &tree, LTH_FRACTIONS_EXACT),
               *g = create(x->ctx, finish(x), LTH_FRACTIONS_EXACT);
  CHECK_AT_MOST(largest_difference(f, g, &count), 0.3);
  // only parts that the crossing triangles meet, two to a face, may be less than exact
  CHECK_NEAR(g->volume, f->volume, 2e-4 * f->volume);
  lth_fractions_destroy(x->ctx, &f);
  lth_fractions_destroy(x->ctx, &g);
}

static void a_wrapped_surface_in_a_combination_keeps_its_parts(void **state) {
  Fixture *x = *state;
  LthSurface *s = NULL;
  int count;
  CHECK_OK(x->ctx, lth_shape_tessellate(x->ctx, &shell, 0.3, &s));
  add(x, s, nowhere, 1, 0);
  LthShape two[2] = {*finish(x), {.kind = LTH_SHAPE_SPHERE, .a = {5, 5, 5}, .radius = 0.1}};
  LthShape tree = {.kind = LTH_SHAPE_DIFFERENCE, .children = two, .n_children = 2};
  LthFractions *f = create(x->ctx, &two[0], LTH_FRACTIONS_EXACT),
               *g = create(x->ctx, &tree, LTH_FRACTIONS_EXACT);
  CHECK_AT_MOST(largest_difference(f, g, &count), 1e-11);
  lth_fractions_destroy(x->ctx, &f);
  lth_fractions_destroy(x->ctx, &g);
  lth_surface_destroy(x->ctx, &s);
}

static void any_number_of_threads_gives_the_same_bits(void **state) {
  Fixture *x = *state;
  LthSurface *s = NULL;
  CHECK_OK(x->ctx, lth_shape_tessellate(x->ctx, &shell, 0.3, &s));
  add(x, s, (double[3]){1, 0, 0}, 0.9, 0);
  const LthShape *wrapped = finish(x);
  for (int method = LTH_FRACTIONS_EXACT; method <= LTH_FRACTIONS_SMOOTH; method++) {
    LthFractions *f[3] = {NULL};
    for (int t = 0; t < 3; t++) {
      lth_set_threads(x->ctx, t == 2 ? 7 : t + 1);
      f[t] = create(x->ctx, wrapped, (LthFractionMethod)method);
      LitheCount n_values = f[0]->first[f[0]->grid->n_blocks] * f[0]->n_parts;
      assert_int_equal(f[t]->grid->n_blocks, f[0]->grid->n_blocks);
      assert_memory_equal(f[t]->cell, f[0]->cell, (size_t)f[0]->grid->n_slots * sizeof *f[0]->cell);
      assert_memory_equal(f[t]->part, f[0]->part, (size_t)n_values * sizeof *f[0]->part);
    }
    for (int t = 0; t < 3; t++) lth_fractions_destroy(x->ctx, &f[t]);
  }
  lth_surface_destroy(x->ctx, &s);
}

/// The slope of the number in the middle of a ring: that of a current loop, 1 / (2 R).
static void rims_bound_the_slope_of_the_number(void **state) {
  Fixture *x = *state;
  LitheIndex middle = soup_point(x->maker, 0, 0, 0.5), ring[64];
  double middle_of_it[3] = {0, 0, 0};
  for (int i = 0; i < 64; i++)
    ring[i] = soup_point(x->maker, 0.7 * cos(2 * M_PI * i / 64), 0.7 * sin(2 * M_PI * i / 64), 0);
  for (int i = 0; i < 64; i++) soup_triangle(x->maker, ring[i], ring[(i + 1) % 64], middle);
  finish(x);
  assert_int_equal(x->wrap->rim->n, 64);
  double slope = lth_rim_slope(x->wrap->rim, middle_of_it, 0.01);
  assert_true(slope >= 1 / (2 * 0.7));
  CHECK_AT_MOST(slope, 2 / (2 * 0.7)); // far edges go together
  assert_true(isinf(lth_rim_slope(x->wrap->rim, (double[3]){0.69, 0, 0}, 0.02)));
  for (int i = 0; i < 20; i++) { // differences against the bound along a line out of the hole
    double a[3] = {0.1, 0.05, -0.05 * i - 0.05}, b[3] = {0.1, 0.05, -0.05 * i - 0.051};
    double change =
        fabs(lth_winding_direct(x->wrap->winding, a) - lth_winding_direct(x->wrap->winding, b));
    CHECK_AT_MOST(change, 0.001 * lth_rim_slope(x->wrap->rim, a, 0.001));
  }
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, setup, teardown)

int main(void) {
  const struct CMUnitTest tests[] = {
      TEST(closed_surfaces_are_as_exact_as_strict_ones),
      TEST(holes_change_parts_near_them_alone),
      TEST(a_box_without_a_lid_is_full_up_to_it),
      TEST(what_is_wound_twice_counts_once),
      TEST(a_wrapped_surface_in_a_combination_keeps_its_parts),
      TEST(any_number_of_threads_gives_the_same_bits),
      TEST(rims_bound_the_slope_of_the_number),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
