/// The boundary curve of a plane shape as points on a lattice's edges, and patches that grow along it.
#pragma once

#include "geometry/shape.h"

/// Where the curve crosses the edges of a lattice: neighbours on the curve share a cell of the lattice.
typedef struct LthCurve {
  double origin[2], step; ///< of the lattice [m]
  int64_t columns;
  LitheIndex n;
  int64_t *edge;  ///< 2 (row * columns + column) + axis, ascending   (n)
  double *point;  ///< [m]                                            (n x 2)
  double *normal; ///< unit, outward                                  (n x 2)
  LitheCount cap_edge, cap_point, cap_normal;
} LthCurve;

/// `step` [m]: what is thinner is not seen. LITHE_BAD_INPUT: far too fine, or no boundary found.
LitheStatus lth_curve_create(LitheCtx *ctx, const LthShape *shape, double step, LthCurve **curve);
void lth_curve_destroy(LitheCtx *ctx, LthCurve **curve);

/// The point of the curve that stands for a point of the boundary: the nearest of those whose normal is like its
/// own, so that the two sides of a corner are told apart; -1: none within some steps. Thread-safe.
LitheIndex lth_curve_nearest(const LthCurve *curve, const double point[3], const double normal[3]);

/// Fill `member` (n) with what is reached from there along neighbours whose normals differ by `angle` at most.
LitheStatus lth_curve_grow(LitheCtx *ctx, const LthCurve *curve, LitheIndex from, double angle,
                           uint8_t *member);
