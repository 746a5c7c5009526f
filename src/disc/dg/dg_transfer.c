/// Exact translation of polynomials between cells, and L2 projection onto merged ones.
#include "disc/dg/dg_transfer.h"

#include "base/tensor.h"

enum { MAX_FUNCS = LTH_DG_MAX_FUNCS, MAX_K = LTH_DG_MAX_DEGREE };

static bool same_basis(const LthDgSpace *from, LitheIndex a, const LthDgSpace *to, LitheIndex b) {
  size_t nb = (size_t)lth_dg_funcs(from, a), size = sizeof(double) * nb * nb;
  return from->degree[a] == to->degree[b] &&
         memcmp(from->center + 3 * (size_t)a, to->center + 3 * (size_t)b, 3 * sizeof(double)) ==
             0 &&
         memcmp(from->scale + 3 * (size_t)a, to->scale + 3 * (size_t)b, 3 * sizeof(double)) == 0 &&
         memcmp(from->basis[a], to->basis[b], size) == 0;
}

/// One axis of xi = ratio xi' + shift: (ratio t + shift)^e = sum_d power[e][d] t^d.
static void set_powers(double ratio, double shift, int k, double power[MAX_K + 1][MAX_K + 1]) {
  memset(power, 0, sizeof(double) * (MAX_K + 1) * (MAX_K + 1));
  power[0][0] = 1;
  for (int e = 1; e <= k; e++)
    for (int d = 0; d <= e; d++)
      power[e][d] =
          (d < e ? shift * power[e - 1][d] : 0) + (d > 0 ? ratio * power[e - 1][d - 1] : 0);
}

/// Monomials about the old cell to monomials about the new one: beta' (n_to x 3) += alpha (n x 3).
static void translate_monomials(const LthDgSpace *from, LitheIndex a, const LthDgSpace *to,
                                LitheIndex b, const double *alpha, double *beta) {
  const int(*e)[3] = lth_monomial3_exponents();
  double power[3][MAX_K + 1][MAX_K + 1];
  int k = from->degree[a], n = lth_monomials3(k);
  for (int i = 0; i < 3; i++) {
    LitheCount p = 3 * (LitheCount)a + i, q = 3 * (LitheCount)b + i;
    set_powers(to->scale[q] / from->scale[p], (to->center[q] - from->center[p]) / from->scale[p], k,
               power[i]);
  }
  for (int q = 0; q < n; q++)
    for (int r = 0; r <= q; r++) {
      if (e[r][0] > e[q][0] || e[r][1] > e[q][1] || e[r][2] > e[q][2]) continue;
      double w =
          power[0][e[q][0]][e[r][0]] * power[1][e[q][1]][e[r][1]] * power[2][e[q][2]][e[r][2]];
      lth_v3_axpy(w, alpha + 3 * q, beta + 3 * r);
    }
}

void lth_dg_translate(const LthDgSpace *from, LitheIndex a, const double *coef,
                      const LthDgSpace *to, LitheIndex b, double *out) {
  int n = lth_dg_funcs(from, a), m = lth_dg_funcs(to, b);
  LITHE_ASSERT(m >= n);
  if (same_basis(from, a, to, b)) {
    memcpy(out, coef, 3 * sizeof(double) * (size_t)n);
    return;
  }
  const double *B = from->basis[a], *C = to->basis[b];
  double alpha[3 * MAX_FUNCS] = {0}, beta[3 * MAX_FUNCS] = {0};
  for (int i = 0; i < n; i++)
    for (int q = 0; q <= i; q++) lth_v3_axpy(B[i * n + q], coef + 3 * i, alpha + 3 * q);
  translate_monomials(from, a, to, b, alpha, beta);

  // beta_q = sum_i out_i C_iq, last function first
  for (int i = m - 1; i >= 0; i--)
    for (int d = 0; d < 3; d++) {
      double sum = beta[3 * i + d];
      for (int j = i + 1; j < m; j++) sum -= out[3 * j + d] * C[j * m + i];
      out[3 * i + d] = sum / C[i * m + i];
    }
}

/// Sums of the projection onto one new cell.
typedef struct Projection {
  const LthDgTransfer *transfer;
  LitheIndex from_cell, to_cell;
  const double *coef;
  double volume, *out;
} Projection;

