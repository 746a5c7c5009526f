/// Multilevel preconditioner: levels, their update, the cycle (docs/theory/multigrid.md).
#include "la/multilevel.h"

#include "la/ml_priv.h"

#include <math.h>
#include <omp.h>
#include <string.h>

#define COARSE_UNKNOWNS 500 // at most so many are solved for by a dense factor
#define TRIAL 40            // iterations after which a solve is looked at
#define STRONG_DEGREE 3     // of the polynomial smoother, where sweeps do not do
#define STAGNATION 0.8      // a level this large beside the one before is not worth having

/// Unknowns whose row has no entry but the diagonal.
static void find_held(const LthBlockMatrix *A, int threads, uint8_t *held) {
#pragma omp parallel for schedule(static) num_threads(threads)
  for (LitheIndex row = 0; row < A->n_rows; row++) {
    const int m = lth_ml_size(A, row);
    for (int r = 0; r < m; r++) {
      bool coupled = false;
      for (LitheCount e = A->block_off[row]; !coupled && e < A->block_off[row + 1]; e++) {
        const int n = lth_ml_size(A, A->block_col[e]);
        const double *B = A->values + A->value_off[e] + r * n;
        for (int c = 0; c < n; c++) coupled |= B[c] != 0 && !(e == A->diagonal[row] && c == r);
      }
      held[A->row_off[row] + r] = !coupled;
    }
  }
}

/// Translations and rotations about the middle of all, zero at held unknowns: (n x 6).
static void rigid_motions(const double *one, const double *position, const uint8_t *held,
                          LitheCount n, double *near) {
  double middle[3] = {0}, weight = 0;
  for (LitheCount i = 0; i < n / 3; i++) {
    weight += one[i] * one[i];
    for (int a = 0; a < 3; a++) middle[a] += one[i] * position[3 * i + a];
  }
  for (int a = 0; a < 3; a++) middle[a] /= weight > 0 ? weight : 1;
  for (LitheCount i = 0; i < n / 3; i++) {
    double x[3];
    for (int a = 0; a < 3; a++) x[a] = position[3 * i + a] - one[i] * middle[a];
    const double rows[3][LTH_ML_MODES] = {{one[i], 0, 0, 0, x[2], -x[1]},
                                          {0, one[i], 0, -x[2], 0, x[0]},
                                          {0, 0, one[i], x[1], -x[0], 0}};
    for (int a = 0; a < 3; a++)
      for (int k = 0; k < LTH_ML_MODES; k++)
        near[LTH_ML_MODES * (3 * i + a) + k] = held[3 * i + a] ? 0 : rows[a][k];
  }
}

/// Motions that were given, zero at held unknowns.
static void copy_near(const double *given, const uint8_t *held, LitheCount n, double *near) {
  for (LitheCount i = 0; i < LTH_ML_MODES * n; i++) near[i] = held[i / LTH_ML_MODES] ? 0 : given[i];
}

static void free_level(LitheCtx *ctx, LthLevel *l) {
  lth_block_matrix_destroy(ctx, &l->own);
  lth_block_jacobi_destroy(ctx, &l->jacobi);
  lth_ml_free_colours(ctx, &l->colours);
  for (int k = 0; k <= LTH_ML_STEPS; k++) lth_ml_transfer_destroy(ctx, &l->stage[k]);
  lth_free(ctx, l->held);
  lth_free(ctx, l->near);
  lth_free(ctx, l->extra_off);
  lth_free(ctx, l->aggregate);
  lth_free(ctx, l->member_off);
  lth_free(ctx, l->member);
  lth_free(ctx, l->tentative);
  lth_free(ctx, l->lead);
  lth_free(ctx, l->x);
  lth_free(ctx, l->b);
  lth_free(ctx, l->r);
  double *vectors[] = {l->q, l->h, l->v, l->s, l->t, l->e};
  for (int k = 0; k < 6; k++) lth_free(ctx, vectors[k]);
}

