/// The exact solutions of the thesis' studies, checked by differentiation alone: equilibrium inside, traction on the
/// boundary that is not held, the printed stress.
#include "check.h"
#include "scene/expression.h"
#include "study/dolny.h"

#include <string.h>

static LitheCtx *ctx;
static LthStudyRun run;

/// Expressions of a case, compiled.
typedef struct Field {
  LthExpression *u[2], *stress[4], *force[2];
  double mu, lambda;
} Field;

static LthExpression *compile(const char *text) {
  LthExpression *e = NULL;
  LthExpressionError error = {0};
  if (!text) return NULL;
  if (lth_expression_create(ctx, text, strlen(text), &error, &e) != LITHE_OK)
    fail_msg("%s: column %d: %s", text, error.column, error.text);
  return e;
}

static Field open_field(const LthExactCase *c) {
  Field f = {.mu = c->young / (2 * (1 + c->poisson)),
             .lambda = c->young * c->poisson / ((1 + c->poisson) * (1 - 2 * c->poisson))};
  for (int a = 0; a < 2; a++) {
    f.u[a] = compile(c->displacement[a]);
    f.force[a] = compile(c->body_force[a]);
  }
  for (int k = 0; k < 4; k++) f.stress[k] = compile(c->stress[k]);
  return f;
}

static void close_field(Field *f) {
  for (int a = 0; a < 2; a++) {
    lth_expression_destroy(ctx, &f->u[a]);
    if (f->force[a]) lth_expression_destroy(ctx, &f->force[a]);
  }
  for (int k = 0; k < 4; k++)
    if (f->stress[k]) lth_expression_destroy(ctx, &f->stress[k]);
}

#define STEP                                                                                       \
  2e-3 // [m] of sixth-order differences: rounding 1e-16 / STEP^2 = 3e-11, and truncation below it

static double at(const LthExpression *e, double x, double y) {
  return e ? lth_expression_eval(e, (double[]){x, y, 0}, 0) : 0;
}

/// Derivative of a function of place along axis b.
static double slope(double (*f)(const Field *, int, double, double), const Field *field, int k,
                    double x, double y, int b) {
  static const double weight[3] = {45. / 60, -9. / 60, 1. / 60};
  double sum = 0;
  for (int i = 1; i <= 3; i++) {
    double dx = b == 0 ? i * STEP : 0, dy = b == 1 ? i * STEP : 0;
    sum += weight[i - 1] * (f(field, k, x + dx, y + dy) - f(field, k, x - dx, y - dy));
  }
  return sum / STEP;
}

static double displacement(const Field *f, int a, double x, double y) { return at(f->u[a], x, y); }

/// Stress entry k of xx xy yx yy, from the displacement.
static double stress(const Field *f, int k, double x, double y) {
  double g[2][2];
  for (int a = 0; a < 2; a++)
    for (int b = 0; b < 2; b++) g[a][b] = slope(displacement, f, a, x, y, b);
  int a = k / 2, b = k % 2;
  return f->mu * (g[a][b] + g[b][a]) + (a == b ? f->lambda * (g[0][0] + g[1][1]) : 0);
}

/// Largest residual of div P + b over places in the ring between radii r0 and r1, over the size of the stress.
static double largest_residual(const Field *f, double r0, double r1) {
  double worst = 0, scale = 0;
  for (int i = 0; i < 60; i++) {
    double r = r0 + (r1 - r0) * (i % 6) / 5, angle = 0.1 + i * 0.77;
    double x = r * cos(angle), y = r * sin(angle);
    for (int a = 0; a < 2; a++) {
      double sum = at(f->force[a], x, y);
      for (int b = 0; b < 2; b++) sum += slope(stress, f, 2 * a + b, x, y, b);
      worst = fmax(worst, fabs(sum));
    }
    for (int k = 0; k < 4; k++) scale = fmax(scale, fabs(stress(f, k, x, y)));
  }
  return worst / scale;
}

/// Largest traction over the largest stress on a circle.
static double largest_traction(const Field *f, double cx, double cy, double r) {
  double worst = 0, scale = 0;
  for (int i = 0; i < 40; i++) {
    double nx = cos(0.2 + i), ny = sin(0.2 + i), x = cx + r * nx, y = cy + r * ny;
    for (int a = 0; a < 2; a++)
      worst = fmax(worst, fabs(stress(f, 2 * a, x, y) * nx + stress(f, 2 * a + 1, x, y) * ny));
    for (int k = 0; k < 4; k++) scale = fmax(scale, fabs(stress(f, k, x, y)));
  }
  return worst / scale;
}

