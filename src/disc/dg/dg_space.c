/// The space of discontinuous polynomials: building it, and values and gradients of its functions.
#include "disc/dg/dg_space.h"

#include "base/tensor.h"
#include "disc/dg/dg_basis.h"
#include "disc/dg/dg_store_priv.h"

void lth_dg_space_destroy(LitheCtx *ctx, LthDgSpace **space) {
  if (!*space) return;
  LthDgSpace *s = *space;
  lth_free(ctx, s->degree);
  lth_free(ctx, s->func_off);
  lth_free(ctx, s->center);
  lth_free(ctx, s->axes);
  lth_free(ctx, s->basis_block);
  lth_free(ctx, s->basis);
  lth_free(ctx, s->mean_gradient);
  lth_free(ctx, s->trace_constant);
  lth_free(ctx, s);
  *space = NULL;
}

/// Degrees, numbering and memory.
static LitheStatus lay_out(LitheCtx *ctx, LthDgSpace *s, int degree, const uint8_t *cell_degree) {
  LitheIndex n = s->n_cells;
  LTH_NEW(ctx, s->degree, n);
  LTH_NEW(ctx, s->func_off, n + 1);
  LTH_NEW(ctx, s->basis, n);
  LTH_NEW(ctx, s->center, 3 * (LitheCount)n);
  LTH_NEW(ctx, s->axes, 9 * (LitheCount)n);
  LTH_NEW(ctx, s->trace_constant, n);
  LitheCount funcs = 0;
  for (LitheIndex c = 0; c < n; c++) {
    int k = cell_degree ? cell_degree[c] : degree;
    if (k < 1 || k > LTH_DG_MAX_DEGREE)
      LITHE_FAIL(ctx, LITHE_BAD_INPUT, "degree %d of element %d; expected 1 to %d", k, (int)c,
                 LTH_DG_MAX_DEGREE);
    int nb = lth_monomials3(k);
    s->degree[c] = (uint8_t)k;
    if (k > s->max_degree) s->max_degree = k;
    funcs += nb;
    if (funcs > INT32_MAX / 3)
      LITHE_FAIL(ctx, LITHE_UNSUPPORTED,
                 "%d elements of degree %d have more than 2^31 unknowns; take fewer cells or a "
                 "lower degree",
                 (int)n, k);
    s->func_off[c + 1] = (LitheIndex)funcs;
  }
  s->n_funcs = (LitheIndex)funcs;
  s->n_dofs = 3 * funcs;
  LTH_NEW(ctx, s->mean_gradient, 3 * funcs);
  return LITHE_OK;
}

/// One block for all bases.
static LitheStatus place_bases(LitheCtx *ctx, LthDgSpace *s) {
  LitheCount size = 0;
  for (LitheIndex c = 0; c < s->n_cells; c++)
    size += (LitheCount)lth_dg_funcs(s, c) * lth_dg_funcs(s, c);
  LTH_NEW(ctx, s->basis_block, size);
  double *next = s->basis_block;
  for (LitheIndex c = 0; c < s->n_cells; c++) {
    s->basis[c] = next;
    next += lth_dg_funcs(s, c) * lth_dg_funcs(s, c);
  }
  return LITHE_OK;
}

static LitheStatus fail_flat(LitheCtx *ctx, const LthMesh *mesh, LitheIndex c) {
  const double *x = mesh->cell_centroid + 3 * c;
  LITHE_FAIL(ctx, LITHE_BAD_INPUT,
             "element %d near (%g, %g, %g) has no thickness but for rounding: volume %g; merge "
             "slivers (method.sliver > 0) or move the grid",
             (int)c, x[0], x[1], x[2], mesh->cell_volume[c]);
}

/// Bases of all cells but those of which they are known; remembers the first cell that has none.
static LitheStatus build_bases(LitheCtx *ctx, LthDgSpace *s, const uint8_t *is_known) {
  const LthMesh *mesh = s->mesh;
  LitheIndex flat = s->n_cells;
#pragma omp parallel for schedule(dynamic, 16) num_threads(lth_threads(ctx)) reduction(min : flat)
  for (LitheIndex c = 0; c < s->n_cells; c++) {
    if (is_known && is_known[c]) continue;
    if (!lth_dg_basis_build(s, c)) flat = c < flat ? c : flat;
  }
  return flat < s->n_cells ? fail_flat(ctx, mesh, flat) : LITHE_OK;
}

