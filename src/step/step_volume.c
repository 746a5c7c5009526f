/// Bodies that keep their volume, with a matrix: pressures as further unknowns of the linear system.
///
/// With H how far positions move with w, c0 the volumetric strains for w = 0 and C, W of LthDiscVolume,
///
///   A w + H C^T W q = b,   c0 + H C w = 0,
///
/// where A contains ck C^T W lambda C (an augmented Lagrangian). Conjugate gradients on S = H^2 W C A^-1 C^T W with
/// S <= H^2 / ck W / lambda as preconditioner, most of whose eigenvalues are near 1; every product with S is a solve.
/// Fortin and Glowinski, Augmented Lagrangian Methods, 1983; docs/theory/staggered-mixed.md, section 4.
#include "step/simulation_priv.h"

#include <math.h>
#include <string.h>

#define ROUNDS 4        // of both equations
#define ITERATIONS 60   // of conjugate gradients in a round
#define INNER 0.05      // of what is asked for, that inner solves may miss
#define INNER_LEAST 0.1 // residual of an inner solve that is worth the product

struct LthStepVolume {
  LitheCount n;           // cells of all bodies
  LitheCount *first;      // of a body                         (n_bodies + 1)
  double *size, *lambda;  // volume [m^3], lambda in A [Pa]    (n)
  double *start, *strain; // for w = 0; as it is               (n)
  double *q, *r, *d, *Sd; // [Pa]                              (n)
  double *w, *b;          // solution and right-hand side      (unknowns)
  double H;
};

static const LthDiscVolume *volume_of(const LthSimulation *s, LitheIndex b) {
  return s->system->bodies[b].disc->table->volume;
}

static LitheStatus allocate(LitheCtx *ctx, LthSimulation *s, LthStepVolume *v) {
  const LthSystem *system = s->system;
  LTH_NEW(ctx, v->first, (LitheCount)system->n_bodies + 1);
  for (LitheIndex b = 0; b < system->n_bodies; b++) {
    const LthDiscVolume *of = volume_of(s, b);
    v->first[b + 1] = v->first[b] + (of ? of->count(system->bodies[b].disc) : 0);
  }
  v->n = v->first[system->n_bodies];
  double **cells[] = {&v->size, &v->lambda, &v->start, &v->strain, &v->q, &v->r, &v->d, &v->Sd};
  for (size_t i = 0; i < sizeof cells / sizeof cells[0]; i++) LTH_NEW(ctx, *cells[i], v->n);
  LTH_NEW(ctx, v->w, s->n);
  LTH_NEW(ctx, v->b, s->n);
  for (LitheIndex b = 0; b < system->n_bodies; b++)
    if (volume_of(s, b))
      volume_of(s, b)->scales(system->bodies[b].disc, v->size + v->first[b],
                              v->lambda + v->first[b]);
  return LITHE_OK;
}

LitheStatus lth_step_volume_create(LitheCtx *ctx, LthSimulation *s) {
  bool any = false;
  for (LitheIndex b = 0; b < s->system->n_bodies; b++) any |= volume_of(s, b) != NULL;
  if (!any) return LITHE_OK;
  LTH_NEW(ctx, s->volume, 1);
  return allocate(ctx, s, s->volume);
}

void lth_step_volume_free(LitheCtx *ctx, LthStepVolume *v) {
  if (!v) return;
  void *blocks[] = {v->first, v->size, v->lambda, v->start, v->strain, v->q,
                    v->r,     v->d,    v->Sd,     v->w,     v->b,      v};
  for (size_t i = 0; i < sizeof blocks / sizeof blocks[0]; i++) lth_free(ctx, blocks[i]);
}

void lth_step_volume_begin(LthSimulation *s) {
  if (s->volume) memset(s->volume->q, 0, sizeof *s->volume->q * (size_t)s->volume->n);
}

/// c = C u of all bodies.
static void find_strain(const LthSimulation *s, int threads, const double *u, double *c) {
  for (LitheIndex b = 0; b < s->system->n_bodies; b++)
    if (volume_of(s, b))
      volume_of(s, b)->strain(s->system->bodies[b].disc, threads, u + s->system->dof_first[b],
                              c + s->volume->first[b]);
}

