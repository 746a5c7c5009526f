/// Rows of the stiffness matrix: a momentum balance per face (equation (2) of docs/theory/staggered.md).
/// Dolny 2025, section 3.3, with the corrections named there.
#include "disc/staggered/staggered_priv.h"

#define N_OFFSETS                                                                                  \
  27           // functions within one cell along each axis; those that a row reads are 13 (2D: 7)
#define OWN 13 // the row's own

/// Rows of the three unknowns of a function: blocks [a][b] by offset, and which functions stand there.
typedef struct Rows {
  double block[N_OFFSETS][9];
  LitheIndex func[N_OFFSETS]; // -1: not read, or not there
} Rows;

static const int weight_of[3] = {1, 3, 9}; // of a step along an axis in an offset's number

/// Offsets that rows read, own included.
static int list_offsets(int dim, int offset[13]) {
  int n = 0;
  offset[n++] = OWN;
  for (int a = 0; a < dim; a++)
    for (int sign = -1; sign <= 1; sign += 2) {
      offset[n++] = OWN + sign * weight_of[a];
      int b =
          (a + 1) % dim; // pairs (0, 1), (1, 2), (2, 0); in 2D the second would repeat the first
      if (dim == 3 || a == 0) offset[n++] = OWN + sign * (weight_of[a] - weight_of[b]);
    }
  return n;
}

static void find_neighbors(const LthStaggered *s, const LitheCount *slot, const int stride[3],
                           LitheIndex func[N_OFFSETS]) {
  int offset[13], n = list_offsets(s->dim, offset);
  for (int i = 0; i < N_OFFSETS; i++) func[i] = -1;
  for (int i = 0; i < n; i++) {
    int k = offset[i], at = (k % 3 - 1) * stride[0] + (k / 3 % 3 - 1) * stride[1];
    if (s->dim == 3) at += (k / 9 - 1) * stride[2];
    if (slot[at] >= 0) func[k] = s->func[slot[at]];
  }
}

/// Columns of a row in ascending order; returns how many.
static int sort_columns(const LitheIndex func[N_OFFSETS], LitheIndex *col, int *offset) {
  int n = 0;
  for (int k = 0; k < N_OFFSETS; k++) {
    if (func[k] < 0) continue;
    int i = n++;
    for (; i > 0 && col[i - 1] > func[k]; i--) {
      col[i] = col[i - 1];
      offset[i] = offset[i - 1];
    }
    col[i] = func[k];
    offset[i] = k;
  }
  return n;
}

/// sigma_aa of the cell at offset `at`, times c, into row a.
static void add_normal(const LthStaggered *s, LitheCount cell, int at, int a, double c,
                       Rows *rows) {
  if (!lth_level_is_live(&s->level, cell)) return;
  for (int b = 0; b < s->dim; b++) {
    const LitheCount own = lth_level_at(&s->level, cell);
    double modulus = s->level.lambda[own] + (a == b ? 2 * s->level.mu[own] : 0);
    double value = c * modulus / s->grid->h[b];
    rows->block[at + weight_of[b]][3 * a + b] += value;
    rows->block[at][3 * a + b] -= value;
  }
}

/// tau_ab of the edge at offset `at`, times c, into row a.
static void add_shear(const LthStaggered *s, LitheCount edge, int at, int a, int b, double c,
                      Rows *rows) {
  double shear = lth_level_value(&s->level, s->level.shear[3 - a - b], edge);
  if (!(shear > 0)) return;
  double along = c * shear / s->grid->h[b], across = c * shear / s->grid->h[a];
  rows->block[at][3 * a + a] += along;
  rows->block[at - weight_of[b]][3 * a + a] -= along;
  rows->block[at][3 * a + b] += across;
  rows->block[at - weight_of[a]][3 * a + b] -= across;
}

static void compute_rows(const LthStaggered *s, const LitheCount *slot, const int stride[3],
                         Rows *rows) {
  const double *h = s->grid->h, volume = lth_sparse_grid_cell_volume(s->grid);
  memset(rows->block, 0, sizeof rows->block);
  for (int a = 0; a < s->dim; a++) {
    if (s->level.state[a][*slot] == LTH_UNKNOWN_DEAD) continue;
    add_normal(s, slot[-stride[a]], OWN - weight_of[a], a, volume / h[a], rows);
    add_normal(s, slot[0], OWN, a, -volume / h[a], rows);
    for (int b = 0; b < s->dim; b++) {
      if (b == a) continue;
      add_shear(s, slot[0], OWN, a, b, volume / h[b], rows);
      add_shear(s, slot[stride[b]], OWN + weight_of[b], a, b, -volume / h[b], rows);
    }
  }
}

/// Blocks of a function's rows in the matrix, in the order of the pattern; those that rollers alone join are zero so far.
static void store_rows(const Rows *rows, LitheIndex row, LthBlockMatrix *K) {
  LitheIndex col[N_OFFSETS];
  int offset[N_OFFSETS], n = sort_columns(rows->func, col, offset), i = 0;
  for (LitheCount e = K->block_off[row]; e < K->block_off[row + 1]; e++) {
    bool is_own = i < n && K->block_col[e] == col[i];
    double *block = K->values + K->value_off[e];
    if (is_own)
      memcpy(block, rows->block[offset[i++]], sizeof rows->block[0]);
    else
      memset(block, 0, sizeof rows->block[0]);
  }
}

