/// External forces: body forces at the unknowns, and boundary loads as the discrete divergence of a stress field near
/// the boundary (docs/theory/staggered.md, "Tractions"). Dolny 2025, equation (4.20), derived anew there.
#include "disc/staggered/staggered_fringe.h"
#include "disc/staggered/staggered_priv.h"

typedef struct Loading {
  const LthLoad *load;
  double t, factor;    ///< factor: 1, or 1 / area of a total force
  const double *x;     ///< position, of followers
  double *f;           ///< NULL: sums only
  LthBoundarySum *sum; ///< per block, in the body's scratch
  double spread[3];    ///< force per weight that is added instead of the load's, where `spreads`
  bool spreads;
} Loading;

static void visit_body_force(const LthStaggered *s, LitheIndex func, const LitheCount *slot,
                             const int stride[3], void *self) {
  const Loading *l = self;
  double volume = lth_sparse_grid_cell_volume(s->grid), at[3];
  for (int a = 0; a < s->dim; a++) {
    if (!lth_staggered_slot_alive(s, a, *slot)) continue;
    lth_staggered_place(s, func, a, at);
    l->f[3 * (LitheCount)func + a] += volume * lth_staggered_own_fraction(s, slot, stride, a) *
                                      lth_value_at(&l->load->value[a], at, l->t);
  }
}

/// cof F of the body where it is nearest to the unknown.
static void cofactor_at(const LthStaggered *s, const LitheCount *slot, const int stride[3],
                        const LthFringe *rim, const double *x, double C[9]) {
  double F[9];
  LitheIndex cell = s->cell[*slot];
  if (cell < 0 && slot[-stride[rim->a]] >= 0) cell = s->cell[slot[-stride[rim->a]]];
  lth_m3_identity(C);
  if (cell < 0) return;
  lth_disc_sample_gradient(&s->disc, cell, x, rim->point, F);
  if (s->dim == 2) F[2] = F[5] = F[6] = F[7] = 0, F[8] = 1;
  lth_m3_cofactor(F, C);
}

static void traction_at(const Loading *l, const LthFringe *rim, double traction[3]) {
  const LthLoad *load = l->load;
  for (int b = 0; b < 3; b++)
    traction[b] = l->factor * lth_value_at(&load->value[b], rim->point, l->t);
}

/// Row a of a stress field P near the boundary with P N = traction.
static void stress_row(const LthStaggered *s, const Loading *l, const LitheCount *slot,
                       const int stride[3], const LthFringe *rim, double row[3]) {
  const LthLoad *load = l->load;
  int a = rim->a;
  if (load->kind == LTH_LOAD_STRESS) {
    for (int b = 0; b < 3; b++) row[b] = lth_value_at(&load->stress[3 * a + b], rim->point, l->t);
  } else if (load->kind == LTH_LOAD_PRESSURE) {
    double pressure = lth_value_at(&load->value[0], rim->point, l->t), C[9];
    lth_m3_identity(C);
    if (load->follower && l->x) cofactor_at(s, slot, stride, rim, l->x, C);
    for (int b = 0; b < 3; b++) row[b] = -pressure * C[3 * a + b];
  } else {
    const double *n = rim->normal;
    double t[3];
    traction_at(l, rim, t);
    for (int b = 0; b < 3; b++) row[b] = t[a] * n[b] + n[a] * t[b] - lth_v3_dot(t, n) * n[a] * n[b];
  }
}

/// The force that the boundary seen by an unknown is to get: its area is along the unknown's axis.
static void add_wanted(const LthStaggered *s, const Loading *l, const LitheCount *slot,
                       const int stride[3], const LthFringe *rim, double area, double wanted[3]) {
  const LthLoad *load = l->load;
  double C[9], t[3];
  if (load->kind == LTH_LOAD_PRESSURE && load->follower && l->x) {
    double force = -lth_value_at(&load->value[0], rim->point, l->t) * area;
    cofactor_at(s, slot, stride, rim, l->x, C);
    for (int b = 0; b < s->dim; b++) wanted[b] += force * C[3 * b + rim->a];
    return;
  }
  traction_at(l, rim, t);
  lth_v3_axpy(area * rim->normal[rim->a], t, wanted);
}

