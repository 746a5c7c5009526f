/// Second derivatives of finite solids by their eigenmodes in the frame of the principal stretches. Smith, de Goes and
/// Kim, "Analytic eigensystems for isotropic distortion energies", ACM Trans. Graph. 38 (2019).
#include "material/finite_priv.h"

#include "base/eigen.h"
#include "base/tensor.h"

#include <float.h>

/// A principal frame, and the two axes of each plane in it.
typedef struct Frame {
  int dim, n; // n = dim^2
  double U[9], V[9], s[3];
} Frame;

static int n_planes(int dim) { return dim == 3 ? 3 : 1; }

/// Plane k has the axes i, j; `other` is the stretch of the third.
static void plane_axes(const Frame *f, int k, int *i, int *j, double *other) {
  *i = f->dim == 3 ? (k + 1) % 3 : 0;
  *j = f->dim == 3 ? (k + 2) % 3 : 1;
  *other = f->dim == 3 ? f->s[k] : 1;
}

/// M = U (alpha e_i e_j^T + beta e_j e_i^T) V^T
static void pair_mode(const Frame *f, int i, int j, double alpha, double beta, double *M) {
  const int d = f->dim;
  for (int a = 0; a < d; a++)
    for (int b = 0; b < d; b++)
      M[a * d + b] =
          alpha * f->U[a * d + i] * f->V[b * d + j] + beta * f->U[a * d + j] * f->V[b * d + i];
}

/// M = U diag(c) V^T
static void stretch_mode(const Frame *f, const double *c, double *M) {
  const int d = f->dim;
  for (int a = 0; a < d; a++)
    for (int b = 0; b < d; b++) {
      M[a * d + b] = 0;
      for (int k = 0; k < d; k++) M[a * d + b] += c[k] * f->U[a * d + k] * f->V[b * d + k];
    }
}

static void add_mode(int n, double value, const double *M, double *H) {
  if (value == 0) return;
  for (int i = 0; i < n; i++)
    for (int j = 0; j < n; j++) H[i * n + j] += value * M[i] * M[j];
}

/// H += sum over planes of c t t^T, the derivative of R times c / 2 (s_i + s_j), t its twist: at least `least` each.
static void add_turning(const Frame *f, double c, double least, double *H) {
  double t[9];
  for (int k = 0; k < n_planes(f->dim); k++) {
    int i, j;
    double other;
    plane_axes(f, k, &i, &j, &other);
    // flat to a line: R is not unique, and any bound does
    double sum = fmax(f->s[i] + f->s[j], 1e-8 * f->s[0] + DBL_MIN);
    pair_mode(f, i, j, -sqrt(0.5), sqrt(0.5), t);
    add_mode(f->n, fmax(2 * c / sum, least), t, H);
  }
}

/// psi + p v = mu |F|^2 + (p - 2 mu) tr R^T F + ...
static void corotated_tangent(const LthFinite *m, const Frame *f, double p, bool definite,
                              double *H) {
  for (int i = 0; i < f->n; i++) H[i * f->n + i] = 2 * m->mu;
  add_turning(f, p - 2 * m->mu, definite ? -2 * m->mu : -INFINITY, H);
}

/// H += the part of c d2 det / dF2 + a I that twists and shears in the planes; `definite` as in the header.
static void add_plane_modes(const Frame *f, double a, double c, bool definite, double *H) {
  double M[9], least = definite ? 0 : -INFINITY;
  for (int k = 0; k < n_planes(f->dim); k++) {
    int i, j;
    double other;
    plane_axes(f, k, &i, &j, &other);
    pair_mode(f, i, j, -sqrt(0.5), sqrt(0.5), M);
    add_mode(f->n, fmax(a + c * other, least), M, H);
    pair_mode(f, i, j, sqrt(0.5), sqrt(0.5), M);
    add_mode(f->n, fmax(a - c * other, least), M, H);
  }
}

/// The part of c d2 det + a I + b cof cof^T that changes the stretches alone: a matrix of dim rows, by its own modes.
static void add_stretch_modes(const Frame *f, double a, double b, double c, bool definite,
                              double *H) {
  const int d = f->dim;
  double A[9] = {0}, g[3], value[3], mode[9], column[3], M[9];
  for (int i = 0; i < d; i++) g[i] = d == 3 ? f->s[(i + 1) % 3] * f->s[(i + 2) % 3] : f->s[1 - i];
  for (int i = 0; i < d; i++)
    for (int j = 0; j < d; j++)
      A[i * d + j] = b * g[i] * g[j] + (i == j ? a : c * (d == 3 ? f->s[3 - i - j] : 1));
  lth_symmetric_eigen(d, A, value, mode);
  for (int k = 0; k < d; k++) {
    for (int i = 0; i < d; i++) column[i] = mode[i * d + k];
    stretch_mode(f, column, M);
    add_mode(f->n, definite ? fmax(value[k], 0) : value[k], M, H);
  }
}

