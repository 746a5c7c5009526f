/// Loads: totals, moments against closed forms, followers, and no allocation.
#include "dg_body.h"
#include "solids.h"

static const LthGrid block = {{0.5, -1, 2}, {1.5, 1, 3}, {2, 3, 2}};

static double linear_in_y(const void *self, const double x[3], double t) {
  (void)self;
  return t * (2 + 3 * x[1]);
}

static double constant_by_callback(const void *self, const double x[3], double t) {
  (void)x, (void)t;
  return *(const double *)self;
}

/// Resultant of a load vector, and its moment about the origin: tests with e_a and with rotations.
static void resultant(const TestBody *b, const double *f, double force[3], double moment[3]) {
  for (int a = 0; a < 3; a++) force[a] = moment[a] = 0;
  for (LitheIndex c = 0; c < b->space->n_cells; c++) {
    lth_v3_add(force, f + 3 * b->space->func_off[c], force);
    for (LitheIndex i = b->space->func_off[c]; i < b->space->func_off[c + 1]; i++) {
      double m[3];
      lth_v3_cross(b->x0 + 3 * i, f + 3 * i, m);
      lth_v3_add(moment, m, moment);
    }
  }
}

static void check_vector(const double got[3], double x, double y, double z) {
  CHECK_NEAR(got[0], x, 1e-12);
  CHECK_NEAR(got[1], y, 1e-12);
  CHECK_NEAR(got[2], z, 1e-12);
}

static void add(TestBody *b, const LthLoad *load, double t, const double *x) {
  memset(b->f, 0, sizeof *b->f * (size_t)b->space->n_dofs);
  CHECK_OK(b->ctx, lth_dg_add_load(b->ctx, b->space, load, t, x, b->f));
}

static void tractions_have_their_resultant_and_moment(void **state) {
  (void)state;
  for (int k = 1; k <= 3; k++) {
    TestBody b = test_body(k == 2 ? TEST_TETRAHEDRA : TEST_HEXAHEDRA, block, k);
    b.patches[0] =
        test_patches(b.ctx, b.mesh, test_facing_up_x); // x = 1.5, area 2, about (1.5, 0, 2.5)
    LthLoad load = {.kind = LTH_LOAD_TRACTION, .patches = b.patches[0]};
    double force[3], moment[3];
    load.value[0].constant = 3, load.value[2].constant = -1;
    add(&b, &load, 0, NULL);
    resultant(&b, b.f, force, moment);
    check_vector(force, 6, 0, -2);
    check_vector(moment, 0, 2.5 * 6 + 1.5 * 2, 0);

    // t (2 + 3 y) along z: total 2 t * 2, moment about x: int y (2 + 3 y) = 3 * 2 / 3
    load = (LthLoad){.kind = LTH_LOAD_TRACTION, .patches = b.patches[0]};
    load.value[2].eval = linear_in_y;
    add(&b, &load, 0.5, NULL);
    resultant(&b, b.f, force, moment);
    check_vector(force, 0, 0, 2);
    check_vector(moment, 0.5 * 2, -1.5 * 2, 0);
    test_body_free(&b);
  }
}

static void total_force_is_spread_evenly(void **state) {
  (void)state;
  TestBody b = test_body(TEST_HEXAHEDRA, block, 2);
  b.patches[0] = test_patches(b.ctx, b.mesh, test_facing_up_x);
  LthLoad load = {.kind = LTH_LOAD_TOTAL_FORCE, .patches = b.patches[0]};
  for (int a = 0; a < 3; a++) load.value[a].constant = a + 1;
  double force[3], moment[3];
  add(&b, &load, 0, NULL);
  resultant(&b, b.f, force, moment);
  check_vector(force, 1, 2, 3);
  check_vector(moment, 0 * 3 - 2.5 * 2, 2.5 * 1 - 1.5 * 3, 1.5 * 2 - 0 * 1);
  b.patches[0]->n = 0;
  assert_int_equal(lth_dg_add_load(b.ctx, b.space, &load, 0, NULL, b.f), LITHE_BAD_INPUT);
  test_body_free(&b);
}

/// Uniform pressure and the stress -p I are the same and balance on a closed surface.
static void pressure_on_a_closed_surface_balances(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthSurface *s = solid_torus(ctx, 1, 0.4, 9, 6);
  LthGrid cells = {{-2, -2, -1}, {2, 2, 1}, {3, 3, 1}};
  LthMesh *mesh = NULL;
  CHECK_OK(ctx, lth_mesh_slice(ctx, s, &cells, 0.05, &mesh));
  TestBody b = test_body_of(ctx, mesh, 2);
  b.patches[0] = test_patches(b.ctx, b.mesh, test_everywhere);
  LthLoad load = {.kind = LTH_LOAD_PRESSURE, .patches = b.patches[0]};
  double force[3], moment[3], p = 5;
  load.value[0].constant = p;
  add(&b, &load, 0, NULL);
  resultant(&b, b.f, force, moment);
  check_vector(force, 0, 0, 0);
  check_vector(moment, 0, 0, 0);
  memcpy(b.r, b.f, sizeof *b.f * (size_t)b.space->n_dofs);
  CHECK_AT_LEAST(test_max(b.space->n_dofs, b.r), 0.1);

  LthLoad as_stress = {.kind = LTH_LOAD_STRESS, .patches = b.patches[0]};
  for (int i = 0; i < 9; i += 4) as_stress.stress[i].constant = -p;
  add(&b, &as_stress, 0, NULL);
  for (LitheCount i = 0; i < b.space->n_dofs; i++) CHECK_NEAR(b.f[i], b.r[i], 1e-12);

  // by quadrature the same as by moments; a follower at rest too
  load.value[0] = (LthValue){0, constant_by_callback, &p};
  for (int follower = 0; follower < 2; follower++) {
    load.follower = follower;
    add(&b, &load, 0, b.x0);
    for (LitheCount i = 0; i < b.space->n_dofs; i++) CHECK_NEAR(b.f[i], b.r[i], 1e-11);
  }
  solid_free(ctx, &s);
  test_body_free(&b);
}

