/// External forces on a DG body: loads on the boundary and in the volume as vectors of coefficients.
#pragma once

#include "disc/dg/dg_space.h"
#include "disc/disc.h"

/// f (n_dofs) += the forces at time t; x is needed for followers only. [N]
LitheStatus lth_dg_add_load(LitheCtx *ctx, const LthDgSpace *space, const LthLoad *load, double t,
                            const double *x, double *f);

/// f += density * gravity, density per cell [kg/m^3].
void lth_dg_add_gravity(const LthDgSpace *space, const double *density, const double gravity[3],
                        double *f);

/// Mass per function: density_K |K| (the basis is orthogonal).  (n_funcs) [kg]
void lth_dg_mass(const LthDgSpace *space, const double *density, double *mass);
