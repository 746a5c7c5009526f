/// Solves of a body in the mixed form: LthDiscSolver on top of its Krylov method (docs/theory/staggered-mixed.md).
///
/// The caller sees displacements alone. Where lambda is finite the answer is that of the displacement form, to its own
/// measure of the residual. Where nu = 0.5 the divergence at the new place is zero, and the pressure that this takes is
/// kept for the next linearisation (staggered_mixed_state.c).
#include "disc/staggered/staggered_mixed_state.h"

#include <math.h>
#include <string.h>

#define STIFF 10 // lambda over mu by which the divergence weighs in the residual where nu = 0.5

static LthMixedState *state_of(const LthDisc *disc) { return lth_staggered_of(disc)->mixed; }

static void force(const LthDisc *disc, int threads, const double *x, double *f) {
  const LthMixedState *m = state_of(disc);
  lth_staggered_rest(disc, f);
#pragma omp parallel for schedule(static) num_threads(threads)
  for (LitheCount i = 0; i < disc->n_dofs; i++) f[i] = x[i] - f[i];
  lth_mixed_follow(m->system, threads, f);
  lth_staggered_own_solver.force(disc, threads, x, f);
  lth_mixed_push(m->system, threads, 1, true, m->system->push, f);
  lth_mixed_add_force(lth_staggered_const(disc), 1, f);
}

static void diagonal(const LthDisc *disc, double cm, double ck, double *d) {
  lth_staggered_own_solver.diagonal(disc, cm, ck, d);
}

static void apply(const LthDisc *disc, int threads, double cm, double ck, const double *x,
                  double *y) {
  const LthMixed *system = state_of(disc)->system;
  lth_mixed_follow(system, threads, x);
  lth_staggered_own_solver.apply(disc, threads, cm, ck, x, y);
  lth_mixed_push(system, threads, ck, false, system->push, y);
}

static LitheStatus prepare(LitheCtx *ctx, LthDisc *disc, double cm, double ck) {
  LthMixedState *m = state_of(disc);
  LITHE_TRY(lth_mixed_prepare(ctx, m->system, cm, ck));
  if (!m->scratch) LTH_NEW(ctx, m->scratch, disc->n_dofs);
  return m->krylov ? LITHE_OK : lth_mixed_krylov_create(ctx, m->system, &m->krylov);
}

static void release(LitheCtx *ctx, LthDisc *disc) {
  LthMixedState *m = state_of(disc);
  lth_staggered_own_solver.release(ctx, disc);
  lth_mixed_krylov_destroy(ctx, &m->krylov);
  lth_free(ctx, m->scratch);
  m->scratch = NULL;
}

static LitheStatus aim(LitheCtx *ctx, LthDisc *disc, const double *u) {
  const LthMixedState *m = state_of(disc);
  if (!m->pressure) return LITHE_OK;
  disc->table->volume->strain(disc, lth_threads(ctx), u, m->strain);
  LITHE_TRY(disc->table->volume->admit(ctx, disc, u, m->strain));
  for (LitheIndex i = 0; i < m->n_stiff; i++) m->target[m->stiff[i]] = m->strain[i];
  return LITHE_OK;
}

/// lambda of a cell, all of it or what is in `system->soft`.
static double lambda_of(const LthStaggered *s, const double *lambda, LitheIndex c) {
  const LthMixed *system = s->mixed->system;
  return lth_level_value(&s->level, lambda, system->slot[c]) / system->volume[c];
}

static bool is_stiff(const LthMixed *system, LitheIndex c) { return system->compliance[c] == 0; }

/// Pressure by w that takes back the augmented Lagrangian's part of the right-hand side, which is that of w = 0.
static double take_back(const LthStaggered *s, double reach, LitheIndex c) {
  const LthMixedState *m = s->mixed;
  return -reach / m->system->ck * lambda_of(s, s->level.lambda, c) * m->target[m->system->slot[c]];
}

/// Right-hand side: forces, and at nu = 0.5 the divergence where positions would be for w = 0, which is to vanish.
static void set_right_side(const LthStaggered *s, double reach, const double *rhs, double *b) {
  const LthMixed *system = s->mixed->system;
  const double unit = system->ck * lth_sparse_grid_cell_volume(s->grid);
  for (LitheCount i = 0; i < system->n_dofs; i++) b[i] = s->held[i] ? 0 : rhs[i];
  for (LitheIndex c = 0; c < system->n_cells; c++)
    b[system->n_dofs + c] =
        is_stiff(system, c) ? -unit * system->volume[c] * s->mixed->target[system->slot[c]] / reach
                            : 0;
}