LitheStatus lth_dg_space_create_kept(LitheCtx *ctx, const LthMesh *mesh, int degree,
                                     const uint8_t *cell_degree, const LthDgRecords *records,
                                     LthDgSpace **space) {
  LitheStatus status = LITHE_OK;
  LthDgSpace *s = NULL;
  uint8_t *is_known = NULL;
  *space = NULL;
  LTH_NEW_OR(done, ctx, s, 1);
  s->mesh = mesh;
  s->n_cells = mesh->n_cells;
  LITHE_TRY_OR(done, lay_out(ctx, s, degree, cell_degree));
  if (records) {
    LTH_NEW_OR(done, ctx, is_known, s->n_cells);
    LITHE_TRY_OR(done, lth_dg_store_lend_bases(ctx, records, s, is_known));
  } else {
    LITHE_TRY_OR(done, place_bases(ctx, s));
  }
  double start = lth_processor_time();
  LITHE_TRY_OR(done, build_bases(ctx, s, is_known));
  if (records) records->store->count.seconds += lth_processor_time() - start;
  if (records) lth_dg_store_keep_bases(records, s, is_known);
  *space = s;
  s = NULL;
done:
  lth_free(ctx, is_known);
  if (s) lth_dg_space_destroy(ctx, &s);
  return status;
}

LitheStatus lth_dg_space_create(LitheCtx *ctx, const LthMesh *mesh, int degree,
                                const uint8_t *cell_degree, LthDgSpace **space) {
  return lth_dg_space_create_kept(ctx, mesh, degree, cell_degree, NULL, space);
}

/// Everything of a cell of another space but its number.
static void copy_cell(const LthDgSpace *from, LitheIndex cell, LthDgSpace *to, LitheIndex at) {
  int nb = lth_dg_funcs(from, cell);
  memcpy(to->center + 3 * (size_t)at, from->center + 3 * (size_t)cell, 3 * sizeof(double));
  memcpy(to->axes + 9 * (size_t)at, from->axes + 9 * (size_t)cell, 9 * sizeof(double));
  memcpy(to->basis[at], from->basis[cell], sizeof(double) * (size_t)(nb * nb));
  memcpy(to->mean_gradient + 3 * (size_t)to->func_off[at],
         from->mean_gradient + 3 * (size_t)from->func_off[cell], 3 * sizeof(double) * (size_t)nb);
  to->trace_constant[at] = from->trace_constant[cell];
}

LitheStatus lth_dg_space_gather(LitheCtx *ctx, const LthMesh *mesh, const LthDgSpace *const *spaces,
                                const uint8_t *from, const LitheIndex *of, LthDgSpace **space) {
  LitheStatus status = LITHE_OK;
  LthDgSpace *s = NULL;
  uint8_t *degree = NULL;
  LTH_NEW_OR(done, ctx, degree, mesh->n_cells);
  for (LitheIndex c = 0; c < mesh->n_cells; c++) degree[c] = spaces[from[c]]->degree[of[c]];
  LTH_NEW_OR(done, ctx, s, 1);
  s->mesh = mesh;
  s->n_cells = mesh->n_cells;
  LITHE_TRY_OR(done, lay_out(ctx, s, 1, degree));
  LITHE_TRY_OR(done, place_bases(ctx, s));
  for (LitheIndex c = 0; c < s->n_cells; c++) copy_cell(spaces[from[c]], of[c], s, c);
done:
  lth_free(ctx, degree);
  if (status != LITHE_OK) lth_dg_space_destroy(ctx, &s);
  *space = s;
  return status;
}

static void to_cell(const LthDgSpace *s, LitheIndex cell, const double x[3], double xi[3]) {
  double d[3];
  lth_v3_sub(x, s->center + 3 * (LitheCount)cell, d);
  lth_m3_apply(s->axes + 9 * (LitheCount)cell, d, xi);
}

void lth_dg_eval(const LthDgSpace *space, LitheIndex cell, const double x[3], double *phi) {
  int nb = lth_dg_funcs(space, cell);
  const double *B = space->basis[cell];
  double xi[3], m[LTH_DG_MAX_FUNCS];
  to_cell(space, cell, x, xi);
  lth_monomials3_eval(space->degree[cell], xi, m);
  for (int i = 0; i < nb; i++) {
    phi[i] = 0;
    for (int q = 0; q <= i; q++) phi[i] += B[i * nb + q] * m[q];
  }
}

