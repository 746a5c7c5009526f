/// Bodies in the mixed form: one answer with the displacement form below nu = 0.5, exact solutions at it.
#include "base/archive.h"
#include "disc/staggered/staggered_mixed_state.h"
#include "staggered_ring.h"

/// Lame's ring (plane strain) and sphere, free at radius b, with u_r = A r + B / r^(dim - 1).
typedef struct Lame {
  int dim;
  double inner, outer, A, B, p, center[3];
} Lame;

static Lame lame_of(int dim, double nu, double mu) {
  Lame s = {.dim = dim, .inner = RING_INNER, .outer = RING_OUTER, .B = 0.1};
  double bulk = nu < 0.5 ? 1 / (1 - 2 * nu) : INFINITY; // of (lambda + mu) / mu in the plane
  double lambda = mu * 2 * nu / (1 - 2 * nu), bd = pow(s.outer, dim);
  if (dim == 2)
    s.A = s.B / (bulk * bd);
  else
    s.A = nu < 0.5 ? 4 * mu * s.B / ((3 * lambda + 2 * mu) * bd) : 0;
  s.p = nu < 0.5 ? lambda * dim * s.A : (dim == 2 ? 2 : 4) * mu * s.B / bd;
  for (int a = 0; a < 3; a++) s.center[a] = a < dim ? 0.01 * (a + 1) : 0;
  return s;
}

static double radius(const Lame *s, const double x[3]) {
  double sum = 0;
  for (int a = 0; a < s->dim; a++) sum += (x[a] - s->center[a]) * (x[a] - s->center[a]);
  return sqrt(sum);
}

static double displacement(const Lame *s, const double x[3], int a) {
  double r = fmax(radius(s, x), 0.5 * s->inner);
  return (x[a] - s->center[a]) * (s->A + s->B / pow(r, s->dim));
}

static double move_x(const void *self, const double x[3], double t) {
  (void)t;
  return displacement(self, x, 0);
}
static double move_y(const void *self, const double x[3], double t) {
  (void)t;
  return displacement(self, x, 1);
}
static double move_z(const void *self, const double x[3], double t) {
  (void)t;
  return displacement(self, x, 2);
}

static bool is_inner(const void *self, const double x[3]) {
  const Lame *s = self;
  return radius(s, x) <= s->inner;
}

/// Fraction of a part inside of the outer radius: exact in the plane, by 4^3 samples in space.
static double outer_part(const void *self, const double low[3], const double size[3]) {
  const Lame *s = self;
  if (s->dim == 2) {
    double at[2] = {low[0] - s->center[0], low[1] - s->center[1]};
    return fmin(1, disc_area(s->outer, at, size) / (size[0] * size[1]));
  }
  int count = 0;
  for (int k = 0; k < 64; k++) {
    double x[3];
    for (int a = 0; a < 3; a++) x[a] = low[a] + size[a] * ((k >> 2 * a & 3) + 0.5) / 4;
    count += radius(s, x) <= s->outer;
  }
  return count / 64.0;
}

typedef struct LameBody {
  Lame exact;
  LthStaggeredHold hold;
  SgBody b;
  double mu;
} LameBody;

/// `L` keeps its place.
static void lame_create(LameBody *L, int dim, int N, double nu, LthFormulation form) {
  L->mu = 1000 / (2 * (1 + nu));
  L->exact = lame_of(dim, nu, L->mu);
  L->hold = (LthStaggeredHold){.selects = is_inner,
                               .self = &L->exact,
                               .fixed = {true, true, dim == 3},
                               .value = {{.eval = move_x, .self = &L->exact},
                                         {.eval = move_y, .self = &L->exact},
                                         {.eval = move_z, .self = &L->exact}}};
  SgDef def = {.dim = dim,
               .low = {-1, -1, dim == 3 ? -1 : 0},
               .high = {1, 1, dim == 3 ? 1 : 0},
               .n = {N, N, dim == 3 ? N : 1},
               .part = outer_part,
               .part_self = &L->exact,
               .young = 1000,
               .poisson = nu,
               .formulation = form,
               .holds = &L->hold,
               .n_holds = 1};
  sg_create(&L->b, &def);
}

