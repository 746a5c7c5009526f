/// Corotated and neo-Hookean bodies on the staggered grid: the calls of disc.h that differ from linear ones.
#include "disc/staggered/staggered_finite.h"

#include <math.h>
#include <string.h>

static LitheIndex wrapped(LitheIndex i) { return i % 3; }

static int color_of(const LthStaggered *s, LitheIndex cell) {
  LitheIndex at[3];
  lth_sparse_grid_cell(s->grid, s->cell_slot[cell], at);
  return (int)(wrapped(at[0]) + 3 * wrapped(at[1]) + (s->dim == 3 ? 9 * wrapped(at[2]) : 0));
}

/// Cells three apart along some axis share no unknown.
static LitheStatus color_cells(LitheCtx *ctx, const LthStaggered *s, LthStaggeredFinite *n) {
  n->n_colors = s->dim == 3 ? 27 : 9;
  LTH_NEW(ctx, n->color_off, (LitheCount)n->n_colors + 1);
  LTH_NEW(ctx, n->color, s->disc.n_cells);
  for (LitheIndex c = 0; c < s->disc.n_cells; c++) n->color_off[color_of(s, c) + 1]++;
  for (int k = 0; k < n->n_colors; k++) n->color_off[k + 1] += n->color_off[k];
  LitheIndex at[27];
  memcpy(at, n->color_off, sizeof *at * (size_t)n->n_colors);
  for (LitheIndex c = 0; c < s->disc.n_cells; c++) n->color[at[color_of(s, c)]++] = c;
  return LITHE_OK;
}

static void update_rotations(LthDisc *disc, const double *x) {
  LthStaggeredFinite *n = lth_staggered_finite_of(disc->self);
  if (x)
    memcpy(n->x, x, sizeof *x * (size_t)disc->n_dofs);
  else
    disc->table->rest(disc, n->x);
}

static double energy(LthDisc *disc, double t, const double *x) {
  const LthStaggered *s = disc->self;
  LthStaggeredFinite *n = lth_staggered_finite_of(s);
  double sum = 0;
  (void)t;
#pragma omp parallel for schedule(static) num_threads(lth_threads(s->ctx))
  for (LitheIndex cell = 0; cell < disc->n_cells; cell++) {
    LthFiniteCell c;
    lth_finite_cell_read(s, cell, x, &c);
    n->partial[cell] = lth_finite_cell_energy(&c);
  }
  for (LitheIndex cell = 0; cell < disc->n_cells; cell++) sum += n->partial[cell];
  return sum;
}

static double gradient_change(const LthDisc *disc, const double *from, const double *to) {
  const LthStaggered *s = disc->self;
  LthStaggeredFinite *n = lth_staggered_finite_of(s);
  double sum = 0;
#pragma omp parallel for schedule(static) num_threads(lth_threads(s->ctx))
  for (LitheIndex cell = 0; cell < disc->n_cells; cell++) {
    LthFiniteCell a, b;
    lth_finite_cell_read(s, cell, from, &a);
    lth_finite_cell_read(s, cell, to, &b);
    n->partial[cell] = 0;
    for (int q = 0; q < n->layout.n_parts; q++)
      for (int k = 0; k < s->dim * s->dim; k++) {
        int entry = n->layout.part[q][k];
        double change = b.value[entry] - a.value[entry];
        n->partial[cell] += change * change / n->layout.n_parts;
      }
  }
  for (LitheIndex cell = 0; cell < disc->n_cells; cell++) sum += n->partial[cell];
  return sqrt(sum / disc->n_cells);
}

/// Means of cells, linear from centre to centre among those that live around the place.
static void stress(const LthDisc *disc, LitheIndex cell, const double *x, const double at[3],
                   double values[6]) {
  const LthStaggered *s = disc->self;
  const LthSparseGrid *g = s->grid;
  LitheIndex place[3];
  double r[3] = {0}, sum = 0;
  lth_sparse_grid_cell(g, s->cell_slot[cell], place);
  for (int a = 0; a < s->dim; a++)
    r[a] = fmin(fmax((at[a] - g->origin[a]) / g->h[a] - place[a] - 0.5, -0.5), 0.5);
  memset(values, 0, 6 * sizeof *values);
  for (int k = 0; k < 1 << s->dim; k++) {
    int d[3] = {0};
    double w = 1, one[6];
    for (int a = 0; a < s->dim; a++) {
      bool beside = k >> a & 1;
      d[a] = beside ? (r[a] < 0 ? -1 : 1) : 0;
      w *= beside ? fabs(r[a]) : 1 - fabs(r[a]);
    }
    LitheCount slot = lth_sparse_grid_step(g, s->cell_slot[cell], d);
    if (w == 0 || slot < 0 || s->cell[slot] < 0) continue;
    LthFiniteCell c;
    lth_finite_cell_read(s, s->cell[slot], x, &c);
    lth_finite_cell_stress(&c, one);
    for (int i = 0; i < 6; i++) values[i] += w * one[i];
    sum += w;
  }
  for (int i = 0; i < 6 && sum > 0; i++) values[i] /= sum;
}

static LitheStatus build(LitheCtx *ctx, LthStaggered *s, LthStaggeredFinite *n) {
  lth_finite_lay_out(s->dim, &n->layout);
  LTH_NEW(ctx, n->x, s->disc.n_dofs);
  LTH_NEW(ctx, n->partial, s->disc.n_cells);
  LITHE_TRY(color_cells(ctx, s, n));
  n->table = *s->disc.table;
  n->table.solver = NULL;
  n->table.matrix_create = lth_finite_matrix_create;
  n->table.update_rotations = update_rotations;
  n->table.assemble = lth_finite_assemble;
  n->table.assemble_load = lth_finite_assemble_load;
  n->table.energy = energy;
  n->table.gradient_change = gradient_change;
  n->table.stress = stress;
  s->disc.table = &n->table;
  s->disc.has_tangent = true;
  update_rotations(&s->disc, NULL);
  return LITHE_OK;
}

LitheStatus lth_staggered_finite_attach(LitheCtx *ctx, LthStaggered *s) {
  LthStaggeredFinite *n = NULL;
  if (s->formulation == LTH_FORM_MIXED)
    LITHE_FAIL(ctx, LITHE_BAD_INPUT,
               "formulation: mixed is for linear bodies; take formulation: displacement for "
               "corotated and neo-Hookean ones");
  LTH_NEW(ctx, n, 1);
  s->nonlinear = n;
  return build(ctx, s, n);
}

void lth_staggered_finite_free(LitheCtx *ctx, LthStaggered *s) {
  LthStaggeredFinite *n = s->nonlinear;
  if (!n) return;
  void *blocks[] = {n->x, n->partial, n->color_off, n->color, n};
  for (size_t i = 0; i < sizeof blocks / sizeof blocks[0]; i++) lth_free(ctx, blocks[i]);
  s->nonlinear = NULL;
}
