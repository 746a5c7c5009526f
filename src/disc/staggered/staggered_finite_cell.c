/// Energy, forces and tangent of one cell: each part pairs the cell's own normal derivatives with those at its
/// edges (docs/theory/staggered-finite.md).
#include "disc/staggered/staggered_finite.h"

#include "base/tensor.h"

static LitheCount slot_at(const LthStaggered *s, LitheCount slot, const int offset[3]) {
  return lth_sparse_grid_step(s->grid, slot, offset);
}

static void read_unknowns(const double *x, LitheCount slot, LthFiniteCell *c) {
  const LthStaggered *s = c->s;
  const LthFiniteLayout *l = c->layout;
  LitheCount at[LTH_FINITE_NODES];
  for (int i = 0; i < l->n_nodes; i++) {
    at[i] = slot_at(s, slot, l->offset[i]);
    c->func[i] = at[i] < 0 ? -1 : s->func[at[i]];
  }
  for (int i = 0; i < l->n_dofs; i++) {
    LitheIndex func = c->func[l->node[i]];
    int a = l->component[i];
    c->alive[i] = func >= 0 && s->level.state[a][at[l->node[i]]] != LTH_UNKNOWN_DEAD;
    c->u[i] = c->alive[i] ? x[3 * (LitheCount)func + a] : 0;
  }
}

static bool is_native(const LthFiniteCell *c, int entry) {
  const LthFiniteEntry *e = &c->layout->entry[entry];
  return c->alive[e->lo] && c->alive[e->hi];
}

/// Where an unknown of the entry is dead: the mean of its kin that live, else what turns with those of the transposed.
static void find_sources(LthFiniteCell *c, int entry) {
  const LthFiniteLayout *l = c->layout;
  const int turned = l->entry[entry].turned;
  c->n_from[entry] = 0;
  if (is_native(c, entry)) {
    c->from[entry][c->n_from[entry]++] = entry;
    c->share[entry] = 1;
    return;
  }
  for (int sign = 1; sign >= -1 && c->n_from[entry] == 0; sign -= 2) {
    const LthFiniteEntry *e = &l->entry[sign > 0 ? entry : turned];
    for (int k = 0; k < e->n_kin; k++)
      if (is_native(c, e->kin[k])) c->from[entry][c->n_from[entry]++] = e->kin[k];
    c->share[entry] = c->n_from[entry] ? (double)sign / c->n_from[entry] : 0;
  }
}

static void read_entries(LthFiniteCell *c) {
  const LthFiniteLayout *l = c->layout;
  double native[LTH_FINITE_ENTRIES];
  for (int k = 0; k < l->n_entries; k++) {
    const LthFiniteEntry *e = &l->entry[k];
    native[k] = (c->u[e->hi] - c->u[e->lo]) / c->s->grid->h[e->b];
    find_sources(c, k);
  }
  for (int k = 0; k < l->n_entries; k++) {
    c->value[k] = 0;
    for (int i = 0; i < c->n_from[k]; i++) c->value[k] += native[c->from[k][i]];
    c->value[k] *= c->share[k];
  }
}

/// Shears of a part whose samples rule A has taken out.
static unsigned loose_shears(const LthFiniteCell *c, LitheCount slot, int part) {
  const LthFiniteLayout *l = c->layout;
  unsigned loose = 0;
  for (int i = 0; i < l->dim * l->dim; i++) {
    const LthFiniteEntry *e = &l->entry[l->part[part][i]];
    if (e->edge < 0) continue;
    LitheCount at = slot_at(c->s, slot, e->offset);
    if (at < 0 || !(c->s->level.shear[e->edge][at] > 0)) loose |= 1u << e->edge;
  }
  return loose;
}

