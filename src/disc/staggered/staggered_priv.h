/// What the staggered_*.c files of this folder share.
#pragma once

#include "base/tensor.h"
#include "disc/staggered/staggered.h"
#include "disc/staggered/staggered_halo.h"
#include "disc/staggered/staggered_hierarchy.h"

/// Most unknowns of a component that interpolation reads.
#define LTH_STENCIL_MAX 16

/// A component's value (and gradient) at a place as a sum over unknowns at slots.
typedef struct LthStencil {
  int n;
  LitheCount slot[LTH_STENCIL_MAX];
  double w[LTH_STENCIL_MAX];
  double dw[LTH_STENCIL_MAX][3]; ///< [1/m]
} LthStencil;

static inline const LthStaggered *lth_staggered_const(const LthDisc *disc) { return disc->self; }

/// Least axis of shear samples: 0 in 3D, 2 in 2D.
static inline int lth_staggered_first_edge(const LthStaggered *s) { return s->dim == 3 ? 0 : 2; }

/// Place of the unknown of component a at a slot, at rest [m].
void lth_staggered_slot_place(const LthStaggered *s, LitheCount slot, int a, double x[3]);

static inline bool lth_staggered_slot_alive(const LthStaggered *s, int a, LitheCount slot) {
  return slot >= 0 && s->level.state[a][slot] != LTH_UNKNOWN_DEAD;
}

// staggered_fraction.c

/// Fractions of the boxes around the low face across axis a, and around the low edge along axis e, of the cell at
/// slot[0]; the slots around it are at strides, as in a halo.
double lth_staggered_face_fraction(const LthStaggered *s, const LitheCount *slot,
                                   const int stride[3], int a);
double lth_staggered_edge_fraction(const LthStaggered *s, const LitheCount *slot,
                                   const int stride[3], int e);

/// The same of the body alone: sides that are held count as the shape has them.
double lth_staggered_own_fraction(const LthStaggered *s, const LitheCount *slot,
                                  const int stride[3], int a);

/// Call `visit` for every function with the slots around its own, on all threads.
void lth_staggered_visit(const LthStaggered *s,
                         void (*visit)(const LthStaggered *s, LitheIndex func,
                                       const LitheCount *slot, const int stride[3], void *self),
                         void *self);

// staggered_weights.c

/// Fractions and materials to the weights of the level and the volume of cells, before rule A.
LitheStatus lth_staggered_weigh(LitheCtx *ctx, LthStaggered *s, double least);

// staggered_hold.c

/// Mark unknowns that a constraint selects and a control volume with material touches, in the level's states.
void lth_staggered_mark_held(LthStaggered *s);

/// After rule A: held unknowns that no sample reads die.
void lth_staggered_drop_unread(LthStaggered *s);

/// Fill `held` and `hold` once functions have numbers.
LitheStatus lth_staggered_build_holds(LitheCtx *ctx, LthStaggered *s);

// staggered_beyond.c

/// After functions have numbers: free unknowns inside the surface take the load and mass of their whole box, as in the
/// interior; what of it lies beyond a held side their held neighbours take off, so that all adds up to the body's.
LitheStatus lth_staggered_build_beyond(LitheCtx *ctx, LthStaggered *s);

/// f += such loads of a body force at time t.
void lth_staggered_load_beyond(const LthStaggered *s, const LthLoad *load, double t, double *f);

// staggered_wall.c

/// Samples between free unknowns and held ones get the stiffness of the way to where the hold begins.
LitheStatus lth_staggered_stiffen_walls(LitheCtx *ctx, LthStaggered *s);

// staggered_roller.c

/// Terms of rollers that are not along an axis, once functions have numbers.
LitheStatus lth_rollers_create(LitheCtx *ctx, LthStaggered *s);
void lth_rollers_destroy(LitheCtx *ctx, LthStaggered *s);
bool lth_rollers_act(const LthStaggered *s); ///< on something
/// Functions that they join with one, ascending, in a list that is lent; returns how many.
LitheCount lth_rollers_near(const LthStaggered *s, LitheIndex func, const LitheIndex **near);
/// Their part of K, of f0 by what is prescribed, of the energy [J]; forces on the body (n_rollers x 3) [N].
void lth_rollers_add_matrix(const LthStaggered *s, LthBlockMatrix *K);
void lth_rollers_add_load(const LthStaggered *s, double t, double *f0);
double lth_rollers_energy(const LthStaggered *s, double t, const double *x);
void lth_rollers_reactions(LthDisc *disc, double t, const double *x, double *reaction);

