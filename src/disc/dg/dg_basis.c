/// The orthogonal basis of one cell: Cholesky of the mass matrix of scaled monomials.
/// docs/theory/integration.md, eqs. (9) to (11).
///
/// The mass matrix M of centred, bbox-scaled monomials comes from exact moments; B = L^{-1}, M = L L^T
/// gives an orthogonal basis up to rounding times cond(M). Where a cell is flat in a direction that is not
/// an axis, cond(M) is large. Then monomials are those of coordinates along the cell's own axes (dg_frame.c), in which a
/// flat cell is as good as a thick one. What is left of cond(M), as in a bent plate, B is corrected for with
/// the Gram matrix of its functions, once or twice (as Cholesky QR is repeated; Fukaya et al. 2020, Shifted Cholesky QR).
#include "disc/dg/dg_basis.h"
#include "disc/dg/dg_frame.h"

#include "base/eigen.h"
#include "base/tensor.h"

#include <float.h>

enum { MAX_FUNCS = LTH_DG_MAX_FUNCS, MAX_PASSES = 5, MAX_MOMENTS = 165 };

/// A pivot below this part of its diagonal has cost three digits: take the cell's own axes.
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

/// G = B N B^T, lower half: the Gram matrix of the functions, eq. (10).
static void gram(int n, const double *N, const double *B, double *G) {
  for (int i = 0; i < n; i++) {
    double BN[MAX_FUNCS] = {0};
    for (int q = 0; q <= i; q++)
      for (int r = 0; r < n; r++) BN[r] += B[i * n + q] * N[q * n + r];
    for (int j = 0; j <= i; j++) {
      double sum = 0;
      for (int r = 0; r <= j; r++) sum += BN[r] * B[j * n + r];
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

/// B such that the functions are orthogonal over a flat cell; false where that fails.
static bool orthogonalise_flat(int n, const double *moment, double *B) {
  double N[MAX_FUNCS * MAX_FUNCS], G[MAX_FUNCS * MAX_FUNCS], C[MAX_FUNCS * MAX_FUNCS];
  bool raised = false;
  product_matrix(n, moment, moment[0], N);
  memcpy(G, N, sizeof *G * (size_t)(n * n));
  if (!inverse_cholesky_shifted(n, G, B, &raised)) return false;
  double error = 1;
  for (int pass = 0; pass < MAX_PASSES; pass++) {
    gram(n, N, B, G);
    double last = error;
    error = distance_from_identity(n, G);
    if (error <= 16 * n * DBL_EPSILON || (pass > 0 && !raised && error >= 0.25 * last)) break;
    if (!inverse_cholesky_shifted(n, G, C, &raised)) return false;
    multiply_lower(n, C, B);
  }
  B[0] = 1;
  return error < 1e-6;
}

/// mean grad_b phi_i = sum_q B_iq sum_a alpha_a axes_ab moment(alpha - 1_a) / |K|
static void set_mean_gradient(LthDgSpace *s, LitheIndex cell, int n, const double *moment,
                              const double *B) {
  const int(*e)[3] = lth_monomial3_exponents();
  double derivative[MAX_FUNCS][3];
  for (int q = 0; q < n; q++) {
    double local[3] = {0, 0, 0};
    for (int a = 0; a < 3; a++) {
      int low[3] = {e[q][0], e[q][1], e[q][2]};
      if (low[a]-- > 0)
        local[a] = e[q][a] * moment[lth_monomial3_index(low[0], low[1], low[2])] / moment[0];
    }
    lth_m3_apply_t(s->axes + 9 * (LitheCount)cell, local, derivative[q]);
  }
  double *mean = s->mean_gradient + 3 * (LitheCount)s->func_off[cell];
  for (int i = 0; i < n; i++)
    for (int a = 0; a < 3; a++) {
      mean[3 * i + a] = 0;
      for (int q = 0; q <= i; q++) mean[3 * i + a] += B[i * n + q] * derivative[q][a];
    }
}

/// Eq. (11): the largest eigenvalue of the boundary's mass matrix over the functions of degree k - 1, which are
/// orthonormal up to |K|. `boundary`: moments up to degree 2 (k - 1) [m^2].
static double trace_constant(int k, int n, double volume, const double *boundary, const double *B) {
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

/// Moments along the axes of space, about the box: of the cell up to degree 2 k, of its boundary up to 2 (k - 1).
static void box_moments(const LthMesh *mesh, LitheIndex cell, int k, const double center[3],
                        const double half[3], double *volume, double *boundary) {
  for (LitheIndex c = mesh->cell_face_off[cell]; c < mesh->cell_face_off[cell + 1]; c++) {
    LitheIndex f = mesh->cell_face[c];
    LthFaceView face = lth_mesh_face(mesh, f);
    if (volume)
      lth_moments_add_face(2 * k, center, half, &face, lth_mesh_side(mesh, f, cell), volume);
    if (boundary) lth_moments_add_face_area(2 * (k - 1), center, half, &face, boundary);
  }
}

/// A frame along the box, for which Cholesky's method does; false where the cell is flat across its axes.
static bool build_in_box(LthDgSpace *s, LitheIndex cell, double *volume, double *boundary) {
  int k = s->degree[cell], n = lth_monomials3(k);
  const double *box = s->mesh->cell_box + 6 * (LitheCount)cell;
  double *center = s->center + 3 * (LitheCount)cell, *axes = s->axes + 9 * (LitheCount)cell;
  double half[3], S[MAX_FUNCS * MAX_FUNCS];
  memset(axes, 0, 9 * sizeof *axes);
  for (int a = 0; a < 3; a++) {
    half[a] = 0.5 * (box[3 + a] - box[a]);
    axes[4 * a] = 1 / half[a];
    center[a] = s->mesh->cell_centroid[3 * (LitheCount)cell + a];
  }
  if (!(half[0] > 0 && half[1] > 0 && half[2] > 0)) return false;
  box_moments(s->mesh, cell, k, center, half, volume, NULL);
  if (!(volume[0] > 0)) return false;
  product_matrix(n, volume, volume[0], S);
  if (inverse_cholesky(n, S, s->basis[cell]) <= weak_pivot) return false;
  box_moments(s->mesh, cell, k, center, half, NULL, boundary);
  return true;
}

static bool build_in_own_axes(LthDgSpace *s, LitheIndex cell, double *volume, double *boundary) {
  int k = s->degree[cell];
  double *center = s->center + 3 * (LitheCount)cell, *axes = s->axes + 9 * (LitheCount)cell;
  if (!isfinite(axes[0] + axes[4] + axes[8])) return false;
  if (!lth_dg_frame_fit(s->mesh, cell, center, axes)) return false;
  lth_dg_frame_moments(s->mesh, cell, 2 * k, center, axes, volume);
  lth_dg_frame_area_moments(s->mesh, cell, 2 * (k - 1), center, axes, boundary);
  return volume[0] > 0 && orthogonalise_flat(lth_monomials3(k), volume, s->basis[cell]);
}

bool lth_dg_basis_build(LthDgSpace *space, LitheIndex cell) {
  int k = space->degree[cell], n = lth_monomials3(k);
  double volume[MAX_MOMENTS] = {0}, boundary[MAX_MOMENTS] = {0};
  const double *B = space->basis[cell];
  if (!build_in_box(space, cell, volume, boundary) &&
      !build_in_own_axes(space, cell, volume, boundary))
    return false;
  set_mean_gradient(space, cell, n, volume, B);
  space->trace_constant[cell] = trace_constant(k, n, volume[0], boundary, B);
  return true;
}
