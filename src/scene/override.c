/// Walking a path of keys and numbers, and hanging a parsed value at its end.
#include "scene/override.h"

#include "scene/yaml.h"

#include <stdlib.h>
#include <string.h>

static LthNode *new_map(LthReport *report, const char *origin) {
  LthNode *map = lth_node_create(report->arena, LTH_NODE_MAP);
  if (map) map->origin = origin;
  return map;
}

/// The entry of a list that `name` numbers; `n_children` stands for one more. -1: no such entry.
static LitheIndex entry_number(const LthNode *list, const char *name) {
  size_t length = strlen(name);
  if (length == 0 || length > 6 || strspn(name, "0123456789") != length) return -1;
  LitheIndex i = (LitheIndex)atoi(name);
  return i <= list->n_children ? i : -1;
}

static const char *where_text(LthReport *report, const LthNode *node) {
  const char *path = lth_node_path(report->arena, node, NULL);
  return path && *path ? path : "the scene";
}

/// The child that `name` means; *is_new where it would have to be made. False after an error.
static bool find_child(LthReport *report, const char *origin, LthNode *node, const char *name,
                       LthNode **child) {
  *child = NULL;
  const char *where = where_text(report, node);
  if (!*name) {
    lth_report_option(report, origin,
                      "an empty key in the path; expected a path such as bodies.0.method.degree");
    return false;
  }
  if (node->kind == LTH_NODE_MAP) {
    *child = lth_node_find(node, name);
    return true;
  }
  if (node->kind == LTH_NODE_SCALAR) {
    lth_report_option(report, origin,
                      "%s is %s and has no keys, got %s; expected the path of a mapping or a list",
                      where, lth_show(report->arena, node), lth_show_text(report->arena, name));
    return false;
  }
  LitheIndex i = entry_number(node, name);
  if (i < 0) {
    lth_report_option(report, origin, "%s is a list of %d, got %s; expected a number from 0 to %d",
                      where, node->n_children, lth_show_text(report->arena, name),
                      node->n_children);
    return false;
  }
  *child = lth_node_at(node, i);
  return true;
}

static void hang(LthNode *parent, const char *name, LthNode *old, LthNode *child) {
  if (old)
    lth_node_replace(old, child);
  else
    lth_node_append(parent, parent->kind == LTH_NODE_MAP ? name : NULL, child);
}

void lth_override(LthReport *report, LthNode *root, const char *override) {
  LthArena *arena = report->arena;
  const char *origin = lth_arena_print(arena, "--set %s", override);
  const char *equals = strchr(override, '=');
  if (!origin) return;
  if (!equals || equals == override) {
    lth_report_option(report, origin,
                      "not PATH=VALUE; expected for example bodies.0.method.degree=2");
    return;
  }
  char *path = lth_arena_text(arena, override, (size_t)(equals - override));
  const char *text = lth_arena_text(arena, equals + 1, strlen(equals + 1));
  if (!path || !text) return;
  LthNode *value = *text ? lth_yaml_parse(report, text, strlen(text), origin) : NULL;
  if (!value && !*text) {
    lth_report_option(report, origin,
                      "the value is empty; expected for example bodies.0.method.degree=2");
  }
  if (!value) return;

  LthNode *node = root;
  for (char *name = path, *dot = NULL;; name = dot + 1) {
    dot = strchr(name, '.');
    if (dot) *dot = 0;
    LthNode *child = NULL;
    if (!find_child(report, origin, node, name, &child)) return;
    if (!dot) {
      hang(node, name, child, value);
      return;
    }
    if (!child || lth_node_is_null(child)) {
      LthNode *map = new_map(report, origin);
      if (!map) return;
      hang(node, name, child, map);
      child = map;
    }
    node = child;
  }
}
