/// Embedding: linear fields, partition of unity, support, cells of points, forces.
#include "check.h"

#include "base/tensor.h"
#include "embed/cell_search.h"
#include "embed/embedding.h"
#include "one_cell.h"

typedef struct Fixture {
  LitheCtx *ctx;
  LthMesh *mesh;
  LthDgSpace *space;
  double *points;
  LitheIndex n;
} Fixture;

static const LthGrid grid = {.min = {1, 2, 3}, .max = {2.2, 2.6, 3.9}, .cells = {4, 2, 3}};

/// Points inside the grid's box, on its sides, edges and corners, and a few outside.
static void make_points(Fixture *f) {
  uint64_t seed = 11;
  f->n = 400;
  f->points = calloc(3 * (size_t)f->n, sizeof(double));
  for (LitheIndex p = 0; p < f->n; p++)
    for (int a = 0; a < 3; a++) {
      double s = test_random(&seed);
      if (p % 4 == 1 && a == p / 4 % 3) s = p / 12 % 2;
      if (p % 4 == 2) s = floor(12 * s) / 12;
      if (p % 20 == 3) s = 1.3 * s - 0.15;
      f->points[3 * p + a] = grid.min[a] + s * (grid.max[a] - grid.min[a]);
    }
}

static int setup(void **state) {
  Fixture *f = calloc(1, sizeof *f);
  f->ctx = test_ctx();
  make_points(f);
  *state = f;
  return 0;
}

static int teardown(void **state) {
  Fixture *f = *state;
  lth_dg_space_destroy(f->ctx, &f->space);
  lth_mesh_destroy(f->ctx, &f->mesh);
  bool leaked = lth_alloc_bytes(f->ctx) != 0;
  lithe_ctx_destroy(&f->ctx);
  free(f->points);
  free(f);
  return leaked;
}

static void make_space(Fixture *f, bool tetrahedra, int degree) {
  lth_dg_space_destroy(f->ctx, &f->space);
  lth_mesh_destroy(f->ctx, &f->mesh);
  if (tetrahedra)
    CHECK_OK(f->ctx, lth_mesh_tetrahedra(f->ctx, &grid, &f->mesh));
  else
    CHECK_OK(f->ctx, lth_mesh_hexahedra(f->ctx, &grid, &f->mesh));
  CHECK_OK(f->ctx, lth_dg_space_create(f->ctx, f->mesh, degree, NULL, &f->space));
}

static const double F[9] = {0.3, -1.1, 0.2, 0.7, 0.1, -0.4, 1.5, 0.6, -0.9};
static const double shift[3] = {0.5, -0.25, 2};

/// Coefficients of u = F x + shift.
static double *affine_field(const Fixture *f) {
  double *x0 = calloc((size_t)f->space->n_dofs, sizeof *x0),
         *u = calloc((size_t)f->space->n_dofs, sizeof *u);
  lth_dg_rest(f->space, x0);
  for (LitheIndex i = 0; i < f->space->n_funcs; i++) lth_m3_apply(F, x0 + 3 * i, u + 3 * i);
  for (LitheIndex c = 0; c < f->space->n_cells; c++)
    for (int a = 0; a < 3; a++) u[3 * f->space->func_off[c] + a] += shift[a];
  free(x0);
  return u;
}

static void check_reproduces_affine_fields(Fixture *f, LthInterpolation how, LthSamples samples) {
  LthEmbedding *e = NULL;
  CHECK_OK(f->ctx, lth_embedding_create(f->ctx, f->space, f->n, f->points, NULL, how, samples, &e));
  double *u = affine_field(f), *x = calloc(3 * (size_t)f->n, sizeof *x);
  lth_embedding_apply(e, 2, u, x);
  for (LitheIndex p = 0; p < f->n; p++) {
    double want[3], one = 0;
    lth_m3_apply(F, f->points + 3 * p, want);
    for (int a = 0; a < 3; a++)
      CHECK_NEAR(x[3 * p + a], f->points[3 * p + a] + want[a] + shift[a], 1e-12);
    for (LitheCount i = e->off[p]; i < e->off[p + 1]; i++) one += e->weight[i];
    CHECK_NEAR(one, 1, 1e-13);
    assert_true(e->off[p + 1] > e->off[p]);
    for (LitheCount i = e->off[p] + 1; i < e->off[p + 1]; i++)
      assert_true(e->sample[i] > e->sample[i - 1]);
  }
  free(u);
  free(x);
  lth_embedding_destroy(f->ctx, &e);
}

