/// Loads and mass beyond held sides: rows of free unknowns beside them are those of the interior, and held unknowns take
/// off what is not the body's (docs/theory/staggered.md, "Held unknowns").
#include "disc/staggered/staggered_priv.h"

/// Parts of a cell became full.
static bool is_changed(const LthStaggered *s, LitheCount slot) {
  if (slot < 0) return false;
  uint16_t now = s->fractions->cell[slot], own = s->own->cell[slot];
  if (now < LTH_CELL_CUT || own < LTH_CELL_CUT) return now != own;
  for (int q = 0; q < s->fractions->n_parts; q++)
    if (lth_fractions_part(s->fractions, slot, q) != lth_fractions_part(s->own, slot, q))
      return true;
  return false;
}

/// Held unknowns of component a beside that at slot[0].
static int held_beside(const LthStaggered *s, const LitheCount *slot, const int stride[3], int a,
                       LitheCount held[6]) {
  int n = 0;
  for (int b = 0; b < s->dim; b++)
    for (int side = -1; side <= 1; side += 2) {
      LitheCount at = slot[side * stride[b]];
      if (at >= 0 && s->level.state[a][at] == LTH_UNKNOWN_HELD) held[n++] = at;
    }
  return n;
}

static bool is_inside(const LthStaggered *s, LitheCount slot, int a) {
  double x[3];
  lth_staggered_slot_place(s, slot, a, x);
  return !s->shape || lth_shape_value(s->shape, x) <= 0;
}

static LitheStatus add(LitheCtx *ctx, LthStaggered *s, const LitheCount *slot, const int stride[3],
                       int a) {
  LitheCount held[6];
  double own = lth_staggered_own_fraction(s, slot, stride, a);
  double volume = lth_staggered_face_fraction(s, slot, stride, a) - own;
  if (s->level.state[a][*slot] != LTH_UNKNOWN_FREE || !(volume > 0) || !(own > 0)) return LITHE_OK;
  int n = held_beside(s, slot, stride, a, held);
  if (n == 0 || !is_inside(s, *slot, a)) return LITHE_OK;
  double *mass = s->level.mass[a], moved = volume * mass[*slot] / own;
  LTH_RESERVE(ctx, s->beyond, s->cap_beyond, s->n_beyond + n);
  mass[*slot] += moved;
  for (int i = 0; i < n; i++) {
    mass[held[i]] -= moved / n;
    s->beyond[s->n_beyond++] = (LthStaggeredBeyond){.free = 3 * (LitheCount)s->func[*slot] + a,
                                                    .held = 3 * (LitheCount)s->func[held[i]] + a,
                                                    .volume = volume / n};
  }
  return LITHE_OK;
}

LitheStatus lth_staggered_build_beyond(LitheCtx *ctx, LthStaggered *s) {
  const LthSparseGrid *g = s->grid;
  for (LitheIndex block = 0; s->own && block < g->n_blocks; block++) {
    LthHalo halo;
    lth_halo_fill(g, block, &halo);
    for (LitheIndex local = 0; local < g->block_cells; local++) {
      const LitheCount *slot = halo.slot + lth_halo_at(g, &halo, local);
      for (int a = 0; a < s->dim; a++)
        if (is_changed(s, slot[0]) || is_changed(s, slot[-halo.stride[a]]))
          LITHE_TRY(add(ctx, s, slot, halo.stride, a));
    }
  }
  return LITHE_OK;
}

void lth_staggered_load_beyond(const LthStaggered *s, const LthLoad *load, double t, double *f) {
  double cell = lth_sparse_grid_cell_volume(s->grid);
  for (LitheCount i = 0; i < s->n_beyond; i++) {
    const LthStaggeredBeyond *b = &s->beyond[i];
    int a = (int)(b->free % 3);
    double at[3];
    lth_staggered_place(s, (LitheIndex)(b->free / 3), a, at);
    double force = cell * b->volume * lth_value_at(&load->value[a], at, t);
    f[b->free] += force;
    f[b->held] -= force;
  }
}
