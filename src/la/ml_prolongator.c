/// Smoothed prolongation of rigid motions (Vanek, Mandel and Brezina 1996; Vanek, Brezina and Mandel 2001).
#include "la/ml_priv.h"

#include <math.h>
#include <omp.h>
#include <string.h>

#define DEPENDENT 1e-9 // a motion that the others leave so small a part of is none of its own

#define SAFETY 1.05 // power steps find the spectral radius from below

// Chebyshev's roots of degree two on [0.3, 1]: the steps damp what the aggregates' edges hold and leave their
// motions smooth. One step (root 3/4) takes a quarter more iterations on sliced meshes, a third more at degree 2.
static const double root[LTH_ML_STEPS] = {0.4025126265847084, 0.8974873734152916};

static void list_members(LthLevel *fine) {
  LitheIndex n_rows = fine->A->n_rows;
  for (LitheIndex i = 0; i < n_rows; i++)
    if (fine->aggregate[i] >= 0) fine->member_off[fine->aggregate[i] + 1]++;
  for (LitheIndex k = 0; k < fine->n_aggregates; k++)
    fine->member_off[k + 1] += fine->member_off[k];
  for (LitheIndex i = 0; i < n_rows; i++)
    if (fine->aggregate[i] >= 0) fine->member[fine->member_off[fine->aggregate[i]]++] = i;
  for (LitheIndex k = fine->n_aggregates; k > 0; k--) fine->member_off[k] = fine->member_off[k - 1];
  fine->member_off[0] = 0;
}

/// Sum over an aggregate of products of two columns.
static double inner(const LthLevel *l, LitheIndex k, const double *q, int c, int d) {
  double sum = 0;
  for (LitheIndex m = l->member_off[k]; m < l->member_off[k + 1]; m++)
    for (LitheCount i = l->A->row_off[l->member[m]]; i < l->A->row_off[l->member[m] + 1]; i++)
      sum += q[LTH_ML_MODES * i + c] * q[LTH_ML_MODES * i + d];
  return sum;
}

/// Column d += factor column c; or times factor where c = d.
static void combine(const LthLevel *l, LitheIndex k, double *q, int c, double factor, int d) {
  for (LitheIndex m = l->member_off[k]; m < l->member_off[k + 1]; m++)
    for (LitheCount i = l->A->row_off[l->member[m]]; i < l->A->row_off[l->member[m] + 1]; i++)
      q[LTH_ML_MODES * i + d] = c == d ? factor * q[LTH_ML_MODES * i + c]
                                       : q[LTH_ML_MODES * i + d] + factor * q[LTH_ML_MODES * i + c];
}

/// Orthonormal columns of the aggregate's motions, at most `limit` of them, moved to the front; R (6 x 6,
/// rows of the columns kept) are the motions in these. Gram-Schmidt, twice. Returns their number.
static int orthonormalise(const LthLevel *l, LitheIndex k, int limit, double *q, double *R) {
  int n = 0;
  memset(R, 0, sizeof *R * LTH_ML_MODES * LTH_ML_MODES);
  for (int d = 0; d < LTH_ML_MODES; d++) {
    double before = sqrt(inner(l, k, q, d, d));
    for (int pass = 0; pass < 2; pass++)
      for (int c = 0; c < n; c++) {
        double part = inner(l, k, q, c, d);
        R[LTH_ML_MODES * c + d] += part;
        combine(l, k, q, c, -part, d);
      }
    double norm = sqrt(inner(l, k, q, d, d));
    bool keep = n < limit && norm > DEPENDENT * before;
    if (keep) {
      R[LTH_ML_MODES * n + d] = norm;
      combine(l, k, q, d, 1 / norm, d);
      if (n != d) {
        combine(l, k, q, n, 0, n);
        combine(l, k, q, d, 1, n);
        combine(l, k, q, d, 0, d);
      }
      n++;
    } else {
      combine(l, k, q, d, 0, d);
    }
  }
  return n;
}

static void copy_near(LthLevel *fine) {
  memcpy(fine->tentative, fine->near, sizeof *fine->near * (size_t)(LTH_ML_MODES * fine->A->n));
}

LitheStatus lth_ml_tentative_create(LitheCtx *ctx, LthLevel *fine, LitheCount *col_off) {
  LTH_NEW(ctx, fine->member_off, fine->n_aggregates + 1);
  LTH_NEW(ctx, fine->member, fine->A->n_rows);
  LTH_NEW(ctx, fine->tentative, LTH_ML_MODES * fine->A->n);
  list_members(fine);
  copy_near(fine);
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheIndex k = 0; k < fine->n_aggregates; k++) {
    double R[LTH_ML_MODES * LTH_ML_MODES];
    col_off[k + 1] = orthonormalise(fine, k, LTH_ML_MODES, fine->tentative, R);
  }
  for (LitheIndex k = 0; k < fine->n_aggregates; k++) col_off[k + 1] += col_off[k];
  return LITHE_OK;
}

