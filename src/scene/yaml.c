/// The events of libfyaml become our own tree: positions stay with every value, aliases become copies,
/// and depth, size and repeated keys are checked while it grows.
#include "scene/yaml.h"

#include <libfyaml.h>
#include <string.h>

typedef struct Anchor Anchor;
struct Anchor {
  Anchor *next;
  const char *name;
  LthNode *node;
};

/// A key that waits for its value.
typedef struct PendingKey {
  const char *text; ///< NULL: none
  int line, column;
} PendingKey;

typedef struct Builder {
  LthReport *report;
  LthArena *arena;
  const char *origin, *text;
  size_t length;
  LthNode *root, *open; ///< open: the map or list being filled
  PendingKey keys[LTH_NODE_DEPTH_MAX + 1];
  int depth;
  int line, column; ///< of the last token, for values that have none
  LitheIndex n_nodes;
  int n_documents;
  int skipped; ///< depth inside a key that is not a word
  Anchor *anchors;
  bool stop;
} Builder;

static void complain(Builder *b, const char *what) {
  b->stop = true;
  if (b->origin)
    lth_report_option(b->report, b->origin, "%s", what);
  else
    lth_report_at(b->report, b->line, b->column, "%s", what);
}

static void take_place(Builder *b, struct fy_token *token, int quotes) {
  const struct fy_mark *mark = token ? fy_token_start_mark(token) : NULL;
  if (!mark) return;
  b->line = mark->line + 1;
  b->column = mark->column + 1 - quotes;
}

static const char *token_text(Builder *b, struct fy_token *token) {
  size_t length = 0;
  const char *text = token ? fy_token_get_text(token, &length) : NULL;
  if (!text) return "";
  if (memchr(text, 0, length)) complain(b, "a zero byte in a text, got \\0; expected letters");
  const char *copy = lth_arena_text(b->arena, text, length);
  return copy ? copy : "";
}

static LthNode *new_node(Builder *b, LthNodeKind kind) {
  LthNode *node = lth_node_create(b->arena, kind);
  if (!node || ++b->n_nodes > LTH_NODE_COUNT_MAX) {
    if (node) complain(b, "too large, got more than 1000000 values; expected a scene");
    b->stop = true;
    return NULL;
  }
  node->line = b->line;
  node->column = b->column;
  node->origin = b->origin;
  return node;
}

/// Hang a node where it belongs: the root, the next item, the value of the pending key.
static void place_node(Builder *b, LthNode *node) {
  if (!b->open) {
    b->root = node;
    return;
  }
  if (b->open->kind == LTH_NODE_LIST) {
    lth_node_append(b->open, NULL, node);
    return;
  }
  PendingKey *key = &b->keys[b->depth];
  const LthNode *same = lth_node_find(b->open, key->text);
  if (b->open->n_children >= LTH_NODE_KEYS_MAX) {
    complain(b, "too many keys in one mapping, got more than 1000; expected the known ones");
    return;
  }
  node->key_line = key->line;
  node->key_column = key->column;
  lth_node_append(b->open, key->text, node);
  key->text = NULL;
  if (same)
    lth_report_key(b->report, node,
                   "the key is given twice, got it first in line %d; expected it once",
                   same->key_line);
}

static void remember_anchor(Builder *b, struct fy_token *token, LthNode *node) {
  if (!token) return;
  Anchor *anchor = lth_arena_take(b->arena, sizeof *anchor);
  if (!anchor) return;
  *anchor = (Anchor){b->anchors, token_text(b, token), node};
  b->anchors = anchor;
}

static void refuse_tag(Builder *b, struct fy_token *token) {
  if (!token) return;
  complain(b, "a YAML tag (!...) has no meaning in a scene; expected a value without it");
}

static bool awaits_key(const Builder *b) {
  return b->open && b->open->kind == LTH_NODE_MAP && !b->keys[b->depth].text;
}

/// libfyaml 0.7.12 garbles and leaks single-quoted texts with '' several times in a row.
static bool has_quote_run(const Builder *b, struct fy_token *token) {
  const struct fy_mark *start = fy_token_start_mark(token), *end = fy_token_end_mark(token);
  if (!start || !end || end->input_pos > b->length || start->input_pos > end->input_pos)
    return false;
  for (size_t i = start->input_pos; i + 4 <= end->input_pos; i++)
    if (memcmp(b->text + i, "''''", 4) == 0) return true;
  return false;
}

