/// Weak constraints by Nitsche's method, symmetric, at the points of a rule on what is held. The penalty is a
/// bound of the traction by the element's own energy, so that the matrix stays positive definite.
/// Nitsche 1971; Warburton and Hesthaven 2003 for the trace inequality; docs/theory/cg.md.
#include "disc/cg/cg_priv.h"

/// Half of an element's energy is left where the penalty is twice the bound.
#define SAFETY 2.0

static void set_projector(const LthWeakConstraint *weak, const double n[3], double P[9]) {
  memset(P, 0, 9 * sizeof *P);
  for (int a = 0; a < 3; a++)
    for (int b = 0; b < 3; b++)
      P[3 * a + b] = weak->normal_only ? n[a] * n[b] : a == b && weak->fixed[a];
}

/// Collecting: first the number of points of each element, then the points.
typedef struct Gather {
  LthCgDisc *d;
  LitheIndex constraint;
  LitheIndex *fill; ///< points of an element so far; NULL: count into hold_off[e + 1]
} Gather;

static void gather_point(void *self, const LthCgPoint *point) {
  Gather *g = self;
  LthCgDisc *d = g->d;
  LitheIndex e = point->element;
  if (!g->fill) {
    d->hold_off[e + 1]++;
    return;
  }
  int n = lth_cg_kind(d, e)->n;
  LthCgHold *hold = &d->holds[d->hold_off[e] + g->fill[e]++];
  hold->constraint = g->constraint;
  lth_v3_copy(point->at, hold->at);
  lth_v3_copy(point->normal, hold->normal);
  hold->weight = point->weight;
  hold->lambda = d->cell_lambda[point->cell];
  hold->mu = d->cell_mu[point->cell];
  set_projector(&d->weak[g->constraint], hold->normal, hold->P);
  memcpy(d->hold_data + hold->table, point->phi, sizeof *point->phi * (size_t)n);
  memcpy(d->hold_data + hold->table + n, point->dphi, sizeof *point->dphi * 3 * (size_t)n);
}

static void gather(LthCgDisc *d, LitheIndex *fill) {
  for (LitheIndex w = 0; w < d->disc.n_weak; w++) {
    Gather g = {d, w, fill};
    const LthPatches *patches = d->weak[w].patches;
    for (LitheIndex i = 0; i < patches->n; i++) lth_cg_visit_patch(d, patches, i, gather_point, &g);
  }
}

/// Functions that span the gradients of an element's functions: constants on tet4, linear ones on tet10, else
/// the element's own. Values at xi; returns their number.
static int slope_functions(const LthCgDisc *d, LitheIndex e, const double *phi, double *psi) {
  const LthCgKind *kind = lth_cg_kind(d, e);
  if (kind->kind == LTH_TET4) {
    psi[0] = 1;
    return 1;
  }
  if (kind->kind == LTH_TET10) { // barycentric coordinates from the quadratic functions
    for (int i = 0; i < 4; i++) psi[i] = phi[i];
    for (int i = 4; i < 10; i++)
      for (int c = 0; c < 4; c++) {
        double L = c == 0 ? 1 - kind->node[i][0] - kind->node[i][1] - kind->node[i][2]
                          : kind->node[i][c - 1];
        psi[c] += L * phi[i];
      }
    return 4;
  }
  for (int i = 0; i < kind->n; i++) psi[i] = phi[i];
  return kind->n;
}

/// In place, A = L L^T of a positive definite A (n x n); false where it is not.
static bool factorize(int n, double *A) {
  for (int j = 0; j < n; j++) {
    for (int i = j; i < n; i++) {
      double sum = A[i * n + j];
      for (int k = 0; k < j; k++) sum -= A[i * n + k] * A[j * n + k];
      if (i == j && !(sum > 0)) return false;
      A[i * n + j] = i == j ? sqrt(sum) : sum / A[j * n + j];
    }
  }
  return true;
}