/// u = x - rest; freed by the caller.
static double *moved(const SgBody *b) {
  double *u = lth_alloc(b->ctx, b->disc->n_dofs, sizeof *u);
  for (LitheCount i = 0; i < b->disc->n_dofs; i++) u[i] = b->x[i] - b->rest[i];
  return u;
}

static void aim_at_rest_of(SgBody *b) {
  double *u = moved(b);
  CHECK_OK(b->ctx, b->disc->table->solver->aim(b->ctx, b->disc, u));
  lth_free(b->ctx, u);
}

/// Static equilibrium by the body's own solver; returns its iterations.
static int solve_own(SgBody *b, double tolerance) {
  const LthDiscSolver *own = b->disc->table->solver;
  LthSolveReport report;
  LitheCount n = b->disc->n_dofs;
  double *w = lth_alloc(b->ctx, n, sizeof *w);
  CHECK_OK(b->ctx, lth_staggered_prescribe(b->disc, 0, b->x));
  CHECK_OK(b->ctx, own->prepare(b->ctx, b->disc, 0, 1));
  b->disc->table->update_rotations(b->disc, b->x);
  own->force(b->disc, 1, b->x, b->r);
  for (LitheCount i = 0; i < n; i++) b->r[i] = sg_is_free(b, i) ? b->f[i] - b->r[i] : 0;
  if (own->aim) aim_at_rest_of(b);
  CHECK_OK(b->ctx, own->solve(b->ctx, b->disc, NULL, 1, b->r, w, tolerance, 100, &report));
  if (!report.converged) fail_msg("%d: residual %g", report.iterations, report.residual);
  for (LitheCount i = 0; i < n; i++) b->x[i] += w[i];
  lth_free(b->ctx, w);
  return report.iterations;
}

/// Mean |e| over free unknowns over the mean displacement.
static double lame_error(const LameBody *L) {
  const SgBody *b = &L->b;
  double sum = 0, size = 0;
  for (LitheCount k = 0; k < b->disc->n_dofs; k++) {
    double at[3];
    int a = (int)(k % 3);
    if (a >= L->exact.dim || !sg_is_free(b, k)) continue;
    lth_staggered_place(b->s, (LitheIndex)(k / 3), a, at);
    if (radius(&L->exact, at) > L->exact.outer) continue;
    double u = displacement(&L->exact, at, a);
    sum += fabs(b->x[k] - b->rest[k] - u);
    size += fabs(u);
  }
  return sum / size;
}

/// Largest V |tr e| of cells with a pressure over the largest strain, which is about B / inner^dim.
static double worst_divergence(const LameBody *L) {
  const SgBody *b = &L->b;
  double most = 0, *u = moved(b);
  for (LitheIndex c = 0; c < b->disc->n_cells; c++) {
    LitheCount slot = b->s->cell_slot[c];
    bool any = false;
    for (int a = 0; a < L->exact.dim; a++) {
      LitheCount high = lth_sparse_grid_step(b->s->grid, slot, (int[3]){a == 0, a == 1, a == 2});
      any |= sg_is_free(b, 3 * (LitheCount)b->s->func[slot] + a) ||
             sg_is_free(b, 3 * (LitheCount)b->s->func[high] + a);
    }
    const double V = lth_level_value(&b->s->level, b->s->level.volume, slot);
    if (any) most = fmax(most, V * fabs(lth_mixed_trace(b->s, slot, u)));
  }
  lth_free(b->ctx, u);
  return most * pow(L->exact.inner, L->exact.dim) / L->exact.B;
}

static void lame_free(LameBody *L) { sg_free(&L->b); }

