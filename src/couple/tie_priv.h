/// The parts of a tie, shared by the files of this room.
#pragma once

#include "couple/tie.h"
#include "geometry/bvh.h"
#include "mesh/piece.h"

#include <math.h>

/// Where planar boundary pieces of two bodies coincide.
typedef struct LthOverlap {
  LthPieces pieces;  ///< in the plane of the first body's face, about its normal
  LitheIndex *patch; ///< piece of each body's patches                        (n x 2)
  LitheCount patch_cap;
} LthOverlap;

void lth_overlap_free(LitheCtx *ctx, LthOverlap *overlap);

/// Find all of it. `tied` of both sides is set to 1 where a piece has a part in it.
LitheStatus lth_overlap_find(LitheCtx *ctx, const LthTieDef *def, LthOverlap *overlap,
                             uint8_t *const tied[2]);

/// Append the convex parts of a face to `out`.
LitheStatus lth_convex_parts(LitheCtx *ctx, const LthFaceView *face, double tolerance,
                             LthPieces *out);

/// A tree over the boxes of all pieces of a side's patches.
LitheStatus lth_patches_tree(LitheCtx *ctx, const LthPatches *patches, LthBvh **tree);

#define LTH_TIE_REACH 0.25 ///< of the smaller cell: farther surfaces are not tied

static inline double lth_tie_reach(const LthTieSide side[2]) {
  return LTH_TIE_REACH * fmin(side[0].disc->mesh->cell_size, side[1].disc->mesh->cell_size);
}

/// Cell of piece i of a side.
static inline LitheIndex lth_tie_cell(const LthTieSide *side, LitheIndex i) {
  return side->disc->mesh->face_cell[2 * side->patches->face[i]];
}

/// Blocks of a small matrix whose rows are some rows of the system.
typedef struct LthTieMatrix {
  LthBlockMatrix *K;
  LitheIndex *row;   ///< of the system                                      (K->n_rows)
  LitheCount *dof;   ///< first unknown of it                                (K->n_rows)
  LitheIndex *pairs; ///< (n_pairs x 2)
  LitheIndex n_pairs;
} LthTieMatrix;

/// List the pairs of a matrix and set them in a coupling.
LitheStatus lth_tie_matrix_list(LitheCtx *ctx, LthTieMatrix *m, LthCoupling *coupling);
void lth_tie_matrix_add(const LthTieMatrix *m, LthBlockMatrix *A); ///< A += K
void lth_tie_matrix_free(LitheCtx *ctx, LthTieMatrix *m);

/// Face terms of discontinuous elements on an overlap.
LitheStatus lth_tie_faces_create(LitheCtx *ctx, const LthTieDef *def, const LthOverlap *overlap,
                                 LthTie *tie, LthCoupling *coupling);

/// Springs on pieces that are not tied yet; none found leaves `coupling` without `self`. `gap` becomes the
/// smallest distance that was seen [m], `reach` the one up to which pieces are tied.
LitheStatus lth_tie_springs_create(LitheCtx *ctx, const LthTieDef *def, LthTie *tie,
                                   LthCoupling *coupling, double *gap, double *reach);
