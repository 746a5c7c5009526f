/// Figures 11 and 12: condition numbers with a small element, and with a thin section of one.
#include "study/kaufmann_studies.h"

#include "disc/dg/dg_space.h"
#include "io/file.h"
#include "la/blas_threads.h"

#include <lapacke.h>
#include <string.h>

static const char solid_scene[] =
    "lithe: 1\n"
    "title: Condition number\n"
    "bodies:\n"
    "  - name: solid\n"
    "    material: {model: linear, young_modulus: 1, poisson_ratio: 0.3, density: 1}\n"
    "    method: {kind: dg, mesh: {file: \"%s.msh\"}, degree: %d}\n"
    "    constraints:\n"
    "      - {where: {plane: {point: [0, 0, 0], normal: [0, 0, -1]}}, displacement: [0, 0, 0]}\n"
    "gravity: [0, 0, -1]\n"
    "time: static\n"
    "solver: {linear: cholesky, condition: true}\n"
    "output: {fields: none}\n";

static LitheStatus write_text(LthStudyRun *run, const char *name, const char *text) {
  LthFileWriter writer;
  LITHE_TRY(lth_folder_make(run->ctx, run->folder));
  LITHE_TRY(lth_file_open(run->ctx, lth_study_print(run, "%s/%s", run->folder, name), &writer));
  fputs(text, writer.stream);
  return lth_file_commit(run->ctx, &writer);
}

// --- Figure 11 ---

/// A unit cube: a tetrahedron on four of its corners, scaled by s about the middle, four frusta around it and four
/// tetrahedra at the other corners: nine elements.
static LitheStatus write_nine(LthStudyRun *run, const char *name, double s) {
  static const double odd[4][3] = {{0, 0, 0}, {1, 1, 0}, {1, 0, 1}, {0, 1, 1}};
  static const double even[4][3] = {{1, 1, 1}, {0, 0, 1}, {0, 1, 0}, {1, 0, 0}};
  // faces of the tetrahedron opposite to corner i, seen from inside
  static const int face[4][3] = {{1, 3, 2}, {0, 2, 3}, {0, 3, 1}, {0, 1, 2}};
  const char *text = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n12\n";
  for (int i = 0; i < 12; i++) {
    double x[3];
    for (int a = 0; a < 3; a++)
      x[a] = i < 4 ? 0.5 + s * (odd[i][a] - 0.5) : (i < 8 ? odd[i - 4][a] : even[i - 8][a]);
    text = lth_study_print(run, "%s%d %.17g %.17g %.17g\n", text, i + 1, x[0], x[1], x[2]);
  }
  text = lth_study_print(run, "%s$EndNodes\n$Elements\n9\n1 4 2 1 1 1 3 2 4\n", text);
  for (int i = 0; i < 4; i++) {
    const int *f = face[i];
    text = lth_study_print(run, "%s%d 6 2 1 1 %d %d %d %d %d %d\n", text, 2 + i, f[0] + 1, f[1] + 1,
                           f[2] + 1, f[0] + 5, f[1] + 5, f[2] + 5);
    text = lth_study_print(run, "%s%d 4 2 1 1 %d %d %d %d\n", text, 6 + i, f[0] + 5, f[1] + 5,
                           f[2] + 5, 9 + i);
  }
  return write_text(run, lth_study_print(run, "%s.msh", name),
                    lth_study_print(run, "%s$EndElements\n", text));
}

/// Condition numbers of the same matrix: between the monomials 1, x, y, z, xx, ... themselves, and after block Jacobi,
/// where the basis within a cell drops out.
typedef struct Conditions {
  double monomials, jacobi;
} Conditions;

#define POINTS 216 // 6 x 6 x 6 in a cell's box

/// Coefficients (nb x nb, column q) of monomial q in the basis of a cell, by least squares over points.
static LitheStatus monomials_of_cell(LitheCtx *ctx, const LthDgSpace *space, LitheIndex cell,
                                     double *coef) {
  int nb = lth_dg_funcs(space, cell), p = space->degree[cell];
  double phi[POINTS * LTH_DG_MAX_FUNCS], value[POINTS * LTH_DG_MAX_FUNCS];
  for (int k = 0; k < POINTS; k++) {
    double x[3];
    const int at[3] = {k % 6, k / 6 % 6, k / 36};
    const double *box = space->mesh->cell_box + 6 * (LitheCount)cell;
    for (int a = 0; a < 3; a++) x[a] = box[a] + (box[3 + a] - box[a]) * at[a] / 5;
    lth_dg_eval(space, cell, x, phi + k * nb);
    lth_monomials3_eval(p, x, value + k * nb);
  }
  if (LAPACKE_dgels(LAPACK_ROW_MAJOR, 'N', POINTS, nb, nb, phi, nb, value, nb) != 0)
    LITHE_FAIL(ctx, LITHE_NOT_CONVERGED, "monomials of a cell: LAPACK's dgels failed");
  memcpy(coef, value, sizeof *coef * (size_t)(nb * nb));
  return LITHE_OK;
}

