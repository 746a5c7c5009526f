/// The staggered discretisation: rows, energy, rigid motions, interpolation.
#include "staggered_ring.h"

static const double young = 1000, poisson = 0.3;

static void lame(double *lambda, double *mu) { lth_lame(young, poisson, lambda, mu); }

/// A grid of full cells with unequal sides.
static SgDef full_def(int dim) {
  return (SgDef){.dim = dim,
                 .low = {0.3, -0.2, 0.1},
                 .high = {2.3, 1.3, 1.9},
                 .n = {5, 6, 4},
                 .part = sg_full};
}

/// Fractions that look random but are those of one solid; nothing is empty.
static double noise_part(const void *self, const double low[3], const double size[3]) {
  (void)self, (void)size;
  double v = sin(91 * low[0] + 57 * low[1] + 33 * low[2]);
  return 0.05 + 0.95 * v * v;
}

static double rough(const double x[3], double a, double b, double c) {
  double v = sin(a * x[0] + b * x[1] + c * x[2] + 1);
  return v * v;
}

/// Unlike from part to part.
static void noise_material(const void *self, const double x[3], double *E, double *nu,
                           double *rho) {
  (void)self;
  *E = 100 + 900 * rough(x, 31, 17, 23);
  *nu = 0.05 + 0.4 * rough(x, 13, 29, 19);
  *rho = 1 + rough(x, 5, 3, 2);
}

static SgDef noise_def(int dim) {
  SgDef d = full_def(dim);
  d.part = noise_part;
  d.material = (LthMaterialField){.eval = noise_material};
  return d;
}

/// Entry of K that couples component b of the function at offset d to component a of that at a slot.
static double entry(const SgBody *b, LitheCount slot, const int d[3], int a, int c) {
  LitheCount other = lth_sparse_grid_step(b->s->grid, slot, d);
  assert_true(other >= 0);
  LitheCount e = lth_block_matrix_find(b->K, b->s->func[slot], b->s->func[other]);
  assert_true(e >= 0);
  return b->K->values[b->K->value_off[e] + 3 * a + c];
}

static LitheCount inner_slot(const SgBody *b, const double x[3]) {
  bool inside;
  LitheIndex cell = b->disc->table->find_cell(b->disc, x, &inside);
  assert_true(inside);
  return b->s->cell_slot[cell];
}

static void check_stencil(int dim) {
  SgBody b;
  SgDef def = full_def(dim);
  double lambda, mu;
  lame(&lambda, &mu);
  sg_create(&b, &def);
  sg_assemble(&b);
  LitheCount slot = inner_slot(&b, (double[3]){1.3, 0.55, 1.2});
  const double *h = b.s->grid->h, volume = lth_sparse_grid_cell_volume(b.s->grid);
  for (int a = 0; a < dim; a++) {
    double diagonal = 2 * (2 * mu + lambda) / (h[a] * h[a]), scale = mu * volume / (h[a] * h[a]);
    for (int c = 0; c < dim; c++) {
      int d[3] = {0};
      if (c != a) diagonal += 2 * mu / (h[c] * h[c]);
      d[c] = 1;
      double modulus = c == a ? 2 * mu + lambda : mu;
      CHECK_NEAR(entry(&b, slot, d, a, a), -modulus * volume / (h[c] * h[c]), 1e-14 * scale);
      if (c == a) continue;
      double cross = (lambda + mu) * volume / (h[a] * h[c]);
      CHECK_NEAR(entry(&b, slot, (int[3]){0, 0, 0}, a, c), cross, 1e-13 * scale);
      CHECK_NEAR(entry(&b, slot, d, a, c), -cross, 1e-13 * scale);
      d[a] = -1;
      CHECK_NEAR(entry(&b, slot, d, a, c), cross, 1e-13 * scale);
      d[c] = 0;
      CHECK_NEAR(entry(&b, slot, d, a, c), -cross, 1e-13 * scale);
    }
    CHECK_NEAR(entry(&b, slot, (int[3]){0, 0, 0}, a, a), diagonal * volume, 1e-13 * scale);
  }
  sg_free(&b);
}

static void inner_rows_are_the_stencil_of_the_theory(void **state) {
  (void)state;
  check_stencil(2);
  check_stencil(3);
}