/// x = L^-1 x
static void substitute(int n, const double *L, double *x) {
  for (int i = 0; i < n; i++) {
    for (int k = 0; k < i; k++) x[i] -= L[i * n + k] * x[k];
    x[i] /= L[i * n + i];
  }
}

/// Square a symmetric matrix.
static void square(int n, double *A) {
  double B[LTH_CG_MAX * LTH_CG_MAX];
  for (int i = 0; i < n; i++)
    for (int j = 0; j < n; j++) {
      B[i * n + j] = 0;
      for (int k = 0; k < n; k++) B[i * n + j] += A[i * n + k] * A[j * n + k];
    }
  memcpy(A, B, sizeof *A * (size_t)(n * n));
}

/// Largest eigenvalue of a positive semi-definite matrix, from above: (tr A^16)^(1/16).
static double largest_eigenvalue(int n, double *A) {
  double scale = 1, power = 1, trace = 0;
  for (int it = 0; it <= 4; it++) {
    trace = 0;
    for (int i = 0; i < n; i++) trace += A[i * n + i];
    if (!(trace > 0)) return 0;
    scale *= pow(trace, 1 / power);
    for (int i = 0; i < n * n; i++) A[i] /= trace;
    if (it < 4) square(n, A);
    power *= 2;
  }
  return scale;
}

/// C with int_held q^2 <= C int_element q^2 for all q that gradients consist of. [1/m]
static double trace_bound(const LthCgDisc *d, LitheIndex e) {
  const LthCgKind *kind = lth_cg_kind(d, e);
  double mass[LTH_CG_MAX * LTH_CG_MAX] = {0}, held[LTH_CG_MAX * LTH_CG_MAX] = {0};
  double psi[LTH_CG_MAX];
  LthCgRule rule;
  int n = 0;
  lth_cg_mass_rule(kind->kind, &rule);
  for (int q = 0; q < rule.n; q++) {
    double X[3], J[9], phi[LTH_CG_MAX], dphi[3 * LTH_CG_MAX];
    lth_cg_map(d, e, rule.xi[q], X, J, phi, dphi);
    double w = rule.weight[q] * lth_m3_det(J);
    n = slope_functions(d, e, phi, psi);
    for (int i = 0; i < n * n; i++) mass[i] += w * psi[i / n] * psi[i % n];
  }
  if (!factorize(n, mass)) return NAN;
  for (LitheIndex h = d->hold_off[e]; h < d->hold_off[e + 1]; h++) {
    slope_functions(d, e, d->hold_data + d->holds[h].table, psi);
    substitute(n, mass, psi);
    for (int i = 0; i < n * n; i++) held[i] += d->holds[h].weight * psi[i / n] * psi[i % n];
  }
  return largest_eigenvalue(n, held);
}

/// |int sigma n . J| <= theta energy / 2 + (C / 2 theta) int (2 mu |J|^2 + max(lambda, 0) (n . J)^2), theta = 1/2.
/// An element that counts less than its cells (partly filled) has less energy to bound with.
static void set_penalty(LthCgDisc *d, LitheIndex e) {
  double C = trace_bound(d, e);
  for (LitheIndex h = d->hold_off[e]; h < d->hold_off[e + 1]; h++) {
    LthCgHold *hold = &d->holds[h];
    double share = d->mu[e] / hold->mu;
    if (hold->lambda > 0) share = fmin(share, d->lambda[e] / hold->lambda);
    hold->iso = SAFETY * C / share * 2 * hold->mu;
    hold->stiff = SAFETY * C / share * fmax(hold->lambda, 0);
  }
}

static LitheStatus check_penalties(LitheCtx *ctx, const LthCgDisc *d) {
  for (LitheIndex e = 0; e < d->elements->n_elements; e++)
    for (LitheIndex h = d->hold_off[e]; h < d->hold_off[e + 1]; h++)
      if (!isfinite(d->holds[h].iso) || !isfinite(d->holds[h].stiff)) {
        const double *at = d->elements->nodes +
                           3 * (LitheCount)d->elements->element_node[d->elements->element_off[e]];
        LITHE_FAIL(ctx, LITHE_BAD_INPUT,
                   "the element at (%g, %g, %g) m is too flat to be held weakly; use `enforce: "
                   "strong` or a better mesh there",
                   at[0], at[1], at[2]);
      }
  return LITHE_OK;
}

