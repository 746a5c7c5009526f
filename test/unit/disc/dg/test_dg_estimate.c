/// The error estimate is zero for exact solutions, and every way of being wrong has its part.
#include "dg_body.h"

#include "disc/dg/dg_estimate.h"

static double *estimate(const TestBody *b, const LthDgEstimateDef *def) {
  double *parts =
      lth_alloc(b->ctx, LTH_ESTIMATE_PARTS * (LitheCount)b->space->n_cells, sizeof *parts);
  CHECK_OK(b->ctx, lth_dg_estimate(b->ctx, def, parts));
  return parts;
}

static double total(const TestBody *b, const double *parts, int part) {
  double sum = 0;
  for (LitheIndex c = 0; c < b->space->n_cells; c++) sum += parts[LTH_ESTIMATE_PARTS * c + part];
  return sum;
}

static const LthGrid bar = {{0, 0, 0}, {2, 1, 1}, {4, 2, 2}};

static bool not_facing_down_x(const double c[3], const double n[3]) {
  return !test_facing_down_x(c, n);
}

/// A quadratic field u = (a x^2 + b xy, c yz, d xz) is found by quadratic functions: nothing is missing.
typedef struct Bend {
  double lambda, mu;
  int row;
} Bend;

static void bent(const void *self, const double x[3], double value[3]) {
  (void)self;
  value[0] = x[0] + 0.02 * x[0] * x[0] + 0.01 * x[0] * x[1];
  value[1] = x[1] - 0.03 * x[1] * x[2];
  value[2] = x[2] + 0.01 * x[0] * x[2];
}

static void bent_stress(const Bend *b, const double x[3], double S[9]) {
  double H[9] = {0.04 * x[0] + 0.01 * x[1],
                 0.01 * x[0],
                 0,
                 0,
                 -0.03 * x[2],
                 -0.03 * x[1],
                 0.01 * x[2],
                 0,
                 0.01 * x[0]};
  for (int i = 0; i < 9; i++)
    S[i] = b->mu * (H[i] + H[3 * (i % 3) + i / 3]) +
           (i % 4 == 0 ? b->lambda * (H[0] + H[4] + H[8]) : 0);
}

static double bent_displacement(const void *self, const double x[3], double t) {
  (void)t;
  double y[3];
  bent(NULL, x, y);
  return y[((const Bend *)self)->row] - x[((const Bend *)self)->row];
}

static double bent_traction(const void *self, const double x[3], double t) {
  (void)t;
  const Bend *b = self;
  double S[9];
  bent_stress(b, x, S);
  return S[b->row];
}

/// -div sigma is constant: by central differences, exact for linear stress.
static void bent_force(const Bend *b, double f[3]) {
  for (int a = 0; a < 3; a++) f[a] = 0;
  for (int d = 0; d < 3; d++)
    for (int side = -1; side <= 1; side += 2) {
      double x[3] = {0}, S[9];
      x[d] = side;
      bent_stress(b, x, S);
      for (int a = 0; a < 3; a++) f[a] -= side * S[3 * a + d] / 2;
    }
}

/// The load is given as two that overlap: the estimate has to add them where both act.
static void exact_solutions_have_no_error(void **state) {
  (void)state;
  for (int degree = 2; degree <= 4; degree++) {
    TestBody b = test_body(degree == 3 ? TEST_TETRAHEDRA : TEST_HEXAHEDRA, bar, degree);
    Bend component[9];
    double force[3], density = 2;
    lth_lame(1000, 0.3, &component[0].lambda, &component[0].mu);
    for (int i = 8; i >= 0; i--) component[i] = component[0], component[i].row = i;
    LthWeakConstraint *hold = test_hold(&b, test_facing_down_x);
    for (int a = 0; a < 3; a++) hold->value[a] = (LthValue){0, bent_displacement, component + a};
    test_assemble(&b, 0);
    test_project(&b, bent, NULL, b.x);

    b.patches[2] = test_patches(b.ctx, b.mesh, not_facing_down_x);
    b.patches[3] = test_patches(b.ctx, b.mesh, test_facing_up_x);
    LthLoad loads[4] = {{.kind = LTH_LOAD_STRESS, .patches = b.patches[2]},
                        {.kind = LTH_LOAD_TRACTION, .patches = b.patches[3]},
                        {.kind = LTH_LOAD_TRACTION, .patches = b.patches[2]},
                        {.kind = LTH_LOAD_BODY_FORCE}};
    for (int i = 0; i < 9; i++) loads[0].stress[i] = (LthValue){0, bent_traction, component + i};
    LthDgEstimateDef def = {.op = b.op, .x = b.x, .loads = loads, .n_loads = 4};
    bent_force(component, force);
    double *rho = lth_alloc(b.ctx, b.space->n_cells, sizeof *rho);
    for (LitheIndex c = 0; c < b.space->n_cells; c++) rho[c] = density;
    def.density = rho;
    def.gravity[2] = -9.81;
    for (int a = 0; a < 3; a++) loads[3].value[a].constant = force[a] - density * def.gravity[a];
    loads[1].value[0].constant = 7, loads[1].value[1].constant = -3;

    // what is too much at the end x = 2 counts in full, its square and its product with the rest
    double *parts = estimate(&b, &def), scale = 0.3 * 0.5 / (degree * component[0].mu);
    if (degree != 3)
      CHECK_NEAR(total(&b, parts, LTH_ESTIMATE_BOUNDARY), scale * 58, 1e-9 * scale * 58);
    lth_free(b.ctx, parts);
    loads[1].value[0].constant = loads[1].value[1].constant = 0;
    parts = estimate(&b, &def);
    // some thousand products of squares that cancel
    double rounding = 1e-12 * lth_dg_energy(b.op, 0, b.x);
    for (int i = 0; i < LTH_ESTIMATE_PARTS; i++) CHECK_AT_MOST(total(&b, parts, i), rounding);
    lth_free(b.ctx, parts);
    lth_free(b.ctx, rho);
    test_body_free(&b);
  }
}

