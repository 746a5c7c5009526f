/// What a study has to show, in order: sentences, tables, plots, pictures, verdicts.
#include "study/study_report.h"

#include "base/ctx.h"
#include "study/orders.h"

#include <stdio.h>
#include <string.h>

static const char *copy(LthArena *arena, const char *text) {
  return text ? lth_arena_text(arena, text, strlen(text)) : NULL;
}

static LthItem *append(LthStudyReport *report, LthItemKind kind) {
  LthItem *item = lth_arena_take(report->arena, sizeof *item);
  if (!item) return NULL;
  item->kind = kind;
  if (report->last)
    report->last->next = item;
  else
    report->first = item;
  report->last = item;
  return item;
}

void lth_study_say(LthStudyReport *report, const char *format, ...) {
  char text[2000];
  va_list args;
  va_start(args, format);
  vsnprintf(text, sizeof text, format, args);
  va_end(args);
  const char *kept = copy(report->arena, text);
  LthItem *item = kept ? append(report, LTH_ITEM_TEXT) : NULL;
  if (item) item->text = kept;
}

int lth_table_column(LthTable *table, const char *name, const char *unit, int digits) {
  LITHE_ASSERT(table->n_columns < LTH_TABLE_COLUMNS_MAX && table->n_rows == 0);
  if (table->n_columns == LTH_TABLE_COLUMNS_MAX) return LTH_TABLE_COLUMNS_MAX - 1;
  table->column[table->n_columns] =
      (LthColumn){copy(table->arena, name), copy(table->arena, unit), digits};
  return table->n_columns++;
}

/// Twice the rows; what was there is left to the arena.
static bool grow(LthTable *table) {
  int cap = table->cap_rows ? 2 * table->cap_rows : 16;
  size_t row = sizeof *table->value * (size_t)table->n_columns;
  double *value = lth_arena_take(table->arena, row * (size_t)cap);
  const char **word = lth_arena_take(table->arena, sizeof *word * (size_t)cap);
  if (!value || !word) return false;
  if (table->n_rows > 0) {
    memcpy(value, table->value, row * (size_t)table->n_rows);
    memcpy(word, table->word, sizeof *word * (size_t)table->n_rows);
  }
  table->value = value;
  table->word = word;
  table->cap_rows = cap;
  return true;
}

void lth_table_row(LthTable *table, const char *word, const double *values) {
  if (table->n_rows == table->cap_rows && !grow(table)) return;
  memcpy(table->value + (size_t)table->n_rows * (size_t)table->n_columns, values,
         sizeof *values * (size_t)table->n_columns);
  table->word[table->n_rows++] = copy(table->arena, word);
}

double lth_table_at(const LthTable *table, int row, int column) {
  if (row < 0 || row >= table->n_rows || column < 0 || column >= table->n_columns) return NAN;
  return table->value[(size_t)row * (size_t)table->n_columns + (size_t)column];
}

LthTable *lth_study_table(LthStudyReport *report, const char *name, const char *caption,
                          const char *row_title) {
  LthTable *table = lth_arena_take(report->arena, sizeof *table);
  LthItem *item = table ? append(report, LTH_ITEM_TABLE) : NULL;
  if (!item) {
    report->no_table = (LthTable){.arena = report->arena};
    return &report->no_table;
  }
  *table = (LthTable){.arena = report->arena,
                      .name = copy(report->arena, name),
                      .caption = copy(report->arena, caption),
                      .row_title = copy(report->arena, row_title)};
  item->table = table;
  return table;
}

LthPlot *lth_study_plot(LthStudyReport *report, const char *name, const char *title,
                        const char *x_label, const char *y_label) {
  LthPlot *plot = lth_arena_take(report->arena, sizeof *plot);
  LthItem *item = plot ? append(report, LTH_ITEM_PLOT) : NULL;
  if (!item) {
    report->no_plot = (LthPlot){0};
    return &report->no_plot;
  }
  *plot = (LthPlot){.name = copy(report->arena, name),
                    .title = copy(report->arena, title),
                    .x_label = copy(report->arena, x_label),
                    .y_label = copy(report->arena, y_label)};
  item->plot = plot;
  return plot;
}