/// First pressures: what the rest of lambda makes of the divergence of w; at nu = 0.5 what takes back, less what `soft` has of it.
static void guess_pressures(const LthStaggered *s, int threads, double reach, double *x) {
  const LthMixed *system = s->mixed->system;
  double *p = x + system->n_dofs;
  lth_mixed_divergence(system, threads, x, p);
  for (LitheIndex c = 0; c < system->n_cells; c++)
    p[c] = is_stiff(system, c)
               ? take_back(s, reach, c) - lambda_of(s, system->soft.lambda, c) * p[c]
               : system->rest[c] / system->volume[c] * p[c];
}

/// Size of the right-hand side without the augmented Lagrangian's part, which would hide all else where the divergence
/// is yet to be mended.
static double size_of_load(const LthStaggered *s, int threads, double reach, const double *b) {
  const LthMixedState *m = s->mixed;
  const LthMixed *system = m->system;
  const LitheCount n = system->n_dofs;
  const double all = sqrt(lth_dot(threads, n, b, b));
  if (!m->pressure) return all;
  for (LitheIndex c = 0; c < system->n_cells; c++)
    system->push[c] = is_stiff(system, c) ? take_back(s, reach, c) : 0;
  memcpy(m->scratch, b, sizeof *b * (size_t)n);
  lth_mixed_push(system, threads, -system->ck, false, system->push, m->scratch);
  const double rest = sqrt(lth_dot(threads, n, m->scratch, m->scratch));
  return fmin(all, fmax(rest, all / LTH_PENALTY));
}

/// What the pressures have become, less what the augmented Lagrangian adds at the new place.
static void keep_pressures(const LthStaggered *s, int threads, double reach, const double *x) {
  const LthMixedState *m = s->mixed;
  const LthMixed *system = m->system;
  if (!m->pressure) return;
  lth_mixed_divergence(system, threads, x, system->push);
  for (LitheIndex c = 0; c < system->n_cells; c++) {
    const LitheIndex slot = system->slot[c];
    const double moved = system->push[c], soft = lambda_of(s, system->soft.lambda, c);
    if (is_stiff(system, c))
      m->latest[slot] = m->pressure[slot] +
                        system->ck / reach * (x[system->n_dofs + c] + soft * moved) -
                        lambda_of(s, s->level.lambda, c) * reach * moved;
  }
  lth_mixed_center(s, m->latest);
}

static LitheStatus solve(LitheCtx *ctx, LthDisc *disc, const LthOperator *extra, double reach,
                         const double *rhs, double *w, double tolerance, LitheIndex max_iterations,
                         LthSolveReport *report) {
  const LthStaggered *s = lth_staggered_const(disc);
  LthMixedState *m = s->mixed;
  const int threads = lth_threads(ctx);
  const LitheCount n = disc->n_dofs;
  double *x = lth_mixed_krylov_x(m->krylov), *b = lth_mixed_krylov_b(m->krylov);
  set_right_side(s, reach, rhs, b);
  for (LitheCount i = 0; i < n; i++) x[i] = s->held[i] ? 0 : w[i];
  guess_pressures(s, threads, reach, x);
  const LthMixedStop stop = {.tolerance = tolerance,
                             .size = size_of_load(s, threads, reach, b),
                             .max_iterations = max_iterations,
                             .stiff = STIFF,
                             .start = !(lth_dot(threads, n, x, x) > 0)};
  LITHE_TRY(lth_mixed_krylov_solve(ctx, m->krylov, m->system, extra, &stop, report));
  keep_pressures(s, threads, reach, x);
  memcpy(w, x, sizeof *w * (size_t)n);
  return LITHE_OK;
}

static LitheCount bytes(const LthDisc *disc) {
  const LthMixedState *m = state_of(disc);
  LitheCount sum = lth_mixed_bytes(m->system);
  if (m->krylov) sum += lth_mixed_krylov_bytes(m->krylov);
  return sum + (m->scratch ? 8 * disc->n_dofs : 0);
}

static const LthDiscSolver solver = {.force = force,
                                     .diagonal = diagonal,
                                     .apply = apply,
                                     .prepare = prepare,
                                     .solve = solve,
                                     .aim = aim,
                                     .release = release,
                                     .bytes = bytes};

LitheStatus lth_mixed_solver_create(LitheCtx *ctx, LthStaggered *s) {
  LthMixedState *m = s->mixed;
  LITHE_TRY(lth_mixed_create(ctx, &s->level, s->func, s->disc.n_dofs, &m->system));
  s->solver = m->system->multigrid;
  s->table.solver = &solver;
  if (m->pressure) LTH_NEW(ctx, m->target, s->grid->n_slots);
  if (m->pressure) LTH_NEW(ctx, m->strain, m->n_stiff);
  return LITHE_OK;
}

void lth_mixed_solver_destroy(LitheCtx *ctx, LthStaggered *s) {
  LthMixedState *m = s->mixed;
  if (!m) return;
  lth_mixed_krylov_destroy(ctx, &m->krylov);
  lth_mixed_destroy(ctx, &m->system);
  lth_free(ctx, m->target);
  lth_free(ctx, m->strain);
  lth_free(ctx, m->scratch);
}
