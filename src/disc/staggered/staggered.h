/// The staggered discretisation of one body: fractions, materials and what is held to coefficients and unknowns.
/// Dolny 2025, sections 3.3 and 4; docs/theory/staggered.md.
#pragma once

#include "disc/disc.h"
#include "disc/staggered/staggered_level.h"
#include "geometry/fractions.h"
#include "material/material.h"

/// What holds some unknowns: a constraint of the scene. `selects` is thread-safe; both it and `values` are asked at
/// the unknown's own place.
typedef struct LthStaggeredHold {
  bool (*selects)(const void *self, const double x[3]);
  const void *self;
  bool fixed[3];
  bool is_position;  ///< value is the deformed place, not the displacement
  bool is_wall;      ///< holds all components, everywhere by the same displacement
  LthValue value[3]; ///< [m]
} LthStaggeredHold;

/// A roller on boundary that is not along an axis: `selects` says which, at a point with an outward unit normal, and is
/// thread-safe.
typedef struct LthStaggeredRoller {
  bool (*selects)(const void *self, const double point[3], const double normal[3]);
  const void *self;
  LthValue value; ///< displacement along the normal [m]
  bool moves;     ///< it varies with time
} LthStaggeredRoller;

/// What the boundary unknowns of a load add up to.
typedef struct LthBoundarySum {
  double area;
  double wanted[3], given[3]; ///< force that tractions are, and that unknowns got [N]
  double weight[3]; ///< what a difference of the two is spread over: area seen by a component
} LthBoundarySum;

/// Beyond a held side a free unknown carries what is not the body's, `volume` of its box too much; a held one beside
/// it takes that off again. Unknowns by 3 function + component.
typedef struct LthStaggeredBeyond {
  LitheCount free, held;
  double volume; ///< share of a cell
} LthStaggeredBeyond;

typedef enum LthFormulation { LTH_FORM_DISPLACEMENT, LTH_FORM_MIXED } LthFormulation;

typedef struct LthStaggeredDef {
  const LthFractions
      *fractions;            ///< of the solid, parts on held sides full already; borrowed for life
  const LthShape *shape;     ///< for nearest boundary points and normals; borrowed for life
  LthMaterialField material; ///< borrowed for life
  LthMaterialModel model;
  LthFormulation formulation;
  const LthStaggeredHold *holds; ///< borrowed for life                          (n_holds)
  LitheIndex n_holds;
  const LthStaggeredRoller
      *rollers; ///< weak constraints in this order; borrowed for life (n_rollers)
  LitheIndex n_rollers;
  const LthFractions *
      own; ///< fractions before held sides became full, on the same grid; borrowed for life; NULL: none did
  double least_fraction; ///< of rule A: cells with less hold nothing; 0: 1e-4
} LthStaggeredDef;

typedef struct LthMixedState LthMixedState;
typedef struct LthStaggeredRollers LthStaggeredRollers;

/// Immutable but for the state of the linearisation that update_rotations() keeps.
typedef struct LthStaggered {
  LthDisc disc;       ///< disc.self is this struct; disc.mesh is NULL
  LthDiscTable table; ///< disc.table: its solver is that of the formulation
  LitheCtx *ctx;
  int dim;
  const LthFractions *fractions;
  const LthShape *shape;
  const LthSparseGrid *grid; ///< that of the fractions
  LthMaterialField material;
  LthMaterialModel model;
  LthFormulation formulation;
  LthStaggeredLevel
      level; ///< weighted coefficients and states; V is 0 where rule A leaves cells out. Packed in linear
             ///< bodies

  LitheIndex *func;      ///< function of a slot, -1 where none of its unknowns is alive   (n_slots)
  LitheIndex *slot;      ///< slot of a function, ascending                                (n_funcs)
  LitheIndex *cell;      ///< cell of a slot, -1 where it holds nothing                    (n_slots)
  LitheIndex *cell_slot; ///< slot of a cell, ascending                               (disc.n_cells)

  const LthStaggeredHold *holds;
  LitheIndex n_holds;
  const LthStaggeredRoller *roller;
  LitheIndex n_rollers;
  LthWeakConstraint *weak;      ///< the same as disc.weak                    (n_rollers)
  LthStaggeredRollers *rollers; ///< their terms (staggered_roller.h), or NULL
  const LthFractions *own;      ///< as in the definition
  LthStaggeredBeyond *beyond;   ///< what free unknowns carry beyond held sides     (n_beyond)
  LitheCount n_beyond, cap_beyond;
  double *f0;           ///< K rest, once a matrix exists; or NULL      (n_dofs)
  double *partial;      ///< scratch of sums                           (grid->n_blocks)
  LthBoundarySum *sums; ///< scratch of loads                          (grid->n_blocks)
  uint8_t *degree;      ///< (n_cells)
  LitheIndex *row_func; ///< (n_rows + 1)

  uint8_t *held;        ///< per unknown: held by a constraint, or dead                  (n_dofs)
  int16_t *hold;        ///< constraint behind a held unknown, -1 where it is free or dead (n_dofs)
  LthMixedState *mixed; ///< of the mixed form (staggered_mixed_state.c), or NULL
  void *nonlinear;      ///< of corotated and neo-Hookean bodies (staggered_finite.c), or NULL
  void *solver;         ///< of matrix-free solves (staggered_solver.c), or NULL
} LthStaggered;

static inline LthStaggered *lth_staggered_of(const LthDisc *disc) { return disc->self; }

/// LITHE_BAD_INPUT: nothing is left by rule A, a material out of range, nu = 0.5 without the mixed form.
LitheStatus lth_staggered_create(LitheCtx *ctx, const LthStaggeredDef *def, LthDisc **disc);

/// Where the unknown of component a of a function is at rest [m].
void lth_staggered_place(const LthStaggered *s, LitheIndex func, int a, double x[3]);

/// Unknowns that are held (n_dofs), and their places at time t, for LthSystemBody.
const uint8_t *lth_staggered_held(const LthDisc *disc);
LitheStatus lth_staggered_prescribe(const void *disc, double t, double *x);

/// Whether a roller holds anything.
bool lth_staggered_roller_acts(const LthDisc *disc, LitheIndex roller);

/// reaction (n_holds x 3) += forces of constraints on the body, from the imbalance of all forces (n_dofs) [N].
void lth_staggered_add_reactions(const LthDisc *disc, const double *imbalance, double *reaction);
