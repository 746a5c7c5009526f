/// Smoothing, the V-cycle and full multigrid, all in single precision.
/// Smoother: Chebyshev polynomials of the fourth kind (Lottes 2023), which need an upper bound of the spectrum alone.
#include "disc/staggered/staggered_multigrid_priv.h"

#define STIFF_DEGREE 10 ///< of smoothers from nu = 0.45 on

/// Step `i` = 1, 2, ... of a smoother for eigenvalues in (0, greatest].
static LthFastStep step_of(const LthFastLevel *L, int i) {
  double k = 2 * i + 1;
  return (LthFastStep){.momentum = i == 1 ? 0 : (float)((2 * i - 3) / k),
                       .length = (float)((8 * i - 4) / (k * L->greatest)),
                       .fresh = i == 1};
}

// Work is counted in applications of the finest level's operator in double precision, which touches 16 bytes an unknown. A step
// of the smoother touches as many and counts as one, and so does a residual, which touches 12. What applies no operator counts
// by bytes.

static double share_of(const LthStaggeredMultigrid *M, int l) {
  return (double)M->hierarchy->n_free[l] / (double)M->hierarchy->n_free[0];
}

static void swap_vectors(LthFastLevel *L) {
  LthFastVector x = L->x;
  L->x = L->y;
  L->y = x;
}

/// Steps first ... last of a smoother; sums of b . x of the last one in `sum`, where not NULL.
static void smooth(LitheCtx *ctx, LthStaggeredMultigrid *M, int l, int first, int last,
                   double *sum) {
  LthFastLevel *L = &M->level[l];
  const LthFastKernels *k = L->kernels;
  M->work_done += share_of(M, l) * (last - first + 1);
  for (int i = first; i <= last; i++) {
    LthFastStep step = step_of(L, i);
    if (first == 2 && i == 2) step.fresh = true; // the iterate before was zero
    step.product = sum && i == last;
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
    for (LitheIndex b = 0; b < L->n_active; b++) {
      double product = k->smooth(L, L->active[b], step);
      if (sum) sum[b] = product;
    }
    swap_vectors(L);
  }
}

static void start(LitheCtx *ctx, LthStaggeredMultigrid *M, int l) {
  LthFastLevel *L = &M->level[l];
  const LthFastKernels *k = L->kernels;
  M->work_done += 0.5 * share_of(M, l);
  float length = step_of(L, 1).length;
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheIndex b = 0; b < L->n_active; b++) k->start(L, L->active[b], length);
}

/// Right-hand side of the coarser level: the residual, or (`of_b`) the right-hand side.
static void restrict_down(LitheCtx *ctx, LthStaggeredMultigrid *M, int l, bool of_b) {
  const LthFastLevel *L = &M->level[l], *coarse = L + 1;
  const LthFastKernels *k = L->kernels;
  M->work_done += (of_b ? 0.75 : 1.25) * share_of(M, l) + 0.25 * share_of(M, l + 1);
#pragma omp parallel num_threads(lth_threads(ctx))
  {
#pragma omp for schedule(static)
    for (LitheIndex b = 0; b < L->n_active; b++) (of_b ? k->weigh : k->residual)(L, L->active[b]);
#pragma omp for schedule(static)
    for (LitheIndex b = 0; b < coarse->n_active; b++) k->restrict_to(L, coarse, coarse->active[b]);
  }
}

static void prolong_up(LitheCtx *ctx, LthStaggeredMultigrid *M, int l, bool add) {
  const LthFastLevel *L = &M->level[l], *coarse = L + 1;
  const LthFastKernels *k = L->kernels;
  M->work_done += (add ? 0.5 : 0.25) * share_of(M, l) + 0.25 * share_of(M, l + 1);
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheIndex b = 0; b < coarse->grid->n_blocks; b++) k->prolong_from(L, coarse, b, add);
}

