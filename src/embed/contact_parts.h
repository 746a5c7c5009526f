/// Parts of bodies that may touch: their surfaces as they are now, and which are near each other.
#pragma once

#include "embed/contact_priv.h"

/// Where a triangle touches others: at its middle, or a little inside of a corner.
typedef struct LthSpot {
  LitheIndex tri;
  int corner; ///< 0, 1, 2, or 3: the middle
} LthSpot;

/// A connected part of a body.
typedef struct LthPart {
  int side;
  LthSurface surface; ///< the one at rest with points of its own
  LthBvh *bvh;
  const LthCrackSides *crack; ///< NULL: none
  LitheIndex first_point;     ///< among the embedded points of its side
  LitheIndex *tri_spot;       ///< first spot of each triangle, among those of its side (n_tris + 1)
  double box[6];
  double mean[3], spread; ///< velocity, and the largest about it [m/s]
  bool is_near;           ///< something else is near it: its surface is where it is now
} LthPart;

/// Points of part `mine` may touch part `other`; where they are the same, the other sides of its cracks.
typedef struct LthNearParts {
  int side; ///< of mine
  LitheIndex mine, other;
} LthNearParts;

typedef struct LthParts {
  LthPartsSide side[2];
  LthPart *part; ///< of side 0, then of side 1                              (n_parts)
  LitheIndex n_parts;
  LthSpot *spot[2]; ///< of each side, by part and triangle
  double *share[2]; ///< of the rest surface that each stands for [m^2]
  LthHold *hold[2]; ///< what each has met last
  LitheIndex n_spots[2];
  double *velocity[2]; ///< of embedded points
  LitheIndex *order;   ///< of parts along an axis                           (n_parts)
  LthNearParts *near;  ///< by side of mine, other, mine
  LitheCount near_cap;
  LitheIndex n_near;
  LitheIndex *tri; ///< triangles of a part that come near another, ascending
  LitheCount tri_cap;
  LitheIndex n_tri;
  LthHit *hit; ///< of their spots                                           (3 x tri_cap)
  LitheCount hit_cap;
} LthParts;

// contact_parts.c

/// Of the corners of its triangle.
void lth_spot_weights(const LthSpot *spot, double w[3]);

// contact_parts_near.c

/// How far apart two parts may be now and touch in the step [m].
double lth_parts_reach(const LthContact *c, const LthPart *a, const LthPart *b);

/// Boxes and velocities of all parts, from places and samples' velocities; then the list of parts near each other.
LitheStatus lth_parts_find_near(LitheCtx *ctx, LthContact *c);

/// Triangles of a part by which sides of cracks touch, into parts->tri.
LitheStatus lth_parts_find_crack_tris(LitheCtx *ctx, LthParts *parts, const LthPart *mine);

/// Triangles of a part within `reach` of a box, into parts->tri.
LitheStatus lth_parts_find_tris(LitheCtx *ctx, LthParts *parts, const LthPart *mine,
                                const double box[6], double reach);
