/// Parts of the boundary that differ in what constraints hold there.
#pragma once

#include "scene/body.h"

typedef struct LthBoundaryPart {
  const LthPatches *patches; ///< owned by the body
  bool blocked[3];           ///< components that are held
  bool blocked_normal;       ///< so is the normal one (rollers)
} LthBoundaryPart;

typedef struct LthBoundaryParts {
  LthBoundaryPart *items;
  LitheCount n, cap;
} LthBoundaryParts;

/// True where a constraint prescribes all of the displacement on its boundary, and no more than that.
bool lth_holds_wholly(const LthSceneConstraint *constraint);

/// Divide the boundary that `where` selects by the weak constraints numbered in `by`: what one of them holds
/// wholly is left out, the rest comes in parts, each with the directions that are held there. The caller
/// frees parts->items with lth_free(). BAD_INPUT: `where` selects nothing at all (names `place`).
LitheStatus lth_boundary_divide(LitheCtx *ctx, LthBody *body, const char *place,
                                const LthWhere *where, LitheIndex n_by, const LitheIndex *by,
                                LthBoundaryParts *parts);
