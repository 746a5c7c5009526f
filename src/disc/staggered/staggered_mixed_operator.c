/// The mixed form's operator, and one V-cycle for displacements with a scaling of pressures as its approximate inverse.
#include "disc/staggered/staggered_mixed.h"

#include <math.h>
#include <string.h>

static double sample(const LthStaggeredLevel *l, const double *v, LitheCount slot) {
  return lth_level_value(l, v, slot);
}

static bool is_free(const LthStaggeredLevel *l, int a, LitheCount slot) {
  return slot >= 0 && l->state[a][slot] == LTH_UNKNOWN_FREE;
}

/// lambda beyond what displacements bear, and something that is free to move.
static bool has_pressure(const LthStaggeredLevel *l, LitheCount slot) {
  const double V = sample(l, l->volume, slot), C = sample(l, l->compliance, slot);
  LitheIndex cell[3];
  if (!(V > 0)) return false;
  if (C > 0 && sample(l, l->lambda, slot) <= LTH_STIFFEST * sample(l, l->mu, slot)) return false;
  lth_sparse_grid_cell(l->grid, slot, cell);
  for (int a = 0; a < l->grid->dim; a++)
    if (is_free(l, a, slot) || is_free(l, a, lth_sparse_grid_along(l->grid, cell, a, 1)))
      return true;
  return false;
}

static LitheStatus split(LitheCtx *ctx, LthMixed *m) {
  const LthStaggeredLevel *l = &m->level;
  const LitheCount n = ((LitheCount)l->n_rows + 1) * l->grid->side;
  double *lambda;
  LTH_NEW(ctx, lambda, n);
  for (LitheCount i = 0; i < n - l->grid->side; i++)
    lambda[i] = fmin(l->lambda[i], LTH_STIFFEST * l->mu[i]);
  m->soft = *l;
  m->soft.lambda = lambda;
  m->soft.compliance = NULL;
  return LITHE_OK;
}

static LitheIndex func_of(const LitheIndex *func, LitheCount slot) {
  return slot < 0 ? -1 : func ? func[slot] : (LitheIndex)slot;
}

/// Faces of a cell, and the cell as neighbour of these.
static void join_cell(LthMixed *m, const LitheIndex *func, LitheIndex c, LitheCount slot) {
  const LthStaggeredLevel *l = &m->level;
  LitheIndex cell[3], *own = m->func + (m->dim + 1) * (LitheCount)c;
  lth_sparse_grid_cell(l->grid, slot, cell);
  m->slot[c] = (LitheIndex)slot;
  own[0] = func_of(func, slot);
  m->beside[(m->dim + 1) * (LitheCount)own[0]] = c;
  for (int a = 0; a < m->dim; a++) {
    own[1 + a] = func_of(func, lth_sparse_grid_along(l->grid, cell, a, 1));
    m->beside[(m->dim + 1) * (LitheCount)own[1 + a] + 1 + a] = c;
  }
}

static void set_cell(LthMixed *m, LitheIndex c) {
  const LthStaggeredLevel *l = &m->level;
  const LitheCount slot = m->slot[c];
  m->volume[c] = sample(l, l->volume, slot);
  m->rest[c] = sample(l, l->lambda, slot) - sample(l, m->soft.lambda, slot);
  m->compliance[c] =
      sample(l, l->compliance, slot) > 0 ? m->volume[c] * m->volume[c] / m->rest[c] : 0;
}

static LitheStatus list_cells(LitheCtx *ctx, const LitheIndex *func, LthMixed *m) {
  const LthStaggeredLevel *l = &m->level;
  const LitheCount n_funcs = m->n_dofs / 3, tables = m->dim + 1;
  for (LitheCount s = 0; s < l->grid->n_slots; s++) m->n_cells += has_pressure(l, s);
  LTH_NEW(ctx, m->slot, m->n_cells);
  LTH_NEW(ctx, m->func, tables * m->n_cells);
  LTH_NEW(ctx, m->beside, tables * n_funcs);
  LTH_NEW(ctx, m->state, n_funcs);
  LTH_NEW(ctx, m->volume, (LitheCount)m->n_cells + 1);
  LTH_NEW(ctx, m->push, (LitheCount)m->n_cells + 1);
  LTH_NEW(ctx, m->rest, m->n_cells);
  LTH_NEW(ctx, m->compliance, m->n_cells);
  LTH_NEW(ctx, m->scale, m->n_cells);
  for (LitheCount i = 0; i < tables * n_funcs; i++) m->beside[i] = m->n_cells;
  LitheIndex n = 0;
  for (LitheCount s = 0; s < l->grid->n_slots; s++) {
    const LitheIndex f = func_of(func, s);
    for (int a = 0; f >= 0 && a < m->dim; a++)
      m->state[f] = (uint8_t)(m->state[f] | l->state[a][s] << 2 * a);
    if (has_pressure(l, s)) join_cell(m, func, n++, s);
  }
  for (LitheIndex c = 0; c < m->n_cells; c++) set_cell(m, c);
  return LITHE_OK;
}