typedef struct Pattern {
  LitheCount *row_off, *block_off;
  LitheIndex *col; // NULL: count only
} Pattern;

/// Two ascending lists as one, in `all` where that is not NULL; returns its length.
static LitheCount unite(const LitheIndex *a, LitheCount n, const LitheIndex *b, LitheCount m,
                        LitheIndex *all) {
  LitheCount count = 0;
  for (LitheCount i = 0, j = 0; i < n || j < m; count++) {
    bool of_a = j == m || (i < n && a[i] <= b[j]), of_b = i == n || (j < m && b[j] <= a[i]);
    if (all) all[count] = of_a ? a[i] : b[j];
    i += of_a;
    j += of_b;
  }
  return count;
}

static void visit_pattern(const LthStaggered *s, LitheIndex row, const LitheCount *slot,
                          const int stride[3], void *self) {
  Pattern *p = self;
  LitheIndex func[N_OFFSETS], col[N_OFFSETS];
  int offset[N_OFFSETS];
  find_neighbors(s, slot, stride, func);
  const LitheIndex *near;
  LitheCount n_near = lth_rollers_near(s, row, &near);
  int n = sort_columns(func, col, offset);
  if (p->col)
    unite(col, n, near, n_near, p->col + p->block_off[row]);
  else
    p->block_off[row + 1] = unite(col, n, near, n_near, NULL);
}

LitheStatus lth_staggered_matrix_create(LitheCtx *ctx, const LthDisc *disc, LthBlockMatrix **K) {
  LitheStatus status = LITHE_OK;
  LthStaggered *s = lth_staggered_of(disc);
  Pattern p = {0};
  if (!s->f0) LTH_NEW(ctx, s->f0, disc->n_dofs);
  LTH_NEW_OR(done, ctx, p.row_off, (LitheCount)disc->n_rows + 1);
  LTH_NEW_OR(done, ctx, p.block_off, (LitheCount)disc->n_rows + 1);
  lth_staggered_visit(s, visit_pattern, &p);
  for (LitheIndex i = 0; i < disc->n_rows; i++) {
    p.row_off[i + 1] = 3 * (LitheCount)(i + 1);
    p.block_off[i + 1] += p.block_off[i];
  }
  LTH_NEW_OR(done, ctx, p.col, p.block_off[disc->n_rows]);
  lth_staggered_visit(s, visit_pattern, &p);
  status = lth_block_matrix_create(ctx, disc->n_rows, p.row_off, p.block_off, p.col, K);
done:
  lth_free(ctx, p.row_off);
  lth_free(ctx, p.block_off);
  lth_free(ctx, p.col);
  return status;
}

static void visit_matrix(const LthStaggered *s, LitheIndex row, const LitheCount *slot,
                         const int stride[3], void *self) {
  Rows rows;
  find_neighbors(s, slot, stride, rows.func);
  compute_rows(s, slot, stride, &rows);
  store_rows(&rows, row, self);
}

/// K rest in another order than the matrix's: 2 mu + dim lambda over the cells on both sides.
static void visit_load(const LthStaggered *s, LitheIndex row, const LitheCount *slot,
                       const int stride[3], void *self) {
  double *f = (double *)self + 3 * (LitheCount)row, volume = lth_sparse_grid_cell_volume(s->grid);
  memset(f, 0, 3 * sizeof *f);
  for (int a = 0; a < s->dim; a++) {
    LitheCount side[2] = {slot[-stride[a]], slot[0]};
    if (s->level.state[a][*slot] == LTH_UNKNOWN_DEAD) continue;
    for (int k = 0; k < 2; k++)
      if (lth_level_is_live(&s->level, side[k]))
        f[a] += (k ? -1 : 1) * volume / s->grid->h[a] *
                (2 * s->level.mu[lth_level_at(&s->level, side[k])] +
                 s->dim * s->level.lambda[lth_level_at(&s->level, side[k])]);
  }
}

void lth_staggered_assemble(LthDisc *disc, double t, LthBlockMatrix *K, double *f0) {
  LthStaggered *s = lth_staggered_of(disc);
  lth_staggered_visit(s, visit_matrix, K);
  lth_rollers_add_matrix(s, K);
  lth_staggered_rest(disc, f0);
  lth_block_matrix_apply(K, lth_threads(s->ctx), f0,
                         s->f0); // the same sums as in K x: nothing is left at rest
  memcpy(f0, s->f0, sizeof *f0 * (size_t)disc->n_dofs);
  lth_mixed_add_force(s, -1, f0);
  lth_rollers_add_load(s, t, f0);
}

void lth_staggered_assemble_load(LthDisc *disc, double t, double *f0) {
  LthStaggered *s = lth_staggered_of(disc);
  if (s->f0)
    memcpy(f0, s->f0, sizeof *f0 * (size_t)disc->n_dofs);
  else
    lth_staggered_visit(s, visit_load, f0);
  lth_mixed_add_force(s, -1, f0);
  lth_rollers_add_load(s, t, f0);
}
