/// The slots of a block and of the cells around it, so that loops over a block reach neighbours by strides.
#pragma once

#include "geometry/sparse_grid.h"

#define LTH_HALO_MAX 1000 ///< (8 + 2)^3; (16 + 2)^2 is less

/// slot[at + dx stride[0] + dy stride[1] + dz stride[2]] is the slot of the cell at that offset (-1..1) from the
/// block's cell at `at`, or -1. In 2D stride[2] is 0.
typedef struct LthHalo {
  LitheCount slot[LTH_HALO_MAX];
  int stride[3];
} LthHalo;

static inline void lth_halo_fill(const LthSparseGrid *g, LitheIndex block, LthHalo *halo) {
  int s = g->side, deep = g->dim == 3, width = s + 2;
  const LitheIndex *neighbor = g->neighbor + (LitheCount)block * g->n_neighbors;
  LitheCount *to = halo->slot;
  halo->stride[0] = 1;
  halo->stride[1] = width;
  halo->stride[2] = deep ? width * width : 0;
  for (int z = -deep; z < (deep ? s + 1 : 1); z++) {
    int bz = !deep || z < 0 ? 0 : z < s ? 1 : 2, lz = deep ? (z + s) % s : 0;
    for (int y = -1; y <= s; y++) {
      int by = y < 0 ? 0 : y < s ? 1 : 2, ly = (y + s) % s;
      for (int x = -1; x <= s; x++) {
        int bx = x < 0 ? 0 : x < s ? 1 : 2, lx = (x + s) % s;
        LitheIndex b = neighbor[bz * 9 + by * 3 + bx];
        *to++ = b < 0 ? -1 : (LitheCount)b * g->block_cells + lx + s * (ly + s * lz);
      }
    }
  }
}

/// Place in the halo of a block's cell, from its place in the block (x fastest).
static inline int lth_halo_at(const LthSparseGrid *g, const LthHalo *halo, LitheIndex local) {
  int s = g->side;
  return local % s + 1 + (local / s % s + 1) * halo->stride[1] +
         (g->dim == 3 ? (local / (s * s) + 1) * halo->stride[2] : 0);
}
