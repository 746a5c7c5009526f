/// A stiffness by record that follows operators which share a store.
#include "disc/dg/dg_kept.h"

#include "disc/dg/dg_live_priv.h"

struct LthDgKept {
  LthDgLiveRows rows; ///< the diagonal block is the first of its row; without load
  uint32_t turn;
};

/// What is being followed.
typedef struct Follow {
  LthDgKept *kept;
  const LthDgRecords *records;
  const LthDgOperator *op;
  uint8_t *touched; ///< (n_cells)
} Follow;

LitheStatus lth_dg_kept_create(LitheCtx *ctx, LthDgKept **kept) {
  LTH_NEW(ctx, *kept, 1);
  return LITHE_OK;
}

void lth_dg_kept_destroy(LitheCtx *ctx, LthDgKept **kept) {
  if (!*kept) return;
  lth_dg_live_rows_free(ctx, &(*kept)->rows);
  lth_free(ctx, *kept);
  *kept = NULL;
}

/// What an element's diagonal block is made of is what its matrix is: faces, holds, material.
static bool is_touched(const Follow *f, LitheIndex cell) {
  const LthDgLiveRows *m = &f->kept->rows;
  LitheIndex record = f->records->cell[cell];
  if (record >= m->n_rows || m->rows[record].nb != lth_dg_funcs(f->op->space, cell)) return true;
  const LthDgLiveBlock *diagonal = m->blocks + m->rows[record].first;
  return diagonal->is_stale || diagonal->made_of != f->records->store->cells[record].made_of;
}

static LitheStatus open_row(LitheCtx *ctx, const Follow *f, LitheIndex cell) {
  LthDgLiveRows *m = &f->kept->rows;
  LitheIndex record = f->records->cell[cell], nb = lth_dg_funcs(f->op->space, cell);
  if (record < m->n_rows && m->rows[record].nb != nb)
    LITHE_TRY(lth_dg_live_rows_close(ctx, m, record)); // of another degree
  return lth_dg_live_rows_open(ctx, m, record, nb);
}

/// The pattern. Where a pair has changed both its elements are touched, for their matrices are made of its faces too.
static LitheStatus place_rows(LitheCtx *ctx, const Follow *f, const LthTopology *t) {
  LthDgLiveRows *m = &f->kept->rows;
  LitheIndex n = f->op->space->n_cells;
  for (LitheIndex i = 0; i < t->log.n_dead_cells; i++)
    LITHE_TRY(lth_dg_live_rows_close(ctx, m, t->log.dead_cells[i]));
  for (LitheIndex c = 0; c < n; c++)
    if ((f->touched[c] = is_touched(f, c))) LITHE_TRY(open_row(ctx, f, c));
  for (LitheIndex c = 0; c < n; c++)
    for (LitheIndex i = f->op->own_face_off[c]; i < f->op->own_face_off[c + 1];
         i = lth_dg_next_pair(f->op, i))
      if (f->touched[c] || f->touched[f->op->faces[i].cell[1]])
        LITHE_TRY(lth_dg_live_rows_place(ctx, m, f->records, f->op, i, f->kept->turn));
  for (LitheIndex c = 0; c < n; c++)
    if (f->touched[c]) LITHE_TRY(lth_dg_live_rows_drop(ctx, m, f->records->cell[c], f->kept->turn));
  return lth_dg_live_rows_grow(ctx, m);
}

static LitheCount write_diagonal(const Follow *f, LitheIndex cell) {
  LthDgLiveRows *m = &f->kept->rows;
  LitheIndex record = f->records->cell[cell];
  LthDgLiveBlock *diagonal = m->blocks + m->rows[record].first;
  lth_dg_assemble_diagonal(f->op, cell, m->values + diagonal->at);
  diagonal->made_of = f->records->store->cells[record].made_of;
  diagonal->is_stale = false;
  return 1;
}

static LitheCount write_pair(const Follow *f, LitheIndex i) {
  LthDgLiveRows *m = &f->kept->rows;
  const LthDgFace *face = f->op->faces + i;
  LitheIndex a = f->records->cell[face->cell[0]], b = f->records->cell[face->cell[1]];
  LthDgLiveBlock *block = lth_dg_live_rows_find(m, a, b), *mirror = lth_dg_live_rows_find(m, b, a);
  if (!block->is_stale && !mirror->is_stale) return 0;
  lth_dg_assemble_pair(f->op, i, m->values + block->at, m->values + mirror->at);
  block->is_stale = mirror->is_stale = false;
  return 2;
}

/// What is owned by one element alone is written by one thread alone.
static LitheCount write_rows(LitheCtx *ctx, const Follow *f) {
  LitheCount n = 0;
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx)) reduction(+ : n)
  for (LitheIndex c = 0; c < f->op->space->n_cells; c++) {
    if (f->touched[c]) n += write_diagonal(f, c);
    for (LitheIndex i = f->op->own_face_off[c]; i < f->op->own_face_off[c + 1];
         i = lth_dg_next_pair(f->op, i))
      if (f->touched[c] || f->touched[f->op->faces[i].cell[1]]) n += write_pair(f, i);
  }
  return n;
}

LitheStatus lth_dg_kept_follow(LitheCtx *ctx, LthDgKept *kept, const LthTopology *topology,
                               const LthDgRecords *records, const LthDgOperator *op,
                               LitheCount *n_written) {
  LITHE_ASSERT(!op->warped && !records->is_rim);
  Follow f = {kept, records, op, NULL};
  LTH_NEW(ctx, f.touched, op->space->n_cells);
  kept->turn++;
  LitheStatus status = place_rows(ctx, &f, topology);
  LitheCount n = status == LITHE_OK ? write_rows(ctx, &f) : 0;
  if (n_written) *n_written = n;
  lth_free(ctx, f.touched);
  return status;
}

void lth_dg_kept_find(const LthDgKept *kept, const LitheIndex *record, const LthBlockMatrix *K,
                      LitheCount *at) {
  for (LitheIndex row = 0; row < K->n_rows; row++)
    for (LitheCount e = K->block_off[row]; e < K->block_off[row + 1]; e++)
      at[e] = lth_dg_live_rows_find(&kept->rows, record[row], record[K->block_col[e]])->at;
}

void lth_dg_kept_copy(LitheCtx *ctx, const LthDgKept *kept, const LitheCount *at,
                      LthBlockMatrix *K) {
#pragma omp parallel for schedule(static)                                                          \
    num_threads(lth_threads(ctx)) if (lth_block_matrix_is_large(K))
  for (LitheIndex row = 0; row < K->n_rows; row++)
    for (LitheCount e = K->block_off[row]; e < K->block_off[row + 1]; e++) {
      LitheIndex col = K->block_col[e];
      LitheCount size =
          (K->row_off[row + 1] - K->row_off[row]) * (K->row_off[col + 1] - K->row_off[col]);
      memcpy(K->values + K->value_off[e], kept->rows.values + at[e], sizeof(double) * (size_t)size);
    }
}
