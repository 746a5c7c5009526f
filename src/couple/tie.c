/// Gluing two bodies together: what they have in common, and its blocks in the system.
#include "base/tensor.h"
#include "couple/tie_priv.h"

LitheStatus lth_tie_matrix_list(LitheCtx *ctx, LthTieMatrix *m, LthCoupling *coupling) {
  const LthBlockMatrix *K = m->K;
  LTH_NEW(ctx, m->pairs, 2 * K->block_off[K->n_rows]);
  for (LitheIndex r = 0; r < K->n_rows; r++)
    for (LitheCount e = K->block_off[r]; e < K->block_off[r + 1]; e++) {
      LitheIndex row = m->row[r], col = m->row[K->block_col[e]];
      if (row >= col) continue;
      m->pairs[2 * m->n_pairs] = row;
      m->pairs[2 * m->n_pairs++ + 1] = col;
    }
  coupling->pairs = m->pairs;
  coupling->n_pairs = m->n_pairs;
  return LITHE_OK;
}

void lth_tie_matrix_add(const LthTieMatrix *m, LthBlockMatrix *A) {
  const LthBlockMatrix *K = m->K;
  for (LitheIndex r = 0; r < K->n_rows; r++)
    for (LitheCount e = K->block_off[r]; e < K->block_off[r + 1]; e++) {
      LitheCount at = lth_block_matrix_find(A, m->row[r], m->row[K->block_col[e]]);
      double *to = A->values + A->value_off[at];
      const double *from = K->values + K->value_off[e];
      for (LitheCount i = 0; i < K->value_off[e + 1] - K->value_off[e]; i++) to[i] += from[i];
    }
}

void lth_tie_matrix_free(LitheCtx *ctx, LthTieMatrix *m) {
  lth_block_matrix_destroy(ctx, &m->K);
  lth_free(ctx, m->row);
  lth_free(ctx, m->dof);
  lth_free(ctx, m->pairs);
  *m = (LthTieMatrix){0};
}

static LitheStatus tie_faces(LitheCtx *ctx, const LthTieDef *def, LthTie *tie) {
  LthOverlap overlap = {.patch = NULL};
  if (!def->side[0].space || !def->side[1].space) return LITHE_OK;
  LitheStatus status = lth_overlap_find(ctx, def, &overlap, tie->tied);
  if (status == LITHE_OK && overlap.pieces.n > 0)
    status = lth_tie_faces_create(ctx, def, &overlap, tie, &tie->coupling[0]);
  lth_overlap_free(ctx, &overlap);
  return status;
}

static LitheStatus create(LitheCtx *ctx, const LthTieDef *def, LthTie *tie) {
  double gap = 0, reach = 0;
  for (int s = 0; s < 2; s++) {
    tie->side[s] = def->side[s];
    LTH_NEW(ctx, tie->tied[s], def->side[s].patches->n);
  }
  bool is_empty = def->side[0].patches->n == 0 || def->side[1].patches->n == 0;
  if (is_empty && def->may_be_empty) return LITHE_OK;
  LITHE_TRY(tie_faces(ctx, def, tie));
  LITHE_TRY(lth_tie_springs_create(ctx, def, tie, &tie->coupling[1], &gap, &reach));
  if (!tie->coupling[0].self && !tie->coupling[1].self && !def->may_be_empty)
    LITHE_FAIL(ctx, LITHE_BAD_INPUT,
               "%s: %s and %s have nothing to tie: their surfaces are %.3g m apart where they are "
               "nearest, and only surfaces that face each other within %.3g m (a quarter of a "
               "cell) are tied; move the bodies together or widen `where`",
               def->place, def->side[0].name, def->side[1].name, gap, reach);
  return LITHE_OK;
}

LitheStatus lth_tie_create(LitheCtx *ctx, const LthTieDef *def, LthTie **tie) {
  LthTie *t = NULL;
  *tie = NULL;
  LTH_NEW(ctx, t, 1);
  LitheStatus status = create(ctx, def, t);
  if (status != LITHE_OK) {
    lth_tie_destroy(ctx, &t);
    return status;
  }
  if (!t->coupling[0].self) { // the springs alone
    t->coupling[0] = t->coupling[1];
    t->coupling[1] = (LthCoupling){0};
  }
  t->n_couplings = t->coupling[1].self ? 2 : t->coupling[0].self ? 1 : 0;
  *tie = t;
  return LITHE_OK;
}

/// The pieces of a side that are in the tie.
typedef struct Tied {
  const LthTieSide *side;
  const uint8_t *tied;
} Tied;

static double tied_distance2(void *self, LitheIndex i, const double x[3], double limit) {
  const Tied *t = self;
  (void)limit;
  if (!t->tied[i]) return INFINITY;
  LthFaceView view = lth_patches_view(t->side->disc->mesh, t->side->patches, i);
  return lth_face_distance2(&view, x);
}

LitheStatus lth_tie_mark(LitheCtx *ctx, const LthTie *tie, int side, LitheIndex n,
                         const double *points, uint8_t *marked) {
  LthBvh *tree = NULL;
  if (tie->n_couplings == 0) return LITHE_OK;
  const double reach = lth_tie_reach(tie->side);
  LITHE_TRY(lth_patches_tree(ctx, tie->side[side].patches, &tree));
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheIndex i = 0; i < n; i++) {
    Tied tied = {&tie->side[side], tie->tied[side]};
    double d2 = reach * reach;
    if (lth_bvh_nearest(tree, points + 3 * (size_t)i, tied_distance2, &tied, &d2) >= 0)
      marked[i] = 1;
  }
  lth_bvh_destroy(ctx, &tree);
  return LITHE_OK;
}

void lth_tie_destroy(LitheCtx *ctx, LthTie **tie) {
  if (!*tie) return;
  LthTie *t = *tie;
  for (int i = 0; i < 2; i++) {
    if (t->coupling[i].self) t->coupling[i].destroy(ctx, t->coupling[i].self);
    lth_free(ctx, t->tied[i]);
  }
  lth_free(ctx, t);
  *tie = NULL;
}
