/// The Poisson equation on the unit square: element and edge integrals by Gauss points, one banded solve.
/// Kaufmann et al. 2009, section 3; the boundary as in docs/theory/dg.md, section 4.
#include "study/poisson.h"

#include "geometry/quadrature.h"
#include "la/blas_threads.h"

#include <lapacke.h>
#include <math.h>

#define FUNCS_MAX 6
#define GAUSS 8 ///< points a direction: sin(pi x) on half the square to 1e-13

/// Functions of a cell at a point.
typedef struct Values {
  double phi[FUNCS_MAX], slope[FUNCS_MAX][2], laplace[FUNCS_MAX];
} Values;

/// The matrix in LAPACK's band storage, or dense (band = n - 1, row 0 on top).
typedef struct Matrix {
  int n, band, lead;
  bool is_dense;
  double *values;
} Matrix;

typedef struct Poisson {
  const LthPoissonProblem *problem;
  const LthPoissonDef *def;
  int n, funcs;
  bool is_monomial;
  Matrix matrix;
  double *load, gauss[GAUSS], weight[GAUSS];
} Poisson;

static int count_unknowns(const Poisson *p) {
  return p->def->method == LTH_POISSON_CG ? (p->n - 1) * (p->n - 1) : p->funcs * p->n * p->n;
}

/// Unknown behind function i of a cell; -1 for nodes on the boundary, where u = 0.
static int unknown(const Poisson *p, const int cell[2], int i) {
  if (p->def->method != LTH_POISSON_CG) return p->funcs * (cell[0] + p->n * cell[1]) + i;
  int x = cell[0] + i % 2, y = cell[1] + i / 2;
  return x < 1 || y < 1 || x == p->n || y == p->n ? -1 : x - 1 + (p->n - 1) * (y - 1);
}

/// Bilinear functions of the nodes, or monomials 1, s, t, ss, st, tt of s = x and t = y, or of -1 ... 1 over the cell.
static void evaluate(const Poisson *p, const int cell[2], const double x[2], Values *v) {
  double h = 1. / p->n, scale = 2 / h, s[2];
  if (p->is_monomial) scale = 1;
  for (int a = 0; a < 2; a++) s[a] = p->is_monomial ? x[a] : scale * (x[a] - h * (cell[a] + 0.5));
  *v = (Values){0};
  if (p->def->method == LTH_POISSON_CG) {
    for (int i = 0; i < 4; i++) {
      double sx = i % 2 ? 1 : -1, sy = i / 2 ? 1 : -1;
      v->phi[i] = (1 + sx * s[0]) * (1 + sy * s[1]) / 4;
      v->slope[i][0] = scale * sx * (1 + sy * s[1]) / 4;
      v->slope[i][1] = scale * sy * (1 + sx * s[0]) / 4;
    }
    return;
  }
  const double phi[FUNCS_MAX] = {1, s[0], s[1], s[0] * s[0], s[0] * s[1], s[1] * s[1]};
  const double slope[FUNCS_MAX][2] = {{0, 0},        {1, 0},       {0, 1},
                                      {2 * s[0], 0}, {s[1], s[0]}, {0, 2 * s[1]}};
  for (int i = 0; i < p->funcs; i++) {
    v->phi[i] = phi[i];
    for (int a = 0; a < 2; a++) v->slope[i][a] = scale * slope[i][a];
    v->laplace[i] = i == 3 || i == 5 ? 2 * scale * scale : 0;
  }
}

static void add(Matrix *m, int i, int j, double value) {
  if (i < 0 || j < 0) return;
  size_t row = m->is_dense ? (size_t)i : (size_t)(2 * m->band + i - j);
  m->values[row + (size_t)m->lead * (size_t)j] += value;
}

// --- integrals ---

