/// Scenes run through the same door as a user's, and the figures of their results.
#include "study/study_run.h"

#include "io/file.h"
#include "io/text.h"
#include "scene/yaml.h"
#include "study/study_plan.h"

#include <stdio.h>
#include <string.h>

const char *lth_study_print(LthStudyRun *run, const char *format, ...) {
  va_list args, again;
  va_start(args, format);
  va_copy(again, args);
  int length = vsnprintf(NULL, 0, format, args);
  va_end(args);
  char *text = length < 0 ? NULL : lth_arena_take(&run->arena, (size_t)length + 1);
  if (text) vsnprintf(text, (size_t)length + 1, format, again);
  va_end(again);
  return text ? text : "";
}

static LitheStatus write_text(LitheCtx *ctx, const char *path, const char *text) {
  LthFileWriter writer;
  LITHE_TRY(lth_file_open(ctx, path, &writer));
  fputs(text, writer.stream);
  return lth_file_commit(ctx, &writer);
}

LitheStatus lth_study_parse(LthStudyRun *run, const char *json, const LthNode **node) {
  LthReport report = {.arena = &run->arena, .file = "result.json"};
  *node = lth_yaml_parse(&report, json, strlen(json), NULL);
  if (run->arena.failed) LITHE_FAIL(run->ctx, LITHE_NO_MEMORY, "out of memory in a study");
  if (!*node) LITHE_FAIL(run->ctx, LITHE_BAD_INPUT, "%s: no result of a run", run->folder);
  return LITHE_OK;
}

/// Bad scenes say all their errors in the log of the study, the message says the first.
static LitheStatus run_file(LthStudyRun *run, const char *file, const char *folder,
                            const LitheSceneDef *def, const LthRunLook *look,
                            LthStudyResult *result) {
  LitheScene *scene = NULL;
  LitheResult *out = NULL;
  LitheSceneDef local = *def;
  local.file = file;
  LitheStatus status = lithe_scene_read(run->ctx, &local, &scene);
  if (status == LITHE_OK) status = lth_run_looked_at(run->ctx, scene, folder, look, &out);
  if (status == LITHE_OK || status == LITHE_NOT_CONVERGED) {
    result->status = status;
    const char *json = lithe_result_json(out);
    status = lth_study_parse(run, json, &result->json);
  }
  lithe_result_destroy(run->ctx, &out);
  lithe_scene_destroy(run->ctx, &scene);
  return status;
}

LitheStatus lth_study_run_with(LthStudyRun *run, const char *name, const char *text, int n,
                               const char *const *more, const LthRunLook *look,
                               LthStudyResult *result) {
  *result = (LthStudyResult){0};
  int n_all = run->n_overrides + n;
  const char **overrides = lth_arena_take(&run->arena, sizeof *overrides * (size_t)(n_all + 1));
  const char *folder = lth_study_print(run, "%s/%s", run->folder, name);
  const char *file = lth_study_print(run, "%s.yaml", folder);
  if (!overrides || run->arena.failed)
    LITHE_FAIL(run->ctx, LITHE_NO_MEMORY, "out of memory in a study");
  for (int i = 0; i < n; i++) overrides[i] = more[i];
  for (int i = 0; i < run->n_overrides; i++) overrides[n + i] = run->overrides[i];

  if (run->plan) lth_study_plan_tell(run->plan, run->ctx, run->study->name);
  lth_progress(run->ctx, name, -1);
  LITHE_TRY(lth_folder_make(run->ctx, run->folder));
  LITHE_TRY(write_text(run->ctx, file, text));
  LitheSceneDef def = lithe_scene_def_default();
  def.overrides = overrides;
  def.n_overrides = n_all;
  return run_file(run, file, folder, &def, look, result);
}

LitheStatus lth_study_run_text(LthStudyRun *run, const char *name, const char *text,
                               const LthRunLook *look, LthStudyResult *result) {
  return lth_study_run_with(run, name, text, 0, NULL, look, result);
}

/// The child whose key is the first `length` bytes of `path`.
static const LthNode *child_named(const LthNode *node, const char *path, size_t length) {
  LitheIndex i = 0;
  for (const LthNode *child = node->first; child; child = child->next, i++) {
    char number[16];
    const char *key = child->key;
    if (node->kind == LTH_NODE_LIST) {
      snprintf(number, sizeof number, "%d", i);
      key = number;
    }
    if (key && strlen(key) == length && strncmp(key, path, length) == 0) return child;
  }
  return NULL;
}

const LthNode *lth_study_node(const LthNode *node, const char *path) {
  if (!node) return NULL;
  size_t length = strlen(path);
  const LthNode *whole = child_named(node, path, length);
  if (whole) return whole;

  // keys may contain dots themselves: the longest that leads on wins
  for (size_t i = length; i-- > 1;) {
    if (path[i] != '.') continue;
    const LthNode *child = child_named(node, path, i);
    const LthNode *found = child ? lth_study_node(child, path + i + 1) : NULL;
    if (found) return found;
  }
  return NULL;
}

double lth_study_number(const LthStudyResult *result, const char *path) {
  const LthNode *node = lth_study_node(result->json, path);
  double value;
  if (!node || node->kind != LTH_NODE_SCALAR) return NAN;
  if (!lth_word_number((LthWord){node->text, strlen(node->text)}, &value)) return NAN;
  return value;
}
