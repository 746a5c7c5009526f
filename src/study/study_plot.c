/// Plots by gnuplot, run as a process on a script that is kept beside the drawing.
#ifndef _GNU_SOURCE
#define _GNU_SOURCE // posix_spawn_file_actions_addchdir_np()
#endif
#include "study/study_files.h"

#include "io/file.h"
#include "io/number_text.h"

#include <errno.h>
#include <fcntl.h>
#include <spawn.h>
#include <string.h>
#include <sys/wait.h>

extern char **environ;

/// Colours of different lightness; points and dashes differ as well, so that none of it is needed.
static const struct {
  const char *colour;
  int point, dash;
} styles[] = {{"#000000", 7, 1}, {"#0072b2", 4, 2}, {"#d55e00", 9, 3},  {"#009e73", 11, 4},
              {"#cc79a7", 5, 5}, {"#7f6000", 6, 1}, {"#56b4e9", 13, 2}, {"#888888", 8, 3}};

#define N_STYLES ((int)(sizeof styles / sizeof styles[0]))

static void put_string(FILE *out, const char *text) {
  fputc('"', out);
  for (; *text; text++) {
    if (*text == '"' || *text == '\\') fputc('\\', out);
    fputc(*text, out);
  }
  fputc('"', out);
}

/// The CSV's column behind a column of the table, from 1.
static int file_column(const LthTable *table, int column) {
  return column + (table->row_title ? 2 : 1);
}

/// Points of values that no line joins.
static const int crosses[6] = {1, 2, 3, 10, 12, 8};

static void put_series(FILE *out, const LthPlot *plot, int i) {
  const LthSeries *s = plot->series + i;
  double order = lth_plot_order(plot, s);
  char title[300], file[200];
  snprintf(file, sizeof file, "%s.csv", s->table->name);
  if (isfinite(order))
    snprintf(title, sizeof title, "%s (order %.2f)", s->name, order);
  else
    snprintf(title, sizeof title, "%s", s->name);
  put_string(out, file);
  fprintf(out, " skip 1 every ::%d::%d using %d:%d with ", s->first, s->last - 1,
          file_column(s->table, s->x), file_column(s->table, s->y));
  if (s->is_printed)
    fprintf(out, "points pt %d ps 1.1 lw 1.6 lc rgb \"%s\"", crosses[i % 6],
            styles[i % N_STYLES].colour);
  else
    fprintf(out, "linespoints pt %d ps 0.8 lw 1.4 dt %d lc rgb \"%s\"", styles[i % N_STYLES].point,
            styles[i % N_STYLES].dash, styles[i % N_STYLES].colour);
  fputs(" title ", out);
  put_string(out, title);
}

/// The line of the observed order through all points, where there is one.
static void put_order_line(FILE *out, const LthPlot *plot, int i) {
  char power_text[LTH_NUMBER_TEXT_MAX], factor_text[LTH_NUMBER_TEXT_MAX];
  double factor, power;
  if (!lth_plot_line(plot, plot->series + i, &factor, &power)) return;
  fprintf(out, ", \\\n  %s * x**(%s) with lines lw 0.7 dt 3 lc rgb \"%s\" notitle",
          lth_number_text(factor, factor_text), lth_number_text(power, power_text),
          styles[i % N_STYLES].colour);
}

/// An axis a little longer than all values are.
static void put_range(FILE *out, const LthPlot *plot) {
  double low = INFINITY, high = 0;
  for (int i = 0; i < plot->n_series; i++) {
    const LthSeries *s = plot->series + i;
    for (int row = s->first; row < s->last; row++) {
      low = fmin(low, lth_table_at(s->table, row, s->x));
      high = fmax(high, lth_table_at(s->table, row, s->x));
    }
  }
  if (low < high) fprintf(out, "set xrange [%.10g:%.10g]\n", low / 1.15, high * 1.15);
}

/// Tics at the first series' values themselves; not where one would be written over another, nor where series have values of
/// their own.
static void put_log_tics(FILE *out, const LthPlot *plot) {
  const LthSeries *s = plot->series;
  double before = NAN, span;
  put_range(out, plot);
  if (s->last - s->first > 16 || s->last <= s->first || plot->orders == LTH_PLOT_ORDERS_BESIDE)
    return;
  span =
      fabs(log(lth_table_at(s->table, s->last - 1, s->x) / lth_table_at(s->table, s->first, s->x)));
  fputs("set xtics (", out);
  for (int row = s->first; row < s->last; row++) {
    double x = lth_table_at(s->table, row, s->x);
    if (fabs(log(x / before)) < 0.07 * span) continue;
    fprintf(out, "%s\"%.4g\" %.10g", isnan(before) ? "" : ", ", x, x);
    before = x;
  }
  fputs(")\n", out);
}

static void put_axis(FILE *out, char axis, const char *label, bool is_log) {
  fprintf(out, "set %clabel ", axis);
  put_string(out, label);
  if (is_log) fprintf(out, "\nset logscale %c", axis);
  if (is_log && axis == 'y') fputs("\nset format y \"%.0e\"", out);
  fputc('\n', out);
}

