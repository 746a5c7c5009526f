/// Condition number of what is free of the matrix, and whether it is symmetric and positive definite.
#include "la/engine.h"
#include "step/simulation_priv.h"

#include <math.h>

/// Diagonal entry of unknown `i` of a block row.
static double *diagonal(LthBlockMatrix *A, LitheIndex row, LitheCount i) {
  LitheCount m = A->row_off[row + 1] - A->row_off[row], e = A->block_off[row];
  while (A->block_col[e] != row) e++;
  return A->values + A->value_off[e] + (m + 1) * (i - A->row_off[row]);
}

/// Give rows of the identity, which stand for held unknowns, a diagonal that free ones have: it lies between the
/// extreme eigenvalues of these, and changes neither.
static void level_held(LthBlockMatrix *A, const uint8_t *held) {
  double value = 0;
  for (LitheIndex row = 0; row < A->n_rows; row++)
    for (LitheCount i = A->row_off[row]; i < A->row_off[row + 1]; i++)
      if (!held[i]) value = fmax(value, *diagonal(A, row, i));
  for (LitheIndex row = 0; row < A->n_rows && value > 0; row++)
    for (LitheCount i = A->row_off[row]; i < A->row_off[row + 1]; i++)
      if (held[i]) *diagonal(A, row, i) = value;
}

LitheStatus lth_simulation_condition(LitheCtx *ctx, LthSimulation *s, double *condition) {
  if (s->system->held) level_held(s->A, s->system->held);
  return lth_block_matrix_condition(ctx, s->A, condition);
}

#define ASYMMETRY 1e-12 ///< of the largest entry: rounding of sums in another order
#define FACTORED 60000  ///< unknowns: beyond, a factor costs more than what it is to prove

LitheStatus lth_simulation_check_matrix(LitheCtx *ctx, const LthSimulation *s) {
  const LthEngine *engine = lth_engine_find("cholesky");
  LthFactor *factor = NULL;
  if (!s->A) return LITHE_OK;
  double asymmetry = lth_block_matrix_asymmetry(s->A);
  if (!(asymmetry <= ASYMMETRY))
    LITHE_FAIL(ctx, LITHE_BAD_INPUT, "the matrix is not symmetric: off by %g of its largest entry",
               asymmetry);
  bool is_held =
      s->v || !s->has_contact; // equilibria may be held by contact, which is no part of it
  if (!engine || !is_held || s->n > FACTORED) return LITHE_OK;
  LitheStatus status = engine->analyse(ctx, s->A, &factor);
  if (status == LITHE_OK) status = engine->factorize(ctx, factor, s->A);
  engine->destroy(ctx, &factor);
  return status;
}