/// Turned with its rotations, a body has the same estimate.
static void the_estimate_turns_with_the_body(void **state) {
  (void)state;
  TestBody b = test_body(TEST_HEXAHEDRA, bar, 2);
  b.def.warped = true;
  test_assemble(&b, 0);
  test_project(&b, bent, NULL, b.x);
  uint64_t seed = 5;
  for (LitheCount i = 0; i < b.space->n_dofs; i++) b.x[i] += 0.02 * (test_random(&seed) - 0.5);
  lth_dg_update_rotations(b.op, b.x);
  LthDgEstimateDef def = {.op = b.op, .x = b.x};
  double *before = estimate(&b, &def), R[9], rough = lth_dg_roughness(b.op, 3, b.x);
  test_rotation(1.1, R);
  test_affine(&b, R, (double[3]){3, 1, -2}, b.x, b.r);
  lth_dg_update_rotations(b.op, b.r);
  def.x = b.r;
  double *after = estimate(&b, &def);
  for (LitheIndex i = 0; i < LTH_ESTIMATE_PARTS * b.space->n_cells; i++)
    CHECK_NEAR(after[i], before[i], 1e-10 * total(&b, before, i % LTH_ESTIMATE_PARTS));
  CHECK_NEAR(lth_dg_roughness(b.op, 3, b.r), rough, 1e-10 * rough);
  lth_free(b.ctx, before);
  lth_free(b.ctx, after);
  test_body_free(&b);
}

/// A body that falls freely has no error once its acceleration is known, and cells that are held have none.
static void inertia_balances_weight_and_held_cells_are_passed_over(void **state) {
  (void)state;
  TestBody b = test_body(TEST_HEXAHEDRA, bar, 1);
  uint8_t *held = lth_alloc(b.ctx, b.space->n_dofs, 1);
  double *rho = lth_alloc(b.ctx, b.space->n_cells, sizeof *rho);
  double *a = lth_alloc(b.ctx, b.space->n_dofs, sizeof *a);
  for (LitheIndex c = 0; c < b.space->n_cells; c++)
    rho[c] = 3, a[3 * b.space->func_off[c] + 1] = -9.81;
  for (LitheCount i = 0; i < 3 * (LitheCount)b.space->func_off[2]; i++) held[i] = LTH_HELD;
  b.def.held = held;
  test_assemble(&b, 0);
  LthDgEstimateDef def = {.op = b.op, .x = b.x, .gravity = {0, -9.81, 0}, .density = rho};
  double *parts = estimate(&b, &def);
  assert_true(lth_dg_estimate_sum(parts, 0) == 0 && lth_dg_estimate_sum(parts, 1) == 0);
  for (LitheIndex c = 2; c < b.space->n_cells; c++) {
    double want = pow(3 * 9.81 * 0.5 / M_PI, 2) / (1000 / 2.6) * b.mesh->cell_volume[c];
    CHECK_NEAR(parts[LTH_ESTIMATE_PARTS * c + LTH_ESTIMATE_VOLUME], want, 1e-12 * want);
  }
  lth_free(b.ctx, parts);
  def.acceleration = a;
  parts = estimate(&b, &def);
  for (int i = 0; i < LTH_ESTIMATE_PARTS; i++) CHECK_AT_MOST(total(&b, parts, i), 1e-20);
  lth_free(b.ctx, parts);
  lth_free(b.ctx, a);
  lth_free(b.ctx, rho);
  lth_free(b.ctx, held);
  test_body_free(&b);
}

