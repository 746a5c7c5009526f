/// Equilibrium of bodies with a tangent: Newton's method, steps shortened along their line until the energy falls, and
/// loads that grow by steps where that fails (docs/theory/stepping.md). Nocedal and Wright, Numerical Optimization,
/// chapter 3.
#include "step/simulation_priv.h"

#include <float.h>
#include <math.h>
#include <string.h>

#define LEG_ITERATIONS 40 // of Newton's method before a leg is cut
#define FEW_ITERATIONS 8  // after so few the next leg is longer
#define LEAST_LEG (1.0 / 512)
#define LEG_CHANGE 0.5  // of deformation gradients by held unknowns in a leg: some 20 degrees
#define STEP_CHANGE 1   // and in a step: beyond, turns would go another way round
#define SUFFICIENT 1e-4 // part of the promised fall that a step must deliver
#define CUTS 20         // of a step
#define ENERGY_ROUNDING (256 * DBL_EPSILON)
#define FORCE_ROUNDING (64 * 0x1p-53)
#define PLACE_ROUNDING (8 * DBL_EPSILON)
#define INNER_TOLERANCE 1e-3 // of iterative solvers
#define STALLED_WINDOW 3
#define PAUSE_MAX 8      // iterations between tries of the exact tangent
#define SHIFT_START 1e-8 // c M over the diagonal of K, where K is found not definite
#define SHIFT_GROWTH 100

/// Memory of searches for equilibria; (n) each.
struct LthNewton {
  double *good;  // last state in balance
  double *from;  // where a step starts
  double *gap_x; // what held places and forces were off at the start: it fades as loads grow
  double *gap_f;
};

/// Where a search stands: loads and places of the time t0 + part (t1 - t0), gaps times 1 - part.
typedef struct Leg {
  LthNewton *n;
  double t0, t1, part;
  bool has_gap, has_energy;
  bool is_last;    // no shorter leg will be tried
  bool is_off;     // held unknowns are not yet where they belong
  double residual; // |f_ext - f_int| over free unknowns [N]
  double scale, floor;
  double potential,
      size;             // energy less the work of the forces; and what it is the difference of [J]
  double lowest, shift; // least residual; c of c M + K [1/s^2]
  int stalled;
  int without, pause; // iterations to go without the exact tangent, and how many next time
} Leg;

static bool has_follower(const LthSystem *system) {
  for (LitheIndex b = 0; b < system->n_bodies; b++)
    for (LitheIndex i = 0; i < system->bodies[b].n_loads; i++)
      if (lth_load_follows(&system->bodies[b].loads[i])) return true;
  return false;
}

bool lth_newton_applies(const LthSimulation *s) {
  const LthSystem *system = s->system;
  for (LitheIndex b = 0; b < system->n_bodies; b++)
    if (system->bodies[b].warped && !system->bodies[b].disc->has_tangent) return false;
  return system->warped && !s->has_contact;
}

bool lth_newton_has_energy(const LthSimulation *s) {
  for (LitheIndex c = 0; c < s->system->n_couplings; c++)
    if (s->system->couplings[c].is_nonlinear) return false;
  return lth_newton_applies(s) && !has_follower(s->system);
}

static double time_of(const Leg *leg) { return leg->t0 + leg->part * (leg->t1 - leg->t0); }

/// driven = where held unknowns belong less where they are.
static LitheStatus drive(LitheCtx *ctx, LthSimulation *s, const Leg *leg) {
  LITHE_TRY(lth_step_drive(ctx, s, time_of(leg), 1, s->x));
  for (LitheCount i = 0; leg->has_gap && s->system->has_held && i < s->n; i++)
    if (s->system->held[i]) s->driven[i] += (1 - leg->part) * leg->n->gap_x[i];
  return LITHE_OK;
}

/// Some held unknown is off its place by more than rounding.
static bool is_off_place(const LthSimulation *s) {
  double way = 0, size = 0;
  for (LitheCount i = 0; s->system->has_held && i < s->n; i++) {
    way = fmax(way, fabs(s->driven[i]));
    size = fmax(size, fabs(s->x[i]));
  }
  return way > PLACE_ROUNDING * size;
}

