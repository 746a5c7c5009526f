/// The open struct of a simulation, shared by the files of this room.
#pragma once

#include "la/reduction.h"
#include "step/anderson.h"
#include "step/simulation.h"

struct LthSimulation {
  LthBodyDef body;
  LthStepOptions options;
  LthStepReport report;
  LitheCount n; // unknowns
  double t;     // [s]
  bool has_strong;

  LthBlockMatrix *A; // K as assembled, then cm M + ck K
  LthBlockJacobi *jacobi;
  LthReduction *reduction; // red-black form of A, where there is no contact
  LthCg *cg;
  double *extra; // contact's part of the diagonal blocks, NULL without contact
  LitheCount n_extra;
  bool contact_on; // points are active in the present system
  int freedom;     // 1: no constraint resists translations, -1: some does, 0: not known yet

  const LthEngine *engine;
  LthFactor *factor;  // analysed when first needed
  bool use_cholesky;  // decided for the present kind of solve
  bool static_chosen; // what `auto` took for equilibria: PCG for this reason, or Cholesky
  const char *static_reason;
  double cost[2][2]; // dynamic steps, without and with contact: PCG, kept factor
  LitheIndex n_tallied[2];
  bool no_lag;                            // no factor can be used
  bool fresh, stale;                      // made in this step; to be made again
  double factor_cm, factor_ck;            // of what matrix
  LitheIndex fresh_iterations, age, life; // age in steps, and that which the factor before reached
  double age_cost;                        // of the iterations that its age has added

  double *x_rest, *x, *v, *u; // coefficients                                        (n)
  double *mass;               // per function [kg]
  double *f_fixed;            // gravity and loads that never change [N]
  double *f_ext, *f0;
  double *force;      // f_ext - f_int [N]
  double *base, *rhs; // right-hand side without and with contact
  double *solution;   // of the linear system
  double *driven;     // prescribed values of the unknown in strong cells, zero elsewhere
  double *scratch;    // free between calls

  double *start, *f_before; // equilibria: state and loads at the start, NULL until the first
  LthAnderson *anderson;
  double *best; // and the state of the smallest residual
};

/// Unknowns of cell K are [first, last).
static inline LitheCount lth_cell_first(const LthSimulation *s, LitheIndex cell) {
  return 3 * (LitheCount)s->body.space->func_off[cell];
}

static inline bool lth_is_strong(const LthSimulation *s, LitheIndex cell) {
  return s->body.strong && s->body.strong[cell];
}

/// f_ext at time t and position x: what never changes plus the other loads.
LitheStatus lth_step_external_force(LitheCtx *ctx, LthSimulation *s, double t);

/// Rotations from x, K into A, f0 at time t, force = f_ext(t) + f0 - K x.
LitheStatus lth_step_assemble(LitheCtx *ctx, LthSimulation *s, double t);

/// Write `driven` = (prescribed position at t - x) / h for strong cells.
LitheStatus lth_step_drive(LitheCtx *ctx, LthSimulation *s, double t, double h);

/// A = cm M + ck A, in place.
void lth_step_combine(LitheCtx *ctx, LthSimulation *s, double cm, double ck);

/// y = 0 in strong cells.
void lth_step_zero_strong(const LthSimulation *s, double *y);

/// base -= A driven; rows and columns of strong cells become those of the identity.
void lth_step_constrain(LitheCtx *ctx, LthSimulation *s);

/// Factor or precondition A as it stands (without contact).
LitheStatus lth_step_factor(LitheCtx *ctx, LthSimulation *s);

/// The same in dynamic steps, where `auto` keeps a factor of cm M + ck K over several steps as a preconditioner
/// until the iterations that its age adds have cost as much as a new one.
LitheStatus lth_step_factor_lagged(LitheCtx *ctx, LthSimulation *s, double cm, double ck);

/// After a dynamic step's solve: remember what it cost with the solver it had, and how much of that is due to
/// a factor's age.
void lth_step_tally(LthSimulation *s);

/// Solve A solution = base (+ contact) from the solution given, until |r| <= tolerance |b|; strong cells
/// end at `driven`. Contact is revised after each solve, and the system solved again while its set changes.
LitheStatus lth_step_solve(LitheCtx *ctx, LthSimulation *s, double tolerance);

/// Decide between Cholesky and PCG for equilibria (`is_static`) or dynamic steps, with the reason.
LitheStatus lth_step_choose(LitheCtx *ctx, LthSimulation *s, bool is_static);

/// |y|, the same bits for any number of threads.
double lth_step_norm(const LitheCtx *ctx, LitheCount n, const double *y);
