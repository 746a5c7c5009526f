/// What a staggered body has beside its discretisation: fractions, holds, material field, loads.
#pragma once

#include "disc/staggered/staggered.h"
#include "geometry/shape_foot.h"
#include "mesh/where_place.h"
#include "scene/body.h"

/// What a hold's selection looks at: a constraint, and for rollers one direction of an axis.
typedef struct LthHoldPlace {
  const LthBody *body;
  const LthWhereSolid *where;
  bool is_roller;
  const uint8_t *is_oblique; ///< of a roller: only where it is along an axis
  int axis;
  double sign;
  LthValue value; ///< of a roller against the axis
} LthHoldPlace;

/// A constraint of a body: what a roller that is not along an axis looks at.
typedef struct LthRollerPlace {
  const LthBody *body;
  const LthWhereSolid *where;
} LthRollerPlace;

struct LthStaggeredBody {
  LthFractions *fractions; ///< sides that are held are full once constraints are built
  LthFractions own;        ///< as the shape has them, where constraints made parts full; else empty
  double volume;           ///< of the shape, as its fractions have it [m^3]
  double h, diagonal;      ///< shortest edge of a cell and its diagonal [m]
  float *filled;           ///< fraction of each cell before held sides were made full  (n_slots)

  LthWhereSolid *constraint_where, *material_where, *load_where;
  LitheIndex n_constraints, n_materials, n_loads; ///< of these, so far
  LthStaggeredHold *holds;
  LthHoldPlace *hold_place;
  LitheIndex *hold_of; ///< scene constraint behind each hold              (n_holds)
  LitheIndex n_holds;
  uint8_t *is_oblique;         ///< per constraint: a roller, and not along an axis everywhere
  LthStaggeredRoller *rollers; ///< where that is so; `weak_of` of the body says whose  (n_rollers)
  LthRollerPlace *roller_place;
  LitheIndex n_rollers;
  LthFormulation formulation; ///< known once the material field is built
};

/// Grid and fractions (build_staggered.c): what a mesh is to others. Sets box, size and cell size.
LitheStatus lth_build_fractions(LitheCtx *ctx, LthBody *body);

/// Mixed from a Poisson's ratio of 0.45 on, unless the scene says.
LthFormulation lth_body_formulation(const LthBody *body);

/// Constraints, material, discretisation and loads.
LitheStatus lth_build_staggered(LitheCtx *ctx, LthBody *body);
void lth_staggered_body_destroy(LitheCtx *ctx, LthStaggeredBody **body);

/// Smooth fractions at flat sides that rollers hold become those of the solid and its mirror image (build_mirror.c).
LitheStatus lth_staggered_mirror_sides(LitheCtx *ctx, LthBody *body);

/// Its parts: holds with their full sides (build_hold.c), the material field (build_field.c), loads
/// (build_grid_load.c).
LitheStatus lth_staggered_hold_sides(LitheCtx *ctx, LthBody *body);
LitheStatus lth_staggered_check_holds(LitheCtx *ctx,
                                      const LthBody *body); ///< each constraint holds something
LitheStatus lth_build_field(LitheCtx *ctx, LthBody *body, LthMaterialField *field);
LitheStatus lth_staggered_check_field(LitheCtx *ctx, const LthBody *body);
LitheStatus lth_build_grid_loads(LitheCtx *ctx, LthBody *body);

/// All cells that touch x are full: it cannot be on the boundary.
bool lth_staggered_is_deep(const LthStaggeredBody *s, const double x[3]);

/// The first material entry that holds a place, -1 where none does. Places outside of the body have what its nearest one has.
LitheIndex lth_field_entry(const LthBody *body, const double x[3]);
double lth_field_density(const LthBody *body, const double x[3]); ///< [kg/m^3]

/// Make a `where` of the scene ready for this body. `all_inside`: `all` means the inside too.
LitheStatus lth_staggered_where(LitheCtx *ctx, const LthBody *body, const LthWhere *where,
                                bool all_inside, LthWhereSolid *ready);

/// A point of the boundary as a place.
static inline LthPlace lth_place_at_boundary(const double x[3], const double n[3]) {
  return (LthPlace){.x = {x[0], x[1], x[2]},
                    .is_boundary = true,
                    .point = {x[0], x[1], x[2]},
                    .normal = {n[0], n[1], n[2]}};
}

/// The place as one of the boundary: false where x is inside the solid or far from it. `depth` [m]: so far inside
/// still counts.
bool lth_staggered_boundary_place(const LthBody *body, const double x[3], double depth,
                                  LthPlace *place);

/// Centre of a cell of the discretisation [m], its volume of material [m^3] and its fraction as the shape fills it.
void lth_staggered_cell(const LthBody *body, LitheIndex cell, double center[3], double *volume,
                        double *fraction);