/// dense += T_row^T block T_col, component by component.
static void transform(const double *block, int m, int n, const double *left, const double *right,
                      double *dense, LitheCount lead) {
  for (int q = 0; q < m; q++)
    for (int r = 0; r < n; r++)
      for (int i = 0; i < m; i++)
        for (int j = 0; j < n; j++) {
          double w = left[i * m + q] * right[j * n + r];
          for (int a = 0; a < 9; a++)
            dense[(3 * q + a / 3) * lead + 3 * r + a % 3] +=
                w * block[(3 * i + a / 3) * 3 * n + 3 * j + a % 3];
        }
}

/// Largest over smallest eigenvalue of a dense symmetric matrix, which is lost; NaN where rounding hides the smallest.
static LitheStatus dense_condition(LitheCtx *ctx, int n, double *dense, double *condition) {
  double *value;
  LTH_NEW(ctx, value, n);
  int info = LAPACKE_dsyevd(LAPACK_COL_MAJOR, 'N', 'L', n, dense, n, value);
  *condition = value[0] > 1e-15 * value[n - 1] ? value[n - 1] / value[0] : NAN;
  lth_free(ctx, value);
  if (info != 0)
    LITHE_FAIL(ctx, LITHE_NOT_CONVERGED, "condition number: LAPACK's dsyevd gave %d", info);
  return LITHE_OK;
}

/// Rows of every cell times the inverse of the Cholesky factor of its diagonal block, then the same of the columns.
static LitheStatus scale_blocks(LitheCtx *ctx, const LthBlockMatrix *K, double *dense) {
  LitheCount n = K->n;
  for (int side = 0; side < 2; side++) {
    for (LitheIndex c = 0; c < K->n_rows; c++) {
      double block[9 * LTH_DG_MAX_FUNCS * LTH_DG_MAX_FUNCS];
      int m = (int)(K->row_off[c + 1] - K->row_off[c]);
      memcpy(block, K->values + K->value_off[K->diagonal[c]], sizeof *block * (size_t)(m * m));
      if (LAPACKE_dpotrf(LAPACK_COL_MAJOR, 'L', m, block, m) != 0 ||
          LAPACKE_dtrtrs(LAPACK_COL_MAJOR, 'L', 'N', 'N', m, (int)n, block, m,
                         dense + K->row_off[c], (int)n) != 0)
        LITHE_FAIL(ctx, LITHE_NOT_CONVERGED, "block Jacobi: a diagonal block is not definite");
    }
    for (LitheCount i = 0; i < n; i++)
      for (LitheCount j = 0; j < i; j++) {
        double swap = dense[i * n + j];
        dense[i * n + j] = dense[j * n + i];
        dense[j * n + i] = swap;
      }
  }
  return LITHE_OK;
}

/// The matrix as it is (`coef` NULL) or between monomials, dense.
static void expand(const LthBlockMatrix *K, const LthDgSpace *space, const double *coef,
                   double *dense) {
  static const LitheCount room = LTH_DG_MAX_FUNCS * LTH_DG_MAX_FUNCS;
  memset(dense, 0, sizeof *dense * (size_t)(K->n * K->n));
  for (LitheIndex row = 0; row < K->n_rows; row++)
    for (LitheCount e = K->block_off[row]; e < K->block_off[row + 1]; e++) {
      LitheIndex col = K->block_col[e];
      int m = lth_dg_funcs(space, row), n = lth_dg_funcs(space, col);
      const double *block = K->values + K->value_off[e];
      double *to = dense + K->row_off[row] * K->n + K->row_off[col];
      if (coef)
        transform(block, m, n, coef + room * row, coef + room * col, to, K->n);
      else
        for (int i = 0; i < 3 * m; i++)
          memcpy(to + i * K->n, block + (size_t)(3 * n * i), sizeof *to * (size_t)(3 * n));
    }
}

