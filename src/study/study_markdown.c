/// The same report as Markdown, with links to the drawings beside it, and as JSON.
#include "study/study_files.h"

#include "io/file.h"
#include "io/json.h"

#include <string.h>

/// Cells of tables end at a bar.
static void put(FILE *out, const char *text) {
  for (; *text; text++) {
    if (*text == '|') fputc('\\', out);
    fputc(*text, out);
  }
}

static void put_table(FILE *out, const LthTable *t) {
  char text[LTH_SHOWN_MAX];
  fprintf(out, "**%s**\n\n|", t->caption);
  if (t->row_title) {
    fputc(' ', out);
    put(out, t->row_title);
    fputs(" |", out);
  }
  for (int c = 0; c < t->n_columns; c++) {
    fputc(' ', out);
    put(out, t->column[c].name);
    if (*t->column[c].unit) fprintf(out, " [%s]", t->column[c].unit);
    fputs(" |", out);
  }
  fputs("\n|", out);
  if (t->row_title) fputs(" --- |", out);
  for (int c = 0; c < t->n_columns; c++) fputs(" ---: |", out);
  fputc('\n', out);
  for (int row = 0; row < t->n_rows; row++) {
    fputc('|', out);
    if (t->row_title) {
      fputc(' ', out);
      put(out, t->word[row] ? t->word[row] : "");
      fputs(" |", out);
    }
    for (int c = 0; c < t->n_columns; c++)
      fprintf(out, " %s |", lth_shown_number(lth_table_at(t, row, c), t->column[c].digits, text));
    fputc('\n', out);
  }
  fputc('\n', out);
}

static void put_item(FILE *out, const LthStudyRun *run, const LthItem *item) {
  char text[4 * LTH_SHOWN_MAX];
  const char *study = run->study->name;
  if (item->kind == LTH_ITEM_TEXT) fprintf(out, "%s\n\n", item->text);
  if (item->kind == LTH_ITEM_TABLE && !item->table->is_curve) put_table(out, item->table);
  if (item->kind == LTH_ITEM_PLOT && item->plot->svg)
    fprintf(out, "![%s](%s/%s.svg)\n\n", item->plot->title, study, item->plot->name);
  if (item->kind == LTH_ITEM_PICTURE)
    fprintf(out, "![%s](%s/%s.svg)\n\n%s\n\n", item->picture->caption, study, item->picture->name,
            item->picture->caption);
  if (item->kind == LTH_ITEM_CHECK)
    fprintf(out, "- %s: %s: %s. %s\n%s", lth_shown_verdict(lth_check_holds(item->check)),
            item->check->what, lth_shown_check(item->check, text), item->check->reason,
            item->next && item->next->kind == LTH_ITEM_CHECK ? "" : "\n");
}

LitheStatus lth_study_write_markdown(LitheCtx *ctx, const char *folder, const LthPageHead *head,
                                     const LthStudyRun *runs) {
  char *path;
  LthFileWriter writer;
  LITHE_TRY(lth_path_join(ctx, folder, "index.md", &path));
  LitheStatus status = lth_file_open(ctx, path, &writer);
  lth_free(ctx, path);
  LITHE_TRY(status);
  FILE *out = writer.stream;
  fprintf(out, "# %s\n\n`%s`, %.1f s\n\n", head->title, head->command, head->seconds);
  for (const LthStudyRun *run = runs; run; run = run->next) {
    fprintf(out, "## %s: %s\n\n*%s*\n\n", run->study->name, run->study->title,
            run->study->question);
    for (const LthItem *item = run->report.first; item; item = item->next) put_item(out, run, item);
    if (run->trouble) fprintf(out, "STOPPED: %s\n\n", run->trouble);
    fprintf(out, "`lithe study %s%s`, %.1f s\n\n", run->study->name, run->quick ? " --quick" : "",
            run->seconds);
  }
  return lth_file_commit(ctx, &writer);
}

static void put_check(LthJson *json, const LthCheck *check) {
  lth_json_begin_object(json, NULL);
  lth_json_string(json, "what", check->what);
  lth_json_number(json, "value", check->value);
  lth_json_number(json, check->relation == LTH_AT_MOST ? "at_most" : "at_least", check->bound);
  lth_json_string(json, "reason", check->reason);
  lth_json_bool(json, "holds", lth_check_holds(check));
  lth_json_end_object(json);
}

static void put_names(LthJson *json, const LthStudyRun *run, LthItemKind kind, const char *key) {
  lth_json_begin_array(json, key);
  for (const LthItem *item = run->report.first; item; item = item->next) {
    if (item->kind != kind) continue;
    if (kind == LTH_ITEM_TABLE) lth_json_string(json, NULL, item->table->name);
    if (kind == LTH_ITEM_PLOT) lth_json_string(json, NULL, item->plot->name);
    if (kind == LTH_ITEM_PICTURE) lth_json_string(json, NULL, item->picture->name);
  }
  lth_json_end_array(json);
}

static void put_run(LthJson *json, const LthStudyRun *run) {
  lth_json_begin_object(json, NULL);
  lth_json_string(json, "name", run->study->name);
  lth_json_string(json, "title", run->study->title);
  lth_json_bool(json, "holds", lth_study_holds(run));
  if (run->trouble) lth_json_string(json, "stopped", run->trouble);
  lth_json_begin_array(json, "checks");
  for (const LthItem *item = run->report.first; item; item = item->next)
    if (item->kind == LTH_ITEM_CHECK) put_check(json, item->check);
  lth_json_end_array(json);
  put_names(json, run, LTH_ITEM_TABLE, "tables");
  put_names(json, run, LTH_ITEM_PLOT, "plots");
  put_names(json, run, LTH_ITEM_PICTURE, "pictures");
  lth_json_string(json, "folder", run->folder);
  lth_json_number(json, "seconds", run->seconds);
  lth_json_end_object(json);
}

static LitheStatus write_text(LitheCtx *ctx, const char *folder, const char *text) {
  char *path;
  LthFileWriter writer;
  LITHE_TRY(lth_path_join(ctx, folder, "study.json", &path));
  LitheStatus status = lth_file_open(ctx, path, &writer);
  lth_free(ctx, path);
  LITHE_TRY(status);
  fputs(text, writer.stream);
  return lth_file_commit(ctx, &writer);
}

LitheStatus lth_study_write_json(LitheCtx *ctx, const char *folder, const LthPageHead *head,
                                 const LthStudyRun *runs, char **text) {
  LthJson *json;
  const char *whole;
  LITHE_TRY(lth_json_create(ctx, &json));
  lth_json_begin_object(json, NULL);
  lth_json_string(json, "command", head->command);
  lth_json_begin_array(json, "studies");
  for (const LthStudyRun *run = runs; run; run = run->next) put_run(json, run);
  lth_json_end_array(json);
  lth_json_number(json, "seconds", head->seconds);
  lth_json_end_object(json);
  LitheStatus status = lth_json_text(json, &whole);
  if (status == LITHE_OK) status = lth_copy_text(ctx, whole, text);
  lth_json_destroy(ctx, &json);
  return status == LITHE_OK ? write_text(ctx, folder, *text) : status;
}
