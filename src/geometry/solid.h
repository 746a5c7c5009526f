/// Solids as formulas: a shape's tree of unions and intersections of half spaces f < 0 of smooth functions.
#pragma once

#include "geometry/shape.h"

typedef enum LthFieldKind {
  LTH_FIELD_PLANE,  ///< normal . (x - at)
  LTH_FIELD_BALL,   ///< |x - at| - radius
  LTH_FIELD_ROUND,  ///< distance from the line at + s normal, less radius
  LTH_FIELD_VALUE,  ///< lth_shape_value() of a shape that is not taken apart
  LTH_FIELD_FORMULA ///< value of an implicit shape, without its box
} LthFieldKind;

/// A function that is smooth but for what shapes that are not taken apart have of edges of their own.
typedef struct LthField {
  LthFieldKind kind;
  double at[3], normal[3], radius; ///< `normal` is a unit vector
  int axis;                        ///< PLANE: the axis that it is across, -1 none
  const LthShape *shape;           ///< VALUE, FORMULA
} LthField;

/// sign times a field's side, or times that of the children joined.
typedef struct LthSolidNode {
  LitheIndex field; ///< -1: children
  int sign;
  bool is_union;
  LitheIndex child, next; ///< first child, next sibling, -1 none
} LthSolidNode;

/// Node 0 is the root. Planes, balls and round sides that coincide are one field.
typedef struct LthSolid {
  LthField *field;
  LthSolidNode *node;
  LitheIndex n_fields, n_nodes;
  LitheCount field_cap, node_cap;
  double rounding; ///< how near two places are the same [m]
} LthSolid;

/// Sides of a field in some region: -1 where it is negative, 1 where not, 0: both.
typedef int8_t LthFieldSide;

/// `shape` is borrowed for life. LITHE_BAD_INPUT: a shape of plane scenes.
LitheStatus lth_solid_create(LitheCtx *ctx, const LthShape *shape, LthSolid **solid);
void lth_solid_destroy(LitheCtx *ctx, LthSolid **solid);

/// Always finite. Thread-safe.
double lth_field_value(const LthField *field, const double x[3]);

/// Is the region inside (-1), outside (1), or is that not known (0) from the fields' sides?
LthFieldSide lth_solid_side(const LthSolid *solid, const LthFieldSide *side);

/// Fields whose side is 0 and may matter, in rising order; the number of them, at most `cap` of which are told.
LitheIndex lth_solid_undecided(const LthSolid *solid, const LthFieldSide *side, LitheIndex cap,
                               LitheIndex *field);
