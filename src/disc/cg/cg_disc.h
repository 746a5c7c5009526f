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

/// Mark (1) the nodes on piece i: those of a face taken as a whole, or those of the element that lie in the
/// piece. Where elements reach beyond the body: all nodes of the element. Marks of others stay. (n_funcs)
void lth_cg_patch_nodes(const LthDisc *disc, const LthPatches *patches, LitheIndex i,
                        uint8_t *node);

/// Points of the boundary, each with its share of it.
typedef struct LthTouchPoints {
  LitheIndex n;
  double *points;    ///< [m]                                                 (n x 3)
  LitheIndex *cells; ///< (n)
  double *area;      ///< positive [m^2]                                      (n)
} LthTouchPoints;

/// True where corners alone would not do: quadratic elements whose faces are the boundary. Under a uniform pressure their
/// corners carry nothing or less, and what presses on corners bends the sides out between them.
bool lth_cg_touches_by_faces(const LthDisc *disc);

/// Corners, middles of sides and middles of all boundary faces, corners alone of linear elements. A field of the
/// elements times the areas sums to its integral over the boundary, exactly where faces are planar and sides straight.
LitheStatus lth_cg_touch_points(LitheCtx *ctx, const LthDisc *disc, LthTouchPoints *points);
void lth_touch_points_free(LitheCtx *ctx, LthTouchPoints *points);

/// An empty matrix as a discretisation on these elements has it.
LitheStatus lth_cg_pattern_create(LitheCtx *ctx, const LthElementMesh *elements,
                                  LthBlockMatrix **K);
