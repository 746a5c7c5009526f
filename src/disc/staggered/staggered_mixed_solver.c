/// Solves of a body in the mixed form: LthDiscSolver on top of its multigrid (docs/theory/staggered-mixed.md).
///
/// The caller sees displacements alone. Where lambda is finite the answer is that of the displacement form, to its own
/// measure of the residual. Where nu = 0.5 the divergence at the new place is zero, and the pressure that this takes is
/// kept for the next linearisation (staggered_mixed_state.c).
#include "disc/staggered/staggered_mixed_state.h"

#include <math.h>
#include <string.h>

#define STAND_IN                                                                                   \
  0.1 // of the extra operator's diagonal, in the levels: all of it holds what points do not see
#define STIFF 10 // lambda over mu by which the divergence weighs in the residual where nu = 0.5

static LthMixedState *state_of(const LthDisc *disc) { return lth_staggered_of(disc)->mixed; }

static void force(const LthDisc *disc, int threads, const double *x, double *f) {
  state_of(disc)->base->force(disc, threads, x, f);
  lth_mixed_add_force(lth_staggered_const(disc), 1, f);
}

static void diagonal(const LthDisc *disc, double cm, double ck, double *d) {
  state_of(disc)->base->diagonal(disc, cm, ck, d);
}

static void apply(const LthDisc *disc, int threads, double cm, double ck, const double *x,
                  double *y) {
  state_of(disc)->base->apply(disc, threads, cm, ck, x, y);
}

static LitheStatus allocate(LitheCtx *ctx, const LthStaggered *s, LthMixedState *m) {
  if (!m->krylov) LITHE_TRY(lth_mixed_krylov_create(ctx, &m->grid->level[0], &m->krylov));
  if (!m->from) LTH_NEW(ctx, m->from, s->disc.n_dofs);
  if (!m->to) LTH_NEW(ctx, m->to, s->disc.n_dofs);
  return LITHE_OK;
}

static LitheStatus prepare(LitheCtx *ctx, LthDisc *disc, double cm, double ck) {
  LthStaggered *s = lth_staggered_of(disc);
  LthMixedState *m = s->mixed;
  m->ck = ck;
  if (m->grid && m->inertia == cm / ck) return LITHE_OK;
  if (m->grid && (cm == 0 || m->grid->level[0].mass[0])) {
    LITHE_TRY(lth_mixed_grid_update(ctx, m->grid, cm, ck));
  } else {
    lth_mixed_grid_destroy(ctx, &m->grid);
    LITHE_TRY(lth_mixed_grid_create(ctx, &s->level, cm, ck, &m->grid));
  }
  LITHE_TRY(allocate(ctx, s, m));
  m->inertia = cm / ck;
  return LITHE_OK;
}

static LitheStatus aim(LitheCtx *ctx, LthDisc *disc, const double *u) {
  const LthMixedState *m = state_of(disc);
  if (!m->pressure) return LITHE_OK;
  disc->table->volume->strain(disc, lth_threads(ctx), u, m->strain);
  LITHE_TRY(disc->table->volume->admit(ctx, disc, u, m->strain));
  for (LitheIndex i = 0; i < m->n_stiff; i++) m->target[m->stiff[i]] = m->strain[i];
  return LITHE_OK;
}

/// Unknowns of the body to those of the level; 0 where they are not free.
static void scatter(const LthStaggered *s, int threads, double c, const double *x, double *to) {
  const LthMixedLevel *l = &s->mixed->grid->level[0];
#pragma omp parallel for schedule(static) num_threads(threads)
  for (LitheIndex i = 0; i < s->disc.n_funcs; i++)
    for (int a = 0; a < s->dim; a++) {
      const LitheCount slot = s->slot[i];
      bool is_free = l->flags[slot] & LTH_MIXED_FREE << a;
      to[a * l->stride + slot] = is_free ? c * x[3 * (LitheCount)i + a] : 0;
    }
}

static void gather(const LthStaggered *s, int threads, const double *from, double *x) {
  const LthMixedLevel *l = &s->mixed->grid->level[0];
#pragma omp parallel for schedule(static) num_threads(threads)
  for (LitheIndex i = 0; i < s->disc.n_funcs; i++)
    for (int a = 0; a < 3; a++)
      x[3 * (LitheCount)i + a] = a < s->dim ? from[a * l->stride + s->slot[i]] : 0;
}

