/// Staggered multigrid: a symmetric definite cycle, bounded iterations, the right answer, the same bits always.
#include "disc/staggered/staggered_entries.h"
#include "disc/staggered/staggered_multigrid.h"
#include "staggered_ring.h"
#include "staggered_shape.h"

#include <string.h>

typedef struct Problem {
  LitheCtx *ctx;
  ShapeLevel shape;
  LthStaggeredMultigrid *M;
  LitheCount n;
  double *b, *w, *z;
} Problem;

static Problem problem(const ShapeDef *def, double cm) {
  Problem P = {.ctx = test_ctx()};
  P.shape = shape_level(P.ctx, def);
  P.n = 3 * P.shape.grid->n_slots;
  LthStaggeredMultigridDef d = {.level = &P.shape.level, .n_dofs = P.n};
  CHECK_OK(P.ctx, lth_staggered_multigrid_create(P.ctx, &d, &P.M));
  CHECK_OK(P.ctx, lth_staggered_multigrid_prepare(P.ctx, P.M, cm, 1));
  P.b = lth_alloc(P.ctx, P.n, sizeof *P.b);
  P.w = lth_alloc(P.ctx, P.n, sizeof *P.w);
  P.z = lth_alloc(P.ctx, P.n, sizeof *P.z);
  double volume = lth_sparse_grid_cell_volume(P.shape.grid);
  for (LitheCount s = 0; s < P.shape.grid->n_slots; s++)
    for (int a = 0; a < def->dim; a++)
      if (P.shape.level.state[a][s] == LTH_UNKNOWN_FREE)
        P.b[3 * s + a] = volume * P.shape.level.mass[a][s] * (a == 1 ? -1 : 0.3);
  return P;
}

static void problem_free(Problem *P) {
  lth_free(P->ctx, P->b);
  lth_free(P->ctx, P->w);
  lth_free(P->ctx, P->z);
  lth_staggered_multigrid_destroy(P->ctx, &P->M);
  shape_free(&P->shape);
  lithe_ctx_destroy(&P->ctx);
}

static LthSolveReport solve(Problem *P) {
  LthSolveReport report;
  memset(P->w, 0, sizeof *P->w * (size_t)P->n);
  CHECK_OK(P->ctx,
           lth_staggered_multigrid_solve(P->ctx, P->M, NULL, P->b, P->w, 1e-8, 200, &report));
  assert_true(report.converged);
  return report;
}

static double product(LitheCount n, const double *x, const double *y) {
  return lth_dot(1, n, x, y);
}

static const ShapeDef ring = {
    .dim = 2, .n = 64, .inside = ring_inside, .held = ring_held, .nu = 0.3, .rho = 1, .samples = 4};
static const ShapeDef ball = {
    .dim = 3, .n = 32, .inside = ball_inside, .held = ball_held, .nu = 0.3, .rho = 1};

static void check_symmetry(const ShapeDef *def) {
  Problem P = problem(def, 0);
  double *s = lth_alloc(P.ctx, P.n, 8), *Ms = lth_alloc(P.ctx, P.n, 8);
  uint64_t seed = 3;
  for (int trial = 0; trial < 4; trial++) {
    for (LitheCount i = 0; i < P.n; i++) {
      bool free = i % 3 < def->dim && P.shape.level.state[i % 3][i / 3] == LTH_UNKNOWN_FREE;
      P.b[i] = free ? 2 * test_random(&seed) - 1 : 0;
      s[i] = free ? 2 * test_random(&seed) - 1 : 0;
    }
    CHECK_OK(P.ctx, lth_staggered_multigrid_cycle(P.ctx, P.M, P.b, P.z));
    CHECK_OK(P.ctx, lth_staggered_multigrid_cycle(P.ctx, P.M, s, Ms));
    double scale = sqrt(product(P.n, P.b, P.z) * product(P.n, s, Ms));
    assert_true(product(P.n, P.b, P.z) > 0);
    CHECK_NEAR(product(P.n, P.b, Ms), product(P.n, s, P.z), 1e-5 * scale); // single precision
  }
  lth_free(P.ctx, s);
  lth_free(P.ctx, Ms);
  problem_free(&P);
}

