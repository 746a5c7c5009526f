/// Forces of new functions, held back at first and let go by and by (docs/theory/adaptivity.md, section 3).
#include "step/simulation_priv.h"

#include <math.h>
#include <string.h>

LitheStatus lth_simulation_keep_rate(LitheCtx *ctx, LthSimulation *s, const double *rate) {
  if (!s->rate) LTH_NEW(ctx, s->rate, s->n);
  memcpy(s->rate, rate, sizeof *s->rate * (size_t)s->n);
  return LITHE_OK;
}

static LitheStatus make_room(LitheCtx *ctx, LthSimulation *s) {
  if (!s->system->fade) LTH_NEW(ctx, s->system->fade, s->n);
  if (!s->faded) LTH_NEW(ctx, s->faded, s->n);
  if (!s->faded_start) LTH_NEW(ctx, s->faded_start, s->n);
  return LITHE_OK;
}

/// What is still held back by the other simulation, as a field: force over mass.
LitheStatus lth_fade_inherit(LitheCtx *ctx, LthSimulation *s, const LthSimulation *from,
                             LthFieldMove *move, const void *self) {
  LthSystem *system = s->system;
  double *field = NULL, left = lth_system_fade_left(from->system, s->t);
  LitheStatus status = LITHE_OK;
  if (from->rate) {
    LTH_NEW(ctx, s->rate, s->n);
    LITHE_TRY(move(ctx, self, from->rate, s->rate));
  }
  if (!(left > 0)) return LITHE_OK;
  LITHE_TRY(make_room(ctx, s));
  LTH_NEW_OR(done, ctx, field, from->n);
  for (LitheCount i = 0; i < from->n; i++)
    field[i] = from->mass[i] > 0 ? left * from->system->fade[i] / from->mass[i] : 0;
  LITHE_TRY_OR(done, move(ctx, self, field, system->fade));
  for (LitheCount i = 0; i < s->n; i++) system->fade[i] *= s->mass[i];
  system->fade_start = s->t;
  system->fade_decay = from->system->fade_decay;
done:
  lth_free(ctx, field);
  return status;
}

/// External less internal force less damping and the inertia of an acceleration (NULL: none), into s->force. Contact's
/// forces and what is held back already are left out: both go on as they are.
static LitheStatus find_unbalanced(LitheCtx *ctx, LthSimulation *s, const double *rate) {
  LthSystem *system = s->system;
  double *fade = system->fade;
  system->fade = NULL;
  LitheStatus status = lth_step_assemble(ctx, s, s->t, s->x);
  system->fade = fade;
  LITHE_TRY(status);
  for (LitheIndex b = 0; b < system->n_bodies; b++)
    for (LitheCount i = system->dof_first[b]; i < system->dof_first[b + 1]; i++)
      s->rhs[i] = (rate ? rate[i] : 0) + system->bodies[b].damping_mass * s->v[i];
  lth_system_apply_mass(system, s->rhs, s->scratch);
  for (LitheCount i = 0; i < s->n; i++) s->force[i] -= s->scratch[i];
  if (!lth_stage_has_stiffness_damping(system)) return LITHE_OK;
  lth_step_apply(s, lth_threads(ctx), s->v, s->scratch);
  for (LitheIndex b = 0; b < system->n_bodies; b++)
    for (LitheCount i = system->dof_first[b]; i < system->dof_first[b + 1]; i++)
      s->force[i] -= system->bodies[b].damping_stiffness * s->scratch[i];
  return LITHE_OK;
}

/// Is anything held back of a body that nothing else holds? (Weak constraints hold smaller elements harder: that has a moment.)
static bool turns_freely(const LthSimulation *s, LitheIndex b) {
  const LthSystem *system = s->system;
  if (!s->rigid.is_free[b]) return false;
  for (LitheCount i = system->dof_first[b]; i < system->dof_first[b + 1]; i++)
    if (system->fade[i] != 0) return true;
  return false;
}

