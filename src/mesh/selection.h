/// `where`: what constraints and loads act on, as a tree, and the boundary pieces it selects.
#pragma once

#include "geometry/shape.h"
#include "mesh/mesh.h"

typedef enum LthWhereKind {
  LTH_WHERE_ALL,
  LTH_WHERE_SHAPE,  ///< closed set, tolerance 1e-9 of the body's size; a box divides faces exactly
  LTH_WHERE_PLANE,  ///< half space that `normal` points into; divides faces exactly
  LTH_WHERE_NORMAL, ///< boundary whose outward normal is within `angle` of `normal`
  LTH_WHERE_FACE, ///< patch around the boundary point nearest to `point`, grown while normals turn
                  ///< by less than `angle` from face to face
  LTH_WHERE_LABEL,
  LTH_WHERE_NOT, ///< children[0]
  LTH_WHERE_AND,
  LTH_WHERE_OR
} LthWhereKind;

typedef struct LthWhere LthWhere;
struct LthWhere {
  LthWhereKind kind;
  LthShape shape;
  double point[3], normal[3]; ///< [m], unit
  double angle;               ///< [rad]
  char *label;                ///< name or number of a group of the mesh, owned
  LthWhere *children;
  LitheIndex n_children;
};

void lth_where_free(LitheCtx *ctx, LthWhere *where); ///< frees children, not the struct itself

/// Pieces of the boundary: whole faces or parts of them, as loops of their own points.
typedef struct LthPatches {
  LitheIndex n, n_points;
  LitheIndex *face;        ///< boundary face of the mesh each piece lies in       (n)
  LitheIndex *loop_off_of; ///< (n + 1) loops of a piece
  LitheIndex *loop_off;    ///< (n_loops + 1)
  LitheIndex *loop_point;  ///< into points
  double *points;          ///< (n_points x 3)
  double *area;            ///< (n)
  double *centroid;        ///< (n x 3)
} LthPatches;

void lth_patches_destroy(LitheCtx *ctx, LthPatches **patches);

/// The loops of piece i; normal is that of its face.
LthFaceView lth_patches_view(const LthMesh *mesh, const LthPatches *patches, LitheIndex i);

/// Select boundary pieces; faces that a cut opened are none (LTH_TAG_CUT). An empty selection is not an error here (n = 0); the scene says so.
LitheStatus lth_select_boundary(LitheCtx *ctx, const LthMesh *mesh, const LthWhere *where,
                                LthPatches **patches);

/// True for every cell whose centroid `where` contains, or that touches selected boundary (for strong
/// and interior constraints). `chosen` is n_cells bytes, set to 0 or 1. LTH_WHERE_NORMAL and LTH_WHERE_FACE
/// know the boundary only: inside, neither they nor their negation select anything by themselves.
LitheStatus lth_select_cells(LitheCtx *ctx, const LthMesh *mesh, const LthWhere *where,
                             uint8_t *chosen);

/// True for every cell that owns a face with a selected piece (for strong constraints on the boundary).
void lth_patches_cells(const LthMesh *mesh, const LthPatches *patches, uint8_t *chosen);

/// A quadrature rule over a piece, exact for polynomials of degree `degree`: triangles of a signed fan.
/// Points (n x 3), weights (n) [m^2, may be negative on non-convex pieces]. Caller frees both.
LitheStatus lth_patch_quadrature(LitheCtx *ctx, const LthFaceView *piece, int degree, LitheIndex *n,
                                 double **points, double **weights);
