/// Do the methods agree? Values of each at its resolutions, what they tend to, and how far apart that is.
#include "study/orders.h"
#include "study/sweep.h"
#include "study/verify.h"

#include <math.h>
#include <string.h>

#define STRESS_FACTOR 3 // stresses converge an order slower than displacements

/// What is compared: all entries of one vector, or one number.
typedef struct Quantity {
  const char *name, *unit;
  const char *path[6];
  int n;
  bool is_stress;
  bool decides;
} Quantity;

#define QUANTITIES_MAX 64

typedef struct Comparison {
  LthStudyRun *run;
  LthVerifyMethod *method;
  int n_methods;
  Quantity quantity[QUANTITIES_MAX];
  int n;
} Comparison;

/// The best that a method says of a number: what its last three levels tend to, or the last level's.
typedef struct Best {
  double value, order;
} Best;

static double number_at(const LthVerifyMethod *m, int level, const char *path) {
  return lth_study_number(m->result + level, path);
}

static Best best_of(const LthVerifyMethod *m, const char *path) {
  int n = m->n_levels;
  Best best = {number_at(m, n - 1, path), NAN};
  double h[3], q[3], order, limit;
  if (n < 3) return best;
  for (int i = 0; i < 3; i++) {
    h[i] = 1 / m->cells[n - 3 + i];
    q[i] = number_at(m, n - 3 + i, path);
  }
  // an order below one half is noise, and its limit far away
  if (lth_order_extrapolate(h, q, &order, &limit) && order >= 0.5) best = (Best){limit, order};
  return best;
}

/// Quantities of the first method's result. Vectors are one quantity: components of different size share a scale.
static void list_quantities(Comparison *c) {
  LthMainNumber *number = lth_arena_take(&c->run->arena, sizeof *number * LTH_MAIN_NUMBERS_MAX);
  int n = number ? lth_main_numbers(c->run, c->method[0].result[0].json, number) : 0;
  for (int k = 0; k < n; k++) {
    const char *path = number[k].path, *dot = strrchr(path, '.');
    bool is_entry = dot && strlen(dot) == 2 && dot[1] >= '0' && dot[1] <= '9';
    size_t length = is_entry ? (size_t)(dot - path) : strlen(path);
    Quantity *last = c->n > 0 ? c->quantity + c->n - 1 : NULL;
    if (!number[k].is_field || strncmp(path, "reaction.", 9) == 0) continue;
    if (is_entry && last && strlen(last->name) == length &&
        strncmp(last->name, path, length) == 0) {
      if (last->n < 6) last->path[last->n++] = path;
      continue;
    }
    if (c->n == QUANTITIES_MAX) return;
    Quantity *q = c->quantity + c->n++;
    *q = (Quantity){.name = lth_study_print(c->run, "%.*s", (int)length, path),
                    .unit = number[k].unit,
                    .path = {path},
                    .n = 1,
                    .is_stress = strstr(path, "stress") || strstr(path, "von_mises"),
                    .decides =
                        strncmp(path, "probes.", 7) == 0 || strcmp(path, "energy.strain") == 0};
  }
}

static void tabulate_method(Comparison *c, const LthVerifyMethod *m) {
  double row[LTH_VERIFY_LEVELS_MAX + 2];
  LthTable *t =
      lth_study_table(&c->run->report, m->name, lth_study_print(c->run, "Method %s", m->name), "");
  for (int i = 0; i < m->n_levels; i++)
    lth_table_column(t, lth_study_print(c->run, "%g cells", m->cells[i]), "", 6);
  lth_table_column(t, "order", "", 3);
  lth_table_column(t, "extrapolated", "", 6);
  for (int k = 0; k < c->n; k++)
    for (int e = 0; e < c->quantity[k].n; e++) {
      const char *path = c->quantity[k].path[e];
      Best best = best_of(m, path);
      for (int i = 0; i < m->n_levels; i++) row[i] = number_at(m, i, path);
      row[m->n_levels] = best.order;
      row[m->n_levels + 1] = isfinite(best.order) ? best.value : NAN;
      lth_table_row(t,
                    lth_study_print(c->run, *c->quantity[k].unit ? "%s [%s]" : "%s", path,
                                    c->quantity[k].unit),
                    row);
    }
}

/// Length of a quantity by a method, and the distance between two methods.
static double size_of(const Quantity *q, const LthVerifyMethod *m) {
  double sum = 0;
  for (int e = 0; e < q->n; e++) sum += pow(best_of(m, q->path[e]).value, 2);
  return sqrt(sum);
}

