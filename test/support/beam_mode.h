/// Eigenmodes of a beam.
#pragma once

#include "beam.h"

#include <lapacke.h>

/// Eigenvector and eigenvalue number k of M^-1 K, K as the simulation's matrix after a tiny step.
static inline double mode_of(Beam *b, int k, double *mode) {
  LitheCount n = b->space->n_dofs;
  LthBlockMatrix *K = NULL;
  double *dense = calloc((size_t)(n * n), sizeof *dense), *w = calloc((size_t)n, sizeof *w);
  double *f0 = calloc((size_t)n, sizeof *f0);
  double *mass = calloc((size_t)b->space->n_funcs, sizeof *mass);
  CHECK_OK(b->ctx, lth_dg_matrix_create(b->ctx, b->op, &K));
  lth_dg_assemble(b->op, 0, K, f0);
  lth_dg_mass(b->space, b->density, mass);
  for (LitheIndex i = 0; i < K->n_rows; i++)
    for (LitheCount e = K->block_off[i]; e < K->block_off[i + 1]; e++) {
      LitheIndex j = K->block_col[e];
      LitheCount rows = K->row_off[i + 1] - K->row_off[i], cols = K->row_off[j + 1] - K->row_off[j];
      for (LitheCount a = 0; a < rows * cols; a++) {
        LitheCount r = K->row_off[i] + a / cols, c = K->row_off[j] + a % cols;
        dense[r * n + c] = K->values[K->value_off[e] + a] / sqrt(mass[r / 3] * mass[c / 3]);
      }
    }
  assert_int_equal(LAPACKE_dsyevd(LAPACK_COL_MAJOR, 'V', 'L', (int)n, dense, (int)n, w), 0);
  for (LitheCount i = 0; i < n; i++) mode[i] = dense[k * n + i] / sqrt(mass[i / 3]);
  double value = w[k];
  lth_block_matrix_destroy(b->ctx, &K);
  free(dense), free(w), free(f0), free(mass);
  return value;
}
