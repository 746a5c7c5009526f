/// The orthogonal basis of one cell: Cholesky of the mass matrix of scaled monomials.
/// docs/theory/integration.md, eqs. (9) to (11).
///
/// The mass matrix M of centred, bbox-scaled monomials comes from exact moments; B = L^{-1}, M = L L^T
/// gives an orthogonal basis up to rounding times cond(M). Where a cell is flat in a direction that is not
/// an axis, cond(M) is large. Then the functions are written in principal axes, where the large numbers of B
/// cancel and moments are well conditioned, and B is corrected with their Gram matrix there, once or twice (as
/// Cholesky QR is repeated; Fukaya et al. 2020, Shifted Cholesky QR). Quadrature of function values does
/// the same but took seconds for cells with hundreds of faces.
#include "disc/dg/dg_basis.h"

#include "base/eigen.h"
#include "base/tensor.h"

#include <float.h>

enum { MAX_FUNCS = LTH_DG_MAX_FUNCS, MAX_PASSES = 5, MAX_MOMENTS = 165 };

/// A pivot below this part of its diagonal has cost three digits: go to principal axes.
static const double weak_pivot = 1e-3;

/// B = L^{-1} of S = L L^T (n x n, row-major, lower half read); returns the smallest ratio of pivot to
/// diagonal, not positive where the factorisation does not exist.
static double inverse_cholesky(int n, const double *S, double *B) {
  double L[MAX_FUNCS * MAX_FUNCS], worst = 1;
  for (int i = 0; i < n; i++)
    for (int j = 0; j <= i; j++) {
      double sum = S[i * n + j];
      for (int k = 0; k < j; k++) sum -= L[i * n + k] * L[j * n + k];
      if (j < i) {
        L[i * n + j] = sum / L[j * n + j];
        continue;
      }
      double ratio = sum / S[i * n + i];
      if (!(ratio > 0 && S[i * n + i] > 0)) return 0;
      if (ratio < worst) worst = ratio;
      L[i * n + i] = sqrt(sum);
    }
  memset(B, 0, sizeof(double) * (size_t)(n * n));
  for (int i = 0; i < n; i++) {
    B[i * n + i] = 1 / L[i * n + i];
    for (int j = 0; j < i; j++) {
      double sum = 0;
      for (int k = j; k < i; k++) sum += L[i * n + k] * B[k * n + j];
      B[i * n + j] = -sum / L[i * n + i];
    }
  }
  return worst;
}

/// As inverse_cholesky(), with the diagonal raised until the factorisation exists.
static bool inverse_cholesky_shifted(int n, double *S, double *B, bool *raised) {
  double trace = 0;
  for (int i = 0; i < n; i++) trace += S[i * n + i];
  *raised = false;
  for (double shift = 16 * n * DBL_EPSILON; shift < 1e-6; shift *= 64) {
    double worst = inverse_cholesky(n, S, B);
    if (worst > n * DBL_EPSILON) return true;
    *raised = true;
    for (int i = 1; i < n; i++) S[i * n + i] += shift * trace;
  }
  return false;
}

/// B = C B for lower-triangular C and B (n x n).
static void multiply_lower(int n, const double *C, double *B) {
  for (int i = n - 1; i >= 0; i--)
    for (int j = 0; j <= i; j++) {
      double sum = 0;
      for (int k = j; k <= i; k++) sum += C[i * n + k] * B[k * n + j];
      B[i * n + j] = sum;
    }
}

/// S_qr = moment(q r) / norm for the first n monomials.
static void product_matrix(int n, const double *moment, double norm, double *S) {
  const int(*e)[3] = lth_monomial3_exponents();
  for (int q = 0; q < n; q++)
    for (int r = 0; r <= q; r++)
      S[q * n + r] = S[r * n + q] =
          moment[lth_monomial3_index(e[q][0] + e[r][0], e[q][1] + e[r][1], e[q][2] + e[r][2])] /
          norm;
}

/// A cell in its principal axes: eta = A (x - center), of about unit size in every direction.
typedef struct PrincipalFrame {
  double A[9];                     // x - center -> eta
  double X[9];                     // eta -> xi
  double N[MAX_FUNCS * MAX_FUNCS]; // mass matrix of monomials in eta
  double T[MAX_FUNCS * MAX_FUNCS]; // monomials in xi as sums of those in eta
} PrincipalFrame;

