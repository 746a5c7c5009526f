/// Variational finite differences on one staggered grid: coefficients and unknowns of one level.
/// Dolny 2025, sections 3.3 and 4; docs/theory/staggered.md.
#pragma once

#include "geometry/sparse_grid.h"

/// V lambda over mu where nu = 0.5: the augmented Lagrangian of the assembled form (docs/theory/staggered-mixed.md).
/// Cut cells have the stiffness of whole ones, lest their pressures lag.
#define LTH_PENALTY 100

/// lambda over mu up to which (nu = 0.49) the multigrid of displacements alone is at its best.
#define LTH_STIFFEST 50

/// What an unknown is. Rule A (docs/theory/staggered.md) says which are dead: they carry no stiffness and no mass.
typedef enum LthUnknownState {
  LTH_UNKNOWN_DEAD,
  LTH_UNKNOWN_FREE,
  LTH_UNKNOWN_HELD
} LthUnknownState;

typedef struct LthStaggeredWalls LthStaggeredWalls; // staggered_walls.h

/// At the slot of cell (i, j, k) stand: at the cell's centre the normal strains; component a of the displacement at the
/// centre of its low face across axis a; shear e at the middle of its low edge along axis e (0: yz, 1: zx, 2: xy; in 2D
/// only 2, at its low corner).
///
///   E(u) = sum over cells of |cell| [ mu sum_a e_aa^2 + lambda/2 (sum_a e_aa)^2 ] + sum over edges of
///          |cell| shear_e / 2 g_e^2
///
/// with e_xx = (x_{i+1} - x_i) / h_x and g_xy = (x_j - x_{j-1}) / h_y + (y_i - y_{i-1}) / h_x; the weights contain the
/// volume fractions. A sample counts only where its weight is not zero.
///
/// States are over slots. Samples are over rows of `grid->side` cells along x: those of a slot stand at
/// lth_level_at(). A level is built with a row of its own for every row of slots, so that this is the slot itself; once
/// packed, rows that are alike in all samples stand once, and samples may no longer be written.
typedef struct LthStaggeredLevel {
  const LthSparseGrid *grid;
  LitheIndex *row;     ///< of samples, for rows of slots                          (n_slots / side)
  LitheIndex n_rows;   ///< of samples; one more is there, of zeros
  double *lambda, *mu; ///< V lambda, V mu of cells [Pa]; where nu = 0.5 V lambda is LTH_PENALTY mu
  double *volume;      ///< V of cells; may be NULL but in the mixed form
  double *
      compliance; ///< V / lambda of cells [1/Pa] without walls, 0 where nu = 0.5; NULL: there are no pressures
  double *shear[3];         ///< V mu of edges [Pa]; 2D: [0] and [1] are NULL
  double *mass[3];          ///< V rho of faces [kg/m^3]; 2D: [2] is NULL
  uint8_t *state[3];        ///< LthUnknownState of faces; 2D: [2] is NULL
  LthStaggeredWalls *walls; ///< in the weights above; NULL: held sides begin at held unknowns
} LthStaggeredLevel;

/// Place of a slot's samples.
static inline LitheCount lth_level_at(const LthStaggeredLevel *level, LitheCount slot) {
  const int bits = level->grid->dim == 3 ? 3 : 4; // log2 of the cells along a row
  const LitheCount row = level->row[slot >> bits];
  return row << bits | (slot & ((1 << bits) - 1));
}

/// A sample of a slot, 0 where there is no such slot.
static inline double lth_level_value(const LthStaggeredLevel *level, const double *sample,
                                     LitheCount slot) {
  return slot < 0 ? 0 : sample[lth_level_at(level, slot)];
}

/// A cell holds something.
static inline bool lth_level_is_live(const LthStaggeredLevel *level, LitheCount slot) {
  return lth_level_value(level, level->mu, slot) > 0;
}

/// LthUnknownState of component a at a slot, dead where there is no such slot.
static inline int lth_level_state(const LthStaggeredLevel *level, int a, LitheCount slot) {
  return slot < 0 ? LTH_UNKNOWN_DEAD : level->state[a][slot];
}

/// Arrays of a level, all zero, on a grid, with a row of samples for every row of slots, without those of the mixed form;
/// freed by lth_staggered_level_free(), which leaves the grid.
LitheStatus lth_staggered_level_alloc(LitheCtx *ctx, const LthSparseGrid *grid,
                                      LthStaggeredLevel *level);
void lth_staggered_level_free(LitheCtx *ctx, LthStaggeredLevel *level);

/// Keep rows of samples that are alike once.
LitheStatus lth_staggered_level_pack(LitheCtx *ctx, LthStaggeredLevel *level);
static inline bool lth_staggered_level_is_packed(const LthStaggeredLevel *level) {
  return level->n_rows < level->grid->n_slots / level->grid->side;
}

LitheCount lth_staggered_level_bytes(const LthStaggeredLevel *level);
