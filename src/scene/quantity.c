/// Splitting off the unit, checking its dimension, evaluating what is constant.
#include "scene/quantity.h"

#include "io/text.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

void lth_expression_list_free(LitheCtx *ctx, LthExpressionList *list) {
  for (LitheCount i = 0; i < list->n; i++) lth_expression_destroy(ctx, &list->items[i].expression);
  lth_free(ctx, list->items);
  *list = (LthExpressionList){0};
}

static bool is_letter(char c) { return isalpha((unsigned char)c) || (unsigned char)c >= 0x80; }

/// Behind a number: digits, a point, an exponent.
static size_t number_end(const char *text, size_t i) {
  while (isdigit((unsigned char)text[i])) i++;
  if (text[i] == '.') i++;
  while (isdigit((unsigned char)text[i])) i++;
  if (text[i] == 'e' || text[i] == 'E') {
    size_t k = i + 1;
    if (text[k] == '+' || text[k] == '-') k++;
    if (isdigit((unsigned char)text[k])) {
      while (isdigit((unsigned char)text[k])) k++;
      return k;
    }
  }
  return i;
}

/// No expression has two operands without an operator between them, so the first such place is where
/// the unit begins: "2*3 mm", "50kPa", "(1+2) 1/s".
size_t lth_quantity_split(const char *text) {
  size_t i = 0, length = strlen(text);
  bool after_operand = false;
  while (i < length) {
    if (isspace((unsigned char)text[i])) {
      i++;
    } else if (isdigit((unsigned char)text[i]) || text[i] == '.') {
      if (after_operand) return i;
      i = number_end(text, i);
      after_operand = true;
    } else if (is_letter(text[i]) || text[i] == '_') {
      if (after_operand) return i;
      while (is_letter(text[i]) || isdigit((unsigned char)text[i]) || text[i] == '_') i++;
      after_operand = true;
    } else {
      after_operand = text[i] == ')';
      i++;
    }
  }
  return length;
}

/// A plain decimal number, whatever the locale; false where it is anything else.
static bool parse_plain(const char *text, size_t length, double *value) {
  size_t start = text[0] == '-' || text[0] == '+';
  bool has_digit = isdigit((unsigned char)text[start]) ||
                   (text[start] == '.' && isdigit((unsigned char)text[start + 1]));
  if (!has_digit || number_end(text, start) != length) return false;
  bool is_number = lth_word_number((LthWord){text + start, length - start}, value);
  if (text[0] == '-') *value = -*value;
  return is_number && isfinite(*value);
}

typedef struct Parts {
  const char *text;
  size_t head; ///< length of the expression, without the spaces behind
  const char *tail;
} Parts;

static Parts split(const char *text) {
  Parts p = {.text = text};
  size_t cut = lth_quantity_split(text);
  p.tail = text + cut;
  while (cut > 0 && isspace((unsigned char)text[cut - 1])) cut--;
  p.head = cut;
  return p;
}

static bool check_unit(LthReport *report, LthNode *node, const LthQuantity *quantity,
                       const char *tail, LthUnit *unit) {
  const char *bad = NULL;
  size_t bad_length = 0;
  char name[24] = "";
  const char *shown = lth_show(report->arena, node);
  if (!lth_unit_parse(tail, unit, &bad, &bad_length)) {
    snprintf(name, sizeof name, "%.*s", (int)(bad_length < 20 ? bad_length : 20), bad);
    const char *nearest = lth_unit_nearest(name);
    if (nearest)
      lth_report(report, node, "unknown unit \"%s\", got %s; did you mean %s?", name, shown,
                 nearest);
    else
      lth_report(
          report, node,
          "unknown unit \"%s\", got %s; expected a unit such as mm, kPa or g/cm^3, or an operator "
          "before it",
          name, shown);
    return false;
  }
  if (lth_unit_same(unit, &quantity->unit)) return true;
  bool has_none = strcmp(quantity->unit_name, "1") == 0;
  const char *got_name = lth_unit_quantity(unit), *want_name = lth_unit_quantity(&quantity->unit);
  lth_report(report, node, "wrong dimension, got %s, %s; expected %s%s%s%s", shown,
             got_name ? got_name : "another quantity", want_name ? want_name : "a number",
             has_none ? "" : " [", has_none ? "" : quantity->unit_name, has_none ? "" : "]");
  return false;
}

static const char *uses_text(int uses) {
  bool has_image = uses & LTH_USES_IMAGE, is_plane = !(uses & LTH_USES_Z);
  uses &= ~LTH_USES_IMAGE;
  if (has_image) return is_plane ? "x, y, value, label" : "x, y, z, value, label";
  if (uses == LTH_USES_T) return "t";
  if (is_plane) return uses & LTH_USES_T ? "x, y, t" : "x, y";
  return uses & LTH_USES_T ? "x, y, z, t" : "x, y, z";
}

