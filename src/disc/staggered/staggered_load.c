/// External forces: body forces at the unknowns.
#include "disc/staggered/staggered_priv.h"

/// Fraction of the box around the low face across axis a of a slot's cell.
static double face_fraction(const LthStaggered *s, LitheCount slot, int a) {
  int down[3] = {0}, n = 1 << s->dim;
  double sum = 0;
  down[a] = -1;
  LitheCount before = lth_sparse_grid_step(s->grid, slot, down);
  for (int q = 0; q < n; q++) {
    LitheCount cell = q >> a & 1 ? before : slot; // the half of each cell towards the face
    if (cell >= 0) sum += lth_fractions_part(s->fractions, cell, q);
  }
  return sum / n;
}

static void add_body_force(const LthStaggered *s, const LthLoad *load, double t, double *f) {
  double volume = lth_sparse_grid_cell_volume(s->grid);
#pragma omp parallel for schedule(static) num_threads(lth_threads(s->ctx))
  for (LitheIndex i = 0; i < s->disc.n_funcs; i++)
    for (int a = 0; a < s->dim; a++) {
      double at[3];
      if (!lth_staggered_slot_alive(s, a, s->slot[i])) continue;
      lth_staggered_place(s, i, a, at);
      f[3 * (LitheCount)i + a] +=
          volume * face_fraction(s, s->slot[i], a) * lth_value_at(&load->value[a], at, t);
    }
}

LitheStatus lth_staggered_add_load(LitheCtx *ctx, const LthDisc *disc, const LthLoad *load,
                                   double t, const double *x, double *f) {
  (void)x;
  if (load->kind != LTH_LOAD_BODY_FORCE)
    LITHE_FAIL(ctx, LITHE_UNSUPPORTED, "staggered bodies take body forces only");
  add_body_force(lth_staggered_const(disc), load, t, f);
  return LITHE_OK;
}
