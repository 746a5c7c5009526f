/// The life of a staggered multigrid solver: what is allocated when, and coefficients of all levels.
#include "disc/staggered/staggered_multigrid_priv.h"

#include <math.h>
#include <string.h>

#define CONTRAST 30          // of stiffness, up to which coarser grids are not doubted
#define TRIAL_TOLERANCE 1e-8 // what a trial has to come to
#define TRIAL_ITERATIONS 20

/// Unknowns up to which the coarsest level is worth a factor.
static LitheCount factor_limit(int dim) { return dim == 3 ? 30000 : 200000; }

LitheStatus lth_staggered_multigrid_create(LitheCtx *ctx, const LthStaggeredMultigridDef *def,
                                           LthStaggeredMultigrid **multigrid) {
  LitheStatus status = LITHE_OK;
  LTH_NEW(ctx, *multigrid, 1);
  LthStaggeredMultigrid *M = *multigrid;
  M->def = *def;
  M->fine = *def->level;
  M->n_levels = 1;
  LITHE_TRY_OR(done, lth_fast_level_analyse(ctx, &M->fine, &M->level[0]));
  M->width = lth_fast_width(&M->level[0]);
  LitheCount n = M->level[0].n_rows * M->width;
  LTH_NEW_OR(done, ctx, M->p, n);
  LTH_NEW_OR(done, ctx, M->work, n);
  LTH_NEW_OR(done, ctx, M->sum, M->level[0].n_active);
done:
  if (status != LITHE_OK) lth_staggered_multigrid_destroy(ctx, multigrid);
  return status;
}

void lth_staggered_multigrid_destroy(LitheCtx *ctx, LthStaggeredMultigrid **multigrid) {
  LthStaggeredMultigrid *M = *multigrid;
  if (!M) return;
  lth_staggered_coarsest_free(ctx, &M->coarsest);
  lth_staggered_clusters_destroy(ctx, &M->clusters);
  for (int l = 0; l < LTH_STAGGERED_MAX_LEVELS; l++) {
    lth_fast_level_free(ctx, &M->level[l]);
    lth_free(ctx, M->vectors[l]);
  }
  lth_staggered_hierarchy_destroy(ctx, &M->hierarchy);
  lth_free(ctx, M->p);
  lth_free(ctx, M->r);
  lth_free(ctx, M->work);
  lth_free(ctx, M->sum);
  lth_free(ctx, M->extra_x);
  lth_free(ctx, M->extra_y);
  lth_free(ctx, M);
  *multigrid = NULL;
}

void lth_staggered_multigrid_release(LitheCtx *ctx, LthStaggeredMultigrid *M) {
  LthFastLevel *L = &M->level[0];
  lth_staggered_coarsest_free(ctx, &M->coarsest);
  lth_staggered_clusters_destroy(ctx, &M->clusters);
  for (int l = 0; l < M->n_levels; l++) {
    if (l > 0) lth_fast_level_free(ctx, &M->level[l]);
    lth_free(ctx, M->vectors[l]);
    M->vectors[l] = NULL;
  }
  lth_staggered_hierarchy_destroy(ctx, &M->hierarchy);
  lth_fast_level_unlink(ctx, L);
  lth_free(ctx, L->constant);
  lth_free(ctx, L->sample);
  lth_free(ctx, L->inertia);
  lth_free(ctx, L->inverse);
  lth_free(ctx, M->r);
  L->constant = L->sample = L->inertia = L->inverse = NULL;
  M->r = NULL;
  M->n_levels = 1;
}

/// Level 0 shares its x and y with q, row by row; the others have x, y and b of their own.
static LitheStatus lend_vectors(LitheCtx *ctx, LthStaggeredMultigrid *M, int l) {
  LthFastLevel *L = &M->level[l];
  LitheCount n = lth_fast_width(L);
  int own = l == 0 ? 1 : 3;
  LTH_NEW(ctx, M->vectors[l], own * n * L->n_rows);
  float *at = M->vectors[l], *work = (float *)M->work;
  L->x = l == 0 ? (LthFastVector){work, 2 * n} : (LthFastVector){at, 3 * n};
  L->y = l == 0 ? (LthFastVector){work + n, 2 * n} : (LthFastVector){at + n, 3 * n};
  L->b = l == 0 ? (LthFastVector){at, n} : (LthFastVector){at + 2 * n, 3 * n};
  return LITHE_OK;
}

