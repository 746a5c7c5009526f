/// Conjugate gradients (Hestenes and Stiefel 1952) with warm start and a true final residual.
#include "la/krylov.h"

#include "la/vector.h"

#include <math.h>
#include <string.h>

struct LthCg {
  LitheCount n;
  double *r, *z, *p, *q;
};

LitheStatus lth_cg_create(LitheCtx *ctx, LitheCount n, LthCg **cg) {
  LitheStatus status = LITHE_OK;
  LthCg *c = NULL;
  *cg = NULL;
  LTH_NEW_OR(done, ctx, c, 1);
  c->n = n;
  LTH_NEW_OR(done, ctx, c->r, n);
  LTH_NEW_OR(done, ctx, c->z, n);
  LTH_NEW_OR(done, ctx, c->p, n);
  LTH_NEW_OR(done, ctx, c->q, n);
  *cg = c;
  c = NULL;
done:
  lth_cg_destroy(ctx, &c);
  return status;
}

void lth_cg_destroy(LitheCtx *ctx, LthCg **cg) {
  if (!cg || !*cg) return;
  lth_free(ctx, (*cg)->r);
  lth_free(ctx, (*cg)->z);
  lth_free(ctx, (*cg)->p);
  lth_free(ctx, (*cg)->q);
  lth_free(ctx, *cg);
  *cg = NULL;
}

static void apply(const LthOperator *A, int threads, const double *x, double *y) {
  A->apply(A->self, threads, x, y);
}

/// r = b - A x and its norm.
static double true_residual(LthCg *cg, int threads, const LthOperator *A, const double *b,
                            const double *x) {
  apply(A, threads, x, cg->q);
  return sqrt(lth_residual(threads, cg->n, b, cg->q, cg->r));
}

/// Iterate on cg->r until |r| <= target; returns the iterations done. Ends early where a direction of
/// no or negative energy shows that A (or M) is not definite.
static LitheIndex iterate(LthCg *cg, int threads, const LthOperator *A, const LthOperator *M,
                          double *x, double target, LitheIndex max_iterations, bool *definite) {
  double rz = 0;
  LitheIndex it = 0;
  for (; it < max_iterations; it++) {
    double *z = cg->r;
    if (M) apply(M, threads, cg->r, z = cg->z);
    double rz_new = lth_dot(threads, cg->n, cg->r, z);
    lth_direction(threads, cg->n, z, it == 0 ? 0 : rz_new / rz, cg->p);
    rz = rz_new;

    apply(A, threads, cg->p, cg->q);
    double pq = lth_dot(threads, cg->n, cg->p, cg->q);
    *definite = rz > 0 && pq > 0;
    if (!*definite) break;
    if (sqrt(lth_advance(threads, cg->n, rz / pq, cg->p, cg->q, x, cg->r)) <= target) return it + 1;
  }
  return it;
}

LthSolveReport lth_cg_solve(LthCg *cg, int threads, const LthOperator *A, const LthOperator *M,
                            const double *b, double *x, double tolerance,
                            LitheIndex max_iterations) {
  LthSolveReport report = {.converged = true};
  double norm_b = sqrt(lth_dot(threads, cg->n, b, b));
  if (norm_b == 0) {
    memset(x, 0, sizeof *x * (size_t)cg->n);
    return report;
  }
  double target = tolerance * norm_b, residual = true_residual(cg, threads, A, b, x);

  // the recurrence drifts from the true residual: start again from that, as long as it pays
  bool definite = true;
  while (residual > target && definite && report.iterations < max_iterations) {
    double before = residual;
    report.iterations +=
        iterate(cg, threads, A, M, x, target, max_iterations - report.iterations, &definite);
    residual = true_residual(cg, threads, A, b, x);
    if (!(residual < 0.5 * before)) break;
  }
  report.residual = residual / norm_b;
  report.converged = residual <= target;
  return report;
}