/// f += C^T W q of all bodies.
static void push(const LthSimulation *s, const double *q, double *f) {
  for (LitheIndex b = 0; b < s->system->n_bodies; b++)
    if (volume_of(s, b))
      volume_of(s, b)->push(s->system->bodies[b].disc, q ? q + s->volume->first[b] : NULL,
                            f + s->system->dof_first[b]);
}

void lth_step_volume_push(const LthSimulation *s, double *f) { push(s, NULL, f); }

void lth_step_volume_push_change(const LthSimulation *s, double *f) {
  for (LitheIndex b = 0; b < s->system->n_bodies; b++)
    if (volume_of(s, b))
      volume_of(s, b)->push_change(s->system->bodies[b].disc, f + s->system->dof_first[b]);
}

/// y = ck / H C^T W lambda c: strains as forces, with which A resists them. Its norm over free unknowns.
static double norm_of_strain(LitheCtx *ctx, const LthSimulation *s, const double *c, double *y) {
  const LthStepVolume *v = s->volume;
  for (LitheIndex b = 0; b < s->system->n_bodies; b++)
    for (LitheCount i = v->first[b]; i < v->first[b + 1]; i++)
      v->Sd[i] = s->ck[b] / v->H * v->lambda[i] * c[i];
  memset(y, 0, sizeof *y * (size_t)s->n);
  push(s, v->Sd, y);
  lth_system_zero_held(s->system, y);
  return lth_step_norm(ctx, s->n, y);
}

/// s->rhs = b - A w - H C^T W q (A with contact) and its norm.
static double find_defect(LitheCtx *ctx, LthSimulation *s) {
  const LthStepVolume *v = s->volume;
  for (LitheCount i = 0; i < v->n; i++) v->Sd[i] = -v->H * v->q[i];
  lth_step_apply_system(s, lth_threads(ctx), v->w, s->scratch);
  memset(s->rhs, 0, sizeof *s->rhs * (size_t)s->n);
  push(s, v->Sd, s->rhs);
  for (LitheCount i = 0; i < s->n; i++) s->rhs[i] += v->b[i] - s->scratch[i];
  lth_system_zero_held(s->system, s->rhs);
  return lth_step_norm(ctx, s->n, s->rhs);
}

/// Where volumes are for w = 0: strains of the places that positions start from.
static LitheStatus find_start(LitheCtx *ctx, LthSimulation *s) {
  const LthSystem *system = s->system;
  const bool in_stage = s->rigid.H > 0;
  const double *from = in_stage ? s->stage.x_hat : s->x;
  s->volume->H = in_stage ? s->rigid.H : 1;
  for (LitheCount i = 0; i < s->n; i++)
    s->scratch[i] = from[i] - s->x_rest[i] + s->volume->H * s->driven[i];
  find_strain(s, lth_threads(ctx), s->scratch, s->volume->start);
  for (LitheIndex b = 0; b < system->n_bodies; b++)
    if (volume_of(s, b))
      LITHE_TRY(volume_of(s, b)->admit(ctx, system->bodies[b].disc,
                                       s->scratch + system->dof_first[b],
                                       s->volume->start + s->volume->first[b]));
  return LITHE_OK;
}

/// v->strain = those of w.
static void update_strain(LitheCtx *ctx, LthSimulation *s) {
  LthStepVolume *v = s->volume;
  find_strain(s, lth_threads(ctx), v->w, v->strain);
  for (LitheCount i = 0; i < v->n; i++) v->strain[i] = v->start[i] + v->H * v->strain[i];
}

/// Solve A y = s->rhs from 0 into s->solution, to a residual of `goal` [N].
static LitheStatus solve_inner(LitheCtx *ctx, LthSimulation *s, double goal,
                               LthSolveReport *total) {
  LthSolveReport report;
  const double size = lth_step_norm(ctx, s->n, s->rhs);
  memset(s->solution, 0, sizeof *s->solution * (size_t)s->n);
  if (!(size > goal)) return LITHE_OK;
  LITHE_TRY(lth_step_solve_linear(ctx, s, fmin(goal / size, INNER_LEAST), &report));
  total->iterations += report.iterations;
  return LITHE_OK;
}

/// Preconditioned residual of the pressures' equation: strains times ck / H^2 lambda.
static void precondition(const LthSimulation *s, const double *r, double *z) {
  const LthStepVolume *v = s->volume;
  for (LitheIndex b = 0; b < s->system->n_bodies; b++)
    for (LitheCount i = v->first[b]; i < v->first[b + 1]; i++)
      z[i] = s->ck[b] / (v->H * v->H) * v->lambda[i] / v->size[i] * r[i];
}