void lth_multilevel_destroy(LitheCtx *ctx, LthMultilevel **M) {
  if (!M || !*M) return;
  for (int l = 0; l < LTH_ML_LEVELS; l++) free_level(ctx, &(*M)->level[l]);
  lth_ml_galerkin_free(ctx, &(*M)->galerkin);
  lth_free(ctx, (*M)->dense);
  lth_free(ctx, *M);
  *M = NULL;
}

/// What every level has, and the inverses of its diagonal blocks.
static LitheStatus open_level(LitheCtx *ctx, LthLevel *l, const LthBlockMatrix *A, bool once) {
  l->A = A;
  LTH_NEW(ctx, l->near, LTH_ML_MODES * A->n);
  LTH_NEW(ctx, l->extra_off, A->n_rows + 1);
  for (LitheIndex i = 0; i < A->n_rows; i++)
    l->extra_off[i + 1] = l->extra_off[i] + lth_ml_size(A, i) * lth_ml_size(A, i);
  LTH_NEW(ctx, l->x, A->n);
  LTH_NEW(ctx, l->b, A->n);
  LTH_NEW(ctx, l->r, A->n);
  double **vectors[] = {&l->q, &l->h, &l->v, &l->s, &l->t, &l->e};
  for (int k = 0; k < 6 && !once; k++)
    LITHE_TRY(lth_new_(ctx, (void **)vectors[k], A->n, sizeof **vectors[k]));
  l->size = A->n_rows > 0 ? lth_ml_size(A, 0) : 0;
  for (LitheIndex i = 0; i < A->n_rows; i++)
    if (lth_ml_size(A, i) != l->size) l->size = 0;
  LITHE_TRY(lth_block_jacobi_create(ctx, A, &l->jacobi));
  LITHE_TRY(lth_ml_colour(ctx, A, &l->colours));
  return LITHE_OK;
}

static void copy_leading(const LthLevel *fine, LthLevel *coarse) {
  for (LitheIndex row = 0; row < fine->A->n_rows; row++)
    memcpy(coarse->near + LTH_ML_MODES * coarse->A->row_off[row],
           fine->near + LTH_ML_MODES * fine->A->row_off[row],
           sizeof *fine->near * (size_t)(LTH_ML_MODES * fine->lead[row]));
}

/// Values of the next level from those of this one, whose matrix and motions stand.
static void fill_next(LitheCtx *ctx, const LthMultilevel *M, LthLevel *l, LthLevel *next) {
  const int threads = lth_threads(ctx);
  if (!l->P) {
    lth_ml_leading(l, threads, next->own);
    copy_leading(l, next);
    return;
  }
  lth_ml_tentative(l, threads, l->P->col_off, next->near);
  lth_ml_smooth_prolongator(l, &M->galerkin);
  for (int k = 0; k < LTH_ML_STEPS && M->def.once; k++) lth_ml_transfer_destroy(ctx, &l->stage[k]);
  lth_ml_galerkin(l, &M->galerkin, next->own);
}

/// True where some row has more unknowns than those that span linear functions.
static LitheStatus find_leading(LitheCtx *ctx, LthLevel *l, LitheIndex n_linear, bool *any) {
  *any = false;
  for (LitheIndex row = 0; row < l->A->n_rows; row++)
    *any |= n_linear > 0 && lth_ml_size(l->A, row) > n_linear;
  if (!*any) return LITHE_OK;
  LTH_NEW(ctx, l->lead, l->A->n_rows);
  for (LitheIndex row = 0; row < l->A->n_rows; row++)
    l->lead[row] = lth_ml_size(l->A, row) > n_linear ? n_linear : lth_ml_size(l->A, row);
  return LITHE_OK;
}

/// A row that hangs together with others by `touch` alone is an aggregate of its own: a body of one element.
static void add_touched(LthLevel *l) {
  for (LitheIndex row = 0; l->touch && row < l->A->n_rows; row++)
    if (l->aggregate[row] < 0 && l->touch->block_off[row + 1] - l->touch->block_off[row] > 1)
      l->aggregate[row] = l->n_aggregates++;
}

