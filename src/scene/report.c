/// Gathering errors with their places, and words that may have been meant.
#include "scene/report.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MESSAGE_MAX 1200
#define SHOWN_MAX 60
#define WORD_MAX 40

struct LthReportEntry {
  LthReportEntry *next;
  int line, column;
  LitheIndex order;
  const char *text;
};

typedef struct Place {
  const char *origin;
  int line, column;
} Place;

/// "FILE:LINE:COLUMN: PATH", or as much of it as there is.
static const char *print_place(const LthReport *report, Place at, const char *path) {
  LthArena *arena = report->arena;
  const char *colon = *path ? ": " : "";
  if (at.origin) return lth_arena_print(arena, "%s%s%s", at.origin, colon, path);
  if (at.line <= 0) return lth_arena_print(arena, "%s%s%s", report->file, colon, path);
  return lth_arena_print(arena, "%s:%d:%d%s%s", report->file, at.line, at.column, colon, path);
}

static void add_entry(LthReport *report, Place at, const char *path, const char *format,
                      va_list args) {
  char text[MESSAGE_MAX];
  LitheIndex order = report->n++;
  if (order >= LTH_REPORT_MAX) return;
  // NOLINTNEXTLINE(clang-analyzer-valist.Uninitialized): clang 14 loses va_start when it inlines
  vsnprintf(text, sizeof text, format, args);
  LthArena *arena = report->arena;
  LthReportEntry *entry = lth_arena_take(arena, sizeof *entry);
  if (!entry || !path) return;
  const char *place = print_place(report, at, path);
  if (place) entry->text = lth_arena_print(arena, "%s: %s", place, text);
  entry->line = at.origin ? 1 << 30 : at.line;
  entry->column = at.column;
  entry->order = order;
  entry->next = report->first;
  report->first = entry;
}

const char *lth_report_place(LthReport *report, const LthNode *node) {
  const char *path = lth_node_path(report->arena, node, NULL);
  if (!path) return "";
  const char *place = print_place(report, (Place){node->origin, node->line, node->column}, path);
  return place ? place : "";
}

/// The mark is bookkeeping, not content: readers hold their nodes as const.
static void mark_bad(const LthNode *node) { ((LthNode *)node)->bad = true; }

void lth_report(LthReport *report, const LthNode *node, const char *format, ...) {
  va_list args;
  va_start(args, format);
  add_entry(report, (Place){node->origin, node->line, node->column},
            lth_node_path(report->arena, node, NULL), format, args);
  va_end(args);
  mark_bad(node);
}

void lth_report_key(LthReport *report, const LthNode *node, const char *format, ...) {
  va_list args;
  va_start(args, format);
  add_entry(report, (Place){node->origin, node->key_line, node->key_column},
            lth_node_path(report->arena, node, NULL), format, args);
  va_end(args);
  mark_bad(node);
}

void lth_report_missing(LthReport *report, const LthNode *map, const char *key, const char *format,
                        ...) {
  va_list args;
  va_start(args, format);
  add_entry(report, (Place){map->origin, map->line, map->column},
            lth_node_path(report->arena, map, key), format, args);
  va_end(args);
}

void lth_report_at(LthReport *report, int line, int column, const char *format, ...) {
  va_list args;
  va_start(args, format);
  add_entry(report, (Place){NULL, line, column}, "", format, args);
  va_end(args);
}

void lth_report_option(LthReport *report, const char *origin, const char *format, ...) {
  va_list args;
  va_start(args, format);
  add_entry(report, (Place){origin, 0, 0}, "", format, args);
  va_end(args);
}

/// Copy what can be shown of a text: at most SHOWN_MAX bytes, whole UTF-8 characters, no controls.
static void clean_text(const char *text, char shown[SHOWN_MAX + 4]) {
  size_t n = 0;
  bool is_cut = false;
  for (const char *c = text; *c; c++) {
    if (n == SHOWN_MAX) {
      is_cut = true;
      break;
    }
    bool is_control = (unsigned char)*c < 0x20 || *c == 0x7f;
    shown[n++] = is_control ? ' ' : *c;
  }
  // a cut may have gone through a character of several bytes: drop its beginning
  if (is_cut) {
    while (n > 0 && ((unsigned char)shown[n - 1] & 0xC0) == 0x80) n--;
    if (n > 0 && (unsigned char)shown[n - 1] >= 0xC0) n--;
    for (int i = 0; i < 3; i++) shown[n++] = '.';
  }
  shown[n] = 0;
}