static void neo_hookean_tangent(const LthFinite *m, const Frame *f, double p, bool definite,
                                double *H) {
  double J = f->dim == 3 ? f->s[0] * f->s[1] * f->s[2] : f->s[0] * f->s[1];
  double c = p + m->mu * (J - 2);
  add_plane_modes(f, m->mu, c, definite, H);
  add_stretch_modes(f, m->mu, m->mu, c, definite, H);
}

/// Lengths and directions (columns of N) of the columns of F; 1 and 0 beyond dim.
static void find_fibres(int d, const double *F, double l[3], double *N) {
  for (int a = 0; a < 3; a++) {
    double square = a < d ? 0 : 1;
    for (int k = 0; k < d && a < d; k++) square += F[k * d + a] * F[k * d + a];
    l[a] = fmax(sqrt(square), 1e-8);
    for (int k = 0; k < d && a < d; k++) N[k * d + a] = F[k * d + a] / l[a];
  }
}

/// H += d2 (psi of columns + p v): with n = f / l, that of l is (I - n n^T) / l.
static void add_fibres(const LthFinite *m, const double *F, double p, double *H) {
  const int d = m->dim, n = d * d;
  const bool adds = m->model == LTH_MATERIAL_COROTATED;
  double l[3], N[9];
  find_fibres(d, F, l, N);
  for (int a = 0; a < d; a++) {
    double others = adds ? 1 : l[(a + 1) % 3] * l[(a + 2) % 3];
    double across = 2 * m->mu * (l[a] - 1) + p * others; // slope of the energy by l
    for (int b = 0; b < d; b++)
      for (int i = 0; i < d; i++)
        for (int j = 0; j < d; j++) {
          double along = N[i * d + a] * N[j * d + b];
          H[(i * d + a) * n + j * d + b] +=
              a == b ? 2 * m->mu * along + across * ((i == j) - along) / l[a]
                     : (adds ? 0 : p * l[3 - a - b] * along);
        }
  }
}

/// H += mu (g' g'^T + g g''), g = f_a . f_b
static void add_bond(const LthFinite *m, const double *F, int a, int b, double *H) {
  const int d = m->dim, n = d * d;
  double slope[9] = {0}, g = 0;
  for (int k = 0; k < d; k++) {
    g += F[k * d + a] * F[k * d + b];
    slope[k * d + a] = F[k * d + b];
    slope[k * d + b] = F[k * d + a];
  }
  add_mode(n, m->mu, slope, H);
  for (int k = 0; k < d; k++) {
    H[(k * d + a) * n + k * d + b] += m->mu * g;
    H[(k * d + b) * n + k * d + a] += m->mu * g;
  }
}

/// Replace negative eigenvalues by zero.
static void project(int n, double *H) {
  double A[81], value[9], V[81], mode[9];
  memcpy(A, H, sizeof *A * (size_t)(n * n));
  lth_symmetric_eigen(n, A, value, V);
  if (value[0] >= 0) return;
  for (int k = 0; k < n && value[k] < 0; k++) {
    for (int i = 0; i < n; i++) mode[i] = V[i * n + k];
    add_mode(n, -value[k], mode, H);
  }
}

static void loose_tangent(const LthFinite *m, const double *F, double p, bool definite, double *H) {
  add_fibres(m, F, p, H);
  for (int e = m->dim == 3 ? 0 : 2; e < 3; e++)
    if (!(m->loose >> e & 1)) add_bond(m, F, (e + 1) % 3, (e + 2) % 3, H);
  if (definite) project(m->dim * m->dim, H);
}

void lth_finite_tangent(const LthFinite *m, const double *F, double p, bool definite, double *H) {
  Frame f = {.dim = m->dim, .n = m->dim * m->dim};
  memset(H, 0, sizeof *H * (size_t)(f.n * f.n));
  if (m->loose) {
    loose_tangent(m, F, p, definite, H);
    return;
  }
  lth_finite_frame(m->dim, F, f.U, f.s, f.V);
  if (m->model == LTH_MATERIAL_COROTATED)
    corotated_tangent(m, &f, p, definite, H);
  else
    neo_hookean_tangent(m, &f, p, definite, H);
}
