/// Tables and pictures of a study as files, and the text that a terminal shows.
#include "study/study_files.h"

#include "io/file.h"
#include "io/number_text.h"

#include <string.h>

const char *lth_shown_number(double value, int digits, char text[LTH_SHOWN_MAX]) {
  if (isnan(value)) return strcpy(text, "");
  if (digits == 0 || (value == rint(value) && fabs(value) < 1e9)) {
    snprintf(text, LTH_SHOWN_MAX, "%.0f", value);
    return text;
  }
  snprintf(text, LTH_SHOWN_MAX, "%#.*g", digits, value);
  size_t length = strlen(text);
  if (length > 1 && text[length - 1] == '.') text[length - 1] = 0;
  return text;
}

const char *lth_shown_check(const LthCheck *check, char text[4 * LTH_SHOWN_MAX]) {
  char value[LTH_SHOWN_MAX], bound[LTH_SHOWN_MAX];
  const char *shown = lth_shown_number(check->value, 4, value);
  snprintf(text, (size_t)4 * LTH_SHOWN_MAX, "%s, to be at %s %s", *shown ? shown : "nothing",
           check->relation == LTH_AT_MOST ? "most" : "least",
           lth_shown_number(check->bound, 4, bound));
  return text;
}

const char *lth_shown_verdict(bool holds) { return holds ? "holds" : "DOES NOT HOLD"; }

int lth_study_checks(const LthStudyReport *report, int *n_failed) {
  int n = 0;
  *n_failed = 0;
  for (const LthItem *item = report->first; item; item = item->next) {
    if (item->kind != LTH_ITEM_CHECK) continue;
    n++;
    if (!lth_check_holds(item->check)) ++*n_failed;
  }
  return n;
}

bool lth_study_holds(const LthStudyRun *run) {
  int n_failed;
  lth_study_checks(&run->report, &n_failed);
  return n_failed == 0 && !run->trouble;
}

/// Open FOLDER/<name><ending>.
static LitheStatus open_file(const LthStudyRun *run, const char *name, const char *ending,
                             LthFileWriter *writer) {
  char *path;
  LITHE_TRY(lth_path_ending(run->ctx, run->folder, name, ending, &path));
  LitheStatus status = lth_file_open(run->ctx, path, writer);
  lth_free(run->ctx, path);
  return status;
}

static void put_quoted(FILE *out, const char *text) {
  fputc('"', out);
  for (; *text; text++) {
    if (*text == '"') fputc('"', out);
    fputc(*text, out);
  }
  fputc('"', out);
}

static void put_csv(FILE *out, const LthTable *t) {
  char text[LTH_NUMBER_TEXT_MAX];
  if (t->row_title) put_quoted(out, t->row_title);
  for (int c = 0; c < t->n_columns; c++) {
    char name[200];
    const LthColumn *column = t->column + c;
    snprintf(name, sizeof name, *column->unit ? "%s [%s]" : "%s", column->name, column->unit);
    if (c > 0 || t->row_title) fputc(',', out);
    put_quoted(out, name);
  }
  fputc('\n', out);
  for (int row = 0; row < t->n_rows; row++) {
    if (t->row_title) put_quoted(out, t->word[row] ? t->word[row] : "");
    for (int c = 0; c < t->n_columns; c++) {
      double value = lth_table_at(t, row, c);
      if (c > 0 || t->row_title) fputc(',', out);
      if (isfinite(value)) fputs(lth_number_text(value, text), out);
    }
    fputc('\n', out);
  }
}

LitheStatus lth_study_write_tables(const LthStudyRun *run) {
  for (const LthItem *item = run->report.first; item; item = item->next) {
    LthFileWriter writer;
    if (item->kind != LTH_ITEM_TABLE) continue;
    LITHE_TRY(open_file(run, item->table->name, "csv", &writer));
    put_csv(writer.stream, item->table);
    LITHE_TRY(lth_file_commit(run->ctx, &writer));
  }
  return LITHE_OK;
}

LitheStatus lth_study_write_pictures(const LthStudyRun *run) {
  for (const LthItem *item = run->report.first; item; item = item->next) {
    LthFileWriter writer;
    if (item->kind != LTH_ITEM_PICTURE) continue;
    LITHE_TRY(open_file(run, item->picture->name, "svg", &writer));
    fputs(item->picture->svg, writer.stream);
    fputc('\n', writer.stream);
    LITHE_TRY(lth_file_commit(run->ctx, &writer));
  }
  return LITHE_OK;
}

