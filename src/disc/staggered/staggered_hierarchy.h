/// Levels of geometric multigrid on a staggered grid, and plain kernels on them.
/// Coarsening and transfers: docs/theory/staggered-multigrid.md.
#pragma once

#include "disc/staggered/staggered_level.h"

#define LTH_STAGGERED_MAX_LEVELS 24

/// When to stop coarsening.
typedef struct LthCoarsenDef {
  LitheCount enough; ///< free unknowns that need no coarser level; 0: 1500
  double
      thin_fraction; ///< share of cells in features thinner than three cells that a level may have; 0: 0.05
} LthCoarsenDef;

/// Level 0 is the finest: its arrays are those given, borrowed for life; the others are owned. Cell I of a level
/// covers cells 2 I and 2 I + 1 of the finer one along every axis (2D: along x and y). They are packed if the finest is.
typedef struct LthStaggeredHierarchy {
  int n_levels;
  bool stopped_thin; ///< the coarsest level is not small: a coarser one would not resolve the body
  LthStaggeredLevel level[LTH_STAGGERED_MAX_LEVELS];
  LitheCount n_free[LTH_STAGGERED_MAX_LEVELS]; ///< free unknowns
} LthStaggeredHierarchy;

LitheStatus lth_staggered_hierarchy_create(LitheCtx *ctx, const LthStaggeredLevel *fine,
                                           const LthCoarsenDef *def,
                                           LthStaggeredHierarchy **hierarchy);
void lth_staggered_hierarchy_destroy(LitheCtx *ctx, LthStaggeredHierarchy **hierarchy);

/// Bytes of the coarse levels.
LitheCount lth_staggered_hierarchy_bytes(const LthStaggeredHierarchy *hierarchy);

/// Rule A on a level whose lambda, mu, shear and mass are set and whose held unknowns are marked: unknowns are free
/// where they touch a cell that holds something; samples that touch dead unknowns, and the mass of these, become 0.
void lth_staggered_rule_a(LitheCtx *ctx, LthStaggeredLevel *level);

LitheCount lth_staggered_count_free(LitheCtx *ctx, const LthStaggeredLevel *level);

/// Low and high (inclusive) fine cells under a coarse box: that of a cell, and shifted by half a coarse cell towards
/// lower places along the axes in `shifted`.
static inline void lth_fine_box(int dim, const LitheIndex cell[3], int shifted, LitheIndex low[3],
                                LitheIndex high[3]) {
  for (int a = 0; a < 3; a++) {
    bool flat = dim == 2 && a == 2;
    low[a] = flat ? 0 : 2 * cell[a] - (shifted >> a & 1);
    high[a] = flat ? 0 : low[a] + 1;
  }
}

/// One level coarser: its grid (owned by the caller) and coefficients.
LitheStatus lth_staggered_coarsen(LitheCtx *ctx, const LthStaggeredLevel *fine,
                                  LthSparseGrid **grid, LthStaggeredLevel *coarse);

/// Whether face a of a coarse cell is held: where the middle of the fine faces that make it up is behind a wall. One held face is
/// enough where a hold is thin.
bool lth_staggered_coarse_is_held(const LthStaggeredLevel *fine, const LitheIndex cell[3], int a);

/// Share of the solid cells of a grid that lie in features thinner than three cells; `solid` is how much of a cell
/// is filled (n_slots). `where`, unless NULL, becomes the slot of one of them, -1: none.
LitheStatus lth_staggered_thin_share(LitheCtx *ctx, const LthSparseGrid *grid, const float *solid,
                                     double *share, LitheCount *where);

// Plain kernels, loops in the order of the theory: for tests, and for set-up on coarse levels. Vectors are three
// (2D: two) components over slots; what is not free counts as it stands in inputs and is zero in outputs.

/// y = (cm M + ck K) u.
void lth_staggered_apply_ref(LitheCtx *ctx, const LthStaggeredLevel *level, double cm, double ck,
                             const double *const u[3], double *const y[3]);
/// diagonal = that of cm M + ck K, 0 where an unknown is not free.
void lth_staggered_diagonal_ref(LitheCtx *ctx, const LthStaggeredLevel *level, double cm, double ck,
                                double *const diagonal[3]);
/// fine = P coarse: linear along the component, 3/4 - 1/4 across it, of what is not dead.
void lth_staggered_prolong_ref(LitheCtx *ctx, const LthStaggeredLevel *coarse,
                               const LthStaggeredLevel *fine, const double *const u_coarse[3],
                               double *const u_fine[3]);
/// coarse = P^T fine.
void lth_staggered_restrict_ref(LitheCtx *ctx, const LthStaggeredLevel *coarse,
                                const LthStaggeredLevel *fine, const double *const r_fine[3],
                                double *const r_coarse[3]);
/// Unknowns of the coarse level that a free fine one is interpolated from, with weights of sum 1 (beside a wall: such that displacements
/// in proportion to the distance from it are kept); returns how many.
/// `unit` is lth_staggered_modulus_unit() of the coarse level.
int lth_staggered_parents(const LthStaggeredLevel *coarse, const LthStaggeredLevel *fine,
                          double unit, int a, const LitheIndex fine_cell[3], LitheCount slot[8],
                          double weight[8]);

/// What the weights of a free fine unknown's parents are multiplied by where a held one is among them; 0: by the inverse of their sum.
double lth_staggered_wall_scale(const LthStaggeredLevel *coarse, const LthStaggeredLevel *fine,
                                double unit, int a, const LitheIndex fine_cell[3]);

/// Greatest mu of a level that knows its volumes, else 0. Where it is not 0, interpolation to the next finer level weighs
/// unknowns by lth_staggered_pull(): what is soft follows what is stiff, and what is full what is nearly empty.
double lth_staggered_modulus_unit(const LthStaggeredLevel *level);
/// 0 where an unknown is dead, else 1, or where `unit` is not 0: mu of the cells around its face over it, and less where
/// less than a quarter of them is filled.
double lth_staggered_pull(const LthStaggeredLevel *level, double unit, int a, LitheCount slot);
