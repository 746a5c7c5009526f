/// A matrix by record: opening and closing rows, adding and dropping blocks, and its pattern for solvers.
#include "disc/dg/dg_live_priv.h"

#include <stdlib.h>

#define LEAST_ROOM 8 ///< blocks of a row; it doubles

void lth_dg_live_rows_free(LitheCtx *ctx, LthDgLiveRows *m) {
  lth_rooms_free(ctx, &m->block_rooms);
  lth_rooms_free(ctx, &m->value_rooms);
  lth_rooms_free(ctx, &m->func_rooms);
  lth_free(ctx, m->rows);
  lth_free(ctx, m->blocks);
  lth_free(ctx, m->values);
  lth_free(ctx, m->load);
}

LthDgLiveBlock *lth_dg_live_rows_find(const LthDgLiveRows *m, LitheIndex row, LitheIndex col) {
  if (row < 0 || row >= m->n_rows) return NULL;
  const LthDgLiveRow *r = m->rows + row;
  for (LitheIndex i = 0; i < r->n; i++)
    if (m->blocks[r->first + i].col == col) return m->blocks + r->first + i;
  return NULL;
}

/// More room for the blocks of a row; they stand in the order in which they came.
static LitheStatus move_row(LitheCtx *ctx, LthDgLiveRows *m, LitheIndex row) {
  LthDgLiveRow *r = m->rows + row;
  LitheIndex room = r->room > 0 ? 2 * r->room : LEAST_ROOM;
  LitheCount first = lth_rooms_take(&m->block_rooms, room);
  LTH_RESERVE(ctx, m->blocks, m->blocks_cap, m->block_rooms.end);
  if (r->n > 0) memcpy(m->blocks + first, m->blocks + r->first, sizeof *m->blocks * (size_t)r->n);
  if (r->room > 0) LITHE_TRY(lth_rooms_give(ctx, &m->block_rooms, r->first, r->room));
  r->first = first;
  r->room = room;
  return LITHE_OK;
}

LitheStatus lth_dg_live_rows_add(LitheCtx *ctx, LthDgLiveRows *m, LitheIndex row, LitheIndex col) {
  LthDgLiveRow *r = m->rows + row;
  LitheIndex size = 9 * r->nb * m->rows[col].nb;
  if (r->n == r->room) LITHE_TRY(move_row(ctx, m, row));
  m->blocks[r->first + r->n++] = (LthDgLiveBlock){
      .col = col, .size = size, .at = lth_rooms_take(&m->value_rooms, size), .is_stale = true};
  m->revision++;
  return LITHE_OK;
}

LitheStatus lth_dg_live_rows_fit(LitheCtx *ctx, LthDgLiveRows *m, LitheIndex row, LitheIndex col) {
  LthDgLiveBlock *block = lth_dg_live_rows_find(m, row, col);
  LitheIndex size = 9 * m->rows[row].nb * m->rows[col].nb;
  if (!block) return lth_dg_live_rows_add(ctx, m, row, col);
  if (block->size == size) return LITHE_OK;
  LITHE_TRY(lth_rooms_give(ctx, &m->value_rooms, block->at, block->size));
  block->at = lth_rooms_take(&m->value_rooms, size);
  block->size = size;
  block->is_stale = true;
  m->revision++;
  return LITHE_OK;
}

LitheStatus lth_dg_live_rows_place(LitheCtx *ctx, LthDgLiveRows *m, const LthDgRecords *records,
                                   const LthDgOperator *op, LitheIndex face, uint32_t seen) {
  const LitheIndex *cell = op->faces[face].cell;
  const LitheIndex record[2] = {records->cell[cell[0]], records->cell[cell[1]]};
  const uint64_t made_of = lth_dg_store_pair_digest(records, op, face);
  for (int side = 0; side < 2; side++) {
    LITHE_TRY(lth_dg_live_rows_fit(ctx, m, record[side], record[!side]));
    LthDgLiveBlock *block = lth_dg_live_rows_find(m, record[side], record[!side]);
    block->seen = seen;
    block->is_stale = block->is_stale || block->made_of != made_of;
    block->made_of = made_of;
  }
  return LITHE_OK;
}

LitheIndex lth_dg_next_pair(const LthDgOperator *op, LitheIndex face) {
  LitheIndex other = op->faces[face].cell[1], end = op->own_face_off[op->faces[face].cell[0] + 1];
  while (face < end && op->faces[face].cell[1] == other) face++;
  return face;
}

LitheStatus lth_dg_live_rows_open(LitheCtx *ctx, LthDgLiveRows *m, LitheIndex record,
                                  LitheIndex nb) {
  LTH_RESERVE(ctx, m->rows, m->rows_cap, (LitheCount)record + 1);
  while (m->n_rows <= record) m->rows[m->n_rows++] = (LthDgLiveRow){0};
  LthDgLiveRow *r = m->rows + record;
  if (r->nb > 0) return LITHE_OK;
  *r = (LthDgLiveRow){.nb = nb, .func = (LitheIndex)lth_rooms_take(&m->func_rooms, nb)};
  return lth_dg_live_rows_add(ctx, m, record, record);
}