static void check_energy(int dim) {
  SgBody b;
  SgDef def = noise_def(dim);
  uint64_t seed = 7;
  sg_create(&b, &def);
  sg_assemble(&b);
  CHECK_AT_MOST(lth_block_matrix_asymmetry(b.K), 1e-15);
  LitheCount n = b.disc->n_dofs;
  for (LitheCount k = 0; k < n; k++) b.r[k] = sg_is_free(&b, k) ? test_random(&seed) - 0.5 : 0;
  // of a quadratic, differences in a direction are exact: E(x + d) - E(x - d) = 2 d . f(x)
  double up, down, slope = 0, most = 0;
  for (LitheCount k = 0; k < n; k++) b.x[k] = b.rest[k] + 0.3 * sin(3.7 * (double)k);
  sg_force(&b, b.x, b.f);
  for (LitheCount k = 0; k < n; k++) slope += 2 * b.r[k] * b.f[k];
  for (LitheCount k = 0; k < n; k++) b.x[k] += b.r[k];
  up = b.disc->table->energy(b.disc, 0, b.x);
  for (LitheCount k = 0; k < n; k++) b.x[k] -= 2 * b.r[k];
  down = b.disc->table->energy(b.disc, 0, b.x);
  most = fmax(up, down);
  CHECK_NEAR(up - down, slope, 1e-13 * most);
  sg_free(&b);
}

static void force_is_the_gradient_of_the_energy_for_any_fractions_and_materials(void **state) {
  (void)state;
  check_energy(2);
  check_energy(3);
}

static const LthShape ball = {.kind = LTH_SHAPE_SPHERE, .a = {0.03, -0.02, 0.05}, .radius = 0.7};

static SgDef ball_def(int dim, int n) {
  return (SgDef){.dim = dim,
                 .low = {-1, -0.9, -0.95},
                 .high = {1, 0.9, 0.95},
                 .n = {n, n + 1, n + 2},
                 .shape = &ball,
                 .method = {LTH_FRACTIONS_SAMPLES, 8, 0}};
}

static void affine(const void *self, const double x[3], double value[3]) {
  const double *A = self;
  lth_m3_apply(A, x, value);
  lth_v3_add(value, A + 9, value);
}

/// Rotation about e_axis as a linear field, of a cut body.
static void check_rigid(int dim) {
  SgBody b;
  SgDef def = ball_def(dim, dim == 2 ? 13 : 9);
  sg_create(&b, &def);
  sg_assemble(&b);
  LitheCount n = b.disc->n_dofs;
  sg_force(&b, b.rest, b.f);
  for (LitheCount k = 0; k < n; k++) assert_true(b.f[k] == 0);
  double stiff = sg_largest(b.K->value_off[b.K->block_off[b.K->n_rows]], b.K->values);
  for (int axis = dim == 2 ? 2 : 0; axis < 3; axis++) {
    double A[12] = {0};
    int c = (axis + 1) % 3, d = (axis + 2) % 3;
    A[3 * c + d] = -1;
    A[3 * d + c] = 1;
    b.disc->table->turn(b.disc, axis, b.rest, b.r);
    sg_project(&b, affine, A, b.x);
    for (LitheCount k = 0; k < n; k++)
      if (sg_is_free(&b, k)) CHECK_NEAR(b.r[k], b.x[k], 1e-15 * 8);
    lth_block_matrix_apply(b.K, 1, b.x, b.f);
    CHECK_AT_MOST(sg_largest(n, b.f), 1e-14 * stiff);
  }
  sg_free(&b);
}

static void rest_has_no_force_and_linearised_rotations_have_none(void **state) {
  (void)state;
  check_rigid(2);
  check_rigid(3);
}

static void check_interpolation(int dim) {
  static const double A[12] = {1.1, 0.3, -0.2, 0.15, 0.9, 0.4, -0.1, 0.2, 1.07, 0.3, -0.2, 0.5};
  double B[12];
  memcpy(B, A, sizeof B);
  if (dim == 2) B[6] = B[7] = B[8] = B[11] = B[2] = B[5] = 0;
  SgBody b;
  SgDef def = ball_def(dim, dim == 2 ? 13 : 9);
  sg_create(&b, &def);
  sg_project(&b, affine, B, b.x);
  uint64_t seed = 3;
  for (LitheIndex c = 0; c < b.disc->n_cells; c++)
    for (int k = 0; k < 4; k++) {
      double x[3], value[3], want[3], gradient[9];
      lth_staggered_place(b.s, b.s->func[b.s->cell_slot[c]], 0, x);
      for (int a = 0; a < dim; a++) x[a] += (2 * test_random(&seed) - 0.5) * b.s->grid->h[a];
      affine(B, x, want);
      lth_disc_sample(b.disc, c, b.x, x, value);
      lth_disc_sample_gradient(b.disc, c, b.x, x, gradient);
      for (int a = 0; a < 3; a++) CHECK_NEAR(value[a], want[a], 1e-14);
      for (int i = 0; i < 9; i++) CHECK_NEAR(gradient[i], B[i], 1e-13);
      lth_disc_mean_gradient(b.disc, c, b.x, gradient);
      for (int i = 0; i < 9; i++) CHECK_NEAR(gradient[i], B[i], 1e-13);
    }
  sg_free(&b);
}

