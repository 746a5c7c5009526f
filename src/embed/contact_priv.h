/// The inside of LthContact: points near colliders, and the samples that they hang on.
#pragma once

#include "embed/collider.h"
#include "embed/contact.h"

typedef enum LthFriction { LTH_FRICTION_STICK, LTH_FRICTION_SLIDE, LTH_FRICTION_DRAG } LthFriction;

/// A point near a collider. Equations: docs/theory/contact.md.
typedef struct LthTouch {
  LitheIndex point, collider;
  bool active;
  LthFriction friction;
  int switches; ///< of friction's state in this step
  double gap;   ///< of the start place to the collider at the end of the step [m]
  double normal[3];
  double stiffness;   ///< k times the point's area [N/m]
  double velocity[3]; ///< of the collider's material there [m/s]
  double anchor[3];   ///< where friction's spring is fixed, in the collider's rest frame [m]
  double offset[3];   ///< tangential stretch of that spring if the point stayed where it is [m]
  double slide[3];    ///< direction of sliding
  double speed;       ///< of sliding in the last solve [m/s]
  double limit;       ///< mu times the normal force of the last solve [N]
  double gap_end;     ///< at the end of the step by the last solve [m]
  double force_n;     ///< normal force of the last solve [N]
  double force_t[3];  ///< friction of the last solve [N]
  double D[9], r[3];  ///< equation (4)
} LthTouch;

struct LthContact {
  LitheCtx *ctx;
  LthContactDef def;
  LthCollider *colliders; ///< copies, meshes with a tree
  bool *owns_bvh;
  LitheCount *block_off; ///< start of each cell's diagonal block      (n_cells + 1)
  bool is_auto;
  double stiffness;   ///< per area or per point
  double weight_norm; ///< largest sum of |weights| of a point
  double t, dt;
  int round;
  double penetration, force, last_penetration;
  double growth; ///< of an automatic stiffness since the start
  LitheIndex n_active;

  double *position;                    ///< (n_points x 3)
  double *gap;                         ///< to the present collider                  (n_points)
  double *sample_value, *sample_force; ///< (n_samples x 4)

  LthTouch *touch, *before; ///< of this step and of the last one, by collider and point
  LitheCount touch_cap, before_cap;
  LitheIndex n_touch, n_before;

  LitheIndex *touched; ///< samples that any touching point hangs on (n_touched)
  LitheCount touched_cap;
  LitheIndex n_touched;
  LitheIndex *sample_slot; ///< place in touched, -1                     (n_samples)
  LitheCount *slot_off;    ///< points of each touched sample            (n_touched + 1)
  LitheCount slot_off_cap;
  LitheIndex *slot_touch;
  LitheCount slot_touch_cap;
  double *slot_weight;
  LitheCount slot_weight_cap;
  double *touch_force; ///< (n_touch x 3)
  LitheCount touch_force_cap;
};

/// Set D and r of a touching point from its state.
void lth_touch_linearize(const LthContact *contact, LthTouch *touch);

/// List the samples of all touching points and who hangs on each.
LitheStatus lth_contact_index(LitheCtx *ctx, LthContact *contact);

/// Averages of v at the touched samples into sample_value.
void lth_contact_sample(const LthContact *contact, const double *v);

/// True where loops over n things are worth several threads.
static inline bool lth_contact_is_large(LitheIndex n) { return n > 400; }
