/// Penalty contact of embedded points with rigid colliders, within the implicit solve.
/// Kaufmann et al. 2009, section 8 (sign corrected: docs/theory/contact.md).
#pragma once

#include "embed/embedding.h"
#include "geometry/shape.h"
#include "la/krylov.h"

typedef enum LthColliderKind {
  LTH_COLLIDER_PLANE,   ///< point, normal (points to the free side)
  LTH_COLLIDER_SPHERE,
  LTH_COLLIDER_BOX,
  LTH_COLLIDER_CAPSULE,
  LTH_COLLIDER_MESH     ///< closed surface
} LthColliderKind;

/// Rigid, may move: translation(t) added to its rest place, rotation about `pivot`.
typedef struct LthCollider {
  LthColliderKind kind;
  LthShape shape;             ///< sphere, box, capsule, mesh
  double point[3], normal[3]; ///< plane
  LthValue translation[3];    ///< [m]
  LthValue angle;             ///< [rad] about axis
  double axis[3], pivot[3];
} LthCollider;

typedef struct LthContactDef {
  const LthEmbedding *points; ///< borrowed for life
  const LthCollider *colliders; ///< borrowed for life
  LitheIndex n_colliders;
  double stiffness;           ///< [Pa/m] per area (or [N/m] a point where no area is known); 0: auto
  double friction;            ///< Coulomb's mu
  double damping;             ///< [s] times the stiffness, along the normal
  double modulus;             ///< largest lambda + 2 mu of the body [Pa], for auto
  double cell_size, body_size, body_weight; ///< [m], [m], [N], for auto
} LthContactDef;

typedef struct LthContact LthContact;

LitheStatus lth_contact_create(LitheCtx *ctx, const LthContactDef *def, LthContact **contact);
void lth_contact_destroy(LitheCtx *ctx, LthContact **contact);

/// Gap (signed distance, negative inside) and outward normal of a collider at time t.
double lth_collider_gap(const LthCollider *collider, const double x[3], double t, double normal[3]);

/// Velocity of the collider's material at x.
void lth_collider_velocity(const LthCollider *collider, const double x[3], double t, double velocity[3]);

/// Find the active points for the step t -> t + dt from displacement u and velocity v (coefficients):
/// those that are in a collider or would be. Returns their number. Allocates only when the set grows
/// beyond what it ever was.
LitheStatus lth_contact_detect(LitheCtx *ctx, LthContact *contact, double t, double dt, const double *u,
                               const double *v, LitheIndex *n_active);

/// For the linearly implicit step: y += dt^2 W^T k (n n^T + friction) W v + dt damping ..., the contact
/// part of the system matrix acting on v1.
void lth_contact_apply(const LthContact *contact, const double *v, double *y);

/// rhs += dt W^T (force at the start of the step): pushes points out of colliders.
void lth_contact_add_rhs(const LthContact *contact, double *rhs);

/// Add the matrix's diagonal blocks to `extra`, laid out as LthBlockJacobi's (block rows `row_off`).
void lth_contact_add_diagonal(const LthContact *contact, const LthDgSpace *space, double *extra);

/// After a solve: drop points that pull, take in new ones; update friction limits by the normal forces.
/// Returns true where the set changed and the step should be solved again.
bool lth_contact_revise(LthContact *contact, const double *u, const double *v1);

/// Number of active points, deepest penetration [m] and total normal force [N] of the last step.
void lth_contact_report(const LthContact *contact, LitheIndex *n, double *penetration, double *force);