void lth_finite_cell_read(const LthStaggered *s, LitheIndex cell, const double *x,
                          LthFiniteCell *c) {
  const LitheCount slot = s->cell_slot[cell];
  c->s = s;
  c->layout = &lth_staggered_finite_of(s)->layout;
  read_unknowns(x, slot, c);
  read_entries(c);
  double size = lth_sparse_grid_cell_volume(s->grid) / c->layout->n_parts;
  c->volume = 0;
  for (int q = 0; q < c->layout->n_parts; q++) {
    c->weight[q] = size * lth_fractions_part(s->fractions, slot, q);
    c->loose[q] = c->weight[q] > 0 ? loose_shears(c, slot, q) : 0;
    c->volume += c->weight[q];
  }
  c->lambda = s->level.lambda[slot] / s->level.volume[slot];
  c->material = (LthFinite){
      .model = s->model, .dim = s->dim, .mu = s->level.mu[slot] / s->level.volume[slot]};
}

void lth_finite_cell_gradient(const LthFiniteCell *c, int part, double *F) {
  const int *entry = c->layout->part[part];
  for (int i = 0; i < c->layout->dim * c->layout->dim; i++) F[i] = c->value[entry[i]];
}

static LthFinite part_material(const LthFiniteCell *c, int part) {
  LthFinite m = c->material;
  m.loose = c->loose[part];
  return m;
}

/// Energy of shape of all parts; *v is the mean of v.
static double sum_parts(const LthFiniteCell *c, double *v) {
  double F[9], energy = 0, sum = 0;
  for (int q = 0; q < c->layout->n_parts; q++) {
    if (!(c->weight[q] > 0)) continue;
    LthFinite m = part_material(c, q);
    double part;
    lth_finite_cell_gradient(c, q, F);
    energy += c->weight[q] * lth_finite_energy(&m, F, &part);
    sum += c->weight[q] * part;
  }
  *v = sum / c->volume;
  return energy;
}

double lth_finite_cell_volume(const LthFiniteCell *c) {
  double v;
  sum_parts(c, &v);
  return v;
}

double lth_finite_cell_energy(const LthFiniteCell *c) {
  double v, energy = sum_parts(c, &v);
  return energy + 0.5 * c->lambda * c->volume * v * v;
}

/// g (entries) += weight times a gradient of a part.
static void add_part(const LthFiniteCell *c, int part, double weight, const double *G, double *g) {
  const int *entry = c->layout->part[part];
  for (int i = 0; i < c->layout->dim * c->layout->dim; i++) g[entry[i]] += weight * G[i];
}

/// Sums of w P and w G over entries; returns the mean of v.
static double entry_stress(const LthFiniteCell *c, double *gP, double *gG) {
  double F[9], P[9], G[9], v, sum = 0;
  memset(gP, 0, sizeof *gP * LTH_FINITE_ENTRIES);
  memset(gG, 0, sizeof *gG * LTH_FINITE_ENTRIES);
  for (int q = 0; q < c->layout->n_parts; q++) {
    if (!(c->weight[q] > 0)) continue;
    LthFinite m = part_material(c, q);
    lth_finite_cell_gradient(c, q, F);
    lth_finite_stress(&m, F, &v, P, G);
    add_part(c, q, c->weight[q], P, gP);
    add_part(c, q, c->weight[q], G, gG);
    sum += c->weight[q] * v;
  }
  return sum / c->volume;
}

void lth_finite_cell_force(const LthFiniteCell *c, double *f) {
  const LthFiniteLayout *l = c->layout;
  double gP[LTH_FINITE_ENTRIES], gG[LTH_FINITE_ENTRIES], p = c->lambda * entry_stress(c, gP, gG);
  memset(f, 0, sizeof *f * (size_t)l->n_dofs);
  for (int k = 0; k < l->n_entries; k++)
    for (int i = 0; i < c->n_from[k]; i++) {
      const LthFiniteEntry *e = &l->entry[c->from[k][i]];
      double force = c->share[k] * (gP[k] + p * gG[k]) / c->s->grid->h[e->b];
      f[e->hi] += force;
      f[e->lo] -= force;
    }
}

