/// Matrix-free solves of a linear staggered body in displacement form: LthDiscSolver on top of the multigrid.
#include "disc/staggered/staggered_entries.h"
#include "disc/staggered/staggered_multigrid.h"
#include "disc/staggered/staggered_priv.h"

static LthStaggeredMultigrid *multigrid_of(const LthDisc *disc) {
  return lth_staggered_of(disc)->solver;
}

/// Internal force, also at what is held: what its supports carry.
static void force(const LthDisc *disc, int threads, const double *x, double *f) {
  lth_staggered_rest(disc, f);
#pragma omp parallel for schedule(static) num_threads(threads)
  for (LitheCount i = 0; i < disc->n_dofs; i++) f[i] = x[i] - f[i];
  lth_staggered_multigrid_apply(multigrid_of(disc), threads, 0, 1, true, f, f);
}

static void diagonal(const LthDisc *disc, double cm, double ck, double *d) {
  const LthStaggered *s = lth_staggered_const(disc);
#pragma omp parallel for schedule(static) num_threads(lth_threads(s->ctx))
  for (LitheIndex i = 0; i < disc->n_funcs; i++)
    for (int a = 0; a < 3; a++) {
      LthStaggeredEntry entry[LTH_STAGGERED_ROW];
      LitheCount slot = s->slot[i];
      d[3 * (LitheCount)i + a] = 0;
      if (a >= s->dim || s->level.state[a][slot] != LTH_UNKNOWN_FREE) continue;
      lth_staggered_row(&s->level, cm, ck, a, slot, entry);
      d[3 * (LitheCount)i + a] = entry[0].value;
    }
}

static void apply(const LthDisc *disc, int threads, double cm, double ck, const double *x,
                  double *y) {
  lth_staggered_multigrid_apply(multigrid_of(disc), threads, cm, ck, false, x, y);
}

static LitheStatus prepare(LitheCtx *ctx, LthDisc *disc, double cm, double ck) {
  return lth_staggered_multigrid_prepare(ctx, multigrid_of(disc), cm, ck);
}

static LitheStatus solve(LitheCtx *ctx, LthDisc *disc, const LthOperator *extra, double reach,
                         const double *rhs, double *w, double tolerance, LitheIndex max_iterations,
                         LthSolveReport *report) {
  (void)reach; // positions do not matter: the operator is that of a linear body
  return lth_staggered_multigrid_solve(ctx, multigrid_of(disc), extra, rhs, w, tolerance,
                                       max_iterations, report);
}

static void release(LitheCtx *ctx, LthDisc *disc) {
  lth_staggered_multigrid_release(ctx, multigrid_of(disc));
}

static LitheCount bytes(const LthDisc *disc) {
  return lth_staggered_multigrid_bytes(multigrid_of(disc));
}

const LthDiscSolver lth_staggered_own_solver = {.force = force,
                                                .diagonal = diagonal,
                                                .apply = apply,
                                                .prepare = prepare,
                                                .solve = solve,
                                                .release = release,
                                                .bytes = bytes};

LitheStatus lth_staggered_solver_create(LitheCtx *ctx, LthStaggered *s) {
  const LthStaggeredMultigridDef def = {
      .level = &s->level, .func = s->func, .n_dofs = s->disc.n_dofs};
  LthStaggeredMultigrid *multigrid = NULL;
  LITHE_TRY(lth_staggered_multigrid_create(ctx, &def, &multigrid));
  s->solver = multigrid;
  s->table.solver = &lth_staggered_own_solver;
  return LITHE_OK;
}

void lth_staggered_solver_destroy(LitheCtx *ctx, LthStaggered *s) {
  LthStaggeredMultigrid *multigrid = s->solver;
  if (s->table.solver == &lth_staggered_own_solver)
    lth_staggered_multigrid_destroy(ctx, &multigrid);
}
