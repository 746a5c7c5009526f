/// The open struct of a simulation, shared by the files of this room.
#pragma once

#include "la/multilevel.h"
#include "la/reduction.h"
#include "step/anderson.h"
#include "step/simulation.h"

/// What every integrator solves in a step: v1 of M v1 = M v_hat + H F(x_hat + H v1, v1), where x1 = x_hat + H v1.
typedef struct LthStage {
  double H, t1;
  double contact_weight; // contact's forces act over this times H
  double ahead;          // x^ is that much beyond the start, at the velocity there [s]
  bool iterates;         // rotations follow the solution; else they are those of x_hat
  bool is_second_order;
  double *x_hat, *v_hat; // (n); all of them NULL before the first dynamic step
  double *p;             // M v_hat, or more: what the stage starts with
  double *v_last;        // iterate before
  double *x_start;       // position at the start of the step ...
  double *f_start;       // ... and the external force there, where the integrator asks for it

  // from the step before
  bool has_old;
  bool settles; // the next step is one of Euler's: elements were cut
  double h_old;
  double *x_old, *v_old; // bdf2: position and velocity a step earlier
  double *f_old;         // newmark: all forces but contact's at its end [N]
} LthStage;

/// Bodies that nothing holds, known from the first step on.
typedef struct LthRigid {
  bool *
      is_free; // no constraint resists translations of the body and of those it is tied to  (n_bodies)
  bool *
      is_alone; // it is tied to none                                                         (n_bodies)
  LitheIndex *
      group; // the first of those it is tied to                                           (n_bodies)
  bool spares; // some free body has mass damping
  double H;    // of the present system, 0: an equilibrium
  double
      *mode[6]; // M times the rigid motions of spared bodies, orthonormal in M; zero elsewhere (n)
} LthRigid;

/// A body as a rigid one.
typedef struct LthInertia {
  double mass, center[3];
  double tensor[9]; // about the centre
} LthInertia;

/// Pressures of bodies that keep their volume (step_volume.c).
typedef struct LthStepVolume LthStepVolume;

/// Memory of Newton's method for equilibria (step_newton.c).
typedef struct LthNewton LthNewton;

// leading unknowns of a block row that span the linear functions: of dg's elements; a node of cg has three in all
#define LTH_STEP_LINEAR 12

struct LthSimulation {
  LthSystem *system;
  LthStepOptions options;
  LthStepReport report;
  LitheCount n; // unknowns
  double t;     // [s]

  const LthDiscSolver *own; // of the only body, which needs no matrix; NULL: all of the following
  LthBlockMatrix *A;        // K as assembled, then cm M + ck K; NULL with `own`
  LthBlockJacobi *jacobi;
  LthStepVolume *volume;   // NULL: no body keeps its volume, or `own` does that
  LthReduction *reduction; // red-black form of A, where there is no contact
  LthCg *cg;
  double *extra; // contact's part of the diagonal blocks, NULL without contact
  LitheCount n_extra;
  bool has_contact;    // some body may touch something
  bool contact_on;     // points are active in the present system
  bool contact_stands; // and solves do not ask whether they should be

  const LthEngine *engine;
  LthFactor *factor;     // analysed when first needed
  LthMultilevel *levels; // made when first needed
  double *levels_x;      // and from what state (n), time step and time; NULL before
  double levels_step, levels_t;
  bool levels_touch;      // coarse levels know of contact:
  LthBlockMatrix *touch;  // it lumped to few blocks, as it was then; NULL: there was none yet
  double *touch_first;    // its values when the levels were created
  LthLinearChoice solver; // decided for the present kind of solve, never auto
  bool static_chosen;     // what `auto` took for equilibria: PCG for this reason, or Cholesky
  const char *static_reason;
  double cost[2][LTH_LINEAR_COUNT]; // dynamic steps, without and with contact, of each solver
  LitheIndex n_tallied[2];
  bool no_lag;                            // no factor can be used
  bool no_levels;                         // nor multigrid
  LthLinearChoice kept;                   // whose factor or levels are kept
  bool fresh, stale;                      // made in this step; to be made again
  bool has_lagged;                        // one has been made
  double factor_step, factor_t;           // of what matrix: its time step, and when
  double *factor_x;                       // and from what state it was assembled           (n)
  LitheIndex fresh_iterations, age, life; // age in steps, and that which the factor before reached
  double age_cost;                        // of the iterations that its age has added

