/// External forces on a DG body: loads on the boundary and in the volume as vectors of coefficients.
#pragma once

#include "disc/dg/dg_space.h"
#include "disc/disc.h"

/// f (n_dofs) += the forces at time t; x is needed for followers only. [N]
LitheStatus lth_dg_add_load(LitheCtx *ctx, const LthDgSpace *space, const LthLoad *load, double t,
                            const double *x, double *f);

/// A point of a rule over loaded boundary: the cell, its outward normal, the weight [m^2], the traction of the load that
/// is visited, and that of all later ones of the list at this point [Pa].
typedef void (*LthDgTractionFn)(void *self, LitheIndex cell, const double *normal,
                                const double at[3], double weight, const double force[3],
                                const double later[3]);

/// Visit rules over all boundary that loads act on, load by load; the others of the list are passed over.
LitheStatus lth_dg_visit_tractions(LitheCtx *ctx, const LthDgSpace *space, LitheIndex n_loads,
                                   const LthLoad *loads, double t, const double *x,
                                   LthDgTractionFn visit, void *self);

/// f += density * gravity, density per cell [kg/m^3].
void lth_dg_add_gravity(const LthDgSpace *space, const double *density, const double gravity[3],
                        double *f);

/// Mass per function: density_K |K| (the basis is orthogonal).  (n_funcs) [kg]
void lth_dg_mass(const LthDgSpace *space, const double *density, double *mass);
