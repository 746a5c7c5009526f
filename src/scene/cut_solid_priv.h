/// A cut of a solid that is not the body, in progress.
#pragma once

#include "embed/around.h"
#include "embed/cell_search.h"
#include "scene/change.h"
#include "scene/cut_surface.h"

#include "base/hash.h"

#define LTH_NOT_LOOKED_FOR (-2)

/// What the solid is divided along: a new cut face of the body, or an edge in which the new cut ends with a plane in
/// which it lies.
typedef struct LthCutSide {
  double plane[4]; ///< unit normal, the same from both sides, and height, to tell planes apart
  double point[3], box[6];
  LitheIndex face; ///< of the body's topology, -1: an edge
  LitheIndex order;
} LthCutSide;

typedef struct LthCutSolid {
  const LthBody *body;
  LthCutSurface *c;
  const LthTopology *body_t;
  LthTopology *t;
  const LthMesh *mesh; ///< of the body, that to come
  const LitheIndex *cell_record;
  LitheIndex *place; ///< cell of the mesh of each record, -1                (body_t->n_cells)
  LthCellSearch *search;
  LthAround around;
  LthCutSide *sides; ///< those in one plane together
  LitheIndex n_sides;
  LitheCount sides_cap;
  LthHash
      pairs; ///< two elements of the body that a new cut has parted -> tag, as LTH_TAG_CUT - tag
  LitheIndex *
      beside; ///< element nearest to a cell of the solid beside the body, -1: inside, or not looked for
  LitheIndex n_beside;
  LitheCount beside_cap;
} LthCutSolid;

// cut_solid_faces.c

/// List the new cut faces of the body, the pairs of elements that they part, and where the cut ends.
LitheStatus lth_cut_solid_find_sides(LitheCtx *ctx, LthCutSolid *s);

/// Part the faces of the divided solid that lie on new cuts of the body.
LitheStatus lth_cut_solid_part(LitheCtx *ctx, LthCutSolid *s);