/// What is below the last level: its factor, or rigid clusters.
static LitheStatus build_bottom(LitheCtx *ctx, LthStaggeredMultigrid *M) {
  LthFastLevel *last = &M->level[M->n_levels - 1];
  LitheCount most = M->def.factored > 0 ? M->def.factored : factor_limit(M->fine.grid->dim);
  LITHE_TRY(lth_staggered_coarsest_create(ctx, last, most, &M->coarsest));
  if (M->coarsest.A || M->hierarchy->n_free[M->n_levels - 1] == 0) return LITHE_OK;
  return lth_staggered_clusters_create(ctx, last, most, &M->clusters);
}

static LitheStatus build_levels(LitheCtx *ctx, LthStaggeredMultigrid *M) {
  LITHE_TRY(lth_staggered_hierarchy_create(ctx, &M->fine, NULL, &M->hierarchy));
  LTH_NEW(ctx, M->r, M->level[0].n_rows * M->width);
  for (int l = 1; l < M->hierarchy->n_levels; l++, M->n_levels++)
    LITHE_TRY(lth_fast_level_analyse(ctx, &M->hierarchy->level[l], &M->level[l]));
  for (int l = 0; l < M->n_levels; l++) LITHE_TRY(lend_vectors(ctx, M, l));
  for (int l = 0; l + 1 < M->n_levels; l++)
    LITHE_TRY(lth_fast_level_link(ctx, &M->level[l], &M->level[l + 1]));
  for (int l = 0; l < M->n_levels; l++) lth_fast_level_clear(ctx, &M->level[l]);
  return build_bottom(ctx, M);
}

/// The finest level alone, for bodies that coarser grids do not help.
static LitheStatus drop_levels(LitheCtx *ctx, LthStaggeredMultigrid *M) {
  const LthCoarsenDef none = {.enough = INT64_MAX};
  lth_staggered_coarsest_free(ctx, &M->coarsest);
  lth_staggered_clusters_destroy(ctx, &M->clusters);
  for (int l = 1; l < M->n_levels; l++) {
    lth_fast_level_free(ctx, &M->level[l]);
    lth_free(ctx, M->vectors[l]);
    M->vectors[l] = NULL;
  }
  M->n_levels = 1;
  lth_staggered_hierarchy_destroy(ctx, &M->hierarchy);
  LITHE_TRY(lth_staggered_hierarchy_create(ctx, &M->fine, &none, &M->hierarchy));
  lth_fast_level_unlink(ctx, &M->level[0]);
  return build_bottom(ctx, M);
}

/// Largest coefficient: what single precision is measured in.
static double unit_of(const LthStaggeredMultigrid *M, double cm, double ck) {
  const LthStaggeredLevel *l = &M->fine;
  double mu = 0, rho = 0, h = l->grid->h[0];
  for (LitheCount s = 0; s < (LitheCount)l->n_rows * l->grid->side; s++) {
    mu = fmax(mu, l->mu[s]);
    rho = fmax(rho, l->mass[0][s]);
  }
  return lth_sparse_grid_cell_volume(l->grid) * (cm * rho + ck * mu / (h * h));
}

/// Steps of a smoother: shear is the softer against the diagonal the closer nu comes to 0.5.
static int degree_of(const LthStaggeredMultigrid *M) {
  double ratio = 0;
  if (M->def.degree > 0) return M->def.degree;
  for (LitheCount s = 0; s < (LitheCount)M->fine.n_rows * M->fine.grid->side; s++)
    if (M->fine.mu[s] > 0) ratio = fmax(ratio, M->fine.lambda[s] / M->fine.mu[s]);
  return (int)fmin(20, round(3 * sqrt(2 + ratio)));
}

/// Greatest over least stiffness of cells that hold something.
static double contrast_of(const LthStaggeredMultigrid *M) {
  const LthStaggeredLevel *l = &M->fine;
  double least = INFINITY, greatest = 0;
  for (LitheCount s = 0; l->volume && s < (LitheCount)l->n_rows * l->grid->side; s++) {
    if (!(l->mu[s] > 0 && l->volume[s] > 0)) continue;
    least = fmin(least, l->mu[s] / l->volume[s]);
    greatest = fmax(greatest, l->mu[s] / l->volume[s]);
  }
  return greatest > 0 ? greatest / least : 1;
}

