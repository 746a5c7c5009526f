/// Aggregates of strongly coupled block rows (Vanek, Mandel and Brezina 1996).
#include "la/ml_priv.h"

#include <math.h>
#include <omp.h>
#include <string.h>

#define STRONG 0.1    // of a row's strongest coupling
#define WEAKEST 0.005 // that aggregates are looked for with

/// Sizes of blocks in the Frobenius norm, scaled by those of the two diagonal blocks.
typedef struct Strength {
  const LthBlockMatrix *A;
  double *diagonal, *strongest; // of a row  (n_rows)
  float *block;                 // (n_blocks)
  double least;                 // of what is strong, over a row's strongest coupling
} Strength;

static double frobenius(const LthBlockMatrix *A, LitheCount block) {
  double sum = 0;
  for (LitheCount i = A->value_off[block]; i < A->value_off[block + 1]; i++)
    sum += A->values[i] * A->values[i];
  return sqrt(sum);
}

static void measure(int threads, Strength *s) {
  const LthBlockMatrix *A = s->A;
#pragma omp parallel num_threads(threads) if (lth_block_matrix_is_large(A))
  {
#pragma omp for schedule(static)
    for (LitheIndex i = 0; i < A->n_rows; i++) s->diagonal[i] = sqrt(frobenius(A, A->diagonal[i]));
#pragma omp for schedule(static)
    for (LitheIndex i = 0; i < A->n_rows; i++)
      for (LitheCount e = A->block_off[i]; e < A->block_off[i + 1]; e++) {
        double scale = s->diagonal[i] * s->diagonal[A->block_col[e]];
        s->block[e] = e == A->diagonal[i] || scale == 0 ? 0 : (float)(frobenius(A, e) / scale);
        s->strongest[i] = fmax(s->strongest[i], s->block[e]);
      }
  }
}

static bool is_strong(const Strength *s, LitheIndex row, LitheCount e) {
  double limit = s->least * fmax(s->strongest[row], s->strongest[s->A->block_col[e]]);
  return s->block[e] > 0 && s->block[e] >= limit;
}

/// A root whose strong neighbours are all free makes an aggregate with them.
static LitheIndex take_roots(const Strength *s, LitheIndex *aggregate) {
  const LthBlockMatrix *A = s->A;
  LitheIndex n = 0;
  for (LitheIndex i = 0; i < A->n_rows; i++) {
    bool is_free = aggregate[i] < 0 && s->strongest[i] > 0, has_neighbour = false;
    for (LitheCount e = A->block_off[i]; is_free && e < A->block_off[i + 1]; e++)
      if (is_strong(s, i, e)) {
        has_neighbour = true;
        is_free = aggregate[A->block_col[e]] < 0;
      }
    if (!is_free || !has_neighbour) continue;
    aggregate[i] = n;
    for (LitheCount e = A->block_off[i]; e < A->block_off[i + 1]; e++)
      if (is_strong(s, i, e)) aggregate[A->block_col[e]] = n;
    n++;
  }
  return n;
}

/// Others join the aggregate of their strongest neighbour.
static void join(const Strength *s, const LitheIndex *before, LitheIndex *aggregate) {
  const LthBlockMatrix *A = s->A;
  for (LitheIndex i = 0; i < A->n_rows; i++) {
    float most = 0;
    if (before[i] >= 0) continue;
    for (LitheCount e = A->block_off[i]; e < A->block_off[i + 1]; e++)
      if (s->block[e] > most && is_strong(s, i, e) && before[A->block_col[e]] >= 0) {
        most = s->block[e];
        aggregate[i] = before[A->block_col[e]];
      }
  }
}

/// What is left aggregates among itself; a row without strong neighbours stands alone.
static LitheIndex gather_rest(const Strength *s, LitheIndex n, LitheIndex *aggregate) {
  const LthBlockMatrix *A = s->A;
  for (LitheIndex i = 0; i < A->n_rows; i++) {
    if (aggregate[i] >= 0 || s->strongest[i] == 0) continue;
    aggregate[i] = n;
    for (LitheCount e = A->block_off[i]; e < A->block_off[i + 1]; e++)
      if (is_strong(s, i, e) && aggregate[A->block_col[e]] < 0) aggregate[A->block_col[e]] = n;
    n++;
  }
  return n;
}

/// Aggregates for what counts as strong; `before` (n_rows) is scratch.
static LitheIndex gather_all(const Strength *s, LitheIndex *before, LitheIndex *aggregate) {
  for (LitheIndex i = 0; i < s->A->n_rows; i++) aggregate[i] = -1;
  LitheIndex n = take_roots(s, aggregate);
  memcpy(before, aggregate, sizeof *before * (size_t)s->A->n_rows);
  join(s, before, aggregate);
  return gather_rest(s, n, aggregate);
}

// Rows of shells and of coarse levels have a few strong neighbours and many weak ones: aggregates of the strong alone are so
// small that the smoothed prolongation couples nearly all of them.
LitheStatus lth_ml_aggregate(LitheCtx *ctx, const LthBlockMatrix *A, LitheIndex least_rows,
                             LitheIndex *aggregate, LitheIndex *n_aggregates) {
  LitheStatus status = LITHE_OK;
  Strength s = {.A = A};
  LitheIndex *before = NULL;
  LTH_NEW_OR(done, ctx, s.diagonal, A->n_rows);
  LTH_NEW_OR(done, ctx, s.strongest, A->n_rows);
  LTH_NEW_OR(done, ctx, s.block, A->block_off[A->n_rows]);
  LTH_NEW_OR(done, ctx, before, A->n_rows);
  measure(lth_threads(ctx), &s);
  s.least = STRONG;
  *n_aggregates = gather_all(&s, before, aggregate);
  while (least_rows > 0 && *n_aggregates > A->n_rows / least_rows && s.least > 2 * WEAKEST) {
    s.least *= 0.5;
    *n_aggregates = gather_all(&s, before, aggregate);
  }
done:
  lth_free(ctx, s.diagonal);
  lth_free(ctx, s.strongest);
  lth_free(ctx, s.block);
  lth_free(ctx, before);
  return status;
}
