/// Integrals of elements, shared by those that differ by a translation (all of a box grid).
#include "disc/cg/cg_priv.h"

#include <float.h>

/// Elements back that an element is compared with: six tetrahedra fill a cell.
#define CLASS_REACH 8

/// Same kind, rule, and edges from node 0 to rounding of the coordinates themselves.
static bool same_shape(const LthCgDisc *d, LitheIndex e, LitheIndex f) {
  const LthElementMesh *m = d->elements;
  if (m->kind[e] != m->kind[f] || d->exact[e] != d->exact[f]) return false;
  if (m->reduced && m->reduced[e] != m->reduced[f]) return false;
  const LitheIndex *p = lth_cg_nodes(d, e), *q = lth_cg_nodes(d, f);
  const double *x0 = lth_cg_node(d, p[0]), *y0 = lth_cg_node(d, q[0]);
  int n = lth_cg_kind(d, e)->n;
  for (int i = 1; i < n; i++) {
    const double *x = lth_cg_node(d, p[i]), *y = lth_cg_node(d, q[i]);
    for (int a = 0; a < 3; a++) {
      double size = fmax(fmax(fabs(x[a]), fabs(y[a])), fmax(fabs(x0[a]), fabs(y0[a])));
      if (!(fabs((x[a] - x0[a]) - (y[a] - y0[a])) <= 4 * DBL_EPSILON * size)) return false;
    }
  }
  return true;
}

/// Give every element its class; new ones are compared with the latest few only.
static LitheStatus find_classes(LitheCtx *ctx, LthCgDisc *d) {
  LitheCount cap = 0, doubles = 0;
  LTH_NEW(ctx, d->class_of, d->elements->n_elements);
  for (LitheIndex e = 0; e < d->elements->n_elements; e++) {
    LitheIndex c = d->n_classes - 1, last = d->n_classes - CLASS_REACH;
    while (c >= 0 && c >= last && !same_shape(d, e, d->classes[c].element)) c--;
    if (c < 0 || c < last) {
      LTH_RESERVE(ctx, d->classes, cap, d->n_classes + 1);
      c = d->n_classes++;
      d->classes[c] = (LthCgClass){.element = e, .table = doubles};
      doubles += lth_cg_table_doubles(lth_cg_kind(d, e)->n);
    }
    d->class_of[e] = c;
  }
  LTH_NEW(ctx, d->tables, doubles);
  return LITHE_OK;
}

/// table[i][a][b][j] += w d_a phi_i d_b phi_j; the order of factors keeps it symmetric to the last bit.
static void add_stiffness(int n, double w, const double *dphi, double *table) {
  for (int i = 0; i < n; i++)
    for (int a = 0; a < 3; a++)
      for (int b = 0; b < 3; b++) {
        double *row = table + ((i * 3 + a) * 3 + b) * n, g = dphi[3 * i + a];
        for (int j = 0; j < n; j++) row[j] += w * (g * dphi[3 * j + b]);
      }
}

/// False where the map folds.
static bool integrate_stiffness(LthCgDisc *d, LthCgClass *class, const LthCgRule *rule,
                                LthCgTables *t) {
  int n = lth_cg_kind(d, class->element)->n;
  bool good = true;
  for (int q = 0; q < rule->n; q++) {
    double X[3], J[9], phi[LTH_CG_MAX], dphi[3 * LTH_CG_MAX];
    lth_cg_map(d, class->element, rule->xi[q], X, J, phi, dphi);
    double w = rule->weight[q] * lth_cg_space_gradients(n, J, dphi);
    good = good && w > 0 && isfinite(w);
    add_stiffness(n, w, dphi, t->stiffness);
    for (int i = 0; i < 3 * n; i++) t->mean[i] += w * dphi[i];
    class->volume += w;
  }
  return good;
}

/// Share of the full rule in a reduced hex8: it holds the hourglasses, which a constant gradient does not see.
#define HOURGLASS 0.05

/// Reduced hex8: the element's mean gradients (Flanagan and Belytschko 1981) and a part of the full rule.
static void average_stiffness(int n, double volume, LthCgTables *t) {
  for (int i = 0; i < n; i++)
    for (int ab = 0; ab < 9; ab++)
      for (int j = 0; j < n; j++) {
        double *G = t->stiffness + (i * 9 + ab) * n + j;
        double mean = t->mean[3 * i + ab / 3] * t->mean[3 * j + ab % 3] / volume;
        *G = (1 - HOURGLASS) * mean + HOURGLASS * *G;
      }
}

