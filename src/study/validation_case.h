/// A validation case: one scene by several methods at refining resolutions, against numbers that are known.
#pragma once

#include "study/block_model.h"

#define LTH_CASE_LEVELS_MAX 4
#define LTH_CASE_QUANTITIES_MAX 3
#define LTH_CASE_METHODS_MAX 6

/// A number of the result and what it ought to be: value = start + slope * number (slope 0: the number itself). Its error is
/// |value - reference| / scale (0: |reference|).
typedef struct LthCaseQuantity {
  const char *name, *unit, *path;
  double reference, scale;
  double bound;       ///< of the error of every method at its finest level
  const char *reason; ///< for the bound
  double start, slope;
} LthCaseQuantity;

typedef enum LthCaseMesh {
  LTH_CASE_NO_MESH,
  LTH_CASE_LINEAR_MESH,
  LTH_CASE_QUADRATIC_MESH
} LthCaseMesh;

/// `set` overrides bodies.0.method; its %d is the level's number, cells or the level of the mesh mesh-<level>.msh. In
/// quick runs the last level is left out.
typedef struct LthCaseMethod {
  const char *name, *set;
  LthCaseMesh mesh;
  int n_levels, level[LTH_CASE_LEVELS_MAX];
} LthCaseMethod;

/// Ways that most cases share, at three levels: dg and cg of degree 2, cells or meshes as above.
LthCaseMethod lth_case_dg_sliced(int level0, int level1, int level2);
LthCaseMethod lth_case_dg_mesh(int level0, int level1, int level2);
LthCaseMethod lth_case_cg_mesh(int level0, int level1, int level2);
LthCaseMethod lth_case_staggered(int level0, int level1, int level2);

typedef struct LthCase {
  const char *name;           ///< stem of the files
  const char *scene;          ///< its shape may be the file body.obj
  const LthBlockModel *model; ///< NULL: no method needs a file
  int surface_level;          ///< of body.obj; 0: none
  int n_quantities, n_methods;
  LthCaseQuantity quantity[LTH_CASE_QUANTITIES_MAX];
  LthCaseMethod method[LTH_CASE_METHODS_MAX];
} LthCase;

/// Run a case: a table of all runs, a plot of errors over unknowns, a table of unknowns and seconds to 1 %, a verdict
/// for every method and quantity.
LitheStatus lth_case_run(LthStudyRun *run, const LthCase *which);