void lth_cg_find_held(LthCgDisc *d) {
  for (LitheIndex w = 0; w < d->disc.n_weak; w++) {
    const LthPatches *patches = d->weak[w].patches;
    for (LitheIndex i = 0; i < patches->n; i++)
      d->exact[lth_cg_element(d, d->disc.mesh->face_cell[2 * patches->face[i]])] = 1;
  }
}

LitheStatus lth_cg_build_holds(LitheCtx *ctx, LthCgDisc *d) {
  LitheStatus status = LITHE_OK;
  LitheIndex n_elements = d->elements->n_elements, *fill = NULL;
  LitheCount doubles = 0;
  gather(d, NULL);
  for (LitheIndex e = 0; e < n_elements; e++) d->hold_off[e + 1] += d->hold_off[e];
  d->n_holds = d->hold_off[n_elements];
  LTH_NEW_OR(done, ctx, fill, n_elements);
  LTH_NEW_OR(done, ctx, d->holds, d->n_holds);
  for (LitheIndex e = 0; e < n_elements; e++)
    for (LitheIndex h = d->hold_off[e]; h < d->hold_off[e + 1]; h++) {
      d->holds[h].table = doubles;
      doubles += 4 * (LitheCount)lth_cg_kind(d, e)->n;
    }
  LTH_NEW_OR(done, ctx, d->hold_data, doubles);
  LTH_NEW_OR(done, ctx, d->hold_matrix_off, n_elements + 1);
  for (LitheIndex e = 0; e < n_elements; e++) {
    LitheCount n = d->hold_off[e] < d->hold_off[e + 1] ? lth_cg_kind(d, e)->n : 0;
    d->hold_matrix_off[e + 1] = d->hold_matrix_off[e] + 9 * n * n;
  }
  LTH_NEW_OR(done, ctx, d->hold_matrix, d->hold_matrix_off[n_elements]);
  LTH_NEW_OR(done, ctx, d->hold_load,
             d->n_holds > 0 ? 3 * (LitheCount)d->elements->element_off[n_elements] : 0);
  gather(d, fill);
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheIndex e = 0; e < n_elements; e++)
    if (d->hold_off[e + 1] > d->hold_off[e]) set_penalty(d, e);
  LITHE_TRY_OR(done, check_penalties(ctx, d));
done:
  lth_free(ctx, fill);
  return status;
}

/// A hold with the element's rotation: R n, functions, the traction T_j of every function (sigma(phi_j c) n =
/// T_j c), P T_j, and the penalty matrix M = P (iso I + stiff n n^T) P.
typedef struct Turned {
  const LthCgHold *hold;
  int n;
  double normal[3], M[9];
  const double *phi;
  double T[9 * LTH_CG_MAX], PT[9 * LTH_CG_MAX];
} Turned;

static void set_traction(Turned *t, const double R[9], const double *dphi, int j) {
  const double *n = t->normal;
  double g[3], *T = t->T + 9 * j;
  lth_m3_apply(R, dphi, g);
  double gn = lth_v3_dot(g, n);
  for (int a = 0; a < 3; a++)
    for (int b = 0; b < 3; b++)
      T[3 * a + b] =
          t->hold->lambda * n[a] * g[b] + t->hold->mu * ((a == b ? gn : 0) + g[a] * n[b]);
  lth_m3_mul(t->hold->P, T, t->PT + 9 * j);
}

