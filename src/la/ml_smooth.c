/// Block Gauss-Seidel by colours: sweeps whose bits do not depend on the number of threads.
#include "la/ml_priv.h"

#include "base/clones.h"
#include "la/block_rows.h"

#include <math.h>
#include <omp.h>
#include <string.h>

#define LOWEST                                                                                     \
  0.3 // of the polynomial's interval, of which 1 is the end; see docs/theory/multigrid.md
#define POWER_STEPS 12

void lth_ml_free_colours(LitheCtx *ctx, LthColours *c) {
  lth_free(ctx, c->colour);
  lth_free(ctx, c->off);
  lth_free(ctx, c->row);
  *c = (LthColours){0};
}

/// Smallest colour that no neighbour has; `taken` (n_rows + 1) is -1 or a row that has seen a colour taken.
static int free_colour(const LthBlockMatrix *A, LitheIndex row, const int *colour,
                       LitheIndex *taken) {
  for (LitheCount e = A->block_off[row]; e < A->block_off[row + 1]; e++)
    if (colour[A->block_col[e]] >= 0) taken[colour[A->block_col[e]]] = row;
  int c = 0;
  while (taken[c] == row) c++;
  return c;
}

/// Greedy in breadth-first order: on a grid layers alternate, and two colours do.
static int colour_rows(const LthBlockMatrix *A, LitheIndex *queue, LitheIndex *taken, int *colour) {
  LitheIndex n = 0, next = 0;
  int count = 0;
  for (LitheIndex i = 0; i <= A->n_rows; i++) taken[i] = -1;
  for (LitheIndex i = 0; i < A->n_rows; i++) colour[i] = -2;
  for (LitheIndex seed = 0; seed < A->n_rows; seed++) {
    if (colour[seed] != -2) continue;
    queue[n++] = seed;
    colour[seed] = -1;
    for (; next < n; next++) {
      LitheIndex row = queue[next];
      int c = colour[row] = free_colour(A, row, colour, taken);
      if (c >= count) count = c + 1;
      for (LitheCount e = A->block_off[row]; e < A->block_off[row + 1]; e++)
        if (colour[A->block_col[e]] == -2) {
          colour[A->block_col[e]] = -1;
          queue[n++] = A->block_col[e];
        }
    }
  }
  return count;
}

LitheStatus lth_ml_colour(LitheCtx *ctx, const LthBlockMatrix *A, LthColours *c) {
  LitheStatus status = LITHE_OK;
  LitheIndex *queue = NULL, *taken = NULL;
  LTH_NEW_OR(done, ctx, c->colour, A->n_rows);
  LTH_NEW_OR(done, ctx, c->row, A->n_rows);
  LTH_NEW_OR(done, ctx, queue, A->n_rows);
  LTH_NEW_OR(done, ctx, taken, A->n_rows + 1);
  c->count = colour_rows(A, queue, taken, c->colour);
  LTH_NEW_OR(done, ctx, c->off, c->count + 1);
  for (LitheIndex i = 0; i < A->n_rows; i++) c->off[c->colour[i] + 1]++;
  for (int k = 0; k < c->count; k++) c->off[k + 1] += c->off[k];
  memcpy(taken, c->off, sizeof *taken * (size_t)c->count);
  for (LitheIndex i = 0; i < A->n_rows; i++) c->row[taken[c->colour[i]]++] = i;
done:
  lth_free(ctx, queue);
  lth_free(ctx, taken);
  return status;
}

/// As row_residual() where all blocks are 12 x 12.
LTH_CLONES
static void row_residual_12(const LthLevel *l, LitheIndex row, int low, int high, int skip,
                            const double *restrict b, const double *restrict x,
                            double *restrict y) {
  const LthBlockMatrix *A = l->A;
  const int *restrict colour = l->colours.colour;
  LthRows12 s;
  lth_rows12_zero(&s);
  for (LitheCount e = A->block_off[row]; e < A->block_off[row + 1]; e++) {
    const LitheIndex col = A->block_col[e];
    if (colour[col] < low || colour[col] >= high || colour[col] == skip) continue;
    lth_rows12_add(A->values + A->value_off[e], x + A->row_off[col], &s);
  }
  const LitheCount at = A->row_off[row];
#pragma GCC unroll 3
  for (int r = 0; r < LTH_TWELVE; r += 4) {
    LthQuad sums;
    lth_quad_sums(s.row + r, &sums);
    *(LthQuad *)(y + at + r) = (b ? LTH_QUAD(b + at + r) : (LthQuad){0}) - sums;
  }
}

