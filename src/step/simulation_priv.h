/// The open struct of a simulation, shared by the files of this room.
#pragma once

#include "la/reduction.h"
#include "step/anderson.h"
#include "step/simulation.h"

struct LthSimulation {
  LthSystem *system;
  LthStepOptions options;
  LthStepReport report;
  LitheCount n; // unknowns
  double t;     // [s]

  LthBlockMatrix *A; // K as assembled, then cm M + ck K
  LthBlockJacobi *jacobi;
  LthReduction *reduction; // red-black form of A, where there is no contact
  LthCg *cg;
  double *extra; // contact's part of the diagonal blocks, NULL without contact
  LitheCount n_extra;
  bool has_contact; // some body may touch something
  bool contact_on;  // points are active in the present system
  int8_t
      *freedom; // per body: 1: no constraint resists translations, -1: some does, 0: not known yet

  const LthEngine *engine;
  LthFactor *factor;  // analysed when first needed
  bool use_cholesky;  // decided for the present kind of solve
  bool static_chosen; // what `auto` took for equilibria: PCG for this reason, or Cholesky
  const char *static_reason;
  double cost[2][2]; // dynamic steps, without and with contact: PCG, kept factor
  LitheIndex n_tallied[2];
  bool no_lag;                            // no factor can be used
  bool fresh, stale;                      // made in this step; to be made again
  bool has_lagged;                        // one has been made
  double factor_step, factor_t;           // of what matrix: its time step, and when
  double *factor_x;                       // and from what state it was assembled           (n)
  LitheIndex fresh_iterations, age, life; // age in steps, and that which the factor before reached
  double age_cost;                        // of the iterations that its age has added

  double *x_rest, *x, *v, *u; // coefficients                                        (n)
  double *mass;               // lumped, per function [kg]
  double *row_mass;           // M 1, per function [kg]
  double *cm, *ck;            // factors of M and K in the present system, per body
  double *f_ext, *f0;
  double *force;      // f_ext - f_int [N]
  double *base, *rhs; // right-hand side without and with contact
  double *solution;   // of the linear system
  double *driven;     // prescribed values of held unknowns, zero elsewhere
  double *scratch;    // free between calls

  double *start, *f_before; // equilibria: state and loads at the start, NULL until the first
  LthAnderson *anderson;
  double *best; // and the state of the smallest residual
};

/// Rotations from x, K into A, f0 at time t, force = f_ext(t) + f0 - K x.
LitheStatus lth_step_assemble(LitheCtx *ctx, LthSimulation *s, double t);

/// Write `driven` = (prescribed position at t - x) / h for held unknowns.
LitheStatus lth_step_drive(LitheCtx *ctx, LthSimulation *s, double t, double h);

/// A = cm M + ck A, in place, with cm (1 + h a) and ck + h b of each body: Rayleigh damping over a step h, 0 for
/// equilibria.
void lth_step_combine(LitheCtx *ctx, LthSimulation *s, double cm, double ck, double h);

/// base -= A driven; rows and columns of held unknowns become those of the identity.
void lth_step_constrain(LitheCtx *ctx, LthSimulation *s);

/// Ordering and symbolic analysis of A, once.
LitheStatus lth_step_analyse(LitheCtx *ctx, LthSimulation *s);

/// Factor or precondition A as it stands (without contact).
LitheStatus lth_step_factor(LitheCtx *ctx, LthSimulation *s);

/// The same in dynamic steps, where `auto` keeps a factor for a time step h over several steps as a preconditioner
/// until the iterations that its age adds have cost as much as a new one.
LitheStatus lth_step_factor_lagged(LitheCtx *ctx, LthSimulation *s, double h);

/// After a dynamic step's solve: remember what it cost with the solver it had, and how much of that is due to
/// a factor's age.
void lth_step_tally(LthSimulation *s);

/// Solve A solution = base (+ contact) from the solution given, until |r| <= tolerance |b|; held unknowns
/// end at `driven`. Contact is revised after each solve, and the system solved again while its set changes.
LitheStatus lth_step_solve(LitheCtx *ctx, LthSimulation *s, double tolerance);

/// Contact of all bodies in the step t -> t + dt: how many points are active at first.
LitheStatus lth_step_detect(LitheCtx *ctx, LthSimulation *s, double t, double dt,
                            LitheIndex *n_active);

/// Contact's part of the system: y += C x, rhs += its forces, and the diagonal blocks of C (n_extra).
void lth_step_contact_apply(const LthSimulation *s, const double *x, double *y);
void lth_step_contact_rhs(const LthSimulation *s, double *rhs);
void lth_step_contact_diagonal(const LthSimulation *s, double *extra);

/// After a solve: true where the set of points has changed. Then its figures into the report.
bool lth_step_contact_revise(LthSimulation *s, const double *v1);
void lth_step_contact_report(LthSimulation *s);

/// Decide between Cholesky and PCG for equilibria (`is_static`) or dynamic steps, with the reason.
LitheStatus lth_step_choose(LitheCtx *ctx, LthSimulation *s, bool is_static);

/// |y|, the same bits for any number of threads.
double lth_step_norm(const LitheCtx *ctx, LitheCount n, const double *y);
