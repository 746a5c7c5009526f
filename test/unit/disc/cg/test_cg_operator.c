/// Stiffness, mass, energy and evaluation of conforming elements of every kind.
#include "cg_body.h"

#define FOR_KINDS(k) for (int k = LTH_TET4; k < LTH_POLYHEDRON; k++)

static const double stretch[9] = {1.1, 0.03, -0.02, 0.05, 0.95, 0.04, -0.01, 0.02, 1.07};
static const double shift[3] = {0.3, -0.2, 0.5};

/// A rotation about (1, 2, 3).
static void turn(double angle, double R[9]) {
  double axis[3] = {1, 2, 3};
  lth_v3_normalize(axis);
  lth_m3_rotation(axis, angle, R);
}

/// First Piola stress R C(sym(R^T F) - I) of the body's material; R = I where it is linear.
static void nominal_stress(const double F[9], const double R[9], double P[9]) {
  double Rt[9], H[9], S[9], lambda, mu;
  lth_lame(1000, 0.3, &lambda, &mu);
  lth_m3_transpose(R, Rt);
  lth_m3_mul(Rt, F, H);
  for (int a = 0; a < 3; a++) H[4 * a] -= 1;
  double trace = H[0] + H[4] + H[8];
  for (int a = 0; a < 3; a++)
    for (int b = 0; b < 3; b++)
      S[3 * a + b] = mu * (H[3 * a + b] + H[3 * b + a]) + (a == b ? lambda * trace : 0);
  lth_m3_mul(R, S, P);
}

