/// Equilibrium of linear and corotated bodies: fixed point over rotations, damped where that fails
/// (docs/theory/stepping.md).
#include "step/simulation_priv.h"

#include <math.h>
#include <string.h>

#define PLAIN_WINDOW 12      // iterations in which the plain fixed point must halve its residual
#define INNER_TOLERANCE 1e-3 // of PCG within a rotation iteration
#define ROUNDING (64 * 0x1p-53)
#define STALLED_WINDOW 3               // iterations without a halved residual that may be rounding
#define STALLED_ROUNDING (4 * 0x1p-53) // of places and of entries, next to |K| |x|
#define LOST 1e-3          // of the loads: rounding of K u that leaves no digits to trust
#define DAMPING_START 1e-2 // c M over the diagonal of K
#define DAMPING_GROWTH 4
#define DAMPING_LOWEST 1e-10
#define NEAR 1e-2          // residual over the forces' size, for contact by its tangent
#define REJECTED 1.2       // times the best residual: go back ...
#define REJECTED_FROM 1e-5 // ... and damp from there on, c M over the diagonal of K ...
#define REJECTED_GROWTH 16 // ... this much more

/// Where an equilibrium search stands.
typedef struct Search {
  double t;
  double residual; // |f_ext - f_int + contact| over unknowns that are free [N]
  double scale;    // size of the forces that balance [N]
  double floor;    // residual that rounding leaves [N]
  double damping;  // c of c M + K [1/s^2], 0: plain
  double lowest;   // smallest residual of this pass [N]
  int stalled;     // iterations since it last halved
  LthContactLook look;
  double best; // smallest residual so far, its state in s->best
  bool best_touches;
} Search;

// What c is measured in.
double lth_step_stiffness_per_mass(const LthSimulation *s) {
  double stiffness = 0, mass = 0;
  lth_step_diagonal(s, s->scratch);
  for (LitheCount i = 0; i < s->n; i++) {
    stiffness += fabs(s->scratch[i]);
    mass += s->mass[i];
  }
  return mass > 0 ? stiffness / mass : 0;
}

/// Contact at rest, as in a step of length one: its forces then come unscaled.
static LitheStatus contact_force(LitheCtx *ctx, LthSimulation *s, Search *q, double *f) {
  LitheIndex n_active = 0;
  LITHE_TRY(lth_step_detect(ctx, s, q->look, q->t, 1, 1, 0, &n_active));
  if (n_active > 0) lth_step_contact_rhs(s, f);
  return LITHE_OK;
}

/// The forces that balance: external ones, those that hold unknowns, and those that hold or stretch
/// the body elsewhere (2 W / |u| is a lower bound of the inner forces' size).
double lth_step_force_scale(LitheCtx *ctx, LthSimulation *s, double t, double held,
                            double contact) {
  double scale = fmax(fmax(lth_step_norm(ctx, s->n, s->f_ext), held), contact);
  double u = lth_step_norm(ctx, s->n, lth_simulation_displacement(s));
  if (u > 0) scale = fmax(scale, 2 * fabs(lth_system_energy(s->system, t, s->x)) / u);
  return scale;
}

/// force = f_ext - f_int in the form that small displacements u = x - X0 ask for,
///   f_int = K u - g + pressures,   g = f0 + pressures - K X0,
/// with a row of g left out where rounding is all that it can be: next to the size of K X0, K x - f0 would
/// drown forces that move a body by a billionth of its length.
static void displacement_force(LitheCtx *ctx, LthSimulation *s) {
  const LthBlockMatrix *A = s->A;
  const double *u = lth_simulation_displacement(s), *X = s->x_rest;
  double *push = s->rhs;
  memset(push, 0, sizeof *push * (size_t)s->n);
  lth_step_volume_push(s, push);
#pragma omp parallel for schedule(static)                                                          \
    num_threads(lth_threads(ctx)) if (lth_block_matrix_is_large(A))
  for (LitheIndex row = 0; row < A->n_rows; row++) {
    LitheCount first = A->row_off[row], m = A->row_off[row + 1] - first;
    for (LitheCount i = 0; i < m; i++) {
      double sum = 0, rest = 0, size = fabs(s->f0[first + i]);
      for (LitheCount e = A->block_off[row]; e < A->block_off[row + 1]; e++) {
        LitheCount at = A->row_off[A->block_col[e]], n = A->row_off[A->block_col[e] + 1] - at;
        const double *B = A->values + A->value_off[e] + i * n;
        for (LitheCount j = 0; j < n; j++) {
          sum += B[j] * u[at + j];
          rest += B[j] * X[at + j];
          size += fabs(B[j] * X[at + j]);
        }
      }
      double g = s->f0[first + i] + push[first + i] - rest;
      if (!(fabs(g) > ROUNDING * size)) g = 0;
      s->force[first + i] = s->f_ext[first + i] + g - sum - push[first + i];
    }
  }
}

