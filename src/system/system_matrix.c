/// The matrix of several bodies: theirs along the diagonal, couplings beside it.
#include "system/system_priv.h"

#include "base/order.h"

#include <math.h>
#include <omp.h>
#include <stdlib.h>
#include <string.h>

/// The matrix is the only body's own.
static bool is_single(const LthSystem *s) { return s->n_bodies == 1 && s->n_couplings == 0; }

void lth_system_parts_free(LitheCtx *ctx, LthSystem *s) {
  for (LitheIndex b = 0; s->part && b < s->n_bodies && !is_single(s); b++) {
    if (s->part[b] && s->lends) s->part[b]->values = NULL; // they are the whole matrix's
    lth_block_matrix_destroy(ctx, s->part + b);
  }
  s->lends = false;
}

/// Columns of the whole matrix, unsorted and with repetitions from block_off[row] on.
typedef struct Columns {
  LitheCount *row_off, *block_off, *fill;
  LitheIndex *col;
} Columns;

static void count_columns(const LthSystem *s, Columns *c) {
  for (LitheIndex b = 0; b < s->n_bodies; b++) {
    const LthBlockMatrix *part = s->part[b];
    for (LitheIndex i = 0; i < part->n_rows; i++) {
      LitheIndex row = s->row_first[b] + i;
      c->row_off[row + 1] = s->dof_first[b] + part->row_off[i + 1];
      c->block_off[row + 1] += part->block_off[i + 1] - part->block_off[i];
    }
  }
  for (LitheIndex k = 0; k < s->n_couplings; k++)
    for (LitheCount p = 0; p < 2 * (LitheCount)s->couplings[k].n_pairs; p++)
      c->block_off[s->couplings[k].pairs[p] + 1]++;
  for (LitheIndex row = 0; row < s->n_rows; row++) c->block_off[row + 1] += c->block_off[row];
}

static void list_columns(const LthSystem *s, Columns *c) {
  for (LitheIndex b = 0; b < s->n_bodies; b++) {
    const LthBlockMatrix *part = s->part[b];
    for (LitheIndex i = 0; i < part->n_rows; i++)
      for (LitheCount e = part->block_off[i]; e < part->block_off[i + 1]; e++)
        c->col[c->fill[s->row_first[b] + i]++] = s->row_first[b] + part->block_col[e];
  }
  for (LitheIndex k = 0; k < s->n_couplings; k++)
    for (LitheCount p = 0; p < s->couplings[k].n_pairs; p++) {
      const LitheIndex *pair = s->couplings[k].pairs + 2 * p;
      c->col[c->fill[pair[0]]++] = pair[1];
      c->col[c->fill[pair[1]]++] = pair[0];
    }
}

/// Sort each row's columns and take repetitions out, in place.
static void tidy_columns(LitheIndex n_rows, Columns *c) {
  LitheCount kept = 0, first = 0;
  for (LitheIndex row = 0; row < n_rows; row++) {
    LitheCount last = c->block_off[row + 1];
    LitheIndex n = lth_sort_unique(c->col + first, (LitheIndex)(last - first));
    memmove(c->col + kept, c->col + first, sizeof *c->col * (size_t)n);
    kept += n;
    first = last;
    c->block_off[row + 1] = kept;
  }
}

/// Let each body's matrix write into its blocks of the whole one.
static void lend_values(LitheCtx *ctx, LthSystem *s, LthBlockMatrix *A) {
  for (LitheIndex b = 0; b < s->n_bodies; b++) {
    LthBlockMatrix *part = s->part[b];
    LitheIndex first = s->row_first[b];
    for (LitheIndex i = 0; i < part->n_rows; i++)
      for (LitheCount e = part->block_off[i]; e < part->block_off[i + 1]; e++)
        part->value_off[e] =
            A->value_off[lth_block_matrix_find(A, first + i, first + part->block_col[e])];
    lth_free(ctx, part->values);
    part->values = A->values;
  }
  s->lends = true;
}

