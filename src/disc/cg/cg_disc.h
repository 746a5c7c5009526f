/// The conforming discretisation: isoparametric elements, linear or corotated, behind the table of LthDisc.
#pragma once

#include "disc/disc.h"
#include "mesh/element_mesh.h"

typedef struct LthCgDef {
  const LthElementMesh *elements; ///< borrowed for life; every node belongs to an element
  const LthMesh *mesh;            ///< polyhedra, borrowed for life
  /// Element of each cell (borrowed for life); NULL: cell k is element k. Where it is given, elements reach
  /// beyond the body and count by what the cells fill of them.
  const LitheIndex *cell_element;
  const double *young, *poisson, *density; ///< per cell                    (n_cells)
  bool warped;                             ///< corotated
  const LthWeakConstraint *weak;           ///< copied; the patches are borrowed
  LitheIndex n_weak;
} LthCgDef;

/// Function i is node i of the elements, row i of the matrix too. Integrates all that does not change.
LitheStatus lth_cg_disc_create(LitheCtx *ctx, const LthCgDef *def, LthDisc **disc);

/// Mark (1) the nodes on patches: those of faces taken as a whole, and those of other faces that lie in the
/// pieces. Where elements reach beyond the body: all nodes of the elements that the patches touch. Marks of
/// others stay. `node` (n_funcs).
void lth_cg_patches_nodes(const LthDisc *disc, const LthPatches *patches, uint8_t *node);
