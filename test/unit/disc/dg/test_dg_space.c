/// The DG space: orthogonality, rest positions, gradients, trace constants, projection.
#include "check.h"
#include "one_cell.h"
#include "polyhedra.h"

#include "disc/dg/dg_space.h"
#include "failing_memory.h"
#include "geometry/shape.h"

typedef struct Fixture {
  LitheCtx *ctx;
  LthMesh *mesh;
  LthDgSpace *space;
} Fixture;

static Fixture open_space(LitheCtx *ctx, LthMesh *mesh, int degree) {
  Fixture t = {ctx, mesh, NULL};
  CHECK_OK(ctx, lth_dg_space_create(ctx, mesh, degree, NULL, &t.space));
  return t;
}

static Fixture hexahedra(int n, int degree) {
  LitheCtx *ctx = test_ctx();
  LthMesh *mesh = NULL;
  LthGrid grid = {{-1, 0, 0.5}, {1, 1.5, 2}, {n, n, n}};
  CHECK_OK(ctx, lth_mesh_hexahedra(ctx, &grid, &mesh));
  return open_space(ctx, mesh, degree);
}

static Fixture tetrahedra(int degree) {
  LitheCtx *ctx = test_ctx();
  LthMesh *mesh = NULL;
  LthGrid grid = {{-1, 0, 0.5}, {1, 1.5, 2}, {2, 1, 1}};
  CHECK_OK(ctx, lth_mesh_tetrahedra(ctx, &grid, &mesh));
  return open_space(ctx, mesh, degree);
}

static Fixture single(const TestSolid *solid, int degree) {
  LitheCtx *ctx = test_ctx();
  return open_space(ctx, test_one_cell(ctx, solid), degree);
}

static void close_space(Fixture *t) {
  lth_dg_space_destroy(t->ctx, &t->space);
  lth_mesh_destroy(t->ctx, &t->mesh);
  assert_int_equal(lth_alloc_bytes(t->ctx), 0);
  lithe_ctx_destroy(&t->ctx);
}

static void box_solid(TestSolid *s, double x, double y, double z) {
  test_box(s, (double[3]){0, 0, 0}, (double[3]){x, y, z});
}

static void ring_solid(TestSolid *s) {
  static const double outer[8] = {-1, -0.75, 1, -0.75, 1, 1, -1, 1};
  static const double hole[8] = {-0.25, -0.5, 0.75, -0.5, 0.75, 0.5, -0.25, 0.5};
  test_prism(s, 4, outer, 4, hole, -0.5, 0.25);
}

static void ell_solid(TestSolid *s) {
  static const double ell[12] = {-1, -1, 1, -1, 1, 0, -0.5, 0, -0.5, 1, -1, 1};
  test_prism(s, 6, ell, 0, NULL, -0.5, 1);
}

static void turn(TestSolid *s) {
  double R[9], zero[3] = {0};
  test_axis_rotation((double[3]){1, 2, 3}, 0.6, R);
  test_transform(s, R, zero);
}

/// Largest |int phi_i phi_j / |K| - delta_ij| of a cell by quadrature of function values. `rounding`: of
/// the volume, by points that are not quite in their planes.
static double orthogonality(const Fixture *t, LitheIndex cell, double rounding) {
  int nb = lth_dg_funcs(t->space, cell);
  LitheIndex n;
  double *x, *w, gram[35 * 35] = {0}, phi[35], volume = 0, worst = 0;
  CHECK_OK(t->ctx,
           lth_dg_cell_quadrature(t->ctx, t->mesh, cell, 2 * t->space->degree[cell], &n, &x, &w));
  for (LitheIndex g = 0; g < n; g++) {
    lth_dg_eval(t->space, cell, x + 3 * g, phi);
    CHECK_NEAR(phi[0], 1, 0);
    volume += w[g];
    for (int i = 0; i < nb; i++)
      for (int j = 0; j < nb; j++) gram[i * nb + j] += w[g] * phi[i] * phi[j];
  }
  CHECK_NEAR(volume / t->mesh->cell_volume[cell], 1, rounding);
  for (int i = 0; i < nb; i++)
    for (int j = 0; j < nb; j++) worst = fmax(worst, fabs(gram[i * nb + j] / volume - (i == j)));
  lth_free(t->ctx, x);
  lth_free(t->ctx, w);
  return worst;
}