  // those of step_vectors.c: some are NULL where the use of the simulation does not need them, some share a place
  double *x_rest, *x, *v, *u; // coefficients                                        (n)
  double *mass;               // lumped, per unknown [kg]
  double *rate;               // acceleration kept for a successor, or NULL [m/s^2]
  double *faded;       // part of f_ext that holds new functions back; NULL: there was none yet
  double *faded_start; // the same at the start of the step
  double *row_mass;    // M 1, per unknown [kg]
  double *cm, *ck;     // factors of M and K in the present system, per body
  double *f_ext, *f0;
  double *force;      // f_ext - f_int [N]
  double *base, *rhs; // right-hand side without and with contact
  double *solution;   // of the linear system
  double *driven;     // prescribed values of held unknowns, zero elsewhere
  double *
      held_force; // of constraints on held unknowns at the last state, one after the other (n_held)
  LitheCount n_held;
  double *scratch; // free between calls

  LthRigid rigid;
  LthStage stage; // of dynamic steps
  double *start,
      *f_before; // equilibria: state and loads at the start; NULL: at rest, without loads
  LthAnderson *anderson;
  LthNewton *newton; // NULL until first needed
  double *best;      // and the state of the smallest residual, where one solve is not all
};

// step_vectors.c

/// Vectors of a simulation, as its use and its system need them.
LitheStatus lth_step_vectors_create(LitheCtx *ctx, LthSimulation *s);
void lth_step_vectors_free(LitheCtx *ctx, LthSimulation *s);

/// y = A x with A as it stands: K after lth_step_assemble(), cm M + ck K after lth_step_combine().
void lth_step_apply(const LthSimulation *s, int threads, const double *x, double *y);

/// Diagonal of A as it stands (n).
void lth_step_diagonal(const LthSimulation *s, double *d);

/// Rotations from x, K into A, f0 at time t, force = f_ext(t) + f0 - K at.
LitheStatus lth_step_assemble(LitheCtx *ctx, LthSimulation *s, double t, const double *at);

/// Write `driven` = (prescribed position at t - from) / h for held unknowns.
LitheStatus lth_step_drive(LitheCtx *ctx, LthSimulation *s, double t, double h, const double *from);

/// A = cm M + ck A, in place, with cm (1 + h a) and ck + h b of each body: Rayleigh damping over a step h, 0 for
/// equilibria.
void lth_step_combine(LitheCtx *ctx, LthSimulation *s, double cm, double ck, double h);

/// base -= A driven; rows and columns of held unknowns become those of the identity.
void lth_step_constrain(LitheCtx *ctx, LthSimulation *s);

/// With `own`: make ready for A as it stands; solve (A + extra) solution = rhs from the solution given.
LitheStatus lth_step_prepare_own(LitheCtx *ctx, LthSimulation *s);
LitheStatus lth_step_solve_own(LitheCtx *ctx, LthSimulation *s, const LthOperator *extra,
                               double tolerance, LthSolveReport *report);

/// y = A x with contact, over free unknowns.
void lth_step_apply_system(const LthSimulation *s, int threads, const double *x, double *y);

/// Solve A solution = s->rhs from the solution given, contact as it stands, with the solver and preconditioner that are
/// ready.
LitheStatus lth_step_solve_linear(LitheCtx *ctx, LthSimulation *s, double tolerance,
                                  LthSolveReport *report);

/// Where some body keeps its volume: the same, with its pressures. They start from those in f0, which an assembly
/// begins anew with.
LitheStatus lth_step_volume_create(LitheCtx *ctx, LthSimulation *s);
void lth_step_volume_free(LitheCtx *ctx, LthStepVolume *volume);
void lth_step_volume_begin(LthSimulation *s);
LitheStatus lth_step_volume_solve(LitheCtx *ctx, LthSimulation *s, double tolerance,
                                  LthSolveReport *report);

/// f += forces of the pressures in f0; of those that the last solve has added to them. Also with `own`.
void lth_step_volume_push(const LthSimulation *s, double *f);
void lth_step_volume_push_change(const LthSimulation *s, double *f);

/// Ordering and symbolic analysis of A, once.
LitheStatus lth_step_analyse(LitheCtx *ctx, LthSimulation *s);

/// Make the multilevel preconditioner for A as it stands, of a step h, with the blocks of `touch`.
LitheStatus lth_step_create_levels(LitheCtx *ctx, LthSimulation *s, double h);

/// Take A, s->x and `touch` over into all levels, contact's diagonal blocks into the finest.
LitheStatus lth_step_update_levels(LitheCtx *ctx, LthSimulation *s);