static LitheStatus look_at_matrix(void *user, LitheCtx *ctx, const LthWorld *world,
                                  LitheIndex frame) {
  Conditions *c = user;
  const LthBlockMatrix *K = lth_simulation_matrix(world->sim);
  const LthDgSpace *space = world->bodies[0]->space;
  const LitheCount room = LTH_DG_MAX_FUNCS * LTH_DG_MAX_FUNCS;
  LitheStatus status = LITHE_OK;
  double *coef = NULL, *dense = NULL;
  int threads = lth_blas_one_thread();
  (void)frame;
  LTH_NEW_OR(done, ctx, coef, room * K->n_rows);
  LTH_NEW_OR(done, ctx, dense, K->n * K->n);
  for (LitheIndex cell = 0; cell < K->n_rows; cell++)
    LITHE_TRY_OR(done, monomials_of_cell(ctx, space, cell, coef + room * cell));
  expand(K, space, coef, dense);
  LITHE_TRY_OR(done, dense_condition(ctx, (int)K->n, dense, &c->monomials));
  expand(K, space, NULL, dense);
  LITHE_TRY_OR(done, scale_blocks(ctx, K, dense));
  LITHE_TRY_OR(done, dense_condition(ctx, (int)K->n, dense, &c->jacobi));
done:
  lth_blas_threads(threads);
  lth_free(ctx, coef);
  lth_free(ctx, dense);
  return status;
}

enum { RATIO, MONOMIAL1, LOCAL1, JACOBI1, MONOMIAL2, LOCAL2, JACOBI2, COLUMNS };

static LitheStatus run_nine(LthStudyRun *run, double s, LthTable *t) {
  const char *mesh = lth_study_print(run, "nine-%g", s);
  double row[COLUMNS];
  LITHE_TRY(write_nine(run, mesh, s));
  row[RATIO] = 1 / (s * s * s);
  for (int degree = 1; degree <= 2; degree++) {
    LthStudyResult r;
    Conditions c = {NAN, NAN};
    LthRunLook look = {look_at_matrix, &c};
    LITHE_TRY(lth_study_run_text(run, lth_study_print(run, "nine-%g-degree-%d", s, degree),
                                 lth_study_print(run, solid_scene, mesh, degree), &look, &r));
    row[3 * degree - 2] = c.monomials;
    row[3 * degree - 1] = lth_study_number(&r, "solver.condition");
    row[3 * degree] = c.jacobi;
  }
  lth_table_row(t, NULL, row);
  return LITHE_OK;
}

/// Last row over first.
static double growth(const LthTable *t, int column) {
  return lth_table_at(t, t->n_rows - 1, column) / lth_table_at(t, 0, column);
}

static void judge_small(LthStudyRun *run, const LthTable *t) {
  LthStudyReport *r = &run->report;
  lth_study_at_least(r, "growth with monomials, linear", growth(t, MONOMIAL1), 1e2,
                     "the figure: the condition number grows as the innermost volume falls");
  lth_study_at_least(r, "growth with monomials, quadratic, up to a volume of 1 : 37000",
                     lth_table_at(t, 3, MONOMIAL2) / lth_table_at(t, 0, MONOMIAL2), 1e4,
                     "the same; the last one is near the limit of double precision");
  for (int degree = 1; degree <= 2; degree++) {
    lth_study_at_most(
        r,
        lth_study_print(run, "degree %d: growth in Lithe's basis over that with monomials", degree),
        lth_table_at(t, 3, 3 * degree - 1) / lth_table_at(t, 0, 3 * degree - 1) /
            (lth_table_at(t, 3, 3 * degree - 2) / lth_table_at(t, 0, 3 * degree - 2)),
        1e-3,
        "what grows in the figure is the basis, not the method: monomials of x, y, z are nearly "
        "dependent on a small cell");
    lth_study_at_most(
        r, lth_study_print(run, "degree %d: growth after block Jacobi", degree),
        growth(t, 3 * degree), 1.2,
        "what is left in Lithe's basis is the size of the small cell's own entries, "
        "which the solver's preconditioner takes out: a volume of 1 : 1e6 costs nothing");
  }
}

LitheStatus lth_study_small(LthStudyRun *run) {
  static const double scales[] = {0.5, 0.25, 0.1, 0.03, 0.01};
  static const char *const names[] = {"monomials of x, y, z", "orthonormal on each cell (Lithe)",
                                      "after block Jacobi"};
  LthStudyReport *r = &run->report;
  LthTable *t = lth_study_table(r, "condition",
                                "Condition number of a mesh of nine elements (Fig. 11)", NULL);
  lth_table_column(t, "tetrahedron of s = 1 over innermost volume", "", 3);
  for (int k = 0; k < 6; k++)
    lth_table_column(
        t, lth_study_print(run, "%s, %s", k < 3 ? "linear" : "quadratic", names[k % 3]), "", 4);
  for (int i = 0; i < 5; i++) LITHE_TRY(run_nine(run, scales[i], t));
  LthPlot *plot = lth_study_plot(
      r, "plot-condition", "Condition number and the innermost element (Fig. 11)",
      "volume of the tetrahedron for s = 1 over that of the innermost [-]", "condition number [-]");
  plot->log_x = plot->log_y = true;
  for (int k = 0; k < 6; k++)
    lth_plot_series(plot,
                    lth_study_print(run, "%s, %s", k < 3 ? "linear" : "quadratic", names[k % 3]), t,
                    RATIO, k + 1);
  judge_small(run, t);
  return LITHE_OK;
}