static LitheStatus set_coefficients(LitheCtx *ctx, LthStaggeredMultigrid *M) {
  for (int l = 0; l < M->n_levels; l++) {
    LITHE_TRY(lth_fast_level_reserve(ctx, &M->level[l], M->cm != 0));
    lth_fast_level_set(ctx, &M->level[l], M->cm, M->ck, M->unit);
  }
  if (M->clusters) return lth_staggered_clusters_set(ctx, M->clusters, M->cm, M->ck, M->unit);
  return lth_staggered_coarsest_set(ctx, &M->coarsest, M->cm, M->ck, M->unit);
}

/// Where stiffness jumps, grids may do well or not at all: stiff parts that touch what is held are no trouble, those that
/// float are. A trial shows it, once.
static LitheStatus try_levels(LitheCtx *ctx, LthStaggeredMultigrid *M) {
  bool reached;
  if (M->n_levels == 1 || contrast_of(M) < CONTRAST) return LITHE_OK;
  LITHE_TRY(lth_staggered_multigrid_trial(ctx, M, TRIAL_TOLERANCE, TRIAL_ITERATIONS, &reached));
  if (reached) return LITHE_OK;
  LITHE_TRY(drop_levels(ctx, M));
  return set_coefficients(ctx, M);
}

LitheStatus lth_staggered_multigrid_prepare(LitheCtx *ctx, LthStaggeredMultigrid *M, double cm,
                                            double ck) {
  bool built = M->hierarchy != NULL;
  if (!built) LITHE_TRY(build_levels(ctx, M));
  if (built && M->cm == cm && M->ck == ck) return LITHE_OK;
  M->cm = cm;
  M->ck = ck;
  M->unit = unit_of(M, cm, ck);
  M->degree = degree_of(M);
  LITHE_TRY(set_coefficients(ctx, M));
  return built ? LITHE_OK : try_levels(ctx, M);
}

void lth_staggered_multigrid_apply(LthStaggeredMultigrid *M, int threads, double cm, double ck,
                                   bool held, const double *x, double *y) {
  const LthFastLevel *L = &M->level[0];
  const LthFastKernels *k = L->kernels;
  lth_staggered_scatter(M, threads, false, x, M->p);
#pragma omp parallel for schedule(static) num_threads(threads)
  for (LitheIndex i = 0; i < L->n_active; i++)
    k->apply(L, L->active[i], cm, ck, held, M->p, M->work);
  lth_staggered_gather(M, threads, held, M->work, y);
}

LitheCount lth_staggered_multigrid_bytes(const LthStaggeredMultigrid *M) {
  LitheCount values = M->level[0].n_rows * M->width, bytes = 16 * values;
  if (M->r) bytes += 8 * values + lth_staggered_hierarchy_bytes(M->hierarchy);
  if (M->extra_x) bytes += 16 * M->def.n_dofs;
  if (M->clusters) bytes += lth_staggered_clusters_bytes(M->clusters);
  for (int l = 0; l < M->n_levels; l++) {
    bytes += lth_fast_level_bytes(&M->level[l]);
    if (M->vectors[l]) bytes += (l == 0 ? 4 : 12) * (LitheCount)M->level[l].n_rows * M->width;
  }
  return bytes;
}

LitheCount lth_staggered_multigrid_apply_bytes(const LthStaggeredMultigrid *M) {
  const LthFastLevel *L = &M->level[0];
  const LitheCount side = L->grid->side, samples = lth_fast_samples(L);
  const LitheCount row = side * L->grid->dim + 2 * (LitheCount)sizeof(LitheIndex);
  return 16 * L->n_rows * M->width + 8 * L->level->n_rows * samples * side + L->n_general * row;
}

int lth_staggered_multigrid_levels(const LthStaggeredMultigrid *M) { return M->n_levels; }

LitheCount lth_staggered_multigrid_unknowns(const LthStaggeredMultigrid *M, int level) {
  return M->hierarchy ? M->hierarchy->n_free[level] : 0;
}