static double distance_of(const Quantity *q, const LthVerifyMethod *a, const LthVerifyMethod *b) {
  double sum = 0;
  for (int e = 0; e < q->n; e++)
    sum += pow(best_of(a, q->path[e]).value - best_of(b, q->path[e]).value, 2);
  return sqrt(sum);
}

/// Displacements of all probes are measured by the largest of them, so are stresses: near a place that does not move,
/// or is not stressed, a share of the value itself says nothing.
static double scale_of(const Comparison *c, const Quantity *of) {
  double scale = 0;
  bool is_probe = strncmp(of->name, "probes.", 7) == 0;
  for (int k = 0; k < c->n; k++) {
    const Quantity *q = c->quantity + k;
    bool same = is_probe && strncmp(q->name, "probes.", 7) == 0 && strcmp(q->unit, of->unit) == 0;
    for (int m = 0; m < c->n_methods && (q == of || same); m++)
      scale = fmax(scale, size_of(q, c->method + m));
  }
  return scale;
}

static double largest_distance(const Comparison *c, const Quantity *q) {
  double largest = 0;
  for (int a = 0; a < c->n_methods; a++)
    for (int b = 0; b < a; b++)
      largest = fmax(largest, distance_of(q, c->method + a, c->method + b));
  return largest;
}

static void tabulate_comparison(Comparison *c) {
  double row[4];
  LthTable *t = lth_study_table(&c->run->report, "agreement",
                                "What the methods tend to (vectors: their length)", "");
  for (int m = 0; m < c->n_methods; m++) lth_table_column(t, c->method[m].name, "", 6);
  lth_table_column(t, "apart", "%", 3);
  for (int k = 0; k < c->n; k++) {
    const Quantity *q = c->quantity + k;
    for (int m = 0; m < c->n_methods; m++) row[m] = size_of(q, c->method + m);
    row[c->n_methods] = 100 * largest_distance(c, q) / scale_of(c, q);
    lth_table_row(t, lth_study_print(c->run, *q->unit ? "%s [%s]" : "%s", q->name, q->unit), row);
  }
}

static void judge(Comparison *c, double tolerance) {
  for (int k = 0; k < c->n; k++) {
    const Quantity *q = c->quantity + k;
    double scale = scale_of(c, q);
    if (!q->decides || !(scale > 0)) continue;
    lth_study_at_most(
        &c->run->report, lth_study_print(c->run, "methods apart in %s, as a share", q->name),
        largest_distance(c, q) / scale, q->is_stress ? STRESS_FACTOR * tolerance : tolerance,
        q->is_stress ? "the tolerance times 3: stresses converge an order slower"
                     : "the tolerance");
  }
}

static void plot_energy(Comparison *c) {
  LthTable *t = lth_study_table(&c->run->report, "energy", "Strain energy by refinement", "method");
  LthPlot *plot = lth_study_plot(&c->run->report, "energy", "Strain energy by refinement",
                                 "cells along the longest side [-]", "strain energy [J]");
  double row[2];
  int first = 0;
  t->is_long = true;
  lth_table_column(t, "cells", "", 6);
  lth_table_column(t, "energy.strain", "J", 7);
  for (int m = 0; m < c->n_methods; m++)
    for (int i = 0; i < c->method[m].n_levels; i++) {
      row[0] = c->method[m].cells[i];
      row[1] = number_at(c->method + m, i, "energy.strain");
      lth_table_row(t, c->method[m].name, row);
    }
  plot->log_x = true;
  for (int m = 0; m < c->n_methods; first += c->method[m++].n_levels)
    lth_plot_rows(plot, c->method[m].name, t, 0, 1, first, first + c->method[m].n_levels);
}

void lth_verify_report(LthStudyRun *run, int n_methods, LthVerifyMethod *methods,
                       double tolerance) {
  Comparison c = {.run = run, .method = methods, .n_methods = n_methods};
  int n_bad = 0;
  list_quantities(&c);
  for (int m = 0; m < n_methods; m++) tabulate_method(&c, methods + m);
  tabulate_comparison(&c);
  plot_energy(&c);
  for (int m = 0; m < n_methods; m++)
    for (int i = 0; i < methods[m].n_levels; i++) n_bad += methods[m].result[i].status != LITHE_OK;
  lth_study_at_most(&run->report, "runs that did not converge", n_bad, 0,
                    "numbers of a solve that was not finished say nothing");
  judge(&c, tolerance);
}
