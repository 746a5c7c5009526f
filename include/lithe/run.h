/// What can be done with a scene: run it, predict what a run would cost, make its mesh.
#pragma once

#include "lithe/scene.h"

#ifdef __cplusplus
extern "C" {
#endif

/// The figures of a run in short; result.json has them all.
typedef struct LitheRunSummary {
  LitheIndex elements;
  LitheCount unknowns;
  LitheIndex frames;       ///< output times written
  double simulated;        ///< [s] of the scene's time
  double max_displacement; ///< [m] at the end
  double max_von_mises;    ///< [Pa] at the end
  double penetration;      ///< deepest contact at the end [m]
  double seconds;          ///< wall clock
  bool converged;
} LitheRunSummary;

/// A finished run: its folder and the text of its result.json.
typedef struct LitheResult LitheResult;

/// Run a scene and write its result into `folder` (NULL: out/<scene name>). Free `*result` with
/// lithe_result_destroy(), after a failure too.
/// @return LITHE_OK. LITHE_NOT_CONVERGED, LITHE_INTERRUPTED: all files are valid and result.json says so.
/// LITHE_BAD_INPUT: the scene selects nothing, or nothing holds a static body, ... LITHE_NO_MEMORY.
/// LITHE_NO_SPACE: cannot write; there is no result.json then.
LITHE_API LitheStatus lithe_run(LitheCtx *ctx, const LitheScene *scene, const char *folder,
                                LitheResult **result);

/// Read the scene of the run whose checkpoint lies in `folder`, as lithe_scene_read() does: from where it was,
/// with the overrides that it had. `def->overrides` come behind them (solver.threads alone may change),
/// `def->file` is not used.
/// @return LITHE_BAD_INPUT: there is no checkpoint, it is damaged or of another version, or the scene is bad.
LITHE_API LitheStatus lithe_resume_read(LitheCtx *ctx, const char *folder, const LitheSceneDef *def,
                                        LitheScene **scene);

/// Go on with that run from its checkpoint: all files, and result.json but for its times, get the same bits
/// as if the run had never stopped. Otherwise as lithe_run().
/// @return also LITHE_BAD_INPUT: the scene, a file that it names or a file of the run has changed since.
/// Nothing in the folder is touched then.
LITHE_API LitheStatus lithe_resume(LitheCtx *ctx, const LitheScene *scene, const char *folder,
                                   LitheResult **result);

/// Borrowed until the result is destroyed. The text is "" where no result.json was written.
LITHE_API const char *lithe_result_json(const LitheResult *result);
LITHE_API const char *lithe_result_folder(const LitheResult *result);
LITHE_API LitheRunSummary lithe_result_summary(const LitheResult *result);
LITHE_API void lithe_result_destroy(LitheCtx *ctx, LitheResult **result);

/// What a run would need.
typedef struct LitheForecast {
  LitheIndex elements, inner_faces;
  LitheCount unknowns, nonzeros; ///< of the system matrix; no nonzeros where none is made
  LitheCount steps;              ///< time steps or static solves
  LitheIndex frames;             ///< output times
  double volume;                 ///< [m^3]
  double memory;                 ///< [byte], predicted
  double seconds;                ///< predicted; good to a factor of three or so
  const char *linear;            ///< linear solver that would be taken
} LitheForecast;

/// Make the mesh, but nothing after it, and predict the rest.
LITHE_API LitheStatus lithe_check(LitheCtx *ctx, const LitheScene *scene, LitheForecast *forecast);

/// What a mesh is like.
typedef struct LitheMeshReport {
  LitheIndex elements, faces, inner_faces, boundary_faces;
  LitheIndex merged;           ///< slivers merged into a neighbour
  LitheIndex components;       ///< parts that hang together
  double volume, surface_area; ///< [m^3], [m^2]
  double min_volume, max_volume;
  double max_gap;    ///< largest |sum of area times normal| of an element over its area
  double max_aspect; ///< largest ratio of an element's bounding box
  double seconds;    ///< to make it
  LitheIndex full_cells, cut_cells; ///< of staggered grids
} LitheMeshReport;

/// Make the mesh of a scene's body, write it as .vtu (of staggered bodies the filled fractions of their grids as .vti;
/// `path` NULL: not) and tell what it is like.
LITHE_API LitheStatus lithe_mesh(LitheCtx *ctx, const LitheScene *scene, const char *path,
                                 LitheMeshReport *report);

#ifdef __cplusplus
}
#endif