/// Force of the load on an unknown, counted in the sums.
static double rim_force(const LthStaggered *s, const Loading *l, const LitheCount *slot,
                        const int stride[3], const LthFringe *rim, LthBoundarySum *sum) {
  int a = rim->a;
  double volume = lth_sparse_grid_cell_volume(s->grid), row[3];
  double seen = fmax(0, volume * lth_v3_dot(rim->normal, rim->slope));
  double area = volume * rim->normal[a] * rim->slope[a];
  if (l->spreads) return seen * l->spread[a];
  stress_row(s, l, slot, stride, rim, row);
  double force = volume * lth_v3_dot(row, rim->slope);
  sum->area += area;
  sum->given[a] += force;
  sum->weight[a] += seen;
  add_wanted(s, l, slot, stride, rim, volume * rim->slope[a], sum->wanted);
  return force;
}

static bool is_selected(const Loading *l, const LthFringe *rim) {
  return !l->load->selects || l->load->selects(l->load->select_self, rim->point, rim->normal);
}

/// Does the shear sample of components a and b at slot[0] hang on an unknown that is not there? It has no stiffness, for that unknown
/// would follow whatever stress is given.
static bool hangs(const LthStaggered *s, const LitheCount *slot, const int stride[3], int a,
                  int b) {
  const LitheCount next[2] = {slot[-stride[b]], slot[-stride[a]]};
  if (*slot < 0 || lth_level_value(&s->level, s->level.shear[3 - a - b], *slot) > 0) return false;
  for (int k = 0; k < 2; k++) {
    int component = k ? a : b; // it differs along the other axis
    const uint8_t *state = s->level.state[component];
    if (state[*slot] == LTH_UNKNOWN_DEAD) return true;
    if (next[k] < 0 || state[next[k]] == LTH_UNKNOWN_DEAD) return true;
  }
  return false;
}

/// A sample that hangs has the stress given beside it, P_q, not the one beside the unknown, P: what that makes in the
/// unknown's row, V_q (P_q - P)_ab / h_b on either side. Without it a shear load acts half a cell inside the body.
static double hanging_force(const LthStaggered *s, const Loading *l, const LitheCount *slot,
                            const int stride[3], int a, const double here[3], const double P[3]) {
  double force = 0, at[3], row[3];
  for (int b = 0; b < s->dim; b++)
    for (int k = 0; k < 2 && b != a; k++) {
      const LitheCount *sample = slot + (k ? stride[b] : 0);
      if (!hangs(s, sample, stride, a, b)) continue;
      if (lth_fringe_is_on_roller(s, sample, stride, a, b)) continue; // a side of its own
      LthFringe rim = {.a = a};
      LitheIndex cell[3];
      double offset[3] = {0.5, 0.5, 0.5};
      offset[a] = offset[b] = 0;
      lth_sparse_grid_cell(s->grid, *sample, cell);
      lth_sparse_grid_place(s->grid, cell, offset, at);
      if (s->dim == 2) at[2] = 0;
      for (int c = 0; c < 3; c++)
        at[c] += 0.01 * (here[c] - at[c]); // at a corner: the unknown's own side
      rim.slope[b] = k ? 1 : -1;
      lth_fringe_nearest(s, at, &rim);
      row[b] = 0;
      if (is_selected(l, &rim)) stress_row(s, l, slot, stride, &rim, row);
      force += (k ? 1 : -1) * lth_staggered_edge_fraction(s, sample, stride, 3 - a - b) *
               (row[b] - P[b]) / s->grid->h[b];
    }
  return force * lth_sparse_grid_cell_volume(s->grid);
}

/// Force on an unknown of component a by the sides of rollers beside it.
static double roller_force(const LthStaggered *s, const Loading *l, LitheIndex func,
                           const LitheCount *slot, const int stride[3], int a,
                           const double side[3]) {
  LthBoundarySum *sum = &l->sum[*slot / s->grid->block_cells];
  double force = 0;
  for (int b = 0; b < s->dim; b++) {
    if (side[b] == 0) continue;
    LthFringe rim = lth_fringe_of_roller(s, func, a, b, side[b]);
    if (is_selected(l, &rim)) force += rim_force(s, l, slot, stride, &rim, sum);
  }
  return force;
}

