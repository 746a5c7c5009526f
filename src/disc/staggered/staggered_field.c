/// Fields as unknowns: rest places, interpolation, rotations; and which cell a place is in.
#include "disc/staggered/staggered_priv.h"

void lth_staggered_rest(const LthDisc *disc, double *x0) {
  const LthStaggered *s = lth_staggered_const(disc);
#pragma omp parallel for schedule(static) num_threads(lth_threads(s->ctx))
  for (LitheIndex i = 0; i < disc->n_funcs; i++)
    for (int a = 0; a < 3; a++) {
      double x[3];
      lth_staggered_place(s, i, a, x);
      x0[3 * (LitheCount)i + a] = x[a];
    }
}

void lth_staggered_one(const LthDisc *disc, double *one) {
  for (LitheIndex i = 0; i < disc->n_funcs; i++) one[i] = 1;
}

LitheStatus lth_staggered_project(LitheCtx *ctx, const LthDisc *disc,
                                  void (*field)(const void *self, const double x[3],
                                                double value[3]),
                                  const void *self, double *coef) {
  const LthStaggered *s = lth_staggered_const(disc);
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheIndex i = 0; i < disc->n_funcs; i++)
    for (int a = 0; a < 3; a++) {
      double x[3], value[3] = {0};
      lth_staggered_place(s, i, a, x);
      if (a < s->dim) field(self, x, value);
      coef[3 * (LitheCount)i + a] = value[a];
    }
  return LITHE_OK;
}

/// A live cell beside face a of a slot, or of a held unknown that touches none across a shear sample that reads it.
static LitheCount cell_beside(const LthStaggered *s, LitheCount slot, int a) {
  for (int k = 0; k <= 2 * s->dim; k++) // its own, then those one step along an axis
    for (int side = 0; side < 2; side++) {
      int d[3] = {0};
      if (k > 0 && (k - 1) / 2 == a) continue;
      if (k > 0) d[(k - 1) / 2] = k % 2 ? -1 : 1;
      d[a] = -side;
      LitheCount cell = lth_sparse_grid_step(s->grid, slot, d);
      if (lth_level_is_live(&s->level, cell)) return cell;
    }
  return -1;
}

/// Component b of a field where the unknown of component a stands.
static double value_beside(const LthStaggered *s, LitheIndex i, int a, int b, const double *x) {
  LitheCount cell = cell_beside(s, s->slot[i], a);
  if (cell < 0) return x[3 * (LitheCount)i + b];
  double at[3], value = 0;
  LthStencil t;
  lth_staggered_place(s, i, a, at);
  lth_staggered_stencil(s, cell, b, at, 0, &t);
  for (int k = 0; k < t.n; k++) value += t.w[k] * x[3 * (LitheCount)s->func[t.slot[k]] + b];
  return value;
}

void lth_staggered_turn(const LthDisc *disc, int axis, const double *x, double *y) {
  const LthStaggered *s = lth_staggered_const(disc);
  int b = (axis + 1) % 3, c = (axis + 2) % 3;
#pragma omp parallel for schedule(static) num_threads(lth_threads(s->ctx))
  for (LitheIndex i = 0; i < disc->n_funcs; i++) {
    double *to = y + 3 * (LitheCount)i;
    memset(to, 0, 3 * sizeof *to);
    if (b < s->dim && lth_staggered_slot_alive(s, b, s->slot[i]))
      to[b] = c < s->dim ? -value_beside(s, i, b, c, x) : 0;
    if (c < s->dim && lth_staggered_slot_alive(s, c, s->slot[i]))
      to[c] = b < s->dim ? value_beside(s, i, c, b, x) : 0;
  }
}

/// Squared distance of x from a slot's cell.
static double distance2(const LthSparseGrid *g, LitheCount slot, const double x[3]) {
  LitheIndex cell[3];
  double sum = 0;
  lth_sparse_grid_cell(g, slot, cell);
  for (int a = 0; a < g->dim; a++) {
    double low = g->origin[a] + g->h[a] * cell[a];
    double beyond = fmax(0, fmax(low - x[a], x[a] - low - g->h[a]));
    sum += beyond * beyond;
  }
  return sum;
}

/// The nearest live cell among the neighbours of a grid cell, or -1.
static LitheIndex nearest_around(const LthStaggered *s, const LitheIndex at[3], const double x[3]) {
  LitheIndex best = -1;
  double best2 = INFINITY;
  int deep = s->dim == 3;
  for (int k = deep ? 0 : 9; k < (deep ? 27 : 18); k++) {
    LitheCount slot =
        lth_sparse_grid_slot(s->grid, at[0] + k % 3 - 1, at[1] + k / 3 % 3 - 1, at[2] + k / 9 - 1);
    if (slot < 0 || s->cell[slot] < 0) continue;
    double d2 = distance2(s->grid, slot, x);
    if (d2 < best2) best2 = d2, best = s->cell[slot];
  }
  return best;
}

static LitheIndex nearest_of_all(const LthStaggered *s, const double x[3]) {
  LitheIndex best = 0;
  double best2 = INFINITY;
  for (LitheIndex c = 0; c < s->disc.n_cells; c++) {
    double d2 = distance2(s->grid, s->cell_slot[c], x);
    if (d2 < best2) best2 = d2, best = c;
  }
  return best;
}

LitheIndex lth_staggered_find_cell(const LthDisc *disc, const double x[3], bool *inside) {
  const LthStaggered *s = lth_staggered_const(disc);
  const LthSparseGrid *g = s->grid;
  LitheIndex at[3] = {0};
  bool within = true;
  for (int a = 0; a < s->dim; a++) {
    double place = floor((x[a] - g->origin[a]) / g->h[a]);
    within &= place >= 0 && place < g->n[a];
    at[a] = within ? (LitheIndex)place : 0;
  }
  LitheCount slot = within ? lth_sparse_grid_slot(g, at[0], at[1], at[2]) : -1;
  LitheIndex cell = slot < 0 ? -1 : s->cell[slot];
  if (inside) *inside = s->shape ? lth_shape_value(s->shape, x) <= 0 : cell >= 0;
  if (cell < 0 && within) cell = nearest_around(s, at, x);
  return cell >= 0 ? cell : nearest_of_all(s, x);
}
