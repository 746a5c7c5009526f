/// Rows of the matrix: the elements around each node, the pattern, and the places of element blocks in it.
#include "disc/cg/cg_priv.h"

#include "base/order.h"

#include <stdlib.h>

/// Elements of every node, in ascending order.
static LitheStatus list_elements(LitheCtx *ctx, LthCgDisc *d) {
  const LthElementMesh *m = d->elements;
  LitheIndex *fill = NULL;
  LTH_NEW(ctx, d->node_off, m->n_nodes + 1);
  LTH_NEW(ctx, d->node_element, m->element_off[m->n_elements]);
  LTH_NEW(ctx, d->node_local, m->element_off[m->n_elements]);
  for (LitheIndex k = 0; k < m->element_off[m->n_elements]; k++)
    d->node_off[m->element_node[k] + 1]++;
  for (LitheIndex i = 0; i < m->n_nodes; i++) {
    if (d->node_off[i + 1] == 0)
      LITHE_FAIL(ctx, LITHE_BAD_INPUT, "node %d belongs to no element", i);
    d->node_off[i + 1] += d->node_off[i];
  }
  LTH_NEW(ctx, fill, m->n_nodes);
  for (LitheIndex e = 0; e < m->n_elements; e++)
    for (LitheIndex k = m->element_off[e]; k < m->element_off[e + 1]; k++) {
      LitheIndex node = m->element_node[k], at = d->node_off[node] + fill[node]++;
      d->node_element[at] = e;
      d->node_local[at] = (uint8_t)(k - m->element_off[e]);
    }
  lth_free(ctx, fill);
  return LITHE_OK;
}

/// Columns of a row, ascending; `seen` (n_nodes) marks those of rows before with their number.
static LitheIndex row_columns(const LthCgDisc *d, LitheIndex row, LitheIndex *seen,
                              LitheIndex *col) {
  LitheIndex n = 0;
  for (LitheIndex k = d->node_off[row]; k < d->node_off[row + 1]; k++) {
    const LitheIndex *node = lth_cg_nodes(d, d->node_element[k]);
    for (int j = 0; j < lth_cg_kind(d, d->node_element[k])->n; j++) {
      if (seen[node[j]] == row + 1) continue;
      seen[node[j]] = row + 1;
      if (col) col[n] = node[j];
      n++;
    }
  }
  if (col) qsort(col, (size_t)n, sizeof *col, lth_compare_index);
  return n;
}

static LitheStatus make_pattern(LitheCtx *ctx, LthCgDisc *d) {
  LitheStatus status = LITHE_OK;
  LitheIndex *seen = NULL, n = d->elements->n_nodes;
  LTH_NEW_OR(done, ctx, d->block_off, n + 1);
  LTH_NEW_OR(done, ctx, seen, n);
  for (LitheIndex row = 0; row < n; row++)
    d->block_off[row + 1] = d->block_off[row] + row_columns(d, row, seen, NULL);
  memset(seen, 0, sizeof *seen * (size_t)n);
  LTH_NEW_OR(done, ctx, d->block_col, d->block_off[n]);
  for (LitheIndex row = 0; row < n; row++)
    row_columns(d, row, seen, d->block_col + d->block_off[row]);
done:
  lth_free(ctx, seen);
  return status;
}

/// Place of a column in a row.
static LitheCount find_column(const LthCgDisc *d, LitheIndex row, LitheIndex col) {
  LitheCount low = d->block_off[row], high = d->block_off[row + 1];
  while (high - low > 1) {
    LitheCount middle = low + (high - low) / 2;
    if (d->block_col[middle] <= col)
      low = middle;
    else
      high = middle;
  }
  return low - d->block_off[row];
}

static LitheStatus make_slots(LitheCtx *ctx, LthCgDisc *d) {
  LitheIndex n_elements = d->elements->n_elements;
  LTH_NEW(ctx, d->slot_off, n_elements + 1);
  for (LitheIndex e = 0; e < n_elements; e++) {
    LitheCount n = lth_cg_kind(d, e)->n;
    d->slot_off[e + 1] = d->slot_off[e] + n * n;
  }
  for (LitheIndex row = 0; row < d->elements->n_nodes; row++)
    if (d->block_off[row + 1] - d->block_off[row] > UINT16_MAX)
      LITHE_FAIL(ctx, LITHE_UNSUPPORTED, "node %d: more than %d nodes share elements with it", row,
                 UINT16_MAX);
  LTH_NEW(ctx, d->slot, d->slot_off[n_elements]);
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheIndex e = 0; e < n_elements; e++) {
    const LitheIndex *node = lth_cg_nodes(d, e);
    int n = lth_cg_kind(d, e)->n;
    for (int i = 0; i < n; i++)
      for (int j = 0; j < n; j++)
        d->slot[d->slot_off[e] + i * n + j] = (uint16_t)find_column(d, node[i], node[j]);
  }
  return LITHE_OK;
}

/// Local nodes by ascending node.
static LitheStatus sort_nodes(LitheCtx *ctx, LthCgDisc *d) {
  const LthElementMesh *m = d->elements;
  LTH_NEW(ctx, d->order, m->element_off[m->n_elements]);
  for (LitheIndex e = 0; e < m->n_elements; e++) {
    uint8_t *order = d->order + m->element_off[e];
    const LitheIndex *node = lth_cg_nodes(d, e);
    for (int i = 0; i < lth_cg_kind(d, e)->n; i++) {
      int k = i;
      for (; k > 0 && node[order[k - 1]] > node[i]; k--) order[k] = order[k - 1];
      order[k] = (uint8_t)i;
    }
  }
  return LITHE_OK;
}

LitheStatus lth_cg_build_rows(LitheCtx *ctx, LthCgDisc *d) {
  LITHE_TRY(list_elements(ctx, d));
  LITHE_TRY(make_pattern(ctx, d));
  LITHE_TRY(make_slots(ctx, d));
  return sort_nodes(ctx, d);
}

static LitheStatus create_matrix(LitheCtx *ctx, const LthCgDisc *d, LthBlockMatrix **K) {
  LitheStatus status = LITHE_OK;
  LitheIndex n = d->elements->n_nodes;
  LitheCount *row_off = NULL;
  LTH_NEW_OR(done, ctx, row_off, n + 1);
  for (LitheIndex i = 0; i <= n; i++) row_off[i] = 3 * (LitheCount)i;
  status = lth_block_matrix_create(ctx, n, row_off, d->block_off, d->block_col, K);
done:
  lth_free(ctx, row_off);
  return status;
}

LitheStatus lth_cg_matrix_create(LitheCtx *ctx, const LthDisc *disc, LthBlockMatrix **K) {
  return create_matrix(ctx, lth_cg_of(disc), K);
}

LitheStatus lth_cg_pattern_create(LitheCtx *ctx, const LthElementMesh *elements,
                                  LthBlockMatrix **K) {
  LthCgDisc d = {.elements = elements};
  LitheStatus status = LITHE_OK;
  *K = NULL;
  for (LitheIndex e = 0; e < elements->n_elements; e++)
    d.kind[elements->kind[e]].n = lth_element_shape(elements->kind[e])->n_nodes;
  LITHE_TRY_OR(done, list_elements(ctx, &d));
  LITHE_TRY_OR(done, make_pattern(ctx, &d));
  LITHE_TRY_OR(done, create_matrix(ctx, &d, K));
done:
  lth_free(ctx, d.node_off);
  lth_free(ctx, d.node_element);
  lth_free(ctx, d.node_local);
  lth_free(ctx, d.block_off);
  lth_free(ctx, d.block_col);
  return status;
}
