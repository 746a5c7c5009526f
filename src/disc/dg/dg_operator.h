/// DG elasticity: element and face matrices, penalty, weak constraints, stiffness warping, assembly.
/// Kaufmann et al. 2009, sections 4.2 and 6, with the corrections of docs/theory/dg.md.
#pragma once

#include "disc/dg/dg_space.h"
#include "disc/disc.h"
#include "material/material.h"

typedef enum LthFlux { LTH_FLUX_IP, LTH_FLUX_BZ } LthFlux;

typedef enum LthPenaltyKind {
  LTH_PENALTY_AUTO,     ///< projected and split by a sharp local bound; BZ: softening below 2 %
  LTH_PENALTY_ETA,      ///< eq. (20) with eta, times lambda + 2 mu
  LTH_PENALTY_ETA_PLAIN ///< eq. (20) with eta, to the letter (no material constant)
} LthPenaltyKind;

typedef struct LthDgOperatorDef {
  const LthDgSpace *space;       ///< borrowed for life
  const double *young, *poisson; ///< per cell (mean)                     (n_cells)
  LthFlux flux;
  LthPenaltyKind penalty;
  double eta;          ///< for the eta kinds
  bool warped;         ///< stiffness warping (corotated)
  bool faces_only;     ///< terms of inner faces alone: the cells are another operator's
  const uint8_t *held; ///< unknowns that move as prescribed; borrowed for life; NULL: none (n_dofs)
  const LthWeakConstraint *weak; ///< copied; the patches are borrowed
  LitheIndex n_weak;
  const LthDgRecords
      *records; ///< NULL: integrals are the operator's own; else as those of the space
} LthDgOperatorDef;

typedef struct LthDgOperator LthDgOperator;

/// Integrate everything that does not change with time: element, face and constraint matrices.
LitheStatus lth_dg_operator_create(LitheCtx *ctx, const LthDgOperatorDef *def, LthDgOperator **op);
void lth_dg_operator_destroy(LitheCtx *ctx, LthDgOperator **op);

/// R_K = polar(mean gradient of position) for every cell, used by the next assembly; the identity at first
/// and, if not warped, always. x (n_dofs) [m].
void lth_dg_update_rotations(LthDgOperator *op, const double *x);

/// Set all R_K to the identity.
void lth_dg_reset_rotations(LthDgOperator *op);

/// An empty matrix for cells of 3 (func_off[c + 1] - func_off[c]) unknowns: diagonal and face neighbours.
/// func_off (n_cells + 1) starts at 0.
LitheStatus lth_dg_pattern_create(LitheCtx *ctx, const LthMesh *mesh, const LitheIndex *func_off,
                                  LthBlockMatrix **K);

/// The same for an operator's space.
LitheStatus lth_dg_matrix_create(LitheCtx *ctx, const LthDgOperator *op, LthBlockMatrix **K);

/// Values of the warped stiffness K and the vector f0 such that the internal force at position
/// coefficients x is f_int = K x - f0 with the rotations as they stand and constraint values of time t.
/// f_int = gradient of the elastic energy; equilibrium is f_int = f_ext. Allocates nothing.
void lth_dg_assemble(LthDgOperator *op, double t, LthBlockMatrix *K, double *f0);

/// Refresh f0 alone for another time or other constraint values (K unchanged).
void lth_dg_assemble_load(LthDgOperator *op, double t, double *f0);

/// Elastic energy at x with the rotations as they stand [J] (jumps and constraints included).
double lth_dg_energy(LthDgOperator *op, double t, const double *x);

/// What of it is that of jumps between elements and beside weak constraints, by fluxes and penalties [J].
double lth_dg_jump_energy(LthDgOperator *op, double t, const double *x);

/// Reaction force of each weak constraint on the body at x [N] (n_weak x 3).
void lth_dg_reactions(LthDgOperator *op, double t, const double *x, double *reaction);

/// Cauchy stress at a point of a cell, rotated to the deformed state; sym: xx yy zz yz zx xy [Pa].
void lth_dg_stress(const LthDgOperator *op, LitheIndex cell, const double *x, const double at[3],
                   double stress[6]);

/// Scale printed as `penalty` in the result: smallest and largest penalty over (lambda + 2 mu) / h.
void lth_dg_penalty_range(const LthDgOperator *op, double *min, double *max);
