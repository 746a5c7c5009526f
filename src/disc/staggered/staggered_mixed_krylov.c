/// A Krylov method for the mixed form: minimal residuals over the last few directions, each a cycle of multigrid
/// (Eisenstat, Elman, Schultz 1983; the preconditioner may change from step to step).
#include "disc/staggered/staggered_mixed.h"

#include <math.h>
#include <string.h>

#define KEPT 12 // directions
#define MOST 60 // with a part that the levels do not know: every point that touches may need one

struct LthMixedKrylov {
  LitheCount size;
  double *x, *b, *r;         ///< unknowns, right-hand side, residual
  int kept;                  ///< directions that there is room for
  double *z[MOST], *q[MOST]; ///< directions and weighted images, of unit size
  double *weight;            ///< of constraint rows: what makes them forces [Pa/m]     (n + 1)
};

/// Room for so many directions.
static LitheStatus reserve(LitheCtx *ctx, LthMixedKrylov *k, int kept) {
  for (; k->kept < kept; k->kept++) {
    LTH_NEW(ctx, k->z[k->kept], k->size);
    LTH_NEW(ctx, k->q[k->kept], k->size);
  }
  return LITHE_OK;
}

static LitheStatus allocate(LitheCtx *ctx, const LthMixedLevel *l, LthMixedKrylov *k) {
  k->size = lth_mixed_size(l);
  LTH_NEW(ctx, k->x, k->size);
  LTH_NEW(ctx, k->b, k->size);
  LTH_NEW(ctx, k->r, k->size);
  LTH_NEW(ctx, k->weight, l->n + 1);
  LITHE_TRY(reserve(ctx, k, KEPT));
  for (LitheCount c = 0; c < l->n; c++)
    if (l->flags[c] & LTH_MIXED_PRESSURE) k->weight[c] = l->mu[c] / (l->volume[c] * l->volume[c]);
  for (LitheCount c = 0; c < l->n; c++) k->weight[c] *= l->per_h[0];
  return LITHE_OK;
}

LitheStatus lth_mixed_krylov_create(LitheCtx *ctx, const LthMixedLevel *l,
                                    LthMixedKrylov **krylov) {
  LTH_NEW(ctx, *krylov, 1);
  LitheStatus status = allocate(ctx, l, *krylov);
  if (status != LITHE_OK) lth_mixed_krylov_destroy(ctx, krylov);
  return status;
}

void lth_mixed_krylov_destroy(LitheCtx *ctx, LthMixedKrylov **krylov) {
  LthMixedKrylov *k = *krylov;
  if (!k) return;
  for (int i = 0; i < MOST; i++) {
    lth_free(ctx, k->z[i]);
    lth_free(ctx, k->q[i]);
  }
  lth_free(ctx, k->x);
  lth_free(ctx, k->b);
  lth_free(ctx, k->r);
  lth_free(ctx, k->weight);
  lth_free(ctx, k);
  *krylov = NULL;
}

LitheCount lth_mixed_krylov_bytes(const LthMixedKrylov *k) {
  return (LitheCount)sizeof(double) * k->size * (3 + 2 * k->kept);
}

double *lth_mixed_krylov_x(LthMixedKrylov *k) { return k->x; }
double *lth_mixed_krylov_b(LthMixedKrylov *k) { return k->b; }

/// Constraint rows times their weight, or over it.
static void weigh(const LthMixedKrylov *k, const LthMixedLevel *l, int threads, bool inverse,
                  double *r) {
  double *g = r + l->dim * l->stride;
#pragma omp parallel for schedule(static) num_threads(threads)
  for (LitheCount c = 0; c < l->n; c++)
    if (k->weight[c] > 0) g[c] = inverse ? g[c] / k->weight[c] : g[c] * k->weight[c];
}

/// r = b - A x, weighted; b NULL: A x.
static void residual(LthMixedKrylov *k, const LthMixedLevel *l, int threads,
                     const LthMixedExtra *extra, const double *b, const double *x, double *r) {
  lth_mixed_residual(l, threads, b, x, r);
  if (extra) extra->subtract(extra->self, threads, x, r);
  if (!b) {
#pragma omp parallel for schedule(static) num_threads(threads)
    for (LitheCount i = 0; i < k->size; i++) r[i] = -r[i];
  }
  weigh(k, l, threads, false, r);
}

static void add(int threads, LitheCount n, double c, const double *x, double *y) {
#pragma omp parallel for schedule(static) num_threads(threads)
  for (LitheCount i = 0; i < n; i++) y[i] += c * x[i];
}

