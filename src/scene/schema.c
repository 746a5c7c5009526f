/// Walking a document and its schema together.
#include "scene/schema.h"

#include "scene/schema_text.h"
#include "scene/yaml.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/// What a place hands down to the numbers in it.
typedef struct Inherited {
  const char *unit;
  int may_use;
} Inherited;

static LitheStatus check(const LthSchema *s, LthNode *node, const LthNode *rule, Inherited from);

LitheStatus lth_schema_create(LitheCtx *ctx, LthReport *report, LthExpressionList *expressions,
                              LthSchema *schema) {
  *schema = (LthSchema){ctx, report, expressions, NULL, 3};
  schema->root = lth_yaml_parse(report, lth_scene_schema, lth_scene_schema_size, NULL);
  LITHE_ASSERT(schema->root || report->arena->failed);
  if (!schema->root) LITHE_FAIL(ctx, LITHE_NO_MEMORY, "out of memory while reading the schema");
  return LITHE_OK;
}

static const LthNode *keyword(const LthSchema *s, const LthNode *rule, const char *name) {
  return lth_schema_keyword(s, rule, name);
}

static bool has_type(const LthSchema *s, const LthNode *rule, const char *name) {
  const LthNode *type = keyword(s, rule, "type");
  return lth_node_is_text(type, name) || lth_schema_lists(type, name);
}

static void report_type(const LthSchema *s, LthNode *node, const LthNode *rule) {
  lth_report(s->report, node, "wrong type, got %s; expected %s", lth_show(s->report->arena, node),
             lth_schema_describe(s, rule));
}

static void report_unbuilt(const LthSchema *s, LthNode *node, const char *available) {
  lth_report(s->report, node, "known but not available in this version, got %s; %s%s",
             lth_show(s->report->arena, node), available ? "available: " : "leave it out",
             available ? available : "");
}

static Inherited inherit(const LthSchema *s, const LthNode *rule, Inherited from) {
  const LthNode *unit = keyword(s, rule, "x-unit"), *varies = keyword(s, rule, "x-varies");
  if (unit) from.unit = unit->text;
  if (varies)
    from.may_use = (strchr(varies->text, 'x') ? LTH_USES_XYZ : 0) |
                   (strchr(varies->text, 't') ? LTH_USES_T : 0) |
                   (strchr(varies->text, 'v') ? LTH_USES_IMAGE : 0);
  if (s->dimension == 2) from.may_use &= ~LTH_USES_Z;
  return from;
}

/// --- scalars ---

static const char *nearest_of(const LthNode *words, const char *text) {
  const char *list[64];
  int n = 0;
  for (const LthNode *w = words->first; w && n < 64; w = w->next) list[n++] = w->text;
  return lth_nearest_word(text, list, n);
}

static void check_enum(const LthSchema *s, LthNode *node, const LthNode *rule,
                       const char *expected) {
  const LthNode *words = keyword(s, rule, "enum");
  if (lth_schema_lists(keyword(s, rule, "x-unbuilt"), node->text)) {
    report_unbuilt(s, node, expected);
    return;
  }
  if (lth_schema_lists(words, node->text)) return;
  const char *nearest = nearest_of(words, node->text);
  bool is_new = nearest && strcmp(nearest, expected) != 0;
  lth_report(s->report, node, "unknown word, got %s; expected %s%s%s%s",
             lth_show(s->report->arena, node), expected, is_new ? ", did you mean " : "",
             is_new ? nearest : "", is_new ? "?" : "");
}

static void check_range(const LthSchema *s, LthNode *node, const LthNode *rule) {
  if (node->value.eval) return;
  double v = node->value.constant;
  bool is_inside = v >= lth_schema_number(s, rule, "minimum", -INFINITY) &&
                   v <= lth_schema_number(s, rule, "maximum", INFINITY) &&
                   v > lth_schema_number(s, rule, "exclusiveMinimum", -INFINITY) &&
                   v < lth_schema_number(s, rule, "exclusiveMaximum", INFINITY);
  double built = lth_schema_number(s, rule, "x-built-maximum", INFINITY);
  if (!is_inside) {
    lth_report(s->report, node, "out of range, got %s; expected %s",
               lth_show(s->report->arena, node), lth_schema_describe(s, rule));
  } else if (v > built) {
    char available[32];
    snprintf(available, sizeof available, "up to %g", built);
    report_unbuilt(s, node, available);
  }
}