static void below_one_half_both_forms_agree(void **state) {
  (void)state;
  const double nu[] = {0.3, 0.45, 0.4999};
  for (int i = 0; i < 3; i++) {
    LameBody D, M;
    lame_create(&D, 2, 24, nu[i], LTH_FORM_DISPLACEMENT);
    lame_create(&M, 2, 24, nu[i], LTH_FORM_MIXED);
    sg_assemble(&D.b);
    CHECK_OK(D.b.ctx, sg_solve(&D.b));
    solve_own(&M.b, 1e-11);
    assert_int_equal(M.b.disc->n_dofs, D.b.disc->n_dofs);
    // the residual's 1e-11 over the condition number in the energy's directions that matter
    for (LitheCount k = 0; k < D.b.disc->n_dofs; k++)
      CHECK_NEAR(M.b.x[k], D.b.x[k], 1e-9 * D.exact.B);
    lame_free(&D);
    lame_free(&M);
  }
}

// THEORY-STAGGERED, section 5, has the same at nu = 0.3 and 0.5: orders 1.9 and 1.8.
static void errors_in_the_plane_do_not_depend_on_poissons_ratio(void **state) {
  (void)state;
  const double nu[] = {0.3, 0.4999, 0.5};
  double error[3][2];
  for (int i = 0; i < 3; i++)
    for (int k = 0; k < 2; k++) {
      LameBody L;
      lame_create(&L, 2, 32 << k, nu[i], LTH_FORM_MIXED);
      int iterations = solve_own(&L.b, 1e-8);
      if (iterations > 14) fail_msg("nu %g: %d iterations", nu[i], iterations);
      error[i][k] = lame_error(&L);
      if (nu[i] == 0.5) assert_true(worst_divergence(&L) < 1e-7);
      lame_free(&L);
    }
  for (int i = 0; i < 3; i++) {
    assert_true(error[i][1] < error[i][0] / 3);
    assert_true(error[i][1] < 1.2 * error[0][1]);
  }
}

static void a_hollow_sphere_keeps_its_volume(void **state) {
  (void)state;
  double error[2];
  for (int k = 0; k < 2; k++) {
    LameBody L;
    lame_create(&L, 3, 12 << k, 0.5, LTH_FORM_MIXED);
    int iterations = solve_own(&L.b, 1e-8);
    if (iterations > 16) fail_msg("%d iterations", iterations);
    error[k] = lame_error(&L);
    assert_true(worst_divergence(&L) < 1e-7);
    lame_free(&L);
  }
  assert_true(error[1] < error[0] / 2.5);
}

/// A step of the augmented Lagrangian: q = lambda tr e.
static void move_pressures(SgBody *b) {
  const LthDiscVolume *volume = b->disc->table->volume;
  const LitheCount n = volume->count(b->disc);
  double *u = moved(b), *size = lth_alloc(b->ctx, n, sizeof *size),
         *lambda = lth_alloc(b->ctx, n, sizeof *lambda), *q = lth_alloc(b->ctx, n, sizeof *q);
  volume->scales(b->disc, size, lambda);
  volume->strain(b->disc, 1, u, q);
  for (LitheCount i = 0; i < n; i++) q[i] *= lambda[i];
  volume->keep(b->disc, q);
  lth_free(b->ctx, u);
  lth_free(b->ctx, size);
  lth_free(b->ctx, lambda);
  lth_free(b->ctx, q);
}

/// By the assembled matrix with pressures that follow the strains.
static void the_augmented_lagrangian_ends_at_the_same(void **state) {
  (void)state;
  LameBody A, M;
  lame_create(&A, 2, 24, 0.5, LTH_FORM_MIXED);
  lame_create(&M, 2, 24, 0.5, LTH_FORM_MIXED);
  solve_own(&M.b, 1e-11);
  CHECK_OK(A.b.ctx, A.b.disc->table->matrix_create(A.b.ctx, A.b.disc, &A.b.K));
  double last = INFINITY;
  for (int it = 0; it < 5; it++) {
    A.b.disc->table->update_rotations(A.b.disc, A.b.x);
    A.b.disc->table->assemble(A.b.disc, 0, A.b.K, A.b.f0);
    CHECK_OK(A.b.ctx, sg_solve(&A.b));
    move_pressures(&A.b);
    double most = 0;
    for (LitheCount k = 0; k < A.b.disc->n_dofs; k++) most = fmax(most, fabs(A.b.x[k] - M.b.x[k]));
    if (most > 1e-8 * A.exact.B) assert_true(most < 0.05 * last);
    last = most;
  }
  assert_true(last <= 1e-8 * A.exact.B);
  A.b.disc->table->update_rotations(A.b.disc, A.b.x);
  M.b.disc->table->update_rotations(M.b.disc, M.b.x);
  double center[3] = {0.55, 0.05, 0}, s[2][6];
  LitheIndex cell = A.b.disc->table->find_cell(A.b.disc, center, NULL);
  A.b.disc->table->stress(A.b.disc, cell, A.b.x, center, s[0]);
  M.b.disc->table->stress(M.b.disc, cell, M.b.x, center, s[1]);
  for (int k = 0; k < 6; k++) CHECK_NEAR(s[0][k], s[1][k], 1e-6 * A.exact.p);
  lame_free(&A);
  lame_free(&M);
}

