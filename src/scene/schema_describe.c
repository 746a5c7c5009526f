/// Schema nodes in words, for messages.
#include "scene/schema.h"

#include "io/text.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const LthNode *follow_ref(const LthSchema *schema, const LthNode *node) {
  const LthNode *ref = lth_node_find(node, "$ref");
  if (!ref) return NULL;
  const char *name = strrchr(ref->text, '/');
  return name ? lth_node_find(lth_node_find(schema->root, "$defs"), name + 1) : NULL;
}

const LthNode *lth_schema_keyword(const LthSchema *schema, const LthNode *node, const char *name) {
  for (int hops = 0; node && hops < 8; hops++) {
    const LthNode *found = lth_node_find(node, name);
    if (found) return found;
    node = follow_ref(schema, node);
  }
  return NULL;
}

bool lth_schema_lists(const LthNode *list, const char *text) {
  for (const LthNode *item = list ? list->first : NULL; item; item = item->next)
    if (item->kind == LTH_NODE_SCALAR && strcmp(item->text, text) == 0) return true;
  return false;
}

double lth_schema_number(const LthSchema *schema, const LthNode *node, const char *name,
                         double otherwise) {
  const LthNode *keyword = lth_schema_keyword(schema, node, name);
  double value = otherwise;
  if (keyword) lth_word_number((LthWord){keyword->text, strlen(keyword->text)}, &value);
  return value;
}

static const char *join(const LthSchema *schema, const char *a, const char *glue, const char *b) {
  const char *text = lth_arena_print(schema->report->arena, "%s%s%s", a, *a ? glue : "", b);
  return text ? text : "";
}

const char *lth_schema_words(const LthSchema *schema, const LthNode *node) {
  const LthNode *words = lth_schema_keyword(schema, node, "enum");
  const LthNode *unbuilt = lth_schema_keyword(schema, node, "x-unbuilt");
  const char *text = "", *last = NULL;
  for (const LthNode *w = words ? words->first : NULL; w; w = w->next) {
    if (lth_schema_lists(unbuilt, w->text)) continue;
    if (last) text = join(schema, text, ", ", last);
    last = w->text;
  }
  return last ? join(schema, text, " or ", last) : text;
}

static const char *range_text(const LthSchema *schema, const LthNode *node) {
  static const struct {
    const char *keyword, *sign;
  } bounds[] = {
      {"exclusiveMinimum", ">"}, {"minimum", ">="}, {"exclusiveMaximum", "<"}, {"maximum", "<="}};
  const char *text = "";
  for (size_t i = 0; i < sizeof bounds / sizeof *bounds; i++) {
    const LthNode *bound = lth_schema_keyword(schema, node, bounds[i].keyword);
    if (!bound) continue;
    char part[64];
    snprintf(part, sizeof part, "%s %s", bounds[i].sign, bound->text);
    text = join(schema, text, " and ", part);
  }
  return *text ? join(schema, "", "", lth_arena_print(schema->report->arena, " %s", text)) : text;
}

static const char *unit_text(const LthSchema *schema, const LthNode *node) {
  const LthNode *unit = lth_schema_keyword(schema, node, "x-unit");
  if (!unit || strcmp(unit->text, "1") == 0) return "";
  const char *text = lth_arena_print(schema->report->arena, " [%s]", unit->text);
  return text ? text : "";
}

bool lth_schema_has_dimension(const LthSchema *schema, const LthNode *property) {
  return lth_schema_number(schema, property, "x-dimensions", schema->dimension) ==
         schema->dimension;
}

static const char *describe_list(const LthSchema *schema, const LthNode *node) {
  const LthNode *items = lth_schema_keyword(schema, node, "items");
  double min = lth_schema_number(schema, node, "minItems", 0);
  double max = lth_schema_number(schema, node, "maxItems", INFINITY);
  if (lth_schema_keyword(schema, node, "x-plane")) min = max = schema->dimension;
  const char *each = items ? lth_schema_describe(schema, items) : "anything";
  LthArena *arena = schema->report->arena;
  const char *text = NULL;
  if (min == max && strncmp(each, "a number", 8) == 0)
    text =
        lth_arena_print(arena, "a list of %g numbers%s%s", min, each + 8, unit_text(schema, node));
  else if (min == max)
    text = lth_arena_print(arena, "a list of %g, each %s", min, each);
  else
    text = lth_arena_print(arena, "a list, each %s", each);
  return text ? text : "";
}

static const char *describe_map(const LthSchema *schema, const LthNode *node) {
  const LthNode *properties = lth_schema_keyword(schema, node, "properties");
  const char *text = "";
  for (const LthNode *p = properties ? properties->first : NULL; p; p = p->next) {
    const LthNode *built = lth_schema_keyword(schema, p, "x-built");
    if (!lth_node_is_text(built, "false") && lth_schema_has_dimension(schema, p))
      text = join(schema, text, ", ", p->key);
  }
  return join(schema, "a mapping with", " ", text);
}

static const char *describe_any(const LthSchema *schema, const LthNode *choices) {
  const char *text = "";
  for (const LthNode *c = choices->first; c; c = c->next) {
    const LthNode *built = lth_schema_keyword(schema, c, "x-built");
    if (!lth_node_is_text(built, "false"))
      text = join(schema, text, " or ", lth_schema_describe(schema, c));
  }
  return text;
}

const char *lth_schema_describe(const LthSchema *schema, const LthNode *node) {
  const LthNode *title =
      schema->dimension == 2 ? lth_schema_keyword(schema, node, "x-plane-title") : NULL;
  if (!title) title = lth_schema_keyword(schema, node, "title");
  if (title) return title->text;
  const LthNode *choices = lth_schema_keyword(schema, node, "anyOf");
  if (choices) return describe_any(schema, choices);
  if (lth_schema_keyword(schema, node, "enum")) return lth_schema_words(schema, node);
  const LthNode *type = lth_schema_keyword(schema, node, "type");
  const char *range = range_text(schema, node);
  if (lth_schema_lists(type, "integer")) return join(schema, "an integer", "", range);
  if (lth_schema_lists(type, "number"))
    return join(schema, join(schema, "a number", "", range), "", unit_text(schema, node));
  if (lth_node_is_text(type, "string")) return "a text";
  if (lth_node_is_text(type, "boolean")) return "true or false";
  if (lth_node_is_text(type, "array")) return describe_list(schema, node);
  if (lth_node_is_text(type, "object")) return describe_map(schema, node);
  return "another value";
}