/// Volume of a cell times ck: what rows of the levels are divided by.
static double unit_of(const LthStaggered *s) {
  return lth_sparse_grid_cell_volume(s->grid) * s->mixed->ck;
}

typedef struct Extra {
  const LthStaggered *s;
  const LthOperator *extra;
} Extra;

static void subtract_extra(const void *self, int threads, const double *x, double *r) {
  const Extra *e = self;
  const LthStaggered *s = e->s;
  const LthMixedLevel *l = &s->mixed->grid->level[0];
  const double per_unit = 1 / unit_of(s);
  gather(s, threads, x, s->mixed->from);
  e->extra->apply(e->extra->self, threads, s->mixed->from, s->mixed->to);
  for (int a = 0; a < s->dim && l->spring[a];
       a++) // the levels' stand-in goes, what it stands for comes
#pragma omp parallel for schedule(static) num_threads(threads)
    for (LitheCount c = 0; c < l->n; c++)
      if (l->flags[c] & LTH_MIXED_FREE << a)
        r[a * l->stride + c] += (double)l->spring[a][c] * x[a * l->stride + c];
#pragma omp parallel for schedule(static) num_threads(threads)
  for (LitheIndex i = 0; i < s->disc.n_funcs; i++)
    for (int a = 0; a < s->dim; a++)
      if (l->flags[s->slot[i]] & LTH_MIXED_FREE << a)
        r[a * l->stride + s->slot[i]] -= per_unit * s->mixed->to[3 * (LitheCount)i + a];
}

static LitheStatus stiffen(LitheCtx *ctx, LthDisc *disc, const double *diagonal) {
  const LthStaggered *s = lth_staggered_const(disc);
  LthMixedState *m = s->mixed;
  LthMixedLevel *l = &m->grid->level[0];
  if (!diagonal && !l->spring[0]) return LITHE_OK;
  memset(l->r, 0, sizeof *l->r * (size_t)lth_mixed_size(l));
  if (diagonal) scatter(s, lth_threads(ctx), STAND_IN / unit_of(s), diagonal, l->r);
  return lth_mixed_grid_stiffen(ctx, m->grid, m->inertia);
}

static bool is_stiff(const LthMixedLevel *l, LitheIndex c) {
  return (l->flags[c] & LTH_MIXED_PRESSURE) && l->compliance[c] == 0;
}

/// Constraint rows: at nu = 0.5 the divergence where positions would be for w = 0 is to vanish.
static void set_constraints(const LthStaggered *s, double reach, double *b) {
  const LthMixedLevel *l = &s->mixed->grid->level[0];
  double *g = b + l->dim * l->stride;
  for (LitheIndex c = 0; c < l->n; c++)
    g[c] = is_stiff(l, c) ? -l->volume[c] * s->mixed->target[c] / reach : 0;
}

/// First pressures: what the divergence of w makes; at nu = 0.5 what takes back the augmented Lagrangian's part of
/// the right-hand side.
static void guess_pressures(const LthStaggered *s, double reach, double *x) {
  const LthMixedState *m = s->mixed;
  const LthMixedLevel *l = &m->grid->level[0];
  double *p = x + l->dim * l->stride;
  for (LitheIndex c = 0; c < l->n; c++) {
    p[c] = 0;
    if (is_stiff(l, c))
      p[c] = -reach / m->ck * s->level.lambda[c] / s->level.volume[c] * m->target[c];
    else if (l->flags[c] & LTH_MIXED_PRESSURE)
      p[c] = l->volume[c] / l->compliance[c] * lth_mixed_divergence(l, c, x);
  }
}

