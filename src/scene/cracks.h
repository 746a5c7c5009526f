/// Cuts that end inside a connected part of a body: where its surface divides along them, and which triangles look at each other
/// across them.
#pragma once

#include "embed/contact.h"
#include "mesh/mesh.h"

/// A boundary point of the mesh as a cell sees it: cells that hang together around the point see the same one.
typedef struct LthCrackCorner {
  LitheIndex point, cell;
} LthCrackCorner;

typedef struct LthCracks {
  const LthMesh *mesh;
  double *fronts; ///< both ends of each edge at which a cut ends             (n_fronts x 6)
  LitheIndex n_fronts;
  LthCrackCorner *corner; ///< sorted                                  (n_corners)
  LitheIndex *fan;        ///< sets of corners                         (n_corners)
  LitheIndex n_corners,
      *sheet; ///< of each face: connected faces of one side of a cut, -1 (n_faces)
} LthCracks;

/// How many edges there are at which a cut ends inside.
LitheStatus lth_cracks_count(LitheCtx *ctx, const LthMesh *mesh, LitheIndex *n_fronts);

/// Find cracks; n_fronts is 0, and nothing else there, where no cut ends inside. `stands_for`: boundary points that are contracted
/// into one are one (n_points).
LitheStatus lth_cracks_find(LitheCtx *ctx, const LthMesh *mesh, const LitheIndex *stands_for,
                            LthCracks *cracks);
void lth_cracks_free(LitheCtx *ctx, LthCracks *cracks);

/// Number of a boundary point as a cell sees it, below n_corners.
LitheIndex lth_cracks_corner(const LthCracks *cracks, LitheIndex point, LitheIndex cell);

/// The sides of cracks on the surface of a part at rest, whose tri_poly are faces of the mesh. All NULL, where the part has none.
LitheStatus lth_cracks_find_sides(LitheCtx *ctx, const LthCracks *cracks, const LthSurface *surface,
                                  LthCrackSides *sides);
void lth_crack_sides_free(LitheCtx *ctx, LthCrackSides *sides);
