/// Fractions of single control volumes, and loops over functions.
#include "disc/staggered/staggered_priv.h"

double lth_staggered_face_fraction(const LthStaggered *s, const LitheCount *slot,
                                   const int stride[3], int a) {
  double sum = 0;
  int n = 1 << s->dim;
  for (int q = 0; q < n;
       q++) { // part q of a cell: the high half of the one before, the low of this
    LitheCount cell = slot[q >> a & 1 ? -stride[a] : 0];
    if (cell >= 0) sum += lth_fractions_part(s->fractions, cell, q);
  }
  return sum / n;
}

double lth_staggered_edge_fraction(const LthStaggered *s, const LitheCount *slot,
                                   const int stride[3], int e) {
  int a = (e + 1) % 3, b = (e + 2) % 3, n = 1 << s->dim;
  double sum = 0;
  for (int q = 0; q < n; q++) {
    LitheCount cell = slot[(q >> a & 1 ? -stride[a] : 0) + (q >> b & 1 ? -stride[b] : 0)];
    if (cell >= 0) sum += lth_fractions_part(s->fractions, cell, q);
  }
  return sum / n;
}

void lth_staggered_visit(const LthStaggered *s,
                         void (*visit)(const LthStaggered *s, LitheIndex func,
                                       const LitheCount *slot, const int stride[3], void *self),
                         void *self) {
  const LthSparseGrid *g = s->grid;
#pragma omp parallel for schedule(static) num_threads(lth_threads(s->ctx))
  for (LitheIndex block = 0; block < g->n_blocks; block++) {
    LthHalo halo;
    lth_halo_fill(g, block, &halo);
    for (LitheIndex local = 0; local < g->block_cells; local++) {
      const LitheCount *slot = halo.slot + lth_halo_at(g, &halo, local);
      if (s->func[*slot] >= 0) visit(s, s->func[*slot], slot, halo.stride, self);
    }
  }
}

double lth_staggered_own_share(const LthStaggered *s, const LitheCount *slot, const int stride[3],
                               int a) {
  double own = 0, all = 0, x[3];
  if (!s->filled) return 1;
  for (int side = 0; side < 2; side++) {
    LitheCount cell = slot[side ? -stride[a] : 0];
    if (cell < 0) continue;
    own += (double)s->filled[cell];
    all += lth_fractions_cell(s->fractions, cell); // as it is now, with its held sides
  }
  if (all <= own + 1e-6) return 1;
  if (s->level.state[a][*slot] != LTH_UNKNOWN_HELD) {
    lth_staggered_slot_place(s, *slot, a, x);
    if (!s->shape || lth_shape_value(s->shape, x) <= 0) return 1;
  }
  return own / all;
}
