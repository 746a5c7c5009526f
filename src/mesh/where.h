/// A `where` tree made ready for one mesh: tolerance, cutting planes, surface patches.
#pragma once

#include "mesh/piece.h"
#include "mesh/selection.h"

/// Members of one LTH_WHERE_FACE node.
typedef struct LthFacePatch {
  const LthWhere *node;
  uint8_t *member; ///< (n_faces)
} LthFacePatch;

typedef struct LthWhereReady {
  const LthMesh *mesh;   ///< borrowed
  const LthWhere *where; ///< borrowed
  double tolerance;      ///< 1e-9 of the body's longest side [m]
  LthPlane *planes;      ///< of all boxes and half spaces
  LthFacePatch *patches;
  LitheIndex n_planes, n_patches;
  LitheCount cap_planes, cap_patches;
} LthWhereReady;

/// LITHE_UNSUPPORTED: labels. Free with lth_where_ready_free(), also after a failure.
LitheStatus lth_where_prepare(LitheCtx *ctx, const LthMesh *mesh, const LthWhere *where,
                              LthWhereReady *ready);
void lth_where_ready_free(LitheCtx *ctx, LthWhereReady *ready);

/// Does the tree contain this point? `face` is the boundary face it lies on, or -1 inside the body, where
/// what only the boundary can answer counts as no, also under `not`.
bool lth_where_contains(const LthWhereReady *ready, const double x[3], LitheIndex face);