/// Axes and extents from the second moments.
static void set_axes(const LthDgSpace *s, LitheIndex cell, const double *moment,
                     PrincipalFrame *p) {
  static const int second[9] = {4, 5, 6, 5, 7, 8, 6, 8, 9};
  const double *h = s->scale + 3 * cell;
  double C[9], variance[3], V[9];
  for (int i = 0; i < 9; i++) C[i] = h[i / 3] * h[i % 3] * moment[second[i]] / moment[0];
  lth_symmetric_eigen(3, C, variance, V);
  // right-handed, so that volumes stay positive
  if (lth_m3_det(V) < 0)
    for (int i = 0; i < 3; i++) V[3 * i] = -V[3 * i];
  for (int j = 0; j < 3; j++) {
    double extent = sqrt(3 * fmax(variance[j], 1e-15 * variance[2]));
    for (int i = 0; i < 3; i++) {
      p->A[3 * j + i] = V[3 * i + j] / extent;
      p->X[3 * i + j] = V[3 * i + j] * extent / h[i];
    }
  }
}

/// Moments in eta up to degree p, triangle by triangle.
static void principal_moments(const LthDgSpace *s, LitheIndex cell, int p, const double A[9],
                              double *moment) {
  static const double zero[3] = {0, 0, 0}, one[3] = {1, 1, 1};
  static const LitheIndex triangle_off[2] = {0, 3}, triangle[3] = {0, 1, 2};
  const LthMesh *mesh = s->mesh;
  for (LitheIndex c = mesh->cell_face_off[cell]; c < mesh->cell_face_off[cell + 1]; c++) {
    LitheIndex f = mesh->cell_face[c];
    LthFaceView face = lth_mesh_face(mesh, f);
    LitheIndex corner[3];
    for (LthFan fan = lth_fan(&face); lth_fan_next(&fan, corner);) {
      double eta[9], d[3];
      for (int a = 0; a < 3; a++) {
        lth_v3_sub(face.points + 3 * (LitheCount)corner[a], s->center + 3 * cell, d);
        lth_m3_apply(A, d, eta + 3 * a);
      }
      LthFaceView view = {eta, triangle_off, triangle, 1, face.normal};
      lth_moments_add_face(p, zero, one, &view, lth_mesh_side(mesh, f, cell), moment);
    }
  }
}

/// T: m_q(xi) = (X eta)_axis m_lower(xi), degree by degree.
static void set_transfer(int n, const double X[9], double *T) {
  const int(*e)[3] = lth_monomial3_exponents();
  memset(T, 0, sizeof(double) * (size_t)(n * n));
  T[0] = 1;
  for (int q = 1; q < n; q++) {
    int axis = e[q][0] ? 0 : e[q][1] ? 1 : 2, low[3] = {e[q][0], e[q][1], e[q][2]};
    low[axis]--;
    const double *from = T + n * lth_monomial3_index(low[0], low[1], low[2]);
    for (int r = 0; r < q; r++)
      for (int j = 0; from[r] != 0 && j < 3; j++)
        T[q * n + lth_monomial3_index(e[r][0] + (j == 0), e[r][1] + (j == 1),
                                      e[r][2] + (j == 2))] += X[3 * axis + j] * from[r];
  }
}

/// G = (B T) N (B T)^T, lower half: the Gram matrix of the functions, eq. (10).
static void principal_gram(int n, const PrincipalFrame *p, const double *B, double *G) {
  double E[MAX_FUNCS * MAX_FUNCS], EN[MAX_FUNCS];
  memset(E, 0, sizeof E);
  for (int i = 0; i < n; i++)
    for (int q = 0; q <= i; q++)
      for (int r = 0; r < n; r++) E[i * n + r] += B[i * n + q] * p->T[q * n + r];
  for (int i = 0; i < n; i++) {
    memset(EN, 0, sizeof EN);
    for (int q = 0; q < n; q++)
      for (int r = 0; r < n; r++) EN[r] += E[i * n + q] * p->N[q * n + r];
    for (int j = 0; j <= i; j++) {
      double sum = 0;
      for (int r = 0; r < n; r++) sum += EN[r] * E[j * n + r];
      G[i * n + j] = sum;
    }
  }
}

static double distance_from_identity(int n, const double *G) {
  double worst = 0;
  for (int i = 0; i < n; i++)
    for (int j = 0; j <= i; j++) worst = fmax(worst, fabs(G[i * n + j] - (i == j)));
  return worst;
}

