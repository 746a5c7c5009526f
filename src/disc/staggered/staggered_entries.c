/// Rows of the operator as lists of entries: equation (2) of docs/theory/staggered.md with inertia.
#include "disc/staggered/staggered_entries.h"

static void add_entry(const LthStaggeredLevel *l, int b, LitheCount slot, double value,
                      LthStaggeredEntry *entry, int *n) {
  if (slot < 0 || value == 0 || l->state[b][slot] == LTH_UNKNOWN_DEAD) return;
  entry[(*n)++] = (LthStaggeredEntry){slot, b, value};
}

/// Slot of the neighbour at offsets along two axes.
static LitheCount neighbor(const LthSparseGrid *g, const LitheIndex cell[3], int a, int da, int b,
                           int db) {
  LitheIndex c[3] = {cell[0], cell[1], cell[2]};
  c[a] += da;
  c[b] += db;
  return lth_sparse_grid_slot(g, c[0], c[1], c[2]);
}

// Normal stress of the two cells along a, shear of the edges across.
int lth_staggered_row(const LthStaggeredLevel *l, double cm, double ck, int a, LitheCount s,
                      LthStaggeredEntry entry[LTH_STAGGERED_ROW]) {
  const LthSparseGrid *g = l->grid;
  double volume = lth_sparse_grid_cell_volume(g), scale = volume * ck, ia = 1 / g->h[a];
  LitheIndex cell[3];
  lth_sparse_grid_cell(g, s, cell);
  LitheCount before = lth_sparse_grid_along(g, cell, a, -1);
  const LitheCount at = lth_level_at(l, s);
  double here = l->lambda[at], there = lth_level_value(l, l->lambda, before);
  double high = (2 * l->mu[at] + here) * ia * ia;
  double low = (2 * lth_level_value(l, l->mu, before) + there) * ia * ia;
  double centre = high + low;
  int n = 1;
  add_entry(l, a, lth_sparse_grid_along(g, cell, a, 1), -scale * high, entry, &n);
  add_entry(l, a, before, -scale * low, entry, &n);
  for (int b = 0; b < g->dim; b++) {
    if (b == a) continue;
    double ib = 1 / g->h[b];
    LitheCount after = lth_sparse_grid_along(g, cell, b, 1);
    const double *shear = l->shear[3 - a - b];
    double below = shear[at], above = lth_level_value(l, shear, after);
    centre += (below + above) * ib * ib;
    add_entry(l, a, after, -scale * above * ib * ib, entry, &n);
    add_entry(l, a, lth_sparse_grid_along(g, cell, b, -1), -scale * below * ib * ib, entry, &n);
    double f = scale * ia * ib;
    add_entry(l, b, s, f * (here + below), entry, &n);
    add_entry(l, b, after, -f * (here + above), entry, &n);
    add_entry(l, b, before, -f * (there + below), entry, &n);
    add_entry(l, b, neighbor(g, cell, a, -1, b, 1), f * (there + above), entry, &n);
  }
  entry[0] = (LthStaggeredEntry){s, a, scale * centre + volume * cm * l->mass[a][at]};
  return n;
}
