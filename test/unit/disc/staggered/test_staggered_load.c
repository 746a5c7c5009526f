/// Loads on staggered bodies: balance with linear deformations, totals, and the errors of tables 5.1 of the theory.
#include "staggered_ring.h"

static const LthShape ball = {.kind = LTH_SHAPE_SPHERE, .a = {0.03, -0.02, 0.05}, .radius = 0.7};
static const LthShape box = {
    .kind = LTH_SHAPE_BOX, .a = {-0.61, -0.5, -0.44}, .b = {0.6, 0.53, 0.57}};

static SgDef shape_def(const LthShape *shape, int dim, int n) {
  return (SgDef){.dim = dim,
                 .low = {-1, -0.9, -0.95},
                 .high = {1, 0.9, 0.95},
                 .n = {n, n + 1, n + 2},
                 .shape = shape,
                 .method = {LTH_FRACTIONS_SAMPLES, 8, 0}};
}

static void affine(const void *self, const double x[3], double value[3]) {
  lth_m3_apply(self, x, value);
}

static void set_stress(const SgBody *b, const double A[9], LthLoad *load) {
  double lambda, mu, trace = -b->s->dim;
  lth_lame(1000, 0.3, &lambda, &mu);
  for (int a = 0; a < b->s->dim; a++) trace += A[4 * a];
  for (int i = 0; i < 9; i++) {
    int a = i / 3, c = i % 3;
    double strain = 0.5 * (A[i] + A[3 * c + a]) - (a == c);
    load->stress[i] = lth_value_constant(2 * mu * strain + (a == c ? lambda * trace : 0));
  }
}

static void check_balance(const LthShape *shape, int dim, LthFractionDef method) {
  double A[9] = {1.1, 0.3, -0.2, 0.15, 0.9, 0.4, -0.1, 0.2, 1.07};
  SgBody b;
  SgDef def = shape_def(shape, dim, dim == 2 ? 17 : 11);
  LthLoad load = {.kind = LTH_LOAD_STRESS};
  def.method = method;
  if (dim == 2) A[2] = A[5] = A[6] = A[7] = 0, A[8] = 1;
  sg_create(&b, &def);
  sg_assemble(&b);
  set_stress(&b, A, &load);
  sg_project(&b, affine, A, b.x);
  sg_force(&b, b.x, b.r);
  CHECK_OK(b.ctx, lth_disc_add_load(b.ctx, b.disc, &load, 0, NULL, b.f));
  double stiff = sg_largest(b.K->value_off[b.K->block_off[b.K->n_rows]], b.K->values);
  for (LitheCount k = 0; k < b.disc->n_dofs; k++) CHECK_NEAR(b.r[k], b.f[k], 1e-14 * stiff);
  sg_free(&b);
}

static void constant_stress_is_balanced_on_every_unknown_of_cut_bodies(void **state) {
  (void)state;
  for (int dim = 2; dim <= 3; dim++) {
    check_balance(&ball, dim, (LthFractionDef){LTH_FRACTIONS_SAMPLES, 4, 0});
    check_balance(&ball, dim, (LthFractionDef){LTH_FRACTIONS_SMOOTH, 0, 1.2});
    check_balance(&box, dim, (LthFractionDef){LTH_FRACTIONS_SAMPLES, 8, 0});
  }
}

static void uniform_pressure_is_a_uniform_stress(void **state) {
  (void)state;
  for (int dim = 2; dim <= 3; dim++) {
    SgBody b;
    SgDef def = shape_def(&ball, dim, 11);
    LthLoad pressure = {.kind = LTH_LOAD_PRESSURE, .value = {lth_value_constant(7)}};
    LthLoad stress = {.kind = LTH_LOAD_STRESS};
    for (int a = 0; a < 3; a++) stress.stress[4 * a] = lth_value_constant(7);
    sg_create(&b, &def);
    CHECK_OK(b.ctx, lth_disc_add_load(b.ctx, b.disc, &pressure, 0, NULL, b.f));
    double most = sg_largest(b.disc->n_dofs, b.f);
    CHECK_OK(b.ctx, lth_disc_add_load(b.ctx, b.disc, &stress, 0, NULL, b.f));
    CHECK_AT_MOST(sg_largest(b.disc->n_dofs, b.f), 1e-15 * most);
    // a pressure that follows sees the area of a body that has grown by 1.2: 1.2^(dim - 1)
    pressure.follower = true;
    double grow[9] = {1.2, 0, 0, 0, 1.2, 0, 0, 0, 1.2};
    sg_project(&b, affine, grow, b.x);
    CHECK_OK(b.ctx, lth_disc_add_load(b.ctx, b.disc, &stress, 0, NULL, b.r));
    memset(b.f, 0, sizeof *b.f * (size_t)b.disc->n_dofs);
    CHECK_OK(b.ctx, lth_disc_add_load(b.ctx, b.disc, &pressure, 0, b.x, b.f));
    for (LitheCount k = 0; k < b.disc->n_dofs; k++)
      CHECK_NEAR(b.f[k], -pow(1.2, dim - 1) * b.r[k], 1e-13 * most);
    sg_free(&b);
  }
}