static bool is_at_rest(LitheCtx *ctx, LthSimulation *s) {
  return !(lth_step_norm(ctx, s->n, lth_simulation_displacement(s)) > 0);
}

/// Assemble at the present state and measure how far it is from equilibrium.
static LitheStatus evaluate(LitheCtx *ctx, LthSimulation *s, Search *q) {
  LITHE_TRY(lth_step_assemble(ctx, s, q->t, s->x));
  // turned elements have a g of their own size, where nothing is to be gained
  if (!s->own && (!s->system->warped || is_at_rest(ctx, s))) displacement_force(ctx, s);
  LITHE_TRY(lth_step_drive(ctx, s, q->t, 1, s->x));
  memset(s->rhs, 0, sizeof *s->rhs * (size_t)s->n);
  LITHE_TRY(contact_force(ctx, s, q, s->rhs));
  double contact = lth_step_norm(ctx, s->n, s->rhs);
  double all = lth_step_norm(ctx, s->n, s->force);

  for (LitheCount i = 0; i < s->n; i++) s->rhs[i] += s->force[i];
  lth_system_zero_held(s->system, s->rhs);
  q->residual = lth_step_norm(ctx, s->n, s->rhs);
  double held = s->system->has_held ? sqrt(fmax(0, all * all - q->residual * q->residual)) : 0;
  q->scale = lth_step_force_scale(ctx, s, q->t, held, contact);
  q->floor = ROUNDING * ((s->f0 ? lth_step_norm(ctx, s->n, s->f0) : 0) + contact);
  s->report.residual = q->scale > 0 ? q->residual / q->scale : q->residual;
  q->look = q->residual <= NEAR * q->scale ? LTH_LOOK_NEAR : LTH_LOOK_AGAIN;
  return LITHE_OK;
}

/// Residual that rounding leaves [N]: the norm of |K| |x| + |f0|, which f_int is the difference of, times a few
/// units. Places carry 16 digits, so that far from the origin, and where K is large (high degrees), no state
/// is nearer to balance. Overwrites s->base, or with `own` s->scratch.
double lth_step_rounding_of_forces(LitheCtx *ctx, LthSimulation *s) {
  const LthBlockMatrix *A = s->A;
  if (s->own) { // neighbours' entries sum up to the diagonal's
    lth_step_diagonal(s, s->scratch);
    for (LitheCount i = 0; i < s->n; i++) s->scratch[i] *= 2 * fabs(s->x[i]);
    return STALLED_ROUNDING * lth_step_norm(ctx, s->n, s->scratch);
  }
#pragma omp parallel for schedule(static)                                                          \
    num_threads(lth_threads(ctx)) if (lth_block_matrix_is_large(A))
  for (LitheIndex row = 0; row < A->n_rows; row++) {
    LitheCount first = A->row_off[row], m = A->row_off[row + 1] - first;
    for (LitheCount i = 0; i < m; i++) {
      double size = fabs(s->f0[first + i]);
      for (LitheCount e = A->block_off[row]; e < A->block_off[row + 1]; e++) {
        LitheCount at = A->row_off[A->block_col[e]], n = A->row_off[A->block_col[e] + 1] - at;
        const double *B = A->values + A->value_off[e] + i * n;
        for (LitheCount j = 0; j < n; j++) size += fabs(B[j] * s->x[at + j]);
      }
      s->base[first + i] = size;
    }
  }
  return STALLED_ROUNDING * lth_step_norm(ctx, s->n, s->base);
}

