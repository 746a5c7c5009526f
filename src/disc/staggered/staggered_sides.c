/// What cut rows make of the stress along a boundary under smooth fractions, and the load that takes it off (docs/theory/staggered.md,
/// "Stress along the boundary").
#include "disc/staggered/staggered_fringe.h"

#define DEPTH 2      // cells inside of the boundary, where stresses are those of the interior
#define STRAIGHT 0.7 // cosine: what falls towards the boundary, and not along it

typedef struct Sides {
  const LthLoad *load;
  double t, depth;
  const double *x;
  double *f;
} Sides;

/// Something within one cell is full because it is held.
static bool touches_held(const LthStaggered *s, const LitheCount *slot, const int stride[3]) {
  int deep = s->dim == 3;
  if (!s->own) return false;
  for (int z = -deep; z <= deep; z++)
    for (int y = -1; y <= 1; y++)
      for (int x = -1; x <= 1; x++) {
        LitheCount cell = slot[x * stride[0] + y * stride[1] + z * stride[2]];
        if (cell >= 0 && lth_fractions_cell(s->own, cell) != lth_fractions_cell(s->fractions, cell))
          return true;
      }
  return false;
}

/// Stress of the body behind a boundary point, less that of loads that are given as a stress.
static bool stress_behind(const LthStaggered *s, const Sides *l, const LthFringe *rim,
                          double P[9]) {
  double at[3], f[6];
  bool inside = false;
  lth_v3_copy(rim->point, at);
  lth_v3_axpy(-l->depth, rim->normal, at);
  LitheIndex cell = lth_staggered_find_cell(&s->disc, at, &inside);
  if (cell < 0 || !inside) return false;
  lth_staggered_stress(&s->disc, cell, l->x, at, f);
  for (int i = 0; i < 9; i++) {
    int a = i / 3, b = i % 3;
    P[i] = f[a == b ? a : 6 - a - b];
  }
  for (LitheIndex k = 0; k < l->load->n_others; k++) {
    const LthLoad *o = &l->load->others[k];
    if (o->kind != LTH_LOAD_STRESS && o->kind != LTH_LOAD_PRESSURE) continue;
    if (o->selects && !o->selects(o->select_self, rim->point, rim->normal)) continue;
    for (int i = 0; i < 9; i++)
      if (o->kind == LTH_LOAD_STRESS)
        P[i] -= lth_value_at(&o->stress[i], rim->point, l->t);
      else if (i % 4 == 0)
        P[i] += lth_value_at(&o->value[0], rim->point, l->t);
  }
  return true;
}

/// Row a of T P T with T = I - N N^T: what P is along the boundary.
static void row_along(const double P[9], const double n[3], int a, double row[3]) {
  double left[3], along = 0; // e_a T P
  for (int b = 0; b < 3; b++) {
    left[b] = P[3 * a + b];
    for (int c = 0; c < 3; c++) left[b] -= n[a] * n[c] * P[3 * c + b];
    along += left[b] * n[b];
  }
  for (int b = 0; b < 3; b++) row[b] = left[b] - along * n[b];
}

static double side_force(const LthStaggered *s, const Sides *l, const LthFringe *rim) {
  double P[9], row[3], slope = lth_v3_norm(rim->slope);
  if (lth_v3_dot(rim->normal, rim->slope) < STRAIGHT * slope) return 0;
  if (!stress_behind(s, l, rim, P)) return 0;
  row_along(P, rim->normal, rim->a, row);
  return lth_sparse_grid_cell_volume(s->grid) * lth_v3_dot(row, rim->slope);
}

static void visit(const LthStaggered *s, LitheIndex func, const LitheCount *slot,
                  const int stride[3], void *self) {
  const Sides *l = self;
  if (lth_fringe_is_inside(s, slot, stride) || touches_held(s, slot, stride)) return;
  for (int a = 0; a < s->dim; a++) {
    LthFringe rim = {.a = a};
    double side[3], at[3];
    if (s->level.state[a][*slot] != LTH_UNKNOWN_FREE) continue;
    if (!lth_fringe_slope(s, slot, stride, &rim, side)) continue;
    lth_staggered_place(s, func, a, at);
    lth_fringe_boundary(s, at, &rim);
    l->f[3 * (LitheCount)func + a] += side_force(s, l, &rim);
  }
}

void lth_staggered_correct_sides(const LthStaggered *s, const LthLoad *load, double t,
                                 const double *x, double *f) {
  double widest = 0;
  for (int a = 0; a < s->dim; a++) widest = fmax(widest, s->grid->h[a]);
  Sides l = {.load = load, .t = t, .depth = DEPTH * widest, .x = x, .f = f};
  lth_staggered_visit(s, visit, &l);
}