/// faded -= M w, w the turn about the body's centre at s->x that it would speed up. Elements that get rotations of their
/// own, and the body's turning since, give it a moment. Overwrites force and f0.
static void remove_moment(LthSimulation *s, LitheIndex b) {
  LthSystem *system = s->system;
  const LitheCount first = system->dof_first[b], n = system->dof_first[b + 1] - first;
  double moment[3], turn[3];
  LthInertia inertia;
  lth_rigid_inertia(s, b, s->x, s->force, s->f0, &inertia);
  for (int k = 0; k < 3; k++) {
    lth_rigid_motion(s, b, &inertia, k, s->x, s->force);
    moment[k] = lth_dot(1, n, s->force + first, s->faded + first);
  }
  if (!lth_rigid_turn(&inertia, moment, turn)) return;
  for (int k = 0; k < 3; k++) {
    lth_rigid_motion(s, b, &inertia, k, s->x, s->force);
    lth_system_apply_body_mass(system, b, s->force, s->f0);
    for (LitheCount i = first; i < first + n; i++) s->faded[i] -= turn[k] * s->f0[i];
  }
}

LitheStatus lth_fade_external_force(LitheCtx *ctx, LthSimulation *s, double t) {
  const LthSystem *system = s->system;
  const double left = lth_system_fade_left(system, t);
  LITHE_TRY(lth_system_external_force(ctx, s->system, t, s->x, s->f_ext));
  if (!system->fade) return LITHE_OK;
  if (!s->rigid.group) { // assembles, and so comes here once more
    LITHE_TRY(lth_rigid_find(ctx, s));
    return lth_fade_external_force(ctx, s, t);
  }
  for (LitheCount i = 0; i < s->n; i++) s->faded[i] = left * system->fade[i];
  for (LitheIndex b = 0; left > 0 && b < system->n_bodies; b++)
    if (turns_freely(s, b)) remove_moment(s, b);
  for (LitheCount i = 0; i < s->n; i++) s->f_ext[i] += s->faded[i];
  return LITHE_OK;
}

void lth_fade_begin(LthSimulation *s) {
  if (s->faded) memcpy(s->faded_start, s->faded, sizeof *s->faded * (size_t)s->n);
}

LitheStatus lth_simulation_find_rate(LitheCtx *ctx, LthSimulation *s, double *rate) {
  LITHE_TRY(find_unbalanced(ctx, s, NULL));
  for (LitheCount i = 0; i < s->n; i++) rate[i] = s->mass[i] > 0 ? s->force[i] / s->mass[i] : 0;
  return LITHE_OK;
}

LitheStatus lth_simulation_hold_back(LitheCtx *ctx, LthSimulation *s, const uint8_t *rows,
                                     double decay, double *released) {
  LthSystem *system = s->system;
  double sum = 0, mass = 0;
  LITHE_ASSERT(s->rate && s->A);
  LITHE_TRY(find_unbalanced(ctx, s, s->rate));
  if (decay > 0) LITHE_TRY(make_room(ctx, s));
  for (LitheIndex row = 0; row < system->n_rows; row++)
    for (LitheCount i = s->A->row_off[row]; i < s->A->row_off[row + 1]; i++) {
      mass += s->mass[i] / 3 * system->one[i / 3];
      if (!rows[row] || !(s->mass[i] > 0) || (system->held && system->held[i])) continue;
      sum += s->force[i] * s->force[i] / s->mass[i];
      if (decay > 0) system->fade[i] -= s->force[i];
    }
  system->fade_start = s->t;
  system->fade_decay = decay;
  *released = mass > 0 ? sqrt(sum / mass) : 0;
  // the next step's work and impulse begin with it
  return decay > 0 ? lth_fade_external_force(ctx, s, s->t) : LITHE_OK;
}

void lth_fade_archive(LthSimulation *s, LthArchive *a) {
  LthSystem *system = s->system;
  bool any = system->fade != NULL;
  lth_archive_mark(a, "fade");
  LTH_ARCHIVE(a, any);
  if (!any || a->status != LITHE_OK) return;
  if (a->is_reading) a->status = make_room(a->ctx, s);
  if (a->status != LITHE_OK) return;
  LTH_ARCHIVE(a, system->fade_start);
  LTH_ARCHIVE(a, system->fade_decay);
  LTH_ARCHIVE_ARRAY(a, system->fade, s->n);
  LTH_ARCHIVE_ARRAY(a, s->faded, s->n);
}