static bool integrate_mass(LthCgDisc *d, LthCgClass *class, const LthCgRule *rule, LthCgTables *t) {
  int n = lth_cg_kind(d, class->element)->n;
  bool good = true;
  for (int q = 0; q < rule->n; q++) {
    double X[3], J[9], phi[LTH_CG_MAX], dphi[3 * LTH_CG_MAX];
    lth_cg_map(d, class->element, rule->xi[q], X, J, phi, dphi);
    double w = rule->weight[q] * lth_m3_det(J);
    good = good && w > 0 && isfinite(w);
    for (int i = 0; i < n; i++)
      for (int j = 0; j < n; j++) t->mass[i * n + j] += w * (phi[i] * phi[j]);
    for (int i = 0; i < n; i++) t->load[i] += w * phi[i];
    class->volume_exact += w;
  }
  double trace = 0;
  for (int i = 0; i < n; i++) trace += t->mass[i * n + i];
  for (int i = 0; i < n; i++) t->lumped[i] = t->mass[i * n + i] * (class->volume_exact / trace);
  return good;
}

/// An affine map is inverted once: nodes lie where the gradient at the centre puts them.
static void find_affine(const LthCgDisc *d, LthCgClass *class) {
  const LthCgKind *kind = lth_cg_kind(d, class->element);
  const LitheIndex *node = lth_cg_nodes(d, class->element);
  double X[3], J[9], phi[LTH_CG_MAX], dphi[3 * LTH_CG_MAX], C[9];
  lth_cg_map(d, class->element, kind->center, X, J, phi, dphi);
  double size = 0, off = 0, far = 0;
  for (int i = 0; i < kind->n; i++) {
    const double *x = lth_cg_node(d, node[i]);
    double xi[3], place[3];
    lth_v3_sub(kind->node[i], kind->center, xi);
    lth_m3_apply(J, xi, place);
    size = fmax(size, lth_v3_norm(place));
    far = fmax(far, lth_v3_norm(x));
    lth_v3_add(place, X, place);
    off = fmax(off, lth_v3_distance(place, x));
  }
  class->affine = off <= 16 * DBL_EPSILON * (size + far);
  lth_v3_sub(X, lth_cg_node(d, node[0]), class->origin);
  lth_m3_cofactor(J, C);
  lth_m3_transpose(C, class->inverse);
  double det = lth_m3_det(J);
  for (int i = 0; i < 9; i++) class->inverse[i] /= det;
}

static bool integrate(LthCgDisc *d, LthCgClass *class) {
  LitheIndex e = class->element;
  LthElementKind kind = d->elements->kind[e];
  LthCgTables t = lth_cg_tables(d, (LitheIndex)(class - d->classes));
  LthCgRule rule;
  bool reduced = !d->exact[e] && d->elements->reduced && d->elements->reduced[e];
  if (d->exact[e])
    lth_cg_mass_rule(kind, &rule);
  else
    lth_cg_stiffness_rule(kind, reduced, &rule);
  bool good = integrate_stiffness(d, class, &rule, &t);
  if (kind == LTH_HEX8 && reduced) average_stiffness(8, class->volume, &t);
  lth_cg_mass_rule(kind, &rule);
  good = integrate_mass(d, class, &rule, &t) && good;
  find_affine(d, class);
  return good;
}

LitheStatus lth_cg_build_classes(LitheCtx *ctx, LthCgDisc *d) {
  const LthElementMesh *m = d->elements;
  LitheIndex bad = -1;
  LITHE_TRY(find_classes(ctx, d));
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx)) reduction(max : bad)
  for (LitheIndex c = 0; c < d->n_classes; c++)
    if (!integrate(d, &d->classes[c]) && d->classes[c].element > bad) bad = d->classes[c].element;
  if (bad < 0) return LITHE_OK;
  const double *x = lth_cg_node(d, lth_cg_nodes(d, bad)[0]);
  LITHE_FAIL(
      ctx, LITHE_BAD_INPUT,
      "element %lld (%s) at (%g, %g, %g) is inverted or folded: its map from the reference "
      "element has no positive volume everywhere; expected nodes in the order of its kind and "
      "mid-side nodes near the middles",
      (long long)(m->element_id ? m->element_id[bad] : bad + 1), lth_cg_kind(d, bad)->shape->name,
      x[0], x[1], x[2]);
}