static void turn_hold(const LthCgDisc *d, LitheIndex element, const LthCgHold *hold, Turned *t) {
  const double *R = d->rotation + 9 * (LitheCount)element;
  double M[9], PM[9];
  t->hold = hold;
  t->n = lth_cg_kind(d, element)->n;
  t->phi = d->hold_data + hold->table;
  lth_m3_apply(R, hold->normal, t->normal);
  for (int j = 0; j < t->n; j++) set_traction(t, R, t->phi + t->n + 3 * j, j);
  for (int a = 0; a < 3; a++)
    for (int b = 0; b < 3; b++)
      M[3 * a + b] = (a == b ? hold->iso : 0) + hold->stiff * t->normal[a] * t->normal[b];
  lth_m3_mul(hold->P, M, PM);
  lth_m3_mul(PM, hold->P, t->M);
}

/// Rows [a][b][j] of node i += those of the hold.
static void add_rows(const Turned *t, int i, double *rows) {
  double w = t->hold->weight;
  for (int a = 0; a < 3; a++)
    for (int b = 0; b < 3; b++) {
      double *row = rows + (3 * a + b) * t->n, M = t->M[3 * a + b], PT = t->PT[9 * i + 3 * b + a];
      for (int j = 0; j < t->n; j++)
        row[j] +=
            w * (t->phi[i] * t->phi[j] * M - t->phi[i] * t->PT[9 * j + 3 * a + b] - t->phi[j] * PT);
    }
}

void lth_cg_hold_data(const LthCgDisc *d, const LthCgHold *hold, double t, double value[3]) {
  const LthWeakConstraint *weak = &d->weak[hold->constraint];
  if (weak->normal_only) {
    double along = lth_value_at(&weak->value[0], hold->at, t);
    for (int a = 0; a < 3; a++) value[a] = along * hold->normal[a];
    return;
  }
  for (int a = 0; a < 3; a++) {
    value[a] = weak->fixed[a] ? lth_value_at(&weak->value[a], hold->at, t) : 0;
    if (weak->fixed[a] && weak->is_position) value[a] -= hold->at[a];
  }
}

/// f0 += that of the hold at time t (n x 3).
static void add_load(const LthCgDisc *d, const Turned *t, double time, double *f0) {
  // the traction of x -> x is (3 lambda + 2 mu) n; what is prescribed is a place
  const LthCgHold *hold = t->hold;
  double place[3], v[3], pull[3], held[3], rest = 3 * hold->lambda + 2 * hold->mu;
  lth_cg_hold_data(d, hold, time, place);
  lth_v3_add(place, hold->at, place);
  lth_m3_apply(t->M, place, pull);
  lth_m3_apply(hold->P, t->normal, v);
  lth_v3_axpy(-rest, v, pull);
  lth_m3_apply(hold->P, place, held);
  for (int i = 0; i < t->n; i++) {
    lth_m3_apply_t(t->T + 9 * i, held, v);
    lth_v3_axpy(hold->weight * t->phi[i], pull, f0 + 3 * i);
    lth_v3_axpy(-hold->weight, v, f0 + 3 * i);
  }
}

void lth_cg_sum_holds(const LthCgDisc *d, double t, bool matrix) {
#pragma omp parallel for schedule(dynamic, 16) num_threads(lth_cg_threads(d))
  for (LitheIndex e = 0; e < d->elements->n_elements; e++) {
    LitheIndex n = lth_cg_kind(d, e)->n;
    double *rows = d->hold_matrix + d->hold_matrix_off[e];
    double *load = d->hold_load + 3 * (LitheCount)d->elements->element_off[e];
    if (d->hold_off[e] == d->hold_off[e + 1]) continue;
    if (matrix) memset(rows, 0, sizeof *rows * 9 * (size_t)(n * n));
    memset(load, 0, sizeof *load * 3 * (size_t)n);
    for (LitheIndex h = d->hold_off[e]; h < d->hold_off[e + 1]; h++) {
      Turned turned;
      turn_hold(d, e, &d->holds[h], &turned);
      for (int i = 0; matrix && i < n; i++) add_rows(&turned, i, rows + 9 * n * i);
      add_load(d, &turned, t, load);
    }
  }
}
