/// Energy and stress of finite solids. Smith, de Goes and Kim, "Stable Neo-Hookean flesh simulation", ACM Trans. Graph.
/// 37 (2018), without its logarithmic term, which makes P = 0 at F = 0; Stomakhin, Howes, Schroeder and Teran,
/// "Energetically consistent invertible elasticity", Proc. SCA 2012, for the gradient of |F - R|^2.
#include "material/finite_priv.h"

#include "base/eigen.h"
#include "base/tensor.h"
#include "material/rotation.h"

/// cos and sin of the angle of the rotation in the plane nearest to F.
static void plane_rotation(const double *F, double *R) {
  double c = F[0] + F[3], s = F[2] - F[1], r = hypot(c, s);
  c = r > 0 ? c / r : 1, s = r > 0 ? s / r : 0;
  R[0] = R[3] = c, R[1] = -s, R[2] = s;
}

void lth_finite_rotation(int dim, const double *F, double *R) {
  if (dim == 2)
    plane_rotation(F, R);
  else
    lth_rotation_nearest(F, R);
}

void lth_finite_frame(int dim, const double *F, double *U, double s[3], double *V) {
  double R[9], S[9], W[9];
  lth_finite_rotation(dim, F, R);
  for (int a = 0; a < dim; a++) // S = sym R^T F
    for (int b = 0; b <= a; b++) {
      double sum = 0;
      for (int k = 0; k < dim; k++)
        sum += R[k * dim + a] * F[k * dim + b] + R[k * dim + b] * F[k * dim + a];
      S[a * dim + b] = S[b * dim + a] = 0.5 * sum;
    }
  lth_symmetric_eigen(dim, S, s, W);
  for (int a = 0; a < dim; a++) // descending
    for (int k = 0; k < dim; k++) V[a * dim + k] = W[a * dim + dim - 1 - k];
  double largest = s[dim - 1], least = s[0];
  s[0] = largest, s[dim - 1] = least;
  for (int a = 0; a < dim; a++)
    for (int k = 0; k < dim; k++) {
      U[a * dim + k] = 0;
      for (int b = 0; b < dim; b++) U[a * dim + k] += R[a * dim + b] * V[b * dim + k];
    }
}

double lth_finite_cofactor(int dim, const double *F, double *C) {
  if (dim == 3) {
    lth_m3_cofactor(F, C);
    return lth_v3_dot(F, C);
  }
  C[0] = F[3], C[1] = -F[2], C[2] = -F[1], C[3] = F[0];
  return F[0] * F[3] - F[1] * F[2];
}

/// Columns a and b that shear e joins.
static void sheared(int e, int *a, int *b) {
  *a = (e + 1) % 3;
  *b = (e + 2) % 3;
}

static double column_product(int dim, const double *F, int a, int b) {
  double sum = 0;
  for (int k = 0; k < dim; k++) sum += F[k * dim + a] * F[k * dim + b];
  return sum;
}

/// psi of a solid with loose shears; P may be NULL.
static double fibres(const LthFinite *m, const double *F, double *P) {
  const int dim = m->dim;
  double psi = 0;
  for (int a = 0; a < dim; a++) {
    double length = sqrt(column_product(dim, F, a, a));
    psi += m->mu * (length - 1) * (length - 1);
    double pull = length > 0 ? 2 * m->mu * (1 - 1 / length) : 0;
    for (int k = 0; P && k < dim; k++) P[k * dim + a] = pull * F[k * dim + a];
  }
  for (int e = dim == 3 ? 0 : 2; e < 3; e++) {
    int a, b;
    if (m->loose >> e & 1) continue;
    sheared(e, &a, &b);
    double g = column_product(dim, F, a, b);
    psi += 0.5 * m->mu * g * g;
    for (int k = 0; P && k < dim; k++) {
      P[k * dim + a] += m->mu * g * F[k * dim + b];
      P[k * dim + b] += m->mu * g * F[k * dim + a];
    }
  }
  return psi;
}

/// v and G of a solid with loose shears.
static double fibre_volume(const LthFinite *m, const double *F, double *G) {
  const int dim = m->dim;
  const bool adds = m->model == LTH_MATERIAL_COROTATED;
  double l[3] = {1, 1, 1};
  for (int a = 0; a < dim; a++) l[a] = sqrt(column_product(dim, F, a, a));
  for (int a = 0; a < dim; a++) {
    double slope = adds ? 1 : l[(a + 1) % 3] * l[(a + 2) % 3];
    for (int k = 0; k < dim; k++) G[k * dim + a] = l[a] > 0 ? slope * F[k * dim + a] / l[a] : 0;
  }
  return adds ? l[0] + l[1] + l[2] - 3 : l[0] * l[1] * l[2] - 1;
}

/// v and G.
static double volume(const LthFinite *m, const double *F, double *G) {
  const int dim = m->dim;
  if (m->loose) return fibre_volume(m, F, G);
  if (m->model == LTH_MATERIAL_NEO_HOOKEAN) return lth_finite_cofactor(dim, F, G) - 1;
  double trace = -dim;
  lth_finite_rotation(dim, F, G);
  for (int i = 0; i < dim * dim; i++) trace += G[i] * F[i];
  return trace;
}

/// (|F|^2 - dim) / 2 - (J - 1), which vanishes with the square of the strain: from differences that vanish themselves,
/// so that small strains keep their digits.
static double distortion(int dim, const double *F) {
  if (dim == 2) return 0.5 * ((F[0] - F[3]) * (F[0] - F[3]) + (F[1] + F[2]) * (F[1] + F[2]));
  // of E = R^T F - I with eigenvalues e: sum e^2 / 2 - sum of products of two - e1 e2 e3
  double R[9], Rt[9], E[9], squares = 0, trace = 0;
  lth_finite_rotation(dim, F, R);
  lth_m3_transpose(R, Rt);
  lth_m3_mul(Rt, F, E);
  for (int i = 0; i < 3; i++) E[4 * i] -= 1, trace += E[4 * i];
  for (int i = 0; i < 9; i++) squares += E[i] * E[i];
  return 0.5 * squares - 0.5 * (trace * trace - squares) - lth_m3_det(E);
}

double lth_finite_energy(const LthFinite *m, const double *F, double *v) {
  const int n = m->dim * m->dim;
  double G[9], squares = 0;
  *v = volume(m, F, G);
  if (m->loose) return fibres(m, F, NULL);
  if (m->model == LTH_MATERIAL_NEO_HOOKEAN) return m->mu * (distortion(m->dim, F) + 0.5 * *v * *v);
  for (int i = 0; i < n; i++) squares += (F[i] - G[i]) * (F[i] - G[i]);
  return m->mu * squares;
}

void lth_finite_stress(const LthFinite *m, const double *F, double *v, double *P, double *G) {
  const int n = m->dim * m->dim;
  *v = volume(m, F, G);
  if (m->loose)
    fibres(m, F, P);
  else if (m->model == LTH_MATERIAL_NEO_HOOKEAN)
    for (int i = 0; i < n; i++) P[i] = m->mu * (F[i] + (*v - 1) * G[i]);
  else
    for (int i = 0; i < n; i++) P[i] = 2 * m->mu * (F[i] - G[i]);
}
