/// Matrix and forces of bodies of large deformation. Cells of one colour share no unknown and are added side by side,
/// colours one after the other: the same bits for any number of threads.
#include "disc/staggered/staggered_finite.h"

#include "base/order.h"

#include <stdlib.h>
#include <string.h>

#define CELLS_AROUND 27
#define COLUMNS_MAX (CELLS_AROUND * LTH_FINITE_NODES)

/// Functions of a cell's nodes that live, -1 for others.
static void cell_functions(const LthStaggered *s, LitheCount slot, LitheIndex *func) {
  const LthFiniteLayout *l = &lth_staggered_finite_of(s)->layout;
  for (int i = 0; i < l->n_nodes; i++) func[i] = -1;
  for (int i = 0; i < l->n_dofs; i++) {
    int node = l->node[i];
    if (func[node] >= 0) continue;
    LitheCount at = lth_sparse_grid_step(s->grid, slot, l->offset[node]);
    if (at >= 0 && s->level.state[l->component[i]][at] != LTH_UNKNOWN_DEAD)
      func[node] = s->func[at];
  }
}

/// Functions that share a cell with a row's, ascending; returns how many.
static int list_columns(const LthStaggered *s, LitheIndex row, LitheIndex *column) {
  const LthFiniteLayout *l = &lth_staggered_finite_of(s)->layout;
  LitheIndex func[LTH_FINITE_NODES];
  int n = 0, deep = s->dim == 3;
  column[n++] = row;
  for (int z = -deep; z <= deep; z++)
    for (int y = -1; y <= 1; y++)
      for (int x = -1; x <= 1; x++) {
        LitheCount slot = lth_sparse_grid_step(s->grid, s->slot[row], (int[3]){x, y, z});
        if (slot < 0 || s->cell[slot] < 0) continue;
        cell_functions(s, slot, func);
        bool touches = false;
        for (int i = 0; i < l->n_nodes; i++) touches |= func[i] == row;
        for (int i = 0; i < l->n_nodes; i++)
          if (touches && func[i] >= 0) column[n++] = func[i];
      }
  return lth_sort_unique(column, n);
}

LitheStatus lth_finite_matrix_create(LitheCtx *ctx, const LthDisc *disc, LthBlockMatrix **K) {
  const LthStaggered *s = disc->self;
  LitheStatus status = LITHE_OK;
  const LitheIndex n = disc->n_rows;
  LitheCount *row_off = NULL, *block_off = NULL;
  LitheIndex *col = NULL;
  *K = NULL;
  LTH_NEW_OR(done, ctx, row_off, (LitheCount)n + 1);
  LTH_NEW_OR(done, ctx, block_off, (LitheCount)n + 1);
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheIndex row = 0; row < n; row++) {
    LitheIndex column[COLUMNS_MAX + 1];
    block_off[row + 1] = list_columns(s, row, column);
    row_off[row + 1] = 3 * ((LitheCount)row + 1);
  }
  for (LitheIndex row = 0; row < n; row++) block_off[row + 1] += block_off[row];
  LTH_NEW_OR(done, ctx, col, block_off[n]);
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheIndex row = 0; row < n; row++) {
    LitheIndex column[COLUMNS_MAX + 1];
    int count = list_columns(s, row, column);
    memcpy(col + block_off[row], column, sizeof *col * (size_t)count);
  }
  LITHE_TRY_OR(done, lth_block_matrix_create(ctx, n, row_off, block_off, col, K));
done:
  lth_free(ctx, row_off);
  lth_free(ctx, block_off);
  lth_free(ctx, col);
  return status;
}

/// Blocks between two nodes of a cell.
static void add_block(const LthFiniteCell *c, const double *local, int node, int other,
                      LthBlockMatrix *K) {
  const LthFiniteLayout *l = c->layout;
  LitheCount e = lth_block_matrix_find(K, c->func[node], c->func[other]);
  double *B = K->values + K->value_off[e];
  for (int i = 0; i < l->n_dofs; i++) {
    if (l->node[i] != node || !c->alive[i]) continue;
    for (int j = 0; j < l->n_dofs; j++)
      if (l->node[j] == other && c->alive[j])
        B[3 * l->component[i] + l->component[j]] += local[i * l->n_dofs + j];
  }
}

static void add_matrix(const LthFiniteCell *c, const double *local, LthBlockMatrix *K) {
  const LthFiniteLayout *l = c->layout;
  bool lives[LTH_FINITE_NODES] = {false};
  for (int i = 0; i < l->n_dofs; i++) lives[l->node[i]] |= c->alive[i];
  for (int i = 0; i < l->n_nodes; i++)
    for (int j = 0; j < l->n_nodes && lives[i]; j++)
      if (lives[j]) add_block(c, local, i, j, K);
}

/// f0 += K u - f_int
static void add_load(const LthFiniteCell *c, const double *local, double *f0) {
  const LthFiniteLayout *l = c->layout;
  double f[LTH_FINITE_DOFS];
  lth_finite_cell_force(c, f);
  for (int i = 0; i < l->n_dofs; i++) {
    double sum = -f[i];
    for (int j = 0; j < l->n_dofs; j++) sum += local[i * l->n_dofs + j] * c->u[j];
    if (c->alive[i]) f0[3 * (LitheCount)c->func[l->node[i]] + l->component[i]] += sum;
  }
}

static void clear_matrix(const LthStaggered *s, LthBlockMatrix *K) {
#pragma omp parallel for schedule(static) num_threads(lth_threads(s->ctx))
  for (LitheIndex row = 0; row < K->n_rows; row++)
    for (LitheCount e = K->block_off[row]; e < K->block_off[row + 1]; e++)
      memset(K->values + K->value_off[e], 0, 9 * sizeof *K->values);
}

/// K may be NULL.
static void add_cells(const LthStaggered *s, LthBlockMatrix *K, double *f0) {
  const LthStaggeredFinite *n = lth_staggered_finite_of(s);
  memset(f0, 0, sizeof *f0 * (size_t)s->disc.n_dofs);
  if (K) clear_matrix(s, K);
  for (int color = 0; color < n->n_colors; color++) {
#pragma omp parallel for schedule(static) num_threads(lth_threads(s->ctx))
    for (LitheIndex i = n->color_off[color]; i < n->color_off[color + 1]; i++) {
      LthFiniteCell c;
      double local[LTH_FINITE_DOFS * LTH_FINITE_DOFS];
      lth_finite_cell_read(s, n->color[i], n->x, &c);
      lth_finite_cell_tangent(&c, local);
      if (K) add_matrix(&c, local, K);
      add_load(&c, local, f0);
    }
  }
}

void lth_finite_assemble(LthDisc *disc, double t, LthBlockMatrix *K, double *f0) {
  (void)t; // no constraint of this body moves its rest state
  add_cells(disc->self, K, f0);
}

void lth_finite_assemble_load(LthDisc *disc, double t, double *f0) {
  (void)t;
  add_cells(disc->self, NULL, f0);
}