static void add_cell(Poisson *p, const int cell[2]) {
  double h = 1. / p->n;
  for (int k = 0; k < GAUSS * GAUSS; k++) {
    double w = h * h * p->weight[k % GAUSS] * p->weight[k / GAUSS];
    double x[2] = {h * (cell[0] + p->gauss[k % GAUSS]), h * (cell[1] + p->gauss[k / GAUSS])};
    double f = p->problem->source(x);
    Values v;
    evaluate(p, cell, x, &v);
    for (int i = 0; i < p->funcs; i++) {
      int row = unknown(p, cell, i);
      if (row >= 0) p->load[row] += w * f * v.phi[i];
      for (int j = 0; j < p->funcs; j++)
        add(&p->matrix, row, unknown(p, cell, j),
            w * (v.slope[i][0] * v.slope[j][0] + v.slope[i][1] * v.slope[j][1]));
    }
  }
}

/// The edge between `cell` and the next one along axis a, at its upper side; or one on the boundary, with `outward` +1
/// or -1. Jumps are those of (12) and (14): the cell below minus the one above.
static void add_edge(Poisson *p, const int cell[2], int a, int outward) {
  double h = 1. / p->n, penalty = p->def->eta / h, sign = outward < 0 ? -1 : 1;
  int sides = outward == 0 ? 2 : 1, next[2] = {cell[0], cell[1]};
  next[a]++;
  for (int k = 0; k < GAUSS; k++) {
    double w = h * p->weight[k], x[2], jump[2 * FUNCS_MAX], mean[2 * FUNCS_MAX];
    int row[2 * FUNCS_MAX];
    x[a] = h * (cell[a] + (outward < 0 ? 0 : 1));
    x[1 - a] = h * (cell[1 - a] + p->gauss[k]);
    for (int side = 0; side < sides; side++) {
      const int *at = side == 0 ? cell : next;
      Values v;
      evaluate(p, at, x, &v);
      for (int i = 0; i < p->funcs; i++) {
        int e = side * p->funcs + i;
        row[e] = unknown(p, at, i);
        jump[e] = side == 0 ? v.phi[i] : -v.phi[i];
        mean[e] = p->def->method == LTH_POISSON_IP ? sign * v.slope[i][a] / sides : 0;
      }
    }
    for (int i = 0; i < sides * p->funcs; i++) {
      for (int j = 0; j < sides * p->funcs; j++)
        add(&p->matrix, row[i], row[j],
            w * (penalty * jump[i] * jump[j] - jump[i] * mean[j] - jump[j] * mean[i]));
      if (outward) p->load[row[i]] += w * p->problem->value(x) * (penalty * jump[i] - mean[i]);
    }
  }
}

static void assemble(Poisson *p) {
  for (int y = 0; y < p->n; y++)
    for (int x = 0; x < p->n; x++) {
      const int cell[2] = {x, y};
      add_cell(p, cell);
      if (p->def->method == LTH_POISSON_CG) continue;
      for (int a = 0; a < 2; a++) {
        add_edge(p, cell, a, cell[a] + 1 == p->n ? 1 : 0);
        if (cell[a] == 0) add_edge(p, cell, a, -1);
      }
    }
}

/// Room for the matrix and the load, and all integrals.
static LitheStatus build(LitheCtx *ctx, Poisson *p, bool is_dense, bool is_monomial) {
  Matrix *m = &p->matrix;
  bool is_cg = p->def->method == LTH_POISSON_CG;
  m->n = count_unknowns(p);
  m->band = is_cg ? p->n : p->funcs * (p->n + 1) - 1;
  if (m->band > m->n - 1) m->band = m->n - 1;
  m->is_dense = is_dense;
  m->lead = is_dense ? m->n : 3 * m->band + 1;
  p->is_monomial = is_monomial && !is_cg;
  LITHE_TRY(lth_new_(ctx, (void **)&m->values, (LitheCount)m->lead * m->n, sizeof *m->values));
  LITHE_TRY(lth_new_(ctx, (void **)&p->load, m->n, sizeof *p->load));
  assemble(p);
  return LITHE_OK;
}