static void functions_are_orthogonal(void **state) {
  (void)state;
  for (int k = 1; k <= LTH_DG_MAX_DEGREE; k++) {
    Fixture t[4] = {hexahedra(2, k), tetrahedra(k)};
    TestSolid s;
    ring_solid(&s);
    turn(&s);
    t[2] = single(&s, k);
    ell_solid(&s);
    turn(&s);
    t[3] = single(&s, k);
    for (int m = 0; m < 4; m++) {
      for (LitheIndex c = 0; c < t[m].space->n_cells; c++)
        CHECK_AT_MOST(orthogonality(&t[m], c, 1e-13), 1e-12);
      close_space(&t[m]);
    }
  }
}

static void functions_of_slivers_are_orthogonal(void **state) {
  (void)state;
  // plates and needles that no axis-aligned scaling can repair. Positions in them are known to 1e-16 of the edge, so to
  // 1e-16 / thickness of the thickness; values of functions, which are of degree k across it, to k times that
  for (int k = 1; k <= LTH_DG_MAX_DEGREE; k++)
    for (double thickness = 1e-1; thickness > 5e-10; thickness *= 0.1)
      for (int is_needle = 0; is_needle < 2; is_needle++) {
        TestSolid s;
        box_solid(&s, 1, is_needle ? thickness : 1, is_needle ? 0.1 * thickness : thickness);
        turn(&s);
        Fixture t = single(&s, k);
        double rounding = 4e-15 / thickness * (is_needle ? 10 : 1);
        CHECK_AT_MOST(orthogonality(&t, 0, rounding), fmax(1e-12, k * rounding));
        close_space(&t);
      }
}

static void functions_of_sliced_cells_are_orthogonal(void **state) {
  (void)state;
  // a solid and a thin wall, whose cells are plates across the axes with many boundary faces
  const LthShape shapes[2] = {
      {.kind = LTH_SHAPE_CAPSULE, .a = {0, 0, 0}, .b = {1, 0.7, 0.4}, .radius = 1},
      {.kind = LTH_SHAPE_SHELL, .a = {0.1, 0.2, 0.3}, .radius = 1, .inner = 0.9}};
  for (int i = 0; i < 2; i++)
    for (int k = 1; k <= 2; k++) {
      LitheCtx *ctx = test_ctx();
      LthSurface *surface = NULL;
      LthMesh *mesh = NULL;
      LthGrid grid = {.cells = {3, 3, 3}};
      CHECK_OK(ctx, lth_shape_tessellate(ctx, &shapes[i], 0.25, &surface));
      lth_surface_bounds(surface, grid.min, grid.max);
      CHECK_OK(ctx, lth_mesh_slice(ctx, surface, &grid, 0.05, &mesh));
      Fixture t = open_space(ctx, mesh, k);
      for (LitheIndex c = 0; c < mesh->n_cells; c++)
        CHECK_AT_MOST(orthogonality(&t, c, 1e-13), 2e-12);
      lth_surface_destroy(ctx, &surface);
      close_space(&t);
    }
}

static void rest_coefficients_give_positions(void **state) {
  (void)state;
  for (int k = 1; k <= LTH_DG_MAX_DEGREE; k++) {
    Fixture t = tetrahedra(k);
    double *x0 = lth_alloc(t.ctx, t.space->n_dofs, sizeof *x0);
    lth_dg_rest(t.space, x0);
    uint64_t seed = 1;
    for (LitheIndex c = 0; c < t.space->n_cells; c++) {
      double x[3], got[3], G[9];
      for (int i = 0; i < 3; i++) x[i] = 4 * test_random(&seed) - 2;
      lth_dg_sample(t.space, c, x0, x, got);
      for (int i = 0; i < 3; i++) CHECK_NEAR(got[i], x[i], 1e-13);
      lth_dg_sample_gradient(t.space, c, x0, x, G);
      for (int i = 0; i < 9; i++) CHECK_NEAR(G[i], i % 4 == 0, 1e-12);
      lth_dg_mean_gradient(t.space, c, x0, G);
      for (int i = 0; i < 9; i++) CHECK_NEAR(G[i], i % 4 == 0, 1e-13);
    }
    lth_free(t.ctx, x0);
    close_space(&t);
  }
}

