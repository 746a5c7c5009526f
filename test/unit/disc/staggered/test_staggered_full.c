/// One pass of full multigrid leaves less than the grid does, for the work of less than 20 applications of the operator, or 50 near
/// nu = 1/2: against exact solutions of a ring (in space a shell) that is held inside and free outside, pulled by its own weight
/// (bending) and by rotation (stretching); in the plane plane strain.
#include "disc/staggered/staggered_multigrid.h"
#include "staggered_ring.h"

typedef struct Solid {
  int dim;
  double nu, lambda, mu;
} Solid;

static Solid solid_of(int dim, double nu) {
  Solid s = {.dim = dim, .nu = nu};
  lth_lame(1000, nu, &s.lambda, &s.mu);
  return s;
}

/// u = a(r) e + b(r) x (x . e) with e along x: the four that need no force - translation, the quadratic one, the dipole and
/// Kelvin's - then one for a force of e. v: a, b and their derivatives.
static void bending(const Solid *s, int k, double r, double v[4]) {
  const int d = s->dim;
  const double both = s->lambda + s->mu, c = (s->lambda + 3 * s->mu) / both;
  const double turn = -(2 * d * s->mu + 2 * both) / (2 * s->mu + both * (d + 1));
  const double push = -1 / (2 * d * s->mu + 2 * both);
  const double part[5][4] = {
      {1, 0, 0, 0},
      {r * r, turn, 2 * r, 0},
      {-pow(r, -d), d * pow(r, -d - 2), d * pow(r, -d - 1), -d * (d + 2) * pow(r, -d - 3)},
      {d == 3 ? c / r : -c * log(r), pow(r, -d), -c * pow(r, 1 - d), -d * pow(r, -d - 1)},
      {push * r * r, 0, 2 * push * r, 0}};
  memcpy(v, part[k], sizeof part[k]);
}

/// What is zero at the inner radius (a and b) and at the outer one (the traction's parts along e and along the normal).
static void bending_ends(const Solid *s, int k, double end[4]) {
  const double r = RING_OUTER;
  double v[4];
  bending(s, k, RING_INNER, v);
  end[0] = v[0], end[1] = v[1];
  bending(s, k, r, v);
  end[2] = s->mu * (v[2] + v[1] * r);
  end[3] = s->lambda * (v[2] / r + v[3] * r + (s->dim + 1) * v[1]) +
           s->mu * (2 * v[3] * r + 3 * v[1] + v[2] / r);
}

