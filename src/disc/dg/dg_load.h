/// External forces on a DG body: loads on the boundary and in the volume as vectors of coefficients.
#pragma once

#include "disc/dg/dg_space.h"
#include "mesh/selection.h"

typedef enum LthLoadKind {
  LTH_LOAD_TRACTION,    ///< value [Pa], force per rest area
  LTH_LOAD_TOTAL_FORCE, ///< value [N], spread evenly over the selection
  LTH_LOAD_PRESSURE,    ///< value[0] [Pa] along the inward normal
  LTH_LOAD_STRESS,      ///< stress [Pa] row-major; traction = stress n
  LTH_LOAD_BODY_FORCE   ///< value [N/m^3]
} LthLoadKind;

typedef struct LthLoad {
  LthLoadKind kind;
  const LthPatches *patches; ///< borrowed for life; NULL for body forces
  LthValue value[3];
  LthValue stress[9];
  bool follower; ///< pressure that turns and stretches with the surface
} LthLoad;

/// f (n_dofs) += the forces at time t; x is needed for followers only. [N]
LitheStatus lth_dg_add_load(LitheCtx *ctx, const LthDgSpace *space, const LthLoad *load, double t,
                            const double *x, double *f);

/// f += density * gravity, density per cell [kg/m^3].
void lth_dg_add_gravity(const LthDgSpace *space, const double *density, const double gravity[3],
                        double *f);

/// Mass per function: density_K |K| (the basis is orthogonal).  (n_funcs) [kg]
void lth_dg_mass(const LthDgSpace *space, const double *density, double *mass);