/// Forces of a linear deformation balance the tractions of its stress on every node: the patch test with
/// loads, which inner nodes pass with nothing and those of the boundary with their share.
static void check_patch(LthElementKind kind, bool warped, bool reduced) {
  CgBody b = cg_body(kind, 2, 0.15);
  b.def.warped = warped;
  if (reduced) {
    b.elements->reduced = lth_alloc(b.ctx, b.elements->n_elements, 1);
    memset(b.elements->reduced, 1, (size_t)b.elements->n_elements);
  }
  cg_build(&b);
  double P[9], R[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  cg_affine(&b, stretch, shift, b.x);
  if (warped) lth_rotation_nearest(stretch, R);
  nominal_stress(stretch, R, P);
  LthLoad load = {.kind = LTH_LOAD_STRESS, .patches = cg_select(&b, 0, NULL, NULL)};
  for (int i = 0; i < 9; i++) load.stress[i] = lth_value_constant(P[i]);
  CHECK_OK(b.ctx, b.disc->table->add_load(b.ctx, b.disc, &load, 0, NULL, b.f));
  cg_force(&b, b.x, true, b.r);
  double scale = cg_scale(&b);
  for (LitheCount i = 0; i < b.disc->n_dofs; i++) CHECK_NEAR(b.r[i], b.f[i], 1e-14 * scale);
  cg_free(&b);
}

static void constant_stress_is_exact_on_distorted_meshes_of_every_kind(void **state) {
  (void)state;
  FOR_KINDS(k) {
    check_patch((LthElementKind)k, false, false);
    check_patch((LthElementKind)k, true, false);
  }
}

static void constant_stress_is_exact_with_reduced_rules(void **state) {
  (void)state;
  check_patch(LTH_HEX8, false, true);
  check_patch(LTH_HEX20, false, true);
  check_patch(LTH_WEDGE6, false, true);
}

static void rigid_motions_cost_no_force_where_elements_turn(void **state) {
  (void)state;
  double R[9];
  turn(2.2, R);
  FOR_KINDS(k) {
    CgBody b = cg_body((LthElementKind)k, 1, 0);
    b.def.warped = true;
    cg_build(&b);
    cg_affine(&b, R, shift, b.x);
    cg_force(&b, b.x, true, b.r);
    CHECK_AT_MOST(cg_max(b.disc->n_dofs, b.r), 1e-14 * cg_scale(&b));
    CHECK_AT_MOST(b.disc->table->energy(b.disc, 0, b.x), 1e-25 * cg_scale(&b));
    b.disc->table->update_rotations(b.disc, NULL);
    cg_force(&b, b.x, false, b.r);
    CHECK_AT_LEAST(cg_max(b.disc->n_dofs, b.r), 0.01 * cg_scale(&b));
    cg_free(&b);
  }
}

static LitheCount count_zero(const double *w, LitheCount n) {
  LitheCount zero = 0;
  for (LitheCount i = 0; i < n; i++) {
    zero += fabs(w[i]) <= 1e-13 * w[n - 1];
    assert_true(fabs(w[i]) <= 1e-13 * w[n - 1] || w[i] >= 1e-6 * w[n - 1]);
  }
  return zero;
}

/// One element of the kind: a mesh of one cell of which all but the first element is dropped.
static CgBody one_element(LthElementKind kind, bool reduced) {
  LitheCtx *ctx = test_ctx();
  LthElementMesh *m = cg_cube(ctx, kind, 1, 0);
  m->n_elements = 1;
  LitheIndex n = lth_element_shape(kind)->n_nodes, last = -1;
  for (LitheIndex i = 0; i < n; i++) last = m->element_node[i] > last ? m->element_node[i] : last;
  assert_int_equal(last, n - 1);
  m->n_nodes = n;
  if (reduced) {
    m->reduced = lth_alloc(ctx, 1, 1);
    m->reduced[0] = 1;
  }
  return cg_body_of(ctx, m);
}

static void a_free_element_has_six_zero_eigenvalues_and_no_more(void **state) {
  (void)state;
  FOR_KINDS(k) {
    CgBody b = one_element((LthElementKind)k, false);
    cg_build(&b);
    cg_force(&b, b.x, false, b.r);
    double *w = cg_eigenvalues(&b);
    assert_int_equal(count_zero(w, b.disc->n_dofs), 6);
    lth_free(b.ctx, w);
    cg_free(&b);
  }
}

/// hex20 with 2x2x2 points has 48 strains for 60 unknowns, wedge6 with two 12 of which one is no new one; hex8 is
/// held by its stabilisation.
static void reduced_elements_have_the_spurious_modes_that_are_known(void **state) {
  (void)state;
  static const LthElementKind kinds[3] = {LTH_HEX8, LTH_HEX20, LTH_WEDGE6};
  static const int zero[3] = {6, 12, 7};
  for (int i = 0; i < 3; i++) {
    CgBody b = one_element(kinds[i], true);
    cg_build(&b);
    cg_force(&b, b.x, false, b.r);
    double *w = cg_eigenvalues(&b);
    assert_int_equal(count_zero(w, b.disc->n_dofs), zero[i]);
    lth_free(b.ctx, w);
    cg_free(&b);
  }
}

static void forces_are_the_slope_of_the_energy(void **state) {
  (void)state;
  uint64_t seed = 3;
  FOR_KINDS(k) {
    CgBody b = cg_body((LthElementKind)k, 1, 0);
    b.def.warped = true;
    cg_build(&b);
    LitheCount n = b.disc->n_dofs;
    for (LitheCount i = 0; i < n; i++) b.x[i] += 0.2 * (test_random(&seed) - 0.5);
    cg_force(&b, b.x, true, b.r); // the slope at frozen rotations
    double along = 0, h = 1e-3;
    for (LitheCount i = 0; i < n; i++) {
      double d = test_random(&seed) - 0.5;
      along += b.r[i] * d;
      b.f[i] = b.x[i] + h * d;
      b.x[i] -= h * d;
    }
    double slope =
        (b.disc->table->energy(b.disc, 0, b.f) - b.disc->table->energy(b.disc, 0, b.x)) / (2 * h);
    CHECK_NEAR(slope, along, 1e-10 * cg_scale(&b)); // quadratic: the quotient is exact
    cg_free(&b);
  }
}

static void the_matrix_is_symmetric_when_turned(void **state) {
  (void)state;
  uint64_t seed = 4;
  FOR_KINDS(k) {
    CgBody b = cg_body((LthElementKind)k, 2, 0.1);
    b.def.warped = true;
    cg_build(&b);
    for (LitheCount i = 0; i < b.disc->n_dofs; i++) b.x[i] += 0.1 * test_random(&seed);
    cg_force(&b, b.x, true, b.r);
    CHECK_AT_MOST(lth_block_matrix_asymmetry(b.K), 1e-14);
    cg_free(&b);
  }
}

static void mass_is_volume_times_density_in_all_its_forms(void **state) {
  (void)state;
  FOR_KINDS(k) {
    CgBody b = cg_body((LthElementKind)k, 2, 0.15);
    for (LitheIndex c = 0; c < b.mesh->n_cells; c++) b.density[c] = 7;
    cg_build(&b);
    const LthDiscTable *t = b.disc->table;
    LitheCount n = b.disc->n_dofs;
    double *mass = lth_alloc(b.ctx, b.disc->n_dofs, sizeof *mass), sum[3] = {0}, lumped = 0;
    t->add_mass(b.disc, 2, b.K);
    for (LitheCount i = 0; i < n; i++) b.x[i] = 1;
    t->apply_mass(b.disc, b.x, b.r);
    lth_block_matrix_apply(b.K, 1, b.x, b.f);
    t->mass_diagonal(b.disc, mass);
    for (LitheCount i = 0; i < n; i++) {
      sum[i % 3] += b.r[i];
      CHECK_NEAR(b.f[i], 2 * b.r[i], 1e-14);
    }
    for (LitheIndex i = 0; i < b.disc->n_funcs; i++) {
      assert_true(mass[3 * i] > 0);
      lumped += mass[3 * i];
    }
    // the cube is divided without gaps, curved faces inside included
    for (int a = 0; a < 3; a++) CHECK_NEAR(sum[a], 7, 1e-13);
    CHECK_NEAR(lumped, 7, 1e-13);
    memset(b.f, 0, sizeof *b.f * (size_t)n);
    t->add_gravity(b.disc, (double[3]){0, 0, -10}, b.f);
    for (LitheIndex i = 0; i < b.disc->n_funcs; i++)
      CHECK_NEAR(b.f[3 * i + 2], -10 * b.r[3 * i + 2], 1e-13);
    lth_free(b.ctx, mass);
    cg_free(&b);
  }
}

/// Inside elements, on their faces and far outside.
static void evaluation_reproduces_linear_fields_anywhere(void **state) {
  (void)state;
  uint64_t seed = 8;
  FOR_KINDS(k) {
    CgBody b = cg_body((LthElementKind)k, 2, 0.2);
    cg_build(&b);
    cg_affine(&b, stretch, shift, b.x);
    for (int trial = 0; trial < 40; trial++) {
      double at[3], want[3], got[3], F[9], reach = trial < 30 ? 1 : 5;
      LitheIndex cell = (LitheIndex)(test_random(&seed) * b.mesh->n_cells);
      for (int a = 0; a < 3; a++) at[a] = 0.5 + reach * (test_random(&seed) - 0.5);
      lth_m3_apply(stretch, at, want);
      lth_v3_add(want, shift, want);
      lth_disc_sample(b.disc, cell, b.x, at, got);
      lth_disc_sample_gradient(b.disc, cell, b.x, at, F);
      for (int a = 0; a < 3; a++) CHECK_NEAR(got[a], want[a], 1e-12);
      for (int i = 0; i < 9; i++) CHECK_NEAR(F[i], stretch[i], 1e-12);
      lth_disc_mean_gradient(b.disc, cell, b.x, F);
      for (int i = 0; i < 9; i++) CHECK_NEAR(F[i], stretch[i], 1e-12);
    }
    cg_free(&b);
  }
}

static void functions_come_in_ascending_order(void **state) {
  (void)state;
  FOR_KINDS(k) {
    CgBody b = cg_body((LthElementKind)k, 2, 0);
    cg_build(&b);
    for (LitheIndex c = 0; c < b.mesh->n_cells; c++) {
      LitheIndex func[LTH_DISC_MAX_FUNCS];
      double phi[3 * LTH_DISC_MAX_FUNCS];
      int n = b.disc->table->eval(b.disc, c, b.mesh->cell_centroid + 3 * c, func, phi);
      for (int i = 1; i < n; i++) assert_true(func[i - 1] < func[i]);
    }
    cg_free(&b);
  }
}

static void stress_at_a_place_is_that_of_the_material(void **state) {
  (void)state;
  CgBody b = cg_body(LTH_HEX20, 2, 0.1);
  cg_build(&b);
  double P[9], stress[6];
  cg_affine(&b, stretch, shift, b.x);
  nominal_stress(stretch, (double[9]){1, 0, 0, 0, 1, 0, 0, 0, 1}, P);
  b.disc->table->stress(b.disc, 3, b.x, b.mesh->cell_centroid + 9, stress);
  static const int voigt[6] = {0, 4, 8, 5, 2, 1};
  for (int i = 0; i < 6; i++) CHECK_NEAR(stress[i], P[voigt[i]], 1e-10);
  cg_free(&b);
}

static void results_have_the_same_bits_for_any_number_of_threads(void **state) {
  (void)state;
  CgBody b = cg_body(LTH_TET4, 5, 0.1); // 750 elements: above the size where threads are used
  b.def.warped = true;
  cg_build(&b);
  uint64_t seed = 6;
  LitheCount n = b.disc->n_dofs, n_values = b.K->value_off[b.K->block_off[b.K->n_rows]];
  for (LitheCount i = 0; i < n; i++) b.x[i] += 0.02 * test_random(&seed);
  double *values = lth_alloc(b.ctx, n_values, sizeof *values), energy = 0;
  for (int threads = 1; threads <= 3; threads++) {
    lth_set_threads(b.ctx, threads);
    cg_force(&b, b.x, true, threads == 1 ? b.f : b.r);
    double e = b.disc->table->energy(b.disc, 0, b.x);
    if (threads == 1) {
      memcpy(values, b.K->values, sizeof *values * (size_t)n_values);
      energy = e;
      continue;
    }
    assert_memory_equal(values, b.K->values, sizeof *values * (size_t)n_values);
    assert_memory_equal(b.f, b.r, sizeof *b.f * (size_t)n);
    assert_true(e == energy);
  }
  lth_free(b.ctx, values);
  cg_free(&b);
}

static void inverted_elements_are_named(void **state) {
  (void)state;
  CgBody b = cg_body(LTH_HEX8, 2, 0);
  LitheIndex *node = b.elements->element_node + b.elements->element_off[5], swap = node[0];
  node[0] = node[6], node[6] = swap;
  assert_int_equal(lth_cg_disc_create(b.ctx, &b.def, &b.disc), LITHE_BAD_INPUT);
  assert_non_null(strstr(lithe_ctx_message(b.ctx), "element 6 (hex8)"));
  cg_free(&b);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(constant_stress_is_exact_on_distorted_meshes_of_every_kind),
      cmocka_unit_test(constant_stress_is_exact_with_reduced_rules),
      cmocka_unit_test(rigid_motions_cost_no_force_where_elements_turn),
      cmocka_unit_test(a_free_element_has_six_zero_eigenvalues_and_no_more),
      cmocka_unit_test(reduced_elements_have_the_spurious_modes_that_are_known),
      cmocka_unit_test(forces_are_the_slope_of_the_energy),
      cmocka_unit_test(the_matrix_is_symmetric_when_turned),
      cmocka_unit_test(mass_is_volume_times_density_in_all_its_forms),
      cmocka_unit_test(evaluation_reproduces_linear_fields_anywhere),
      cmocka_unit_test(functions_come_in_ascending_order),
      cmocka_unit_test(stress_at_a_place_is_that_of_the_material),
      cmocka_unit_test(results_have_the_same_bits_for_any_number_of_threads),
      cmocka_unit_test(inverted_elements_are_named),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
