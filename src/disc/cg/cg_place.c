/// Places in elements: the isoparametric map, its inverse, and functions at any point of space.
#include "disc/cg/cg_priv.h"

void lth_cg_map(const LthCgDisc *d, LitheIndex element, const double xi[3], double X[3],
                double J[9], double *phi, double *dphi) {
  const LthCgKind *kind = lth_cg_kind(d, element);
  const LitheIndex *node = lth_cg_nodes(d, element);
  const double *x0 = lth_cg_node(d, node[0]);
  lth_cg_shape(kind, xi, phi, dphi);
  memset(X, 0, 3 * sizeof *X);
  memset(J, 0, 9 * sizeof *J);
  for (int i = 1; i < kind->n; i++) { // about node 0, so that far bodies lose no digits
    double edge[3];
    lth_v3_sub(lth_cg_node(d, node[i]), x0, edge);
    lth_v3_axpy(phi[i], edge, X);
    for (int k = 0; k < 9; k++) J[k] += edge[k / 3] * dphi[3 * i + k % 3];
  }
  lth_v3_add(X, x0, X);
}

double lth_cg_space_gradients(int n, const double J[9], double *dphi) {
  double C[9], det = lth_m3_det(J);
  lth_m3_cofactor(J, C);
  for (int i = 0; i < n; i++) {
    double g[3];
    lth_m3_apply(C, dphi + 3 * i, g);
    for (int a = 0; a < 3; a++) dphi[3 * i + a] = g[a] / det;
  }
  return det;
}

/// xi += J^-1 (x - X); false where the map is singular.
static bool newton_step(const double x[3], const double X[3], const double J[9], double xi[3]) {
  double C[9], r[3], step[3], det = lth_m3_det(J);
  if (det == 0) return false;
  lth_v3_sub(x, X, r);
  lth_m3_cofactor(J, C);
  lth_m3_apply_t(C, r, step); // J^-1 = C^T / det
  lth_v3_axpy(1 / det, step, xi);
  return isfinite(xi[0]) && isfinite(xi[1]) && isfinite(xi[2]);
}

/// Reference place of x, within the reference element. Newton's method; its steps are cut back to the
/// neighbourhood of the element, where the map is known to be good.
static void locate(const LthCgDisc *d, LitheIndex element, const double x[3], double xi[3]) {
  const LthCgKind *kind = lth_cg_kind(d, element);
  const LthCgClass *class = &d->classes[d->class_of[element]];
  lth_v3_copy(kind->center, xi);
  if (class->affine) {
    double r[3], step[3];
    lth_v3_sub(x, lth_cg_node(d, lth_cg_nodes(d, element)[0]), r);
    lth_v3_sub(r, class->origin, r);
    lth_m3_apply(class->inverse, r, step);
    lth_v3_add(kind->center, step, xi);
    lth_cg_clamp(kind, xi);
    return;
  }
  for (int it = 0; it < 30; it++) {
    double X[3], J[9], phi[LTH_CG_MAX], dphi[3 * LTH_CG_MAX], old[3];
    lth_v3_copy(xi, old);
    lth_cg_map(d, element, xi, X, J, phi, dphi);
    if (!newton_step(x, X, J, xi)) {
      lth_v3_copy(kind->center, xi);
      break;
    }
    lth_cg_clamp(kind, xi);
    if (lth_v3_distance(old, xi) < 1e-14) break;
  }
}

void lth_cg_eval_local(const LthCgDisc *d, LitheIndex element, const double x[3], double *phi,
                       double *dphi) {
  int n = lth_cg_kind(d, element)->n;
  double xi[3], X[3], J[9], r[3];
  locate(d, element, x, xi);
  lth_cg_map(d, element, xi, X, J, phi, dphi);
  lth_cg_space_gradients(n, J, dphi);
  lth_v3_sub(x, X, r);
  for (int i = 0; i < n; i++) phi[i] += lth_v3_dot(dphi + 3 * i, r);
}

int lth_cg_eval(const LthDisc *disc, LitheIndex cell, const double x[3], LitheIndex *func,
                double *phi) {
  const LthCgDisc *d = lth_cg_of(disc);
  LitheIndex e = lth_cg_element(d, cell);
  const uint8_t *order = d->order + d->elements->element_off[e];
  double value[LTH_CG_MAX], dphi[3 * LTH_CG_MAX];
  int n = lth_cg_kind(d, e)->n;
  lth_cg_eval_local(d, e, x, value, dphi);
  for (int k = 0; k < n; k++) {
    func[k] = lth_cg_nodes(d, e)[order[k]];
    phi[k] = value[order[k]];
  }
  lth_disc_spread(n, 1, phi);
  return n;
}

int lth_cg_eval_gradient(const LthDisc *disc, LitheIndex cell, const double x[3], LitheIndex *func,
                         double *dphi) {
  const LthCgDisc *d = lth_cg_of(disc);
  LitheIndex e = lth_cg_element(d, cell);
  const uint8_t *order = d->order + d->elements->element_off[e];
  double value[LTH_CG_MAX], gradient[3 * LTH_CG_MAX];
  int n = lth_cg_kind(d, e)->n;
  lth_cg_eval_local(d, e, x, value, gradient);
  for (int k = 0; k < n; k++) {
    func[k] = lth_cg_nodes(d, e)[order[k]];
    lth_v3_copy(gradient + 3 * order[k], dphi + 3 * k);
  }
  lth_disc_spread(n, 3, dphi);
  return n;
}

int lth_cg_mean_gradient(const LthDisc *disc, LitheIndex cell, LitheIndex *func, double *dphi) {
  const LthCgDisc *d = lth_cg_of(disc);
  LitheIndex e = lth_cg_element(d, cell), class_index = d->class_of[e];
  const uint8_t *order = d->order + d->elements->element_off[e];
  LthCgTables t = lth_cg_tables(d, class_index);
  int n = lth_cg_kind(d, e)->n;
  for (int k = 0; k < n; k++) {
    func[k] = lth_cg_nodes(d, e)[order[k]];
    for (int a = 0; a < 3; a++)
      dphi[3 * k + a] = t.mean[3 * order[k] + a] / d->classes[class_index].volume;
  }
  lth_disc_spread(n, 3, dphi);
  return n;
}
