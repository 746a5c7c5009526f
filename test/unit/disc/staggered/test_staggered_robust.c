/// Staggered multigrid where grids alone fail: stiff parts that float, thin shells, solids of random shape and stiffness.
/// An argument is the number of random solids (4), and more than that takes larger grids, too.
#include "disc/staggered/staggered_loose.h"
#include "disc/staggered/staggered_multigrid.h"
#include "staggered_shape.h"

#include <string.h>

static int n_random = 4;

/// Iterations to 1e-8 under a uniform force; `factored` as in LthStaggeredMultigridDef: small, so that no factor does it all.
static LthSolveReport solve(const ShapeDef *def, LitheCount factored) {
  LitheCtx *ctx = test_ctx();
  lth_set_threads(ctx, 1); // many small loops
  ShapeLevel S = shape_level(ctx, def);
  LthLoose loose;
  CHECK_OK(ctx, lth_staggered_drop_loose(ctx, &S.level, &loose)); // as bodies do
  const LitheCount n = 3 * S.grid->n_slots;
  LthStaggeredMultigrid *M;
  LthStaggeredMultigridDef d = {.level = &S.level, .n_dofs = n, .factored = factored};
  LthSolveReport report;
  double *b = lth_alloc(ctx, n, sizeof *b), *w = lth_alloc(ctx, n, sizeof *w);
  for (LitheCount s = 0; s < S.grid->n_slots; s++)
    for (int a = 0; a < def->dim; a++)
      if (S.level.state[a][s] == LTH_UNKNOWN_FREE)
        b[3 * s + a] = S.level.mass[a][s] * (a == 1 ? -1 : 0.3);
  CHECK_OK(ctx, lth_staggered_multigrid_create(ctx, &d, &M));
  CHECK_OK(ctx, lth_staggered_multigrid_prepare(ctx, M, 0, 1));
  CHECK_OK(ctx, lth_staggered_multigrid_solve(ctx, M, NULL, b, w, 1e-8, 1000, &report));
  lth_free(ctx, b);
  lth_free(ctx, w);
  lth_staggered_multigrid_destroy(ctx, &M);
  shape_free(&S);
  lithe_ctx_destroy(&ctx);
  return report;
}

static void check(const char *name, const ShapeDef *def, LitheCount factored, int bound) {
  LthSolveReport report = solve(def, factored);
  if (!report.converged || report.iterations > bound)
    fail_msg("%s, %d cells: %d iterations to %.1e, expected at most %d", name, def->n,
             report.iterations, report.residual, bound);
}

static double jump;
static bool box_inside(const double x[3]) {
  return x[0] >= 0 && x[0] <= 1 && x[1] >= 0 && x[1] <= 1 && x[2] >= 0 && x[2] <= 1;
}
static bool plate_inside(const double x[3]) {
  return x[0] >= 0 && x[0] <= 1 && x[1] >= 0 && x[1] <= 1;
}
static bool bottom_held(const double x[3]) { return x[1] <= 0.02; }
static double one_disk(const double x[3]) {
  return hypot(x[0] - 0.52, x[1] - 0.47) < 0.2 ? jump : 1;
}
static double one_hole(const double x[3]) {
  return hypot(x[0] - 0.52, x[1] - 0.47) < 0.2 ? 1 : jump;
}
static double many_disks(const double x[3]) {
  double u = fmod(4 * x[0] + 8.1, 1), v = fmod(4 * x[1] + 8.03, 1);
  return hypot(u - 0.5, v - 0.5) < 0.3 ? jump : 1;
}
static double layers(const double x[3]) { return fmod(6 * x[1] + 6, 2) < 1 ? jump : 1; }
static double one_ball(const double x[3]) { return ball_radius(x) < 0.22 ? jump : 1; }

static void stiff_parts_that_float_take_bounded_iterations(void **state) {
  (void)state;
  double (*const young[])(const double x[3]) = {one_disk, one_hole, many_disks, layers};
  for (jump = n_random > 4 ? 1e2 : 1e4; jump <= 1e4; jump *= 100)
    for (size_t i = 0; i < sizeof young / sizeof *young; i++) {
      ShapeDef def = {.dim = 2,
                      .n = n_random > 4 ? 128 : 48,
                      .inside = plate_inside,
                      .held = bottom_held,
                      .nu = 0.3,
                      .rho = 1,
                      .young = young[i]};
      check("plate", &def, 1000, 45);
    }
  jump = 1e4;
  ShapeDef def = {.dim = 3,
                  .n = n_random > 4 ? 32 : 16,
                  .inside = box_inside,
                  .held = bottom_held,
                  .nu = 0.3,
                  .rho = 1,
                  .young = one_ball};
  check("cube", &def, 1000, 45);
}