static LitheStatus create(LitheCtx *ctx, const LitheIndex *func, LthMixed *m) {
  LITHE_TRY(split(ctx, m));
  LITHE_TRY(list_cells(ctx, func, m));
  const LthStaggeredMultigridDef def = {.level = &m->soft, .func = func, .n_dofs = m->n_dofs};
  return lth_staggered_multigrid_create(ctx, &def, &m->multigrid);
}

LitheStatus lth_mixed_create(LitheCtx *ctx, const LthStaggeredLevel *level, const LitheIndex *func,
                             LitheCount n_dofs, LthMixed **mixed) {
  LTH_NEW(ctx, *mixed, 1);
  **mixed = (LthMixed){.level = *level, .dim = level->grid->dim, .n_dofs = n_dofs};
  LitheStatus status = create(ctx, func, *mixed);
  if (status != LITHE_OK) lth_mixed_destroy(ctx, mixed);
  return status;
}

void lth_mixed_destroy(LitheCtx *ctx, LthMixed **mixed) {
  LthMixed *m = *mixed;
  if (!m) return;
  lth_staggered_multigrid_destroy(ctx, &m->multigrid);
  void *blocks[] = {m->soft.lambda, m->slot, m->func,       m->beside, m->state,
                    m->volume,      m->rest, m->compliance, m->scale,  m->push};
  for (size_t i = 0; i < sizeof blocks / sizeof blocks[0]; i++) lth_free(ctx, blocks[i]);
  lth_free(ctx, m);
  *mixed = NULL;
}

LitheCount lth_mixed_bytes(const LthMixed *m) {
  const LitheCount tables = (m->dim + 1) * (LitheCount)sizeof(LitheIndex);
  return lth_staggered_multigrid_bytes(m->multigrid) + (tables + 4 + 40) * m->n_cells +
         (tables + 1) * (m->n_dofs / 3) + 8 * (LitheCount)m->soft.n_rows * m->soft.grid->side;
}

/// Diagonal of the momentum row of a free face without lambda, over ck |cell|.
static double diagonal(const LthMixed *m, int a, LitheCount slot) {
  const LthStaggeredLevel *l = &m->level;
  const double *h = l->grid->h;
  LitheIndex cell[3];
  lth_sparse_grid_cell(l->grid, slot, cell);
  const double low = sample(l, l->mu, lth_sparse_grid_along(l->grid, cell, a, -1));
  double sum = 2 * (sample(l, l->mu, slot) + low) / (h[a] * h[a]);
  for (int b = 0; b < m->dim; b++) {
    if (b == a) continue;
    const double *shear = l->shear[3 - a - b];
    const double above = sample(l, shear, lth_sparse_grid_along(l->grid, cell, b, 1));
    sum += (sample(l, shear, slot) + above) / (h[b] * h[b]);
  }
  return sum + m->cm / m->ck * sample(l, l->mass[a], slot);
}

/// The inverse of B A^-1 B^T + C. Without lambda, div A^-1 div^T of a whole cell is 1 / (2 mu); by its own faces' diagonal alone it
/// seems to be dim / (dim + 1) / mu, so that the faces of other cells are taken in this proportion too: slivers hang on whole cells,
/// and resist as these do. lambda adds to the inverse (Fortin, Glowinski 1983).
static double scale_of(const LthMixed *m, LitheIndex c) {
  const LthStaggeredLevel *l = &m->level;
  const double *h = l->grid->h, V = m->volume[c], share = 0.5 * (m->dim + 1) / m->dim;
  const LitheCount slot = m->slot[c];
  double give = 0;
  LitheIndex cell[3];
  lth_sparse_grid_cell(l->grid, slot, cell);
  for (int a = 0; a < m->dim; a++)
    for (int side = 0; side < 2; side++) {
      const LitheCount face = side ? lth_sparse_grid_along(l->grid, cell, a, 1) : slot;
      if (is_free(l, a, face)) give += V * V / (h[a] * h[a] * diagonal(m, a, face));
    }
  const double stiffness = sample(l, m->soft.lambda, slot) / (V * V) + 1 / (share * give);
  return 1 / (1 / stiffness + m->compliance[c]);
}

