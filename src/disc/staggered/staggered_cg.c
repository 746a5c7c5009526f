/// Conjugate gradients in double precision around the V-cycle, on vectors that lie as those of the cycle do.
// Vectors p, r and q; the V-cycle's x and y lie where q does: q is of use between A p and the next residual alone.
#include "disc/staggered/staggered_multigrid_priv.h"

#include <math.h>
#include <string.h>

double lth_staggered_sum(const LthStaggeredMultigrid *M) {
  double sum = 0;
  for (LitheIndex i = 0; i < M->level[0].n_active; i++) sum += M->sum[i];
  return sum;
}

static LitheIndex func_of(const LthStaggeredMultigrid *M, LitheCount slot) {
  return M->def.func ? M->def.func[slot] : (LitheIndex)slot;
}

/// Calls for every cell of the rows of a block: its place i in vectors, and its slot; component a is a side further on.
#define EACH_CELL(L, block, i, slot)                                                               \
  for (LitheIndex q_ = (L)->first[block]; q_ < (L)->first[(block) + 1]; q_++)                      \
    for (LitheCount i = q_ * (LitheCount)lth_fast_width(L), slot = lth_fast_slot(L, block, q_),    \
                    end_ = slot + (L)->grid->side;                                                 \
         slot < end_; i++, slot++)

void lth_staggered_scatter(const LthStaggeredMultigrid *M, int threads, bool only_free,
                           const double *x, double *rows) {
  const LthStaggeredLevel *l = &M->fine;
  const LthFastLevel *L = &M->level[0];
  const LitheIndex side = l->grid->side;
#pragma omp parallel for schedule(static) num_threads(threads)
  for (LitheIndex k = 0; k < L->n_active; k++) EACH_CELL(L, L->active[k], i, slot) {
      LitheIndex f = func_of(M, slot);
      for (int a = 0; a < l->grid->dim; a++) {
        uint8_t state = l->state[a][slot];
        bool counts = f >= 0 && (only_free ? state == LTH_UNKNOWN_FREE : state != LTH_UNKNOWN_DEAD);
        rows[i + a * side] = counts ? x[3 * (LitheCount)f + a] : 0;
      }
    }
}

void lth_staggered_gather(const LthStaggeredMultigrid *M, int threads, bool held,
                          const double *rows, double *y) {
  const LthStaggeredLevel *l = &M->fine;
  const LthFastLevel *L = &M->level[0];
  const LitheIndex side = l->grid->side;
#pragma omp parallel for schedule(static) num_threads(threads)
  for (LitheIndex k = 0; k < L->n_active; k++) EACH_CELL(L, L->active[k], i, slot) {
      LitheIndex f = func_of(M, slot);
      if (f < 0) continue;
      for (int a = 0; a < 3; a++) {
        uint8_t state = a < l->grid->dim ? l->state[a][slot] : LTH_UNKNOWN_DEAD;
        bool counts = state == LTH_UNKNOWN_FREE || (held && state == LTH_UNKNOWN_HELD);
        y[3 * (LitheCount)f + a] = counts ? rows[i + a * side] : 0;
      }
    }
}

/// w += alpha p (unless w is NULL), then (`renew`) p = z + beta p, in one sweep; z is x of the V-cycle.
static void turn_direction(LitheCtx *ctx, LthStaggeredMultigrid *M, double alpha, double beta,
                           bool renew, double *w) {
  const LthFastLevel *L = &M->level[0];
  const LitheIndex side = L->grid->side, dim = L->grid->dim;
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheIndex k = 0; k < L->n_active; k++) {
    const LitheIndex b = L->active[k];
    if (alpha != 0 && w) EACH_CELL(L, b, i, slot) {
        LitheIndex f = func_of(M, slot);
        if (f < 0) continue;
        for (int a = 0; a < dim; a++) w[3 * (LitheCount)f + a] += alpha * M->p[i + a * side];
      }
    if (!renew) continue;
    for (LitheIndex q = L->first[b]; q < L->first[b + 1]; q++) {
      double *p = M->p + q * M->width;
      const float *z = L->x.at + q * L->x.stride;
      for (LitheCount i = 0; i < M->width; i++) p[i] = z[i] + beta * p[i];
    }
  }
}

/// q += y at free unknowns; returns the sum of p . y.
static double add_extra(LitheCtx *ctx, LthStaggeredMultigrid *M, const double *y) {
  const LthFastLevel *L = &M->level[0];
  const LitheIndex side = L->grid->side;
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheIndex k = 0; k < L->n_active; k++) {
    M->sum[k] = 0;
    EACH_CELL(L, L->active[k], i, slot) {
      LitheIndex f = func_of(M, slot);
      for (int a = 0; f >= 0 && a < L->grid->dim; a++) {
        if (M->fine.state[a][slot] != LTH_UNKNOWN_FREE) continue;
        M->work[i + a * side] += y[3 * (LitheCount)f + a];
        M->sum[k] += M->p[i + a * side] * y[3 * (LitheCount)f + a];
      }
    }
  }
  return lth_staggered_sum(M);
}