/// 20 for an angle is hardly twenty radians.
static void warn_degrees(const LthSchema *s, const LthNode *node, const LthUnit *unit) {
  static const LthUnit radian = {1, {0, 0, 0, 1}};
  if (node->has_unit || node->is_default || !lth_unit_same(unit, &radian)) return;
  double angle = node->value.constant;
  if (node->value.eval || fabs(angle) <= 6.3) return;
  const char *path = lth_node_path(s->report->arena, node, NULL);
  lth_warn(s->ctx,
           "%s: an angle without unit is in radians: %g is %.4g turns; write \"%g deg\" if degrees "
           "are meant",
           path ? path : "", angle, angle / 6.283185307179586, angle);
}

/// The unit that a neighbouring key's word gives; NULL where that word is wrong.
static const char *unit_by(const LthNode *by, const LthNode *node) {
  const LthNode *word = lth_node_find(node->parent, lth_node_find(by, "key")->text);
  const LthNode *unit = word && word->kind == LTH_NODE_SCALAR
                            ? lth_node_find(lth_node_find(by, "units"), word->text)
                            : NULL;
  return unit ? unit->text : NULL;
}

static LitheStatus check_number(const LthSchema *s, LthNode *node, const LthNode *rule,
                                Inherited from) {
  const LthNode *by = keyword(s, rule, "x-unit-by");
  if (by) from.unit = unit_by(by, node);
  if (by && !from.unit) return LITHE_OK;
  LthQuantity quantity = {.may_use = from.may_use, .unit_name = from.unit ? from.unit : "1"};
  lth_unit_parse(quantity.unit_name, &quantity.unit, NULL, NULL);
  bool is_good = false;
  LITHE_TRY(lth_quantity_parse(s->ctx, s->report, s->expressions, node, &quantity, &is_good));
  if (!is_good) return LITHE_OK;
  double v = node->value.constant;
  if (has_type(s, rule, "integer") && (v != floor(v) || fabs(v) > 2147483647.0)) {
    node->has_value = false;
    report_type(s, node, rule);
    return LITHE_OK;
  }
  check_range(s, node, rule);
  warn_degrees(s, node, &quantity.unit);
  return LITHE_OK;
}

static LitheStatus check_scalar(const LthSchema *s, LthNode *node, const LthNode *rule,
                                Inherited from) {
  if (lth_node_is_null(node)) {
    if (!has_type(s, rule, "null")) report_type(s, node, rule);
    return LITHE_OK;
  }
  if (keyword(s, rule, "enum")) {
    check_enum(s, node, rule, lth_schema_words(s, rule));
    return LITHE_OK;
  }
  if (has_type(s, rule, "number") || has_type(s, rule, "integer"))
    return check_number(s, node, rule, from);
  if (has_type(s, rule, "boolean")) {
    bool is_boolean = lth_node_is_text(node, "true") || lth_node_is_text(node, "false");
    if (!is_boolean || !node->plain) report_type(s, node, rule);
    return LITHE_OK;
  }
  if (!has_type(s, rule, "string")) {
    report_type(s, node, rule);
  } else if ((double)strlen(node->text) < lth_schema_number(s, rule, "minLength", 0)) {
    lth_report(s->report, node, "an empty text, got \"\"; expected %s",
               lth_schema_describe(s, rule));
  }
  return LITHE_OK;
}

/// --- lists ---

static void set_place(LthNode *node, const LthNode *from) {
  node->line = from->line, node->column = from->column;
  node->key_line = from->line, node->key_column = from->column;
  node->origin = from->origin;
  node->is_default = true;
  for (LthNode *child = node->first; child; child = child->next) set_place(child, from);
}

static LitheStatus copy_default(const LthSchema *s, const LthNode *from, const LthNode *place,
                                LthNode **copy) {
  *copy = lth_node_copy(s->report->arena, from);
  if (!*copy) LITHE_FAIL(s->ctx, LITHE_NO_MEMORY, "out of memory while reading the scene");
  set_place(*copy, place);
  return LITHE_OK;
}