/// Whether forces balance to the tolerance, or as far as rounding lets them: a residual that has stopped
/// falling may be rounding, and is if it is of that size. The solve of a linear body leaves nothing else.
static bool is_balanced(LitheCtx *ctx, LthSimulation *s, Search *q) {
  const double wanted = s->options.newton_tolerance * q->scale;
  if (q->residual <= wanted || q->residual <= q->floor) return true;
  if (s->own && !s->system->warped && !s->has_contact && s->report.newton_iterations > 0 &&
      q->residual <= wanted + lth_step_rounding_of_forces(ctx, s))
    return true;
  q->stalled = q->residual < 0.5 * q->lowest ? 0 : q->stalled + 1;
  q->lowest = fmin(q->lowest, q->residual);
  return q->stalled >= STALLED_WINDOW && q->residual <= lth_step_rounding_of_forces(ctx, s);
}

/// How exact a correction has to be. What a solve leaves of the residual is measured by the forces that balance, as equilibrium is:
/// a linear body that is near it already, as after a cut or a step of the loads, takes fewer iterations than from rest.
static double correction_tolerance(const LthSimulation *s, const Search *q, double tolerance) {
  if (s->system->warped || !(q->residual > 0)) return tolerance;
  double wanted = 0.5 * fmin(s->options.tolerance, s->options.newton_tolerance) * q->scale;
  return fmin(fmax(tolerance, wanted / q->residual), INNER_TOLERANCE);
}

/// x += the solution of (c M + K) dx = force.
static LitheStatus correct(LitheCtx *ctx, LthSimulation *s, const Search *q, bool plain,
                           double tolerance) {
  if (s->base != s->force) memcpy(s->base, s->force, sizeof *s->base * (size_t)s->n);
  lth_step_combine(ctx, s, q->damping, 1, 0);
  lth_step_constrain(ctx, s);
  // the matrix of a linear body stays: so does its factor
  bool same = !s->system->warped && q->damping == 0 && s->report.newton_iterations > 0;
  if (!same) LITHE_TRY(lth_step_factor(ctx, s));
  memset(s->solution, 0, sizeof *s->solution * (size_t)s->n);
  LITHE_TRY(lth_step_solve(ctx, s, tolerance));
  // linear bodies need no acceleration
  if (plain && s->anderson && s->system->warped)
    lth_anderson_step(s->anderson, lth_threads(ctx), s->solution, s->x);
  else
    for (LitheCount i = 0; i < s->n; i++) s->x[i] += s->solution[i];
  return LITHE_OK;
}

/// Bodies that do not touch yet may be closer to balance than those that do: what comes with contact goes first.
static void keep_best(LthSimulation *s, Search *q) {
  bool comes = s->contact_on && !q->best_touches;
  if (!(q->residual < q->best) && !comes) return;
  q->best = q->residual;
  q->best_touches = s->contact_on;
  if (!s->best) return;
  memcpy(s->best, s->x, sizeof *s->x * (size_t)s->n);
}

/// Next c of a damped search: less where the residual falls, more where it grows (switched evolution
/// relaxation, Mulder and van Leer 1985).
static void adapt_damping(Search *q, double before, double unit) {
  double ratio = fmin(fmax(q->residual / before, 0.1), DAMPING_GROWTH);
  q->damping *= ratio < 1 ? ratio * ratio : 2 * ratio;
  q->damping = fmin(fmax(q->damping, DAMPING_LOWEST * unit), unit);
}

