/// Elements that are divided, merged back and change their degree while a scene runs (docs/theory/adaptivity.md).
#pragma once

#include "disc/dg/dg_estimate.h"
#include "scene/change.h"

/// What adapts one body.
typedef struct LthAdaptBody {
  uint8_t *first_degree; ///< of the cells that the topology began with; degrees do not fall below
  double scale;          ///< twice the largest strain energy at a look so far [J]
  LitheCount n_divided, n_merged, n_raised, n_lowered; ///< elements, since the start
  LitheIndex n_first, n_most;                          ///< elements at the start, most at a time
} LthAdaptBody;

struct LthAdapt {
  LthAdaptBody *bodies; ///< (n_bodies)
  LitheCount n_steps;   ///< time or load steps so far
  LitheCount n_looks;   ///< those that looked, each with all its solves
  double released;  ///< largest acceleration that new functions released, root mean square [m/s^2]
  double *velocity; ///< before the step of now, then its acceleration (system's unknowns)
  LitheCount n_velocity, cap_velocity;
  LitheCount n_changes; ///< looks that changed something
  double jump[2];       ///< largest change of strain and of kinetic energy by one of them [J]
  bool is_full;         ///< told that there are too many elements
};

/// What becomes of a cell at a look.
typedef enum LthMark { LTH_KEEP, LTH_DIVIDE, LTH_RAISE, LTH_LOWER, LTH_MERGE } LthMark;

/// Values of the criteria at one look at one body, by cell of its mesh; NULL where the scene does not ask.
typedef struct LthAdaptValues {
  double *h, *p;
} LthAdaptValues;

/// Let the bodies of a scene with `adapt` change: before anything is built upon their meshes.
LitheStatus lth_adapt_begin_body(LitheCtx *ctx, const LthScene *scene, LthBody *body);
LitheStatus lth_adapt_begin(LitheCtx *ctx, LthWorld *world);
void lth_adapt_end(LitheCtx *ctx, LthWorld *world);

/// Before a time step: keep what the look after it needs.
LitheStatus lth_adapt_before_step(LitheCtx *ctx, LthWorld *world);

/// After a solve that led `dt` on (0: equilibrium): look, where a look is due, and renew the world where something
/// changes. `round` counts solves at the same time: from the second on elements only get finer.
LitheStatus lth_adapt_look(LitheCtx *ctx, LthWorld *world, double dt, int round, bool *changed);

void lth_adapt_archive(LthWorld *world, LthArchive *archive);

// adapt_criteria.c

/// The criterion's value in every cell: the largest |principal stress| at the centroid [Pa], the largest turn between a cell
/// and a neighbour [rad], or an element's error over its share of the body's energy norm. `acceleration` (n_dofs) may be NULL.
LitheStatus lth_adapt_measure(LitheCtx *ctx, LthBody *body, LthAdaptBody *state,
                              LthCriterion criterion, const double *acceleration, double *value);

/// Unit normal of the plane across the largest principal stress, in rest space; along the cell's box where nothing pulls.
void lth_adapt_normal(const LthBody *body, LitheIndex cell, double normal[3]);

// adapt_mark.c

/// What becomes of the cells (mesh->n_cells). `may_undo`: merging and lowering are considered.
LitheStatus lth_adapt_mark(LitheCtx *ctx, const LthBody *body, const LthAdaptBody *state,
                           const LthAdaptValues *values, bool may_undo, LthMark *mark);
