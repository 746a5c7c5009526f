/// The inside of LthContact: what may touch what, and the samples that touching points hang on.
#pragma once

#include "embed/contact.h"
#include "geometry/bvh.h"

/// An embedded point that takes part in a touch, with its weight in the relative velocity.
typedef struct LthLeg {
  int side;
  LitheIndex point;
  double weight;
} LthLeg;

#define LTH_LEGS_MAX 6 ///< the corners of two triangles

/// A point near a collider or another body. Equations: docs/theory/contact.md. Velocities are relative to the other
/// body's material; that of a rigid collider, known beforehand, is kept apart in `velocity`.
typedef struct LthTouch {
  int side;         ///< whose point
  LitheIndex other; ///< collider or part; 0 in contacts of two bodies
  LitheIndex point; ///< its number on its side
  int n_legs, n_own;
  LthLeg leg[LTH_LEGS_MAX]; ///< the first n_own are the point itself, their weights sum to one
  bool active;
  bool acted;     ///< was active in the last solve
  bool anchored;  ///< has been active in this search for an equilibrium
  double gap;     ///< of the start place to the collider at the end of the step, with slack [m]
  double slack;   ///< depth at which the spring is not pressed; 0 at colliders [m]
  double pressed; ///< the spring at the start of the step, below zero at a gap [m]
  double normal[3];
  double stiffness;      ///< k times the point's area [N/m]
  double velocity[3];    ///< of the collider's material there [m/s]
  LitheIndex anchor_tri; ///< of the other body, where friction's spring is fixed
  double
      anchor[3]; ///< place in the collider's rest frame [m], or weights of the triangle's corners
  double offset[3];     ///< tangential stretch of that spring if the point stayed where it is [m]
  double start[3];      ///< velocity of the point at the start [m/s]
  double trial[3];      ///< stretch by the last solve, or as predicted [m]
  double spring;        ///< secant stiffness of friction [N/m], at most `stiffness`
  double limit;         ///< mu times the normal force of the last solve [N]
  double gap_end;       ///< at the end of the step by the last solve, with slack [m]
  double force_n;       ///< normal force of the last solve [N]
  double stored, drawn; ///< in the normal's spring and in friction's, by the last solve [J]
  double lost;          ///< by the normal's in the step [J]
  double D[9], r[3];    ///< equation (4)
} LthTouch;

/// A body in a contact: where its points are, and its part of the linear system.
typedef struct LthContactSide {
  const LthEmbedding *points;          ///< borrowed for life
  LitheIndex first_row;                ///< of the body among the system's block rows
  LitheCount first_dof;                ///< and in its vectors
  LitheCount first_block;              ///< of its diagonal blocks [doubles]
  LitheCount *block_off;               ///< start of each row's diagonal block       (n_rows + 1)
  double weight_norm;                  ///< largest sum of |weights| of a point
  double *position;                    ///< (n_points x 3)
  double *sample_value, *sample_force; ///< (n_samples x 4)

  // samples that active points hang on, and who hangs on each
  LitheIndex *touched; ///< (n_touched)
  LitheCount touched_cap;
  LitheIndex n_touched;
  LitheIndex *sample_slot; ///< place in touched, -1                     (n_samples)
  LitheCount *slot_off;    ///< entries of each touched sample           (n_touched + 1)
  LitheCount slot_off_cap;
  LitheIndex *slot_active; ///< places in LthContact.active
  LitheCount slot_active_cap;
  double *slot_weight;
  LitheCount slot_weight_cap;

  // the same by active touch: samples and weights, one after the other
  LitheCount *active_off; ///< (n_active + 1)
  LitheCount active_off_cap;
  LitheIndex *active_sample;
  LitheCount active_sample_cap;
  double *active_weight;
  LitheCount active_weight_cap;
} LthContactSide;

/// What differs between contact with colliders and between bodies.
typedef struct LthContactKind {
  /// Places of all points and velocities of samples are known. NULL: nothing to do.
  LitheStatus (*begin)(LitheCtx *ctx, LthContact *c);
  LitheStatus (*find_near)(LitheCtx *ctx,
                           LthContact *c); ///< appends to c->touch, by side, other, point
  void (*move_anchor)(const LthContact *c, LthTouch *touch, const double x[3]);
  void (*destroy)(LitheCtx *ctx, LthContact *c); ///< frees c->self
  bool may_grow;     ///< an automatic stiffness, where a body rests too deep
  bool keeps_energy; ///< springs give back no more than they took
} LthContactKind;

