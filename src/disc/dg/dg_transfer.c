/// Exact translation of polynomials between cells, and L2 projection onto merged ones.
#include "disc/dg/dg_transfer.h"

#include "base/tensor.h"

enum { MAX_FUNCS = LTH_DG_MAX_FUNCS };

static bool same_basis(const LthDgSpace *from, LitheIndex a, const LthDgSpace *to, LitheIndex b) {
  size_t nb = (size_t)lth_dg_funcs(from, a), size = sizeof(double) * nb * nb;
  return from->degree[a] == to->degree[b] &&
         memcmp(from->center + 3 * (size_t)a, to->center + 3 * (size_t)b, 3 * sizeof(double)) ==
             0 &&
         memcmp(from->axes + 9 * (size_t)a, to->axes + 9 * (size_t)b, 9 * sizeof(double)) == 0 &&
         memcmp(from->basis[a], to->basis[b], size) == 0;
}

/// Old local coordinates as linear functions of new ones: xi_i = linear[i][0] + sum_j linear[i][1 + j] xi'_j.
static void set_linear(const LthDgSpace *from, LitheIndex a, const LthDgSpace *to, LitheIndex b,
                       double linear[3][4]) {
  const double *axes = from->axes + 9 * (LitheCount)a;
  double inverse[9], ratio[9], shift[3], d[3];
  lth_m3_inverse(to->axes + 9 * (LitheCount)b, inverse);
  lth_m3_mul(axes, inverse, ratio);
  lth_v3_sub(to->center + 3 * (LitheCount)b, from->center + 3 * (LitheCount)a, d);
  lth_m3_apply(axes, d, shift);
  for (int i = 0; i < 3; i++) {
    linear[i][0] = shift[i];
    memcpy(linear[i] + 1, ratio + 3 * i, 3 * sizeof(double));
  }
}

/// Monomials about the old cell to monomials about the new one: beta (n_to x 3) += alpha (n x 3). Each is a linear
/// function times one of a degree less.
static void translate_monomials(const LthDgSpace *from, LitheIndex a, const LthDgSpace *to,
                                LitheIndex b, const double *alpha, double *beta) {
  const int(*e)[3] = lth_monomial3_exponents();
  double linear[3][4], image[MAX_FUNCS][MAX_FUNCS] = {{1}};
  int n = lth_monomials3(from->degree[a]);
  set_linear(from, a, to, b, linear);
  lth_v3_axpy(1, alpha, beta);
  for (int q = 1; q < n; q++) {
    int axis = e[q][0] ? 0 : e[q][1] ? 1 : 2, low[3] = {e[q][0], e[q][1], e[q][2]};
    low[axis]--;
    const double *lower = image[lth_monomial3_index(low[0], low[1], low[2])];
    for (int r = 0; r < q; r++) {
      if (lower[r] == 0) continue;
      image[q][r] += linear[axis][0] * lower[r];
      for (int j = 0; j < 3; j++)
        image[q][lth_monomial3_index(e[r][0] + (j == 0), e[r][1] + (j == 1), e[r][2] + (j == 2))] +=
            linear[axis][1 + j] * lower[r];
    }
    for (int r = 0; r < n; r++)
      if (image[q][r] != 0) lth_v3_axpy(image[q][r], alpha + 3 * q, beta + 3 * r);
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
    LitheIndex at = t->atom ? t->atom[atom[i]] : atom[i];
    p.from_cell = t->from_cell[atom[i]];
    LITHE_TRY(lth_simplex_rule(ctx, 3, t->to->degree[cell] + t->from->degree[p.from_cell], &rule));
    lth_dg_visit_cell(&rule, at < 0 ? t->from->mesh : t->atoms, at < 0 ? p.from_cell : at,
                      add_to_projection, &p);
  }
  for (int i = 0; i < 3 * nb; i++) p.out[i] /= p.volume;
  return LITHE_OK;
}

static LitheStatus transfer_cell(LitheCtx *ctx, const LthDgTransfer *t, LitheIndex cell,
                                 const LitheIndex *atom, LitheIndex n, const double *coef,
                                 double *out) {
  LitheIndex from = n > 0 ? t->from_cell[atom[0]] : -1, same = t->same ? t->same[cell] : -1;
  if (same >= 0)
    memcpy(out + 3 * (LitheCount)t->to->func_off[cell],
           coef + 3 * (LitheCount)t->from->func_off[same],
           3 * sizeof *out * (size_t)lth_dg_funcs(t->to, cell));
  if (n == 0) return LITHE_OK;
  if (n > 1 || t->from->degree[from] > t->to->degree[cell])
    return project(ctx, t, cell, atom, n, coef, out);
  lth_dg_translate(t->from, from, coef + 3 * (LitheCount)t->from->func_off[from], t->to, cell,
                   out + 3 * (LitheCount)t->to->func_off[cell]);
  return LITHE_OK;
}

LitheStatus lth_dg_sort_atoms(LitheCtx *ctx, const LthDgTransfer *t, LitheIndex **off,
                              LitheIndex **atom) {
  LitheIndex n = t->n_atoms, n_cells = t->to->n_cells;
  LTH_NEW(ctx, *off, (LitheCount)n_cells + 2);
  LTH_NEW(ctx, *atom, n);
  LitheIndex *first = *off;
  for (LitheIndex i = 0; i < n; i++)
    if (t->to_cell[i] >= 0) first[t->to_cell[i] + 2]++;
  for (LitheIndex c = 0; c < n_cells; c++) first[c + 2] += first[c + 1];
  for (LitheIndex i = 0; i < n; i++)
    if (t->to_cell[i] >= 0) (*atom)[first[t->to_cell[i] + 1]++] = i;
  return LITHE_OK;
}

LitheStatus lth_dg_transfer(LitheCtx *ctx, const LthDgTransfer *t, const double *coef,
                            double *out) {
  LitheStatus status = LITHE_OK;
  LitheIndex *off = NULL, *atom = NULL;
  LITHE_TRY_OR(done, lth_dg_sort_atoms(ctx, t, &off, &atom));
  for (LitheIndex c = 0; c < t->to->n_cells; c++)
    LITHE_TRY_OR(done, transfer_cell(ctx, t, c, atom + off[c], off[c + 1] - off[c], coef, out));
done:
  lth_free(ctx, off);
  lth_free(ctx, atom);
  return status;
}

bool lth_dg_plane_to_rest(const LthDgSpace *space, LitheIndex cell, const double *x,
                          const LthPlane *deformed, LthPlane *rest) {
  const double *center = space->center + 3 * (LitheCount)cell;
  const double *box = space->mesh->cell_box + 6 * (LitheCount)cell;
  double size = lth_v3_distance(box, box + 3);
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
