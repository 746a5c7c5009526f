/// Table 1: unknowns, sparsity and times of five methods on a cube.
#include "study/kaufmann_studies.h"

static const char block_scene[] =
    "# Table 1: a cube, clamped below, under its weight.\n"
    "lithe: 1\n"
    "title: Ten by ten by ten\n"
    "bodies:\n"
    "  - name: cube\n"
    "    shape: {box: {min: [0, 0, 0], max: [1, 1, 1]}}\n"
    "    material: {model: linear, young_modulus: 100 kPa, poisson_ratio: 0.3, density: 1}\n"
    "    method: {kind: dg, cells: 10}\n"
    "    constraints:\n"
    "      - {where: {plane: {point: [0, 0, 0], normal: [0, 0, -1]}}, displacement: [0, 0, 0]}\n"
    "gravity: [0, 0, -9.81]\n"
    "time: static\n"
    "solver: {linear: cholesky}\n"
    "output: {fields: none}\n";

/// The paper's rows: percent of all entries, milliseconds.
static const struct {
  const char *name, *method;
  int unknowns;
  double percent, integrate, assemble, solve;
} rows[] = {
    {"BZ linear", "{kind: dg, cells: 10, degree: 1, flux: bz, penalty: 20}", 12000, 0.28, 532, 22,
     656},
    {"IP linear", "{kind: dg, cells: 10, degree: 1, penalty: 20}", 12000, 0.62, 1437, 87, 734},
    {"CG trilinear", "{kind: cg, cells: 15, mesh: hexahedra}", 12288, 0.58, 3750, 41, 641},
    {"BZ quadratic", "{kind: dg, cells: 10, degree: 2, flux: bz, penalty: 20}", 30000, 0.28, 3062,
     152, 7797},
    {"IP quadratic", "{kind: dg, cells: 10, degree: 2, penalty: 20}", 30000, 0.64, 8344, 621,
     8484}};

#define N_ROWS ((int)(sizeof rows / sizeof rows[0]))

enum {
  ROW,
  UNKNOWNS,
  PERCENT_PRINTED,
  PERCENT,
  PERCENT_STORED,
  INTEGRATE_PRINTED,
  INTEGRATE,
  ASSEMBLE_PRINTED,
  ASSEMBLE,
  SOLVE_PRINTED,
  SOLVE,
  COLUMNS
};

/// What may be other than zero whatever the material and the rotations are not: all of a diagonal block; of others, with
/// BZ multiples of the 3 x 3 identity, with IP all but the pair of constants, which is such a multiple.
typedef struct Count {
  bool is_dg, is_bz;
  double kept, stored, outside,
      largest; ///< entries; largest value outside of the pattern, and of all
} Count;

static bool is_in_pattern(const Count *c, bool is_diagonal, LitheCount row, LitheCount col) {
  if (!c->is_dg || is_diagonal || row % 3 == col % 3) return true;
  return !c->is_bz && (row >= 3 || col >= 3);
}

static LitheStatus count_entries(void *user, LitheCtx *ctx, const LthWorld *world,
                                 LitheIndex frame) {
  Count *c = user;
  const LthBlockMatrix *K = lth_simulation_matrix(world->sim);
  (void)ctx;
  (void)frame;
  c->kept = c->stored = c->outside = c->largest = 0;
  for (LitheIndex row = 0; row < K->n_rows; row++)
    for (LitheCount e = K->block_off[row]; e < K->block_off[row + 1]; e++) {
      LitheIndex col = K->block_col[e];
      LitheCount m = K->row_off[row + 1] - K->row_off[row];
      LitheCount n = K->row_off[col + 1] - K->row_off[col];
      const double *value = K->values + K->value_off[e];
      c->stored += (double)(m * n);
      for (LitheCount i = 0; i < m; i++)
        for (LitheCount j = 0; j < n; j++) {
          double v = fabs(value[i * n + j]);
          bool is_kept = is_in_pattern(c, row == col, i, j);
          c->kept += is_kept ? 1 : 0;
          c->largest = fmax(c->largest, v);
          if (!is_kept) c->outside = fmax(c->outside, v);
        }
    }
  return LITHE_OK;
}