/// The point of another surface that a point may touch.
typedef struct LthHit {
  LitheIndex tri; ///< -1: none
  double point[3], normal[3], gap;
  bool held; ///< to the plane of its triangle, perhaps beside it
} LthHit;

/// What a point has met in a search for an equilibrium. Inside facets the nearest triangle, and the normal with it,
/// jumps: a point that is pushed over an edge by either of two triangles would go to and fro for ever.
typedef struct LthHold {
  LitheIndex tri; ///< last one met inside, -1
  int changes;
} LthHold;

/// A point's own normal, for choosing triangles that face it.
typedef struct LthSeeker {
  const LthBvh *bvh; ///< of the other's surface
  double normal[3];
  double facing;  ///< largest cosine between the normals of what touches
  double way_out; ///< farthest face that a point inside is led back to [m]
  const LthCrackSides
      *crack;       ///< of the other's surface where it is the point's own; NULL: it is not
  LitheIndex sheet; ///< that the point is on then
} LthSeeker;

struct LthContact {
  LitheCtx *ctx;
  const LthContactKind *kind;
  void *self; ///< LthRigid, LthPair or LthParts
  int n_sides;
  LthContactSide side[2];
  double friction, damping, cell_size, body_size;
  bool is_auto;
  double stiffness; ///< per area or per point
  double t, dt;
  LthContactLook look;
  bool is_search; ///< the last look was for an equilibrium
  double weight;  ///< time that forces act over dt; 1, or 2 where dt is half a step
  double ahead; ///< of the places of a look beyond those of the step's start, at their velocity [s]
  double spare,
      spent; ///< energy that springs had lost when the step began, and what slacks take of it [J]
  int round, friction_round;
  double penetration, force, last_penetration;
  double begin_penetration; ///< when the step began
  bool again;               ///< the next look begins the same step
  double growth;            ///< of an automatic stiffness since the start
  bool warned;              ///< that bodies are fast
  bool started;             ///< some step has been looked at

  LthTouch *touch, *before; ///< of this step and of the last one, by side, other and point
  LitheCount touch_cap, before_cap;
  LitheIndex n_touch, n_before, before_at; ///< before_at: how far lth_touch_remember() has come

  LitheIndex n_acted; ///< points that the last solve had active
  bool drops;         ///< no more points come in in this step
  LitheIndex *active; ///< places in touch, ascending               (n_active)
  LitheCount active_cap;
  LitheIndex n_active;
  double *active_D; ///< D of each                                (n_active x 9)
  LitheCount active_D_cap;
  double *force_of; ///< on each active point                     (n_active x 3)
  LitheCount force_of_cap;
};

// contact.c

/// A contact of `n_sides` bodies; owned by the caller once `kind` and `self` are set.
LitheStatus lth_contact_create_sides(LitheCtx *ctx, int n_sides, const LthEmbedding *const *points,
                                     double stiffness, LthContact **contact);

/// Stiffer than a layer of cells, and stiff enough to carry a weight [N] on a spot of a body of `size`:
/// equation (6), per area.
double lth_contact_auto_stiffness(double modulus, double cell_size, double weight, double size);

/// As stiff as `soft`, what the softer body needs, and enough for the lighter one's weight [N].
double lth_contact_pair_stiffness(double soft, double cell_size, double weight, double size);

/// Where the point of a touch is.
void lth_touch_place(const LthContact *c, const LthTouch *touch, double x[3]);

/// Append a touching point of a side.
LitheStatus lth_touch_add(LitheCtx *ctx, LthContact *c, const LthTouch *touch);

/// The same point in the last step, or NULL. Points come in the order of the list.
const LthTouch *lth_touch_before(LthContact *c, const LthTouch *touch);

/// Take over what a point of the last step knows, and let its velocity v go on changing as it did. Points come in
/// the order of the list.
void lth_touch_remember(LthContact *c, LthTouch *touch, double v[3]);

/// Largest speed of any point of a side, from its samples' velocities.
double lth_contact_fastest(const LthContactSide *side);

/// Smallest box that holds all points of a side.
void lth_contact_box(const LthContactSide *side, double box[6]);

/// When the step ends: in a search for an equilibrium no time passes.
static inline double lth_contact_end(const LthContact *c) {
  return c->look == LTH_LOOK_STEP ? c->t + c->dt : c->t;
}

