/// Expressions of x, y, z, t: compiled once by muParser, evaluated from any thread.
#pragma once

#include "base/ctx.h"
#include "base/value.h"
#include "geometry/image.h"

/// What an expression depends on, as bits.
enum {
  LTH_USES_X = 1,
  LTH_USES_Y = 2,
  LTH_USES_Z = 4,
  LTH_USES_T = 8,
  LTH_USES_VALUE = 16, ///< of an image
  LTH_USES_LABEL = 32,
  LTH_USES_XYZ = 7,
  LTH_USES_IMAGE = 48
};

typedef struct LthExpression LthExpression;

typedef struct LthExpressionError {
  int column;     ///< from 1, inside the expression; 0: none
  char text[200]; ///< "unknown name \"foo\""
} LthExpressionError;

/// Compile `length` bytes of text; decimal points and functions do not depend on the locale. `log` is the
/// natural logarithm, `^` the power (right to left), `c ? a : b` a choice. On LITHE_BAD_INPUT `error`
/// says what is wrong where.
LitheStatus lth_expression_create(LitheCtx *ctx, const char *text, size_t length,
                                  LthExpressionError *error, LthExpression **expression);
void lth_expression_destroy(LitheCtx *ctx, LthExpression **expression);

/// Bits of the variables it uses; 0: a constant.
int lth_expression_uses(const LthExpression *expression);

/// What `value` and `label` mean from now on; both are 0 before. The image is borrowed for life.
void lth_expression_bind(LthExpression *expression, const LthImage *image);

/// Multiply all values (a unit behind the expression).
void lth_expression_scale(LthExpression *expression, double factor);

/// The value at x, t; NaN where it is not defined. Fits LthValue.eval with `self` an LthExpression.
/// Threads do not wait for each other unless there are more than compiled copies.
double lth_expression_eval(const void *self, const double x[3], double t);

/// Where a value was infinite or undefined.
typedef struct LthExpressionGap {
  double x[3], t, value;
} LthExpressionGap;

/// The earliest such place among all evaluations so far (at equal times the smallest x, y, z, so that it
/// does not depend on the threads); false where every value was finite.
bool lth_expression_gap(const LthExpression *expression, LthExpressionGap *gap);