/// H (entries) += w d2 of the parts, and lambda / volume times the volume's own slopes.
static void entry_tangent(const LthFiniteCell *c, double (*H)[LTH_FINITE_ENTRIES]) {
  const LthFiniteLayout *l = c->layout;
  const int d2 = l->dim * l->dim;
  double gP[LTH_FINITE_ENTRIES], g[LTH_FINITE_ENTRIES], p = c->lambda * entry_stress(c, gP, g);
  for (int i = 0; i < l->n_entries; i++)
    for (int j = 0; j < l->n_entries; j++) H[i][j] = c->lambda / c->volume * g[i] * g[j];
  for (int q = 0; q < l->n_parts; q++) {
    double F[9], T[81];
    if (!(c->weight[q] > 0)) continue;
    LthFinite m = part_material(c, q);
    lth_finite_cell_gradient(c, q, F);
    lth_finite_tangent(&m, F, p, !c->s->disc.is_exact, T);
    for (int i = 0; i < d2; i++)
      for (int j = 0; j < d2; j++) H[l->part[q][i]][l->part[q][j]] += c->weight[q] * T[i * d2 + j];
  }
}

/// Rows of entries to rows of unknowns: B (n_dofs x n_entries) = D^T H.
static void rows_to_unknowns(const LthFiniteCell *c, double (*H)[LTH_FINITE_ENTRIES],
                             double (*B)[LTH_FINITE_ENTRIES]) {
  const LthFiniteLayout *l = c->layout;
  memset(B, 0, sizeof *B * (size_t)l->n_dofs);
  for (int k = 0; k < l->n_entries; k++)
    for (int i = 0; i < c->n_from[k]; i++) {
      const LthFiniteEntry *e = &l->entry[c->from[k][i]];
      double share = c->share[k] / c->s->grid->h[e->b];
      for (int j = 0; j < l->n_entries; j++) {
        B[e->hi][j] += share * H[k][j];
        B[e->lo][j] -= share * H[k][j];
      }
    }
}

void lth_finite_cell_tangent(const LthFiniteCell *c, double *K) {
  const LthFiniteLayout *l = c->layout;
  double H[LTH_FINITE_ENTRIES][LTH_FINITE_ENTRIES], B[LTH_FINITE_DOFS][LTH_FINITE_ENTRIES];
  entry_tangent(c, H);
  rows_to_unknowns(c, H, B);
  memset(K, 0, sizeof *K * (size_t)(l->n_dofs * l->n_dofs));
  for (int k = 0; k < l->n_entries; k++)
    for (int i = 0; i < c->n_from[k]; i++) {
      const LthFiniteEntry *e = &l->entry[c->from[k][i]];
      double share = c->share[k] / c->s->grid->h[e->b];
      for (int r = 0; r < l->n_dofs; r++) {
        K[r * l->n_dofs + e->hi] += share * B[r][k];
        K[r * l->n_dofs + e->lo] -= share * B[r][k];
      }
    }
}

/// Stress along the axis that a plane body does not move along.
static double stress_across(const LthFiniteCell *c, double v, double J, double p) {
  double mu = c->material.mu;
  if (c->material.model == LTH_MATERIAL_COROTATED) return p / J;
  return mu * (1 / J + v - 1) + p; // P33 = mu + (mu (J - 1) - mu + p) J
}

void lth_finite_cell_stress(const LthFiniteCell *c, double stress[6]) {
  static const int voigt[6] = {0, 4, 8, 5, 2, 1};
  const int d = c->layout->dim;
  double F[9], P[9], G[9], T[9] = {0}, v, p = c->lambda * lth_finite_cell_volume(c);
  for (int q = 0; q < c->layout->n_parts; q++) {
    if (!(c->weight[q] > 0)) continue;
    LthFinite m = part_material(c, q);
    double share = c->weight[q] / c->volume;
    lth_finite_cell_gradient(c, q, F);
    lth_finite_stress(&m, F, &v, P, G);
    double J = d == 3 ? lth_m3_det(F) : F[0] * F[3] - F[1] * F[2];
    for (int a = 0; a < d; a++)
      for (int b = 0; b < d; b++)
        for (int k = 0; k < d; k++)
          T[3 * a + b] += share * (P[a * d + k] + p * G[a * d + k]) * F[b * d + k] / J;
    if (d == 2) T[8] += share * stress_across(c, v, J, p);
  }
  for (int i = 0; i < 6; i++) stress[i] = 0.5 * (T[voigt[i]] + T[voigt[i] % 3 * 3 + voigt[i] / 3]);
}