/// Make levels ready for A, s->x and contact as they stand: created, or created anew where contact couples other blocks, or updated.
LitheStatus lth_step_make_levels(LitheCtx *ctx, LthSimulation *s, double h);

// step_touch.c

/// Contact as it stands, lumped, into s->touch. `*fits`: its blocks are those of before.
LitheStatus lth_step_lump_contact(LitheCtx *ctx, LthSimulation *s, bool *fits);

/// True where contact as it stands is much stiffer than what the levels know of it, or couples other rows; uses scratch and extra.
bool lth_step_outgrows_levels(LthSimulation *s);

/// Zero all of it.
void lth_step_clear_touch(LthSimulation *s);
LitheCount lth_step_touch_values(const LthSimulation *s); ///< how many it has

/// Both sets of its values, and pattern, in an archive.
void lth_step_touch_archive(LthSimulation *s, LthArchive *archive);

/// A factor or levels of now: where they were made.
void lth_step_date_factor(LthSimulation *s, double h);

/// Take A's and contact's present diagonal blocks into a preconditioner whose other parts may be older; levels that are too soft for
/// contact are made anew.
LitheStatus lth_step_refresh(LitheCtx *ctx, LthSimulation *s);

/// Factor or precondition A as it stands (a factor: without contact).
LitheStatus lth_step_factor(LitheCtx *ctx, LthSimulation *s);

/// The same in dynamic steps, where `auto` keeps a factor for a time step h over several steps as a preconditioner
/// until the iterations that its age adds have cost as much as a new one. So are multigrid's coarse levels.
LitheStatus lth_step_factor_lagged(LitheCtx *ctx, LthSimulation *s, double h);

/// After a dynamic step's solve: remember what it cost with the solver it had, and how much of that is due to
/// a factor's age.
void lth_step_tally(LthSimulation *s);

/// Solve A solution = base (+ contact) from the solution given, until |r| <= tolerance |b|; held unknowns
/// end at `driven`. Contact is revised after each solve, and the system solved again while its set changes,
/// unless it stands.
LitheStatus lth_step_solve(LitheCtx *ctx, LthSimulation *s, double tolerance);

/// Contact of all bodies in the step t -> t + dt, forces acting over weight dt, from places `ahead` [s] of those of the step's start, or in a look for an equilibrium: how
/// many points are active at first.
LitheStatus lth_step_detect(LitheCtx *ctx, LthSimulation *s, LthContactLook look, double t,
                            double dt, double weight, double ahead, LitheIndex *n_active);

/// The next look for contact begins the step of the last one once more.
void lth_step_contact_begin_again(LthSimulation *s);

/// Contact's part of the system: y += C x, rhs += its forces, and the diagonal blocks of C (n_extra).
void lth_step_contact_apply(const LthSimulation *s, const double *x, double *y);
void lth_step_contact_rhs(const LthSimulation *s, double *rhs);

// step_fade.c
LitheStatus lth_fade_inherit(LitheCtx *ctx, LthSimulation *s, const LthSimulation *from,
                             LthFieldMove *move, const void *self);
void lth_fade_archive(LthSimulation *s, LthArchive *a);

/// Keep for the step that begins what is held back at its start.
void lth_fade_begin(LthSimulation *s);

/// f_ext at (t, s->x), what is held back among it, of which no free body gets a moment; overwrites force and f0, and at
/// the first time the matrix.
LitheStatus lth_fade_external_force(LitheCtx *ctx, LthSimulation *s, double t);

void lth_step_contact_diagonal(const LthSimulation *s, double *extra);

/// After a solve: true where the set of points has changed. Then its figures into the report.
bool lth_step_contact_revise(LthSimulation *s, const double *v1);

/// After that: true where points were left out that pull and would make energy.
bool lth_step_contact_drop_pulls(LthSimulation *s);

void lth_step_contact_report(LthSimulation *s);

/// |rhs - (A + C) solution| over free unknowns with base, driven, A and contact as they stand, and |rhs|. Held
/// unknowns of the solution become `driven`.
void lth_step_residual(LitheCtx *ctx, LthSimulation *s, double *residual, double *scale);

/// y = base - A solution over free unknowns, contact left out.
void lth_step_defect(LitheCtx *ctx, LthSimulation *s, double *y);

/// y of a body = e_k x (x - c), or the translation along e_k for k - 3.
void lth_rigid_motion(const LthSimulation *s, LitheIndex b, const LthInertia *inertia, int k,
                      const double *x, double *y);