/// Letters as a terminal shows them: bytes that do not go on with one.
static int width(const char *text) {
  int n = 0;
  for (; *text; text++) n += ((unsigned char)*text & 0xC0) != 0x80;
  return n;
}

static void put_padded(FILE *out, const char *text, int to, bool is_left) {
  int blanks = to > width(text) ? to - width(text) : 0;
  if (is_left)
    fprintf(out, "%s%*s", text, blanks, "");
  else
    fprintf(out, "%*s%s", blanks, "", text);
}

static void put_text_table(FILE *out, const LthTable *t) {
  char text[LTH_SHOWN_MAX], heading[200];
  int words = t->row_title ? width(t->row_title) : 0, wide[LTH_TABLE_COLUMNS_MAX];
  for (int row = 0; row < t->n_rows && t->row_title; row++)
    if (t->word[row] && width(t->word[row]) > words) words = width(t->word[row]);
  fprintf(out, "  %s\n", t->caption);
  fputs("    ", out);
  put_padded(out, t->row_title ? t->row_title : "", words, true);
  for (int c = 0; c < t->n_columns; c++) {
    const LthColumn *column = t->column + c;
    snprintf(heading, sizeof heading, *column->unit ? "%s [%s]" : "%s", column->name, column->unit);
    wide[c] = width(heading);
    for (int row = 0; row < t->n_rows; row++) {
      int w = width(lth_shown_number(lth_table_at(t, row, c), column->digits, text));
      if (w > wide[c]) wide[c] = w;
    }
    fputs("  ", out);
    put_padded(out, heading, wide[c], false);
  }
  fputc('\n', out);
  for (int row = 0; row < t->n_rows; row++) {
    fputs("    ", out);
    put_padded(out, t->word[row] ? t->word[row] : "", words, true);
    for (int c = 0; c < t->n_columns; c++) {
      fputs("  ", out);
      put_padded(out, lth_shown_number(lth_table_at(t, row, c), t->column[c].digits, text), wide[c],
                 false);
    }
    fputc('\n', out);
  }
}

static void put_text_item(FILE *out, const LthStudyRun *run, const LthItem *item) {
  char text[4 * LTH_SHOWN_MAX];
  if (item->kind == LTH_ITEM_TEXT) fprintf(out, "  %s\n", item->text);
  if (item->kind == LTH_ITEM_TABLE && (item->table->is_long || item->table->is_curve))
    fprintf(out, "  table    %s/%s.csv\n", run->folder, item->table->name);
  else if (item->kind == LTH_ITEM_TABLE)
    put_text_table(out, item->table);
  if (item->kind == LTH_ITEM_PLOT)
    fprintf(out, "  plot     %s/%s.%s\n", run->folder, item->plot->name,
            item->plot->svg ? "svg" : "gp");
  if (item->kind == LTH_ITEM_PICTURE)
    fprintf(out, "  picture  %s/%s.svg\n", run->folder, item->picture->name);
  if (item->kind == LTH_ITEM_CHECK)
    fprintf(out, "  %-8s %s: %s\n", lth_shown_verdict(lth_check_holds(item->check)),
            item->check->what, lth_shown_check(item->check, text));
}

LitheStatus lth_study_write_text(const LthStudyRun *run, char **text) {
  char *path;
  size_t size;
  LthFileWriter writer;
  int n_failed, n = lth_study_checks(&run->report, &n_failed);
  LITHE_TRY(open_file(run, "report", "txt", &writer));
  FILE *out = writer.stream;
  fprintf(out, "%s: %s\n", run->study->name, run->study->title);
  for (const LthItem *item = run->report.first; item; item = item->next)
    put_text_item(out, run, item);
  if (run->trouble)
    fprintf(out, "  STOPPED  %s\n", run->trouble);
  else if (n > 0)
    fprintf(out, "  %d of %d verdicts hold\n", n - n_failed, n);
  fprintf(out, "  %.1f s\n", run->seconds);
  LITHE_TRY(lth_file_commit(run->ctx, &writer));
  LITHE_TRY(lth_path_join(run->ctx, run->folder, "report.txt", &path));
  LitheStatus status = lth_file_read(run->ctx, path, text, &size);
  lth_free(run->ctx, path);
  return status;
}