// staggered_assemble.c

LitheStatus lth_staggered_matrix_create(LitheCtx *ctx, const LthDisc *disc, LthBlockMatrix **K);
void lth_staggered_assemble(LthDisc *disc, double t, LthBlockMatrix *K, double *f0);
void lth_staggered_assemble_load(LthDisc *disc, double t, double *f0);

// staggered_mass.c

void lth_staggered_add_mass(const LthDisc *disc, double c, LthBlockMatrix *K);
void lth_staggered_apply_mass(const LthDisc *disc, const double *v, double *y);
void lth_staggered_mass_diagonal(const LthDisc *disc, double *mass);
void lth_staggered_add_gravity(const LthDisc *disc, const double gravity[3], double *f);

// staggered_parts.c

LitheIndex lth_staggered_parts(const LthDisc *disc, LitheIndex *part_of);

// staggered_energy.c

double lth_staggered_energy(LthDisc *disc, double t, const double *x);
void lth_staggered_stress(const LthDisc *disc, LitheIndex cell, const double *x, const double at[3],
                          double stress[6]);

// staggered_place.c

/// Component a at x, which may lie outside of the live cell at `slot`: linear fields are exact there too. By unknowns whose cells
/// have the mean fraction `least`, but for those of the cell itself; 0: by all.
void lth_staggered_stencil(const LthStaggered *s, LitheCount slot, int a, const double x[3],
                           double least, LthStencil *stencil);
/// Slopes of component a over a cell, in `dw`.
void lth_staggered_mean_stencil(const LthStaggered *s, LitheCount slot, int a, double least,
                                LthStencil *stencil);
int lth_staggered_eval(const LthDisc *disc, LitheIndex cell, const double x[3], LitheIndex *func,
                       double *phi);
int lth_staggered_eval_gradient(const LthDisc *disc, LitheIndex cell, const double x[3],
                                LitheIndex *func, double *dphi);
int lth_staggered_mean_gradient(const LthDisc *disc, LitheIndex cell, LitheIndex *func,
                                double *dphi);

// staggered_field.c

LitheIndex lth_staggered_find_cell(const LthDisc *disc, const double x[3], bool *inside);
void lth_staggered_turn(const LthDisc *disc, int axis, const double *x, double *y);
void lth_staggered_rest(const LthDisc *disc, double *x0);
void lth_staggered_one(const LthDisc *disc, double *one);
LitheStatus lth_staggered_project(LitheCtx *ctx, const LthDisc *disc,
                                  void (*field)(const void *self, const double x[3],
                                                double value[3]),
                                  const void *self, double *coef);

// staggered_solver.c

/// Matrix-free solves for a linear body in displacement form: sets the table's solver, and destroys what it set.
extern const LthDiscSolver lth_staggered_own_solver;
LitheStatus lth_staggered_solver_create(LitheCtx *ctx, LthStaggered *s);
void lth_staggered_solver_destroy(LitheCtx *ctx, LthStaggered *s);

// staggered_load.c

LitheStatus lth_staggered_add_load(LitheCtx *ctx, const LthDisc *disc, const LthLoad *load,
                                   double t, const double *x, double *f);

// staggered_mixed_state.c

/// Pressures of the mixed form, where it is that.
LitheStatus lth_mixed_state_create(LitheCtx *ctx, LthStaggered *s);
void lth_mixed_state_destroy(LitheCtx *ctx, LthStaggered *s);
void lth_mixed_state_archive(LthDisc *disc, LthArchive *archive);
/// Pressures as solved last come into force.
void lth_mixed_state_linearise(LthStaggered *s);
/// f += c C^T W p over cells of nu = 0.5 [N].
void lth_mixed_add_force(const LthStaggered *s, double c, double *f);
/// Sum of |cell| V p tr e there [J].
double lth_mixed_energy(const LthStaggered *s, const double *x);
/// p of a cell, over what lambda tr e gives [Pa].
double lth_mixed_pressure(const LthStaggered *s, LitheCount slot);

// staggered_mixed_solver.c

/// Solves of the mixed form, instead; needs the state.
LitheStatus lth_mixed_solver_create(LitheCtx *ctx, LthStaggered *s);
void lth_mixed_solver_destroy(LitheCtx *ctx, LthStaggered *s);
