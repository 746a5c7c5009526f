#include "dense_stencil.h"

#include "base/clones.h"

#include <math.h>

#define PAD 8 // values before and after a row, so that rows begin where lines of the cache do

static inline double rise(const double *p, ptrdiff_t i, ptrdiff_t step) {
  return p[i + step] - p[i];
}

static inline double divergence(const int dim, const double *const p[3], ptrdiff_t i,
                                const ptrdiff_t step[3]) {
  double sum = 0;
  for (int a = 0; a < dim; a++) sum += rise(p[a], i, step[a]);
  return sum;
}

/// q = -mu lap p - (lambda + mu) grad div p in a row.
static inline __attribute__((always_inline)) void stencil(const int dim, const DenseStencil *box,
                                                          ptrdiff_t at) {
  const double mu = 1, both = 2.5;
  const ptrdiff_t step[3] = {1, box->step[1], box->step[2]};
  const double *p[3];
  double *q[3];
  for (int a = 0; a < 3; a++)
    p[a] = box->p + a * box->size + at, q[a] = box->q + a * box->size + at;
#pragma omp simd
  for (ptrdiff_t i = 0; i < box->side; i++) {
    const double here = divergence(dim, p, i, step);
    for (int a = 0; a < dim; a++) {
      double laplacian = 0;
      for (int b = 0; b < dim; b++)
        laplacian += rise(p[a], i, step[b]) - rise(p[a], i - step[b], step[b]);
      q[a][i] = -mu * laplacian - both * (here - divergence(dim, p, i - step[a], step));
    }
  }
}

LTH_CLONES static void row_2d(const DenseStencil *box, ptrdiff_t at) { stencil(2, box, at); }
LTH_CLONES static void row_3d(const DenseStencil *box, ptrdiff_t at) { stencil(3, box, at); }

void dense_stencil_apply(const LitheCtx *ctx, const DenseStencil *box) {
  const LitheCount deep = box->dim == 3 ? box->side : 1;
#pragma omp parallel for collapse(2) schedule(static) num_threads(lth_threads(ctx))
  for (LitheCount k = 0; k < deep; k++)
    for (LitheCount j = 1; j <= box->side; j++) {
      const ptrdiff_t at = (box->dim == 3 ? k + 1 : 0) * box->step[2] + j * box->step[1] + PAD;
      (box->dim == 3 ? row_3d : row_2d)(box, at);
    }
}

/// Values that are not all alike, on pages that each thread has written.
static void fill(const LitheCtx *ctx, DenseStencil *box) {
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheCount i = 0; i < box->dim * box->size; i++) box->p[i] = (double)(i % 17), box->q[i] = 0;
}

LitheStatus dense_stencil_create(LitheCtx *ctx, int dim, LitheCount unknowns, DenseStencil *box) {
  *box = (DenseStencil){.dim = dim, .side = (LitheCount)pow((double)unknowns / dim, 1.0 / dim)};
  box->step[1] = box->side + 2 * PAD;
  box->step[2] = box->step[1] * (box->side + 2);
  box->size = box->step[2] * (dim == 3 ? box->side + 2 : 1) + PAD;
  box->share = (double)unknowns / (dim * pow((double)box->side, dim));
  LTH_NEW(ctx, box->p, dim * box->size);
  LTH_NEW(ctx, box->q, dim * box->size);
  fill(ctx, box);
  return LITHE_OK;
}

void dense_stencil_free(LitheCtx *ctx, DenseStencil *box) {
  lth_free(ctx, box->p);
  lth_free(ctx, box->q);
}
