/// A Krylov method for the mixed form: minimal residuals over the last few directions, each a cycle of multigrid
/// (Eisenstat, Elman, Schultz 1983; the preconditioner may change from step to step).
// The residual is carried along, and computed anew each time that it has fallen so far that rounding, which lambda magnifies, would show. Directions
// in single precision were tried: they do without contact, whose stiff springs show their rounding.
#include "disc/staggered/staggered_mixed.h"

#include <math.h>
#include <string.h>

#define KEPT 10    // directions
#define MOST 60    // with a part that the levels do not know: every point that touches may need one
#define BLOCK 4096 // of sums
#define FALL 1e-2  // of the residual until it is computed anew
#define PATIENCE 20 // steps in which the residual does not fall by a tenth, until it is given up
#define PATIENCE_TOUCHED 200 // where every point that touches may need a step

struct LthMixedKrylov {
  LitheCount size, n_blocks;
  double *x, *b, *r; ///< unknowns, right-hand side, residual (its constraint rows weighted)
  double *z, *q;     ///< the latest direction and its image
  double *scratch;   ///< of `extra`, NULL before the first                         (size)
  double *weight;    ///< of constraint rows: what makes them forces [Pa/m]     (n_cells)
  int kept;          ///< directions that there is room for
  double *zs[MOST], *qs[MOST]; ///< directions and weighted images, of unit size
  double *sum;                 ///< (n_blocks x (MOST + 1))
};

/// Room for so many directions.
static LitheStatus reserve(LitheCtx *ctx, LthMixedKrylov *k, int kept) {
  for (; k->kept < kept; k->kept++) {
    LTH_NEW(ctx, k->zs[k->kept], k->size);
    LTH_NEW(ctx, k->qs[k->kept], k->size);
  }
  return LITHE_OK;
}

static LitheStatus allocate(LitheCtx *ctx, const LthMixed *m, LthMixedKrylov *k) {
  const LthStaggeredLevel *l = &m->level;
  k->size = lth_mixed_size(m);
  k->n_blocks = (k->size + BLOCK - 1) / BLOCK;
  double **vectors[] = {&k->x, &k->b, &k->r, &k->z, &k->q};
  for (int i = 0; i < 5; i++) LTH_NEW(ctx, *vectors[i], k->size);
  LTH_NEW(ctx, k->weight, m->n_cells);
  LTH_NEW(ctx, k->sum, k->n_blocks * (MOST + 1));
  LITHE_TRY(reserve(ctx, k, KEPT));
  for (LitheIndex c = 0; c < m->n_cells; c++)
    k->weight[c] =
        lth_level_value(l, l->mu, m->slot[c]) / (m->volume[c] * m->volume[c]) / l->grid->h[0];
  return LITHE_OK;
}

LitheStatus lth_mixed_krylov_create(LitheCtx *ctx, const LthMixed *m, LthMixedKrylov **krylov) {
  LTH_NEW(ctx, *krylov, 1);
  LitheStatus status = allocate(ctx, m, *krylov);
  if (status != LITHE_OK) lth_mixed_krylov_destroy(ctx, krylov);
  return status;
}

void lth_mixed_krylov_destroy(LitheCtx *ctx, LthMixedKrylov **krylov) {
  LthMixedKrylov *k = *krylov;
  if (!k) return;
  for (int i = 0; i < MOST; i++) {
    lth_free(ctx, k->zs[i]);
    lth_free(ctx, k->qs[i]);
  }
  void *blocks[] = {k->x, k->b, k->r, k->z, k->q, k->scratch, k->weight, k->sum};
  for (size_t i = 0; i < sizeof blocks / sizeof blocks[0]; i++) lth_free(ctx, blocks[i]);
  lth_free(ctx, k);
  *krylov = NULL;
}

LitheCount lth_mixed_krylov_bytes(const LthMixedKrylov *k) {
  return k->size * (5 + 2 * (LitheCount)k->kept) * 8;
}