/// The same for blocks of 3 x 3.
LTH_CLONES
static void row_residual_3(const LthLevel *l, LitheIndex row, int low, int high, int skip,
                           const double *restrict b, const double *restrict x, double *restrict y) {
  const LthBlockMatrix *A = l->A;
  const int *restrict colour = l->colours.colour;
  LthRows3 s = {0};
  for (LitheCount e = A->block_off[row]; e < A->block_off[row + 1]; e++) {
    const LitheIndex col = A->block_col[e];
    if (colour[col] < low || colour[col] >= high || colour[col] == skip) continue;
    lth_rows3_add(A->values + A->value_off[e], x + A->row_off[col], &s);
  }
  double sums[LTH_THREE];
  lth_rows3_sums(&s, sums);
  const LitheCount at = A->row_off[row];
  for (int r = 0; r < LTH_THREE; r++) y[at + r] = (b ? b[at + r] : 0) - sums[r];
}

#define SIX 6

/// The same for blocks of 6 x 6: two rows of a block are three lanes.
LTH_CLONES
static void row_residual_6(const LthLevel *l, LitheIndex row, int low, int high, int skip,
                           const double *restrict b, const double *restrict x, double *restrict y) {
  const LthBlockMatrix *A = l->A;
  const int *restrict colour = l->colours.colour;
  LthQuad s[9];
#pragma GCC unroll 9
  for (int r = 0; r < 9; r++) s[r] = (LthQuad){0};
  for (LitheCount e = A->block_off[row]; e < A->block_off[row + 1]; e++) {
    const LitheIndex col = A->block_col[e];
    if (colour[col] < low || colour[col] >= high || colour[col] == skip) continue;
    const double *restrict B = A->values + A->value_off[e];
    const double *xc = x + A->row_off[col];
    const LthQuad x0 = LTH_QUAD(xc), x1 = {xc[4], xc[5], xc[0], xc[1]}, x2 = LTH_QUAD(xc + 2);
#pragma GCC unroll 3
    for (int r = 0; r < 3; r++) {
      s[3 * r] += LTH_QUAD(B + 2 * SIX * r) * x0;
      s[3 * r + 1] += LTH_QUAD(B + 2 * SIX * r + 4) * x1;
      s[3 * r + 2] += LTH_QUAD(B + 2 * SIX * r + 8) * x2;
    }
  }
  const LitheCount at = A->row_off[row];
#pragma GCC unroll 3
  for (int r = 0; r < 3; r++) {
    const LthQuad *t = s + 3 * r;
    const double first = lth_quad_sum(&t[0]) + (t[1][0] + t[1][1]);
    const double second = (t[1][2] + t[1][3]) + lth_quad_sum(&t[2]);
    y[at + 2 * r] = (b ? b[at + 2 * r] : 0) - first;
    y[at + 2 * r + 1] = (b ? b[at + 2 * r + 1] : 0) - second;
  }
}

/// y = b - A x in one block row, of the columns whose colour is in [low, high) and not `skip`; b may be NULL
/// for zero. As lth_block_matrix_apply(), three rows at a time.
LTH_CLONES
static void row_residual(const LthLevel *l, LitheIndex row, int low, int high, int skip,
                         const double *restrict b, const double *restrict x, double *restrict y) {
  const LthBlockMatrix *A = l->A;
  const int *restrict colour = l->colours.colour;
  if (l->size == LTH_TWELVE) {
    row_residual_12(l, row, low, high, skip, b, x, y);
    return;
  }
  if (l->size == SIX) {
    row_residual_6(l, row, low, high, skip, b, x, y);
    return;
  }
  if (l->size == LTH_THREE) {
    row_residual_3(l, row, low, high, skip, b, x, y);
    return;
  }
  const LitheIndex m = lth_ml_size(A, row);
  for (LitheIndex r = 0; r < m; r += 3) {
    const LitheIndex r1 = r + 1 < m ? r + 1 : r, r2 = r + 2 < m ? r + 2 : r;
    LthQuad s0 = {0}, s1 = {0}, s2 = {0};
    double t0 = 0, t1 = 0, t2 = 0;
    for (LitheCount e = A->block_off[row]; e < A->block_off[row + 1]; e++) {
      const LitheIndex col = A->block_col[e];
      if (colour[col] < low || colour[col] >= high || colour[col] == skip) continue;
      const LitheIndex n = lth_ml_size(A, col);
      const double *restrict B = A->values + A->value_off[e];
      const double *b0 = B + (size_t)r * (size_t)n, *b1 = B + (size_t)r1 * (size_t)n,
                   *b2 = B + (size_t)r2 * (size_t)n, *xc = x + A->row_off[col];
      LitheIndex c = 0;
      for (; c + 4 <= n; c += 4) {
        const LthQuad v = LTH_QUAD(xc + c);
        s0 += LTH_QUAD(b0 + c) * v;
        s1 += LTH_QUAD(b1 + c) * v;
        s2 += LTH_QUAD(b2 + c) * v;
      }
      for (; c < n; c++) {
        t0 += b0[c] * xc[c];
        t1 += b1[c] * xc[c];
        t2 += b2[c] * xc[c];
      }
    }
    const LitheCount at = A->row_off[row] + r;
    y[at] = (b ? b[at] : 0) - (lth_quad_sum(&s0) + t0);
    if (r + 1 < m) y[at + 1] = (b ? b[at + 1] : 0) - (lth_quad_sum(&s1) + t1);
    if (r + 2 < m) y[at + 2] = (b ? b[at + 2] : 0) - (lth_quad_sum(&s2) + t2);
  }
}