/// Shares of the four such that both ends are zero, by elimination.
static void solve_bending(const Solid *s, double share[4]) {
  double m[4][5], end[4];
  for (int k = 0; k < 5; k++) {
    bending_ends(s, k, end);
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

static void hanging(const Solid *s, const double x[3], double u[3]) {
  double share[5], v[4], a = 0, b = 0;
  solve_bending(s, share);
  share[4] = 1;
  for (int k = 0; k < 5; k++) {
    bending(s, k, lth_v3_norm(x), v);
    a += share[k] * v[0];
    b += share[k] * v[1];
  }
  for (int i = 0; i < 3; i++) u[i] = b * x[0] * x[i] + (i == 0 ? a : 0);
}

/// A r + B r^(1 - d) + C r^3 along x, for a force of x.
static void turning(const Solid *s, const double x[3], double u[3]) {
  const int d = s->dim;
  const double r = lth_v3_norm(x), inner = RING_INNER * RING_INNER, outer = RING_OUTER * RING_OUTER;
  const double shear = 2 * (d - 1) * s->mu * pow(RING_INNER / RING_OUTER, d);
  const double C = -1 / ((2 * d + 4) * (s->lambda + 2 * s->mu));
  const double A = -(C * outer * ((d + 2) * s->lambda + 6 * s->mu) + shear * C * inner) /
                   (d * s->lambda + 2 * s->mu + shear);
  const double B = -pow(RING_INNER, d) * (A + C * inner);
  for (int i = 0; i < 3; i++) u[i] = (A + B * pow(r, -d) + C * r * r) * x[i];
}

static double place(const void *self, const double x[3], double t) {
  (void)t;
  return x[*(const int *)self];
}

static bool is_in_core(const void *self, const double x[3]) {
  (void)self;
  return lth_v3_norm(x) <= RING_INNER;
}

/// Squares of errors: what one pass leaves of the distance from the solution on the grid, and what the grid leaves of that from the
/// exact one.
typedef struct Errors {
  double pass, grid, work; ///< work: of the pass, in applications of the operator
} Errors;

static void measure(const Solid *s, const SgBody *b, bool turns, Errors *e) {
  double pass = 0, grid = 0, size = 0;
  for (LitheCount i = 0; i < b->disc->n_dofs; i++) {
    double at[3], exact[3];
    if (i % 3 >= s->dim || !sg_is_free(b, i)) continue;
    pass += (b->r[i] - b->x[i]) * (b->r[i] - b->x[i]);
    lth_staggered_place(b->s, (LitheIndex)(i / 3), (int)(i % 3), at);
    if (s->dim == 2) at[2] = 0;
    if (lth_v3_norm(at) > RING_OUTER) continue;
    (turns ? turning : hanging)(s, at, exact);
    grid += (b->x[i] - exact[i % 3]) * (b->x[i] - exact[i % 3]);
    size += exact[i % 3] * exact[i % 3];
  }
  e->pass += pass / size;
  e->grid += grid / size;
}

static void add_errors(const Solid *s, int N, bool turns, Errors *e) {
  static const int axis[3] = {0, 1, 2};
  static const LthShape ball = {.kind = LTH_SHAPE_SPHERE, .radius = RING_OUTER};
  const LthStaggeredHold hold = {
      .selects = is_in_core, .fixed = {true, true, true}, .is_wall = true};
  SgDef def = ring_def(N, ring_outer_part, &hold);
  def.poisson = s->nu;
  def.formulation = LTH_FORM_DISPLACEMENT;
  if (s->dim == 3) {
    def.dim = 3, def.n[2] = N, def.low[2] = -1, def.high[2] = 1;
    def.part = NULL, def.shape = &ball, def.method.method = LTH_FRACTIONS_EXACT;
  }
  LthLoad load = {.kind = LTH_LOAD_BODY_FORCE, .value = {lth_value_constant(1)}};
  for (int a = 0; turns && a < s->dim; a++)
    load.value[a] = (LthValue){.eval = place, .self = &axis[a]};
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
  double seconds;
  CHECK_OK(b.ctx,
           lth_staggered_multigrid_time_full(b.ctx, b.s->solver, b.f, 1, &seconds, &e->work));
  measure(s, &b, turns, e);
  sg_free(&b);
}

/// How large the grid's error is depends on where its faces happen to lie: four grids from N to 2 N cells together.
static void check_octave(int dim, double nu, int N) {
  const Solid solid = solid_of(dim, nu);
  const bool near = nu > 0.4;
  for (int turns = 0; turns < 2; turns++) {
    Errors e = {0};
    for (int i = 0; i < 4; i++)
      add_errors(&solid, 2 * (int)(0.5 * N * pow(2, 0.25 * i)), turns, &e);
    print_message("%dD, nu %g, %s, from %d cells: one pass %.1e, the grid %.1e, work %.1f\n", dim,
                  nu, turns ? "turning" : "hanging", N, sqrt(e.pass / 4), sqrt(e.grid / 4), e.work);
    assert_true(e.pass < e.grid);
    assert_true(e.work < (near ? 50 : 20));
  }
}

static void full_multigrid_ends_below_the_error_of_the_grid(void **state) {
  (void)state;
  check_octave(2, 0.3, 128);
  check_octave(2, 0.49, 128);
}

static void full_multigrid_ends_below_the_error_of_fine_grids(void **state) {
  (void)state;
  for (int near = 0; near < 2; near++) {
    for (int N = 256; N <= 1024; N *= 2) check_octave(2, near ? 0.49 : 0.3, N);
    check_octave(3, near ? 0.49 : 0.3, 64); // of fewer, the shell is some cells thick
  }
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