double *lth_mixed_krylov_x(LthMixedKrylov *k) { return k->x; }
double *lth_mixed_krylov_b(LthMixedKrylov *k) { return k->b; }

/// Constraint rows times their weight, or over it.
static void weigh(const LthMixedKrylov *k, const LthMixed *m, int threads, bool inverse,
                  double *r) {
  double *g = r + m->n_dofs;
#pragma omp parallel for schedule(static) num_threads(threads)
  for (LitheIndex c = 0; c < m->n_cells; c++)
    g[c] = inverse ? g[c] / k->weight[c] : g[c] * k->weight[c];
}

/// y = A x with weighted rows.
static void apply(const LthMixedKrylov *k, const LthMixed *m, int threads, const LthOperator *extra,
                  const double *x, double *y) {
  lth_mixed_apply(m, threads, x, y);
  weigh(k, m, threads, false, y);
  if (!extra) return;
  extra->apply(extra->self, threads, x, k->scratch);
#pragma omp parallel for schedule(static) num_threads(threads)
  for (LitheCount i = 0; i < m->n_dofs; i++)
    if ((m->state[i / 3] >> 2 * (i % 3) & 3) == LTH_UNKNOWN_FREE) y[i] += k->scratch[i];
}

/// r = b - A x, weighted.
static void find_residual(LthMixedKrylov *k, const LthMixed *m, int threads,
                          const LthOperator *extra) {
  apply(k, m, threads, extra, k->x, k->r);
#pragma omp parallel for schedule(static) num_threads(threads)
  for (LitheCount i = 0; i < k->size; i++)
    k->r[i] = (i < m->n_dofs ? k->b[i] : k->b[i] * k->weight[i - m->n_dofs]) - k->r[i];
}

/// The residual of the displacements alone, once every pressure is what the divergence makes it: that of the
/// constraint goes back to the momentum rows through lambda (at nu = 0.5 through `stiff` mu).
static double primal_norm(LthMixedKrylov *k, const LthMixed *m, int threads, double stiff) {
  const double unit = m->ck * lth_sparse_grid_cell_volume(m->level.grid);
  double *f = k->q, *p = k->q + m->n_dofs;
  memcpy(f, k->r, sizeof *f * (size_t)m->n_dofs);
#pragma omp parallel for schedule(static) num_threads(threads)
  for (LitheIndex c = 0; c < m->n_cells; c++) {
    const double per_lambda =
        m->compliance[c] > 0 ? m->compliance[c] : 1 / (stiff * k->weight[c] * m->level.grid->h[0]);
    p[c] = k->r[m->n_dofs + c] / (k->weight[c] * unit * per_lambda);
  }
  lth_mixed_push(m, threads, m->ck, false, p, f);
  return sqrt(lth_dot(threads, m->n_dofs, f, f));
}

/// sum[i] = q . q_i, and sum[n] = q . r: block by block, so that threads do not matter.
static void project(LthMixedKrylov *k, int threads, int n, double *sum) {
#pragma omp parallel for schedule(static) num_threads(threads)
  for (LitheCount block = 0; block < k->n_blocks; block++) {
    const LitheCount first = block * BLOCK;
    const LitheCount end = first + BLOCK < k->size ? first + BLOCK : k->size;
    for (int i = 0; i < n; i++) {
      const double *q = k->qs[i];
      double part = 0;
#pragma omp simd reduction(+ : part)
      for (LitheCount j = first; j < end; j++) part += k->q[j] * q[j];
      k->sum[block * (MOST + 1) + i] = part;
    }
  }
  for (int i = 0; i < n; i++) {
    sum[i] = 0;
    for (LitheCount block = 0; block < k->n_blocks; block++)
      sum[i] += k->sum[block * (MOST + 1) + i];
  }
}

