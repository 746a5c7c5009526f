/// Values between unknowns: each component (bi- or tri-)linear between its own faces, and linear where some of them
/// are missing. Linear fields are exact (docs/theory/staggered.md, "Interpolation").
#include "disc/staggered/staggered_priv.h"

/// Place in a cell: 0 to 1 along every axis.
static void cell_place(const LthStaggered *s, LitheCount slot, const double x[3], double xi[3]) {
  LitheIndex cell[3];
  lth_sparse_grid_cell(s->grid, slot, cell);
  for (int a = 0; a < 3; a++) xi[a] = (x[a] - s->grid->origin[a]) / s->grid->h[a] - cell[a];
}

/// An unknown that is there, and whose cells hold `least` between them.
static bool counts(const LthStaggered *s, LitheCount slot, int a, double least) {
  if (!lth_staggered_slot_alive(s, a, slot)) return false;
  if (least <= 0) return true;
  const int below[3] = {-(a == 0), -(a == 1), -(a == 2)};
  LitheCount low = lth_sparse_grid_step(s->grid, slot, below);
  return lth_level_value(&s->level, s->level.volume, slot) +
             lth_level_value(&s->level, s->level.volume, low) >=
         2 * least;
}

static void add_node(LthStencil *t, LitheCount slot, double w, const double dw[3]) {
  int i = 0;
  while (i < t->n && t->slot[i] != slot) i++;
  if (i == t->n) {
    LITHE_ASSERT(t->n < LTH_STENCIL_MAX);
    t->slot[i] = slot;
    t->w[i] = 0;
    memset(t->dw[i], 0, sizeof t->dw[i]);
    t->n++;
  }
  t->w[i] += w;
  lth_v3_axpy(1, dw, t->dw[i]);
}

/// The product of linear functions between the nodes at offsets base and base + 1; false where one is not alive.
static bool product_stencil(const LthStaggered *s, LitheCount slot, int a, const double xi[3],
                            const int base[3], double least, LthStencil *t) {
  t->n = 0;
  for (int k = 0; k < 1 << s->dim; k++) {
    double w = 1, dw[3] = {0};
    int d[3] = {0};
    for (int b = 0; b < s->dim; b++) d[b] = base[b] + (k >> b & 1);
    LitheCount node = lth_sparse_grid_step(s->grid, slot, d);
    if (!counts(s, node, a, least)) return false;
    for (int b = 0; b < s->dim; b++) dw[b] = 1;
    for (int b = 0; b < s->dim; b++) {
      double r = xi[b] - (b == a ? 0 : 0.5) - base[b], high = k >> b & 1;
      double value = high ? r : 1 - r, slope = (high ? 1 : -1) / s->grid->h[b];
      w *= value;
      for (int c = 0; c < s->dim; c++) dw[c] *= c == b ? slope : value;
    }
    add_node(t, node, w, dw);
  }
  return true;
}

/// Slope of component a across axis b over a cell: the mean over its two faces of differences between the faces on
/// both sides, or to the one there is; false where there is none.
static int slope_nodes(const LthStaggered *s, LitheCount slot, int a, int b, double least,
                       LitheCount node[6], double c[6]) {
  int n = 0, faces = 0;
  for (int face = 0; face < 2; face++) {
    LitheCount at[3]; // below, own, above
    for (int k = -1; k <= 1; k++) {
      int d[3] = {0};
      d[a] = face;
      d[b] = k;
      at[k + 1] = lth_sparse_grid_step(s->grid, slot, d);
    }
    int low = counts(s, at[0], a, least) ? 0 : 1, high = counts(s, at[2], a, least) ? 2 : 1;
    if (low == high || !lth_staggered_slot_alive(s, a, at[1])) continue;
    node[n] = at[high];
    c[n++] = 1 / ((high - low) * s->grid->h[b]);
    node[n] = at[low];
    c[n++] = -1 / ((high - low) * s->grid->h[b]);
    faces++;
  }
  for (int i = 0; i < n; i++) c[i] /= faces;
  return n;
}

/// Linear between the cell's own two faces, with slopes across.
static void linear_stencil(const LthStaggered *s, LitheCount slot, int a, const double xi[3],
                           double least, LthStencil *t) {
  t->n = 0;
  for (int face = 0; face < 2; face++) {
    double dw[3] = {0};
    int d[3] = {0};
    d[a] = face;
    dw[a] = (face ? 1 : -1) / s->grid->h[a];
    add_node(t, lth_sparse_grid_step(s->grid, slot, d), face ? xi[a] : 1 - xi[a], dw);
  }
  for (int b = 0; b < s->dim; b++) {
    LitheCount node[6];
    double c[6];
    int n = b == a ? 0 : slope_nodes(s, slot, a, b, least, node, c);
    for (int i = 0; i < n; i++) {
      double dw[3] = {0};
      dw[b] = c[i];
      add_node(t, node[i], c[i] * (xi[b] - 0.5) * s->grid->h[b], dw);
    }
  }
}