/// Patterns of the next level; *coarse is NULL where there is none.
static LitheStatus coarsen(LitheCtx *ctx, LthMultilevel *M, LthLevel *l, bool first,
                           LthBlockMatrix **coarse) {
  LitheStatus status = LITHE_OK;
  LitheCount *col_off = NULL;
  bool leading = false;
  *coarse = NULL;
  if (first) LITHE_TRY(find_leading(ctx, l, M->def.n_linear, &leading));
  if (leading) return lth_ml_leading_create(ctx, l, coarse);
  if (l->A->n <= COARSE_UNKNOWNS) return LITHE_OK;
  LTH_NEW(ctx, l->aggregate, l->A->n_rows);
  LITHE_TRY(lth_ml_aggregate(ctx, l->A, M->def.least_rows, l->aggregate, &l->n_aggregates));
  add_touched(l);
  LTH_NEW(ctx, col_off, l->n_aggregates + 1);
  LITHE_TRY_OR(done, lth_ml_tentative_create(ctx, l, col_off));
  LitheCount n = col_off[l->n_aggregates];
  if (n == 0 || (double)n > STAGNATION * (double)l->A->n) goto done;
  LITHE_TRY_OR(done, lth_ml_transfer_create(ctx, l, col_off, &l->stage[0]));
  for (int k = 0; k < LTH_ML_STEPS; k++)
    LITHE_TRY_OR(done, lth_ml_transfer_spread(ctx, l->A, l->stage[k], &l->stage[k + 1]));
  l->P = l->stage[LTH_ML_STEPS];
  LITHE_TRY_OR(done, lth_ml_galerkin_create(ctx, l, &M->galerkin, coarse));
done:
  lth_free(ctx, col_off);
  return status;
}

static void smooth_down(const LthMultilevel *M, const LthLevel *l, int threads, const double *b,
                        double *x) {
  if (M->degree > 0)
    lth_ml_polynomial_down(l, threads, M->degree, b, x, l->r);
  else
    lth_ml_smooth_down(l, threads, b, x, l->r);
}

static void smooth_up(const LthMultilevel *M, const LthLevel *l, int threads, const double *b,
                      double *x) {
  if (M->degree > 0)
    lth_ml_polynomial_up(l, threads, M->degree, b, x);
  else
    lth_ml_smooth_up(l, threads, b, x);
}

/// What only an update would read again.
static void forget(LitheCtx *ctx, LthLevel *l) {
  lth_free(ctx, l->near);
  lth_free(ctx, l->tentative);
  lth_free(ctx, l->aggregate);
  lth_free(ctx, l->member_off);
  lth_free(ctx, l->member);
  l->near = l->tentative = NULL;
  l->aggregate = l->member_off = l->member = NULL;
}

static LitheStatus factor_coarsest(LitheCtx *ctx, LthMultilevel *M) {
  const LthBlockMatrix *A = M->level[M->n_levels - 1].A;
  if (M->dense && !lth_ml_dense_factor(A, M->dense))
    LITHE_FAIL(ctx, LITHE_NOT_CONVERGED,
               "multilevel preconditioner: the matrix is not positive definite; raise the penalty, "
               "constrain the body, or let thin elements be merged (method.sliver)");
  return LITHE_OK;
}

static LitheStatus build(LitheCtx *ctx, LthMultilevel *M) {
  const LthBlockMatrix *A = M->def.A;
  LthLevel *l = M->level;
  LitheStatus status = LITHE_OK;
  const int threads = lth_threads(ctx);
  LITHE_TRY(open_level(ctx, l, A, M->def.once));
  l->touch = M->def.touch;
  LTH_NEW(ctx, l->held, A->n);
  find_held(A, threads, l->held);
  if (M->def.near)
    copy_near(M->def.near, l->held, A->n, l->near);
  else
    rigid_motions(M->def.one, M->def.position, l->held, A->n, l->near);
  for (M->n_levels = 1; M->n_levels < LTH_ML_LEVELS; M->n_levels++, l++) {
    LthBlockMatrix *coarse = NULL;
    LITHE_TRY(lth_block_jacobi_update(ctx, l->jacobi, l->A, NULL));
    status = coarsen(ctx, M, l, M->n_levels == 1, &coarse);
    l[1].own = coarse;
    LITHE_TRY(status);
    if (!coarse) break;
    LITHE_TRY(open_level(ctx, l + 1, coarse, M->def.once));
    fill_next(ctx, M, l, l + 1);
    if (M->def.once) forget(ctx, l);
  }
  if (M->def.once) forget(ctx, l);
  if (M->def.once) lth_ml_galerkin_free(ctx, &M->galerkin);
  if (l->A->n <= 4 * COARSE_UNKNOWNS) LTH_NEW(ctx, M->dense, l->A->n * l->A->n);
  return factor_coarsest(ctx, M);
}