/// Force and moment (about the origin) of nodal forces.
static void totals(const SgBody *b, double force[3], double moment[3]) {
  for (int a = 0; a < 3; a++) force[a] = moment[a] = 0;
  for (LitheCount k = 0; k < b->disc->n_dofs; k++) {
    double at[3], f[3] = {0}, m[3];
    lth_staggered_place(b->s, (LitheIndex)(k / 3), (int)(k % 3), at);
    f[k % 3] = b->f[k];
    lth_v3_cross(at, f, m);
    lth_v3_add(force, f, force);
    lth_v3_add(moment, m, moment);
  }
}

static bool is_right(const void *self, const double point[3], const double normal[3]) {
  (void)self, (void)point;
  return normal[0] > 0.5;
}

static void total_forces_and_tractions_add_up(void **state) {
  (void)state;
  const double F[3] = {3, -2, 5};
  for (int dim = 2; dim <= 3; dim++)
    for (int round = 0; round < 2; round++) {
      SgBody b;
      SgDef def = shape_def(round ? &ball : &box, dim, 15);
      LthLoad load = {.kind = LTH_LOAD_TOTAL_FORCE, .selects = is_right};
      double force[3], moment[3];
      for (int a = 0; a < 3; a++) load.value[a] = lth_value_constant(F[a]);
      sg_create(&b, &def);
      CHECK_OK(b.ctx, lth_disc_add_load(b.ctx, b.disc, &load, 0, NULL, b.f));
      totals(&b, force, moment);
      for (int a = 0; a < dim; a++) CHECK_NEAR(force[a], F[a], 1e-13);
      // it acts at the middle of the side: (0.6, 0.015, 0.065), or of the ball's right part
      double arm[3] = {0.6, 0.015, 0.065}, want[3], cell = 0.14;
      if (round == 0) {
        lth_v3_cross(arm, F, want);
        for (int a = dim == 2 ? 2 : 0; a < 3; a++) CHECK_NEAR(moment[a], want[a], 5 * cell);
      }
      load.kind = LTH_LOAD_TRACTION;
      memset(b.f, 0, sizeof *b.f * (size_t)b.disc->n_dofs);
      CHECK_OK(b.ctx, lth_disc_add_load(b.ctx, b.disc, &load, 0, NULL, b.f));
      totals(&b, force, moment);
      // side of the box, cap of the ball within 60 degrees of x; half a cell along the rim is not certain
      double area = dim == 2 ? 1.03 : 1.03 * 1.01, rim = dim == 2 ? 2 : 2 * 1.03 + 2 * 1.01;
      if (round) area = dim == 2 ? 0.7 * 2 * M_PI / 3 : 2 * M_PI * 0.49 * 0.5;
      if (round && dim == 3) rim = 2 * M_PI * 0.7 * sqrt(0.75);
      for (int a = 0; a < dim; a++)
        CHECK_NEAR(force[a], F[a] * area, fabs(F[a]) * rim * 0.5 * cell);
      sg_free(&b);
    }
}

static double parabola(const void *self, const double x[3], double t) {
  (void)self, (void)t;
  return x[1] * x[1] - 1;
}

/// A parabola of shear on the end of a beam, as shear samples there without stiffness pass it on.
static void shear_on_an_end_acts_at_the_end(void **state) {
  (void)state;
  for (int n = 8; n <= 32; n *= 2) {
    const LthShape beam = {.kind = LTH_SHAPE_BOX, .a = {-2, -1, 0}, .b = {2, 1, 0}};
    double force[3], moment[3], h = 2.0 / n, total = -4. / 3;
    SgBody b;
    SgDef def = {
        .dim = 2, .low = {-2, -1, 0}, .high = {2, 1, 0}, .n = {2 * n, n, 1}, .shape = &beam};
    LthLoad load = {.kind = LTH_LOAD_TRACTION, .selects = is_right, .value[1].eval = parabola};
    sg_create(&b, &def);
    CHECK_OK(b.ctx, lth_disc_add_load(b.ctx, b.disc, &load, 0, NULL, b.f));
    totals(&b, force, moment);
    CHECK_NEAR(force[1], total,
               0.5 * h * h); // the midpoint rule is off by 1/3 h^2, the trapezoidal one by 2/3
    CHECK_NEAR(moment[2], 2 * total, 2 * h * h);
    sg_free(&b);
  }
}

static bool is_nothing(const void *self, const double point[3], const double normal[3]) {
  (void)self, (void)point, (void)normal;
  return false;
}

