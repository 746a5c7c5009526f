/// Manufactured solutions: interior penalty converges with order k + 1 in L2, on sliced meshes too.
#include "dg_body.h"
#include "solids.h"

/// u = (sin 2x cos y, cos(x + z) - 2 cos 2x sin y, sin(x - y)) / 10 keeps volumes, so that it is one
/// problem for every Poisson's ratio; E = 1000.
typedef struct Case {
  double lambda, mu;
} Case;

typedef struct Component {
  const Case *problem;
  int row, column;
} Component;

static void solution(const double x[3], double u[3]) {
  u[0] = 0.1 * sin(2 * x[0]) * cos(x[1]);
  u[1] = 0.1 * (cos(x[0] + x[2]) - 2 * cos(2 * x[0]) * sin(x[1]));
  u[2] = 0.1 * sin(x[0] - x[1]);
}

static void solution_gradient(const double x[3], double H[9]) {
  double s = sin(2 * x[0]) * sin(x[1]), c = cos(2 * x[0]) * cos(x[1]), d = cos(x[0] - x[1]);
  H[0] = 0.2 * c, H[1] = -0.1 * s, H[2] = 0;
  H[3] = -0.1 * sin(x[0] + x[2]) + 0.4 * s, H[4] = -0.2 * c, H[5] = -0.1 * sin(x[0] + x[2]);
  H[6] = 0.1 * d, H[7] = -0.1 * d, H[8] = 0;
}

static double displacement(const void *self, const double x[3], double t) {
  (void)t;
  double u[3];
  solution(x, u);
  return u[((const Component *)self)->row];
}

static double stress(const void *self, const double x[3], double t) {
  (void)t;
  const Component *c = self;
  double H[9];
  solution_gradient(x, H);
  double trace = c->row == c->column ? c->problem->lambda * (H[0] + H[4] + H[8]) : 0;
  return trace + c->problem->mu * (H[3 * c->row + c->column] + H[3 * c->column + c->row]);
}

/// -mu laplace u, as div u = 0
static double body_force(const void *self, const double x[3], double t) {
  (void)t;
  const Component *c = self;
  double wave = 0.1 * cos(x[0] + x[2]), u[3];
  solution(x, u);
  double laplace[3] = {-5 * u[0], -2 * wave - 5 * (u[1] - wave), -2 * u[2]};
  return -c->problem->mu * laplace[c->row];
}

static bool lower(const double c[3], const double n[3]) {
  (void)n;
  return c[0] < 0.05;
}
static bool upper(const double c[3], const double n[3]) { return !lower(c, n); }

/// sqrt(int |u_h - u|^2)
static double error_l2(const TestBody *b) {
  double sum = 0;
  for (LitheIndex c = 0; c < b->space->n_cells; c++) {
    LitheIndex n = 0;
    double *points = NULL, *weights = NULL;
    CHECK_OK(b->ctx, lth_dg_cell_quadrature(b->ctx, b->mesh, c, 6, &n, &points, &weights));
    for (LitheIndex q = 0; q < n; q++) {
      double got[3], u[3];
      lth_dg_sample(b->space, c, b->x, points + 3 * q, got);
      solution(points + 3 * q, u);
      for (int a = 0; a < 3; a++) {
        double d = got[a] - points[3 * q + a] - u[a];
        sum += weights[q] * d * d;
      }
    }
    lth_free(b->ctx, points);
    lth_free(b->ctx, weights);
  }
  return sqrt(sum);
}