// Across a component's own axis the nodes on the place's side are taken, or those on the other side where one of
// them is missing: the value is then that of the same linear function carried on.
void lth_staggered_stencil(const LthStaggered *s, LitheCount slot, int a, const double x[3],
                           double least, LthStencil *t) {
  double xi[3];
  int across[2], n = 0;
  cell_place(s, slot, x, xi);
  for (int b = 0; b < s->dim; b++)
    if (b != a) across[n++] = b;
  for (int flip = 0; flip < 1 << n; flip++) {
    int base[3] = {0};
    for (int k = 0; k < n; k++) {
      bool below = (xi[across[k]] < 0.5) != (flip >> k & 1);
      base[across[k]] = below ? -1 : 0;
    }
    if (product_stencil(s, slot, a, xi, base, least, t)) return;
  }
  linear_stencil(s, slot, a, xi, least, t);
}

void lth_staggered_mean_stencil(const LthStaggered *s, LitheCount slot, int a, double least,
                                LthStencil *t) {
  linear_stencil(s, slot, a, (const double[3]){0.5, 0.5, 0.5}, least, t);
}

/// The components' functions as one ascending list.
static int list_funcs(const LthStaggered *s, const LthStencil stencil[3], LitheIndex *func) {
  int n = 0;
  for (int a = 0; a < s->dim; a++)
    for (int k = 0; k < stencil[a].n; k++) {
      LitheIndex f = s->func[stencil[a].slot[k]];
      int i = n;
      while (i > 0 && func[i - 1] > f) i--;
      if (i > 0 && func[i - 1] == f) continue;
      LITHE_ASSERT(n < LTH_DISC_MAX_FUNCS);
      memmove(func + i + 1, func + i, sizeof *func * (size_t)(n - i));
      func[i] = f;
      n++;
    }
  return n;
}

static int place_in(const LitheIndex *func, LitheIndex f) {
  int i = 0;
  while (func[i] != f) i++;
  return i;
}

/// In 2D the z unknowns are zero; they take the functions of x.
static int source_of(const LthStaggered *s, int a) { return a < s->dim ? a : 0; }

static int gather_values(const LthStaggered *s, const LthStencil stencil[3], LitheIndex *func,
                         double *phi) {
  int n = list_funcs(s, stencil, func);
  memset(phi, 0, sizeof *phi * 3 * (size_t)n);
  for (int a = 0; a < 3; a++) {
    const LthStencil *t = &stencil[source_of(s, a)];
    for (int k = 0; k < t->n; k++) phi[3 * place_in(func, s->func[t->slot[k]]) + a] = t->w[k];
  }
  return n;
}

static int gather_slopes(const LthStaggered *s, const LthStencil stencil[3], LitheIndex *func,
                         double *dphi) {
  int n = list_funcs(s, stencil, func);
  memset(dphi, 0, sizeof *dphi * 9 * (size_t)n);
  for (int a = 0; a < 3; a++) {
    const LthStencil *t = &stencil[source_of(s, a)];
    for (int k = 0; k < t->n; k++)
      lth_v3_copy(t->dw[k], dphi + 9 * place_in(func, s->func[t->slot[k]]) + 3 * a);
  }
  return n;
}

static void stencils_at(const LthStaggered *s, LitheIndex cell, const double x[3],
                        LthStencil stencil[3]) {
  for (int a = 0; a < s->dim; a++)
    lth_staggered_stencil(s, s->cell_slot[cell], a, x, 0, &stencil[a]);
}

int lth_staggered_eval(const LthDisc *disc, LitheIndex cell, const double x[3], LitheIndex *func,
                       double *phi) {
  LthStencil stencil[3];
  stencils_at(disc->self, cell, x, stencil);
  return gather_values(disc->self, stencil, func, phi);
}

int lth_staggered_eval_gradient(const LthDisc *disc, LitheIndex cell, const double x[3],
                                LitheIndex *func, double *dphi) {
  LthStencil stencil[3];
  stencils_at(disc->self, cell, x, stencil);
  return gather_slopes(disc->self, stencil, func, dphi);
}

int lth_staggered_mean_gradient(const LthDisc *disc, LitheIndex cell, LitheIndex *func,
                                double *dphi) {
  const LthStaggered *s = lth_staggered_const(disc);
  LthStencil stencil[3];
  for (int a = 0; a < s->dim; a++)
    lth_staggered_mean_stencil(s, s->cell_slot[cell], a, 0, &stencil[a]);
  return gather_slopes(s, stencil, func, dphi);
}
