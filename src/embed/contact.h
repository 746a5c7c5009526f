/// Penalty contact of embedded points with rigid colliders or other bodies, within the implicit solve.
/// Kaufmann et al. 2009, section 8 (sign corrected: docs/theory/contact.md).
#pragma once

#include "base/archive.h"
#include "embed/embedding.h"
#include "geometry/shape.h"
#include "la/krylov.h"

typedef enum LthColliderKind {
  LTH_COLLIDER_PLANE, ///< point, normal (points to the free side)
  LTH_COLLIDER_SPHERE,
  LTH_COLLIDER_BOX,
  LTH_COLLIDER_CAPSULE,
  LTH_COLLIDER_MESH ///< closed surface
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

/// Width of what carries a body's weight over its size, for an automatic stiffness: the root of 0.004.
#define LTH_CONTACT_SPOT 0.0632455532033675866

typedef struct LthContactDef {
  const LthEmbedding *points;   ///< borrowed for life
  const LthCollider *colliders; ///< borrowed for life; a mesh without bvh gets one here
  LitheIndex n_colliders;
  double stiffness; ///< [Pa/m] per area (or [N/m] a point where no area is known); 0: auto
  double friction;  ///< Coulomb's mu
  double damping;   ///< [s] times the stiffness, along the normal
  double modulus;   ///< largest lambda + 2 mu of the body [Pa], for auto
  double cell_size, body_size, body_weight; ///< [m], [m], [N], for auto
} LthContactDef;

/// A body in a contact of two: its points, and the closed surface that the other's points touch.
typedef struct LthPairSide {
  const char *name; ///< for messages, borrowed for life
  const LthEmbedding
      *points; ///< borrowed for life; points whose area is 0 carry the surface, and do not touch
  const LthSurface *surface; ///< at rest, borrowed for life
  const LitheIndex
      *surface_point;      ///< embedded point of each of the surface's    (n_points of surface)
  const uint8_t *excluded; ///< points that touch nothing (tied), or NULL     (n_points)
  double modulus;          ///< largest lambda + 2 mu [Pa]
  double cell_size, body_size, body_weight; ///< [m], [m], [N]
} LthPairSide;

/// Contact of two bodies, both ways: the points of each touch the surface of the other.
typedef struct LthPairDef {
  LthPairSide side[2];
  double stiffness, friction, damping; ///< as in LthContactDef
} LthPairDef;

/// Where cuts end inside a part: sheets are faces of a cut that hang together on one side of it.
typedef struct LthCrackSides {
  LitheIndex *
      sheet; ///< of each triangle, -1: of none, or at the front    (n_tris); NULL: there is no crack
  uint8_t *
      touches; ///< places of triangles that touch others: bit k by corner k, bit 3 the middle; not those
               ///< near the front                               (n_tris)
  LitheIndex *mates; ///< sheets that look at each other, ascending         (n_mates x 2)
  LitheIndex n_mates;
} LthCrackSides;

/// A body that consists of parts, each with a closed surface of its own. Point i of part k's surface is embedded point
/// first_point[k] + i.
typedef struct LthPartsSide {
  const char *name;              ///< for messages, borrowed for life
  const LthEmbedding *points;    ///< of all parts' surfaces, borrowed for life
  const LthSurface *surface;     ///< at rest, borrowed for life              (n_parts)
  const LitheIndex *first_point; ///< borrowed for life                       (n_parts + 1)
  LitheIndex n_parts;
  const LthCrackSides *cracks; ///< of each part, borrowed for life; NULL: none has any (n_parts)
  const uint8_t *excluded;     ///< points whose triangles touch nothing (tied), or NULL (n_points)
  double modulus;              ///< largest lambda + 2 mu [Pa]
  double cell_size, body_size, body_weight; ///< [m], [m], [N]
} LthPartsSide;

/// Contact of the parts of one body with each other, of the sides of cracks in each, or of the parts of two bodies: triangles of each part touch the
/// surfaces of the others by points inside them, so that what lies face to face along a cut is sure of its side.
typedef struct LthPartsDef {
  int n_sides; ///< 1: every part of side[0] with every other, and the sides of its cracks; 2: those of side[0] with those of side[1]
  LthPartsSide side[2];
  double stiffness, friction, damping; ///< as in LthContactDef
} LthPartsDef;

/// Contact of one body with colliders, of two bodies with each other, or of parts of bodies.
typedef struct LthContact LthContact;

/// Set up for a body; `ctx` is kept for its number of threads. What changes in a run (active points,
/// anchors of friction, an automatic stiffness) is inside: one contact per moving body.
LitheStatus lth_contact_create(LitheCtx *ctx, const LthContactDef *def, LthContact **contact);
LitheStatus lth_contact_create_pair(LitheCtx *ctx, const LthPairDef *def, LthContact **contact);
LitheStatus lth_contact_create_parts(LitheCtx *ctx, const LthPartsDef *def, LthContact **contact);
void lth_contact_destroy(LitheCtx *ctx, LthContact **contact);

/// Bodies of a contact: 1 with colliders and among the parts of a body, else 2.
int lth_contact_sides(const LthContact *contact);

/// Among the parts of one body: its forces sum up to nothing there.
bool lth_contact_is_within(const LthContact *contact);

/// Where a body stands among block rows, vectors and diagonal blocks given to the functions below; 0 at first.
void lth_contact_place(LthContact *contact, int side, LitheIndex first_row, LitheCount first_dof,
                       LitheCount first_block);

/// What points are looked for: a time step, or an equilibrium at t, for the first time or once more in the same
/// search. In a search colliders stand where they are at t, friction's springs stay where they are fixed, also those of
/// points that part and come back, and their limits are those of the present gaps: forces follow from the
/// displacement alone, whatever the search has tried before. dt is 1 and v zero there.
typedef enum LthContactLook {
  LTH_LOOK_STEP,
  LTH_LOOK_FIRST,
  LTH_LOOK_AGAIN,
  LTH_LOOK_NEAR ///< again, near an equilibrium: friction by its tangent, not its secant
} LthContactLook;

/// For the next lth_contact_detect(); a step at first.
void lth_contact_set_look(LthContact *contact, LthContactLook look);

/// Find the points that may touch in the step t -> t + dt, from displacement u and velocity v
/// (coefficients). Returns the number of those that are active at first: in a collider if they went on as
/// they do. Also ends the step before: sliding points take their anchors along. Allocates only when more
/// points come near than ever before.
LitheStatus lth_contact_detect(LitheCtx *ctx, LthContact *contact, double t, double dt,
                               const double *u, const double *v, LitheIndex *n_active);

/// The contact is made in the middle of a run: what lies inside something at first has not come in, and does not push.
void lth_contact_join_run(LthContact *contact);

/// The next lth_contact_detect() begins the step of the last one once more, from the same places: anchors, limits and an automatic
/// stiffness are those that it began with.
void lth_contact_begin_again(LthContact *contact);

/// Forces of the next steps act over `weight` dt, 1 at first: a trapezoidal rule looks half a step ahead (dt) and
/// lets the forces at its end act for all of it. Displacements given to looks are those of the step's start and `ahead` [s] on at the
/// velocity given.
void lth_contact_set_weight(LthContact *contact, double weight, double ahead);

/// The contact part of the system matrix acting on v1: y += W^T D W v, D of equation (4) of
/// docs/theory/contact.md, symmetric and positive semi-definite.
void lth_contact_apply(const LthContact *contact, const double *v, double *y);

/// rhs += W^T r, r of equation (4): pushes points out of colliders and along with them.
void lth_contact_add_rhs(const LthContact *contact, double *rhs);

/// Add to `extra`, laid out as LthBlockJacobi's diagonal blocks (those of all rows one after the
/// other), a block diagonal matrix that is nowhere below the contact part where weights are positive.
void lth_contact_add_diagonal(const LthContact *contact, double *extra);

/// One side of a touch as if it hung on one block row alone: relative velocity is the sum over both ends of phi . v.
typedef struct LthContactEnd {
  LitheIndex row;
  int nb;                       ///< functions of the row
  double phi[LTH_DG_MAX_FUNCS]; ///< with its sign
} LthContactEnd;

/// D (3 x 3) of equation (4) as it stands; one end where a collider is touched.
typedef void LthContactLumpFn(void *self, int n_ends, const LthContactEnd *end, const double *D);

/// Visit active touches (`all`: also those that may become so), each lumped to the rows that it hangs on most: sum of (phi D phi^T) is
/// near the contact part of the matrix for what hardly jumps between elements, and couples few rows. False: nothing is
/// visited, for components have functions of their own.
bool lth_contact_visit_lumps(const LthContact *contact, bool all, LthContactLumpFn *visit,
                             void *self);

/// After a solve: drop points that pull, take in those that end inside, let go of or hold those whose
/// friction is above or below Coulomb's limit. Returns true where the step should be solved again; a few
/// rounds at most in a step.
bool lth_contact_revise(LthContact *contact, const double *v1);

/// Number of active points, deepest penetration [m] and total normal force [N] of the last solve.
void lth_contact_report(const LthContact *contact, LitheIndex *n, double *penetration,
                        double *force);

/// After the last revision: where points that were active and pull have made more energy than springs have lost before, those are left out, and no
/// others come in any more in this step. True where the step should be solved again.
bool lth_contact_drop_pulls(LthContact *contact);

/// Whether the last solve had forces of this contact in it: the points that are active after it may be others.
bool lth_contact_acted(const LthContact *contact);

/// Energy that springs begin the present step with [J]; 0 at colliders.
double lth_contact_start_energy(const LthContact *contact);

/// Energy in springs after the last solve, and what they have lost so far and may press others with [J]. Between bodies, and between parts, neither the
/// first nor the sum of both rises but by work of the bodies.
void lth_contact_energy(const LthContact *contact, double *stored, double *spare);

/// What a later step needs to know of the steps before: anchors, limits, an automatic stiffness. Walks
/// outwards or inwards.
void lth_contact_archive(LthContact *contact, LthArchive *archive);

/// Take the memory of another contact of the same bodies: of points that are still there. `point_of` has for each side
/// the new number of each of the other's points, -1: none. Where surfaces of bodies differ,
/// friction between them starts anew.
LitheStatus lth_contact_inherit(LitheCtx *ctx, LthContact *contact, const LthContact *from,
                                const LitheIndex *const point_of[2], bool same_surfaces);

/// The same of contacts of parts, by places at rest: parts may be others than before, and more. Surfaces of both at rest
/// are those that they were made with.
LitheStatus lth_contact_inherit_parts(LitheCtx *ctx, LthContact *contact, const LthContact *from);

/// Stiffness per area in use [Pa/m] (per point [N/m] where no area is known).
double lth_contact_stiffness(const LthContact *contact);
