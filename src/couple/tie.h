/// Gluing two bodies together: by face terms where planar faces coincide, else by springs between surfaces.
/// docs/theory/ties.md.
#pragma once

#include "disc/dg/dg_operator.h"
#include "system/system.h"

/// One of the two bodies; everything is borrowed for life.
typedef struct LthTieSide {
  const char *name; ///< for messages
  const LthDisc *disc;
  const LthPatches *patches;     ///< the boundary that may be tied
  const double *young, *poisson; ///< per cell                               (n_cells of the mesh)
  const LthDgSpace *space;       ///< of a dg body, else NULL
  LthFlux flux;                  ///< of a dg body, like the next two
  LthPenaltyKind penalty;
  double eta;
  bool warped;          ///< corotated
  LitheIndex first_row; ///< of the body in the system
  LitheCount first_dof;
} LthTieSide;

typedef struct LthTieDef {
  const char *place; ///< "scene.yaml:8:3: tie.0", for messages
  LthTieSide side[2];
  bool may_be_empty; ///< having nothing in common is no error: then nothing is coupled
} LthTieDef;

/// What was found in common, and what it adds to the system.
typedef struct LthTie {
  LitheIndex n_faces, n_springs;
  double face_area, spring_area; ///< [m^2]
  LthTieSide side[2];
  uint8_t *tied[2]; ///< per piece of each side's patches: in the tie
  LthCoupling coupling[2];
  LitheIndex n_couplings; ///< faces, springs, or both
} LthTie;

/// LITHE_BAD_INPUT where the two have nothing in common; the message has the gap between them.
LitheStatus lth_tie_create(LitheCtx *ctx, const LthTieDef *def, LthTie **tie);

/// Set marked[i] (n) to 1 for points (n x 3) [m] of a side's surface, at rest, that the tie holds.
LitheStatus lth_tie_mark(LitheCtx *ctx, const LthTie *tie, int side, LitheIndex n,
                         const double *points, uint8_t *marked);
void lth_tie_destroy(LitheCtx *ctx, LthTie **tie);