static void scale(int threads, LitheCount n, double c, double *x) {
#pragma omp parallel for schedule(static) num_threads(threads)
  for (LitheCount i = 0; i < n; i++) x[i] *= c;
}

/// z = one cycle for the residual.
static LitheStatus precondition(LitheCtx *ctx, LthMixedKrylov *k, LthMixedGrid *g, bool full,
                                double *z) {
  LthMixedLevel *l = &g->level[0];
  const size_t bytes = sizeof *z * (size_t)k->size;
  memcpy(l->b, k->r, bytes);
  weigh(k, l, lth_threads(ctx), true, l->b);
  LITHE_TRY(lth_mixed_cycle(ctx, g, full));
  memcpy(z, l->x, bytes);
  return LITHE_OK;
}

/// The residual of the displacements alone, once every pressure is what the divergence makes it: that of the
/// constraint goes back to the momentum rows through lambda (at nu = 0.5 through `stiff` mu).
static double primal_norm(LthMixedKrylov *k, LthMixedLevel *l, int threads, double stiff) {
  const LitheCount pressure = l->dim * l->stride;
  double *p = l->x + pressure, *r = l->r;
#pragma omp parallel for schedule(static) num_threads(threads)
  for (LitheCount c = 0; c < l->n; c++) {
    const double V = l->volume[c];
    p[c] = 0;
    if (!(k->weight[c] > 0)) continue;
    double lambda = l->compliance[c] > 0 ? V / l->compliance[c] : stiff * l->mu[c] / V;
    p[c] = k->r[pressure + c] / k->weight[c] * lambda / V;
  }
#pragma omp parallel for schedule(static) num_threads(threads)
  for (LitheIndex c = 0; c < l->n; c++)
    for (int a = 0; a < l->dim; a++) {
      const LitheIndex low = l->next[2 * a][c];
      double push = (l->volume[low] * p[low] - l->volume[c] * p[c]) * l->per_h[a];
      r[a * l->stride + c] = l->flags[c] & LTH_MIXED_FREE << a ? k->r[a * l->stride + c] + push : 0;
    }
  return sqrt(lth_dot(threads, pressure, r, r));
}

static void orthogonalise(LthMixedKrylov *k, int threads, int n, int slot) {
  for (int i = 0; i < n; i++) {
    if (i == slot) continue;
    double c = lth_dot(threads, k->size, k->q[slot], k->q[i]);
    add(threads, k->size, -c, k->q[i], k->q[slot]);
    add(threads, k->size, -c, k->z[i], k->z[slot]);
  }
}

LitheStatus lth_mixed_krylov_solve(LitheCtx *ctx, LthMixedKrylov *k, LthMixedGrid *g,
                                   const LthMixedExtra *extra, const LthMixedStop *stop,
                                   LthSolveReport *report) {
  const int threads = lth_threads(ctx), kept = extra ? MOST : KEPT;
  LthMixedLevel *l = &g->level[0];
  LITHE_TRY(reserve(ctx, k, kept));
  double best = INFINITY;
  int idle = 0;
  *report = (LthSolveReport){0};
  residual(k, l, threads, extra, k->b, k->x, k->r);
  for (;; report->iterations++) {
    double now = stop->primal ? primal_norm(k, l, threads, stop->stiff)
                              : sqrt(lth_dot(threads, k->size, k->r, k->r));
    report->residual = stop->size > 0 ? now / stop->size : now;
    report->converged = now <= stop->tolerance * stop->size;
    idle = now < 0.9 * best ? 0 : idle + 1;
    best = fmin(best, now);
    if (report->converged || report->iterations >= stop->max_iterations || idle > 20 ||
        !isfinite(now))
      return LITHE_OK;
    const int slot = report->iterations % kept,
              n = report->iterations < kept ? report->iterations : kept;
    LITHE_TRY(precondition(ctx, k, g, stop->full && report->iterations == 0, k->z[slot]));
    residual(k, l, threads, extra, NULL, k->z[slot], k->q[slot]);
    orthogonalise(k, threads, n, slot);
    double size = sqrt(lth_dot(threads, k->size, k->q[slot], k->q[slot]));
    if (!(size > 0)) return LITHE_OK;
    scale(threads, k->size, 1 / size, k->q[slot]);
    scale(threads, k->size, 1 / size, k->z[slot]);
    double step = lth_dot(threads, k->size, k->q[slot], k->r);
    add(threads, k->size, step, k->z[slot], k->x);
    add(threads, k->size, -step, k->q[slot], k->r);
  }
}