static void gradients_match_differences(void **state) {
  (void)state;
  Fixture t = tetrahedra(4);
  double h = 1e-5, x[3] = {0.1, 0.4, 0.9}, d[3 * 35], plus[35], minus[35];
  for (LitheIndex c = 0; c < 3; c++) {
    lth_dg_eval_gradient(t.space, c, x, d);
    for (int a = 0; a < 3; a++) {
      double y[3] = {x[0], x[1], x[2]};
      y[a] = x[a] + h;
      lth_dg_eval(t.space, c, y, plus);
      y[a] = x[a] - h;
      lth_dg_eval(t.space, c, y, minus);
      double size = 0;
      for (int i = 0; i < 35; i++) size = fmax(size, fabs(d[3 * i + a]));
      for (int i = 0; i < 35; i++)
        CHECK_NEAR((plus[i] - minus[i]) / (2 * h), d[3 * i + a], 1e-7 * size);
    }
  }
  close_space(&t);
}

static void mean_gradients_are_integrals(void **state) {
  (void)state;
  TestSolid s;
  ring_solid(&s);
  turn(&s);
  for (int k = 1; k <= 4; k++) {
    Fixture t = single(&s, k);
    LitheIndex n;
    double *x, *w, sum[105] = {0}, d[105];
    CHECK_OK(t.ctx, lth_dg_cell_quadrature(t.ctx, t.mesh, 0, k, &n, &x, &w));
    for (LitheIndex g = 0; g < n; g++) {
      lth_dg_eval_gradient(t.space, 0, x + 3 * g, d);
      for (int i = 0; i < 3 * t.space->n_funcs; i++) sum[i] += w[g] * d[i];
    }
    for (int i = 0; i < 3 * t.space->n_funcs; i++)
      CHECK_NEAR(sum[i] / t.mesh->cell_volume[0], t.space->mean_gradient[i], 1e-11);
    lth_free(t.ctx, x);
    lth_free(t.ctx, w);
    close_space(&t);
  }
}

static void trace_constants_match_closed_forms(void **state) {
  (void)state;
  // k = 1: surface over volume; k = 2 on a box: the linear function of the shortest edge L attains
  // |dK|/|K| + 4/L (its square is 3 times the mean on the two faces, 1 times on the others)
  TestSolid s;
  double edge[3] = {2, 0.5, 1}, ratio = 2 / edge[0] + 2 / edge[1] + 2 / edge[2];
  box_solid(&s, edge[0], edge[1], edge[2]);
  Fixture t = single(&s, 1);
  CHECK_NEAR(t.space->trace_constant[0], ratio, 1e-14 * ratio);
  close_space(&t);
  t = single(&s, 2);
  CHECK_NEAR(t.space->trace_constant[0], ratio + 4 / 0.5, 1e-13 * ratio);
  close_space(&t);
  box_solid(&s, 0.25, 0.25, 0.25);
  t = single(&s, 1);
  CHECK_NEAR(t.space->trace_constant[0], 6 / 0.25, 1e-14 * 24);
  close_space(&t);
}

static void trace_constants_match_known_ratios(void **state) {
  (void)state;
  // C_K |K| / |dK| for k = 1 to 4, from an independent computation
  static const double ratio[3][4] = {
      {1, 1.667, 3.12, 4.305}, {1, 1.667, 2.815, 3.93}, {1, 1.95, 3.74, 5.51}};
  TestSolid s[3];
  box_solid(&s[0], 1, 1, 1);
  test_tetrahedron(&s[1], (double[12]){1, 1, 1, -1, 1, -1, 1, -1, -1, -1, -1, 1});
  box_solid(&s[2], 1, 1, 10);
  for (int shape = 0; shape < 3; shape++)
    for (int k = 1; k <= 4; k++) {
      Fixture t = single(&s[shape], k);
      double area = 0;
      for (LitheIndex f = 0; f < t.mesh->n_faces; f++) area += t.mesh->face_area[f];
      CHECK_NEAR(t.space->trace_constant[0] * t.mesh->cell_volume[0] / area, ratio[shape][k - 1],
                 6e-3);
      close_space(&t);
    }
}