/// Pressures do on displacements the work of their strains: push() is the transpose of strain().
static void pressures_push_where_strains_are(void **state) {
  (void)state;
  LameBody L;
  lame_create(&L, 3, 10, 0.5, LTH_FORM_MIXED);
  SgBody *b = &L.b;
  const LthDiscVolume *volume = b->disc->table->volume;
  const LitheCount n = volume->count(b->disc);
  double *size = lth_alloc(b->ctx, n, sizeof *size), *lambda = lth_alloc(b->ctx, n, sizeof *lambda),
         *q = lth_alloc(b->ctx, n, sizeof *q), *c = lth_alloc(b->ctx, n, sizeof *c);
  volume->scales(b->disc, size, lambda);
  for (LitheCount i = 0; i < n; i++) q[i] = sin(1.7 * (double)i);
  for (LitheCount i = 0; i < b->disc->n_dofs; i++) b->x[i] = cos(0.3 * (double)i), b->r[i] = 0;
  volume->push(b->disc, q, b->r);
  volume->strain(b->disc, 2, b->x, c);
  double by_strain = 0, by_force = 0, sum = 0;
  for (LitheCount i = 0; i < n; i++) by_strain += size[i] * q[i] * c[i];
  for (LitheCount i = 0; i < b->disc->n_dofs; i++) {
    by_force += b->r[i] * b->x[i];
    sum += fabs(b->r[i] * b->x[i]);
  }
  CHECK_NEAR(by_strain, by_force, 1e-13 * sum);
  lth_free(b->ctx, size);
  lth_free(b->ctx, lambda);
  lth_free(b->ctx, q);
  lth_free(b->ctx, c);
  lame_free(&L);
}

/// sigma_zz = p in the plane at nu = 0.5.
static void stress_is_made_of_the_pressure(void **state) {
  (void)state;
  double error[2];
  for (int k = 0; k < 2; k++) {
    LameBody L;
    lame_create(&L, 2, 32 << k, 0.5, LTH_FORM_MIXED);
    solve_own(&L.b, 1e-8);
    error[k] = 0;
    for (int i = 0; i < 12; i++) {
      double x[3] = {0.5 * cos(i), 0.5 * sin(i), 0}, stress[6];
      LitheIndex cell = L.b.disc->table->find_cell(L.b.disc, x, NULL);
      L.b.disc->table->stress(L.b.disc, cell, L.b.x, x, stress);
      error[k] = fmax(error[k], fabs(stress[2] - L.exact.p));
    }
    error[k] /= L.exact.p;
    lame_free(&L);
  }
  assert_true(error[1] < 0.03);
}