/// Conjugate gradients on S dq = W c: q and w move until the strains are worth less than `goal` [N].
static LitheStatus keep_volumes(LitheCtx *ctx, LthSimulation *s, double goal,
                                LthSolveReport *total) {
  LthStepVolume *v = s->volume;
  const int threads = lth_threads(ctx);
  double before = 0;
  for (int it = 0; it < ITERATIONS; it++) {
    for (LitheCount i = 0; i < v->n; i++) v->r[i] = v->size[i] * v->strain[i];
    if (!(norm_of_strain(ctx, s, v->strain, s->rhs) > goal)) return LITHE_OK;
    precondition(s, v->r, v->Sd);
    const double now = lth_dot(threads, v->n, v->r, v->Sd), share = it > 0 ? now / before : 0;
    for (LitheCount i = 0; i < v->n; i++) v->d[i] = v->Sd[i] + share * v->d[i];
    before = now;
    for (LitheCount i = 0; i < v->n; i++) v->Sd[i] = v->H * v->d[i];
    memset(s->rhs, 0, sizeof *s->rhs * (size_t)s->n);
    push(s, v->Sd, s->rhs);
    lth_system_zero_held(s->system, s->rhs);
    LITHE_TRY(solve_inner(ctx, s, INNER * goal, total));
    find_strain(s, threads, s->solution, v->Sd);
    for (LitheCount i = 0; i < v->n; i++) v->Sd[i] *= v->H * v->size[i];
    const double along = lth_dot(threads, v->n, v->d, v->Sd);
    if (!(along > 0)) return LITHE_OK;
    const double alpha = now / along;
    for (LitheCount i = 0; i < v->n; i++) v->q[i] += alpha * v->d[i];
    for (LitheCount i = 0; i < s->n; i++) v->w[i] -= alpha * s->solution[i];
    update_strain(ctx, s);
  }
  return LITHE_OK;
}

/// Size of the right-hand side without what A's own resistance to strains at the start gives it.
static double size_of_load(LitheCtx *ctx, LthSimulation *s) {
  const LthStepVolume *v = s->volume;
  const double all = lth_step_norm(ctx, s->n, v->b);
  norm_of_strain(ctx, s, v->start, s->scratch);
  for (LitheCount i = 0; i < s->n; i++) s->scratch[i] += v->b[i];
  const double rest = lth_step_norm(ctx, s->n, s->scratch);
  return fmin(all, fmax(rest, 0.01 * all));
}

static void keep_pressures(LthSimulation *s) {
  for (LitheIndex b = 0; b < s->system->n_bodies; b++)
    if (volume_of(s, b))
      volume_of(s, b)->keep(s->system->bodies[b].disc, s->volume->q + s->volume->first[b]);
}

LitheStatus lth_step_volume_solve(LitheCtx *ctx, LthSimulation *s, double tolerance,
                                  LthSolveReport *report) {
  LthStepVolume *v = s->volume;
  const size_t bytes = sizeof *v->w * (size_t)s->n;
  *report = (LthSolveReport){0};
  memcpy(v->b, s->rhs, bytes);
  memcpy(v->w, s->solution, bytes);
  LITHE_TRY(find_start(ctx, s));
  const double size = size_of_load(ctx, s), goal = tolerance * size;
  for (int round = 0;; round++) {
    const double defect = find_defect(ctx, s);
    update_strain(ctx, s);
    const double strain = norm_of_strain(ctx, s, v->strain, s->scratch);
    report->residual = size > 0 ? hypot(defect, strain) / size : 0;
    report->converged = hypot(defect, strain) <= goal;
    if (report->converged || round == ROUNDS || !isfinite(defect)) break;
    LITHE_TRY(solve_inner(ctx, s, 0.5 * goal, report));
    for (LitheCount i = 0; i < s->n; i++) v->w[i] += s->solution[i];
    update_strain(ctx, s);
    LITHE_TRY(keep_volumes(ctx, s, 0.5 * goal, report));
  }
  keep_pressures(s);
  memcpy(s->solution, v->w, bytes);
  return LITHE_OK;
}