static void linear_fields_are_exact_in_and_beside_every_cell(void **state) {
  (void)state;
  check_interpolation(2);
  check_interpolation(3);
}

/// Largest row of a function whose neighbours are all there, in a linear deformation: no force inside.
static void linear_deformations_leave_no_force_inside(void **state) {
  (void)state;
  static const double A[12] = {1.1, 0.3, -0.2, 0.15, 0.9, 0.4, -0.1, 0.2, 1.07};
  SgBody b;
  SgDef def = full_def(3);
  sg_create(&b, &def);
  sg_assemble(&b);
  sg_project(&b, affine, A, b.x);
  sg_force(&b, b.x, b.f);
  double stiff = sg_largest(b.K->value_off[b.K->block_off[b.K->n_rows]], b.K->values);
  for (LitheIndex i = 0; i < b.disc->n_funcs; i++) {
    bool inside = true;
    for (int k = 0; k < 27; k++) {
      int d[3] = {k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1};
      LitheCount other = lth_sparse_grid_step(b.s->grid, b.s->slot[i], d);
      inside &= other >= 0 && b.s->cell[other] >= 0;
    }
    for (int a = 0; a < 3 && inside; a++) CHECK_NEAR(b.f[3 * (LitheCount)i + a], 0, 1e-14 * stiff);
  }
  sg_free(&b);
}

static void mass_is_that_of_the_solid_in_every_direction(void **state) {
  (void)state;
  for (int dim = 2; dim <= 3; dim++) {
    SgBody b;
    SgDef def = ball_def(dim, 9);
    sg_create(&b, &def);
    double sum[3] = {0};
    b.disc->table->mass_diagonal(b.disc, b.r);
    for (LitheCount k = 0; k < b.disc->n_dofs; k++) sum[k % 3] += b.r[k];
    for (int a = 0; a < 3; a++) CHECK_NEAR(sum[a], b.fractions->volume, 1e-4 * sum[a]);
    sg_free(&b);
  }
}

/// Pulled with one end held: sigma_xx = E e (plane strain: E / (1 - nu^2)), and the reaction is it times the area.
static bool at_left(const void *self, const double x[3]) {
  (void)self;
  return x[0] <= 0.3 + 1e-9;
}
static bool at_right(const void *self, const double x[3]) {
  (void)self;
  return x[0] >= 2.3 - 1e-9;
}
static bool at_bottom(const void *self, const double x[3]) {
  (void)self;
  return x[1] <= -0.2 + 1e-9;
}
static bool at_back(const void *self, const double x[3]) {
  (void)self;
  return x[2] <= 0.1 + 1e-9;
}