/// A step of implicit Euler from rest under a force: momentum balances, the volume stays, and the next step starts
/// from the pressure of this one.
static void a_step_in_time_keeps_the_volume(void **state) {
  (void)state;
  LameBody L;
  const double dt = 0.01;
  lame_create(&L, 2, 24, 0.5, LTH_FORM_MIXED);
  SgBody *b = &L.b;
  const LthDiscSolver *own = b->disc->table->solver;
  LitheCount n = b->disc->n_dofs;
  double *v = lth_alloc(b->ctx, n, sizeof *v), *y = lth_alloc(b->ctx, n, sizeof *y);
  b->disc->table->add_gravity(b->disc, (double[3]){0, -9.81, 0}, b->f);
  LthSolveReport report;
  for (int step = 0; step < 3; step++) {
    aim_at_rest_of(b);
    LitheCount count = lth_alloc_count(b->ctx);
    CHECK_OK(b->ctx, own->prepare(b->ctx, b->disc, 1, dt * dt));
    b->disc->table->update_rotations(b->disc, b->x);
    own->force(b->disc, 1, b->x, b->r);
    b->disc->table->apply_mass(b->disc, v, y);
    for (LitheCount i = 0; i < n; i++)
      b->r[i] = sg_is_free(b, i) ? y[i] + dt * (b->f[i] - b->r[i]) : 0;
    CHECK_OK(b->ctx, own->solve(b->ctx, b->disc, NULL, dt, b->r, v, 1e-10, 100, &report));
    assert_true(report.converged);
    if (step > 0) assert_int_equal(lth_alloc_count(b->ctx), count);
    for (LitheCount i = 0; i < n; i++) b->x[i] += dt * v[i];
    double fall = 0;
    for (LitheCount i = 1; i < n; i += 3) fall = fmax(fall, -v[i]);
    assert_true(fall > 0);
    double *u = moved(b);
    for (LitheIndex c = 0; c < b->disc->n_cells; c++)
      CHECK_NEAR(lth_mixed_trace(b->s, b->s->cell_slot[c], u), 0,
                 1e-8 * dt * fall / b->s->grid->h[0] + 1e-13);
    lth_free(b->ctx, u);
    // M (v1 - v0) = dt (f - f_int(x1)): what the next step starts from is in balance with this one
    b->disc->table->update_rotations(b->disc, b->x);
    own->force(b->disc, 1, b->x, b->f0);
    double size = sg_largest(n, b->r), worst = 0;
    double *my = lth_alloc(b->ctx, n, sizeof *my);
    b->disc->table->apply_mass(b->disc, v, my);
    for (LitheCount i = 0; i < n; i++)
      if (sg_is_free(b, i)) worst = fmax(worst, fabs(my[i] - y[i] - dt * (b->f[i] - b->f0[i])));
    lth_free(b->ctx, my);
    assert_true(worst < 1e-7 * size);
  }
  lth_free(b->ctx, v);
  lth_free(b->ctx, y);
  lame_free(&L);
}

/// Whatever the strains are that a solve has to mend, beside a held side that moves, forces balance with the pressures that it leaves.
static void pressures_balance_where_strains_were_mended(void **state) {
  (void)state;
  for (int dim = 2; dim <= 3; dim++) {
    LameBody L;
    lame_create(&L, dim, dim == 2 ? 24 : 12, 0.5, LTH_FORM_MIXED);
    SgBody *b = &L.b;
    solve_own(b, 1e-11);
    const double size = sg_largest(b->disc->n_dofs, b->r);
    b->disc->table->update_rotations(b->disc, b->x);
    b->disc->table->solver->force(b->disc, 1, b->x, b->r);
    for (LitheCount i = 0; i < b->disc->n_dofs; i++)
      if (sg_is_free(b, i)) CHECK_NEAR(b->r[i], b->f[i], 1e-8 * size);
    lame_free(&L);
  }
}