static bool has_length(const LthSchema *s, const LthNode *node, const LthNode *rule) {
  double n = node->n_children;
  if (keyword(s, rule, "x-plane")) return n == s->dimension || (node->is_default && n == 3);
  return n >= lth_schema_number(s, rule, "minItems", 0) &&
         n <= lth_schema_number(s, rule, "maxItems", INFINITY);
}

static LitheStatus check_list(const LthSchema *s, LthNode *node, const LthNode *rule,
                              Inherited from) {
  const LthNode *items = keyword(s, rule, "items"), *plane = keyword(s, rule, "x-plane");
  double n = node->n_children, built = lth_schema_number(s, rule, "x-built-maximum", INFINITY);
  if (!has_length(s, node, rule)) {
    lth_report(s->report, node, "wrong length, got %s; expected %s",
               lth_show(s->report->arena, node),
               n == 0 ? "at least one entry" : lth_schema_describe(s, rule));
    return LITHE_OK;
  }
  if (n > built) {
    char available[32];
    snprintf(available, sizeof available, "%g", built);
    report_unbuilt(s, node, available);
  }
  if (plane && n == 2) {
    LthNode *third = NULL;
    LITHE_TRY(copy_default(s, plane, node, &third));
    lth_node_append(node, NULL, third);
  }
  for (LthNode *item = node->first; item && items; item = item->next)
    LITHE_TRY(check(s, item, items, from));
  return LITHE_OK;
}

/// --- maps ---

static void report_unknown_key(const LthSchema *s, LthNode *child, const LthNode *properties,
                               const LthNode *rule) {
  const char *list[64];
  int n = 0;
  for (const LthNode *p = properties->first; p && n < 64; p = p->next) list[n++] = p->key;
  const char *nearest = lth_nearest_word(child->key, list, n);
  const char *shown = lth_show_text(s->report->arena, child->key);
  if (nearest)
    lth_report_key(s->report, child, "unknown key, got %s; did you mean %s?", shown, nearest);
  else
    lth_report_key(s->report, child, "unknown key, got %s; expected %s", shown,
                   lth_schema_describe(s, rule));
}

/// A key that is not built may stand empty where empty is its default: it asks for nothing.
static bool asks_for_nothing(const LthSchema *s, const LthNode *child, const LthNode *rule) {
  bool is_empty =
      (child->kind != LTH_NODE_SCALAR && child->n_children == 0) || lth_node_is_null(child);
  return is_empty && keyword(s, rule, "default");
}

/// Give a map the default of a key it lacks, or that it leaves empty.
static LitheStatus add_default(const LthSchema *s, LthNode *map, const LthNode *property) {
  const LthNode *otherwise = keyword(s, property, "default");
  LthNode *given = lth_node_find(map, property->key);
  if (!otherwise || (given && !lth_node_is_null(given))) return LITHE_OK;
  LthNode *copy = NULL;
  LITHE_TRY(copy_default(s, otherwise, map, &copy));
  if (given)
    lth_node_replace(given, copy);
  else
    lth_node_append(map, property->key, copy);
  return LITHE_OK;
}

static void check_required(const LthSchema *s, LthNode *map, const LthNode *rule) {
  const LthNode *required = keyword(s, rule, "required");
  const LthNode *properties = keyword(s, rule, "properties");
  for (const LthNode *r = required ? required->first : NULL; r; r = r->next)
    if (!lth_node_find(map, r->text) &&
        lth_schema_has_dimension(s, lth_node_find(properties, r->text)))
      lth_report_missing(s->report, map, r->text, "missing; expected %s",
                         lth_schema_describe(s, lth_node_find(properties, r->text)));
}

static const LthNode *choice_key(const LthNode *choice) {
  return lth_node_find(choice, "required")->first;
}

static bool is_built(const LthSchema *s, const LthNode *properties, const char *key) {
  const LthNode *property = lth_node_find(properties, key);
  return property && !lth_node_is_text(keyword(s, property, "x-built"), "false") &&
         lth_schema_has_dimension(s, property);
}

static const char *choice_list(const LthSchema *s, const LthNode *choices,
                               const LthNode *properties) {
  LthArena *arena = s->report->arena;
  const char *text = NULL;
  for (const LthNode *c = choices->first; c; c = c->next) {
    const char *key = choice_key(c)->text;
    if (!is_built(s, properties, key)) continue;
    text = text ? lth_arena_print(arena, "%s, %s", text, key) : key;
    if (!text) return "";
  }
  return text ? text : "";
}