static void the_cycle_is_symmetric_and_definite(void **state) {
  (void)state;
  check_symmetry(&ring);
  check_symmetry(&ball);
}

/// Iterations at sizes n, 2 n, ... are at most `bound`.
static void check_iterations(ShapeDef def, int n_sizes, const int *bound) {
  for (int i = 0; i < n_sizes; i++, def.n *= 2) {
    Problem P = problem(&def, 0);
    LthSolveReport report = solve(&P);
    if (report.iterations > bound[i])
      fail_msg("%d cells, nu = %g: %d iterations, expected at most %d", def.n, def.nu,
               report.iterations, bound[i]);
    problem_free(&P);
  }
}

/// The table of docs/theory/staggered-multigrid.md: what sweeps over blocks of unknowns need.
static void iterations_in_2d_stay_within_those_of_block_sweeps(void **state) {
  (void)state;
  ShapeDef def = ring;
  check_iterations(def, 3, (int[]){7, 9, 9});
  def.nu = 0.45;
  check_iterations(def, 3, (int[]){10, 10, 11});
  def.nu = 0.49;
  check_iterations(def, 3, (int[]){13, 14, 15});
}

static void iterations_in_3d_do_not_grow(void **state) {
  (void)state;
  ShapeDef def = ball;
  def.n = 24;
  check_iterations(def, 2, (int[]){10, 12});
}

static bool slit_inside(const double x[3]) {
  return ring_inside(x) && !(x[0] > 0.5 && fabs(x[1] - 0.5) < 0.011);
}
static bool comb_inside(const double x[3]) {
  return x[0] > 0 && x[0] < 1 && x[1] > -0.3 && x[1] < 1 &&
         (x[1] < 0.2 || fmod(x[0] * 4.5 + 1e-9, 1) < 0.5);
}
static bool comb_held(const double x[3]) { return x[1] <= 0.02; }

static void slits_and_combs_converge(void **state) {
  (void)state;
  ShapeDef def = ring;
  def.inside = slit_inside;
  check_iterations(def, 2, (int[]){16, 16});
  def.inside = comb_inside;
  def.held = comb_held;
  check_iterations(def, 2, (int[]){17, 17});
}

static double two_materials(const double x[3]) { return x[0] + 0.3 * x[1] > 0.6 ? 1e4 : 1; }

static void a_jump_of_ten_thousand_in_stiffness_converges(void **state) {
  (void)state;
  ShapeDef def = ring;
  def.young = two_materials;
  check_iterations(def, 2, (int[]){20, 20});
  def = ball;
  def.young = two_materials;
  check_iterations(def, 1, (int[]){32}); // by rigid clusters
}

static void slivers_of_a_millionth_do_no_harm(void **state) {
  (void)state;
  ShapeDef def = ring;
  def.samples = 16;
  def.least = 1e-6;
  check_iterations(def, 2, (int[]){7, 9});
}

static void inertia_costs_no_iterations(void **state) {
  (void)state;
  for (double cm = 1; cm < 1e7; cm *= 100) {
    Problem P = problem(&ball, cm);
    assert_true(solve(&P).iterations <= (cm < 1e5 ? 9 : 18)); // slivers have no mass, but stiffness
    problem_free(&P);
  }
}

/// The answer, checked row by row against the plain rows.
static void solutions_satisfy_every_row(void **state) {
  (void)state;
  Problem P = problem(&ball, 3);
  solve(&P);
  double error = 0, size = 0;
  for (int a = 0; a < 3; a++)
    for (LitheCount s = 0; s < P.shape.grid->n_slots; s++) {
      if (P.shape.level.state[a][s] != LTH_UNKNOWN_FREE) continue;
      LthStaggeredEntry entry[LTH_STAGGERED_ROW];
      int n = lth_staggered_row(&P.shape.level, 3, 1, a, s, entry);
      double r = P.b[3 * s + a];
      for (int e = 0; e < n; e++) r -= entry[e].value * P.w[3 * entry[e].slot + entry[e].b];
      error += r * r;
      size += P.b[3 * s + a] * P.b[3 * s + a];
    }
  CHECK_AT_MOST(sqrt(error / size), 1.001e-8);
  problem_free(&P);
}