static int open_run(void **state) {
  (void)state;
  ctx = test_ctx();
  run = (LthStudyRun){.ctx = ctx, .arena = {.ctx = ctx}, .folder = ""};
  return 0;
}

static int close_run(void **state) {
  (void)state;
  lth_arena_free(&run.arena);
  lithe_ctx_destroy(&ctx);
  return 0;
}

static void manufactured_solution_is_in_equilibrium_with_the_printed_stress(void **state) {
  (void)state;
  LthExactCase c = lth_exact_manufactured(false);
  Field f = open_field(&c);
  CHECK_NEAR(f.mu, 1, 1e-15);
  CHECK_NEAR(f.lambda, 1, 1e-15);
  CHECK_AT_MOST(largest_residual(&f, 0.325, 0.8), 1e-8);
  for (int i = 0; i < 20; i++) {
    double x = cos(i) * 0.6, y = sin(1.3 * i) * 0.6;
    for (int k = 0; k < 4; k++) CHECK_NEAR(stress(&f, k, x, y), at(f.stress[k], x, y), 1e-9);
  }
  close_field(&f);
}

static void ring_is_in_equilibrium_and_free_outside(void **state) {
  (void)state;
  for (double nu = 0; nu < 0.5; nu += 0.3) {
    LthExactCase c = lth_exact_ring(&run, nu);
    Field f = open_field(&c);
    CHECK_AT_MOST(largest_residual(&f, 0.34, 0.8), 1e-7);
    CHECK_AT_MOST(largest_traction(&f, 0, 0, 0.8), 1e-9);
    CHECK_NEAR(at(f.u[0], 0.325, 0), 1, 1e-14);
    close_field(&f);
  }
}

static void hole_is_in_equilibrium_and_free_and_pulled_far_away(void **state) {
  (void)state;
  LthExactCase c = lth_exact_hole(&run, 0.3, 0.01, -0.02);
  Field f = open_field(&c);
  CHECK_AT_MOST(largest_residual(&f, 0.4, 1), 1e-7);
  CHECK_AT_MOST(largest_traction(&f, 0.01, -0.02, 0.325), 1e-7);
  CHECK_NEAR(stress(&f, 3, 0.01, -0.02 + 0.325), 0, 1e-7); // along the normal
  CHECK_NEAR(stress(&f, 0, 0.01, -0.02 + 0.325), 3, 1e-7); // the factor of three
  CHECK_NEAR(stress(&f, 0, 300, 0), 1, 1e-5);
  CHECK_NEAR(stress(&f, 3, 0, 300), 0, 1e-5);
  close_field(&f);
}

static void rotating_ring_is_in_equilibrium_and_free_outside(void **state) {
  (void)state;
  LthExactCase c = lth_exact_rotating(&run, 0.3);
  Field f = open_field(&c);
  CHECK_AT_MOST(largest_residual(&f, 0.325, 0.8), 1e-8);
  CHECK_AT_MOST(largest_traction(&f, 0, 0, 0.8), 1e-9);
  close_field(&f);
}

static void printed_orders_follow_from_the_printed_errors(void **state) {
  (void)state;
  // the last column of Table 5.1, N = 2048, and of Table 5.2, N = 48
  const LthPrintedError *t1 = lth_dolny_table_5_1, *t2 = lth_dolny_table_5_2;
  CHECK_NEAR(log(t1[12].linf / t1[13].linf) / log(2048. / 1536), 3.02, 0.005);
  CHECK_NEAR(log(t1[12].l1 / t1[13].l1) / log(2048. / 1536), 1.99, 0.005);
  CHECK_NEAR(log(t2[0].l1 / t2[1].l1) / log(1.5), 2.16, 0.005);
  CHECK_NEAR(log(t2[0].linf / t2[1].linf) / log(1.5), 2.0, 0.05);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(manufactured_solution_is_in_equilibrium_with_the_printed_stress),
      cmocka_unit_test(ring_is_in_equilibrium_and_free_outside),
      cmocka_unit_test(hole_is_in_equilibrium_and_free_and_pulled_far_away),
      cmocka_unit_test(rotating_ring_is_in_equilibrium_and_free_outside),
      cmocka_unit_test(printed_orders_follow_from_the_printed_errors),
  };
  return cmocka_run_group_tests(tests, open_run, close_run);
}