static LitheStatus run_row(LthStudyRun *run, int i, LthTable *t, double *outside) {
  LthStudyResult r;
  Count count = {.is_dg = i != 2, .is_bz = i % 3 == 0};
  LthRunLook look = {count_entries, &count};
  const char *const sets[] = {lth_study_print(run, "bodies.0.method=%s", rows[i].method)};
  LITHE_TRY(lth_study_run_with(run, lth_study_print(run, "row-%d", i + 1), block_scene, 1, sets,
                               &look, &r));
  double n = lth_study_number(&r, "bodies.0.dofs"), row[COLUMNS];
  row[ROW] = i + 1;
  row[UNKNOWNS] = n;
  row[PERCENT_PRINTED] = rows[i].percent;
  row[PERCENT] = 100 * count.kept / (n * n);
  row[PERCENT_STORED] = 100 * count.stored / (n * n);
  row[INTEGRATE_PRINTED] = rows[i].integrate;
  row[INTEGRATE] = 1e3 * lth_study_number(&r, "time.integrate");
  row[ASSEMBLE_PRINTED] = rows[i].assemble;
  row[ASSEMBLE] = 1e3 * lth_study_number(&r, "time.assemble");
  row[SOLVE_PRINTED] = rows[i].solve;
  row[SOLVE] = 1e3 * (lth_study_number(&r, "time.factor") + lth_study_number(&r, "time.solve"));
  lth_table_row(t, rows[i].name, row);
  *outside = fmax(*outside, count.outside / count.largest);
  lth_study_at_most(&run->report,
                    lth_study_print(run, "%s: unknowns off the printed ones", rows[i].name),
                    fabs(n - rows[i].unknowns), 0,
                    "12k and 30k: four and ten functions an element, "
                    "three components; 16^3 nodes of CG");
  lth_study_at_most(
      &run->report,
      lth_study_print(run, "%s: percent of entries off the printed one", rows[i].name),
      fabs(row[PERCENT] - rows[i].percent), 0.0051, "a printed number is rounded to 0.01");
  return LITHE_OK;
}

LitheStatus lth_study_table_1(LthStudyRun *run) {
  LthTable *t =
      lth_study_table(&run->report, "table",
                      "Table 1 (printed: Core2 Duo of 2.4 GHz; here: this machine)", "method");
  lth_table_column(t, "row", "", 0);
  lth_table_column(t, "unknowns", "", 0);
  lth_table_column(t, "entries printed", "%", 2);
  lth_table_column(t, "entries", "%", 4);
  lth_table_column(t, "stored", "%", 4);
  lth_table_column(t, "integration printed", "ms", 0);
  lth_table_column(t, "integration", "ms", 3);
  lth_table_column(t, "assembly printed", "ms", 0);
  lth_table_column(t, "assembly", "ms", 3);
  lth_table_column(t, "solution printed", "ms", 0);
  lth_table_column(t, "solution", "ms", 3);
  double outside = 0;
  for (int i = 0; i < N_ROWS; i++)
    if (!run->quick || i < 3) LITHE_TRY(run_row(run, i, t, &outside));
  lth_study_at_most(&run->report, "largest entry where the count has none, over the largest of all",
                    outside, 1e-14, "what is not counted is zero to rounding");
  lth_study_say(
      &run->report,
      "Entries are counted as the paper must have: those that are not zero by structure, both "
      "triangles, over "
      "the square of the unknowns. Lithe stores one dense block for each pair of elements: its "
      "Cholesky factor is twice as fast that way, and warping fills the blocks anyway. Integration "
      "is "
      "without quadrature (Fig. 4), so its time is not of the same order.");
  LthPlot *plot = lth_study_plot(&run->report, "plot-times", "Times of Table 1",
                                 "row of the table [-]", "time [ms]");
  plot->log_y = true;
  lth_plot_printed(plot, "solution, here", t, ROW, SOLVE);
  lth_plot_printed(plot, "integration, here", t, ROW, INTEGRATE);
  lth_plot_printed(plot, "solution, printed", t, ROW, SOLVE_PRINTED);
  lth_plot_printed(plot, "integration, printed", t, ROW, INTEGRATE_PRINTED);
  return LITHE_OK;
}