// In the sweep from zero later colours count as zero, so a row has no residual until they change: both
// together cost one product with A.
void lth_ml_smooth_down(const LthLevel *l, int threads, const double *b, double *x, double *r) {
  const LthBlockMatrix *A = l->A;
  const LthColours *c = &l->colours;
#pragma omp parallel num_threads(threads) if (lth_block_matrix_is_large(A))
  {
    for (int k = 0; k < c->count; k++)
#pragma omp for schedule(static)
      for (LitheIndex i = c->off[k]; i < c->off[k + 1]; i++) {
        row_residual(l, c->row[i], 0, k, -1, b, x, r);
        lth_block_jacobi_apply_row(l->jacobi, c->row[i], r, x);
      }
#pragma omp for schedule(static)
    for (LitheIndex i = 0; i < A->n_rows; i++)
      row_residual(l, i, c->colour[i] + 1, c->count, -1, NULL, x, r);
  }
}

void lth_ml_smooth_up(const LthLevel *l, int threads, const double *b, double *x) {
  const LthBlockMatrix *A = l->A;
  const LthColours *c = &l->colours;
#pragma omp parallel num_threads(threads) if (lth_block_matrix_is_large(A))
  for (int k = c->count - 1; k >= 0; k--)
#pragma omp for schedule(static)
    for (LitheIndex i = c->off[k]; i < c->off[k + 1]; i++) {
      row_residual(l, c->row[i], 0, c->count, k, b, x, l->r);
      lth_block_jacobi_apply_row(l->jacobi, c->row[i], l->r, x);
    }
}

// Symmetric Gauss-Seidel is M = (D + L) D^-1 (D + U), and A <= M. In the variables y = (D + U) x and
// h = (D + L)^-1 r one step needs L once and U once (Eisenstat 1981); q = D h comes without a product.

/// q = D (D + L)^-1 r, h = D^-1 q.
static void forward(const LthLevel *l, const double *r, double *q, double *h) {
  const LthColours *c = &l->colours;
  for (int k = 0; k < c->count; k++)
#pragma omp for schedule(static)
    for (LitheIndex i = c->off[k]; i < c->off[k + 1]; i++) {
      row_residual(l, c->row[i], 0, k, -1, r, h, q);
      lth_block_jacobi_apply_row(l->jacobi, c->row[i], q, h);
    }
}

/// x += (D + U)^-1 v and, where the residual is wanted after that, h and q follow.
static void step(const LthLevel *l, bool follow, double *x) {
  const LthBlockMatrix *A = l->A;
  const LthColours *c = &l->colours;
  for (int k = c->count - 1; k >= 0; k--)
#pragma omp for schedule(static)
    for (LitheIndex i = c->off[k]; i < c->off[k + 1]; i++) {
      const LitheIndex row = c->row[i];
      row_residual(l, row, k + 1, c->count, -1, l->v, l->t, l->s);
      lth_block_jacobi_apply_row(l->jacobi, row, l->s, l->t);
      for (LitheCount d = A->row_off[row]; d < A->row_off[row + 1]; d++) {
        x[d] += l->t[d];
        l->s[d] = l->v[d] - l->s[d]; // U t
        l->h[d] -= l->t[d];
        l->q[d] += l->s[d] - l->v[d];
      }
    }
  if (!follow) return;
  // s = (D + L)^-1 U t, over U t; the argument of D^-1 goes through e
  for (int k = 0; k < c->count; k++)
#pragma omp for schedule(static)
    for (LitheIndex i = c->off[k]; i < c->off[k + 1]; i++) {
      const LitheIndex row = c->row[i];
      row_residual(l, row, 0, k, -1, l->s, l->s, l->e);
      lth_block_jacobi_apply_row(l->jacobi, row, l->e, l->s);
      for (LitheCount d = A->row_off[row]; d < A->row_off[row + 1]; d++) {
        l->h[d] -= l->s[d];
        l->q[d] -= l->e[d];
      }
    }
}