/// Distance from the solution after one pass of full multigrid, over that from the solution to zero.
static void one_pass_of_full_multigrid_is_within_a_tenth(void **state) {
  (void)state;
  for (int i = 0; i < 2; i++) {
    Problem P = problem(i ? &ball : &ring, 0);
    solve(&P);
    CHECK_OK(P.ctx, lth_staggered_multigrid_full(P.ctx, P.M, P.b, P.z));
    double size = sqrt(product(P.n, P.w, P.w));
    for (LitheCount k = 0; k < P.n; k++) P.z[k] -= P.w[k];
    CHECK_AT_MOST(sqrt(product(P.n, P.z, P.z)) / size, 0.1);
    problem_free(&P);
  }
}

static void any_number_of_threads_gives_the_same_bits(void **state) {
  (void)state;
  for (int i = 0; i < 2; i++) {
    double *first = NULL;
    for (int threads = 1; threads <= 3; threads++) {
      Problem P = problem(i ? &ball : &ring, 0);
      lth_set_threads(P.ctx, threads);
      solve(&P);
      if (!first) {
        first = malloc(sizeof *first * (size_t)P.n);
        memcpy(first, P.w, sizeof *first * (size_t)P.n);
      }
      assert_memory_equal(first, P.w, sizeof *first * (size_t)P.n);
      problem_free(&P);
    }
    free(first);
  }
}

static void solves_allocate_nothing(void **state) {
  (void)state;
  Problem P = problem(&ring, 1);
  LitheCount before = lth_alloc_count(P.ctx);
  solve(&P);
  CHECK_OK(P.ctx, lth_staggered_multigrid_prepare(P.ctx, P.M, 2, 1));
  solve(&P);
  assert_int_equal(lth_alloc_count(P.ctx), before);
  problem_free(&P);
}

static bool noise_is_held(const void *self, const double x[3]) {
  (void)self;
  return x[0] < 0.6;
}
static double noise_part(const void *self, const double low[3], const double size[3]) {
  (void)self, (void)size;
  double v = sin(91 * low[0] + 57 * low[1] + 33 * low[2]);
  return 0.05 + 0.95 * v * v;
}

/// y += 7 x: a support under every function.
static void add_support(const void *self, int threads, const double *x, double *y) {
  (void)threads;
  for (LitheCount i = 0; i < *(const LitheCount *)self; i++) y[i] = 7 * x[i];
}

