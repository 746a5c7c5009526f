/// Numbers of a scene: plain, constant expressions with a unit behind, expressions of place and time.
#pragma once

#include "scene/expression.h"
#include "scene/report.h"
#include "scene/unit.h"

/// An expression of a scene and where it stands.
typedef struct LthSceneExpression {
  LthExpression *expression; ///< owned
  const char *place;  ///< "scene.yaml:3:5: bodies.0.loads.0.traction.0"; in the scene's arena
  const char *text;   ///< as shown in messages; there too
  bool may_have_gaps; ///< implicit shapes: what is undefined is outside
} LthSceneExpression;

/// Expressions behind the values of a scene; freed together.
typedef struct LthExpressionList {
  LthSceneExpression *items;
  LitheCount n, cap;
} LthExpressionList;

/// LITHE_BAD_INPUT where an expression came out infinite or undefined so far: the message names it, the
/// place and the time.
LitheStatus lth_expression_list_check(LitheCtx *ctx, const LthExpressionList *list);

/// The expression behind `value` (if it is one) may be undefined somewhere.
void lth_expression_list_allow_gaps(LthExpressionList *list, const LthValue *value);

void lth_expression_list_free(LitheCtx *ctx, LthExpressionList *list);

/// What a number has to be.
typedef struct LthQuantity {
  LthUnit unit;          ///< its dimension; the angle's is rad
  const char *unit_name; ///< for messages
  int may_use;           ///< variables it may vary with (LTH_USES_...)
} LthQuantity;

/// Parse a scalar node into node->value (SI). What is wrong goes into `report`; false where nothing came
/// of it. A failure is memory only.
LitheStatus lth_quantity_parse(LitheCtx *ctx, LthReport *report, LthExpressionList *list,
                               LthNode *node, const LthQuantity *quantity, bool *is_good);

/// Where the unit of "2*3 mm" begins; the length of the text where there is none.
size_t lth_quantity_split(const char *text);
