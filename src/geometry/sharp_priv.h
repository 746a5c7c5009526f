/// The parts of a sharp surface while it is made.
///   sharp_lattice.c  where the lattice lies
///   sharp_cell.c     pieces in one tetrahedron
///   sharp_march.c    all tetrahedra that the boundary may cross, one layer after the other
///   sharp_place.c    points onto the true surfaces
///   sharp_separate.c parts that touch come apart; is it closed?
///   sharp_surface.c  the order of these
#pragma once

#include "base/hash.h"
#include "geometry/polygon.h"
#include "geometry/sharp_cell.h"
#include "geometry/sharp_surface.h"

/// Where a point comes from: one to three fields are zero in a simplex of as many corners and one more.
typedef struct LthSharpPoint {
  LitheIndex corner[3]; ///< the simplex' lowest lattice point
  int n, step[3];       ///< fields; other corners as bit masks of axes from the lowest, rising
  LitheIndex field[3];  ///< rising
} LthSharpPoint;

typedef struct LthSharp {
  LitheCtx *ctx;
  const LthSolid *solid;
  double origin[3], h;
  LitheIndex n[3];    ///< lattice points per axis
  LitheIndex n_words; ///< of 64 bits, for one bit of each field
  uint64_t *negative
      [2];     ///< which fields are negative at the points of two layers (n[0] n[1] n_words each)
  bool is_bad; ///< some tetrahedron has no consistent surface

  LthHash hash;          ///< simplex and fields -> point
  LthSharpPoint *source; ///< (n_points)
  double *points;        ///< (n_points x 3)
  LitheIndex *tris;      ///< (n_tris x 3)
  LitheIndex *
      group; ///< first triangle and the one after the last of tetrahedra where fields meet (n_groups x 2)
  LitheIndex n_points, n_tris, n_groups;
  LitheCount source_cap, points_cap, tris_cap, group_cap;
} LthSharp;

static inline void lth_sharp_place(const LthSharp *s, const LitheIndex at[3], double x[3]) {
  for (int a = 0; a < 3; a++) x[a] = s->origin[a] + s->h * at[a];
}

/// Lay the lattice so that planes across axes, and the edges in which these meet, keep away from its own planes.
/// `attempt` 0, 1 ... gives different ones.
LitheStatus lth_sharp_lay_out(LthSharp *s, const double min[3], const double max[3],
                              double resolution, int attempt);

LitheStatus lth_sharp_march(LthSharp *s);

/// Move points onto the true surface where they stay in their simplex and no triangles come to cross.
/// *is_good: none cross where they were, either. What is in one tetrahedron stays there, so that others need not be asked.
LitheStatus lth_sharp_move(LthSharp *s, bool *is_good);

/// Copies of points for parts that touch but are no neighbours, so that every edge has two triangles and every point
/// one fan of them. *is_closed is false where some triangle has no neighbour.
LitheStatus lth_sharp_separate(LthSharp *s, bool *is_closed);