static void add_to_projection(void *self, const double x[3], double weight) {
  Projection *p = self;
  double phi[MAX_FUNCS], value[3];
  lth_dg_sample(p->transfer->from, p->from_cell, p->coef, x, value);
  lth_dg_eval(p->transfer->to, p->to_cell, x, phi);
  p->volume += weight;
  for (int i = 0; i < lth_dg_funcs(p->transfer->to, p->to_cell); i++)
    lth_v3_axpy(weight * phi[i], value, p->out + 3 * i);
}

/// out_i = sum over atoms of int phi_i u / |K|, exact for polynomials.
static LitheStatus project(LitheCtx *ctx, const LthDgTransfer *t, LitheIndex cell,
                           const LitheIndex *atom, LitheIndex n, const double *coef, double *out) {
  Projection p = {.transfer = t,
                  .to_cell = cell,
                  .coef = coef,
                  .out = out + 3 * (LitheCount)t->to->func_off[cell]};
  int nb = lth_dg_funcs(t->to, cell);
  memset(p.out, 0, 3 * sizeof(double) * (size_t)nb);
  for (LitheIndex i = 0; i < n; i++) {
    LthSimplexRule rule;
    p.from_cell = t->from_cell[atom[i]];
    LITHE_TRY(lth_simplex_rule(ctx, 3, t->to->degree[cell] + t->from->degree[p.from_cell], &rule));
    lth_dg_visit_cell(&rule, t->atoms, atom[i], add_to_projection, &p);
  }
  for (int i = 0; i < 3 * nb; i++) p.out[i] /= p.volume;
  return LITHE_OK;
}

static LitheStatus transfer_cell(LitheCtx *ctx, const LthDgTransfer *t, LitheIndex cell,
                                 const LitheIndex *atom, LitheIndex n, const double *coef,
                                 double *out) {
  LitheIndex from = n > 0 ? t->from_cell[atom[0]] : -1;
  if (n == 0) return LITHE_OK;
  if (n > 1 || t->from->degree[from] > t->to->degree[cell])
    return project(ctx, t, cell, atom, n, coef, out);
  lth_dg_translate(t->from, from, coef + 3 * (LitheCount)t->from->func_off[from], t->to, cell,
                   out + 3 * (LitheCount)t->to->func_off[cell]);
  return LITHE_OK;
}

LitheStatus lth_dg_transfer(LitheCtx *ctx, const LthDgTransfer *t, const double *coef,
                            double *out) {
  LitheStatus status = LITHE_OK;
  LitheIndex *off = NULL, *atom = NULL, n = t->atoms->n_cells, n_cells = t->to->n_cells;
  LTH_NEW_OR(done, ctx, off, (LitheCount)n_cells + 2);
  LTH_NEW_OR(done, ctx, atom, n);
  for (LitheIndex i = 0; i < n; i++) off[t->to_cell[i] + 2]++;
  for (LitheIndex c = 0; c < n_cells; c++) off[c + 2] += off[c + 1];
  for (LitheIndex i = 0; i < n; i++) atom[off[t->to_cell[i] + 1]++] = i;
  for (LitheIndex c = 0; c < n_cells; c++)
    LITHE_TRY_OR(done, transfer_cell(ctx, t, c, atom + off[c], off[c + 1] - off[c], coef, out));
done:
  lth_free(ctx, off);
  lth_free(ctx, atom);
  return status;
}

bool lth_dg_plane_to_rest(const LthDgSpace *space, LitheIndex cell, const double *x,
                          const LthPlane *deformed, LthPlane *rest) {
  const double *center = space->center + 3 * (LitheCount)cell;
  double size = 2 * lth_v3_norm(space->scale + 3 * (LitheCount)cell);
  lth_v3_copy(center, rest->point);

  // Newton's method for n . (x(X) - p) = 0 along the steepest way from the centroid
  for (int i = 0; i < 20; i++) {
    double at[3], F[9], height, length2;
    lth_dg_sample(space, cell, x, rest->point, at);
    lth_dg_sample_gradient(space, cell, x, rest->point, F);
    lth_m3_apply_t(F, deformed->normal, rest->normal);
    lth_v3_sub(at, deformed->point, at);
    height = lth_v3_dot(deformed->normal, at);
    length2 = lth_v3_dot(rest->normal, rest->normal);
    if (!(length2 > 0) || !isfinite(length2)) return false;
    lth_v3_axpy(-height / length2, rest->normal, rest->point);

    // beyond the cell its polynomial says nothing: the first step has shown that the plane misses it
    bool is_far = lth_v3_distance(rest->point, center) > 2 * size;
    if (is_far || fabs(height) <= 1e-15 * size * sqrt(length2)) break;
  }
  lth_v3_normalize(rest->normal);
  return true;
}
