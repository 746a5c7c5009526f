/// Forces of new functions, held back at first and let go by and by (docs/theory/adaptivity.md, section 3).
#include "step/simulation_priv.h"

#include <math.h>
#include <string.h>

LitheStatus lth_simulation_keep_rate(LitheCtx *ctx, LthSimulation *s, const double *rate) {
  if (!s->rate) LTH_NEW(ctx, s->rate, s->n);
  memcpy(s->rate, rate, sizeof *s->rate * (size_t)s->n);
  return LITHE_OK;
}

static LitheStatus make_room(LitheCtx *ctx, LthSystem *system) {
  return system->fade ? LITHE_OK
                      : lth_new_(ctx, (void **)&system->fade, system->n, sizeof *system->fade);
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
  LITHE_TRY(make_room(ctx, system));
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

/// External less internal force less inertia and damping, with the acceleration that was kept.
static LitheStatus find_released(LitheCtx *ctx, LthSimulation *s) {
  const LthSystem *system = s->system;
  LITHE_TRY(lth_step_assemble(ctx, s, s->t, s->x));
  for (LitheIndex b = 0; b < system->n_bodies; b++)
    for (LitheCount i = system->dof_first[b]; i < system->dof_first[b + 1]; i++)
      s->rhs[i] = s->rate[i] + system->bodies[b].damping_mass * s->v[i];
  lth_system_apply_mass(system, s->rhs, s->scratch);
  for (LitheCount i = 0; i < s->n; i++) s->force[i] -= s->scratch[i];
  if (!lth_stage_has_stiffness_damping(system)) return LITHE_OK;
  lth_step_apply(s, lth_threads(ctx), s->v, s->scratch);
  for (LitheIndex b = 0; b < system->n_bodies; b++)
    for (LitheCount i = system->dof_first[b]; i < system->dof_first[b + 1]; i++)
      s->force[i] -= system->bodies[b].damping_stiffness * s->scratch[i];
  return LITHE_OK;
}

LitheStatus lth_simulation_hold_back(LitheCtx *ctx, LthSimulation *s, const uint8_t *rows,
                                     double decay, double *released) {
  LthSystem *system = s->system;
  double sum = 0, mass = 0;
  LITHE_ASSERT(s->rate && s->A);
  LITHE_TRY(find_released(ctx, s));
  if (decay > 0) LITHE_TRY(make_room(ctx, system));
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
  return LITHE_OK;
}

void lth_fade_archive(LthSimulation *s, LthArchive *a) {
  LthSystem *system = s->system;
  bool any = system->fade != NULL;
  lth_archive_mark(a, "fade");
  LTH_ARCHIVE(a, any);
  if (!any || a->status != LITHE_OK) return;
  if (a->is_reading) a->status = make_room(a->ctx, system);
  if (a->status != LITHE_OK) return;
  LTH_ARCHIVE(a, system->fade_start);
  LTH_ARCHIVE(a, system->fade_decay);
  LTH_ARCHIVE_ARRAY(a, system->fade, s->n);
}