/// Share of the stiffness of a point [N/m].
static inline double lth_contact_share(const LthContact *c, const LthEmbedding *e, LitheIndex p) {
  return c->stiffness * (e->area ? e->area[p] : 1);
}

// contact_foot.c

/// Weights of a triangle's corners in the foot of x on its plane: also below zero, their sum is one.
void lth_plane_weights(const LthSurface *surface, LitheIndex tri, const double x[3], double w[3]);

/// The same for a point of the triangle, where only rounding is below zero.
void lth_corner_weights(const LthSurface *surface, LitheIndex tri, const double x[3], double w[3]);

/// The foot of x on the plane of a triangle, and the gap [m]: true where x is behind the plane and the foot not far
/// beside the triangle.
bool lth_meet_plane(const LthBvh *bvh, LitheIndex tri, const double x[3], double *gap,
                    double foot[3]);

/// The thinnest side of a box, and the distance of two boxes [m].
double lth_box_thickness(const double box[6]);
double lth_box_gap(const double a[6], const double b[6]);

/// Fix friction's spring of a touch at point x of a triangle of the other's surface.
void lth_touch_fix(const LthSurface *surface, LitheIndex tri, const double x[3], LthTouch *touch);

/// Append the corners of the triangle that was hit, as points of that surface.
void lth_touch_add_foot(const LthSurface *surface, const LthHit *hit, int side, LthTouch *touch);

/// All the rest of a touch whose legs and stiffness are set, from its relative velocity v at the start: gap, spring,
/// equations.
void lth_touch_meet(LthContact *c, const LthSurface *surface, const LthHit *hit, double v[3],
                    LthTouch *touch);

// contact_energy.c

/// Gap, slack and compression of a touch whose normal, stiffness and velocity at the start are set; `old`: the same point in the last step,
/// or NULL.
void lth_touch_begin(const LthContact *c, const LthTouch *old, const LthHit *hit, LthTouch *touch);

/// Let friction's spring begin with no more than it held.
void lth_touch_limit_stretch(const LthContact *c, const LthTouch *old, LthTouch *touch);

/// What the springs of a touch hold after a solve, and what was lost in it. `acted`: the point was active in it, friction's secant was
/// `spring`.
void lth_touch_account(const LthContact *c, bool acted, double spring, LthTouch *touch);

/// When a step has ended: what its springs have lost may press others.
void lth_contact_end_account(LthContact *c);

/// Once all points are known: take up some of their slack with what was lost before.
void lth_contact_relax(LthContact *c);

// contact_seek.c

/// A triangle that faces the point: LthBvhAccept.
bool lth_seeker_faces(const void *self, LitheIndex tri);

/// What point x meets on the other's surface that is nearer than `reach`, or inside and no deeper than `depth`. A point
/// that is inside nearest to a face it cannot have come through is led back to one that it can.
void lth_seek(const LthSeeker *seeker, const double x[3], double reach, double depth, LthHit *hit);

/// Points that have changed their triangle too often keep to its plane, until their foot is far beside it.
void lth_hold_on(const LthBvh *other, const double x[3], bool first, LthHold *hold, LthHit *hit);

// contact_system.c

/// Make room for the index of as many active points as there are touching ones.
LitheStatus lth_contact_reserve(LitheCtx *ctx, LthContact *c);

/// List the active points, their samples, and who hangs on each sample. Allocates nothing.
void lth_contact_index(LthContact *c);

/// Sum of the legs' values from the samples of all sides.
void lth_touch_value(const LthContact *c, const LthTouch *touch, double value[3]);

// contact_archive.c

/// Take over all that another contact remembers, but for touches.
void lth_contact_take(LthContact *c, const LthContact *from);

/// Put a touch where it belongs in the order of the list.
LitheStatus lth_contact_insert(LitheCtx *ctx, LthContact *c, const LthTouch *touch);

// contact_revise.c

/// Set D and r of a touching point from its state.
void lth_touch_linearize(const LthContact *c, LthTouch *touch);

/// Set trial and spring of a touching point for velocity v, by its limit: equation (3).
void lth_touch_stretch(const LthContact *c, LthTouch *touch, const double v[3]);

/// True where loops over n things are worth several threads.
static inline bool lth_contact_is_large(LitheIndex n) { return n > 2000; }
