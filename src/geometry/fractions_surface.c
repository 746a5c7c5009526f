/// Parts inside closed triangle surfaces: what is closed sums up to 0 or 1, and nothing needs to be known of neighbours
/// (docs/theory/fractions.md).
#include "geometry/fractions_ledger.h"

#include "base/tensor.h"

/// Sum up along x.
static void settle(const LthLedger *l) {
  const LthFractionFrame *f = l->frame;
  int w = l->width;
  for (int k = 0; k < w; k++)
    for (int j = 0; j < w; j++) {
      double sum = 0;
      for (LitheIndex m = 0; m < l->row->n; m++) {
        const double *behind = l->behind + lth_ledger_place(l, m, 0, j, k);
        double *part = l->part + (LitheCount)m * f->block_cells * f->n_parts;
        sum += l->carry[((LitheCount)m * w + k) * w + j];
        for (int i = 0; i < w; i++) {
          sum += behind[i];
          double *p = &part[lth_fraction_place(f, i, j, k)];
          *p = fmin(fmax(*p + sum, 0), 1);
        }
      }
    }
}

LitheStatus lth_fraction_fill_surface(LitheCtx *ctx, const LthShape *shape, int samples,
                                      const LthFractionFrame *f, const LthFractionRow *row,
                                      double *part) {
  LthLedger l;
  LITHE_TRY(lth_ledger_open(ctx, f, row, samples, false, part, &l));
  lth_ledger_take(&l, shape->bvh, NULL);
  settle(&l);
  lth_ledger_close(ctx, &l);
  return LITHE_OK;
}
