/// Making, finding and copying nodes.
#include "scene/node.h"

#include <stdio.h>
#include <string.h>

LthNode *lth_node_create(LthArena *arena, LthNodeKind kind) {
  LthNode *node = lth_arena_take(arena, sizeof *node);
  if (node) node->kind = kind;
  return node;
}

void lth_node_append(LthNode *parent, const char *key, LthNode *child) {
  child->parent = parent;
  child->key = key;
  child->index = parent->n_children++;
  child->next = NULL;
  if (parent->last)
    parent->last->next = child;
  else
    parent->first = child;
  parent->last = child;
}

void lth_node_replace(LthNode *old, LthNode *child) {
  LthNode *parent = old->parent;
  child->parent = parent;
  child->key = old->key;
  child->index = old->index;
  child->next = old->next;
  LthNode **link = &parent->first;
  while (*link != old) link = &(*link)->next;
  *link = child;
  if (parent->last == old) parent->last = child;
}

LthNode *lth_node_copy(LthArena *arena, const LthNode *node) {
  LthNode *copy = lth_node_create(arena, node->kind);
  if (!copy) return NULL;
  *copy = *node;
  copy->parent = copy->next = copy->first = copy->last = NULL;
  copy->n_children = 0;
  for (const LthNode *child = node->first; child; child = child->next) {
    LthNode *child_copy = lth_node_copy(arena, child);
    if (!child_copy) return NULL;
    lth_node_append(copy, child->key, child_copy);
  }
  return copy;
}

LthNode *lth_node_find(const LthNode *map, const char *key) {
  if (!map || map->kind != LTH_NODE_MAP) return NULL;
  for (LthNode *child = map->first; child; child = child->next)
    if (strcmp(child->key, key) == 0) return child;
  return NULL;
}

LthNode *lth_node_at(const LthNode *node, LitheIndex i) {
  LthNode *child = node ? node->first : NULL;
  while (child && i-- > 0) child = child->next;
  return child;
}

const LthNode *lth_node_get(const LthNode *map, const char *key) {
  const LthNode *node = lth_node_find(map, key);
  return node && !node->bad ? node : NULL;
}

bool lth_node_is_sound(const LthNode *node) {
  if (node->bad) return false;
  for (const LthNode *child = node->first; child; child = child->next)
    if (!lth_node_is_sound(child)) return false;
  return true;
}

bool lth_node_is_null(const LthNode *node) {
  if (node->kind != LTH_NODE_SCALAR || !node->plain) return false;
  return !node->text[0] || strcmp(node->text, "null") == 0 || strcmp(node->text, "~") == 0;
}

bool lth_node_is_text(const LthNode *node, const char *text) {
  return node && node->kind == LTH_NODE_SCALAR && strcmp(node->text, text) == 0;
}

const char *lth_node_path(LthArena *arena, const LthNode *node, const char *key) {
  if (!node || !node->parent) return key ? key : "";
  char number[16];
  const char *name = node->key;
  if (!name) {
    snprintf(number, sizeof number, "%d", node->index);
    name = number;
  }
  const char *above = lth_node_path(arena, node->parent, NULL);
  if (!above) return NULL;
  return lth_arena_print(arena, "%s%s%s%s%s", above, *above ? "." : "", name, key ? "." : "",
                         key ? key : "");
}