static void on_scalar(Builder *b, struct fy_event *event) {
  struct fy_token *token = event->scalar.value;
  enum fy_scalar_style style = token ? fy_token_scalar_style(token) : FYSS_PLAIN;
  bool is_quoted = style == FYSS_SINGLE_QUOTED || style == FYSS_DOUBLE_QUOTED;
  take_place(b, token, is_quoted);
  refuse_tag(b, event->scalar.tag);
  if (style == FYSS_SINGLE_QUOTED && has_quote_run(b, token)) {
    complain(b, "several '' in a row in a single-quoted text; expected double quotes around it");
    return;
  }
  if (awaits_key(b)) {
    b->keys[b->depth] = (PendingKey){token_text(b, token), b->line, b->column};
    return;
  }
  LthNode *node = new_node(b, LTH_NODE_SCALAR);
  if (!node) return;
  node->text = token_text(b, token);
  node->plain = style == FYSS_PLAIN;
  remember_anchor(b, event->scalar.anchor, node);
  place_node(b, node);
}

static void on_start(Builder *b, LthNodeKind kind, struct fy_token *token, struct fy_token *anchor,
                     struct fy_token *tag) {
  take_place(b, token, 0);
  refuse_tag(b, tag);
  if (awaits_key(b)) {
    complain(b, "a key must be a word, got a list or a mapping; expected `key: value`");
    return;
  }
  if (b->depth == LTH_NODE_DEPTH_MAX) {
    complain(b, "nested too deep, got more than 48 levels; expected a scene");
    return;
  }
  LthNode *node = new_node(b, kind);
  if (!node) return;
  place_node(b, node);
  remember_anchor(b, anchor, node);
  b->open = node;
  b->keys[++b->depth] = (PendingKey){0};
}

static void on_end(Builder *b) {
  if (!b->open) return;
  b->open = b->open->parent;
  b->depth--;
}

static LitheIndex subtree_size(const LthNode *node) {
  LitheIndex n = 1;
  for (const LthNode *child = node->first; child; child = child->next) n += subtree_size(child);
  return n;
}

static int subtree_depth(const LthNode *node) {
  int deepest = 0;
  for (const LthNode *child = node->first; child; child = child->next) {
    int depth = subtree_depth(child);
    if (depth > deepest) deepest = depth;
  }
  return deepest + (node->kind != LTH_NODE_SCALAR);
}

static bool is_above(const LthNode *node, const LthNode *open) {
  while (open && open != node) open = open->parent;
  return open != NULL;
}

/// An alias is a copy of what its anchor holds, as if it were written twice.
static void on_alias(Builder *b, struct fy_event *event) {
  take_place(b, event->alias.anchor, 1);
  const char *name = token_text(b, event->alias.anchor);
  const Anchor *anchor = b->anchors;
  while (anchor && strcmp(anchor->name, name) != 0) anchor = anchor->next;
  if (!anchor || is_above(anchor->node, b->open)) {
    complain(b, anchor ? "an alias (*) inside its own anchor (&); expected one that is complete"
                       : "an alias (*) without its anchor (&); expected the anchor before it");
    return;
  }
  if (awaits_key(b)) {
    complain(b, "a key must be a word, got an alias; expected `key: value`");
    return;
  }
  b->n_nodes += subtree_size(anchor->node);
  if (b->n_nodes > LTH_NODE_COUNT_MAX ||
      b->depth + subtree_depth(anchor->node) > LTH_NODE_DEPTH_MAX) {
    complain(b, "aliases make the document too large or too deep; expected a scene");
    return;
  }
  LthNode *copy = lth_node_copy(b->arena, anchor->node);
  if (copy) place_node(b, copy);
}

static void on_event(Builder *b, struct fy_event *event) {
  switch (event->type) {
  case FYET_DOCUMENT_START:
    take_place(b, event->document_start.document_start, 0);
    if (b->n_documents++ > 0)
      complain(b, "a second document begins, got ---; expected one document");
    break;
  case FYET_SCALAR:
    on_scalar(b, event);
    break;
  case FYET_MAPPING_START:
    on_start(b, LTH_NODE_MAP, event->mapping_start.mapping_start, event->mapping_start.anchor,
             event->mapping_start.tag);
    break;
  case FYET_SEQUENCE_START:
    on_start(b, LTH_NODE_LIST, event->sequence_start.sequence_start, event->sequence_start.anchor,
             event->sequence_start.tag);
    break;
  case FYET_MAPPING_END:
  case FYET_SEQUENCE_END:
    on_end(b);
    break;
  case FYET_ALIAS:
    on_alias(b, event);
    break;
  default:
    break;
  }
}