/// Turned, and stretched evenly, under the tractions of that stress: nothing is missing.
static void a_stretched_body_has_no_error_however_it_is_turned(void **state) {
  (void)state;
  TestBody b = test_body(TEST_HEXAHEDRA, bar, 1);
  b.def.warped = true;
  test_assemble(&b, 0);
  const double U[9] = {1.1, 0, 0, 0, 0.95, 0, 0, 0, 1};
  double R[9], F[9], S[9] = {0}, P[9], lambda, mu;
  test_rotation(1.1, R);
  lth_m3_mul(R, U, F);
  test_affine(&b, F, (double[3]){3, 1, -2}, b.x0, b.x);
  lth_dg_update_rotations(b.op, b.x);
  lth_lame(1000, 0.3, &lambda, &mu);
  for (int i = 0; i < 9; i += 4) S[i] = lambda * 0.05 + 2 * mu * (U[i] - 1);
  lth_m3_mul(R, S, P);
  b.patches[0] = test_patches(b.ctx, b.mesh, test_everywhere);
  LthLoad load = {.kind = LTH_LOAD_STRESS, .patches = b.patches[0]};
  for (int i = 0; i < 9; i++) load.stress[i].constant = P[i];
  LthDgEstimateDef def = {.op = b.op, .x = b.x, .loads = &load, .n_loads = 1};
  double *parts = estimate(&b, &def), rounding = 1e-12 * lth_dg_energy(b.op, 0, b.x);
  for (int i = 0; i < LTH_ESTIMATE_PARTS; i++) CHECK_AT_MOST(total(&b, parts, i), rounding);
  lth_free(b.ctx, parts);
  test_body_free(&b);
}

/// Elements that are moved as they are have no stress: all of the energy is that of jumps and holds, and counts twice.
static void jumps_count_with_twice_their_energy(void **state) {
  (void)state;
  for (int degree = 1; degree <= 2; degree++) {
    TestBody b = test_body(TEST_TETRAHEDRA, bar, degree);
    uint64_t seed = 11;
    test_hold(&b, test_facing_down_x);
    test_assemble(&b, 0);
    for (LitheIndex c = 0; c < b.space->n_cells; c++)
      for (int a = 0; a < 3; a++)
        b.x[3 * b.space->func_off[c] + a] += 0.01 * (test_random(&seed) - 0.5);
    LthDgEstimateDef def = {.op = b.op, .x = b.x};
    double *parts = estimate(&b, &def), energy = lth_dg_energy(b.op, 0, b.x);
    CHECK_NEAR(total(&b, parts, LTH_ESTIMATE_JUMPS), 2 * energy, 1e-12 * energy);
    lth_free(b.ctx, parts);
    test_body_free(&b);
  }
}

/// Where the traction jumps by T between two materials, the shares of the two sides make up the whole, and the
/// stiffer one has more: a jump costs it less.
static void a_jump_of_traction_is_shared_by_two_materials(void **state) {
  (void)state;
  TestBody b = test_body(TEST_HEXAHEDRA, (LthGrid){{0, 0, 0}, {2, 1, 1}, {2, 1, 1}}, 1);
  double lambda[2], mu[2], stretch[9] = {1.01, 0, 0, 0, 1, 0, 0, 0, 1}, share[2];
  b.young[1] = 5000;
  test_assemble(&b, 0);
  for (int s = 0; s < 2; s++) lth_lame(b.young[s], 0.3, &lambda[s], &mu[s]);
  test_affine(&b, stretch, (double[3]){0}, b.x0, b.r);
  LitheCount half = 3 * (LitheCount)b.space->func_off[1];
  memcpy(b.x + half, b.r + half, sizeof *b.x * (size_t)half);
  LthDgEstimateDef def = {.op = b.op, .x = b.x};
  double *parts = estimate(&b, &def), T = 0.01 * (lambda[1] + 2 * mu[1]);
  for (int s = 0; s < 2; s++)
    share[s] = sqrt(parts[LTH_ESTIMATE_PARTS * s + LTH_ESTIMATE_FACES] * mu[s] / 0.3) / T;
  CHECK_NEAR(share[0] + share[1], 1, 1e-12);
  CHECK_AT_MOST(share[0], 0.5 * share[1]);
  lth_free(b.ctx, parts);
  test_body_free(&b);
}

/// Legendre's polynomials of degree 2 and 3 on a cube of edge 2.
static void waves(const void *self, const double x[3], double value[3]) {
  const double *c = self, s = x[0] - 1;
  lth_v3_copy(x, value);
  value[0] += c[0] * 0.5 * (3 * s * s - 1) + c[1] * 0.5 * (5 * s * s * s - 3 * s);
}

/// Mean squares of their slopes are 3 and 6.
static void roughness_is_the_fall_off_of_slopes(void **state) {
  (void)state;
  TestBody b = test_body(TEST_HEXAHEDRA, (LthGrid){{0, 0, 0}, {2, 2, 2}, {1, 1, 1}}, 3);
  test_assemble(&b, 0);
  test_project(&b, waves, (double[2]){0.02, 0.005}, b.x);
  CHECK_NEAR(lth_dg_roughness(b.op, 0, b.x), sqrt(2) * 0.25, 1e-12);
  test_body_free(&b);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(exact_solutions_have_no_error),
      cmocka_unit_test(the_estimate_turns_with_the_body),
      cmocka_unit_test(inertia_balances_weight_and_held_cells_are_passed_over),
      cmocka_unit_test(a_stretched_body_has_no_error_however_it_is_turned),
      cmocka_unit_test(jumps_count_with_twice_their_energy),
      cmocka_unit_test(a_jump_of_traction_is_shared_by_two_materials),
      cmocka_unit_test(roughness_is_the_fall_off_of_slopes),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
