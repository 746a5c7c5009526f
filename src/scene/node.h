/// A YAML document as a tree of nodes that know where they stand in the file.
#pragma once

#include "base/value.h"
#include "scene/arena.h"

typedef enum LthNodeKind { LTH_NODE_SCALAR, LTH_NODE_LIST, LTH_NODE_MAP } LthNodeKind;

typedef struct LthNode LthNode;
struct LthNode {
  LthNodeKind kind;
  const char *text;         ///< of a scalar, ends with a zero
  bool plain;               ///< a scalar without quotes
  const char *key;          ///< in a map; NULL in a list and at the root
  LitheIndex index;         ///< in a list
  int line, column;         ///< of the value, from 1; 0: stands in no file
  int key_line, key_column; ///< of the key
  const char *origin;       ///< "--set ..." instead of a place in the file, or NULL
  LthNode *parent, *next, *first, *last;
  LitheIndex n_children;
  bool bad;                 ///< an error was reported here: readers skip it
  bool is_default;          ///< the schema's default, not in the file
  bool has_value, has_unit; ///< a number, checked and parsed by the schema
  LthValue value;
};

/// What reading a document may run into.
#define LTH_NODE_DEPTH_MAX 48
#define LTH_NODE_COUNT_MAX 1000000
#define LTH_NODE_KEYS_MAX 1000

LthNode *lth_node_create(LthArena *arena, LthNodeKind kind);

/// Append a child to a map (key) or a list (key NULL).
void lth_node_append(LthNode *parent, const char *key, LthNode *child);

/// Put `child` in the place of `old`, which must have a parent.
void lth_node_replace(LthNode *old, LthNode *child);

/// A deep copy without parent, key and siblings; NULL where memory is out.
LthNode *lth_node_copy(LthArena *arena, const LthNode *node);

/// Value of a key or NULL; also where `map` is NULL or no map.
LthNode *lth_node_find(const LthNode *map, const char *key);

/// Child number i or NULL.
LthNode *lth_node_at(const LthNode *node, LitheIndex i);

/// As lth_node_find, but NULL where the value is bad as well: what readers use.
const LthNode *lth_node_get(const LthNode *map, const char *key);

/// True where neither the node nor anything below it is bad.
bool lth_node_is_sound(const LthNode *node);

bool lth_node_is_null(const LthNode *node); ///< a plain `null`, `~` or nothing at all
bool lth_node_is_text(const LthNode *node, const char *text);

/// "bodies.0.method.degree", "" at the root; `key` (may be NULL) is appended. In the arena.
const char *lth_node_path(LthArena *arena, const LthNode *node, const char *key);