void lth_ml_tentative(LthLevel *fine, int threads, const LitheCount *col_off, double *near) {
  copy_near(fine);
#pragma omp parallel for schedule(static) num_threads(threads)
  for (LitheIndex k = 0; k < fine->n_aggregates; k++) {
    double R[LTH_ML_MODES * LTH_ML_MODES];
    int n = (int)(col_off[k + 1] - col_off[k]);
    orthonormalise(fine, k, n, fine->tentative, R);
    memcpy(near + LTH_ML_MODES * col_off[k], R, sizeof *R * (size_t)(LTH_ML_MODES * n));
  }
}

/// The motions as blocks: one in every row of an aggregate.
static void copy_tentative(const LthLevel *l, int threads, LthTransfer *Q) {
#pragma omp parallel for schedule(static) num_threads(threads)
  for (LitheIndex row = 0; row < Q->n_rows; row++)
    for (LitheCount e = Q->block_off[row]; e < Q->block_off[row + 1]; e++) {
      const LitheCount n = Q->col_off[Q->block_col[e] + 1] - Q->col_off[Q->block_col[e]];
      for (LitheCount i = Q->row_off[row], at = Q->value_off[e]; i < Q->row_off[row + 1];
           i++, at += n)
        for (LitheCount c = 0; c < n; c++)
          Q->values[at + c] = (float)l->tentative[LTH_ML_MODES * i + c];
    }
}

static inline int columns(const LthTransfer *P, LitheCount e) {
  return (int)(P->col_off[P->block_col[e] + 1] - P->col_off[P->block_col[e]]);
}

/// out (m x n) = in - damping W, W (m x 8); in may be NULL for zero.
static void subtract(int m, int n, const float *in, double damping, const double *W, float *out) {
  for (int r = 0; r < m; r++)
    for (int c = 0; c < n; c++)
      out[r * n + c] = (float)((in ? in[r * n + c] : 0) - damping * W[LTH_ML_PADDED * r + c]);
}

/// One row of P - damping D^-1 A P; W has room for a padded block of every column of the row.
static void smooth_row(const LthLevel *l, LitheIndex row, const LthTransfer *in, double damping,
                       double *W, LthTransfer *out) {
  double Q[LTH_ML_ROW * LTH_ML_PADDED];
  const LthBlockMatrix *A = l->A;
  const int m = lth_ml_size(A, row);
  const LitheCount first = out->block_off[row], last = out->block_off[row + 1];
  memset(W, 0, sizeof *W * (size_t)((last - first) * m * LTH_ML_PADDED));
  for (LitheCount a = A->block_off[row]; a < A->block_off[row + 1]; a++) {
    const LitheIndex j = A->block_col[a];
    LitheCount at = first; // both lists ascend
    for (LitheCount e = in->block_off[j]; e < in->block_off[j + 1]; e++) {
      const int n = columns(in, e), rows = lth_ml_size(A, j);
      while (out->block_col[at] < in->block_col[e]) at++;
      lth_ml_pad(rows, n, in->values + in->value_off[e], Q);
      lth_ml_add_product(m, rows, A->values + A->value_off[a], rows, 1, Q,
                         W + (at - first) * m * LTH_ML_PADDED);
    }
  }
  LitheCount own = in->block_off[row];
  for (LitheCount e = first; e < last; e++) {
    while (own < in->block_off[row + 1] && in->block_col[own] < out->block_col[e]) own++;
    bool has = own < in->block_off[row + 1] && in->block_col[own] == out->block_col[e];
    memset(Q, 0, sizeof *Q * (size_t)(m * LTH_ML_PADDED));
    lth_ml_add_product(m, m, lth_block_jacobi_inverse(l->jacobi, row), m, 1,
                       W + (e - first) * m * LTH_ML_PADDED, Q);
    subtract(m, columns(out, e), has ? in->values + in->value_off[own] : NULL, damping, Q,
             out->values + out->value_off[e]);
  }
}

static void smooth(const LthLevel *l, const LthGalerkin *g, const LthTransfer *in, double damping,
                   LthTransfer *out) {
#pragma omp parallel for schedule(static) num_threads(g->threads)
  for (LitheIndex row = 0; row < l->A->n_rows; row++)
    smooth_row(l, row, in, damping,
               g->product + (LitheCount)omp_get_thread_num() * g->most * g->block, out);
}

void lth_ml_smooth_prolongator(LthLevel *l, const LthGalerkin *g) {
  const double radius = SAFETY * lth_ml_spectral_radius(l, g->threads);
  copy_tentative(l, g->threads, l->stage[0]);
  for (int k = 0; k < LTH_ML_STEPS; k++)
    smooth(l, g, l->stage[k], 1 / (root[k] * radius), l->stage[k + 1]);
}
