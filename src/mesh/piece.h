/// Lists of planar polygons with holes, and cutting them by planes.
#pragma once

#include "geometry/moments.h"

/// Polygons in one or several planes; those of a piece are its loops, outer ones counter-clockwise about
/// the normal of its plane, holes clockwise. Zero-initialised it is empty and usable.
typedef struct LthPieces {
  LitheIndex n, n_loops, n_points;
  LitheIndex *piece_loop_off; ///< loops of a piece                        (n + 1)
  LitheIndex *loop_off;       ///< points of a loop                        (n_loops + 1)
  LitheIndex *loop_point;     ///< 0, 1, 2, ...: points are in loop order  (n_points)
  double *points;             ///< [m]                                     (n_points x 3)
  LitheCount cap_pieces, cap_loops, cap_index, cap_points;
} LthPieces;

void lth_pieces_free(LitheCtx *ctx, LthPieces *pieces);

/// Forget all pieces, keep the memory.
void lth_pieces_clear(LthPieces *pieces);

/// Append a copy of a face.
LitheStatus lth_pieces_add(LitheCtx *ctx, LthPieces *pieces, const LthFaceView *face);

/// A piece as a face; `normal` is borrowed.
LthFaceView lth_pieces_view(const LthPieces *pieces, LitheIndex i, const double *normal);

/// The plane (x - point) . normal = 0; `normal` is unit.
typedef struct LthPlane {
  double point[3], normal[3];
} LthPlane;

/// True where a face has points on both sides, farther than `tolerance` [m] from the plane.
bool lth_plane_crosses(const LthPlane *plane, const LthFaceView *face, double tolerance);

/// Scratch of lth_pieces_cut(), kept between calls. Zero-initialised it is usable.
typedef struct LthCutScratch {
  double *height;       ///< of each point above the plane
  double *along[2];     ///< places of the chains' starts and ends on the cut line, sorted
  LitheIndex *chain[2]; ///< the chains of these
  LitheIndex *next;     ///< chain that follows each chain
  LthPieces chains;     ///< open chains in place of loops
  LitheCount caps[6];
} LthCutScratch;

void lth_cut_scratch_free(LitheCtx *ctx, LthCutScratch *scratch);

/// Append to `out` the part of a face on one side of a plane (side +1: where its normal points; -1), as one
/// piece; nothing where no such part exists. Points within `tolerance` of the plane count as on it. Works
/// for non-convex faces with holes; both parts get the same new points.
LitheStatus lth_pieces_cut(LitheCtx *ctx, const LthFaceView *face, const LthPlane *plane,
                           double side, double tolerance, LthCutScratch *scratch, LthPieces *out);