// --- Figure 12 ---

static const char neck_scene[] =
    "lithe: 1\n"
    "title: One element with a thin section\n"
    "bodies:\n"
    "  - name: dumbbell\n"
    "    shape: {mesh: {file: \"%s.obj\"}}\n"
    "    material: {model: linear, young_modulus: 1, poisson_ratio: 0.3, density: 1}\n"
    "    method: {kind: dg, cells: [1, 1, 1], degree: %d, sliver: 0}\n"
    "    constraints:\n"
    "      - {where: {plane: {point: [-1.5, 0, 0], normal: [-1, 0, 0]}}, displacement: [0, 0, 0]}\n"
    "gravity: [0, 0, -1]\n"
    "time: static\n"
    "solver: {linear: cholesky, condition: true}\n"
    "output: {fields: none}\n";

/// Two cubes with a bridge of height `neck` between them, 1 m thick: faces as quadrilaterals and two twelve-gons.
static LitheStatus write_dumbbell(LthStudyRun *run, const char *name, double neck) {
  double h = neck / 2;
  const double xz[12][2] = {{-1.5, -.5}, {-.5, -.5}, {-.5, -h}, {.5, -h}, {.5, -.5}, {1.5, -.5},
                            {1.5, .5},   {.5, .5},   {.5, h},   {-.5, h}, {-.5, .5}, {-1.5, .5}};
  const char *text = "", *front = "f", *back = "f", *sides = "";
  for (int k = 0; k < 24; k++)
    text = lth_study_print(run, "%sv %.17g %g %.17g\n", text, xz[k % 12][0], k < 12 ? 0. : 1.,
                           xz[k % 12][1]);
  for (int k = 0; k < 12; k++) {
    int next = (k + 1) % 12;
    front = lth_study_print(run, "%s %d", front, k + 1);
    back = lth_study_print(run, "%s %d", back, 24 - k);
    sides = lth_study_print(run, "%sf %d %d %d %d\n", sides, next + 1, k + 1, k + 13, next + 13);
  }
  return write_text(run, lth_study_print(run, "%s.obj", name),
                    lth_study_print(run, "%s%s\n%s\n%s", text, front, back, sides));
}

LitheStatus lth_study_thin(LthStudyRun *run) {
  static const double necks[] = {0.5, 0.1, 1e-2, 1e-4, 1e-6, 1e-8};
  const int n = (int)(sizeof necks / sizeof necks[0]);
  LthStudyReport *r = &run->report;
  LthTable *t = lth_study_table(
      r, "condition", "Condition number of one element with a thin section (Fig. 12)", NULL);
  lth_table_column(t, "height of the section", "m", 2);
  for (int degree = 1; degree <= 3; degree++)
    lth_table_column(t, lth_study_print(run, "degree %d", degree), "", 5);
  for (int i = 0; i < n; i++) {
    const char *name = lth_study_print(run, "neck-%g", necks[i]);
    double row[4] = {necks[i]};
    LITHE_TRY(write_dumbbell(run, name, necks[i]));
    for (int degree = 1; degree <= 3; degree++) {
      LthStudyResult result;
      LITHE_TRY(lth_study_run_text(run, lth_study_print(run, "%s-degree-%d", name, degree),
                                   lth_study_print(run, neck_scene, name, degree), NULL, &result));
      row[degree] = lth_study_number(&result, "solver.condition");
    }
    lth_table_row(t, NULL, row);
  }
  LthPlot *plot = lth_study_plot(r, "condition", "Condition number and a thin section (Fig. 12)",
                                 "height of the section [m]", "condition number [-]");
  plot->log_x = plot->log_y = true;
  for (int degree = 1; degree <= 3; degree++)
    lth_plot_series(plot, lth_study_print(run, "degree %d", degree), t, 0, degree);
  for (int degree = 1; degree <= 3; degree++) {
    lth_study_at_most(
        r, lth_study_print(run, "degree %d: growth from 0.5 m to 1e-8 m", degree),
        growth(t, degree), 1.5,
        "\"the condition number stays finite\": the functions see the two halves as one "
        "volume, whatever is between them");
    lth_study_at_most(
        r, lth_study_print(run, "degree %d: change from 1e-6 m to 1e-8 m, relative", degree),
        fabs(lth_table_at(t, n - 1, degree) / lth_table_at(t, n - 2, degree) - 1), 1e-3,
        "it has a limit");
  }
  return LITHE_OK;
}