static void report_variables(LthReport *report, LthNode *node, int may_use, int extra) {
  const char *names[6] = {"x", "y", "z", "t", "value", "label"};
  int k = 0;
  while (!(extra & (1 << k))) k++;
  const char *shown = lth_show(report->arena, node);
  if (may_use)
    lth_report(report, node, "it varies with %s, got %s; expected a number or an expression of %s",
               names[k], shown, uses_text(may_use));
  else
    lth_report(report, node, "it varies with %s, got %s; expected a constant", names[k], shown);
}

static LitheStatus keep_expression(LitheCtx *ctx, LthReport *report, LthExpressionList *list,
                                   const LthNode *node, LthExpression *e) {
  LTH_RESERVE(ctx, list->items, list->cap, list->n + 1);
  list->items[list->n++] = (LthSceneExpression){.expression = e,
                                                .place = lth_report_place(report, node),
                                                .text = lth_show(report->arena, node)};
  return LITHE_OK;
}

LitheStatus lth_expression_list_check(LitheCtx *ctx, const LthExpressionList *list) {
  for (LitheCount i = 0; i < list->n; i++) {
    const LthSceneExpression *e = &list->items[i];
    LthExpressionGap gap = {0};
    if (e->may_have_gaps || !lth_expression_gap(e->expression, &gap)) continue;
    LITHE_FAIL(ctx, LITHE_BAD_INPUT,
               "%s: %s at (%g, %g, %g), t = %g, got %s; expected a finite number", e->place,
               isnan(gap.value) ? "not a number" : "infinite", gap.x[0], gap.x[1], gap.x[2], gap.t,
               e->text);
  }
  return LITHE_OK;
}

void lth_expression_list_allow_gaps(LthExpressionList *list, const LthValue *value) {
  for (LitheCount i = 0; i < list->n; i++)
    if (value->eval && list->items[i].expression == value->self)
      list->items[i].may_have_gaps = true;
}

static LitheStatus parse_expression(LitheCtx *ctx, LthReport *report, LthExpressionList *list,
                                    LthNode *node, const LthQuantity *quantity, const Parts *p,
                                    double factor) {
  LthExpression *e = NULL;
  LthExpressionError error;
  LitheStatus status = lth_expression_create(ctx, p->text, p->head, &error, &e);
  if (status == LITHE_BAD_INPUT) {
    lth_report(
        report, node, "not a number: column %d: %s, got %s; expected a number or an expression%s%s",
        error.column, error.text, lth_show(report->arena, node), quantity->may_use ? " of " : "",
        quantity->may_use ? uses_text(quantity->may_use) : "");
    return LITHE_OK;
  }
  if (status != LITHE_OK) return status;
  lth_expression_scale(e, factor);
  int extra = lth_expression_uses(e) & ~quantity->may_use;
  if (extra) {
    report_variables(report, node, quantity->may_use, extra);
    lth_expression_destroy(ctx, &e);
    return LITHE_OK;
  }
  if (lth_expression_uses(e)) {
    status = keep_expression(ctx, report, list, node, e);
    if (status != LITHE_OK) lth_expression_destroy(ctx, &e);
    node->value = (LthValue){.eval = lth_expression_eval, .self = e};
    return status;
  }
  const double origin[3] = {0};
  node->value = lth_value_constant(lth_expression_eval(e, origin, 0));
  lth_expression_destroy(ctx, &e);
  return LITHE_OK;
}

LitheStatus lth_quantity_parse(LitheCtx *ctx, LthReport *report, LthExpressionList *list,
                               LthNode *node, const LthQuantity *quantity, bool *is_good) {
  LthUnit unit = {.factor = 1};
  Parts p = split(node->text);
  *is_good = false;
  node->has_unit = *p.tail != 0;
  if (node->has_unit && !check_unit(report, node, quantity, p.tail, &unit)) return LITHE_OK;
  double number = 0;
  node->value = (LthValue){0};
  if (parse_plain(p.text, p.head, &number))
    node->value.constant = number * unit.factor;
  else
    LITHE_TRY(parse_expression(ctx, report, list, node, quantity, &p, unit.factor));
  if (node->bad) return LITHE_OK;
  if (!node->value.eval && !isfinite(node->value.constant)) {
    lth_report(report, node, "not a finite number, got %s; expected one",
               lth_show(report->arena, node));
    return LITHE_OK;
  }
  *is_good = node->has_value = true;
  return LITHE_OK;
}