static LitheStatus join_parts(LitheCtx *ctx, LthSystem *s, LthBlockMatrix **A) {
  LitheStatus status = LITHE_OK;
  Columns c = {0};
  LTH_NEW_OR(done, ctx, c.row_off, (LitheCount)s->n_rows + 1);
  LTH_NEW_OR(done, ctx, c.block_off, (LitheCount)s->n_rows + 1);
  LTH_NEW_OR(done, ctx, c.fill, s->n_rows);
  count_columns(s, &c);
  memcpy(c.fill, c.block_off, sizeof *c.fill * (size_t)s->n_rows);
  LTH_NEW_OR(done, ctx, c.col, c.block_off[s->n_rows]);
  list_columns(s, &c);
  tidy_columns(s->n_rows, &c);
  LITHE_TRY_OR(done, lth_block_matrix_create(ctx, s->n_rows, c.row_off, c.block_off, c.col, A));
  lend_values(ctx, s, *A);
done:
  lth_free(ctx, c.row_off);
  lth_free(ctx, c.block_off);
  lth_free(ctx, c.fill);
  lth_free(ctx, c.col);
  return status;
}

LitheStatus lth_system_matrix_create(LitheCtx *ctx, LthSystem *s, LthBlockMatrix **A) {
  *A = NULL;
  lth_system_parts_free(ctx, s);
  for (LitheIndex b = 0; b < s->n_bodies; b++)
    LITHE_TRY(s->bodies[b].disc->table->matrix_create(ctx, s->bodies[b].disc, s->part + b));
  if (!is_single(s)) return join_parts(ctx, s, A);
  *A = s->part[0];
  return LITHE_OK;
}

void lth_system_assemble(LthSystem *s, double t, LthBlockMatrix *A, double *f0) {
  if (s->n_couplings > 0)
    memset(A->values, 0, sizeof *A->values * (size_t)A->value_off[A->block_off[A->n_rows]]);
  for (LitheIndex b = 0; b < s->n_bodies; b++)
    s->bodies[b].disc->table->assemble(s->bodies[b].disc, t, s->part[b], f0 + s->dof_first[b]);
  for (LitheIndex k = 0; k < s->n_couplings; k++)
    s->couplings[k].add(s->couplings[k].self, t, A, f0);
}

static void scale_row(const LthSystem *s, const double *ck, LitheIndex row, LthBlockMatrix *A) {
  double own = ck[s->row_body[row]];
  for (LitheCount e = A->block_off[row]; e < A->block_off[row + 1]; e++) {
    double factor = fmin(own, ck[s->row_body[A->block_col[e]]]);
    for (LitheCount i = A->value_off[e]; factor != 1 && i < A->value_off[e + 1]; i++)
      A->values[i] *= factor;
  }
}

void lth_system_combine(LitheCtx *ctx, LthSystem *s, const double *cm, const double *ck,
                        LthBlockMatrix *A) {
#pragma omp parallel for schedule(static)                                                          \
    num_threads(lth_threads(ctx)) if (lth_block_matrix_is_large(A))
  for (LitheIndex row = 0; row < A->n_rows; row++) scale_row(s, ck, row, A);
  for (LitheIndex b = 0; b < s->n_bodies; b++)
    if (cm[b] != 0) s->bodies[b].disc->table->add_mass(s->bodies[b].disc, cm[b], s->part[b]);
}

/// Zero rows and columns of held unknowns in a block row, ones on the diagonal.
static void hold_row(const LthSystem *s, LitheIndex row, LthBlockMatrix *A) {
  const uint8_t *held = s->held + A->row_off[row];
  LitheCount m = A->row_off[row + 1] - A->row_off[row];
  for (LitheCount e = A->block_off[row]; e < A->block_off[row + 1]; e++) {
    LitheIndex col = A->block_col[e];
    LitheCount n = A->row_off[col + 1] - A->row_off[col];
    const uint8_t *other = s->held + A->row_off[col];
    double *B = A->values + A->value_off[e];
    if (!s->row_held[row] && !s->row_held[col]) continue;
    for (LitheCount i = 0; i < m; i++)
      for (LitheCount j = 0; j < n; j++)
        if (held[i] || other[j]) B[i * n + j] = row == col && i == j;
  }
}

void lth_system_hold(LitheCtx *ctx, const LthSystem *s, LthBlockMatrix *A) {
  (void)ctx;
  for (LitheIndex row = 0; s->has_held && row < A->n_rows; row++) hold_row(s, row, A);
}