/// q = A p; returns p . q.
static double apply_operator(LitheCtx *ctx, LthStaggeredMultigrid *M, const LthOperator *extra) {
  const LthFastLevel *L = &M->level[0];
  const LthFastKernels *k = L->kernels;
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheIndex i = 0; i < L->n_active; i++)
    M->sum[i] = k->apply(L, L->active[i], M->cm, M->ck, false, M->p, M->work);
  double sum = lth_staggered_sum(M);
  if (!extra) return sum;
  lth_staggered_gather(M, lth_threads(ctx), false, M->p, M->extra_x);
  extra->apply(extra->self, lth_threads(ctx), M->extra_x, M->extra_y);
  return sum + add_extra(ctx, M, M->extra_y);
}

/// r -= alpha q and b = scale r in single precision; returns r . r.
static double advance(LitheCtx *ctx, LthStaggeredMultigrid *M, double alpha, double scale) {
  const LthFastLevel *L = &M->level[0];
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheIndex k = 0; k < L->n_active; k++) {
    const LitheIndex first = L->first[L->active[k]], n = L->first[L->active[k] + 1] - first;
    double *r = M->r + first * M->width, lane[8] = {0};
    const double *q = M->work + first * M->width;
    float *single = L->b.at + first * L->b.stride; // without gaps
    for (LitheCount i = 0; i < n * M->width; i += 8)
      for (int s = 0; s < 8; s++) {
        double value = r[i + s] - alpha * q[i + s];
        r[i + s] = value;
        single[i + s] = (float)(scale * value);
        lane[s] += value * value;
      }
    M->sum[k] = 0;
    for (int s = 0; s < 8; s++) M->sum[k] += lane[s];
  }
  return lth_staggered_sum(M);
}

/// r = rhs - A w and b = scale r; returns |r|. Leaves w in p.
static double true_residual(LitheCtx *ctx, LthStaggeredMultigrid *M, const LthOperator *extra,
                            const double *rhs, const double *w, bool is_zero, double scale) {
  lth_staggered_scatter(M, lth_threads(ctx), true, rhs, M->r);
  if (is_zero) {
    memset(M->p, 0, sizeof *M->p * (size_t)(M->level[0].n_rows * M->width));
    return sqrt(advance(ctx, M, 0, scale));
  }
  lth_staggered_scatter(M, lth_threads(ctx), true, w, M->p);
  apply_operator(ctx, M, extra);
  return sqrt(advance(ctx, M, 1, scale));
}

static double norm_of(LitheCtx *ctx, LthStaggeredMultigrid *M, const double *v) {
  const LthFastLevel *L = &M->level[0];
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheIndex k = 0; k < L->n_active; k++) {
    M->sum[k] = 0;
    EACH_CELL(L, L->active[k], i, slot) {
      LitheIndex f = func_of(M, slot);
      for (int a = 0; f >= 0 && a < L->grid->dim; a++)
        if (M->fine.state[a][slot] == LTH_UNKNOWN_FREE)
          M->sum[k] += v[3 * (LitheCount)f + a] * v[3 * (LitheCount)f + a];
    }
  }
  return sqrt(lth_staggered_sum(M));
}

/// w += x of the V-cycle over `scale`.
static void take_start(LitheCtx *ctx, LthStaggeredMultigrid *M, double scale, double *w) {
  turn_direction(ctx, M, 0, 0, true, w);
  turn_direction(ctx, M, 1 / scale, 0, false, w);
}

/// Iterate from r and b until |r| <= target; returns the iterations done.
static LitheStatus iterate(LitheCtx *ctx, LthStaggeredMultigrid *M, const LthOperator *extra,
                           double scale, double target, LitheIndex most, double *w,
                           LitheIndex *iterations, bool *definite) {
  double rz = 0, rz_before = 0, alpha = 0, norm = INFINITY;
  LitheIndex it = 0;
  for (; it < most && norm > target; it++) {
    if (lth_cancelled(ctx)) LITHE_FAIL(ctx, LITHE_INTERRUPTED, "interrupted");
    LITHE_TRY(lth_staggered_cycle(ctx, M, &rz));
    turn_direction(ctx, M, alpha, it == 0 ? 0 : rz / rz_before, true, w);
    double pq = apply_operator(ctx, M, extra);
    *definite = rz > 0 && pq > 0;
    alpha = 0;
    if (!*definite) break;
    alpha = rz / scale / pq;
    rz_before = rz;
    norm = sqrt(advance(ctx, M, alpha, scale));
  }
  turn_direction(ctx, M, alpha, 0, false, w);
  *iterations += it;
  return LITHE_OK;
}

