/// Bodies that move: their state, and the static, quasistatic and dynamic drivers.
#pragma once

#include "la/engine.h"
#include "la/krylov.h"
#include "system/system.h"

typedef enum LthLinearChoice {
  LTH_LINEAR_AUTO,
  LTH_LINEAR_CHOLESKY,
  LTH_LINEAR_PCG,
  LTH_LINEAR_MULTIGRID,
  LTH_LINEAR_COUNT
} LthLinearChoice;

/// How time goes on. The first solves one linear system a step, the others iterate over rotations.
typedef enum LthIntegrator {
  LTH_IMPLICIT_EULER, ///< linearly implicit, rotations of the start of the step
  LTH_NEWTON_EULER,   ///< fully implicit
  LTH_BDF2,           ///< second order, damps what is faster than the step
  LTH_NEWMARK         ///< average acceleration: second order, damps nothing
} LthIntegrator;

/// What a simulation is asked for: decides which vectors it holds.
typedef enum LthStepUse {
  LTH_USE_STEPS,      ///< lth_simulation_step(), and whatever else
  LTH_USE_EQUILIBRIA, ///< lth_simulation_equilibrium() alone
  LTH_USE_ONE_EQUILIBRIUM ///< the same once, from rest: what only the way there needs is freed behind it
} LthStepUse;

typedef struct LthStepOptions {
  LthStepUse use;
  LthIntegrator integrator;
  LthLinearChoice linear;
  double tolerance;          ///< of the linear solver, relative
  LitheIndex max_iterations; ///< of PCG; 0: 10 sqrt(n) + 1000, with contact + 5000
  double newton_tolerance;   ///< relative residual of static equilibrium
  LitheIndex newton_iterations;
  double memory_limit; ///< bytes that `auto` may plan for; 0: three quarters of the machine's
  bool needs_matrix;   ///< somebody wants to look at lth_simulation_matrix()
} LthStepOptions;

LthStepOptions lth_step_options_default(void);

/// Whether `auto` takes multigrid for equilibria: foreseen from A's pattern alone, where a factor of a compact body's
/// matrix would be too large for `memory_limit` (bytes, 0: any) or for patience; or, once an analysis has
/// counted a factor's operations, because that costs more than iterations.
bool lth_step_foresees_levels(const LthBlockMatrix *A, double memory_limit);
bool lth_step_prefers_levels(const LthBlockMatrix *A, double flops);

/// Whether a system is solved without a matrix: it can be, and nothing speaks against it.
bool lth_step_needs_no_matrix(const LthSystem *system, const LthStepOptions *options);

/// Running totals and the last step's figures.
typedef struct LthStepReport {
  bool converged;                                  ///< all solves so far
  const char *linear;                              ///< "cholesky", "pcg" or "multigrid"
  const char *linear_reason;                       ///< why `auto` took it
  LitheIndex linear_iterations, newton_iterations; ///< of the last step
  LitheCount linear_total;                         ///< of the whole run
  LitheCount frozen_steps; ///< of an iterated integrator that were taken by LTH_IMPLICIT_EULER
  double residual;         ///< of the last step
  double strain_energy, kinetic_energy, work; ///< [J]
  double momentum[3], angular_momentum[3];
  LitheIndex contacts;
  double penetration; ///< [m]
  double contact_energy,
      contact_spare; ///< in its springs, and what they lost and may press others with [J]
  double time_assemble, time_factor, time_solve; ///< [s] in total
  double processor_factor;                       ///< as time_factor, of the processor
} LthStepReport;

typedef struct LthSimulation LthSimulation;

/// Start at rest; x = X0. Sets up matrices, solvers and scratch, so that steps allocate nothing. The system is
/// borrowed for life.
LitheStatus lth_simulation_create(LitheCtx *ctx, LthSystem *system, const LthStepOptions *options,
                                  LthSimulation **sim);
void lth_simulation_destroy(LitheCtx *ctx, LthSimulation **sim);

/// Free matrix, factors and preconditioners: a simulation whose fields another takes over makes no more steps.
void lth_simulation_free_solvers(LitheCtx *ctx, LthSimulation *sim);

/// Coefficients of all bodies, in the order of the system: position, velocity (n each), lent until the next
/// call. Writable by owners that set an initial state. The velocity may be NULL where equilibria alone are asked for: it is zero.
double *lth_simulation_position(LthSimulation *sim);
double *lth_simulation_velocity(LthSimulation *sim);
const double *lth_simulation_displacement(LthSimulation *sim); ///< x - X0, computed by each call