/// Energy at s->x less the work of the present forces f_ext on the way from s->start.
static void measure_potential(LthSimulation *s, Leg *leg) {
  double work = 0, energy = lth_system_energy(s->system, time_of(leg), s->x);
  for (LitheCount i = 0; i < s->n; i++) work += s->f_ext[i] * (s->x[i] - s->start[i]);
  leg->potential = energy - work;
  leg->size = fabs(energy) + fabs(work);
}

static LitheStatus evaluate(LitheCtx *ctx, LthSimulation *s, Leg *leg) {
  LITHE_TRY(lth_step_assemble(ctx, s, time_of(leg), s->x));
  for (LitheCount i = 0; leg->has_gap && i < s->n; i++) {
    double gap = (1 - leg->part) * leg->n->gap_f[i];
    s->f_ext[i] -= gap;
    s->force[i] -= gap;
  }
  LITHE_TRY(drive(ctx, s, leg));
  leg->is_off = is_off_place(s);
  double all = lth_step_norm(ctx, s->n, s->force), held = 0;
  memcpy(s->rhs, s->force, sizeof *s->rhs * (size_t)s->n);
  lth_system_zero_held(s->system, s->rhs);
  leg->residual = lth_step_norm(ctx, s->n, s->rhs);
  if (s->system->has_held) held = sqrt(fmax(0, all * all - leg->residual * leg->residual));
  leg->scale = lth_step_force_scale(ctx, s, time_of(leg), held, 0);
  leg->floor = FORCE_ROUNDING * lth_step_norm(ctx, s->n, s->f0);
  s->report.residual = leg->scale > 0 ? leg->residual / leg->scale : leg->residual;
  if (leg->has_energy) measure_potential(s, leg);
  return LITHE_OK;
}

static bool is_balanced(LitheCtx *ctx, LthSimulation *s, Leg *leg) {
  if (leg->is_off) return false;
  if (leg->residual <= s->options.newton_tolerance * leg->scale || leg->residual <= leg->floor)
    return true;
  leg->stalled = leg->residual < 0.5 * leg->lowest ? 0 : leg->stalled + 1;
  leg->lowest = fmin(leg->lowest, leg->residual);
  return leg->stalled >= STALLED_WINDOW && leg->residual <= lth_step_rounding_of_forces(ctx, s);
}

static void set_exact(LthSimulation *s, bool exact) {
  for (LitheIndex b = 0; b < s->system->n_bodies; b++) s->system->bodies[b].disc->is_exact = exact;
}

/// Solve (c M + K) d = force with the matrix as assembled. *good is false where K is found not definite, or the solver
/// gets nowhere.
static LitheStatus try_direction(LitheCtx *ctx, LthSimulation *s, const Leg *leg, bool *good) {
  double tolerance = s->solver == LTH_LINEAR_CHOLESKY ? s->options.tolerance : INNER_TOLERANCE;
  bool before = s->report.converged;
  memcpy(s->base, s->force, sizeof *s->base * (size_t)s->n);
  lth_step_combine(ctx, s, leg->shift, 1, 0);
  lth_step_constrain(ctx, s);
  memset(s->solution, 0, sizeof *s->solution * (size_t)s->n);
  LitheStatus status = lth_step_factor(ctx, s);
  s->report.converged = true;
  if (status == LITHE_OK) status = lth_step_solve(ctx, s, tolerance);
  *good = status == LITHE_OK && s->report.converged;
  s->report.converged = before; // a rough direction is one, too
  return status == LITHE_NOT_CONVERGED ? LITHE_OK : status;
}

/// A direction from the exact tangent where that is definite, for Newton's own speed; else from the semi-definite one,
/// whose steps are safe and slow, with some mass if even that is singular.
static LitheStatus find_direction(LitheCtx *ctx, LthSimulation *s, Leg *leg, bool *good) {
  const double unit = lth_step_stiffness_per_mass(s);
  bool exact = leg->without == 0;
  s->report.newton_iterations++;
  if (exact) {
    LITHE_TRY(try_direction(ctx, s, leg, good));
    leg->pause = *good ? 1 : leg->pause < PAUSE_MAX ? 2 * leg->pause : PAUSE_MAX;
    if (*good) return LITHE_OK;
    leg->without = leg->pause;
    set_exact(s, false);
    LITHE_TRY(evaluate(ctx, s, leg));
  }
  leg->without--;
  LITHE_TRY(try_direction(ctx, s, leg, good));
  while (!*good && leg->shift < unit) {
    leg->shift = fmin(fmax(leg->shift, SHIFT_START * unit / SHIFT_GROWTH) * SHIFT_GROWTH, unit);
    LITHE_TRY(evaluate(ctx, s, leg));
    LITHE_TRY(try_direction(ctx, s, leg, good));
  }
  leg->shift = leg->shift > SHIFT_START * unit ? leg->shift / SHIFT_GROWTH : 0;
  set_exact(s, leg->without == 0);
  return LITHE_OK;
}

