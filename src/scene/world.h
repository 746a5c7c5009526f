/// All bodies of a scene, and the one simulation that moves them.
#pragma once

#include "couple/tie.h"
#include "scene/body.h"

/// A tie of the scene.
typedef struct LthWorldTie {
  LitheIndex body[2];
  LthPatches *patches[2]; ///< what `where` selects of both
  LthTie *tie;
} LthWorldTie;

/// Two bodies that may touch, or the parts of one.
typedef struct LthWorldPair {
  LitheIndex body[2];
  bool by_parts;    ///< one of them has several
  uint8_t *tied[2]; ///< points that a tie holds, or NULL
  LthContact *contact;
} LthWorldPair;

typedef struct LthAdapt LthAdapt; // adapt.h

/// What a change of elements was.
typedef enum LthChangeKind {
  LTH_CHANGE_PLANE,
  LTH_CHANGE_BLADE,
  LTH_CHANGE_CARVE,
  LTH_CHANGE_ADAPT
} LthChangeKind;

/// Parts of what a change costs, in seconds of the processor.
typedef enum LthCostPart {
  LTH_COST_GEOMETRY,    ///< operations on the topology
  LTH_COST_MESH,        ///< the mesh of all cells, and what old and new ones have in common
  LTH_COST_SURFACE,     ///< the embedded surface cut
  LTH_COST_LISTS,       ///< of elements and faces: spaces, operators, constraints, loads
  LTH_COST_INTEGRATION, ///< of bases, face tables, matrices of elements
  LTH_COST_ASSEMBLY, ///< of rows of the stiffness that is kept; corotated bodies have it in every step
  LTH_COST_EMBEDDING, ///< of the surface
  LTH_COST_CONTACT,   ///< with colliders, and of bodies and parts
  LTH_COST_SYSTEM,    ///< vectors and the pattern of the matrix
  LTH_COST_TRANSFER,  ///< of the state and of what contacts remember
  LTH_COST_MEASURE,   ///< energies before and after, figures of the mesh
  LTH_COST_OUTPUT,    ///< observers
  LTH_COST_SOLVER,    ///< preconditioners and factors made anew in the next step
  LTH_COST_COUNT
} LthCostPart;

/// A clock that is read between parts.
typedef struct LthCost {
  double seconds[LTH_COST_COUNT];
  double last;       ///< when it was read
  LitheIndex n_told; ///< notes that have it
  bool waits;        ///< for the next step
} LthCost;

/// One change of one body, as result.json tells it.
typedef struct LthChangeNote {
  LthChangeKind kind;
  double t;             ///< [s]
  LitheIndex body, cut; ///< of the scene; cut -1: another change
  bool is_refused;      ///< nothing would be left of the body, and so nothing was changed
  LitheIndex n_split, n_separated, n_merged,
      n_removed;                  ///< elements split, faces parted, elements merged, taken away
  double area;                    ///< of one side of a cut [m^2]
  double volume;                  ///< of the body after it [m^3]
  LitheIndex elements;            ///< after it
  LitheCount unknowns;            ///< after it
  LitheIndex pieces;              ///< parts of the body that do not hang together, after it
  double strain[2], kinetic[2];   ///< of all bodies before and after [J]; 0 before the first solve
  double jump[2];                 ///< what of the body's strain energy is that of jumps
  double seconds[LTH_COST_COUNT]; ///< of the processor, of all changes of that time together
} LthChangeNote;

typedef struct LthWorld {
  const LthScene *scene;
  LitheIndex n_bodies;
  LthBody **bodies;  ///< in the scene's order                          (n_bodies)
  LthWorldTie *ties; ///< in the scene's order
  LitheIndex n_ties;
  LthWorldPair *pairs; ///< none where bodies do not collide
  LitheIndex n_pairs;
  LthSystem *system;
  LthSimulation *sim;

  // what has changed so far (change.h); none but where the scene has cuts or adapt
  bool *cut_done; ///< (scene->n_cuts)
  LthChangeNote *notes;
  LitheIndex n_notes, n_settled; ///< settled: energies are known
  LitheCount cap_notes;
  LitheIndex n_renewals;
  LthCost cost;    ///< of the last change
  LthAdapt *adapt; ///< NULL: nothing adapts
} LthWorld;

/// Build everything that a run needs. `times` (2): seconds spent on meshes and on all integration.
LitheStatus lth_world_create(LitheCtx *ctx, const LthScene *scene, double *times, LthWorld **world);
void lth_world_destroy(LitheCtx *ctx, LthWorld **world);

/// What is between bodies that are built (build_pair.c): ties first, then contact of every two and of the parts of each.
LitheStatus lth_world_build_system(LitheCtx *ctx, LthWorld *world); ///< and what static runs need
LitheStatus lth_world_create_simulation(LitheCtx *ctx,
                                        LthWorld *world); ///< bodies take their places
LitheStatus lth_world_build_ties(LitheCtx *ctx, LthWorld *world);
LitheStatus lth_world_build_pairs(LitheCtx *ctx, LthWorld *world);
void lth_world_free_ties(LitheCtx *ctx, LthWorld *world);
void lth_world_free_pairs(LitheCtx *ctx, LthWorld *world);

/// Only the bodies' meshes.
LitheStatus lth_world_create_meshes(LitheCtx *ctx, const LthScene *scene, LthWorld **world);

/// Whether a world that has its meshes could be run: materials, selections, and in static runs what holds
/// the bodies. Builds what that takes into it.
LitheStatus lth_world_check(LitheCtx *ctx, LthWorld *world);
