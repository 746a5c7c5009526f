/// Fractions of single control volumes, and loops over functions.
#include "disc/staggered/staggered_priv.h"

static double face_fraction(const LthFractions *f, const LitheCount *slot, const int stride[3],
                            int a) {
  double sum = 0;
  for (int q = 0; q < f->n_parts;
       q++) { // part q of a cell: the high half of the one before, the low of this
    LitheCount cell = slot[q >> a & 1 ? -stride[a] : 0];
    if (cell >= 0) sum += lth_fractions_part(f, cell, q);
  }
  return sum / f->n_parts;
}

double lth_staggered_face_fraction(const LthStaggered *s, const LitheCount *slot,
                                   const int stride[3], int a) {
  return face_fraction(s->fractions, slot, stride, a);
}

double lth_staggered_own_fraction(const LthStaggered *s, const LitheCount *slot,
                                  const int stride[3], int a) {
  return face_fraction(s->own ? s->own : s->fractions, slot, stride, a);
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
