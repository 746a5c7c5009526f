/// All contacts of the bodies as one: each has its own set of points.
#include "step/simulation_priv.h"

#include <math.h>
#include <string.h>

LitheStatus lth_step_detect(LitheCtx *ctx, LthSimulation *s, LthContactLook look, double t,
                            double dt, double weight, double ahead, LitheIndex *n_active) {
  *n_active = 0;
  if (s->has_contact) lth_simulation_displacement(s);
  for (LitheIndex c = 0; c < s->system->n_contacts; c++) {
    LitheIndex n = 0;
    lth_contact_set_look(s->system->contacts[c], look);
    lth_contact_set_weight(s->system->contacts[c], weight, ahead);
    LITHE_TRY(lth_contact_detect(ctx, s->system->contacts[c], t, dt, s->u, s->v, &n));
    *n_active += n;
  }
  s->contact_on = *n_active > 0;
  return LITHE_OK;
}

void lth_step_contact_begin_again(LthSimulation *s) {
  for (LitheIndex c = 0; c < s->system->n_contacts; c++)
    lth_contact_begin_again(s->system->contacts[c]);
}

void lth_step_contact_apply(const LthSimulation *s, const double *x, double *y) {
  for (LitheIndex c = 0; c < s->system->n_contacts; c++)
    lth_contact_apply(s->system->contacts[c], x, y);
}

void lth_step_contact_rhs(const LthSimulation *s, double *rhs) {
  for (LitheIndex c = 0; c < s->system->n_contacts; c++)
    lth_contact_add_rhs(s->system->contacts[c], rhs);
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
  for (LitheIndex c = 0; c < s->system->n_contacts; c++)
    lth_contact_add_diagonal(s->system->contacts[c], extra);
  for (LitheIndex row = 0; A && s->system->has_held && row < A->n_rows; row++) {
    LitheCount m = A->row_off[row + 1] - A->row_off[row];
    if (s->system->row_held[row]) mask_block(s->system->held + A->row_off[row], m, extra + at);
    at += m * m;
  }
}

bool lth_step_contact_revise(LthSimulation *s, const double *v1) {
  bool changed = false;
  for (LitheIndex c = 0; c < s->system->n_contacts; c++)
    changed |= lth_contact_revise(s->system->contacts[c], v1);
  return changed;
}

bool lth_step_contact_drop_pulls(LthSimulation *s) {
  bool changed = false;
  for (LitheIndex c = 0; s->has_contact && c < s->system->n_contacts; c++)
    changed |= lth_contact_drop_pulls(s->system->contacts[c]);
  return changed;
}

void lth_step_contact_report(LthSimulation *s) {
  if (!s->has_contact) return;
  s->report.contacts = 0;
  s->report.penetration = 0;
  s->report.contact_energy = s->report.contact_spare = 0;
  for (LitheIndex c = 0; c < s->system->n_contacts; c++) {
    LitheIndex n;
    double penetration, force, stored, spare;
    lth_contact_report(s->system->contacts[c], &n, &penetration, &force);
    lth_contact_energy(s->system->contacts[c], &stored, &spare);
    s->report.contacts += n;
    s->report.contact_energy += stored;
    s->report.contact_spare += spare;
    s->report.penetration = fmax(s->report.penetration, penetration);
  }
}
