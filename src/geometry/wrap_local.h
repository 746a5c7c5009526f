/// Inside tests of a wrapped surface at many places of a small ball.
#pragma once

#include "geometry/wrap.h"

#define LTH_WRAP_LOCAL_TRIS 48

/// One winding number, and the triangles at which it changes within the ball.
typedef struct LthWrapLocal {
  const LthWrapMap *map;
  double center[3];
  int n;
  LitheIndex tri[LTH_WRAP_LOCAL_TRIS];
  const LthWindingNear *near; ///< numbers in the ball where it is not sure; NULL: by the map
  int number;                 ///< at the centre, where it is nearly whole
  bool
      is_sure; ///< it is nearly whole in all of the ball but for jumps, and all triangles are listed
} LthWrapLocal;

void lth_wrap_local_find(const LthWrapMap *map, const double center[3], double radius,
                         LthWrapLocal *local);

/// Is x, within the ball, inside? By the triangles between it and the centre, or else by the map.
bool lth_wrap_local_inside(const LthWrapLocal *local, const double x[3]);

/// Share of a box center +- half that is inside: by a plane where the surface is about one there, else by places. `larger`:
/// numbers in a box that this one is in, or NULL.
double lth_wrap_local_share(const LthWrapMap *map, const LthWindingNear *larger,
                            const double center[3], const double half[3]);

/// Share of the n^3 midpoints of a box that are inside.
double lth_wrap_local_samples(const LthWrapMap *map, const LthWindingNear *larger,
                              const double center[3], const double half[3], int n);
