/// What a study has to show, in order: sentences, tables, plots, pictures, verdicts.
#pragma once

#include "scene/arena.h"

#include <math.h>

#define LTH_TABLE_COLUMNS_MAX 112
#define LTH_PLOT_SERIES_MAX 16

/// A column of numbers. `unit` is "" where there is none.
typedef struct LthColumn {
  const char *name, *unit;
  int digits; ///< significant ones in texts and pages; files have all
} LthColumn;

/// Rows of numbers, each with a word in front where `row_title` is not NULL. NaN: nothing there.
typedef struct LthTable {
  LthArena *arena;
  const char *name; ///< stem of its file
  const char *caption;
  const char *row_title; ///< heading of the rows' words, or NULL
  LthColumn column[LTH_TABLE_COLUMNS_MAX];
  int n_columns;
  double *value; ///< (n_rows x n_columns)
  const char **word;
  int n_rows, cap_rows;
  bool is_long;  ///< too wide for a terminal: only its file is told there
  bool is_curve; ///< the points of a plot: only its file is told, on pages as well
} LthTable;

int lth_table_column(LthTable *table, const char *name, const char *unit, int digits);
/// Append a row (n_columns values, copied). No columns may follow.
void lth_table_row(LthTable *table, const char *word, const double *values);
double lth_table_at(const LthTable *table, int row, int column);

typedef enum LthPlotOrders {
  LTH_PLOT_NO_ORDERS,
  LTH_PLOT_ORDERS_OF_H,     ///< x is a length: errors go like x^p
  LTH_PLOT_ORDERS_OF_CELLS, ///< x is a number of cells: errors go like x^-p
  LTH_PLOT_ORDERS_BESIDE ///< x is a number of unknowns; what errors fall with has a column of its own
} LthPlotOrders;

/// Two columns of a table as points joined by lines, rows [first, last).
typedef struct LthSeries {
  const char *name;
  const LthTable *table;
  int x, y, first, last;
  int cells;       ///< column of LTH_PLOT_ORDERS_BESIDE
  bool is_printed; ///< a value from the literature: points only
} LthSeries;

typedef struct LthPlot {
  const char *name; ///< stem of its files
  const char *title, *x_label, *y_label;
  bool log_x, log_y;
  LthPlotOrders orders; ///< observed orders by least squares are drawn as lines and told in the key
  LthSeries series[LTH_PLOT_SERIES_MAX];
  int n_series;
  char *svg; ///< filled where it could be drawn
} LthPlot;

void lth_plot_series(LthPlot *plot, const char *name, const LthTable *table, int x, int y);
/// The same for some rows, and for values from the literature.
void lth_plot_rows(LthPlot *plot, const char *name, const LthTable *table, int x, int y, int first,
                   int last);
void lth_plot_printed(LthPlot *plot, const char *name, const LthTable *table, int x, int y);
/// Observed order of a series: positive where errors fall; NaN where there is none.
double lth_plot_order(const LthPlot *plot, const LthSeries *series);
/// The line factor x^power by least squares that a plot draws; false where there is none.
bool lth_plot_line(const LthPlot *plot, const LthSeries *series, double *factor, double *power);

/// A drawing that a study made itself: a whole <svg> element.
typedef struct LthPicture {
  const char *name, *caption, *svg;
} LthPicture;

typedef enum LthRelation { LTH_AT_MOST, LTH_AT_LEAST } LthRelation;

/// A verdict: a number against a bound that stands in the study's source with its reason. NaN never holds.
typedef struct LthCheck {
  const char *what;
  double value, bound;
  LthRelation relation;
  const char *reason;
} LthCheck;

bool lth_check_holds(const LthCheck *check);

typedef enum LthItemKind {
  LTH_ITEM_TEXT,
  LTH_ITEM_TABLE,
  LTH_ITEM_PLOT,
  LTH_ITEM_PICTURE,
  LTH_ITEM_CHECK
} LthItemKind;

typedef struct LthItem {
  LthItemKind kind;
  const char *text;
  LthTable *table;
  LthPlot *plot;
  LthPicture *picture;
  LthCheck *check;
  struct LthItem *next;
} LthItem;

/// Zero-initialise and set arena. Where memory is out the arena says so and items are missing.
typedef struct LthStudyReport {
  LthArena *arena;
  LthItem *first, *last;
  LthTable no_table; ///< what callers fill where memory is out
  LthPlot no_plot;
} LthStudyReport;

void lth_study_say(LthStudyReport *report, const char *format, ...)
    __attribute__((format(printf, 2, 3)));
/// Empty ones to be filled at once; never NULL, but not shown where memory is out. Texts are copied.
LthTable *lth_study_table(LthStudyReport *report, const char *name, const char *caption,
                          const char *row_title);
LthPlot *lth_study_plot(LthStudyReport *report, const char *name, const char *title,
                        const char *x_label, const char *y_label);
void lth_study_picture(LthStudyReport *report, const char *name, const char *caption,
                       const char *svg);
void lth_study_at_most(LthStudyReport *report, const char *what, double value, double bound,
                       const char *reason);
void lth_study_at_least(LthStudyReport *report, const char *what, double value, double bound,
                        const char *reason);