static void put_script(FILE *out, const LthStudyRun *run, const LthPlot *plot) {
  fprintf(out, "# %s: draw it again with `gnuplot %s.gp` in this folder\n", run->study->name,
          plot->name);
  fputs("set terminal svg noenhanced size 720,500 dynamic font \"Helvetica,13\" background "
        "\"white\"\nset output ",
        out);
  char file[200];
  snprintf(file, sizeof file, "%s.svg", plot->name);
  put_string(out, file);
  fputs("\nset datafile separator \",\"\nset grid lc rgb \"#999999\"\nset key below height 1\nset "
        "title ",
        out);
  put_string(out, plot->title);
  fputc('\n', out);
  put_axis(out, 'x', plot->x_label, plot->log_x);
  if (plot->log_x) put_log_tics(out, plot);
  put_axis(out, 'y', plot->y_label, plot->log_y);
  fputs("plot ", out);
  for (int i = 0; i < plot->n_series; i++) {
    if (i > 0) fputs(", \\\n  ", out);
    put_series(out, plot, i);
  }
  for (int i = 0; i < plot->n_series; i++) put_order_line(out, plot, i);
  fputc('\n', out);
}

static LitheStatus write_script(const LthStudyRun *run, const LthPlot *plot) {
  char *path;
  LthFileWriter writer;
  LITHE_TRY(lth_path_ending(run->ctx, run->folder, plot->name, "gp", &path));
  LitheStatus status = lth_file_open(run->ctx, path, &writer);
  lth_free(run->ctx, path);
  LITHE_TRY(status);
  put_script(writer.stream, run, plot);
  return lth_file_commit(run->ctx, &writer);
}

/// Run gnuplot in a folder without a word from it. 0, an errno, or -1 where it ran and failed.
static int run_gnuplot(const char *folder, const char *script) {
  posix_spawn_file_actions_t actions;
  pid_t child;
  int state, error;
  char name[] = "gnuplot", file[300];
  snprintf(file, sizeof file, "%s", script);
  char *words[] = {name, file, NULL};
  if (posix_spawn_file_actions_init(&actions) != 0) return ENOMEM;
  posix_spawn_file_actions_addchdir_np(&actions, folder);
  posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, 1, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_addopen(&actions, 2, "/dev/null", O_WRONLY, 0);
  error = posix_spawnp(&child, name, &actions, NULL, words, environ);
  posix_spawn_file_actions_destroy(&actions);
  if (error) return error;
  while (waitpid(child, &state, 0) < 0)
    if (errno != EINTR) return -1;
  if (WIFEXITED(state) && WEXITSTATUS(state) == 127) return ENOENT;
  return WIFEXITED(state) && WEXITSTATUS(state) == 0 ? 0 : -1;
}

/// The <svg> element alone, its names made different from those of other plots on the same page.
static LitheStatus keep_svg(LthStudyRun *run, LthPlot *plot) {
  static const char *const names[] = {"id='gp", "id=\"gp", "href='#gp", "url(#gp"};
  char *path, *text, *out;
  size_t size, extra = strlen(run->study->name) + strlen(plot->name) + 2;
  LITHE_TRY(lth_path_ending(run->ctx, run->folder, plot->name, "svg", &path));
  LitheStatus status = lth_file_read(run->ctx, path, &text, &size);
  lth_free(run->ctx, path);
  LITHE_TRY(status);
  const char *from = strstr(text, "<svg");
  size_t n = 0;
  for (const char *at = from; at && (at = strstr(at, "gp")); at++) n++;
  plot->svg = out = from ? lth_arena_take(&run->arena, size + n * extra + 1) : NULL;
  for (const char *at = from; at && *at && out;) {
    size_t length = 1;
    for (size_t k = 0; k < sizeof names / sizeof names[0]; k++)
      if (strncmp(at, names[k], strlen(names[k])) == 0) length = strlen(names[k]) - 2;
    memcpy(out, at, length);
    out += length;
    at += length;
    if (length > 1) out += sprintf(out, "%s-%s-", run->study->name, plot->name);
  }
  lth_free(run->ctx, text);
  return LITHE_OK;
}

LitheStatus lth_study_draw_plots(LthStudyRun *run) {
  for (LthItem *item = run->report.first; item; item = item->next) {
    char script[300];
    if (item->kind != LTH_ITEM_PLOT || item->plot->n_series == 0) continue;
    LITHE_TRY(write_script(run, item->plot));
    snprintf(script, sizeof script, "%s.gp", item->plot->name);
    int error = run_gnuplot(run->folder, script);
    if (error == ENOENT)
      lth_warn(run->ctx, "gnuplot is not there (Debian: gnuplot-nox): the numbers are written as "
                         ".csv, the scripts as .gp, and nothing is drawn");
    else if (error != 0)
      lth_warn(run->ctx, "gnuplot could not draw %s/%s.gp", run->folder, item->plot->name);
    else
      LITHE_TRY(keep_svg(run, item->plot));
  }
  return LITHE_OK;
}