/// x = F X: the force of a follower is cof F times that at rest.
static void follower_pressure_turns_and_stretches(void **state) {
  (void)state;
  TestBody b = test_body(TEST_HEXAHEDRA, block, 1);
  b.patches[0] = test_patches(b.ctx, b.mesh, test_facing_up_x);
  double R[9], F[9], U[9] = {1.5, 0.2, 0, 0, 0.8, 0.1, 0, 0, 1.2}, force[3], moment[3];
  test_rotation(1.3, R);
  lth_m3_mul(R, U, F);
  test_affine(&b, F, (double[3]){1, 2, 3}, b.x0, b.x);
  LthLoad load = {.kind = LTH_LOAD_PRESSURE, .patches = b.patches[0], .follower = true};
  load.value[0].constant = 2;
  add(&b, &load, 0, b.x);
  resultant(&b, b.f, force, moment);
  double column[2][3] = {{F[1], F[4], F[7]}, {F[2], F[5], F[8]}}, want[3];
  lth_v3_cross(column[0], column[1], want); // edges y and z of the face, area 2
  check_vector(force, -2 * 2 * want[0], -2 * 2 * want[1], -2 * 2 * want[2]);
  test_body_free(&b);
}

static void body_forces_and_gravity_agree(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthSurface *s = solid_star(ctx, 5, 0.4, 1, 0.5);
  LthGrid cells = {{-1, -1, -0.1}, {1, 1, 0.6}, {2, 2, 1}};
  LthMesh *mesh = NULL;
  CHECK_OK(ctx, lth_mesh_slice(ctx, s, &cells, 0.05, &mesh));
  TestBody b = test_body_of(ctx, mesh, 2);
  double g[3] = {0, 2, -9.81}, force[3], moment[3], one = -9.81, *rho = b.poisson;
  for (LitheIndex c = 0; c < b.space->n_cells; c++) rho[c] = 1;
  lth_dg_add_gravity(b.space, rho, g, b.r);
  LthLoad load = {.kind = LTH_LOAD_BODY_FORCE};
  load.value[1].constant = 2, load.value[2].constant = -9.81;
  add(&b, &load, 0, NULL);
  for (LitheCount i = 0; i < b.space->n_dofs; i++) CHECK_NEAR(b.f[i], b.r[i], 1e-14);
  load.value[2] = (LthValue){0, constant_by_callback, &one};
  add(&b, &load, 0, NULL);
  for (LitheCount i = 0; i < b.space->n_dofs; i++) CHECK_NEAR(b.f[i], b.r[i], 1e-13);
  resultant(&b, b.f, force, moment);
  double volume = solid_volume(s);
  check_vector(force, 0, 2 * volume, -9.81 * volume);

  double *mass = b.x, total = 0; // room enough
  lth_dg_mass(b.space, rho, mass);
  for (LitheIndex c = 0; c < b.space->n_cells; c++) total += mass[b.space->func_off[c]];
  CHECK_NEAR(total, volume, 1e-13);
  solid_free(ctx, &s);
  test_body_free(&b);
}

static void loads_allocate_nothing(void **state) {
  (void)state;
  TestBody b = test_body(TEST_HEXAHEDRA, block, 2);
  b.patches[0] = test_patches(b.ctx, b.mesh, test_everywhere);
  LitheCount before = lth_alloc_count(b.ctx);
  LthLoad load = {.patches = b.patches[0], .follower = true};
  for (int kind = LTH_LOAD_TRACTION; kind <= LTH_LOAD_BODY_FORCE; kind++) {
    load.kind = (LthLoadKind)kind;
    load.value[0].eval = load.stress[0].eval = linear_in_y;
    add(&b, &load, 0, b.x0);
  }
  assert_int_equal(lth_alloc_count(b.ctx), before);
  test_body_free(&b);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(tractions_have_their_resultant_and_moment),
      cmocka_unit_test(total_force_is_spread_evenly),
      cmocka_unit_test(pressure_on_a_closed_surface_balances),
      cmocka_unit_test(follower_pressure_turns_and_stretches),
      cmocka_unit_test(body_forces_and_gravity_agree),
      cmocka_unit_test(loads_allocate_nothing),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