/// B such that the functions are orthogonal; false where that fails.
static bool orthogonalise(const LthDgSpace *s, LitheIndex cell, int k, const double *moment,
                          double *B) {
  int n = lth_monomials3(k);
  double S[MAX_FUNCS * MAX_FUNCS], C[MAX_FUNCS * MAX_FUNCS], principal[MAX_MOMENTS] = {0};
  PrincipalFrame frame;
  bool raised = false;
  product_matrix(n, moment, moment[0], S);
  if (inverse_cholesky(n, S, B) > weak_pivot) return true;
  if (!inverse_cholesky_shifted(n, S, B, &raised)) return false;
  set_axes(s, cell, moment, &frame);
  principal_moments(s, cell, 2 * k, frame.A, principal);
  product_matrix(n, principal, principal[0], frame.N);
  set_transfer(n, frame.X, frame.T);
  double error = 1;
  for (int pass = 0; pass < MAX_PASSES; pass++) {
    principal_gram(n, &frame, B, S);
    double last = error;
    error = distance_from_identity(n, S);
    if (error <= 16 * n * DBL_EPSILON || (pass > 0 && !raised && error >= 0.25 * last)) break;
    if (!inverse_cholesky_shifted(n, S, C, &raised)) return false;
    multiply_lower(n, C, B);
  }
  B[0] = 1;
  return error < 1e-6;
}

/// mean grad_a phi_i = sum_q B_iq alpha_a moment(alpha - 1_a) / (|K| scale_a)
static void set_mean_gradient(LthDgSpace *s, LitheIndex cell, int n, const double *moment,
                              const double *B) {
  const int(*e)[3] = lth_monomial3_exponents();
  double derivative[MAX_FUNCS][3];
  for (int q = 0; q < n; q++)
    for (int a = 0; a < 3; a++) {
      int low[3] = {e[q][0], e[q][1], e[q][2]};
      derivative[q][a] = 0;
      if (low[a]-- > 0)
        derivative[q][a] = e[q][a] * moment[lth_monomial3_index(low[0], low[1], low[2])] /
                           (moment[0] * s->scale[3 * cell + a]);
    }
  double *mean = s->mean_gradient + 3 * (LitheCount)s->func_off[cell];
  for (int i = 0; i < n; i++)
    for (int a = 0; a < 3; a++) {
      mean[3 * i + a] = 0;
      for (int q = 0; q <= i; q++) mean[3 * i + a] += B[i * n + q] * derivative[q][a];
    }
}

/// Eq. (11): the largest eigenvalue of the boundary's mass matrix over the functions of degree k - 1, which are
/// orthonormal up to |K|.
static double trace_constant(const LthDgSpace *s, LitheIndex cell, int k, int n, double volume,
                             const double *B) {
  const LthMesh *mesh = s->mesh;
  double boundary[MAX_MOMENTS] = {0};
  for (LitheIndex c = mesh->cell_face_off[cell]; c < mesh->cell_face_off[cell + 1]; c++) {
    LthFaceView face = lth_mesh_face(mesh, mesh->cell_face[c]);
    lth_moments_add_face_area(2 * (k - 1), s->center + 3 * cell, s->scale + 3 * cell, &face,
                              boundary);
  }
  int m = lth_monomials3(k - 1);
  if (m == 1) return boundary[0] / volume;
  double S[20 * 20], BS[20 * 20], A[20 * 20], values[20];
  product_matrix(m, boundary, volume, S);
  for (int i = 0; i < m; i++)
    for (int r = 0; r < m; r++) {
      BS[i * m + r] = 0;
      for (int q = 0; q <= i; q++) BS[i * m + r] += B[i * n + q] * S[q * m + r];
    }
  for (int i = 0; i < m; i++)
    for (int j = 0; j <= i; j++) {
      double sum = 0;
      for (int r = 0; r <= j; r++) sum += BS[i * m + r] * B[j * n + r];
      A[i * m + j] = A[j * m + i] = sum;
    }
  lth_symmetric_eigen(m, A, values, NULL);
  return values[m - 1];
}

bool lth_dg_basis_build(LthDgSpace *space, LitheIndex cell) {
  const LthMesh *mesh = space->mesh;
  int k = space->degree[cell], n = lth_monomials3(k);
  double moment[MAX_MOMENTS] = {0};
  double *B = space->basis[cell];
  for (LitheIndex c = mesh->cell_face_off[cell]; c < mesh->cell_face_off[cell + 1]; c++) {
    LitheIndex f = mesh->cell_face[c];
    LthFaceView face = lth_mesh_face(mesh, f);
    lth_moments_add_face(2 * k, space->center + 3 * cell, space->scale + 3 * cell, &face,
                         lth_mesh_side(mesh, f, cell), moment);
  }
  if (!(moment[0] > 0) || !orthogonalise(space, cell, k, moment, B)) return false;
  set_mean_gradient(space, cell, n, moment, B);
  space->trace_constant[cell] = trace_constant(space, cell, k, n, moment[0], B);
  return true;
}