/// Without a matrix force and product are those of the matrix; and forces are slopes of the energy.
static void check_operator(double nu) {
  const double cm = 3, ck = 1.5;
  LameBody L;
  lame_create(&L, 2, 24, nu, LTH_FORM_MIXED);
  SgBody *b = &L.b;
  const LthDiscSolver *own = b->disc->table->solver;
  const LitheCount n = b->disc->n_dofs;
  double *x = lth_alloc(b->ctx, n, sizeof *x), *y = lth_alloc(b->ctx, n, sizeof *y);
  uint64_t seed = 7;
  solve_own(b, 1e-8);
  b->disc->table->update_rotations(b->disc, b->x);
  sg_assemble(b);
  for (LitheCount i = 0; i < n; i++) {
    x[i] = sg_is_free(b, i) ? test_random(&seed) - 0.5 : 0;
    b->x[i] += 0.01 * x[i];
  }
  own->apply(b->disc, 1, cm, ck, x, y);
  lth_block_matrix_apply(b->K, 1, x, b->r);
  b->disc->table->apply_mass(b->disc, x, b->f);
  const double size = sg_largest(n, y);
  for (LitheCount i = 0; i < n; i++)
    if (sg_is_free(b, i)) CHECK_NEAR(y[i], ck * b->r[i] + cm * b->f[i], 1e-12 * size);
  own->force(b->disc, 1, b->x, y);
  sg_force(b, b->x, b->r);
  double slope = 0, energy[2];
  for (LitheCount i = 0; i < n; i++) {
    if (sg_is_free(b, i)) CHECK_NEAR(y[i], b->r[i], 1e-11 * size);
    slope += y[i] * x[i];
  }
  for (int k = 0; k < 2; k++) {
    for (LitheCount i = 0; i < n; i++) b->f[i] = b->x[i] + (k ? 0.01 : -0.01) * x[i];
    energy[k] = b->disc->table->energy(b->disc, 0, b->f);
  }
  CHECK_NEAR((energy[1] - energy[0]) / 0.02, slope, 1e-9 * fabs(slope));
  lth_free(b->ctx, x);
  lth_free(b->ctx, y);
  lame_free(&L);
}

static void forces_are_those_of_the_matrix_and_slopes_of_the_energy(void **state) {
  (void)state;
  check_operator(0.4999);
  check_operator(0.5);
}

/// A square of (-1, 1)^dim that is held beyond a cell of its boundary, but for one side, or all around (-1).
typedef struct Tray {
  int dim, open;
} Tray;

static bool is_rim(const void *self, const double x[3]) {
  const Tray *t = self;
  bool any = false;
  for (int a = 0; a < t->dim; a++)
    for (int high = 0; high < 2; high++)
      any |= 2 * a + high != t->open && (high ? x[a] > 0.8 : x[a] < -0.8);
  return any;
}

static void tray_create(SgBody *b, Tray *t, LthStaggeredHold *hold) {
  *hold = (LthStaggeredHold){.selects = is_rim, .self = t, .fixed = {true, true, t->dim == 3}};
  SgDef def = {.dim = t->dim,
               .low = {-1, -1, t->dim == 3 ? -1 : 0},
               .high = {1, 1, t->dim == 3 ? 1 : 0},
               .n = {8, 8, t->dim == 3 ? 8 : 1},
               .part = sg_full,
               .poisson = 0.5,
               .formulation = LTH_FORM_MIXED,
               .holds = hold,
               .n_holds = 1};
  sg_create(b, &def);
}

/// Without divergence but on a grid, where cubes are not told from their secants.
static void curved(const void *self, const double x[3], double value[3]) {
  (void)self;
  value[0] = x[0] * x[0] * x[0];
  value[1] = -3 * x[0] * x[0] * x[1];
  value[2] = 0;
}

static void wider(const void *self, const double x[3], double value[3]) {
  (void)self;
  value[0] = x[0];
  value[1] = value[2] = 0;
}

/// A field's changes of volume, and what is admitted of them.
static LitheStatus admit(SgBody *b, void (*field)(const void *, const double[3], double[3]),
                         double *before, double *c) {
  const LthDiscVolume *volume = b->disc->table->volume;
  sg_project(b, field, NULL, b->f);
  volume->strain(b->disc, 1, b->f, before);
  memcpy(c, before, sizeof *c * (size_t)volume->count(b->disc));
  return volume->admit(b->ctx, b->disc, b->f, c);
}