/// Held on one half of the boundary, pulled on the other; frees the body.
static double solve_and_measure(TestBody b, double poisson) {
  Case problem;
  Component component[9];
  lth_lame(1000, poisson, &problem.lambda, &problem.mu);
  for (int i = 0; i < 9; i++) component[i] = (Component){&problem, i / 3, i % 3};
  for (LitheIndex c = 0; c < b.space->n_cells; c++) b.poisson[c] = poisson;
  LthWeakConstraint *hold = test_hold(&b, lower);
  for (int a = 0; a < 3; a++) hold->value[a] = (LthValue){0, displacement, &component[3 * a]};
  test_assemble(&b, 0);
  b.patches[3] = test_patches(b.ctx, b.mesh, upper);
  LthLoad pull = {.kind = LTH_LOAD_STRESS, .patches = b.patches[3]},
          volume = {.kind = LTH_LOAD_BODY_FORCE};
  for (int i = 0; i < 9; i++) pull.stress[i] = (LthValue){0, stress, &component[i]};
  for (int a = 0; a < 3; a++) volume.value[a] = (LthValue){0, body_force, &component[3 * a]};
  CHECK_OK(b.ctx, lth_dg_add_load(b.ctx, b.space, &pull, 0, NULL, b.f));
  CHECK_OK(b.ctx, lth_dg_add_load(b.ctx, b.space, &volume, 0, NULL, b.f));
  test_solve_sparse(&b, b.K, b.f0);
  double error = error_l2(&b);
  test_body_free(&b);
  return error;
}

/// A cube turned off the grid's axes, cut into n cells a side.
static TestBody sliced_cube(LitheIndex n, int degree) {
  LitheCtx *ctx = test_ctx();
  LthSurface *s = solid_box(ctx, (double[3]){-0.4, -0.4, -0.4}, (double[3]){0.4, 0.4, 0.4});
  double R[9];
  test_rotation(0.5, R);
  solid_move(s, R, 1, (double[3]){0, 0, 0});
  LthGrid cells = {.cells = {n, n, n}};
  solid_bounds(s, cells.min, cells.max);
  LthMesh *mesh = NULL;
  CHECK_OK(ctx, lth_mesh_slice(ctx, s, &cells, 0.05, &mesh));
  solid_free(ctx, &s);
  return test_body_of(ctx, mesh, degree);
}

static TestBody tetrahedra(LitheIndex n, int degree) {
  return test_body(TEST_TETRAHEDRA, (LthGrid){{-0.4, -0.4, -0.4}, {0.4, 0.4, 0.4}, {n, n, n}},
                   degree);
}

/// Errors with n and ratio n cells a side; the order between them is at least k + 1 - slack.
static void check_order(TestBody (*make)(LitheIndex, int), LitheIndex n, LitheIndex ratio,
                        int degree, double poisson, double slack) {
  double coarse = solve_and_measure(make(n, degree), poisson);
  double fine = solve_and_measure(make(ratio * n, degree), poisson);
  double order = log(coarse / fine) / log(ratio);
  print_message("degree %d, nu %g, %d and %d cells: error %.3g, %.3g, order %.2f\n", degree,
                poisson, n, ratio * n, coarse, fine, order);
  CHECK_AT_LEAST(order, degree + 1 - slack);
}

static void tetrahedra_converge(void **state) {
  (void)state;
  check_order(tetrahedra, 3, 2, 1, 0.3, 0.15);
  check_order(tetrahedra, 2, 2, 2, 0.3, 0.15);
}

static void sliced_meshes_converge(void **state) {
  (void)state;
  check_order(sliced_cube, 6, 2, 1, 0.3, 0.25);
  check_order(sliced_cube, 5, 2, 2, 0.3, 0.25);
}

static void nearly_incompressible_sliced_meshes_converge(void **state) {
  (void)state;
  check_order(sliced_cube, 6, 2, 1, 0.499, 0.25);
  check_order(sliced_cube, 5, 2, 2, 0.499, 0.15);
}

/// As in test_dg_beam, with quadratic functions.
static void quadratic_compliance_agrees_with_independent_codes(void **state) {
  (void)state;
  CHECK_NEAR(test_reference_compliance(LTH_FLUX_IP, 2, 40), 2.94883907e-4, 1e-8 * 3e-4);
  CHECK_NEAR(test_reference_compliance(LTH_FLUX_BZ, 2, 40), 3.02297494e-4, 1e-8 * 3e-4);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(tetrahedra_converge),
      cmocka_unit_test(sliced_meshes_converge),
      cmocka_unit_test(nearly_incompressible_sliced_meshes_converge),
      cmocka_unit_test(quadratic_compliance_agrees_with_independent_codes),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