/// From a step that went too far back to the best state, and more damped on from there. Contact may act otherwise there
/// by now: what is best starts anew.
static LitheStatus go_back(LitheCtx *ctx, LthSimulation *s, Search *q, double unit) {
  memcpy(s->x, s->best, sizeof *s->x * (size_t)s->n);
  LITHE_TRY(evaluate(ctx, s, q));
  q->best = q->residual;
  q->damping = fmin(fmax(q->damping, REJECTED_FROM * unit) * REJECTED_GROWTH, unit);
  return LITHE_OK;
}

/// A linear body that something does not hold goes so far that the rounding of K u is of the size of the loads: then no
/// residual tells whether forces balance.
static LitheStatus check_reach(LitheCtx *ctx, LthSimulation *s) {
  const double loads = lth_step_norm(ctx, s->n, s->f_ext);
  if (s->system->warped || s->has_contact || !(loads > 0)) return LITHE_OK;
  for (LitheCount i = 0; i < s->n; i++)
    if (s->driven[i] != 0) return LITHE_OK;
  const double *u = lth_simulation_displacement(s);
  double far = 0;
  lth_step_diagonal(s, s->scratch);
  for (LitheCount i = 0; i < s->n; i++) {
    s->scratch[i] *= 2 * fabs(u[i]);
    far = fmax(far, fabs(u[i]));
  }
  const double rounding = 0x1p-53 * lth_step_norm(ctx, s->n, s->scratch);
  if (rounding <= LOST * loads) return LITHE_OK;
  LITHE_FAIL(
      ctx, LITHE_NOT_CONVERGED,
      "equilibrium: the loads move a part of a body by %.3g m, so far that rounding alone makes "
      "forces of %.2g times the loads: nothing holds that part, or next to nothing; constrain "
      "it, remove it, or take a stiffer material",
      far, rounding / loads);
}

/// One pass of the search. Ends balanced, out of iterations, or, where plain, as soon as something touches,
/// the residual no longer halves within a window, or the linear solver finds no way on.
static LitheStatus search(LitheCtx *ctx, LthSimulation *s, Search *q, bool plain, bool *balanced) {
  double window_start = INFINITY, inner = INNER_TOLERANCE, unit = 0;
  if (s->solver == LTH_LINEAR_CHOLESKY || !s->system->warped) inner = s->options.tolerance;
  bool was_back = false;
  q->damping = 0;
  q->lowest = INFINITY;
  q->stalled = 0;
  *balanced = false;
  if (s->anderson) lth_anderson_reset(s->anderson);
  for (LitheIndex it = 0; it <= s->options.newton_iterations; it++) {
    double before = q->residual;
    LITHE_TRY(evaluate(ctx, s, q));
    if (!isfinite(q->residual) || (plain && s->contact_on)) return LITHE_OK;
    if (it > 0 && !(q->residual < before)) LITHE_TRY(check_reach(ctx, s));
    bool is_driven = it > 0 || !s->system->has_held;
    bool back = !plain && !was_back && q->best_touches && q->residual > REJECTED * q->best;
    if (back) LITHE_TRY(go_back(ctx, s, q, unit));
    was_back = back;
    if (is_driven) keep_best(s, q);
    *balanced = is_driven && is_balanced(ctx, s, q);
    if (*balanced || it == s->options.newton_iterations) return LITHE_OK;
    if (plain && it % PLAIN_WINDOW == PLAIN_WINDOW - 1) {
      if (!(q->best < 0.5 * window_start)) return LITHE_OK;
      window_start = q->best;
    }
    if (!plain && it == 0) q->damping = DAMPING_START * (unit = lth_step_stiffness_per_mass(s));
    if (!plain && it > 0 && !back) adapt_damping(q, before, unit);
    if (lth_cancelled(ctx)) LITHE_FAIL(ctx, LITHE_INTERRUPTED, "interrupted");
    LitheStatus status = correct(ctx, s, q, plain, correction_tolerance(s, q, inner));
    bool has_other_way = s->system->warped || s->has_contact;
    if (status == LITHE_NOT_CONVERGED && plain && has_other_way) return LITHE_OK;
    LITHE_TRY(status);
    s->report.newton_iterations++;
  }
  return LITHE_OK;
}

