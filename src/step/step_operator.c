/// The operator of a step, cm M + ck K: a matrix, or what the only body does without one.
#include "step/simulation_priv.h"

static LthDisc *only_disc(const LthSimulation *s) { return s->system->bodies[0].disc; }

void lth_step_apply(const LthSimulation *s, int threads, const double *x, double *y) {
  if (s->own)
    s->own->apply(only_disc(s), threads, s->cm[0], s->ck[0], x, y);
  else
    lth_block_matrix_apply(s->A, threads, x, y);
}

void lth_step_diagonal(const LthSimulation *s, double *d) {
  const LthBlockMatrix *A = s->A;
  if (s->own) {
    s->own->diagonal(only_disc(s), s->cm[0], s->ck[0], d);
    return;
  }
  for (LitheIndex row = 0; row < A->n_rows; row++) {
    LitheCount m = A->row_off[row + 1] - A->row_off[row];
    const double *B = A->values + A->value_off[A->diagonal[row]];
    for (LitheCount i = 0; i < m; i++) d[A->row_off[row] + i] = B[i * m + i];
  }
}

LitheStatus lth_step_prepare_own(LitheCtx *ctx, LthSimulation *s) {
  return s->own->prepare(ctx, only_disc(s), s->cm[0], s->ck[0]);
}

/// The levels hear of contact.
static LitheStatus stiffen(LitheCtx *ctx, LthSimulation *s) {
  if (!s->own->stiffen) return LITHE_OK;
  if (!s->contact_on) return s->own->stiffen(ctx, only_disc(s), NULL);
  lth_step_contact_diagonal(s, s->extra);
  for (LitheCount i = 0; i < s->n; i++) s->scratch[i] = s->extra[9 * (i / 3) + 4 * (i % 3)];
  return s->own->stiffen(ctx, only_disc(s), s->scratch);
}

LitheStatus lth_step_solve_own(LitheCtx *ctx, LthSimulation *s, const LthOperator *extra,
                               double tolerance, LthSolveReport *report) {
  bool in_stage = s->rigid.H > 0;
  double reach = in_stage ? s->rigid.H : 1;
  const double *from = in_stage ? s->stage.x_hat : s->x;
  if (s->has_contact) LITHE_TRY(stiffen(ctx, s));
  if (s->own->aim) {
    for (LitheCount i = 0; i < s->n; i++)
      s->scratch[i] = from[i] - s->x_rest[i] + reach * s->driven[i];
    LITHE_TRY(s->own->aim(ctx, only_disc(s), s->scratch));
  }
  return s->own->solve(ctx, only_disc(s), extra, reach, s->rhs, s->solution, tolerance,
                       s->options.max_iterations, report);
}