/// q and z less their parts along the directions that are kept.
static void orthogonalise(LthMixedKrylov *k, int threads, int n) {
  double sum[MOST];
  project(k, threads, n, sum);
#pragma omp parallel for schedule(static) num_threads(threads)
  for (LitheCount block = 0; block < k->n_blocks; block++) {
    const LitheCount first = block * BLOCK;
    const LitheCount end = first + BLOCK < k->size ? first + BLOCK : k->size;
    for (int i = 0; i < n; i++) {
      const double *q = k->qs[i], *z = k->zs[i];
      for (LitheCount j = first; j < end; j++) k->q[j] -= sum[i] * q[j];
      for (LitheCount j = first; j < end; j++) k->z[j] -= sum[i] * z[j];
    }
  }
}

/// Keep z and q over |q|, and go along z until the residual no longer falls. False: nothing is left of q.
static bool step_along(LthMixedKrylov *k, int threads, int slot) {
  const double size = sqrt(lth_dot(threads, k->size, k->q, k->q));
  if (!(size > 0)) return false;
  const double step = lth_dot(threads, k->size, k->q, k->r) / (size * size);
#pragma omp parallel for schedule(static) num_threads(threads)
  for (LitheCount i = 0; i < k->size; i++) {
    k->x[i] += step * k->z[i];
    k->r[i] -= step * k->q[i];
    k->zs[slot][i] = k->z[i] / size;
    k->qs[slot][i] = k->q[i] / size;
  }
  return true;
}

/// Displacements of a body that pressures do nothing to.
static LitheStatus guess(LitheCtx *ctx, LthMixedKrylov *k, LthMixed *m) {
  memcpy(k->r, k->b, sizeof *k->r * (size_t)m->n_dofs);
  lth_mixed_push(m, lth_threads(ctx), -m->ck, false, k->x + m->n_dofs, k->r);
  return lth_staggered_multigrid_full(ctx, m->multigrid, k->r, k->x);
}

LitheStatus lth_mixed_krylov_solve(LitheCtx *ctx, LthMixedKrylov *k, LthMixed *m,
                                   const LthOperator *extra, const LthMixedStop *stop,
                                   LthSolveReport *report) {
  const int threads = lth_threads(ctx), kept = extra ? MOST : KEPT;
  const int patience = extra ? PATIENCE_TOUCHED : PATIENCE;
  double best = INFINITY, peak = 0;
  int idle = 0;
  *report = (LthSolveReport){0};
  LITHE_TRY(reserve(ctx, k, kept));
  if (extra && !k->scratch) LTH_NEW(ctx, k->scratch, k->size);
  if (stop->start && !extra) LITHE_TRY(guess(ctx, k, m));
  find_residual(k, m, threads, extra);
  for (;; report->iterations++) {
    if (lth_cancelled(ctx)) LITHE_FAIL(ctx, LITHE_INTERRUPTED, "interrupted");
    double now = primal_norm(k, m, threads, stop->stiff);
    if (now < FALL * peak) {
      find_residual(k, m, threads, extra);
      peak = now = primal_norm(k, m, threads, stop->stiff);
    }
    peak = fmax(peak, now);
    report->residual = stop->size > 0 ? now / stop->size : now;
    report->converged = now <= stop->tolerance * stop->size;
    idle = now < 0.9 * best ? 0 : idle + 1;
    best = fmin(best, now);
    if (report->converged || report->iterations >= stop->max_iterations || idle > patience ||
        !isfinite(now))
      return LITHE_OK;
    const int n = report->iterations < kept ? report->iterations : kept;
    weigh(k, m, threads, true, k->r);
    LITHE_TRY(lth_mixed_precondition(ctx, m, k->r, k->q, k->z));
    weigh(k, m, threads, false, k->r);
    apply(k, m, threads, extra, k->z, k->q);
    orthogonalise(k, threads, n);
    if (!step_along(k, threads, report->iterations % kept)) return LITHE_OK;
  }
}
