/// Everything that is wrong with a scene file, gathered while reading goes on.
#pragma once

#include "scene/node.h"
#include "scene/scene.h"

typedef struct LthReportEntry LthReportEntry;

/// Zero-initialise, set arena and file.
typedef struct LthReport {
  LthArena *arena;
  const char *file;
  LthReportEntry *first;
  LitheIndex n; ///< found; only the first LTH_REPORT_MAX are kept
} LthReport;

#define LTH_REPORT_MAX 100

/// "FILE:LINE:COLUMN: PATH: text" at a node, which is marked as bad. The text has the form "what is wrong,
/// got VALUE; what is expected".
void lth_report(LthReport *report, const LthNode *node, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/// The same at a node's key (unknown and repeated keys), and for a key that is missing from a map.
void lth_report_key(LthReport *report, const LthNode *node, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
void lth_report_missing(LthReport *report, const LthNode *map, const char *key, const char *format,
                        ...) __attribute__((format(printf, 4, 5)));

/// At a place of the file that has no node; line 0: none.
void lth_report_at(LthReport *report, int line, int column, const char *format, ...)
    __attribute__((format(printf, 4, 5)));

/// About an option: "--set ...: text".
void lth_report_option(LthReport *report, const char *origin, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/// "FILE:LINE:COLUMN: PATH" of a node; in the report's arena, "" where memory is out.
const char *lth_report_place(LthReport *report, const LthNode *node);

/// A node's value for a message: scalars quoted as they need, cut and without control characters;
/// "a list of 3", "a mapping".
const char *lth_show(LthArena *arena, const LthNode *node);

/// The same for any text.
const char *lth_show_text(LthArena *arena, const char *text);

/// Move all entries into `errors`, sorted by their place in the file.
LitheStatus lth_report_finish(LthReport *report, LitheCtx *ctx, LthSceneErrors *errors);

/// Number of letters to change, add, drop or swap to make `b` of `a`; at most `limit + 1`.
int lth_word_distance(const char *a, const char *b, int limit);

/// The word of the list nearest to `word`, NULL where none is near enough to be meant.
const char *lth_nearest_word(const char *word, const char *const *words, int n_words);