/// oneOf lists keys of which exactly one must be there.
static void check_choice(const LthSchema *s, LthNode *map, const LthNode *rule,
                         bool has_wrong_key) {
  const LthNode *choices = keyword(s, rule, "oneOf"), *properties = keyword(s, rule, "properties");
  if (!choices) return;
  LthNode *found = NULL;
  for (const LthNode *c = choices->first; c; c = c->next) {
    LthNode *child = lth_node_find(map, choice_key(c)->text);
    if (child && found) {
      LthNode *later = child->index > found->index ? child : found;
      lth_report_key(s->report, later,
                     "%s and %s exclude each other, got both; expected exactly one of %s",
                     found->key, child->key, choice_list(s, choices, properties));
      return;
    }
    if (child) found = child;
  }
  if (!found && !has_wrong_key)
    lth_report(s->report, map, "incomplete, got %s; expected exactly one of %s",
               map->n_children ? "none of the keys it needs" : "an empty mapping",
               choice_list(s, choices, properties));
}

/// `not: {required: [a, b]}`: not both.
static void check_exclusion(const LthSchema *s, LthNode *map, const LthNode *rule) {
  const LthNode *pair = lth_node_find(keyword(s, rule, "not"), "required");
  if (!pair) return;
  LthNode *a = lth_node_find(map, pair->first->text), *b = lth_node_find(map, pair->last->text);
  if (a && b)
    lth_report_key(s->report, b, "%s and %s exclude each other, got both; expected one", a->key,
                   b->key);
}

/// A key of the other dimension; `map` is the rule of the map that it stands in.
static void report_dimension(const LthSchema *s, LthNode *child, const LthNode *map) {
  const LthNode *choices = keyword(s, map, "oneOf");
  bool is_choice = false;
  for (const LthNode *c = choices ? choices->first : NULL; c; c = c->next)
    is_choice = is_choice || strcmp(choice_key(c)->text, child->key) == 0;
  lth_report_key(s->report, child, "it is of scenes in %s dimensions, got %s in %s; %s%s",
                 s->dimension == 2 ? "three" : "two", child->key,
                 s->dimension == 2 ? "`dimension: 2`" : "three (write `dimension: 2` for a plane)",
                 is_choice ? "expected one of " : "leave it out",
                 is_choice ? choice_list(s, choices, keyword(s, map, "properties")) : "");
}

static LitheStatus check_property(const LthSchema *s, LthNode *child, const LthNode *map,
                                  const LthNode *rule, Inherited from) {
  if (!lth_schema_has_dimension(s, rule)) {
    report_dimension(s, child, map);
    return LITHE_OK;
  }
  if (lth_node_is_text(keyword(s, rule, "x-built"), "false")) {
    if (asks_for_nothing(s, child, rule)) return LITHE_OK;
    lth_report_key(s->report, child,
                   "known but not available in this version, got %s; leave it out",
                   lth_show(s->report->arena, child));
    return LITHE_OK;
  }
  return check(s, child, rule, from);
}

static LitheStatus check_map(const LthSchema *s, LthNode *map, const LthNode *rule,
                             Inherited from) {
  const LthNode *properties = keyword(s, rule, "properties");
  bool has_wrong_key = false;
  for (LthNode *child = map->first; child; child = child->next) {
    if (lth_node_find(properties, child->key) || child->bad) continue;
    report_unknown_key(s, child, properties, rule);
    has_wrong_key = true;
  }
  check_required(s, map, rule);
  check_choice(s, map, rule, has_wrong_key);
  check_exclusion(s, map, rule);
  for (const LthNode *p = properties->first; p; p = p->next) LITHE_TRY(add_default(s, map, p));
  for (LthNode *child = map->first; child; child = child->next) {
    const LthNode *property = lth_node_find(properties, child->key);
    if (property && !child->bad) LITHE_TRY(check_property(s, child, rule, property, from));
  }
  return LITHE_OK;
}

/// --- alternatives ---

