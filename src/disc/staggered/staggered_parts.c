/// Connected parts of a body on the grid: cells that share faces. Cells that meet at an edge or corner alone share a
/// shear sample at most, which lets them turn against each other.
#include "base/disjoint_sets.h"
#include "disc/staggered/staggered_priv.h"

/// Unite all unknowns on the faces of a live cell.
static void unite_cell(const LthStaggered *s, LitheCount slot, LitheIndex *part_of) {
  LitheIndex own = s->func[slot]; // low faces are the cell's own: there is one at least
  for (int a = 0; a < s->dim; a++) {
    const int d[3] = {a == 0, a == 1, a == 2};
    LitheCount high = lth_sparse_grid_step(s->grid, slot, d);
    if (high >= 0 && own >= 0 && s->func[high] >= 0 && lth_staggered_slot_alive(s, a, high))
      lth_sets_unite(part_of, own, s->func[high]);
  }
}

/// A held unknown that no live cell touches hangs on shear samples: it joins those across.
static void unite_held(const LthStaggered *s, LitheIndex i, LitheIndex *part_of) {
  LitheCount slot = s->slot[i];
  for (int a = 0; a < s->dim; a++) {
    if (s->level.state[a][slot] != LTH_UNKNOWN_HELD) continue;
    for (int k = 0; k < 2 * s->dim; k++) {
      int d[3] = {0};
      d[k / 2] = k % 2 ? -1 : 1;
      LitheCount other = k / 2 == a ? -1 : lth_sparse_grid_step(s->grid, slot, d);
      if (other >= 0 && s->func[other] >= 0 && lth_staggered_slot_alive(s, a, other))
        lth_sets_unite(part_of, i, s->func[other]);
    }
  }
}

/// A function of which only the high faces of other cells are alive joins through them; two of these may be of two
/// parts that touch at an edge, which then count as one.
LitheIndex lth_staggered_parts(const LthDisc *disc, LitheIndex *part_of) {
  const LthStaggered *s = lth_staggered_const(disc);
  LitheIndex n = 0;
  lth_sets_reset(part_of, disc->n_rows);
  for (LitheIndex c = 0; c < disc->n_cells; c++) unite_cell(s, s->cell_slot[c], part_of);
  for (LitheIndex i = 0; i < disc->n_rows; i++) unite_held(s, i, part_of);
  for (LitheIndex i = 0; i < disc->n_rows; i++) part_of[i] = lth_sets_root(part_of, i);
  for (LitheIndex i = 0; i < disc->n_rows; i++)
    part_of[i] = part_of[i] == i ? n++ : part_of[part_of[i]];
  return n;
}