/// r = the volume around every free unknown, in a direction that favours none.
static void uniform_force(LitheCtx *ctx, LthStaggeredMultigrid *M) {
  static const double direction[3] = {0.6, -1, 0.8};
  const LthStaggeredLevel *l = &M->fine;
  const LthFastLevel *L = &M->level[0];
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheIndex k = 0; k < L->n_active; k++) EACH_CELL(L, L->active[k], i, slot) {
      LitheIndex cell[3];
      lth_sparse_grid_cell(l->grid, slot, cell);
      for (int a = 0; a < l->grid->dim; a++) {
        LitheCount before = lth_sparse_grid_along(l->grid, cell, a, -1);
        double V = lth_level_value(l, l->volume, slot) + lth_level_value(l, l->volume, before);
        bool counts = l->state[a][slot] == LTH_UNKNOWN_FREE;
        M->r[i + a * l->grid->side] = counts ? V * direction[a] : 0;
      }
    }
}

LitheStatus lth_staggered_multigrid_trial(LitheCtx *ctx, LthStaggeredMultigrid *M, double tolerance,
                                          LitheIndex most, bool *reached) {
  uniform_force(ctx, M);
  const double norm = sqrt(advance(ctx, M, 0, 1)), scale = norm > 0 ? 1 / norm : 1;
  LitheIndex iterations = 0;
  bool definite = true;
  advance(ctx, M, 0, scale);
  LITHE_TRY(iterate(ctx, M, NULL, scale, tolerance * norm, most, NULL, &iterations, &definite));
  *reached = definite && iterations < most;
  return LITHE_OK;
}

static bool all_zero(LitheCount n, const double *v) {
  for (LitheCount i = 0; i < n; i++)
    if (v[i] != 0) return false;
  return true;
}

LitheStatus lth_staggered_multigrid_solve(LitheCtx *ctx, LthStaggeredMultigrid *M,
                                          const LthOperator *extra, const double *rhs, double *w,
                                          double tolerance, LitheIndex max_iterations,
                                          LthSolveReport *report) {
  *report = (LthSolveReport){.converged = true};
  double norm_b = norm_of(ctx, M, rhs);
  if (norm_b == 0) {
    memset(w, 0, sizeof *w * (size_t)M->def.n_dofs);
    return LITHE_OK;
  }
  if (extra && !M->extra_x) {
    LTH_NEW(ctx, M->extra_x, M->def.n_dofs);
    LTH_NEW(ctx, M->extra_y, M->def.n_dofs);
  }
  double scale = 1 / norm_b, target = tolerance * norm_b;
  bool is_zero = all_zero(M->def.n_dofs, w), definite = true;
  double residual = true_residual(ctx, M, extra, rhs, w, is_zero, scale);
  if (is_zero && !extra) {
    LITHE_TRY(lth_staggered_full(ctx, M));
    take_start(ctx, M, scale * M->unit, w);
    residual = true_residual(ctx, M, extra, rhs, w, false, scale);
  }
  while (residual > target && definite && report->iterations < max_iterations) {
    double before = residual;
    LITHE_TRY(iterate(ctx, M, extra, scale, target, max_iterations - report->iterations, w,
                      &report->iterations, &definite));
    residual = true_residual(ctx, M, extra, rhs, w, false, scale);
    if (!(residual < 0.5 * before)) break;
  }
  report->residual = residual / norm_b;
  report->converged = residual <= target;
  return LITHE_OK;
}

LitheStatus lth_staggered_multigrid_cycle(LitheCtx *ctx, LthStaggeredMultigrid *M, const double *r,
                                          double *z) {
  double product, norm = norm_of(ctx, M, r), scale = norm > 0 ? 1 / norm : 1;
  true_residual(ctx, M, NULL, r, NULL, true, scale);
  LITHE_TRY(lth_staggered_cycle(ctx, M, &product));
  memset(z, 0, sizeof *z * (size_t)M->def.n_dofs);
  take_start(ctx, M, scale * M->unit, z);
  return LITHE_OK;
}

LitheStatus lth_staggered_multigrid_full(LitheCtx *ctx, LthStaggeredMultigrid *M, const double *rhs,
                                         double *w) {
  double norm = norm_of(ctx, M, rhs), scale = norm > 0 ? 1 / norm : 1;
  true_residual(ctx, M, NULL, rhs, NULL, true, scale);
  LITHE_TRY(lth_staggered_full(ctx, M));
  memset(w, 0, sizeof *w * (size_t)M->def.n_dofs);
  take_start(ctx, M, scale * M->unit, w);
  return LITHE_OK;
}

LitheStatus lth_staggered_multigrid_time_full(LitheCtx *ctx, LthStaggeredMultigrid *M,
                                              const double *rhs, int count, double *seconds,
                                              double *work) {
  double norm = norm_of(ctx, M, rhs), scale = norm > 0 ? 1 / norm : 1;
  true_residual(ctx, M, NULL, rhs, NULL, true, scale);
  double start = lth_now(), before = M->work_done;
  for (int i = 0; i < count; i++) {
    advance(ctx, M, 0, scale);
    LITHE_TRY(lth_staggered_full(ctx, M));
  }
  *seconds = (lth_now() - start) / count;
  *work = (M->work_done - before) / count;
  return LITHE_OK;
}

double lth_staggered_multigrid_time_apply(LitheCtx *ctx, LthStaggeredMultigrid *M) {
  const double start = lth_now();
  apply_operator(ctx, M, NULL);
  return lth_now() - start;
}