LitheStatus lth_dg_live_rows_close(LitheCtx *ctx, LthDgLiveRows *m, LitheIndex record) {
  if (record >= m->n_rows || m->rows[record].nb == 0) return LITHE_OK;
  LthDgLiveRow *r = m->rows + record;
  for (LitheIndex i = 0; i < r->n; i++) {
    const LthDgLiveBlock *block = m->blocks + r->first + i;
    LITHE_TRY(lth_rooms_give(ctx, &m->value_rooms, block->at, block->size));
  }
  LITHE_TRY(lth_rooms_give(ctx, &m->block_rooms, r->first, r->room));
  LITHE_TRY(lth_rooms_give(ctx, &m->func_rooms, r->func, r->nb));
  if (m->load) memset(m->load + 3 * (size_t)r->func, 0, 3 * sizeof(double) * (size_t)r->nb);
  *r = (LthDgLiveRow){0};
  m->revision++;
  return LITHE_OK;
}

LitheStatus lth_dg_live_rows_drop(LitheCtx *ctx, LthDgLiveRows *m, LitheIndex row, uint32_t seen) {
  LthDgLiveRow *r = m->rows + row;
  LitheIndex kept = 0;
  for (LitheIndex i = 0; i < r->n; i++) {
    LthDgLiveBlock block = m->blocks[r->first + i];
    if (block.col == row || block.seen == seen)
      m->blocks[r->first + kept++] = block;
    else
      LITHE_TRY(lth_rooms_give(ctx, &m->value_rooms, block.at, block.size));
  }
  if (kept < r->n) m->revision++;
  r->n = kept;
  return LITHE_OK;
}

LitheStatus lth_dg_live_rows_grow(LitheCtx *ctx, LthDgLiveRows *m) {
  LitheCount values = m->value_rooms.end, load = 3 * m->func_rooms.end;
  // a quarter more than is asked for: the first changes move nothing
  if (values > m->values_cap) LTH_RESERVE(ctx, m->values, m->values_cap, values + values / 4);
  if (load > m->load_cap) LTH_RESERVE(ctx, m->load, m->load_cap, load + load / 4);
  return LITHE_OK;
}

// --- for solvers ---

static int compare_blocks(const void *pa, const void *pb) {
  const LthDgLiveBlock *a = pa, *b = pb;
  return a->col < b->col ? -1 : a->col > b->col;
}

LitheStatus lth_dg_live_rows_matrix(LitheCtx *ctx, const LthDgLiveRows *m,
                                    LthBlockMatrix **matrix) {
  LitheStatus status = LITHE_OK;
  LitheIndex n = 0, *row_of = NULL, *col = NULL;
  LitheCount n_blocks = 0, *row_off = NULL, *block_off = NULL, *value_off = NULL;
  *matrix = NULL;
  LTH_NEW_OR(done, ctx, row_of, m->n_rows);
  for (LitheIndex r = 0; r < m->n_rows; r++) {
    row_of[r] = n;
    n += m->rows[r].nb > 0;
    n_blocks += m->rows[r].n;
  }
  LTH_NEW_OR(done, ctx, row_off, (LitheCount)n + 1);
  LTH_NEW_OR(done, ctx, block_off, (LitheCount)n + 1);
  LTH_NEW_OR(done, ctx, value_off, n_blocks + 1);
  LTH_NEW_OR(done, ctx, col, n_blocks);
  for (LitheIndex r = 0; r < m->n_rows; r++) {
    const LthDgLiveRow *row = m->rows + r;
    if (row->nb == 0) continue;
    LitheIndex i = row_of[r];
    LitheCount e = block_off[i];
    qsort(m->blocks + row->first, (size_t)row->n, sizeof *m->blocks, compare_blocks);
    for (LitheIndex k = 0; k < row->n; k++, e++) {
      col[e] = row_of[m->blocks[row->first + k].col];
      value_off[e] = m->blocks[row->first + k].at;
    }
    block_off[i + 1] = e;
    row_off[i + 1] = row_off[i] + 3 * (LitheCount)row->nb;
  }
  value_off[n_blocks] = m->value_rooms.end;
  LITHE_TRY_OR(
      done, lth_block_matrix_lend(ctx, n, row_off, block_off, col, value_off, m->values, matrix));
done:
  lth_free(ctx, row_of);
  lth_free(ctx, row_off);
  lth_free(ctx, block_off);
  lth_free(ctx, value_off);
  lth_free(ctx, col);
  return status;
}
