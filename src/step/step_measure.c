/// Energies and momenta of the present state.
#include "step/simulation_priv.h"

#include <string.h>

// The basis is orthogonal, phi_0 = 1: the integral of rho a b is the sum of mass_i a_i b_i, and that of
// rho v is the sum over the cells' first functions.
void lth_simulation_measure(LitheCtx *ctx, LthSimulation *s) {
  (void)ctx;
  const LthDgSpace *space = s->body.space;
  LthStepReport *r = &s->report;
  lth_dg_update_rotations(s->body.op, s->x);
  r->strain_energy = lth_dg_energy(s->body.op, s->t, s->x);
  r->kinetic_energy = 0;
  memset(r->momentum, 0, sizeof r->momentum);
  memset(r->angular_momentum, 0, sizeof r->angular_momentum);
  for (LitheIndex cell = 0; cell < space->n_cells; cell++)
    for (LitheIndex i = space->func_off[cell]; i < space->func_off[cell + 1]; i++) {
      const double m = s->mass[i], *x = s->x + 3 * (LitheCount)i, *v = s->v + 3 * (LitheCount)i;
      r->kinetic_energy += 0.5 * m * (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
      for (int a = 0; a < 3; a++) {
        int b = (a + 1) % 3, c = (a + 2) % 3;
        r->angular_momentum[a] += m * (x[b] * v[c] - x[c] * v[b]);
        if (i == space->func_off[cell]) r->momentum[a] += m * v[a];
      }
    }
}
