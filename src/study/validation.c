/// The validation book: cases whose answer is known.
#include "study/validation_studies.h"

#include <string.h>

/// A body under constant strain: whatever the elements, the answer is exact.
static const char patch_scene[] =
    "# A linear field on the whole surface: whatever the elements, the inside follows to "
    "rounding.\n"
    "lithe: 1\n"
    "title: Patch test\n"
    "bodies:\n"
    "  - name: block\n"
    "    shape: {difference: [{box: {min: [0, 0, 0], max: [1, 0.8, 0.6]}},\n"
    "                         {box: {min: [0.31, 0.23, -1], max: [0.72, 0.61, 1]}}]}\n"
    "    material: {model: linear, young_modulus: 50 kPa, poisson_ratio: 0.3, density: 1000}\n"
    "    method: {kind: dg, cells: 4, degree: 1}\n"
    "    constraints:\n"
    "      - {where: all, displacement: [\"0.01*x+0.02*y-0.03*z\", \"0.05*z-0.01*x\", "
    "\"0.02*x-0.04*y+0.01*z\"]}\n"
    "time: static\n"
    "solver: {linear: cholesky}\n"
    "exact: {displacement: [\"0.01*x+0.02*y-0.03*z\", \"0.05*z-0.01*x\", "
    "\"0.02*x-0.04*y+0.01*z\"]}\n"
    "output: {fields: none}\n";

static const struct {
  const char *name, *set[2];
  int n_set;
} patch_methods[] = {
    {"dg, degree 1, ip", {"bodies.0.method.flux=ip"}, 1},
    {"dg, degree 2, ip", {"bodies.0.method.degree=2"}, 1},
    {"dg, crooked file mesh", {"bodies.0.method={kind: dg, mesh: {file: crooked.msh}}"}, 1},
    {"cg, hexahedra", {"bodies.0.method={kind: cg, cells: 4}"}, 1},
    {"cg, crooked file mesh", {"bodies.0.method={kind: cg, mesh: {file: crooked.msh}}"}, 1},
};

LitheStatus lth_study_patch_test(LthStudyRun *run) {
  LthTable *table = lth_study_table(&run->report, "errors",
                                    "Error of the displacement under constant strain", "method");
  int dofs = lth_table_column(table, "unknowns", "", 0);
  int linf = lth_table_column(table, "largest error", "m", 3);
  double worst = 0, scale = 0;
  LITHE_TRY(lth_block_model_mesh(run, &lth_crooked_cube, 1, 1, "crooked"));
  for (size_t i = 0; i < sizeof patch_methods / sizeof patch_methods[0]; i++) {
    double row[2];
    LthStudyResult result;
    const char *name = lth_study_print(run, "case-%d", (int)i + 1);
    LITHE_TRY(lth_study_run_with(run, name, patch_scene, patch_methods[i].n_set,
                                 patch_methods[i].set, NULL, &result));
    row[dofs] = lth_study_number(&result, "bodies.0.dofs");
    row[linf] = lth_study_number(&result, "error.linf");
    worst = isnan(row[linf]) ? NAN : fmax(worst, row[linf]);
    scale = fmax(scale, lth_study_number(&result, "displacement.max"));
    lth_table_row(table, patch_methods[i].name, row);
  }
  lth_study_at_most(&run->report, "largest error of all methods over the largest displacement",
                    worst / scale, 1e-10,
                    "rounding times the condition number of the matrix, which is below 1e5 here");
  return LITHE_OK;
}

const LthStudy lth_studies_validation[] = {
    {"validation/patch-test", "Patch test: constant strain, held all around",
     "Is a field with constant strain reproduced exactly, whatever the elements are?",
     lth_study_patch_test},
    {"validation/tension", "Patch test: constant strain by a load",
     "Do loads and smooth supports give a field with constant strain exactly?", lth_study_tension},
    {"validation/cantilever", "Timoshenko's cantilever",
     "How many unknowns and seconds does bending take to 1 %?", lth_study_cantilever},
    {"validation/cook", "Cook's membrane", "How many do bending and shear of a tapered slab take?",
     lth_study_cook},
    {"validation/cylinder", "Thick-walled cylinder under pressure (Lame)",
     "Are displacement and stress of a curved wall right?", lth_study_cylinder},
    {"validation/sphere", "Thick-walled sphere under pressure (Lame)",
     "Are displacement and stress of a wall curved both ways right?", lth_study_sphere},
    {"validation/kirsch", "Hole in a plate (Kirsch)",
     "Is the concentration of stress at a hole found?", lth_study_kirsch},
    {"validation/le1", "NAFEMS LE1: elliptic membrane", "Is the target of 92.7 MPa met?",
     lth_study_le1},
    {"validation/le10", "NAFEMS LE10: thick plate", "Is the target of -5.38 MPa met?",
     lth_study_le10},
    {"validation/hertz", "Hertz: a rigid sphere on a half space",
     "Are force and stress of a contact right?", lth_study_hertz},
    {"validation/bar", "Free vibration of a bar", "Are its frequencies right?", lth_study_bar},
    {0}};