/// x of the coarsest level by its factor.
static LitheStatus solve_coarsest(LthFastLevel *L, LitheCtx *ctx, LthStaggeredMultigrid *M,
                                  double *sum) {
  M->work_done +=
      lth_staggered_coarsest_bytes(&M->coarsest) / (16.0 * (double)M->hierarchy->n_free[0]);
  LITHE_TRY(lth_staggered_coarsest_solve(ctx, &M->coarsest));
  for (LitheIndex i = 0; sum && i < L->n_active; i++) {
    LitheIndex b = L->active[i];
    sum[i] = 0;
    for (LitheIndex q = L->first[b]; q < L->first[b + 1]; q++)
      for (LitheCount j = 0; j < M->width; j++)
        sum[i] += (double)L->b.at[q * L->b.stride + j] * L->x.at[q * L->x.stride + j];
  }
  return LITHE_OK;
}

/// Steps of the smoother before and after a correction.
typedef struct Steps {
  int before, after;
} Steps;

static LitheStatus run_cycle(LitheCtx *ctx, LthStaggeredMultigrid *M, int l, const Steps *steps,
                             bool from_zero, double *sum);

/// x += what the coarser level, or that of rigid clusters, makes of the residual.
static LitheStatus correct(LitheCtx *ctx, LthStaggeredMultigrid *M, int l, const Steps *steps) {
  LthFastLevel *L = &M->level[l];
  if (l < M->n_levels - 1) {
    restrict_down(ctx, M, l, false);
    LITHE_TRY(run_cycle(ctx, M, l + 1, steps, true, NULL));
    prolong_up(ctx, M, l, true);
    return LITHE_OK;
  }
  if (!M->clusters) return LITHE_OK;
  const LthFastKernels *k = L->kernels;
  M->work_done += share_of(M, l);
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheIndex b = 0; b < L->n_active; b++) k->residual(L, L->active[b]);
  return lth_staggered_clusters_correct(ctx, M->clusters);
}

static LitheStatus run_cycle(LitheCtx *ctx, LthStaggeredMultigrid *M, int l, const Steps *steps,
                             bool from_zero, double *sum) {
  LthFastLevel *L = &M->level[l];
  if (l == M->n_levels - 1 && M->coarsest.A) return solve_coarsest(L, ctx, M, sum);
  if (from_zero) start(ctx, M, l);
  smooth(ctx, M, l, from_zero ? 2 : 1, steps->before, NULL);
  LITHE_TRY(correct(ctx, M, l, steps));
  smooth(ctx, M, l, 1, steps->after, sum);
  return LITHE_OK;
}

LitheStatus lth_staggered_cycle(LitheCtx *ctx, LthStaggeredMultigrid *M, double *product) {
  const Steps same = {M->degree, M->degree};
  LITHE_TRY(run_cycle(ctx, M, 0, &same, true, M->sum));
  *product = lth_staggered_sum(M);
  return LITHE_OK;
}

/// What a pass of full multigrid does on a level. The start is smooth but for what interpolation adds, and that has to be gone before
/// a residual is restricted, while a correction leaves little: all steps are before. The cycle need not be symmetric here.
/// One cycle does in the plane; a second one below the finest level is cheap, an eighth of a cycle in space and a third in the plane,
/// and is taken there and near nu = 1/2, where interpolation adds more (test_staggered_full.c).
typedef struct Pass {
  Steps steps;
  int coarse_cycles; ///< on every level but the finest
} Pass;

static Pass pass_of(const LthStaggeredMultigrid *M) {
  const bool space = M->fine.grid->dim == 3, stiff = M->degree >= STIFF_DEGREE;
  const int before = !stiff ? M->degree + 1 : (space ? 14 : 9) * M->degree / 10;
  return (Pass){.steps = {before, 0}, .coarse_cycles = space || stiff ? 2 : 1};
}

LitheStatus lth_staggered_full(LitheCtx *ctx, LthStaggeredMultigrid *M) {
  const int last = M->n_levels - 1;
  const Steps same = {M->degree, M->degree};
  const Pass pass = pass_of(M);
  for (int l = 0; l < last; l++) restrict_down(ctx, M, l, true);
  LITHE_TRY(run_cycle(ctx, M, last, &same, true, NULL));
  for (int l = last - 1; l >= 0; l--) {
    prolong_up(ctx, M, l, false);
    for (int i = 0; i < (l > 0 ? pass.coarse_cycles : 1); i++)
      LITHE_TRY(run_cycle(ctx, M, l, &pass.steps, false, NULL));
  }
  return LITHE_OK;
}