/// sum += weight sum of x_i x y_i over a body.
void lth_rigid_add_moment(const LthSimulation *s, LitheIndex b, double weight, const double *x,
                          const double *y, double sum[3]);

/// Keep the state at the start of a step; allocates at the first.
LitheStatus lth_stage_begin(LitheCtx *ctx, LthSimulation *s);
void lth_stage_free(LitheCtx *ctx, LthStage *stage);

/// True where some body has it; then y += weight b f0(t), f0 of weak constraints at t (NULL: to be assembled).
bool lth_stage_has_stiffness_damping(const LthSystem *system);
void lth_stage_add_damped_load(LthSimulation *s, double weight, double t, const double *f0,
                               double *y);

/// Solve the stage for s->solution = v1 from the solution given. Leaves s->x anywhere. `*ended`: false where rotations that
/// should follow the solution do not settle.
LitheStatus lth_stage_solve(LitheCtx *ctx, LthSimulation *s, bool *ended);

/// Whether Newton's method finds equilibria: all bodies that are not linear have tangents, and nothing touches. And
/// whether forces have an energy.
bool lth_newton_applies(const LthSimulation *s);
bool lth_newton_has_energy(const LthSimulation *s);

/// Equilibrium at time t from s->start = s->x at the last one, by loads that grow in steps where needed.
LitheStatus lth_newton_equilibrium(LitheCtx *ctx, LthSimulation *s, double t, bool *balanced);
void lth_newton_free(LitheCtx *ctx, LthNewton *newton);

/// Size of the diagonal of K per mass [1/s^2], with A = K.
double lth_step_stiffness_per_mass(const LthSimulation *s);

/// Size of the forces that balance at s->x [N], `held` and `contact` among them.
double lth_step_force_scale(LitheCtx *ctx, LthSimulation *s, double t, double held, double contact);

/// Residual that rounding of f_int leaves at s->x [N], with A = K. Overwrites s->base.
double lth_step_rounding_of_forces(LitheCtx *ctx, LthSimulation *s);

/// Which bodies are free, once; assembles for it.
LitheStatus lth_rigid_find(LitheCtx *ctx, LthSimulation *s);
void lth_rigid_free(LitheCtx *ctx, LthRigid *rigid);

/// Mass and centre of a body at x; and its inertia, with `motion` and `momentum` (n each) as scratch.
void lth_rigid_measure(LthSimulation *s, LitheIndex b, const double *x, LthInertia *inertia);
void lth_rigid_inertia(LthSimulation *s, LitheIndex b, const double *x, double *motion,
                       double *momentum, LthInertia *inertia);

/// Angular velocity [rad/s] that gives a body its angular momentum about the centre; false where it has no inertia.
bool lth_rigid_turn(const LthInertia *inertia, const double momentum[3], double turn[3]);

/// Rigid motions of bodies at x that mass damping spares; overwrites rhs and scratch. Then y += weight a M (what of v
/// is their rigid motion).
void lth_rigid_prepare(LthSimulation *s, const double *x);
void lth_rigid_spare(const LthSimulation *s, double weight, const double *v, double *y);

/// Where bodies are free their momentum is known beforehand, P1 = P^ + H F: a translation takes away what rounding
/// and the solver's tolerance leave; and so is their angular momentum, that the scheme itself would miss.
void lth_stage_balance(LthSimulation *s, double dt);

/// Decide between Cholesky, PCG and multigrid for equilibria (`is_static`) or dynamic steps, with the reason.
LitheStatus lth_step_choose(LitheCtx *ctx, LthSimulation *s, bool is_static);

/// The solver of a step did not come to the tolerance: where `auto` took it, it is made anew or not taken again in steps with (without)
/// contact. True if there is something else to try.
bool lth_step_has_other_way(LthSimulation *s);

/// Work since (t0, x0) of weak constraints that move, by the mean over both ends.
double lth_work_of_weak(LthSimulation *s, double t0, const double *x0);

/// Work on the way from x0 of those that hold unknowns, from s->force, their imbalance at s->x. `share`: weight of the
/// forces at the start, 0.5 or 0.
double lth_work_of_held(LthSimulation *s, const double *x0, double share);

/// Both for the step that ends at s->t, into the report.
LitheStatus lth_work_of_step(LitheCtx *ctx, LthSimulation *s, double t0, double share);

/// |y|, the same bits for any number of threads.
double lth_step_norm(const LitheCtx *ctx, LitheCount n, const double *y);