/// s->x = from + alpha d
static void go(LthSimulation *s, const Leg *leg, double alpha) {
  for (LitheCount i = 0; i < s->n; i++) s->x[i] = leg->n->from[i] + alpha * s->solution[i];
}

/// Where the parabola through the energies at 0 and alpha has its least value, within a tenth and a half of alpha.
static double shorter(double alpha, double slope, double change) {
  double curve = change - slope * alpha;
  double least = curve > 0 ? -slope * alpha * alpha / (2 * curve) : 0.5 * alpha;
  return fmin(fmax(least, 0.1 * alpha), 0.5 * alpha);
}

/// A step along the direction that lets the energy fall as its slope promises. *found is false where there is none.
static void search_energy(LthSimulation *s, Leg *leg, double slope, double alpha, bool *found) {
  const double start = leg->potential;
  for (int cut = 0; cut < CUTS; cut++) {
    go(s, leg, alpha);
    measure_potential(s, leg);
    double change = leg->potential - start, rounding = ENERGY_ROUNDING * leg->size;
    *found = change <= SUFFICIENT * alpha * slope + rounding;
    if (*found) return;
    alpha = isfinite(change) ? shorter(alpha, slope, change) : 0.1 * alpha;
  }
}

/// The same by the residual, where the forces have no energy or it drowns in rounding.
static LitheStatus search_residual(LitheCtx *ctx, LthSimulation *s, Leg *leg, double alpha,
                                   bool *found) {
  const double start = leg->residual;
  for (int cut = 0; cut < CUTS / 4; cut++, alpha *= 0.5) {
    go(s, leg, alpha);
    LITHE_TRY(evaluate(ctx, s, leg));
    *found = leg->residual <= (1 - SUFFICIENT * alpha) * start;
    if (*found) return LITHE_OK;
  }
  *found =
      isfinite(leg->residual) && leg->residual < 2 * start; // rounding; the leg's own end decides
  return LITHE_OK;
}

/// How much deformation gradients change in the whole of a step.
static double measure_change(LthSimulation *s, const Leg *leg) {
  const LthSystem *system = s->system;
  double most = 0;
  go(s, leg, 1);
  for (LitheIndex b = 0; b < system->n_bodies; b++) {
    const LthDisc *disc = system->bodies[b].disc;
    LitheCount first = system->dof_first[b];
    if (disc->has_tangent)
      most = fmax(most, disc->table->gradient_change(disc, leg->n->from + first, s->x + first));
  }
  return most;
}

/// One step of Newton's method.
static LitheStatus advance(LitheCtx *ctx, LthSimulation *s, Leg *leg, bool *found) {
  memcpy(leg->n->from, s->x, sizeof *s->x * (size_t)s->n);
  bool was_off = leg->is_off;
  LITHE_TRY(find_direction(ctx, s, leg, found));
  if (!*found) return LITHE_OK;
  double slope = 0;
  for (LitheCount i = 0; i < s->n; i++) slope -= s->rhs[i] * s->solution[i];
  double change = measure_change(s, leg), alpha = fmin(1, STEP_CHANGE / change);
  if (was_off) // held unknowns move: there is nothing to compare with but how far
    *found = change <= LEG_CHANGE || leg->is_last;
  else if (leg->has_energy && -slope > ENERGY_ROUNDING * leg->size / SUFFICIENT)
    search_energy(s, leg, slope, alpha, found);
  else
    return search_residual(ctx, s, leg, alpha, found);
  return *found ? evaluate(ctx, s, leg) : LITHE_OK;
}