LitheStatus lth_mixed_prepare(LitheCtx *ctx, LthMixed *m, double cm, double ck) {
  LITHE_TRY(lth_staggered_multigrid_prepare(ctx, m->multigrid, cm, ck));
  m->cm = cm;
  m->ck = ck;
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheIndex c = 0; c < m->n_cells; c++) m->scale[c] = scale_of(m, c);
  return LITHE_OK;
}

void lth_mixed_divergence(const LthMixed *m, int threads, const double *u, double *d) {
  const double *h = m->level.grid->h;
#pragma omp parallel for schedule(static) num_threads(threads)
  for (LitheIndex c = 0; c < m->n_cells; c++) {
    const LitheIndex *f = m->func + (m->dim + 1) * (LitheCount)c;
    d[c] = 0;
    for (int a = 0; a < m->dim; a++)
      d[c] += (u[3 * (LitheCount)f[1 + a] + a] - u[3 * (LitheCount)f[0] + a]) / h[a];
  }
}

void lth_mixed_follow(const LthMixed *m, int threads, const double *u) {
  lth_mixed_divergence(m, threads, u, m->push);
#pragma omp parallel for schedule(static) num_threads(threads)
  for (LitheIndex c = 0; c < m->n_cells; c++) m->push[c] *= m->rest[c] / m->volume[c];
}

void lth_mixed_push(const LthMixed *m, int threads, double c, bool held, const double *p,
                    double *f) {
  const double volume = lth_sparse_grid_cell_volume(m->level.grid);
  double per_h[3], *push = m->push;
  for (int a = 0; a < 3; a++) per_h[a] = c * volume / m->level.grid->h[a];
#pragma omp parallel for schedule(static) num_threads(threads)
  for (LitheIndex i = 0; i < m->n_cells; i++) push[i] = m->volume[i] * p[i];
#pragma omp parallel for schedule(static) num_threads(threads)
  for (LitheCount i = 0; i < m->n_dofs / 3; i++) {
    const LitheIndex *beside = m->beside + (m->dim + 1) * i;
    for (int a = 0; a < m->dim; a++) {
      const int state = m->state[i] >> 2 * a & 3;
      if (state == LTH_UNKNOWN_FREE || (held && state == LTH_UNKNOWN_HELD))
        f[3 * i + a] += per_h[a] * (push[beside[1 + a]] - push[beside[0]]);
    }
  }
}

void lth_mixed_apply(const LthMixed *m, int threads, const double *x, double *y) {
  const double unit = m->ck * lth_sparse_grid_cell_volume(m->level.grid);
  const double *p = x + m->n_dofs;
  double *g = y + m->n_dofs;
  lth_staggered_multigrid_apply(m->multigrid, threads, m->cm, m->ck, false, x, y);
  lth_mixed_push(m, threads, m->ck, false, p, y);
  lth_mixed_divergence(m, threads, x, g);
#pragma omp parallel for schedule(static) num_threads(threads)
  for (LitheIndex c = 0; c < m->n_cells; c++)
    g[c] = unit * (m->volume[c] * g[c] - m->compliance[c] * p[c]);
}

LitheStatus lth_mixed_precondition(LitheCtx *ctx, LthMixed *m, const double *r, double *work,
                                   double *z) {
  const double per_unit = 1 / (m->ck * lth_sparse_grid_cell_volume(m->level.grid));
  const int threads = lth_threads(ctx);
  double *p = z + m->n_dofs;
#pragma omp parallel for schedule(static) num_threads(threads)
  for (LitheIndex c = 0; c < m->n_cells; c++) p[c] = -per_unit * m->scale[c] * r[m->n_dofs + c];
  memcpy(work, r, sizeof *work * (size_t)m->n_dofs);
  lth_mixed_push(m, threads, -m->ck, false, p, work);
  return lth_staggered_multigrid_cycle(ctx, m->multigrid, work, z);
}