LitheStatus lth_multilevel_create(LitheCtx *ctx, const LthMultilevelDef *def, LthMultilevel **out) {
  LitheStatus status = LITHE_OK;
  LthMultilevel *M = NULL;
  LitheCount before = lth_alloc_bytes(ctx);
  *out = NULL;
  LTH_NEW_OR(done, ctx, M, 1);
  M->def = *def;
  LITHE_TRY_OR(done, build(ctx, M));
  M->def.position = M->def.near = NULL;
  M->bytes = lth_alloc_bytes(ctx) - before;
  *out = M;
  M = NULL;
done:
  lth_multilevel_destroy(ctx, &M);
  return status;
}

LitheStatus lth_multilevel_refresh(LitheCtx *ctx, LthMultilevel *M, const double *extra) {
  M->level[0].extra = extra;
  return lth_block_jacobi_update(ctx, M->level[0].jacobi, M->level[0].A, extra);
}

LitheStatus lth_multilevel_update(LitheCtx *ctx, LthMultilevel *M, const double *position,
                                  const double *extra) {
  LthLevel *l = M->level;
  LITHE_ASSERT(!M->def.once);
  if (position) rigid_motions(M->def.one, position, l->held, l->A->n, l->near);
  LITHE_TRY(lth_multilevel_refresh(ctx, M, NULL)); // the prolongation is that of A
  for (int k = 0; k + 1 < M->n_levels; k++, l++) {
    fill_next(ctx, M, l, l + 1);
    LITHE_TRY(lth_block_jacobi_update(ctx, l[1].jacobi, l[1].A, NULL));
  }
  if (extra) LITHE_TRY(lth_multilevel_refresh(ctx, M, extra));
  return factor_coarsest(ctx, M);
}

void lth_multilevel_strengthen(LthMultilevel *M) {
  LITHE_ASSERT(!M->def.once);
  M->degree = STRONG_DEGREE;
}
bool lth_multilevel_is_strong(const LthMultilevel *M) { return M->degree > 0; }

void lth_multilevel_add(LthMultilevel *M, const LthOperator *C) {
  M->added = C ? *C : (LthOperator){0};
}

/// y = from + extra x - C x on the finest level, in b's place; y may be from.
static void correct(const LthMultilevel *M, int threads, const double *x, const double *from,
                    double *y) {
  const LthLevel *l = M->level;
  double *sum = l->b; // free: the right-hand side of this level is the caller's
#pragma omp parallel for schedule(static) num_threads(threads) if (lth_block_matrix_is_large(l->A))
  for (LitheIndex row = 0; row < l->A->n_rows; row++) {
    const LitheCount at = l->A->row_off[row];
    const int m = lth_ml_size(l->A, row);
    const double *B = l->extra ? l->extra + l->extra_off[row] : NULL;
    for (int i = 0; i < m; i++) {
      double t = 0;
      for (int j = 0; B && j < m; j++) t -= B[i * m + j] * x[at + j];
      sum[at + i] = t;
    }
  }
  M->added.apply(M->added.self, threads, x, sum);
#pragma omp parallel for schedule(static) num_threads(threads) if (lth_block_matrix_is_large(l->A))
  for (LitheCount i = 0; i < l->A->n; i++) y[i] = from[i] - sum[i];
}