static void mls_reproduces_affine_fields_at_all_points(void **state) {
  Fixture *f = *state;
  for (int tets = 0; tets < 2; tets++)
    for (int degree = 1; degree <= 2; degree++) {
      make_space(f, tets, degree);
      for (int s = LTH_SAMPLE_NODES; s <= LTH_SAMPLE_CELLS; s++)
        check_reproduces_affine_fields(f, LTH_EMBED_MLS, (LthSamples)s);
    }
}

static void stitching_reproduces_affine_fields_at_all_points(void **state) {
  Fixture *f = *state;
  for (int tets = 0; tets < 2; tets++) {
    make_space(f, tets, 1);
    check_reproduces_affine_fields(f, LTH_EMBED_STITCHED, LTH_SAMPLE_NODES);
  }
}

/// Random coefficients: jumps everywhere.
static double *random_field(const Fixture *f) {
  double *u = calloc((size_t)f->space->n_dofs, sizeof *u);
  uint64_t seed = 5;
  for (LitheCount i = 0; i < f->space->n_dofs; i++) u[i] = 2 * test_random(&seed) - 1;
  return u;
}

static void stitching_gives_the_plain_average_at_mesh_points(void **state) {
  Fixture *f = *state;
  make_space(f, false, 2);
  LthEmbedding *e = NULL;
  CHECK_OK(f->ctx, lth_embedding_create(f->ctx, f->space, f->mesh->n_points, f->mesh->points, NULL,
                                        LTH_EMBED_STITCHED, LTH_SAMPLE_NODES, &e));
  double *u = random_field(f);
  for (LitheIndex p = 0; p < f->mesh->n_points; p++) {
    double sum[3] = {0}, got[3];
    int n = 0;
    const double *x = f->mesh->points + 3 * p;
    for (LitheIndex c = 0; c < f->mesh->n_cells; c++) {
      double value[3];
      if (lth_box_distance2(f->mesh->cell_box + 6 * c, x) > 1e-20) continue;
      lth_dg_sample(f->space, c, u, x, value);
      lth_v3_add(sum, value, sum);
      n++;
    }
    lth_embedding_point(e, p, u, got);
    for (int a = 0; a < 3; a++) CHECK_NEAR(got[a], sum[a] / n, 1e-13);
  }
  free(u);
  lth_embedding_destroy(f->ctx, &e);
}

/// A jump in the field must not be seen in the surface: neighbouring points move alike.
static void mls_removes_the_jumps_of_the_field(void **state) {
  Fixture *f = *state;
  make_space(f, false, 1);
  double line[600], u_max = 0;
  for (int i = 0; i < 200; i++)
    line[3 * i] = 1 + 1.2 * i / 199.0, line[3 * i + 1] = 2.3 + 1e-9, line[3 * i + 2] = 3.31;
  LthEmbedding *e = NULL;
  CHECK_OK(f->ctx, lth_embedding_create(f->ctx, f->space, 200, line, NULL, LTH_EMBED_MLS,
                                        LTH_SAMPLE_NODES, &e));
  double *u = random_field(f), before[3], now[3];
  for (LitheCount i = 0; i < f->space->n_dofs; i++) u_max = fmax(u_max, fabs(u[i]));
  lth_embedding_point(e, 0, u, before);
  for (int i = 1; i < 200; i++) {
    lth_embedding_point(e, i, u, now);
    CHECK_AT_MOST(lth_v3_distance(now, before), 0.1 * u_max); // one two-hundredth of the body
    lth_v3_copy(now, before);
  }
  free(u);
  lth_embedding_destroy(f->ctx, &e);
}