/// int_dK p^2 / int_K p^2 of random polynomials of degree k - 1 never exceeds C_K, and some come close.
static void trace_constants_bound_random_polynomials(void **state) {
  (void)state;
  TestSolid s;
  ring_solid(&s);
  turn(&s);
  uint64_t seed = 9;
  for (int k = 2; k <= 4; k++) {
    Fixture t = single(&s, k);
    int m = lth_monomials3(k - 1);
    double area_moments[35 * 5] = {0}, best = 0, unit[3] = {1, 1, 1}, zero[3] = {0},
                             volume_moments[165] = {0};
    for (int f = 0; f < s.n_faces; f++) {
      LthFaceView face = lth_mesh_face(t.mesh, f);
      lth_moments_add_face_area(2 * (k - 1), zero, unit, &face, area_moments);
      lth_moments_add_face(2 * (k - 1), zero, unit, &face, 1, volume_moments);
    }
    const int(*e)[3] = lth_monomial3_exponents();
    for (int repeat = 0; repeat < 2000; repeat++) {
      double c[20], on = 0, in = 0;
      for (int q = 0; q < m; q++) c[q] = test_random(&seed) - 0.5;
      for (int q = 0; q < m; q++)
        for (int r = 0; r < m; r++) {
          int at = lth_monomial3_index(e[q][0] + e[r][0], e[q][1] + e[r][1], e[q][2] + e[r][2]);
          on += c[q] * c[r] * area_moments[at];
          in += c[q] * c[r] * volume_moments[at];
        }
      best = fmax(best, on / in);
    }
    CHECK_AT_MOST(best, t.space->trace_constant[0]);
    CHECK_AT_LEAST(best, (k == 2 ? 0.9 : 0.4) * t.space->trace_constant[0]);
    close_space(&t);
  }
}

static void polynomial(const void *self, const double x[3], double value[3]) {
  int k = *(const int *)self;
  value[0] = pow(x[0], k) - x[1];
  value[1] = 1 + x[2] * pow(x[1], k - 1);
  value[2] = pow(0.3 * x[0] - x[1] + 0.5 * x[2], k);
}

static void projection_reproduces_polynomials(void **state) {
  (void)state;
  for (int k = 1; k <= 4; k++) {
    Fixture t[3] = {hexahedra(2, k), tetrahedra(k)};
    TestSolid s;
    ring_solid(&s);
    turn(&s);
    t[2] = single(&s, k);
    for (int m = 0; m < 3; m++) {
      double *coef = lth_alloc(t[m].ctx, t[m].space->n_dofs, sizeof *coef);
      CHECK_OK(t[m].ctx, lth_dg_project(t[m].ctx, t[m].space, polynomial, &k, 0, coef));
      uint64_t seed = 4;
      for (LitheIndex c = 0; c < t[m].space->n_cells; c++) {
        double x[3], got[3], want[3], r = test_random(&seed);
        LitheIndex f = t[m].mesh->cell_face[t[m].mesh->cell_face_off[c]];
        for (int i = 0; i < 3; i++)
          x[i] = r * t[m].mesh->cell_centroid[3 * c + i] +
                 (1 - r) * t[m].mesh->face_centroid[3 * f + i];
        lth_dg_sample(t[m].space, c, coef, x, got);
        polynomial(&k, x, want);
        for (int i = 0; i < 3; i++) CHECK_NEAR(got[i], want[i], 1e-12);
      }
      lth_free(t[m].ctx, coef);
      close_space(&t[m]);
    }
  }
}

static void does_not_depend_on_the_place(void **state) {
  (void)state;
  // grids with exact coordinates, one a million sizes away. Centroids may round, by 1e-10 there: the basis
  // moves by that over the cell's size and no more
  LitheCtx *ctx = test_ctx();
  LthGrid near_grid = {{0, 0, 0}, {2, 2, 2}, {2, 2, 2}};
  LthGrid far_grid = {{1e6, 1e6, -2e6}, {1e6 + 2, 1e6 + 2, -2e6 + 2}, {2, 2, 2}};
  LthMesh *near_mesh = NULL, *far_mesh = NULL;
  CHECK_OK(ctx, lth_mesh_tetrahedra(ctx, &near_grid, &near_mesh));
  CHECK_OK(ctx, lth_mesh_tetrahedra(ctx, &far_grid, &far_mesh));
  LthDgSpace *a = NULL, *b = NULL;
  CHECK_OK(ctx, lth_dg_space_create(ctx, near_mesh, 2, NULL, &a));
  CHECK_OK(ctx, lth_dg_space_create(ctx, far_mesh, 2, NULL, &b));
  for (LitheIndex c = 0; c < a->n_cells; c++)
    for (int i = 0; i < lth_dg_funcs(a, c) * lth_dg_funcs(a, c); i++)
      CHECK_NEAR(b->basis[c][i], a->basis[c][i], 1e-7);
  for (LitheIndex c = 0; c < a->n_cells; c++) {
    CHECK_NEAR(b->trace_constant[c] / a->trace_constant[c], 1, 1e-8);
    Fixture t = {ctx, far_mesh, b};
    CHECK_AT_MOST(orthogonality(&t, c, 1e-8), 1e-8);
  }
  lth_dg_space_destroy(ctx, &a);
  lth_dg_space_destroy(ctx, &b);
  lth_mesh_destroy(ctx, &near_mesh);
  lth_mesh_destroy(ctx, &far_mesh);
  lithe_ctx_destroy(&ctx);
}