/// Newton's method at the leg's part from s->x.
static LitheStatus iterate(LitheCtx *ctx, LthSimulation *s, Leg *leg, LitheIndex most,
                           bool *balanced) {
  bool found = true;
  *balanced = false;
  leg->lowest = INFINITY;
  leg->stalled = 0;
  leg->shift = 0;
  leg->without = 0;
  leg->pause = 1;
  set_exact(s, true);
  LITHE_TRY(evaluate(ctx, s, leg));
  for (LitheIndex it = 0; isfinite(leg->residual); it++) {
    *balanced = is_balanced(ctx, s, leg);
    if (*balanced || it == most || !found) return LITHE_OK;
    if (lth_cancelled(ctx)) LITHE_FAIL(ctx, LITHE_INTERRUPTED, "interrupted");
    LITHE_TRY(advance(ctx, s, leg, &found));
  }
  return LITHE_OK;
}

/// What the start misses of the data at t0: what it takes to be balanced there.
static LitheStatus measure_gap(LitheCtx *ctx, LthSimulation *s, Leg *leg) {
  LthNewton *n = leg->n;
  memcpy(s->x, s->start, sizeof *s->x * (size_t)s->n);
  leg->part = 0;
  leg->has_gap = false;
  LITHE_TRY(evaluate(ctx, s, leg));
  for (LitheCount i = 0; i < s->n; i++) n->gap_x[i] = -s->driven[i];
  memcpy(n->gap_f, s->force, sizeof *n->gap_f * (size_t)s->n);
  lth_system_zero_held(s->system, n->gap_f);
  leg->has_gap = true;
  return LITHE_OK;
}

/// By legs that grow and shrink from s->start to all of the loads.
static LitheStatus walk(LitheCtx *ctx, LthSimulation *s, Leg *leg, bool *balanced) {
  const size_t bytes = sizeof *s->x * (size_t)s->n;
  const LitheIndex most =
      s->options.newton_iterations < LEG_ITERATIONS ? s->options.newton_iterations : LEG_ITERATIONS;
  double reached = 0, length = 0.25;
  LITHE_TRY(measure_gap(ctx, s, leg));
  memcpy(leg->n->good, s->start, bytes);
  while (reached < 1 && length >= LEAST_LEG) {
    LitheIndex before = s->report.newton_iterations;
    leg->part = fmin(1, reached + length);
    LITHE_TRY(iterate(ctx, s, leg, most, balanced));
    if (*balanced) {
      reached = leg->part;
      memcpy(leg->n->good, s->x, bytes);
      if (s->report.newton_iterations - before <= FEW_ITERATIONS) length *= 2;
    } else {
      memcpy(s->x, leg->n->good, bytes);
      length *= 0.5;
    }
  }
  *balanced &= reached == 1;
  return LITHE_OK;
}

static LitheStatus allocate(LitheCtx *ctx, LthSimulation *s) {
  if (s->newton) return LITHE_OK;
  LTH_NEW(ctx, s->newton, 1);
  double **vectors[] = {&s->newton->good, &s->newton->from, &s->newton->gap_x, &s->newton->gap_f};
  for (size_t i = 0; i < sizeof vectors / sizeof vectors[0]; i++) LTH_NEW(ctx, *vectors[i], s->n);
  return LITHE_OK;
}

void lth_newton_free(LitheCtx *ctx, LthNewton *newton) {
  if (!newton) return;
  double *vectors[] = {newton->good, newton->from, newton->gap_x, newton->gap_f};
  for (size_t i = 0; i < sizeof vectors / sizeof vectors[0]; i++) lth_free(ctx, vectors[i]);
  lth_free(ctx, newton);
}

/// At once, else by legs, else from the farthest state in balance as far as it goes.
static LitheStatus find_balance(LitheCtx *ctx, LthSimulation *s, Leg *leg, bool *balanced) {
  const LitheIndex all = s->options.newton_iterations;
  LITHE_TRY(iterate(ctx, s, leg, all < LEG_ITERATIONS ? all : LEG_ITERATIONS, balanced));
  if (!*balanced) LITHE_TRY(walk(ctx, s, leg, balanced));
  if (*balanced) return LITHE_OK;
  leg->part = 1;
  leg->is_last = true;
  return iterate(ctx, s, leg, all, balanced);
}

LitheStatus lth_newton_equilibrium(LitheCtx *ctx, LthSimulation *s, double t, bool *balanced) {
  LITHE_TRY(allocate(ctx, s));
  Leg leg = {
      .n = s->newton, .t0 = s->t, .t1 = t, .part = 1, .has_energy = lth_newton_has_energy(s)};
  LitheStatus status = find_balance(ctx, s, &leg, balanced);
  set_exact(s, false);
  return status;
}