void lth_plot_rows(LthPlot *plot, const char *name, const LthTable *table, int x, int y, int first,
                   int last) {
  LITHE_ASSERT(plot->n_series < LTH_PLOT_SERIES_MAX);
  if (plot->n_series == LTH_PLOT_SERIES_MAX) return;
  plot->series[plot->n_series++] = (LthSeries){.name = copy(table->arena, name),
                                               .table = table,
                                               .x = x,
                                               .y = y,
                                               .first = first,
                                               .last = last};
}

void lth_plot_series(LthPlot *plot, const char *name, const LthTable *table, int x, int y) {
  lth_plot_rows(plot, name, table, x, y, 0, table->n_rows);
}

void lth_plot_printed(LthPlot *plot, const char *name, const LthTable *table, int x, int y) {
  lth_plot_series(plot, name, table, x, y);
  if (plot->n_series > 0) plot->series[plot->n_series - 1].is_printed = true;
}

/// Exponent of y over a column.
static double fit(const LthSeries *series, int column, double *factor) {
  double x[256], y[256];
  int n = 0;
  for (int row = series->first; row < series->last && n < 256; row++, n++) {
    x[n] = lth_table_at(series->table, row, column);
    y[n] = lth_table_at(series->table, row, series->y);
  }
  return lth_order_fit(n, x, y, factor);
}

double lth_plot_order(const LthPlot *plot, const LthSeries *series) {
  switch (plot->orders) {
  case LTH_PLOT_NO_ORDERS:
    return NAN;
  case LTH_PLOT_ORDERS_OF_H:
    return fit(series, series->x, NULL);
  case LTH_PLOT_ORDERS_OF_CELLS:
    return -fit(series, series->x, NULL);
  case LTH_PLOT_ORDERS_BESIDE:
    return -fit(series, series->cells, NULL);
  }
  return NAN;
}

bool lth_plot_line(const LthPlot *plot, const LthSeries *series, double *factor, double *power) {
  *factor = NAN;
  *power = plot->orders == LTH_PLOT_NO_ORDERS ? NAN : fit(series, series->x, factor);
  return isfinite(*power) && isfinite(*factor);
}

void lth_study_picture(LthStudyReport *report, const char *name, const char *caption,
                       const char *svg) {
  LthPicture *picture = lth_arena_take(report->arena, sizeof *picture);
  LthItem *item = picture ? append(report, LTH_ITEM_PICTURE) : NULL;
  if (!item) return;
  *picture = (LthPicture){copy(report->arena, name), copy(report->arena, caption),
                          copy(report->arena, svg)};
  item->picture = picture;
}

static void add_check(LthStudyReport *report, LthCheck check) {
  LthCheck *kept = lth_arena_take(report->arena, sizeof *kept);
  LthItem *item = kept ? append(report, LTH_ITEM_CHECK) : NULL;
  if (!item) return;
  *kept = check;
  kept->what = copy(report->arena, check.what);
  kept->reason = copy(report->arena, check.reason);
  item->check = kept;
}

void lth_study_at_most(LthStudyReport *report, const char *what, double value, double bound,
                       const char *reason) {
  add_check(report, (LthCheck){what, value, bound, LTH_AT_MOST, reason});
}

void lth_study_at_least(LthStudyReport *report, const char *what, double value, double bound,
                        const char *reason) {
  add_check(report, (LthCheck){what, value, bound, LTH_AT_LEAST, reason});
}

bool lth_check_holds(const LthCheck *check) {
  return check->relation == LTH_AT_MOST ? check->value <= check->bound
                                        : check->value >= check->bound;
}