static double thickness;
static bool shell_inside(const double x[3]) {
  double r = ball_radius(x);
  return r < 0.45 && r > 0.45 - thickness;
}
static bool rim_inside(const double x[3]) {
  double r = hypot(x[0] - 0.5, x[1] - 0.5);
  return r < 0.45 && r > 0.45 - thickness;
}
static bool low_held(const double x[3]) { return x[1] < 0.1; }

/// Three cells thick at every size.
static void thin_shells_take_bounded_iterations(void **state) {
  (void)state;
  ShapeDef def = {.dim = 3, .inside = shell_inside, .held = low_held, .nu = 0.3, .rho = 1};
  for (def.n = 20; def.n <= (n_random > 4 ? 80 : 20); def.n *= 2) {
    thickness = 3.0 / def.n;
    check("shell", &def, 1000, 40);
  }
  def.dim = 2;
  def.inside = rim_inside;
  for (def.n = 64; def.n <= (n_random > 4 ? 128 : 64); def.n *= 2) {
    thickness = 3.0 / def.n;
    check("ring", &def, 100, 40);
  }
}

static uint64_t seed;
static int dimension;
static double hash_of(const double x[3], double fineness, unsigned salt) {
  uint64_t h = seed * 0x9E3779B97F4A7C15u + salt;
  for (int a = 0; a < dimension; a++)
    h = (h ^ (uint64_t)(int64_t)floor(fineness * x[a] + 1e-6)) * 0xBF58476D1CE4E5B9u, h ^= h >> 29;
  return (double)(h >> 11) / 9007199254740992.0;
}
/// A block with a cavity of random size in every cell of a lattice: all of it hangs together.
static bool random_inside(const double x[3]) {
  double r = 0;
  for (int a = 0; a < dimension; a++) {
    if (x[a] < 0.013 || x[a] > 0.987) return false;
    double offset = fmod(4 * x[a], 1) - 0.5;
    r += offset * offset;
  }
  return sqrt(r) > 0.42 * hash_of(x, 4, 1);
}
static bool random_held(const double x[3]) { return x[1] < 0.06 || hash_of(x, 5, 2) < 0.04; }
static bool random_axis(const double x[3], int a) {
  return x[1] < 0.06 || hash_of(x, 5, 3 + (unsigned)a) < 0.5;
}
static double random_young(const double x[3]) { return pow(1e4, hash_of(x, 1e4, 9)); }
static double random_pieces(const double x[3]) { return hash_of(x, 9, 10) < 0.3 ? 1e4 : 1; }

/// Stiffness from 1 to 1e4 by cell or by piece, slivers of 1e-6, holds of single components here and there.
static void random_solids_converge(void **state) {
  (void)state;
  int most[2] = {0};
  for (seed = 1; seed <= (uint64_t)n_random; seed++)
    for (dimension = 2; dimension <= 3; dimension++) {
      ShapeDef def = {.dim = dimension,
                      .n = dimension == 2 ? 32 : 8,
                      .inside = random_inside,
                      .held = random_held,
                      .axis = random_axis,
                      .young = seed % 3 == 0   ? NULL
                               : seed % 3 == 1 ? random_young
                                               : random_pieces,
                      .nu = seed % 4 == 0 ? 0.45 : 0.3,
                      .rho = 1,
                      .least = 1e-6};
      LthSolveReport report = solve(&def, 200);
      // rounding of a matrix whose entries go over 1e10 ends some at 1e-8
      if (report.residual > 1e-7)
        fail_msg("seed %d in %d dimensions: %d iterations to %.1e", (int)seed, dimension,
                 report.iterations, report.residual);
      if (report.iterations > most[dimension - 2]) most[dimension - 2] = report.iterations;
    }
  print_message("most iterations: %d in the plane, %d in space\n", most[0], most[1]);
}

int main(int argc, char **argv) {
  if (argc > 1) n_random = atoi(argv[1]);
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(stiff_parts_that_float_take_bounded_iterations),
      cmocka_unit_test(thin_shells_take_bounded_iterations),
      cmocka_unit_test(random_solids_converge),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
