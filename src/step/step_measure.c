/// Energies and momenta of the present state.
#include "base/tensor.h"
#include "step/simulation_priv.h"

#include <string.h>

// With y = M v: kinetic energy v . y / 2; the function 1 has coefficients `one` and the place x, so
// that momentum is the sum of one_i y_i and angular momentum that of x_i x y_i.
void lth_simulation_measure(LitheCtx *ctx, LthSimulation *s) {
  (void)ctx;
  const double *y = s->scratch;
  LthStepReport *r = &s->report;
  lth_system_update_rotations(s->system, s->x);
  r->strain_energy = lth_system_energy(s->system, s->t, s->x);
  r->kinetic_energy = 0;
  memset(r->momentum, 0, sizeof r->momentum);
  memset(r->angular_momentum, 0, sizeof r->angular_momentum);
  if (!s->v) return;
  lth_system_apply_mass(s->system, s->v, s->scratch);
  for (LitheCount i = 0; i < s->n / 3; i++) {
    r->kinetic_energy += 0.5 * lth_v3_dot(y + 3 * i, s->v + 3 * i);
    lth_v3_axpy(s->system->one[i], y + 3 * i, r->momentum);
  }
  for (LitheIndex b = 0; b < s->system->n_bodies; b++)
    lth_rigid_add_moment(s, b, 1, s->x, y, r->angular_momentum);
}