static void parts_that_are_held_all_around_keep_their_volume(void **state) {
  (void)state;
  for (int dim = 2; dim <= 3; dim++) {
    Tray tray = {.dim = dim, .open = -1};
    LthStaggeredHold hold;
    SgBody b;
    tray_create(&b, &tray, &hold);
    const LthDiscVolume *volume = b.disc->table->volume;
    const LitheCount n = volume->count(b.disc);
    double *c = lth_alloc(b.ctx, n, sizeof *c), *before = lth_alloc(b.ctx, n, sizeof *before);
    CHECK_OK(b.ctx, admit(&b, curved, before, c));
    double left = 0, taken = before[0] - c[0];
    for (LitheCount i = 0; i < n; i++) {
      CHECK_NEAR(before[i] - c[i], taken, 1e-13);
      left += c[i];
    }
    assert_true(fabs(taken) > 1e-3);
    CHECK_NEAR(left, 0, 1e-13 * (double)n);
    assert_int_equal(admit(&b, wider, before, c), LITHE_BAD_INPUT);
    for (LitheCount i = 0; i < n; i++) c[i] = 1 + cos((double)i);
    volume->keep(b.disc, c);
    double mean = 0;
    for (LitheCount s = 0; s < b.s->grid->n_slots; s++)
      mean += lth_level_value(&b.s->level, b.s->level.volume, s) * lth_mixed_pressure(b.s, s);
    CHECK_NEAR(mean, 0, 1e-12 * (double)n);
    lth_free(b.ctx, c);
    lth_free(b.ctx, before);
    sg_free(&b);
  }
}

static void one_side_that_is_free_lets_volumes_change(void **state) {
  (void)state;
  for (int side = 0; side < 6; side++) {
    Tray tray = {.dim = 3, .open = side};
    LthStaggeredHold hold;
    SgBody b;
    tray_create(&b, &tray, &hold);
    const LitheCount n = b.disc->table->volume->count(b.disc);
    double *c = lth_alloc(b.ctx, n, sizeof *c), *before = lth_alloc(b.ctx, n, sizeof *before);
    CHECK_OK(b.ctx, admit(&b, wider, before, c));
    assert_memory_equal(before, c, sizeof *c * (size_t)n);
    lth_free(b.ctx, c);
    lth_free(b.ctx, before);
    sg_free(&b);
  }
}

static void pressures_go_into_checkpoints(void **state) {
  (void)state;
  LameBody A, B;
  lame_create(&A, 2, 16, 0.5, LTH_FORM_MIXED);
  lame_create(&B, 2, 16, 0.5, LTH_FORM_MIXED);
  solve_own(&A.b, 1e-8);
  A.b.disc->table->update_rotations(A.b.disc, A.b.x);
  LthArchive out = {0}, in = {0};
  lth_archive_begin(&out, A.b.ctx);
  A.b.disc->table->archive(A.b.disc, &out);
  assert_int_equal(out.status, LITHE_OK);
  lth_archive_open(&in, B.b.ctx, out.data, out.size);
  B.b.disc->table->archive(B.b.disc, &in);
  assert_int_equal(in.status, LITHE_OK);
  LitheIndex cell = A.b.disc->n_cells / 2;
  LitheCount slot = A.b.s->cell_slot[cell];
  assert_true(lth_mixed_pressure(A.b.s, slot) != 0);
  assert_true(lth_mixed_pressure(B.b.s, slot) == lth_mixed_pressure(A.b.s, slot));
  lth_archive_free(A.b.ctx, &out);
  lame_free(&A);
  lame_free(&B);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(below_one_half_both_forms_agree),
      cmocka_unit_test(errors_in_the_plane_do_not_depend_on_poissons_ratio),
      cmocka_unit_test(a_hollow_sphere_keeps_its_volume),
      cmocka_unit_test(the_augmented_lagrangian_ends_at_the_same),
      cmocka_unit_test(pressures_push_where_strains_are),
      cmocka_unit_test(stress_is_made_of_the_pressure),
      cmocka_unit_test(a_step_in_time_keeps_the_volume),
      cmocka_unit_test(pressures_balance_where_strains_were_mended),
      cmocka_unit_test(forces_are_those_of_the_matrix_and_slopes_of_the_energy),
      cmocka_unit_test(parts_that_are_held_all_around_keep_their_volume),
      cmocka_unit_test(one_side_that_is_free_lets_volumes_change),
      cmocka_unit_test(pressures_go_into_checkpoints),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