static void visit_boundary(const LthStaggered *s, LitheIndex func, const LitheCount *slot,
                           const int stride[3], void *self) {
  const Loading *l = self;
  if (lth_fringe_is_inside(s, slot, stride)) return;
  LthBoundarySum *sum = &l->sum[*slot / s->grid->block_cells];
  for (int a = 0; a < s->dim; a++) {
    LthFringe rim = {.a = a};
    double at[3], side[3], P[3] = {0}, force = 0;
    if (!lth_staggered_slot_alive(s, a, *slot)) continue;
    bool falls = lth_fringe_slope(s, slot, stride, &rim, side);
    lth_staggered_place(s, func, a, at);
    if (falls) lth_fringe_boundary(s, at, &rim);
    if (falls && is_selected(l, &rim)) {
      force = rim_force(s, l, slot, stride, &rim, sum);
      stress_row(s, l, slot, stride, &rim, P);
    }
    if (falls && !l->spreads) {
      double more = hanging_force(s, l, slot, stride, a, at, P);
      sum->given[a] += more;
      force += more;
    }
    force += roller_force(s, l, func, slot, stride, a, side);
    if (l->f) l->f[3 * (LitheCount)func + a] += force;
  }
}

/// One pass over the boundary; sums of all blocks in their order.
static LthBoundarySum pass(const LthStaggered *s, Loading *l) {
  LthBoundarySum all = {0};
  l->sum = s->sums;
  memset(l->sum, 0, sizeof all * (size_t)s->grid->n_blocks);
  lth_staggered_visit(s, visit_boundary, l);
  for (LitheIndex b = 0; b < s->grid->n_blocks; b++) {
    all.area += l->sum[b].area;
    lth_v3_add(all.wanted, l->sum[b].wanted, all.wanted);
    lth_v3_add(all.given, l->sum[b].given, all.given);
    lth_v3_add(all.weight, l->sum[b].weight, all.weight);
  }
  return all;
}

/// Spread over the boundary what unknowns got less than the tractions are: samples at corners of the body have no
/// stiffness, and theirs is missing.
static void complete(const LthStaggered *s, Loading *l, const LthBoundarySum *sum) {
  for (int a = 0; a < s->dim; a++)
    l->spread[a] = sum->weight[a] > 0 ? (sum->wanted[a] - sum->given[a]) / sum->weight[a] : 0;
  l->spreads = true;
  pass(s, l);
}

static LitheStatus add_boundary(LitheCtx *ctx, const LthStaggered *s, Loading *l) {
  const LthLoad *load = l->load;
  double *f = l->f;
  bool is_total = load->kind == LTH_LOAD_TOTAL_FORCE;
  double area = load->area;
  if (is_total && !(area > 0)) {
    l->f = NULL;
    area = pass(s, l).area;
    l->f = f;
  }
  if (is_total) l->factor = area > 0 ? 1 / area : 0;
  LthBoundarySum sum = pass(s, l);
  if (!(sum.area > 0))
    LITHE_FAIL(ctx, LITHE_BAD_INPUT,
               "the load acts on no boundary of the body; choose a `where` that selects some");
  for (int a = 0; a < 3 && is_total; a++)
    sum.wanted[a] = lth_value_at(&load->value[a], (const double[3]){0}, l->t);
  bool follows = load->kind == LTH_LOAD_PRESSURE && load->follower && l->x;
  if (is_total || follows || load->kind == LTH_LOAD_TRACTION) complete(s, l, &sum);
  return LITHE_OK;
}

LitheStatus lth_staggered_add_load(LitheCtx *ctx, const LthDisc *disc, const LthLoad *load,
                                   double t, const double *x, double *f) {
  const LthStaggered *s = lth_staggered_const(disc);
  Loading l = {.load = load, .t = t, .factor = 1, .x = x, .f = f};
  if (load->kind != LTH_LOAD_BODY_FORCE) return add_boundary(ctx, s, &l);
  lth_staggered_visit(s, visit_body_force, &l);
  lth_staggered_load_beyond(s, load, t, f);
  return LITHE_OK;
}
