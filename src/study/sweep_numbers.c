/// Values of a sweep, and which numbers of a result are worth comparing.
#include "study/sweep.h"

#include "io/text.h"
#include "scene/quantity.h"

#include <stdio.h>
#include <string.h>

/// "16", "1/120", "2.5 cm" as an SI number; of "[8, 8, 8]" the first entry.
static double number_of(const char *text) {
  char first[64];
  double value, below = 1;
  LthUnit unit;
  size_t length = strcspn(text += strspn(text, "[ "), ",]"), split;
  if (length >= sizeof first) return NAN;
  memcpy(first, text, length);
  first[length] = 0;
  split = lth_quantity_split(first);
  if (split < length && !lth_unit_parse(first + split, &unit, NULL, NULL)) return NAN;
  double factor = split < length ? unit.factor : 1;
  while (split > 0 && first[split - 1] == ' ') split--;
  const char *slash = memchr(first, '/', split);
  size_t head = slash ? (size_t)(slash - first) : split;
  if (!lth_word_number((LthWord){first, head}, &value)) return NAN;
  if (slash && !lth_word_number((LthWord){slash + 1, split - head - 1}, &below)) return NAN;
  return value / below * factor;
}

static LthSweepKind kind_of(const char *key) {
  static const char *const counts[] = {"cells", "steps"};
  static const char *const lengths[] = {"cell_size", "step", "resolution"};
  for (size_t i = 0; i < sizeof counts / sizeof counts[0]; i++)
    if (strcmp(key, counts[i]) == 0) return LTH_SWEEP_CELLS;
  for (size_t i = 0; i < sizeof lengths / sizeof lengths[0]; i++)
    if (strcmp(key, lengths[i]) == 0) return LTH_SWEEP_LENGTH;
  return LTH_SWEEP_PLAIN;
}

/// Length of the value at the front of `text`: up to a comma outside brackets and quotes.
static size_t value_length(const char *text) {
  int depth = 0;
  char quote = 0;
  size_t i = 0;
  for (; text[i]; i++) {
    char c = text[i];
    if (quote) {
      if (c == quote) quote = 0;
    } else if (c == '"' || c == '\'') {
      quote = c;
    } else if (strchr("[{(", c)) {
      depth++;
    } else if (strchr("]})", c)) {
      depth--;
    } else if (c == ',' && depth <= 0) {
      break;
    }
  }
  return i;
}

static LitheStatus fail_sweep(LthStudyRun *run, const char *text) {
  LITHE_FAIL(run->ctx, LITHE_BAD_INPUT,
             "--sweep %s: expected PATH=VALUE,VALUE,... with 1 to %d values, as in "
             "bodies.0.method.cells=8,16,32",
             text, LTH_SWEEP_VALUES_MAX);
}

LitheStatus lth_sweep_parse(LthStudyRun *run, const char *text, LthSweep *sweep) {
  const char *equals = strchr(text, '=');
  *sweep = (LthSweep){0};
  if (!equals || equals == text) return fail_sweep(run, text);
  sweep->path = lth_study_print(run, "%.*s", (int)(equals - text), text);
  const char *dot = strrchr(sweep->path, '.');
  sweep->key = dot ? dot + 1 : sweep->path;
  sweep->kind = kind_of(sweep->key);
  for (const char *at = equals + 1;; at++) {
    size_t length = value_length(at);
    if (length == 0 || sweep->n == LTH_SWEEP_VALUES_MAX) return fail_sweep(run, text);
    const char *value = lth_study_print(run, "%.*s", (int)length, at);
    sweep->value[sweep->n++] = (LthSweepValue){value, number_of(value)};
    at += length;
    if (!*at) return LITHE_OK;
  }
}

double lth_sweep_length(const LthSweep *sweep, int i) {
  double number = sweep->value[i].number;
  if (sweep->kind == LTH_SWEEP_PLAIN || !(number > 0)) return NAN;
  return sweep->kind == LTH_SWEEP_CELLS ? 1 / number : number;
}

/// Where the main numbers of a result stand; `*` at the end of a pattern is anything.
static const struct {
  const char *pattern, *unit;
  bool is_error, is_field;
  int digits;
} kinds[] = {
    {"bodies.*.elements", "", false, false, 0},
    {"bodies.*.dofs", "", false, false, 0},
    {"bodies.*.volume", "m^3", false, true, 7},
    {"displacement.*", "m", false, true, 7},
    {"energy.*", "J", false, true, 7},
    {"reaction.*", "N", false, true, 7},
    {"stress.von_mises_max", "Pa", false, true, 6},
    {"stress.p99", "Pa", false, true, 6},
    {"stress.safety", "", false, true, 6},
    {"probes.*.displacement.*", "m", false, true, 7},
    {"probes.*.stress.*", "Pa", false, true, 6},
    {"probes.*.von_mises", "Pa", false, true, 6},
    {"error.*", "", true, false, 4},
    {"solver.iterations", "", false, false, 0},
    {"solver.condition", "", false, false, 4},
    {"time.total", "s", false, false, 3},
};

/// Whether a path fits a pattern; a star stands for one part, at the end for all that follows.
static bool fits(const char *path, const char *pattern) {
  for (; *pattern; pattern++, path++) {
    if (*pattern == '*') {
      if (!pattern[1]) return *path != 0;
      while (*path && *path != '.') path++;
      if (*path != pattern[1]) return false;
      path--;
    } else if (*path != *pattern) {
      return false;
    }
  }
  return *path == 0;
}

typedef struct Gathering {
  LthStudyRun *run;
  LthMainNumber *numbers;
  int n;
} Gathering;

static void take(Gathering *g, const char *path) {
  for (size_t k = 0; k < sizeof kinds / sizeof kinds[0]; k++) {
    if (!fits(path, kinds[k].pattern) || g->n == LTH_MAIN_NUMBERS_MAX) continue;
    g->numbers[g->n++] =
        (LthMainNumber){path, kinds[k].unit, kinds[k].is_error, kinds[k].is_field, kinds[k].digits};
    return;
  }
}

static void gather(Gathering *g, const LthNode *node, const char *path) {
  double value;
  if (node->kind == LTH_NODE_SCALAR) {
    if (node->plain && lth_word_number((LthWord){node->text, strlen(node->text)}, &value))
      take(g, path);
    return;
  }
  LitheIndex i = 0;
  for (const LthNode *child = node->first; child; child = child->next, i++) {
    const char *dot = *path ? "." : "";
    if (node->kind == LTH_NODE_MAP)
      gather(g, child, lth_study_print(g->run, "%s%s%s", path, dot, child->key));
    else
      gather(g, child, lth_study_print(g->run, "%s%s%d", path, dot, i));
  }
}

int lth_main_numbers(LthStudyRun *run, const LthNode *json,
                     LthMainNumber numbers[LTH_MAIN_NUMBERS_MAX]) {
  Gathering g = {run, numbers, 0};
  gather(&g, json, "");
  return g.n;
}