static bool accepts_kind(const LthSchema *s, const LthNode *rule, const LthNode *node) {
  if (node->kind == LTH_NODE_LIST) return has_type(s, rule, "array");
  if (node->kind == LTH_NODE_MAP) return has_type(s, rule, "object");
  if (lth_node_is_null(node)) return has_type(s, rule, "null");
  return keyword(s, rule, "enum") || has_type(s, rule, "string") || has_type(s, rule, "number") ||
         has_type(s, rule, "integer") || has_type(s, rule, "boolean");
}

static int common_keys(const LthSchema *s, const LthNode *rule, const LthNode *map) {
  const LthNode *properties = keyword(s, rule, "properties");
  int n = 0;
  for (const LthNode *child = map->first; child; child = child->next)
    n += lth_node_find(properties, child->key) != NULL;
  return n;
}

/// Of a word: an enum that lists it, else a free alternative. Of a map: most known keys.
static const LthNode *choose(const LthSchema *s, const LthNode *node, const LthNode *choices) {
  const LthNode *best = NULL;
  int best_score = -1;
  for (const LthNode *c = choices->first; c; c = c->next) {
    if (!accepts_kind(s, c, node)) continue;
    int score = 0;
    if (node->kind == LTH_NODE_MAP) {
      score = common_keys(s, c, node);
    } else if (node->kind == LTH_NODE_SCALAR) {
      const LthNode *words = keyword(s, c, "enum");
      score = !words ? 1 : lth_schema_lists(words, node->text) ? 2 : 0;
    }
    if (score > best_score) {
      best_score = score;
      best = c;
    }
  }
  return best;
}

/// The word of any alternative's enum that a text may mean: "auot" where auto or a number is expected.
static const char *meant_word(const LthSchema *s, const LthNode *node, const LthNode *choices) {
  for (const LthNode *c = choices->first; c; c = c->next) {
    const LthNode *words = keyword(s, c, "enum");
    const char *nearest = words ? nearest_of(words, node->text) : NULL;
    if (nearest) return nearest;
  }
  return NULL;
}

static LitheStatus check_any(const LthSchema *s, LthNode *node, const LthNode *rule,
                             Inherited from) {
  const LthNode *choices = keyword(s, rule, "anyOf"), *choice = choose(s, node, choices);
  if (!choice) {
    report_type(s, node, rule);
    return LITHE_OK;
  }
  if (lth_node_is_text(keyword(s, choice, "x-built"), "false")) {
    report_unbuilt(s, node, lth_schema_describe(s, rule));
    return LITHE_OK;
  }
  bool is_word = node->kind == LTH_NODE_SCALAR && !lth_node_is_null(node);
  bool is_listed = is_word && lth_schema_lists(keyword(s, choice, "enum"), node->text);
  bool is_number = has_type(s, choice, "number") || has_type(s, choice, "integer");
  if (is_word && !is_listed && (is_number || !has_type(s, choice, "string"))) {
    const char *nearest = meant_word(s, node, choices);
    if (nearest) {
      lth_report(s->report, node, "unknown word, got %s; expected %s, did you mean %s?",
                 lth_show(s->report->arena, node), lth_schema_describe(s, rule), nearest);
      return LITHE_OK;
    }
  }
  if (is_word && keyword(s, choice, "enum")) {
    check_enum(s, node, choice, lth_schema_describe(s, rule));
    return LITHE_OK;
  }
  return check(s, node, choice, from);
}

static LitheStatus check(const LthSchema *s, LthNode *node, const LthNode *rule, Inherited from) {
  from = inherit(s, rule, from);
  if (keyword(s, rule, "anyOf")) return check_any(s, node, rule, from);
  if (node->kind == LTH_NODE_SCALAR) return check_scalar(s, node, rule, from);
  const char *type = node->kind == LTH_NODE_LIST ? "array" : "object";
  if (!has_type(s, rule, type)) {
    report_type(s, node, rule);
    return LITHE_OK;
  }
  return node->kind == LTH_NODE_LIST ? check_list(s, node, rule, from)
                                     : check_map(s, node, rule, from);
}

LitheStatus lth_schema_check(LthSchema *schema, LthNode *document) {
  schema->dimension = lth_node_is_text(lth_node_find(document, "dimension"), "2") ? 2 : 3;
  return check(schema, document, schema->root, (Inherited){0});
}
