/// Where held sides begin between unknowns, on all levels of a staggered grid: docs/theory/staggered-multigrid.md, section 1.
#pragma once

#include "disc/staggered/staggered_level.h"

#define LTH_WALL_WAYS 9
#define LTH_WALL_SHORTEST 0.05 // share of a way that counts at least: bounds the stiffness

/// Shares, of the way from a free unknown to a held one, that are free, for differences which the samples of a slot read;
/// 0: no difference of the two kinds, or all of the way. Component a along itself, in the cell: way[a]. Of the edge along axis e:
/// component e + 1 along e + 2 (mod 3) way[3 + 2 e], the other way round way[4 + 2 e].
typedef struct LthStaggeredWall {
  LitheCount slot;
  float way[LTH_WALL_WAYS];
} LthStaggeredWall;

struct LthStaggeredWalls {
  LitheIndex *first;    ///< of a block; ascending by slot                 (n_blocks + 1)
  LthStaggeredWall *at; ///<                                               (first[n_blocks])
};

/// Differences of one sample that a wall cuts.
typedef struct LthWallCuts {
  int n;
  double once, twice; ///< sums of 1 / way and of its square
} LthWallCuts;

static inline void lth_wall_cut(LthWallCuts *c, double way) {
  c->n++;
  c->once += 1 / way;
  c->twice += 1 / (way * way);
}

/// Factor on the weight of a sample: d^2 / way and d / way of each difference d are energy and stress.
static inline double lth_wall_factor(const LthWallCuts *c) {
  return c->n > 0 ? c->twice / c->once : 1;
}

/// Room for a wall in every slot with a difference between a free unknown and one that is not; none if there are none.
LitheStatus lth_staggered_walls_create(LitheCtx *ctx, const LthStaggeredLevel *level,
                                       LthStaggeredWalls **walls);
void lth_staggered_walls_destroy(LitheCtx *ctx, LthStaggeredWalls **walls);
LitheCount lth_staggered_walls_bytes(const LthSparseGrid *grid, const LthStaggeredWalls *walls);

/// What the wall at a slot does to its cell (`edge` -1) or to the edge along an axis.
LthWallCuts lth_staggered_wall_cuts(const LthStaggeredLevel *level, LitheCount slot, int edge);

/// Share of the way between two neighbours of component a along b, one free and one held, that is free.
double lth_staggered_wall_way(const LthStaggeredLevel *level, int a, int b,
                              const LitheIndex from[3], const LitheIndex to[3]);

/// How far a free unknown is before the plane that cuts the axes where walls do, in cells; 0: no wall is near.
double lth_staggered_wall_distance(const LthStaggeredLevel *level, int a, const LitheIndex cell[3]);

/// Walls of a coarse level, whose weights are those of no wall so far and whose states are set, from those of the finer one.
LitheStatus lth_staggered_walls_coarsen(LitheCtx *ctx, const LthStaggeredLevel *fine,
                                        LthStaggeredLevel *coarse);