static void loads_that_select_nothing_are_refused(void **state) {
  (void)state;
  SgBody b;
  SgDef def = shape_def(&ball, 2, 9);
  LthLoad load = {.kind = LTH_LOAD_TRACTION, .selects = is_nothing};
  sg_create(&b, &def);
  assert_int_equal(lth_disc_add_load(b.ctx, b.disc, &load, 0, NULL, b.f), LITHE_BAD_INPUT);
  sg_free(&b);
}

/// --- the annulus with a traction outside ---

typedef struct Material {
  double lambda, mu;
} Material;

/// P_ab of the solution: 2 mu (phi_a,b sym - delta) + lambda (tr - 2) delta; div phi = 0.
static double stress_of(const Material *m, const double x[3], int a, int b) {
  double c = 2 * M_PI, cx = cos(c * x[0]), sx = sin(c * x[0]), cy = cos(c * x[1]),
         sy = sin(c * x[1]);
  double grad[4] = {-c * sx * cy, -c * cx * sy, c * cx * sy, c * sx * cy};
  double trace = grad[0] + grad[3] - 2;
  return m->mu * (grad[2 * a + b] + grad[2 * b + a] - 2 * (a == b)) +
         (a == b ? m->lambda * trace : 0);
}

static double p11(const void *self, const double x[3], double t) {
  (void)t;
  return stress_of(self, x, 0, 0);
}
static double p12(const void *self, const double x[3], double t) {
  (void)t;
  return stress_of(self, x, 0, 1);
}
static double p22(const void *self, const double x[3], double t) {
  (void)t;
  return stress_of(self, x, 1, 1);
}

/// Traction by the stress at the nearest point of the shape, or without one at the unknowns.
static RingError pulled_ring(int N, const LthShape *shape) {
  SgBody b;
  Material m;
  LthStaggeredHold hold = ring_hold(ring_is_inner, NULL);
  SgDef def = ring_def(N, ring_outer_part, &hold);
  def.shape = shape;
  lth_lame(def.young, def.poisson, &m.lambda, &m.mu);
  LthLoad body = {
      .kind = LTH_LOAD_BODY_FORCE,
      .value = {{.eval = ring_force_x, .self = &m.mu}, {.eval = ring_force_y, .self = &m.mu}}};
  LthLoad stress = {.kind = LTH_LOAD_STRESS};
  stress.stress[0] = (LthValue){.eval = p11, .self = &m};
  stress.stress[1] = stress.stress[3] = (LthValue){.eval = p12, .self = &m};
  stress.stress[4] = (LthValue){.eval = p22, .self = &m};
  sg_create(&b, &def);
  sg_assemble(&b);
  CHECK_OK(b.ctx, lth_disc_add_load(b.ctx, b.disc, &body, 0, NULL, b.f));
  CHECK_OK(b.ctx, lth_disc_add_load(b.ctx, b.disc, &stress, 0, NULL, b.f));
  CHECK_OK(b.ctx, sg_solve(&b));
  RingError e = ring_error(&b);
  sg_free(&b);
  return e;
}

static void errors_of_the_pulled_annulus_are_those_of_the_theory(void **state) {
  (void)state;
  const LthShape outer = {.kind = LTH_SHAPE_SPHERE, .radius = RING_OUTER};
  const struct {
    int N;
    double a1, a, b1, b;
  } table[] = {{32, 2.22e-2, 2.23e-2, 1.65e-2, 1.55e-2}, {48, 1.16e-2, 1.06e-2, 6.14e-3, 7.69e-3},
               {64, 5.33e-3, 6.24e-3, 4.54e-3, 4.90e-3}, {80, 4.03e-3, 4.30e-3, 2.08e-3, 2.68e-3},
               {96, 2.45e-3, 2.47e-3, 1.76e-3, 1.76e-3}, {112, 1.80e-3, 2.13e-3, 1.36e-3, 1.42e-3},
               {128, 1.54e-3, 1.68e-3, 8.38e-4, 1.19e-3}};
  for (int i = 0; i < 7; i++) {
    RingError a = pulled_ring(table[i].N, NULL), b = pulled_ring(table[i].N, &outer);
    CHECK_NEAR(a.l1, table[i].a1, 0.004 * a.l1); // three digits
    CHECK_NEAR(a.linf, table[i].a, 0.004 * a.linf);
    CHECK_NEAR(b.l1, table[i].b1, 0.004 * b.l1);
    CHECK_NEAR(b.linf, table[i].b, 0.004 * b.linf);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(constant_stress_is_balanced_on_every_unknown_of_cut_bodies),
      cmocka_unit_test(uniform_pressure_is_a_uniform_stress),
      cmocka_unit_test(total_forces_and_tractions_add_up),
      cmocka_unit_test(shear_on_an_end_acts_at_the_end),
      cmocka_unit_test(loads_that_select_nothing_are_refused),
      cmocka_unit_test(errors_of_the_pulled_annulus_are_those_of_the_theory),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