static void drop(LitheCtx *ctx, Poisson *p) {
  lth_free(ctx, p->matrix.values);
  lth_free(ctx, p->load);
  p->matrix.values = p->load = NULL;
}

// --- results ---

static void measure(const Poisson *p, LthPoissonResult *result) {
  double h = 1. / p->n, l2 = 0, laplace = 0;
  for (int c = 0; c < p->n * p->n; c++)
    for (int k = 0; k < GAUSS * GAUSS; k++) {
      const int cell[2] = {c % p->n, c / p->n};
      double w = h * h * p->weight[k % GAUSS] * p->weight[k / GAUSS], u = 0, lap = 0;
      double x[2] = {h * (cell[0] + p->gauss[k % GAUSS]), h * (cell[1] + p->gauss[k / GAUSS])};
      Values v;
      evaluate(p, cell, x, &v);
      for (int i = 0; i < p->funcs; i++) {
        int row = unknown(p, cell, i);
        u += row < 0 ? 0 : p->load[row] * v.phi[i];
        lap += row < 0 ? 0 : p->load[row] * v.laplace[i];
      }
      l2 += w * pow(u - p->problem->value(x), 2);
      laplace += w * pow(lap + p->problem->source(x), 2);
    }
  result->l2 = sqrt(l2);
  result->laplace = sqrt(laplace);
}

/// LU with pivots, for a penalty below the limit leaves the matrix indefinite.
static LitheStatus solve(LitheCtx *ctx, Poisson *p) {
  Matrix *m = &p->matrix;
  lapack_int *pivot;
  LTH_NEW(ctx, pivot, m->n);
  int threads = lth_blas_one_thread();
  int info = LAPACKE_dgbsv(LAPACK_COL_MAJOR, m->n, m->band, m->band, 1, m->values, m->lead, pivot,
                           p->load, m->n);
  lth_blas_threads(threads);
  lth_free(ctx, pivot);
  if (info != 0) LITHE_FAIL(ctx, LITHE_NOT_CONVERGED, "Poisson: LAPACK's dgbsv gave %d", info);
  return LITHE_OK;
}

static LitheStatus find_eigenvalues(LitheCtx *ctx, Poisson *p, LthPoissonResult *result) {
  Matrix *m = &p->matrix;
  double *value;
  LTH_NEW(ctx, value, m->n);
  int threads = lth_blas_one_thread();
  int info = LAPACKE_dsyevd(LAPACK_COL_MAJOR, 'N', 'L', m->n, m->values, m->n, value);
  lth_blas_threads(threads);
  result->smallest = value[0];
  result->largest = value[m->n - 1];
  lth_free(ctx, value);
  if (info != 0) LITHE_FAIL(ctx, LITHE_NOT_CONVERGED, "Poisson: LAPACK's dsyevd gave %d", info);
  return LITHE_OK;
}

LitheStatus lth_poisson_solve(LitheCtx *ctx, const LthPoissonProblem *problem,
                              const LthPoissonDef *def, LthPoissonResult *result) {
  Poisson p = {.problem = problem, .def = def, .n = def->cells};
  p.funcs = def->method == LTH_POISSON_CG ? 4 : (def->degree + 1) * (def->degree + 2) / 2;
  *result = (LthPoissonResult){.unknowns = count_unknowns(&p), .smallest = NAN, .largest = NAN};
  lth_gauss_jacobi(GAUSS, 0, p.gauss, p.weight);
  LitheStatus status = build(ctx, &p, false, false);
  if (status == LITHE_OK) status = solve(ctx, &p);
  if (status == LITHE_OK) measure(&p, result);
  drop(ctx, &p);
  if (status != LITHE_OK || !def->wants_matrix) return status;
  status = build(ctx, &p, true, def->is_monomial);
  if (status == LITHE_OK) status = find_eigenvalues(ctx, &p, result);
  drop(ctx, &p);
  return status;
}