static void forces_are_the_transpose_of_displacements(void **state) {
  Fixture *f = *state;
  make_space(f, true, 2);
  LthEmbedding *e = NULL;
  CHECK_OK(f->ctx, lth_embedding_create(f->ctx, f->space, f->n, f->points, NULL, LTH_EMBED_MLS,
                                        LTH_SAMPLE_NODES, &e));
  double *u = random_field(f), *force = calloc((size_t)f->space->n_dofs, sizeof *force);
  double *w = calloc((size_t)f->space->n_funcs, sizeof *w),
         *x = calloc(3 * (size_t)f->n, sizeof *x);
  double push[3] = {1, -2, 0.5};
  lth_embedding_apply(e, 1, u, x);
  for (LitheIndex p = 0; p < f->n; p += 37) {
    double at[3], work = 0, row[3] = {0}, total[3] = {0};
    memset(force, 0, sizeof *force * (size_t)f->space->n_dofs);
    lth_embedding_point(e, p, u, at);
    lth_embedding_add_force(e, p, push, force);
    lth_embedding_weights(e, p, w);
    for (LitheCount i = 0; i < f->space->n_dofs; i++) work += force[i] * u[i];
    for (LitheIndex i = 0; i < f->space->n_funcs; i++) lth_v3_axpy(w[i], u + 3 * i, row);
    for (LitheIndex c = 0; c < f->space->n_cells; c++)
      lth_v3_axpy(1, force + 3 * f->space->func_off[c], total);
    CHECK_NEAR(work, lth_v3_dot(push, at), 1e-12);
    for (int a = 0; a < 3; a++) {
      CHECK_NEAR(row[a], at[a], 1e-13);
      CHECK_NEAR(x[3 * p + a], f->points[3 * p + a] + at[a], 1e-13);
      CHECK_NEAR(total[a], push[a],
                 1e-13); // constants are the first functions: the sum of forces is kept
    }
  }
  free(u), free(force), free(w), free(x);
  lth_embedding_destroy(f->ctx, &e);
}

static void same_bits_for_any_number_of_threads(void **state) {
  Fixture *f = *state;
  make_space(f, false, 1);
  LthEmbedding *e[2] = {NULL, NULL};
  for (int k = 0; k < 2; k++) {
    lth_set_threads(f->ctx, 1 + 2 * k);
    CHECK_OK(f->ctx, lth_embedding_create(f->ctx, f->space, f->n, f->points, NULL, LTH_EMBED_MLS,
                                          LTH_SAMPLE_FACES, &e[k]));
  }
  assert_int_equal(e[0]->off[f->n], e[1]->off[f->n]);
  assert_memory_equal(e[0]->sample, e[1]->sample, sizeof(LitheIndex) * (size_t)e[0]->off[f->n]);
  assert_memory_equal(e[0]->weight, e[1]->weight, sizeof(double) * (size_t)e[0]->off[f->n]);
  lth_embedding_destroy(f->ctx, &e[0]);
  lth_embedding_destroy(f->ctx, &e[1]);
}

#define SPIKES 7
/// Is the place inside the polygon (even or odd crossings)? `*beside`: farther from all edges than a thousandth.
static bool is_in_polygon(int n, const double *polygon, const double p[2], bool *beside) {
  bool inside = false;
  for (int i = 0; i < n; i++) {
    const double *a = polygon + 2 * i, *b = polygon + 2 * ((i + 1) % n);
    double e[2] = {b[0] - a[0], b[1] - a[1]}, d[2] = {p[0] - a[0], p[1] - a[1]};
    double t = fmin(fmax((e[0] * d[0] + e[1] * d[1]) / (e[0] * e[0] + e[1] * e[1]), 0), 1);
    *beside = *beside && hypot(d[0] - t * e[0], d[1] - t * e[1]) > 1e-3;
    if ((a[1] > p[1]) != (b[1] > p[1]) && d[0] < d[1] * e[0] / e[1]) inside = !inside;
  }
  return inside;
}