double lth_simulation_time(const LthSimulation *sim);

/// Put the clock where the steps were meant to lead [s]: sums of equal steps drift by rounding.
void lth_simulation_set_time(LthSimulation *sim, double t);
/// NULL where the only body is solved without one.
const LthBlockMatrix *lth_simulation_matrix(const LthSimulation *sim);

/// Largest over smallest eigenvalue of that matrix without the unknowns that are held. Overwrites their rows.
LitheStatus lth_simulation_condition(LitheCtx *ctx, LthSimulation *sim, double *condition);

/// The matrix of the last solve is symmetric to rounding and, where no contact has to hold a body, positive definite: an error that
/// says what it is not. For builds that check their own work.
LitheStatus lth_simulation_check_matrix(LitheCtx *ctx, const LthSimulation *sim);

/// External less internal force at the present state, after a step less the forces of inertia and damping too,
/// contact not among them: (n) [N], valid until the next call on `sim`. Overwrites the matrix.
LitheStatus lth_simulation_imbalance(LitheCtx *ctx, LthSimulation *sim, const double **force);

/// One step of length dt by the integrator of the options. Implicit Euler:
///   ((1 + h a) M + (h^2 + h b) K_w + contact) v1 = M v0 + h (f_ext - f_int(x0; R(x0))),  x1 = x0 + h v1.
/// A solve that misses its tolerance is told in the report (converged = false), not an error. After a failure
/// position, velocity and time are those of the start.
LitheStatus lth_simulation_step(LitheCtx *ctx, LthSimulation *sim, double dt);

/// Equilibrium at time t from the present state. Corotated bodies iterate rotations; where the plain
/// iteration does not fall, loads are stepped and steps damped. `report->converged` says whether the
/// residual came below newton_tolerance.
LitheStatus lth_simulation_equilibrium(LitheCtx *ctx, LthSimulation *sim, double t);

/// All that the next step depends on: state, totals, contact's memory, what the choice of a solver has
/// learnt, and the kept factor (as the state that it was made from: reading makes it again). Walks outwards
/// or inwards; inwards `sim` was created from the same definition.
void lth_simulation_archive(LthSimulation *sim, LthArchive *archive);

/// A field of coefficients of one system as that of another: `to` (n of the new one) is zero before.
typedef LitheStatus LthFieldMove(LitheCtx *ctx, const void *self, const double *from, double *to);

/// A velocity that was moved is corrected to what places and velocities were before.
typedef LitheStatus LthMotionMove(LitheCtx *ctx, const void *self, const double *x_from,
                                  const double *v_from, const double *x, double *v);

typedef struct LthStateMove {
  const void *self;
  LthFieldMove *field;
  LthMotionMove *motion; ///< of what moves, after its two fields
} LthStateMove;

/// Go on in the place of another simulation, whose system had other unknowns: position and velocity, time, totals and
/// what the integrator remembers. Solvers learn anew.
LitheStatus lth_simulation_inherit(LitheCtx *ctx, LthSimulation *sim, const LthSimulation *from,
                                   const LthStateMove *move);

/// Take the next step by Euler's rule where the integrator damps nothing: jumps that are weighed by other penalties than before may have
/// left large forces in motions much faster than a step, which would go on for ever.
void lth_simulation_settle(LthSimulation *sim);

/// The acceleration (n) [m/s^2] that the forces of now give, but contact's and those held back, where the mass is diagonal.
/// Overwrites the matrix.
LitheStatus lth_simulation_find_rate(LitheCtx *ctx, LthSimulation *sim, double *rate);

/// Keep an acceleration (n) [m/s^2] for a simulation that inherits.
LitheStatus lth_simulation_keep_rate(LitheCtx *ctx, LthSimulation *sim, const double *rate);

/// After inheriting with a kept acceleration: what is out of balance in the block rows marked is what new functions
/// release. Hold it back by a force that falls to 1/e in `decay` [s] (0: do not). `released`: its root mean
/// square over all mass [m/s^2]. Needs a matrix.
LitheStatus lth_simulation_hold_back(LitheCtx *ctx, LthSimulation *sim, const uint8_t *rows,
                                     double decay, double *released);

/// Recompute energies, momenta and work of the present state.
void lth_simulation_measure(LitheCtx *ctx, LthSimulation *sim);
const LthStepReport *lth_simulation_report(const LthSimulation *sim);
