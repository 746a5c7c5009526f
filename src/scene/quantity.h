/// Numbers of a scene: plain, constant expressions with a unit behind, expressions of place and time.
#pragma once

#include "scene/expression.h"
#include "scene/report.h"
#include "scene/unit.h"

/// Expressions behind the values of a scene; freed together.
typedef struct LthExpressionList {
  LthExpression **items;
  LitheCount n, cap;
} LthExpressionList;

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