static void check_table(int dim) {
  const LthStaggeredHold hold = {.selects = noise_is_held, .fixed = {true, true, true}};
  SgDef def = {.dim = dim,
               .low = {0.3, -0.2, 0.1},
               .high = {2.3, 1.3, 1.9},
               .n = {21, 19, 17},
               .part = noise_part,
               .holds = &hold,
               .n_holds = 1};
  SgBody b;
  sg_create(&b, &def);
  sg_assemble(&b);
  const LthDiscSolver *solver = b.disc->table->solver;
  LitheCount n = b.disc->n_dofs;
  double *d = lth_alloc(b.ctx, n, 8);
  uint64_t seed = 23;
  for (LitheCount i = 0; i < n; i++)
    b.x[i] = b.rest[i] + (i % 3 < dim ? 2 * test_random(&seed) - 1 : 0);

  // force: with what is held
  sg_force(&b, b.x, b.f);
  solver->force(b.disc, 2, b.x, b.r);
  double stiff = sg_largest(b.K->value_off[b.K->block_off[b.K->n_rows]], b.K->values);
  for (LitheCount i = 0; i < n; i++)
    if (i % 3 < dim) CHECK_NEAR(b.r[i], b.f[i], 1e-13 * stiff);

  // diagonal, and cm M + ck K
  solver->diagonal(b.disc, 0, 1, d);
  lth_block_matrix_apply(b.K, 1, b.x, b.f);
  solver->apply(b.disc, 2, 0, 1, b.x, b.r);
  for (LitheCount i = 0; i < n; i++) {
    if (b.s->held[i]) {
      assert_true(b.r[i] == 0 && d[i] == 0);
      continue;
    }
    LitheCount e = b.K->diagonal[i / 3];
    CHECK_NEAR(d[i], b.K->values[b.K->value_off[e] + 4 * (i % 3)], 1e-14 * stiff);
    CHECK_NEAR(b.r[i], b.f[i], 1e-13 * stiff);
  }

  // a solve, plain and with something extra
  LthOperator extra = {.n = n, .apply = add_support, .self = &n};
  for (int k = 0; k < 2; k++) {
    LthSolveReport report;
    memset(b.x, 0, sizeof *b.x * (size_t)n);
    for (LitheCount i = 0; i < n; i++) b.f[i] = b.s->held[i] ? 0 : 2 * test_random(&seed) - 1;
    CHECK_OK(b.ctx, solver->prepare(b.ctx, b.disc, 2, 1));
    CHECK_OK(b.ctx,
             solver->solve(b.ctx, b.disc, k ? &extra : NULL, 1, b.f, b.x, 1e-10, 100, &report));
    assert_true(report.converged && report.residual <= 1e-10);
    solver->apply(b.disc, 1, 2, 1, b.x, b.r);
    for (LitheCount i = 0; i < n; i++)
      if (!b.s->held[i]) CHECK_NEAR(b.r[i] + (k ? 7 * b.x[i] : 0), b.f[i], 1e-10 * sqrt((double)n));
  }
  assert_true(solver->bytes(b.disc) > 0);
  lth_free(b.ctx, d);
  sg_free(&b);
}

static void the_solver_of_the_table_is_that_of_the_assembled_matrix(void **state) {
  (void)state;
  check_table(2);
  check_table(3);
}

/// The table of the theory, section 6: no more iterations than sweeps over blocks of the four unknowns around a corner count, up to
/// 512 cells, and in space, where the theory has none, than point sweeps in the plane.
static void iterations_are_no_more_than_the_theory_counts(void **state) {
  (void)state;
  static const struct {
    double nu;
    int bound[4];
  } table[] = {{0.3, {9, 10, 10, 11}}, {0.45, {11, 12, 12, 13}}, {0.49, {13, 13, 14, 15}}};
  for (size_t i = 0; i < sizeof table / sizeof *table; i++) {
    ShapeDef def = ring;
    def.n = 64;
    def.nu = table[i].nu;
    check_iterations(def, 4, table[i].bound);
  }
  ShapeDef def = ball;
  check_iterations(def, 3, (int[]){12, 13, 13});
}

int main(int argc, char **argv) {
  (void)argv;
  const struct CMUnitTest long_tests[] = {
      cmocka_unit_test(iterations_are_no_more_than_the_theory_counts),
  };
  if (argc > 1) return cmocka_run_group_tests(long_tests, NULL, NULL);
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(the_cycle_is_symmetric_and_definite),
      cmocka_unit_test(iterations_in_2d_stay_within_those_of_block_sweeps),
      cmocka_unit_test(iterations_in_3d_do_not_grow),
      cmocka_unit_test(slits_and_combs_converge),
      cmocka_unit_test(a_jump_of_ten_thousand_in_stiffness_converges),
      cmocka_unit_test(slivers_of_a_millionth_do_no_harm),
      cmocka_unit_test(inertia_costs_no_iterations),
      cmocka_unit_test(solutions_satisfy_every_row),
      cmocka_unit_test(one_pass_of_full_multigrid_is_within_a_tenth),
      cmocka_unit_test(any_number_of_threads_gives_the_same_bits),
      cmocka_unit_test(solves_allocate_nothing),
      cmocka_unit_test(the_solver_of_the_table_is_that_of_the_assembled_matrix),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