/// One V-cycle for A x = b from zero.
static void cycle(const LthMultilevel *M, int depth, int threads, const double *b, double *x) {
  const LthLevel *l = &M->level[depth], *next = l + 1;
  if (depth == M->n_levels - 1) {
    if (M->dense) {
      lth_ml_dense_solve(l->A->n, M->dense, b, x);
      return;
    }
    smooth_down(M, l, threads, b, x);
    smooth_up(M, l, threads, b, x);
    return;
  }
  const bool corrects = depth == 0 && M->added.apply;
  smooth_down(M, l, threads, b, x);
  if (corrects) correct(M, threads, x, l->r, l->r);
  if (l->P) {
    lth_ml_restrict(l->P, threads, l->r, next->b);
    cycle(M, depth + 1, threads, next->b, next->x);
    lth_ml_prolong(l->P, threads, next->x, x);
  } else {
    for (LitheIndex row = 0; row < l->A->n_rows; row++)
      memcpy(next->b + next->A->row_off[row], l->r + l->A->row_off[row],
             sizeof *x * (size_t)l->lead[row]);
    cycle(M, depth + 1, threads, next->b, next->x);
    for (LitheIndex row = 0; row < l->A->n_rows; row++)
      for (LitheIndex i = 0; i < l->lead[row]; i++)
        x[l->A->row_off[row] + i] += next->x[next->A->row_off[row] + i];
  }
  // a sweep for A + extra from x: what it takes for the residual has to be that of A + C
  if (corrects) correct(M, threads, x, b, l->x);
  smooth_up(M, l, threads, corrects ? l->x : b, x);
}

static void apply(const void *self, int threads, const double *r, double *z) {
  cycle(self, 0, threads, r, z);
}

LthOperator lth_multilevel_operator(const LthMultilevel *M) {
  return (LthOperator){.n = M->level[0].A->n, .apply = apply, .self = M};
}

LthSolveReport lth_multilevel_solve(LthMultilevel *M, LthCg *cg, int threads, const LthOperator *A,
                                    const double *b, double *x, double tolerance,
                                    LitheIndex max_iterations) {
  const LthOperator B = lth_multilevel_operator(M);
  const bool can_change = M->degree == 0 && max_iterations > TRIAL;
  LthSolveReport first =
      lth_cg_solve(cg, threads, A, &B, b, x, tolerance, can_change ? TRIAL : max_iterations);
  if (first.converged || first.iterations < TRIAL || !can_change) return first;
  // slow: had it halved its digits the rest would be quick, too
  if (first.residual > sqrt(tolerance)) lth_multilevel_strengthen(M);
  LthSolveReport rest =
      lth_cg_solve(cg, threads, A, &B, b, x, tolerance, max_iterations - first.iterations);
  rest.iterations += first.iterations;
  return rest;
}

int lth_multilevel_levels(const LthMultilevel *M) { return M->n_levels; }

LitheCount lth_multilevel_unknowns(const LthMultilevel *M, int level) {
  return M->level[level].A->n;
}

double lth_multilevel_complexity(const LthMultilevel *M) {
  double all = 0;
  for (int l = 0; l < M->n_levels; l++)
    all += (double)M->level[l].A->value_off[M->level[l].A->block_off[M->level[l].A->n_rows]];
  return all / (double)M->level[0].A->value_off[M->level[0].A->block_off[M->level[0].A->n_rows]];
}

// Measured: some fifty products with the first level of linear functions, and the inverses of the first level's
// diagonal blocks.
double lth_multilevel_update_cost(const LthBlockMatrix *A, LitheIndex n_linear) {
  double linear = 0, inverses = 0;
  for (LitheIndex i = 0; i < A->n_rows; i++) {
    double m = lth_ml_size(A, i), n = n_linear > 0 && m > n_linear ? n_linear : m;
    linear += 8 * n * n * (double)(A->block_off[i + 1] - A->block_off[i]);
    inverses += m * m * m;
  }
  return 50 * linear + 2 * inverses;
}

LitheCount lth_multilevel_bytes(const LthMultilevel *M) { return M->bytes; }