static void degrees_may_differ_between_cells(void **state) {
  (void)state;
  Fixture t = hexahedra(2, 1);
  uint8_t degree[8] = {1, 2, 3, 4, 4, 3, 2, 1};
  lth_dg_space_destroy(t.ctx, &t.space);
  CHECK_OK(t.ctx, lth_dg_space_create(t.ctx, t.mesh, 1, degree, &t.space));
  assert_int_equal(t.space->n_funcs, 2 * (4 + 10 + 20 + 35));
  assert_int_equal(t.space->max_degree, 4);
  for (LitheIndex c = 0; c < 8; c++) {
    assert_int_equal(lth_dg_funcs(t.space, c), lth_monomials3(degree[c]));
    CHECK_AT_MOST(orthogonality(&t, c, 1e-13), 1e-12);
  }
  close_space(&t);
}

static void is_the_same_for_any_number_of_threads(void **state) {
  (void)state;
  Fixture t = tetrahedra(3);
  LthDgSpace *one = NULL;
  lth_set_threads(t.ctx, 1);
  CHECK_OK(t.ctx, lth_dg_space_create(t.ctx, t.mesh, 3, NULL, &one));
  for (LitheIndex c = 0; c < one->n_cells; c++)
    assert_memory_equal(one->basis[c], t.space->basis[c],
                        sizeof(double) * (size_t)(lth_dg_funcs(one, c) * lth_dg_funcs(one, c)));
  assert_memory_equal(one->trace_constant, t.space->trace_constant,
                      sizeof(double) * (size_t)one->n_cells);
  lth_dg_space_destroy(t.ctx, &one);
  close_space(&t);
}

static void refuses_wrong_degrees(void **state) {
  (void)state;
  Fixture t = hexahedra(1, 1);
  LthDgSpace *none = NULL;
  assert_int_equal(lth_dg_space_create(t.ctx, t.mesh, 0, NULL, &none), LITHE_BAD_INPUT);
  assert_int_equal(lth_dg_space_create(t.ctx, t.mesh, 5, NULL, &none), LITHE_BAD_INPUT);
  assert_null(none);
  close_space(&t);
}

/// Memory fails from the n-th allocation on.
static int allocations_left;

static void survives_failing_allocations(void **state) {
  (void)state;
  LitheCtxDef def = lithe_ctx_def_default();
  def.allocate = test_failing_allocate;
  def.memory_user = &allocations_left;
  def.threads = 1;
  TestSolid s;
  box_solid(&s, 1, 2, 3);
  for (int n = 0, done = 0; !done; n++) {
    allocations_left = INT32_MAX;
    Fixture t = {.ctx = lithe_ctx_create(&def)};
    t.mesh = test_one_cell(t.ctx, &s);
    int k = 2;
    double coef[30];
    allocations_left = n;
    LitheStatus status = lth_dg_space_create(t.ctx, t.mesh, k, NULL, &t.space);
    if (!status) status = lth_dg_project(t.ctx, t.space, polynomial, &k, 0, coef);
    done = status == LITHE_OK;
    assert_true(done || status == LITHE_NO_MEMORY);
    close_space(&t);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(functions_are_orthogonal),
      cmocka_unit_test(functions_of_slivers_are_orthogonal),
      cmocka_unit_test(functions_of_sliced_cells_are_orthogonal),
      cmocka_unit_test(rest_coefficients_give_positions),
      cmocka_unit_test(gradients_match_differences),
      cmocka_unit_test(mean_gradients_are_integrals),
      cmocka_unit_test(trace_constants_match_closed_forms),
      cmocka_unit_test(trace_constants_match_known_ratios),
      cmocka_unit_test(trace_constants_bound_random_polynomials),
      cmocka_unit_test(projection_reproduces_polynomials),
      cmocka_unit_test(does_not_depend_on_the_place),
      cmocka_unit_test(degrees_may_differ_between_cells),
      cmocka_unit_test(is_the_same_for_any_number_of_threads),
      cmocka_unit_test(refuses_wrong_degrees),
      cmocka_unit_test(survives_failing_allocations),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
