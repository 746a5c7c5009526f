/// A `where` tree made ready for one mesh: tolerance, cutting planes, surface patches.
#pragma once

#include "mesh/piece.h"
#include "mesh/selection.h"

/// Members of one LTH_WHERE_FACE or LTH_WHERE_LABEL node.
typedef struct LthFacePatch {
  const LthWhere *node;
  uint8_t
      *member; ///< faces (n_faces); of a label: NULL where no group of boundary faces has the name
  uint8_t *cell; ///< cells of a label (n_cells), NULL where no group of cells has the name
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

/// LITHE_BAD_INPUT: a label that no group of the mesh has. Free with lth_where_ready_free(), also after a failure.
LitheStatus lth_where_prepare(LitheCtx *ctx, const LthMesh *mesh, const LthWhere *where,
                              LthWhereReady *ready);
void lth_where_ready_free(LitheCtx *ctx, LthWhereReady *ready);

/// Fill a patch with the group that a label names: exactly, else but for upper and lower case, else by its number.
LitheStatus lth_mesh_label(LitheCtx *ctx, const LthMesh *mesh, const char *label,
                           LthFacePatch *patch);

/// Does the tree contain this point? `face` is the boundary face it lies on, or -1 inside the body, where
/// what only the boundary can answer counts as no, also under `not`.
bool lth_where_contains(const LthWhereReady *ready, const double x[3], LitheIndex face);

/// The same for a cell of the mesh: its centroid, and the groups of cells that it belongs to.
bool lth_where_contains_cell(const LthWhereReady *ready, LitheIndex cell);