const char *lth_show_text(LthArena *arena, const char *text) {
  char shown[SHOWN_MAX + 4];
  clean_text(text, shown);
  const char *result = lth_arena_print(arena, "\"%s\"", shown);
  return result ? result : "";
}

const char *lth_show(LthArena *arena, const LthNode *node) {
  if (node->kind == LTH_NODE_MAP) return node->n_children ? "a mapping" : "an empty mapping";
  if (node->kind == LTH_NODE_LIST) {
    if (!node->n_children) return "an empty list";
    LitheIndex n = node->n_children; // without what the schema has added behind
    if (!node->is_default && node->last->is_default) n--;
    const char *text = lth_arena_print(arena, "a list of %d", n);
    return text ? text : "";
  }
  if (lth_node_is_null(node)) return "nothing";
  return lth_show_text(arena, node->text);
}

static int compare_entries(const void *a, const void *b) {
  const LthReportEntry *x = *(const LthReportEntry *const *)a;
  const LthReportEntry *y = *(const LthReportEntry *const *)b;
  if (x->line != y->line) return x->line < y->line ? -1 : 1;
  if (x->column != y->column) return x->column < y->column ? -1 : 1;
  return x->order < y->order ? -1 : x->order > y->order;
}

LitheStatus lth_report_finish(LthReport *report, LitheCtx *ctx, LthSceneErrors *errors) {
  LitheStatus status = LITHE_OK;
  LitheIndex kept = report->n < LTH_REPORT_MAX ? report->n : LTH_REPORT_MAX, n = 0;
  LitheIndex more = report->n - kept;
  const LthReportEntry **sorted = NULL;
  LTH_NEW_OR(done, ctx, sorted, kept + 1);
  for (const LthReportEntry *e = report->first; e; e = e->next)
    if (e->text) sorted[n++] = e;
  qsort(sorted, (size_t)n, sizeof *sorted, compare_entries);

  errors->ctx = ctx;
  LTH_NEW_OR(done, ctx, errors->lines, n + 1);
  for (LitheIndex i = 0; i < n; i++) {
    LITHE_TRY_OR(done, lth_copy_text(ctx, sorted[i]->text, &errors->lines[i]));
    errors->n = i + 1;
  }
  if (more > 0) {
    const char *text = lth_arena_print(report->arena, "%s: %d more errors", report->file, more);
    if (text) LITHE_TRY_OR(done, lth_copy_text(ctx, text, &errors->lines[n]));
    errors->n += text != NULL;
  }

done:
  lth_free(ctx, sorted);
  return status;
}

void lth_scene_errors_free(LthSceneErrors *errors) {
  for (LitheIndex i = 0; i < errors->n; i++) lth_free(errors->ctx, errors->lines[i]);
  if (errors->lines) lth_free(errors->ctx, errors->lines);
  *errors = (LthSceneErrors){0};
}

int lth_word_distance(const char *a, const char *b, int limit) {
  int n = (int)strnlen(a, WORD_MAX + 1), m = (int)strnlen(b, WORD_MAX + 1);
  if (n > WORD_MAX || m > WORD_MAX || abs(n - m) > limit) return limit + 1;
  int rows[3][WORD_MAX + 1];
  int *before = rows[0], *above = rows[1], *row = rows[2];
  for (int j = 0; j <= m; j++) above[j] = before[j] = j;
  for (int i = 1; i <= n; i++) {
    row[0] = i;
    for (int j = 1; j <= m; j++) {
      int best = above[j - 1] + (a[i - 1] != b[j - 1]);
      if (above[j] + 1 < best) best = above[j] + 1;
      if (row[j - 1] + 1 < best) best = row[j - 1] + 1;
      bool is_swap = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
      if (is_swap && before[j - 2] + 1 < best) best = before[j - 2] + 1;
      row[j] = best;
    }
    int *free_row = before;
    before = above, above = row, row = free_row;
  }
  return above[m] <= limit ? above[m] : limit + 1;
}

const char *lth_nearest_word(const char *word, const char *const *words, int n_words) {
  int length = (int)strnlen(word, WORD_MAX + 1);
  int limit = length <= 3 ? 1 : length <= 6 ? 2 : 3, best = limit + 1;
  const char *nearest = NULL;
  for (int i = 0; i < n_words; i++) {
    int distance = lth_word_distance(word, words[i], limit);
    // a word that is a beginning of a known one ("young" of "young_modulus") is meant too
    if (length >= 3 && strncmp(word, words[i], (size_t)length) == 0 && distance > 1) distance = 1;
    if (distance < best) {
      best = distance;
      nearest = words[i];
    }
  }
  return nearest;
}