/// Size of the right-hand side without the augmented Lagrangian's part, which would hide all else where the divergence
/// is yet to be mended.
static double size_of_load(const LthStaggered *s, int threads, const double *x, const double *b) {
  LthMixedLevel *l = &s->mixed->grid->level[0];
  const double *p = x + l->dim * l->stride;
  const LitheCount n = l->dim * l->stride;
  double all = sqrt(lth_dot(threads, n, b, b));
  if (!s->mixed->pressure) return all;
  for (LitheIndex c = 0; c < l->n; c++)
    for (int a = 0; a < l->dim; a++) {
      const LitheIndex low = l->next[2 * a][c];
      double push = 0;
      if (is_stiff(l, low)) push += l->volume[low] * p[low];
      if (is_stiff(l, c)) push -= l->volume[c] * p[c];
      bool is_free = l->flags[c] & LTH_MIXED_FREE << a;
      l->r[a * l->stride + c] = is_free ? b[a * l->stride + c] - push * l->per_h[a] : 0;
    }
  double rest = sqrt(lth_dot(threads, n, l->r, l->r));
  return fmin(all, fmax(rest, all / LTH_PENALTY));
}

/// What the pressures have become, less what the augmented Lagrangian adds at the new place.
static void keep_pressures(const LthStaggered *s, double reach, const double *x) {
  const LthMixedState *m = s->mixed;
  const LthMixedLevel *l = &m->grid->level[0];
  for (LitheIndex c = 0; m->pressure && c < l->n; c++) {
    if (!(l->flags[c] & LTH_MIXED_PRESSURE) || l->compliance[c] != 0) continue;
    double moved = reach * lth_mixed_divergence(l, c, x);
    m->latest[c] = m->pressure[c] + m->ck / reach * x[l->dim * l->stride + c] -
                   s->level.lambda[c] / s->level.volume[c] * moved;
  }
  if (m->pressure) lth_mixed_center(s, m->latest);
}

static LitheStatus solve(LitheCtx *ctx, LthDisc *disc, const LthOperator *extra, double reach,
                         const double *rhs, double *w, double tolerance, LitheIndex max_iterations,
                         LthSolveReport *report) {
  const LthStaggered *s = lth_staggered_const(disc);
  LthMixedState *m = s->mixed;
  const int threads = lth_threads(ctx);
  double *x = lth_mixed_krylov_x(m->krylov), *b = lth_mixed_krylov_b(m->krylov);
  const Extra self = {s, extra};
  const LthMixedExtra more = {subtract_extra, &self};
  LthMixedStop stop = {.tolerance = tolerance,
                       .max_iterations = max_iterations,
                       .full = !(lth_dot(threads, disc->n_dofs, w, w) > 0),
                       .primal = true,
                       .stiff = STIFF};
  scatter(s, threads, 1, w, x);
  scatter(s, threads, 1 / unit_of(s), rhs, b);
  set_constraints(s, reach, b);
  guess_pressures(s, reach, x);
  stop.size = size_of_load(s, threads, x, b);
  LITHE_TRY(lth_mixed_krylov_solve(ctx, m->krylov, m->grid, extra ? &more : NULL, &stop, report));
  keep_pressures(s, reach, x);
  gather(s, threads, x, w);
  return LITHE_OK;
}

static LitheCount bytes(const LthDisc *disc) {
  const LthMixedState *m = state_of(disc);
  LitheCount sum = m->base->bytes(disc);
  if (m->grid) sum += lth_mixed_grid_bytes(m->grid);
  if (m->krylov) sum += lth_mixed_krylov_bytes(m->krylov);
  return sum;
}

static const LthDiscSolver solver = {.force = force,
                                     .diagonal = diagonal,
                                     .apply = apply,
                                     .prepare = prepare,
                                     .solve = solve,
                                     .aim = aim,
                                     .stiffen = stiffen,
                                     .bytes = bytes};

LitheStatus lth_mixed_solver_create(LitheCtx *ctx, LthStaggered *s) {
  LthMixedState *m = s->mixed;
  m->base = s->table.solver;
  s->table.solver = &solver;
  if (m->pressure) LTH_NEW(ctx, m->target, s->grid->n_slots);
  if (m->pressure) LTH_NEW(ctx, m->strain, m->n_stiff);
  return LITHE_OK;
}

void lth_mixed_solver_destroy(LitheCtx *ctx, LthStaggered *s) {
  LthMixedState *m = s->mixed;
  if (!m) return;
  if (m->base) s->table.solver = m->base;
  lth_mixed_krylov_destroy(ctx, &m->krylov);
  lth_mixed_grid_destroy(ctx, &m->grid);
  lth_free(ctx, m->target);
  lth_free(ctx, m->strain);
  lth_free(ctx, m->from);
  lth_free(ctx, m->to);
}