/// What equilibria need beside a step's vectors; the only one of a linear body starts at rest and without loads.
static LitheStatus allocate(LitheCtx *ctx, LthSimulation *s) {
  const bool only = s->options.use == LTH_USE_ONE_EQUILIBRIUM && s->own && !s->has_contact;
  if (s->f_before || only) return LITHE_OK;
  LTH_NEW(ctx, s->start, s->n);
  // where one solve is all, nothing goes back to a state before
  if (s->system->warped || s->has_contact) LTH_NEW(ctx, s->best, s->n);
  LTH_NEW(ctx, s->f_before, s->n);
  if (!s->own) LITHE_TRY(lth_anderson_create(ctx, s->n, &s->anderson)); // one solve is exact
  return LITHE_OK;
}

/// Work as if the loads had grown slowly from those of the last equilibrium.
static void add_work(LthSimulation *s, double t0) {
  const double *from = s->start ? s->start : s->scratch, *before = s->f_before;
  double work = 0;
  if (!s->start) lth_system_rest(s->system, s->scratch);
  for (LitheCount i = 0; i < s->n; i++)
    work += 0.5 * ((before ? before[i] : 0) + s->f_ext[i]) * (s->x[i] - from[i]);
  s->report.work += work + lth_work_of_weak(s, t0, from) + lth_work_of_held(s, from, 0.5);
}

/// The accelerated fixed point from where the body is; where that fails damped from there, and then the
/// fixed point again from the best state seen.
static LitheStatus find_balance(LitheCtx *ctx, LthSimulation *s, Search *q, bool *balanced) {
  const size_t bytes = sizeof *s->x * (size_t)s->n;
  *balanced = false;
  LITHE_TRY(search(ctx, s, q, true, balanced));
  if (*balanced || (!s->system->warped && !s->has_contact)) return LITHE_OK;
  memcpy(s->x, s->start, bytes);
  LITHE_TRY(search(ctx, s, q, false, balanced));
  if (*balanced) return LITHE_OK;
  memcpy(s->x, s->best, bytes);
  if (!s->contact_on) LITHE_TRY(search(ctx, s, q, true, balanced));
  if (*balanced) return LITHE_OK;
  memcpy(s->x, s->best, bytes);
  return evaluate(ctx, s, q);
}

LitheStatus lth_simulation_equilibrium(LitheCtx *ctx, LthSimulation *s, double t) {
  bool balanced = false, before = s->report.converged;
  Search q = {.t = t, .best = INFINITY, .look = LTH_LOOK_FIRST};
  const size_t bytes = sizeof *s->x * (size_t)s->n;
  LITHE_TRY(allocate(ctx, s));
  if (s->start) memcpy(s->start, s->x, bytes);
  if (s->best) memcpy(s->best, s->x, bytes);
  if (s->f_before) memcpy(s->f_before, s->f_ext, bytes);
  for (LitheCount i = 0; s->v && i < s->n; i++)
    if (s->v[i] != 0) s->v[i] = 0; // pages that nobody has written stay so, and take no memory
  s->report.newton_iterations = 0;
  s->contact_stands = false;
  s->rigid.H = 0;
  LITHE_TRY(lth_step_choose(ctx, s, true));
  if (lth_newton_applies(s))
    LITHE_TRY(lth_newton_equilibrium(ctx, s, t, &balanced));
  else
    LITHE_TRY(find_balance(ctx, s, &q, &balanced));
  LITHE_TRY(check_reach(ctx, s));
  s->report.converged = before && balanced;
  if (!s->own)
    lth_step_constrain(ctx, s); // the matrix that owners look at is the one that is solved with
  double t0 = s->t;
  s->t = t;
  add_work(s, t0);
  if (s->has_contact) lth_step_contact_revise(s, s->v); // forces at rest: v is zero
  lth_step_contact_report(s);
  if (s->options.use == LTH_USE_ONE_EQUILIBRIUM && s->own && s->own->release)
    s->own->release(ctx, s->system->bodies[0].disc);
  return LITHE_OK;
}
