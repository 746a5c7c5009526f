/// Parts by inside tests on one lattice, and the halving of blocks that all methods share.
#include "geometry/fractions_fill.h"

#include "base/tensor.h"

/// A block while it is filled.
typedef struct Halving {
  const LthFractionFiller *filler;
  LthFractionLeaf leaf;
  const LthFractionFrame *frame;
  const double *low; ///< corner of the block
  int asked;         ///< parts along the smallest box whose side is asked
  double *part;
} Halving;

/// Parts [at, at + size) of the block.
static void fill_box(const Halving *s, const int at[3], int size) {
  const LthFractionFrame *f = s->frame;
  double center[3] = {0, 0, 0}, half[3] = {0, 0, 0};
  int deep = f->dim == 3 ? size : 1;
  for (int a = 0; a < f->dim; a++) {
    half[a] = 0.25 * f->h[a] * size;
    center[a] = s->low[a] + 0.5 * f->h[a] * at[a] + half[a];
  }
  LthSide side = size < s->asked ? LTH_SIDE_MIXED : s->filler->side(s->filler->self, center, half);
  if (side == LTH_SIDE_OUTSIDE) return;
  if (side == LTH_SIDE_MIXED && size > 1) {
    for (int q = 0; q < f->n_parts; q++) {
      int to[3] = {at[0] + (q & 1) * size / 2, at[1] + (q >> 1 & 1) * size / 2,
                   at[2] + (q >> 2) * size / 2};
      fill_box(s, to, size / 2);
    }
    return;
  }
  double value = side == LTH_SIDE_INSIDE ? 1 : s->leaf(s->filler->self, f, s->low, at);
  for (int k = at[2]; k < at[2] + deep; k++)
    for (int j = at[1]; j < at[1] + size; j++)
      for (int i = at[0]; i < at[0] + size; i++) s->part[lth_fraction_place(f, i, j, k)] = value;
}

void lth_fraction_halve(const LthFractionFiller *filler, LthFractionLeaf leaf, int asked,
                        const LthFractionFrame *frame, const double low[3], double *part) {
  Halving s = {
      .filler = filler, .leaf = leaf, .frame = frame, .low = low, .asked = asked, .part = part};
  fill_box(&s, (int[3]){0, 0, 0}, 2 * frame->side);
}

/// Number of samples of a part that are inside, as a part of all.
static double sample_part(const void *self, const LthFractionFrame *f, const double low[3],
                          const int at[3]) {
  const LthSampler *s = self;
  int n = s->samples / 2, deep = f->dim == 3 ? n : 1, count = 0;
  double x[3] = {0, 0, 0};
  for (int k = 0; k < deep; k++)
    for (int j = 0; j < n; j++)
      for (int i = 0; i < n; i++) {
        int place[3] = {i, j, k};
        for (int a = 0; a < f->dim; a++)
          x[a] = low[a] + f->h[a] * ((at[a] * n + place[a]) + 0.5) / (2 * n);
        count += lth_probe_inside(s->probe, x);
      }
  return (double)count / (n * n * deep);
}

LthSide lth_fraction_sample_side(const void *sampler, const double center[3],
                                 const double half[3]) {
  const LthSampler *s = sampler;
  return lth_probe_side(s->probe, center, half);
}

LitheStatus lth_fraction_fill_samples(const void *sampler, LitheCtx *ctx, const LthFractionFrame *f,
                                      const LthFractionRow *row) {
  LthFractionFiller filler = {.self = sampler, .side = lth_fraction_sample_side};
  const LthSampler *s = sampler;
  const LthShape *shape = s->probe->shape;
  if (shape->kind == LTH_SHAPE_MESH && shape->bvh && f->dim == 3)
    return lth_fraction_fill_surface(ctx, shape, s->samples, f, row, row->part);
  if (shape->kind == LTH_SHAPE_WRAP && f->dim == 3)
    return lth_fraction_fill_wrap(ctx, s->probe, s->samples, f, row, row->part);
  for (LitheIndex m = 0; m < row->n; m++) {
    double low[3];
    lth_fraction_corner(f, row->at[m], row->j, row->k, low);
    lth_fraction_halve(&filler, sample_part, 1, f, low,
                       row->part + (LitheCount)m * f->block_cells * f->n_parts);
  }
  return LITHE_OK;
}
