/// Contact of all bodies as one: each has its own set of points.
#include "step/simulation_priv.h"

#include <math.h>
#include <string.h>

LitheStatus lth_step_detect(LitheCtx *ctx, LthSimulation *s, double t, double dt,
                            LitheIndex *n_active) {
  *n_active = 0;
  lth_simulation_displacement(s);
  for (LitheIndex b = 0; b < s->system->n_bodies; b++) {
    const LthSystemBody *body = s->system->bodies + b;
    LitheCount first = s->system->dof_first[b];
    LitheIndex n = 0;
    if (!body->contact) continue;
    LITHE_TRY(lth_contact_detect(ctx, body->contact, t, dt, s->u + first, s->v + first, &n));
    *n_active += n;
  }
  s->contact_on = *n_active > 0;
  return LITHE_OK;
}

void lth_step_contact_apply(const LthSimulation *s, const double *x, double *y) {
  for (LitheIndex b = 0; b < s->system->n_bodies; b++)
    if (s->system->bodies[b].contact)
      lth_contact_apply(s->system->bodies[b].contact, x + s->system->dof_first[b],
                        y + s->system->dof_first[b]);
}

void lth_step_contact_rhs(const LthSimulation *s, double *rhs) {
  for (LitheIndex b = 0; b < s->system->n_bodies; b++)
    if (s->system->bodies[b].contact)
      lth_contact_add_rhs(s->system->bodies[b].contact, rhs + s->system->dof_first[b]);
}

/// Nothing reaches a held unknown.
static void mask_block(const uint8_t *held, LitheCount m, double *block) {
  for (LitheCount i = 0; i < m; i++)
    for (LitheCount j = 0; j < m; j++)
      if (held[i] || held[j]) block[i * m + j] = 0;
}

void lth_step_contact_diagonal(const LthSimulation *s, double *extra) {
  const LthBlockMatrix *A = s->A;
  LitheCount at = 0;
  memset(extra, 0, sizeof *extra * (size_t)s->n_extra);
  for (LitheIndex b = 0, row = 0; b < s->system->n_bodies; b++) {
    if (s->system->bodies[b].contact)
      lth_contact_add_diagonal(s->system->bodies[b].contact, extra + at);
    for (; row < s->system->row_first[b + 1]; row++) {
      LitheCount m = A->row_off[row + 1] - A->row_off[row];
      if (s->system->has_held && s->system->row_held[row])
        mask_block(s->system->held + A->row_off[row], m, extra + at);
      at += m * m;
    }
  }
}

bool lth_step_contact_revise(LthSimulation *s, const double *v1) {
  bool changed = false;
  for (LitheIndex b = 0; b < s->system->n_bodies; b++)
    if (s->system->bodies[b].contact)
      changed |= lth_contact_revise(s->system->bodies[b].contact, v1 + s->system->dof_first[b]);
  return changed;
}

void lth_step_contact_report(LthSimulation *s) {
  if (!s->has_contact) return;
  s->report.contacts = 0;
  s->report.penetration = 0;
  for (LitheIndex b = 0; b < s->system->n_bodies; b++) {
    LitheIndex n;
    double penetration, force;
    if (!s->system->bodies[b].contact) continue;
    lth_contact_report(s->system->bodies[b].contact, &n, &penetration, &force);
    s->report.contacts += n;
    s->report.penetration = fmax(s->report.penetration, penetration);
  }
}