static void swallow_output(struct fy_diag *diag, void *user, const char *text, size_t length) {
  (void)diag, (void)user, (void)text, (void)length;
}

static void report_syntax(Builder *b, struct fy_diag *diag) {
  void *at = NULL;
  const struct fy_diag_error *error = fy_diag_errors_iterate(diag, &at);
  if (error && error->line > 0) b->line = error->line, b->column = error->column;
  const char *text = lth_arena_print(b->arena, "not YAML: %s; expected YAML 1.2 or JSON",
                                     error && error->msg ? error->msg : "syntax error");
  if (text) complain(b, text);
}

static struct fy_diag *quiet_diag(void) {
  struct fy_diag_cfg def;
  fy_diag_cfg_default(&def);
  def.fp = NULL;
  def.output_fn = swallow_output;
  struct fy_diag *diag = fy_diag_create(&def);
  if (diag) fy_diag_set_collect_errors(diag, true);
  return diag;
}

static void run_parser(Builder *b, const char *text, size_t length) {
  struct fy_diag *diag = quiet_diag();
  struct fy_parse_cfg def = {.flags = FYPCF_DEFAULT_VERSION_1_2 | FYPCF_JSON_NONE, .diag = diag};
  struct fy_parser *parser = diag ? fy_parser_create(&def) : NULL;
  if (!parser || fy_parser_set_string(parser, text, length) != 0) {
    b->arena->failed = true;
  } else {
    struct fy_event *event = NULL;
    while (!b->stop && (event = fy_parser_parse(parser)) != NULL) {
      on_event(b, event);
      fy_parser_event_free(parser, event);
    }
    if (!b->stop && fy_parser_get_stream_error(parser)) report_syntax(b, diag);
  }
  if (parser) fy_parser_destroy(parser);
  if (diag) fy_diag_destroy(diag);
}

/// Length of the UTF-8 character at c, 0 where there is none (RFC 3629).
static size_t utf8_length(const unsigned char *c, size_t left) {
  if (c[0] < 0x80) return 1;
  size_t n = c[0] >= 0xF0 && c[0] <= 0xF4  ? 4
             : c[0] >= 0xE0 && c[0] < 0xF0 ? 3
             : c[0] >= 0xC2 && c[0] < 0xE0 ? 2
                                           : 0;
  if (n == 0 || n > left) return 0;
  for (size_t i = 1; i < n; i++)
    if ((c[i] & 0xC0) != 0x80) return 0;
  bool is_overlong = (c[0] == 0xE0 && c[1] < 0xA0) || (c[0] == 0xF0 && c[1] < 0x90);
  bool is_beyond = (c[0] == 0xED && c[1] > 0x9F) || (c[0] == 0xF4 && c[1] > 0x8F);
  return is_overlong || is_beyond ? 0 : n;
}

/// Bytes that YAML does not allow end its text silently in the parser, so they are found before.
static bool is_clean_text(Builder *b, const char *text, size_t length) {
  b->line = b->column = 1;
  for (size_t i = 0; i < length;) {
    const unsigned char *c = (const unsigned char *)text + i;
    size_t n = utf8_length(c, length - i);
    bool is_control = *c < 0x20 && *c != '\t' && *c != '\n' && *c != '\r';
    if (n == 0 || is_control || *c == 0x7f) {
      const char *what = lth_arena_print(b->arena, "%s, got byte 0x%02x; expected UTF-8 text",
                                         n == 0 ? "not UTF-8" : "a control character", *c);
      if (what) complain(b, what);
      return false;
    }
    b->column++;
    if (*c == '\n') b->line++, b->column = 1;
    i += n;
  }
  b->line = b->column = 1;
  return true;
}

LthNode *lth_yaml_parse(LthReport *report, const char *text, size_t length, const char *origin) {
  Builder b = {.report = report,
               .arena = report->arena,
               .origin = origin,
               .text = text,
               .length = length,
               .line = 1,
               .column = 1};
  if (length > LTH_YAML_BYTES_MAX) {
    complain(&b, "too large, got more than 16 MiB; expected a scene");
    return NULL;
  }
  if (!is_clean_text(&b, text, length)) return NULL;
  run_parser(&b, text, length);
  if (b.stop || b.arena->failed) return NULL;
  return b.root;
}
