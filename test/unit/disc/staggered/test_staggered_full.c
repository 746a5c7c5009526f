/// One pass of full multigrid leaves less than the grid does: against exact solutions of a ring that is held inside and free outside,
/// pulled by its own weight (bending) and by rotation (stretching). Plane strain, nu = 0.3.
#include "disc/staggered/staggered_multigrid.h"
#include "staggered_ring.h"

#define LAMBDA (0.3 / (1.3 * 0.4) * 1000)
#define MU (1000 / 2.6)

/// Radial and tangential displacement f cos and g sin of the angle, and their derivatives: the four that need no force, then that of
/// a force of one along x.
static void bending(int k, double r, double v[4]) {
  const double c = -(LAMBDA + MU) / (LAMBDA + 3 * MU), p = LAMBDA - MU, q = -(3 * LAMBDA + 5 * MU);
  const double part[5][4] = {{1, -1, 0, 0},
                             {p * r * r, q * r * r, 2 * p * r, 2 * q * r},
                             {1 / (r * r), 1 / (r * r), -2 / (r * r * r), -2 / (r * r * r)},
                             {log(r), c - log(r), 1 / r, -1 / r},
                             {r * r / q, 0, 2 * r / q, 0}};
  memcpy(v, part[k], sizeof part[k]);
}

/// What is zero at the inner radius (displacements) and at the outer one (stresses).
static void bending_ends(int k, double end[4]) {
  const double a = RING_INNER, b = RING_OUTER;
  double v[4];
  bending(k, a, v);
  end[0] = v[0], end[1] = v[1];
  bending(k, b, v);
  end[2] = LAMBDA * (v[2] + (v[0] + v[1]) / b) + 2 * MU * v[2];
  end[3] = MU * (v[3] - (v[1] + v[0]) / b);
}

/// Shares of the four such that both ends are zero, by elimination.
static void solve_bending(double share[4]) {
  double m[4][5], end[4];
  for (int k = 0; k < 5; k++) {
    bending_ends(k, end);
    for (int i = 0; i < 4; i++) m[i][k] = k < 4 ? end[i] : -end[i];
  }
  for (int i = 0; i < 4; i++) {
    int most = i;
    for (int r = i; r < 4; r++)
      if (fabs(m[r][i]) > fabs(m[most][i])) most = r;
    for (int c = 0; c < 5; c++) {
      double swap = m[i][c];
      m[i][c] = m[most][c], m[most][c] = swap;
    }
    for (int r = 0; r < 4; r++)
      for (int c = 4; r != i && c >= i; c--) m[r][c] -= m[r][i] / m[i][i] * m[i][c];
  }
  for (int i = 0; i < 4; i++) share[i] = m[i][4] / m[i][i];
}

static void hanging_ring(const double x[3], double u[2]) {
  double share[5], v[4], f = 0, g = 0, r = hypot(x[0], x[1]), c = x[0] / r, s = x[1] / r;
  solve_bending(share);
  share[4] = 1;
  for (int k = 0; k < 5; k++) {
    bending(k, r, v);
    f += share[k] * v[0];
    g += share[k] * v[1];
  }
  u[0] = f * c * c - g * s * s;
  u[1] = (f + g) * c * s;
}

/// A r + B / r + C r^3.
static void turning_ring(const double x[3], double u[2]) {
  const double a = RING_INNER, b = RING_OUTER, r = hypot(x[0], x[1]);
  const double C = -1 / (8 * (LAMBDA + 2 * MU));
  const double A = -(C * (4 * LAMBDA + 6 * MU) * b * b + 2 * MU * C * pow(a, 4) / (b * b)) /
                   (2 * (LAMBDA + MU) + 2 * MU * a * a / (b * b));
  const double radial = A + -(A * a * a + C * pow(a, 4)) / (r * r) + C * r * r;
  u[0] = radial * x[0];
  u[1] = radial * x[1];
}

static double place(const void *self, const double x[3], double t) {
  (void)t;
  return x[*(const int *)self];
}

/// Squares of errors: what one pass leaves of the distance from the solution on the grid, and what the grid leaves of that from the
/// exact one.
typedef struct Errors {
  double pass, grid;
} Errors;

static void add_errors(int N, bool turns, Errors *e) {
  static const int axis[2] = {0, 1};
  const LthStaggeredHold hold = {
      .selects = ring_is_inner, .fixed = {true, true, true}, .is_wall = true};
  SgDef def = ring_def(N, ring_outer_part, &hold);
  def.poisson = 0.3;
  LthLoad load = {.kind = LTH_LOAD_BODY_FORCE, .value = {lth_value_constant(1)}};
  for (int a = 0; turns && a < 2; a++) load.value[a] = (LthValue){.eval = place, .self = &axis[a]};
  SgBody b;
  LthSolveReport report;
  sg_create(&b, &def);
  const LitheCount n = b.disc->n_dofs;
  const LthDiscSolver *solver = b.disc->table->solver;
  CHECK_OK(b.ctx, lth_disc_add_load(b.ctx, b.disc, &load, 0, NULL, b.f));
  for (LitheCount i = 0; i < n; i++)
    if (!sg_is_free(&b, i)) b.f[i] = 0;
  memset(b.x, 0, sizeof *b.x * (size_t)n);
  CHECK_OK(b.ctx, solver->prepare(b.ctx, b.disc, 0, 1));
  CHECK_OK(b.ctx, solver->solve(b.ctx, b.disc, NULL, 1, b.f, b.x, 1e-11, 100, &report));
  CHECK_OK(b.ctx, lth_staggered_multigrid_full(b.ctx, b.s->solver, b.f, b.r));
  double pass = 0, grid = 0, size = 0;
  for (LitheCount i = 0; i < n; i++) {
    double at[3], exact[2];
    if (i % 3 == 2 || !sg_is_free(&b, i)) continue;
    pass += (b.r[i] - b.x[i]) * (b.r[i] - b.x[i]);
    lth_staggered_place(b.s, (LitheIndex)(i / 3), (int)(i % 3), at);
    if (hypot(at[0], at[1]) > RING_OUTER) continue;
    (turns ? turning_ring : hanging_ring)(at, exact);
    grid += (b.x[i] - exact[i % 3]) * (b.x[i] - exact[i % 3]);
    size += exact[i % 3] * exact[i % 3];
  }
  sg_free(&b);
  e->pass += pass / size;
  e->grid += grid / size;
}

/// How large the grid's error is depends on where its faces happen to lie: four grids from N to 2 N cells together.
static void check_octave(int N, bool turns) {
  Errors e = {0};
  for (int i = 0; i < 4; i++) add_errors(2 * (int)(0.5 * N * pow(2, 0.25 * i)), turns, &e);
  assert_true(e.pass < e.grid);
}

static void full_multigrid_ends_below_the_error_of_the_grid(void **state) {
  (void)state;
  for (int turns = 0; turns < 2; turns++) check_octave(128, turns);
}

static void full_multigrid_ends_below_the_error_of_fine_grids(void **state) {
  (void)state;
  for (int N = 256; N <= 1024; N *= 2)
    for (int turns = 0; turns < 2; turns++) check_octave(N, turns);
}

int main(int argc, char **argv) {
  (void)argv;
  const struct CMUnitTest long_tests[] = {
      cmocka_unit_test(full_multigrid_ends_below_the_error_of_fine_grids),
  };
  if (argc > 1) return cmocka_run_group_tests(long_tests, NULL, NULL);
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(full_multigrid_ends_below_the_error_of_the_grid),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