static void a_pulled_block_has_the_stress_and_reactions_of_uniaxial_stress(void **state) {
  (void)state;
  LthStaggeredHold holds[4] = {{.selects = at_left, .fixed = {true}},
                               {.selects = at_right, .fixed = {true}},
                               {.selects = at_bottom, .fixed = {false, true}},
                               {.selects = at_back, .fixed = {false, false, true}}};
  holds[1].value[0] = lth_value_constant(0.1);
  for (int dim = 2; dim <= 3; dim++) {
    SgBody b;
    SgDef def = full_def(dim);
    def.holds = holds;
    def.n_holds = dim + 1;
    sg_create(&b, &def);
    sg_assemble(&b);
    CHECK_OK(b.ctx, sg_solve(&b));
    double E = dim == 3 ? young : young / (1 - poisson * poisson), pull = E * 0.05;
    double area = dim == 3 ? 1.5 * 1.8 : 1.5, reaction[12] = {0};
    for (LitheIndex c = 0; c < b.disc->n_cells; c += 7) {
      double at[3], stress[6];
      lth_staggered_place(b.s, b.s->func[b.s->cell_slot[c]], 0, at);
      b.disc->table->stress(b.disc, c, b.x, at, stress);
      CHECK_NEAR(stress[0], pull, 1e-11 * pull);
      if (dim == 2) CHECK_NEAR(stress[2], poisson * pull, 1e-11 * pull);
      for (int k = 1; k < 6; k++)
        if (dim == 3 || k != 2) CHECK_NEAR(stress[k], 0, 1e-11 * pull);
    }
    b.disc->table->assemble(b.disc, 0, b.K, b.f0);
    sg_force(&b, b.x, b.r);
    for (LitheCount k = 0; k < b.disc->n_dofs; k++) b.r[k] = -b.r[k];
    lth_staggered_add_reactions(b.disc, b.r, reaction);
    CHECK_NEAR(reaction[0], -pull * area, 1e-11 * pull * area);
    CHECK_NEAR(reaction[3], pull * area, 1e-11 * pull * area);
    CHECK_NEAR(reaction[7], 0, 1e-11 * pull * area);
    sg_free(&b);
  }
}

static void check_fixed_ring(int N, double l1, double linf) {
  SgBody b;
  LthStaggeredHold hold = ring_hold(ring_is_outside, NULL);
  ring_solve_full(N, &hold, &b);
  RingError e = ring_error(&b);
  CHECK_NEAR(e.l1, l1, 0.0006 * l1); // four digits
  CHECK_NEAR(e.linf, linf, 0.0006 * linf);
  sg_free(&b);
}

static void errors_of_the_fixed_annulus_are_those_of_the_theory(void **state) {
  (void)state;
  check_fixed_ring(32, 1.038e-2, 1.049e-2);
  check_fixed_ring(48, 4.168e-3, 4.427e-3);
  check_fixed_ring(64, 2.277e-3, 2.505e-3);
}

static void twist(const void *self, const double x[3], double value[3]) {
  const double *c = self;
  value[0] = x[0] + *c * x[1] * x[2];
  value[1] = x[1];
  value[2] = x[2];
}

static void a_shear_that_is_linear_along_its_edges_is_exact_inside_a_body(void **state) {
  (void)state;
  SgBody b;
  SgDef def = full_def(3);
  const double c = 0.01, mu = young / (2 * (1 + poisson));
  int n_tested = 0;
  sg_create(&b, &def);
  sg_project(&b, twist, &c, b.x);
  for (LitheIndex k = 0; k < b.disc->n_cells; k++) {
    LitheIndex cell[3];
    bool is_inside = true;
    double at[3], stress[6];
    lth_sparse_grid_cell(b.s->grid, b.s->cell_slot[k], cell);
    lth_sparse_grid_place(b.s->grid, cell, (const double[3]){0.3, 0.8, 0.15}, at);
    for (int a = 0; a < 3; a++) {
      double h = (def.high[a] - def.low[a]) / def.n[a];
      is_inside &= at[a] > def.low[a] + h && at[a] < def.high[a] - h;
    }
    if (!is_inside) continue;
    b.disc->table->stress(b.disc, k, b.x, at, stress);
    CHECK_NEAR(stress[5], mu * c * at[2], 1e-11 * mu);
    CHECK_NEAR(stress[4], mu * c * at[1], 1e-11 * mu);
    CHECK_NEAR(stress[3], 0, 1e-11 * mu);
    n_tested++;
  }
  assert_true(n_tested > 0);
  sg_free(&b);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(inner_rows_are_the_stencil_of_the_theory),
      cmocka_unit_test(force_is_the_gradient_of_the_energy_for_any_fractions_and_materials),
      cmocka_unit_test(rest_has_no_force_and_linearised_rotations_have_none),
      cmocka_unit_test(linear_fields_are_exact_in_and_beside_every_cell),
      cmocka_unit_test(linear_deformations_leave_no_force_inside),
      cmocka_unit_test(mass_is_that_of_the_solid_in_every_direction),
      cmocka_unit_test(a_pulled_block_has_the_stress_and_reactions_of_uniaxial_stress),
      cmocka_unit_test(a_shear_that_is_linear_along_its_edges_is_exact_inside_a_body),
      cmocka_unit_test(errors_of_the_fixed_annulus_are_those_of_the_theory),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