/// A star with a hole, turned at random, from places in the planes of its ends: inside them it is all around, or half; outside
/// there is nothing of it, whatever rounding says of each triangle of a fan.
static void a_place_in_the_plane_of_a_face_is_not_in_the_cell(void **state) {
  Fixture *f = *state;
  double star[4 * SPIKES], hole[4 * SPIKES];
  uint64_t seed = 23;
  for (int i = 0; i < 2 * SPIKES; i++) {
    double r = i % 2 ? 0.5 : 1.5, angle = acos(-1) * i / SPIKES;
    star[2 * i] = r * cos(angle), star[2 * i + 1] = r * sin(angle);
    hole[2 * i] = 0.5 * star[2 * i], hole[2 * i + 1] = 0.5 * star[2 * i + 1];
  }
  for (int turn = 0, n_outside = 0; turn < 10 || n_outside < 1000; turn++) {
    TestSolid solid;
    double u[3], v[3], w[3];
    for (int a = 0; a < 3; a++) u[a] = test_random(&seed) - 0.5, v[a] = test_random(&seed) - 0.5;
    lth_v3_normalize(u);
    lth_v3_axpy(-lth_v3_dot(u, v), u, v);
    lth_v3_normalize(v);
    lth_v3_cross(u, v, w);
    test_prism(&solid, 2 * SPIKES, star, 2 * SPIKES, hole, -0.3, 0.4);
    for (int p = 0; p < solid.n_points; p++) {
      double x[3] = {0, 0, 0}, *at = solid.points + 3 * p;
      lth_v3_axpy(at[0], u, x), lth_v3_axpy(at[1], v, x), lth_v3_axpy(at[2], w, x);
      lth_v3_copy(x, at);
    }
    test_finish(&solid);
    LthMesh *mesh = test_one_cell(f->ctx, &solid);
    for (int i = 0; i < 300; i++) {
      double p[2] = {3 * test_random(&seed) - 1.5, 3 * test_random(&seed) - 1.5}, x[3] = {0, 0, 0};
      bool beside = true, inside = is_in_polygon(2 * SPIKES, star, p, &beside);
      inside = !is_in_polygon(2 * SPIKES, hole, p, &beside) && inside;
      if (!beside) continue;
      lth_v3_axpy(p[0], u, x), lth_v3_axpy(p[1], v, x), lth_v3_axpy(i % 2 ? 0.4 : -0.3, w, x);
      CHECK_NEAR(lth_cell_winding(mesh, 0, x), inside, 1e-9);
      n_outside += !inside;
    }
    lth_mesh_destroy(f->ctx, &mesh);
  }
}

static void finds_the_cell_of_a_point(void **state) {
  Fixture *f = *state;
  make_space(f, true, 1);
  LthCellSearch *search = NULL;
  CHECK_OK(f->ctx, lth_cell_search_create(f->ctx, f->mesh, &search));
  for (LitheIndex c = 0; c < f->mesh->n_cells; c++) {
    bool inside;
    assert_int_equal(lth_cell_search_find(search, f->mesh->cell_centroid + 3 * c, &inside), c);
    assert_true(inside);
    CHECK_NEAR(lth_cell_winding(f->mesh, c, f->mesh->cell_centroid + 3 * c), 1, 1e-14);
  }
  for (LitheIndex p = 0; p < f->n; p++) {
    LitheIndex plain;
    bool inside, inside_plain, in_box = true;
    const double *x = f->points + 3 * p;
    for (int a = 0; a < 3; a++) in_box = in_box && x[a] >= grid.min[a] && x[a] <= grid.max[a];
    LitheIndex cell = lth_cell_search_find(search, x, &inside);
    CHECK_OK(f->ctx, lth_find_cell(f->ctx, f->mesh, x, &plain, &inside_plain));
    assert_int_equal(inside, in_box);
    assert_int_equal(inside_plain, in_box);
    CHECK_NEAR(lth_cell_distance2(f->mesh, cell, x), lth_cell_distance2(f->mesh, plain, x),
               in_box ? 1 : 1e-15);
  }
  lth_cell_search_destroy(f->ctx, &search);
}

static void areas_sum_to_the_surface(void **state) {
  Fixture *f = *state;
  make_space(f, false, 1);
  double square[12] = {1, 2, 3, 2, 2, 3, 2, 2.5, 3, 1, 2.5, 3};
  LitheIndex off[2] = {0, 4}, polygon[4] = {0, 1, 2, 3};
  LthEmbedding *e = NULL;
  CHECK_OK(f->ctx, lth_embedding_create(f->ctx, f->space, 4, square, NULL, LTH_EMBED_MLS,
                                        LTH_SAMPLE_NODES, &e));
  CHECK_OK(f->ctx, lth_embedding_set_area(f->ctx, e, 1, off, polygon));
  for (int i = 0; i < 4; i++) CHECK_NEAR(e->area[i], 0.125, 1e-15);
  CHECK_NEAR(e->area[0] + e->area[1] + e->area[2] + e->area[3], 0.5, 1e-15);
  lth_embedding_destroy(f->ctx, &e);
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, setup, teardown)

int main(void) {
  const struct CMUnitTest tests[] = {
      TEST(mls_reproduces_affine_fields_at_all_points),
      TEST(stitching_reproduces_affine_fields_at_all_points),
      TEST(stitching_gives_the_plain_average_at_mesh_points),
      TEST(mls_removes_the_jumps_of_the_field),
      TEST(forces_are_the_transpose_of_displacements),
      TEST(same_bits_for_any_number_of_threads),
      TEST(finds_the_cell_of_a_point),
      TEST(a_place_in_the_plane_of_a_face_is_not_in_the_cell),
      TEST(areas_sum_to_the_surface),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