static void iterate(const LthLevel *l, int degree, bool residual, double *x) {
  const double theta = 0.5 * (1 + LOWEST), delta = 0.5 * (1 - LOWEST), sigma = theta / delta;
  double rho = 1 / sigma;
#pragma omp for schedule(static)
  for (LitheCount i = 0; i < l->A->n; i++) l->v[i] = l->q[i] / theta;
  for (int k = 0; k < degree; k++) {
    step(l, residual || k + 1 < degree, x);
    const double next = 1 / (2 * sigma - rho), keep = next * rho, take = 2 * next / delta;
    rho = next;
#pragma omp for schedule(static)
    for (LitheCount i = 0; i < l->A->n; i++) l->v[i] = keep * l->v[i] + take * l->q[i];
  }
}

/// r = b - (A + extra) x in one row.
static void full_residual(const LthLevel *l, LitheIndex row, const double *b, const double *x,
                          double *r) {
  const LthBlockMatrix *A = l->A;
  const int m = lth_ml_size(A, row);
  row_residual(l, row, 0, l->colours.count, -1, b, x, r);
  for (int i = 0; l->extra && i < m; i++)
    for (int j = 0; j < m; j++)
      r[A->row_off[row] + i] -= l->extra[l->extra_off[row] + i * m + j] * x[A->row_off[row] + j];
}

void lth_ml_polynomial_down(const LthLevel *l, int threads, int degree, const double *b, double *x,
                            double *r) {
  const LthBlockMatrix *A = l->A;
#pragma omp parallel num_threads(threads) if (lth_block_matrix_is_large(A))
  {
#pragma omp for schedule(static)
    for (LitheCount i = 0; i < A->n; i++) x[i] = 0;
    forward(l, b, l->q, l->h);
    iterate(l, degree, true, x);
    // r = (D + L) h
#pragma omp for schedule(static)
    for (LitheCount i = 0; i < A->n; i++) l->h[i] = -l->h[i];
#pragma omp for schedule(static)
    for (LitheIndex i = 0; i < A->n_rows; i++)
      row_residual(l, i, 0, l->colours.colour[i], -1, l->q, l->h, r);
  }
}

void lth_ml_polynomial_up(const LthLevel *l, int threads, int degree, const double *b, double *x) {
  const LthBlockMatrix *A = l->A;
#pragma omp parallel num_threads(threads) if (lth_block_matrix_is_large(A))
  {
#pragma omp for schedule(static)
    for (LitheIndex i = 0; i < A->n_rows; i++) full_residual(l, i, b, x, l->r);
    forward(l, l->r, l->q, l->h);
    iterate(l, degree, false, x);
  }
}

double lth_ml_spectral_radius(LthLevel *l, int threads) {
  const LthBlockMatrix *A = l->A;
  LthOperator D = lth_block_jacobi_operator(l->jacobi);
  double radius = 0;
  // a start that is rough from unknown to unknown
  for (LitheCount i = 0; i < A->n; i++)
    l->x[i] = (double)((uint64_t)(i + 1) * 2654435761u % 65536) / 32768.0 - 1;
  for (int step = 0; step < POWER_STEPS; step++) {
    lth_block_matrix_apply(A, threads, l->x, l->b);
    D.apply(D.self, threads, l->b, l->r);
    // Rayleigh quotient in the inner product of D, in which D^-1 A is symmetric: x A x / x D x
    double energy = lth_dot(threads, A->n, l->b, l->r), norm = lth_dot(threads, A->n, l->x, l->b);
    if (!(norm > 0)) break;
    radius = energy / norm;
    double scale = 1 / sqrt(lth_dot(threads, A->n, l->r, l->r));
    for (LitheCount i = 0; i < A->n; i++) l->x[i] = scale * l->r[i];
  }
  return radius;
}