void lth_dg_eval_gradient(const LthDgSpace *space, LitheIndex cell, const double x[3],
                          double *dphi) {
  int nb = lth_dg_funcs(space, cell);
  const double *B = space->basis[cell], *axes = space->axes + 9 * (LitheCount)cell;
  const int(*e)[3] = lth_monomial3_exponents();
  double xi[3], m[LTH_DG_MAX_FUNCS], dm[LTH_DG_MAX_FUNCS][3];
  to_cell(space, cell, x, xi);
  lth_monomials3_eval(space->degree[cell], xi, m);
  for (int q = 0; q < nb; q++) {
    double local[3] = {0, 0, 0};
    for (int a = 0; a < 3; a++) {
      int low[3] = {e[q][0], e[q][1], e[q][2]};
      if (low[a]-- > 0) local[a] = e[q][a] * m[lth_monomial3_index(low[0], low[1], low[2])];
    }
    lth_m3_apply_t(axes, local, dm[q]);
  }
  for (int i = 0; i < nb; i++)
    for (int a = 0; a < 3; a++) {
      dphi[3 * i + a] = 0;
      for (int q = 0; q <= i; q++) dphi[3 * i + a] += B[i * nb + q] * dm[q][a];
    }
}

/// x = center + axes^{-1} m_1..3(xi), and m = B4^{-1} phi on the linear functions.
static void rest_of_cell(const LthDgSpace *s, LitheIndex cell, double *x0) {
  int nb = lth_dg_funcs(s, cell);
  const double *B = s->basis[cell];
  const double *center = s->center + 3 * (LitheCount)cell;
  double inverse[9];
  lth_m3_inverse(s->axes + 9 * (LitheCount)cell, inverse);
  memset(x0, 0, 3 * (size_t)nb * sizeof *x0);
  for (int a = 0; a < 3; a++) {
    // solve c^T B4 = (center_a, row a of the inverse), last function first
    double c[4] = {center[a], inverse[3 * a], inverse[3 * a + 1], inverse[3 * a + 2]};
    for (int i = 3; i >= 0; i--) {
      c[i] /= B[i * nb + i];
      for (int q = 0; q < i; q++) c[q] -= c[i] * B[i * nb + q];
      x0[3 * i + a] = c[i];
    }
  }
}

void lth_dg_rest(const LthDgSpace *space, double *x0) {
  for (LitheIndex c = 0; c < space->n_cells; c++)
    rest_of_cell(space, c, x0 + 3 * (LitheCount)space->func_off[c]);
}

void lth_dg_sample(const LthDgSpace *space, LitheIndex cell, const double *coef, const double x[3],
                   double value[3]) {
  double phi[LTH_DG_MAX_FUNCS];
  const double *c = coef + 3 * (LitheCount)space->func_off[cell];
  lth_dg_eval(space, cell, x, phi);
  value[0] = value[1] = value[2] = 0;
  for (int i = 0; i < lth_dg_funcs(space, cell); i++) lth_v3_axpy(phi[i], c + 3 * i, value);
}

/// gradient[a][b] = sum_i coef_ia d_ib
static void gradient_sum(int nb, const double *coef, const double *d, double gradient[9]) {
  memset(gradient, 0, 9 * sizeof *gradient);
  for (int i = 0; i < nb; i++)
    for (int a = 0; a < 3; a++)
      for (int b = 0; b < 3; b++) gradient[3 * a + b] += coef[3 * i + a] * d[3 * i + b];
}

void lth_dg_sample_gradient(const LthDgSpace *space, LitheIndex cell, const double *coef,
                            const double x[3], double gradient[9]) {
  double dphi[3 * LTH_DG_MAX_FUNCS];
  lth_dg_eval_gradient(space, cell, x, dphi);
  gradient_sum(lth_dg_funcs(space, cell), coef + 3 * (LitheCount)space->func_off[cell], dphi,
               gradient);
}

void lth_dg_mean_gradient(const LthDgSpace *space, LitheIndex cell, const double *coef,
                          double gradient[9]) {
  LitheCount first = 3 * (LitheCount)space->func_off[cell];
  gradient_sum(lth_dg_funcs(space, cell), coef + first, space->mean_gradient + first, gradient);
}
