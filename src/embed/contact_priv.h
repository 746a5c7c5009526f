/// The inside of LthContact: points near colliders, and the samples that they hang on.
#pragma once

#include "embed/collider.h"
#include "embed/contact.h"

/// A point near a collider. Equations: docs/theory/contact.md.
typedef struct LthTouch {
  LitheIndex point, collider;
  bool active;
  double gap; ///< of the start place to the collider at the end of the step [m]
  double normal[3];
  double stiffness;   ///< k times the point's area [N/m]
  double velocity[3]; ///< of the collider's material there [m/s]
  double anchor[3];   ///< where friction's spring is fixed, in the collider's rest frame [m]
  double offset[3];   ///< tangential stretch of that spring if the point stayed where it is [m]
  double start[3];    ///< velocity of the point at the start [m/s]
  double trial[3];    ///< stretch by the last solve, or as predicted [m]
  double spring;      ///< secant stiffness of friction [N/m], at most `stiffness`
  double limit;       ///< mu times the normal force of the last solve [N]
  double gap_end;     ///< at the end of the step by the last solve [m]
  double force_n;     ///< normal force of the last solve [N]
  double D[9], r[3];  ///< equation (4)
} LthTouch;

struct LthContact {
  LitheCtx *ctx;
  LthContactDef def;
  LthCollider *colliders; ///< copies, meshes with a tree
  bool *owns_bvh;
  LitheCount *block_off; ///< start of each row's diagonal block       (n_rows + 1)
  bool is_auto;
  double stiffness;   ///< per area or per point
  double weight_norm; ///< largest sum of |weights| of a point
  double t, dt;
  int round, friction_round;
  double penetration, force, last_penetration;
  double growth; ///< of an automatic stiffness since the start
  LitheIndex n_active;

  double *position;                    ///< (n_points x 3)
  double *gap;                         ///< to the present collider                  (n_points)
  double *sample_value, *sample_force; ///< (n_samples x 4)

  LthTouch *touch, *before; ///< of this step and of the last one, by collider and point
  LitheCount touch_cap, before_cap;
  LitheIndex n_touch, n_before;

  // the system's part: active points and the samples they hang on
  LitheIndex *active; ///< places in touch, ascending               (n_active)
  LitheCount active_cap;
  LitheIndex *touched; ///< samples that active points hang on       (n_touched)
  LitheCount touched_cap;
  LitheIndex n_touched;
  LitheIndex *sample_slot; ///< place in touched, -1                     (n_samples)
  LitheCount *slot_off;    ///< active points of each touched sample     (n_touched + 1)
  LitheCount slot_off_cap;
  LitheIndex *slot_active; ///< places in active
  LitheCount slot_active_cap;
  double *slot_weight;
  LitheCount slot_weight_cap;
  double *force_of; ///< on each active point                     (n_active x 3)
  LitheCount force_of_cap;
};

/// Set D and r of a touching point from its state.
void lth_touch_linearize(const LthContact *contact, LthTouch *touch);

/// Set trial and spring of a touching point for velocity v, by its limit: equation (3).
void lth_touch_stretch(const LthContact *contact, LthTouch *touch, const double v[3]);

/// Make room for the index of as many active points as there are touching ones.
LitheStatus lth_contact_reserve(LitheCtx *ctx, LthContact *contact);

/// List the active points, their samples, and who hangs on each sample. Allocates nothing.
void lth_contact_index(LthContact *contact);

/// True where loops over n things are worth several threads.
static inline bool lth_contact_is_large(LitheIndex n) { return n > 2000; }
