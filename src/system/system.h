/// All bodies of a scene as one vector of unknowns and one block matrix: what stepping knows of them.
#pragma once

#include "disc/disc.h"
#include "embed/contact.h"

/// One body; everything is borrowed for life.
typedef struct LthSystemBody {
  LthDisc *disc;
  double damping_mass, damping_stiffness; ///< Rayleigh [1/s], [s]
  const LthLoad *loads;
  LitheIndex n_loads;
  const uint8_t *held; ///< LthHeld: unknowns that move as prescribed, or NULL  (n_dofs)
  LitheStatus (*prescribe)(const void *self, double t,
                           double *x); ///< writes held unknowns, others untouched
  const void *prescribe_self;
  bool warped; ///< corotated: static solves iterate rotations
} LthSystemBody;

/// What couples two bodies by blocks of the matrix (a tie). Rows and unknowns are the system's.
typedef struct LthCoupling {
  void *self;
  LitheIndex n_pairs;
  const LitheIndex *pairs; ///< (row, col), row < col, of coupled block rows   (n_pairs x 2)
  void (*update_rotations)(void *self, const double *x);            ///< or NULL
  void (*add)(void *self, double t, LthBlockMatrix *A, double *f0); ///< A += K, f0 += f0
  void (*add_load)(void *self, double t, double *f0);
  double (*energy)(void *self, double t, const double *x);
  void (*archive)(void *self, LthArchive *archive); ///< memory from step to step; NULL: it has none
  void (*destroy)(LitheCtx *ctx, void *self);       ///< by its owner, not by the system
  bool is_nonlinear;                                ///< its K changes with x
} LthCoupling;

/// Contact of a body with colliders, or of two bodies with each other; borrowed for life.
typedef struct LthSystemContact {
  LthContact *contact;
  LitheIndex body[2]; ///< of its sides; the second is not read where there is one
} LthSystemContact;

typedef struct LthSystemDef {
  const LthSystemBody *bodies; ///< copied                                   (n_bodies)
  LitheIndex n_bodies;
  const LthCoupling *couplings; ///< copied                                  (n_couplings)
  LitheIndex n_couplings;
  const LthSystemContact *contacts; ///< copied                              (n_contacts)
  LitheIndex n_contacts;
  double gravity[3];
} LthSystemDef;

/// Body b has block rows [row_first[b], row_first[b + 1]) and unknowns [dof_first[b], dof_first[b + 1]).
typedef struct LthSystem {
  LitheIndex n_bodies, n_couplings, n_contacts, n_rows;
  LthSystemBody *bodies;
  LthCoupling *couplings;
  LthContact **contacts; ///< all see vectors of the system               (n_contacts)
  LitheCount n;          ///< unknowns
  LitheIndex *row_first;
  LitheCount *dof_first;
  LitheIndex *row_body; ///< body of a block row                              (n_rows)
  double gravity[3];
  bool warped;                   ///< some body is
  bool is_nonlinear;             ///< warped, or forces follow the position otherwise
  bool has_held;                 ///< some unknown is
  uint8_t *held;                 ///< LthHeld (n), NULL where none is
  uint8_t *row_held;             ///< some unknown of a block row is, or NULL          (n_rows)
  double *one;                   ///< coefficients of the function 1                   (n / 3)
  double *f_fixed;               ///< gravity and loads that never change [N]          (n)
  double *fade;                  ///< a force that dies away, NULL: none [N]           (n)
  double fade_start, fade_decay; ///< when it was whole, and the time in which it falls to 1/e [s]
  LthBlockMatrix **part;         ///< a body's rows of A, values lent from there       (n_bodies)
  bool lends;                    ///< they are: parts have none of their own
} LthSystem;

/// How the only body of a system can be solved without a matrix, or NULL: it must be linear, and tied to none.
const LthDiscSolver *lth_system_solver(const LthSystem *system);

LitheStatus lth_system_create(LitheCtx *ctx, const LthSystemDef *def, LthSystem **system);
void lth_system_destroy(LitheCtx *ctx, LthSystem **system);

/// The matrix of all bodies and couplings; lth_system_assemble() fills this one and no other.
LitheStatus lth_system_matrix_create(LitheCtx *ctx, LthSystem *system, LthBlockMatrix **A);

void lth_system_rest(const LthSystem *system, double *x0);
void lth_system_update_rotations(LthSystem *system, const double *x);
void lth_system_assemble(LthSystem *system, double t, LthBlockMatrix *A, double *f0);
void lth_system_assemble_load(LthSystem *system, double t, double *f0);
double lth_system_energy(LthSystem *system, double t, const double *x);

/// A = cm M + ck A with factors of each body (n_bodies each): Rayleigh damping is in them. Blocks between two
/// bodies take the smaller ck, which keeps A definite.
void lth_system_combine(LitheCtx *ctx, LthSystem *system, const double *cm, const double *ck,
                        LthBlockMatrix *A);
void lth_system_apply_mass(const LthSystem *system, const double *v, double *y); ///< y = M v
/// The same of one body; other entries of v and y (n each) stay.
void lth_system_apply_body_mass(const LthSystem *system, LitheIndex b, const double *v, double *y);
void lth_system_mass_diagonal(const LthSystem *system, double *mass); ///< (n)

/// What is left at time t of the force that dies away: 1 at first, 0 once it is below a thousandth.
double lth_system_fade_left(const LthSystem *system, double t);

/// f = external forces at time t, without contact and without the force that dies away.
LitheStatus lth_system_external_force(LitheCtx *ctx, LthSystem *system, double t, const double *x,
                                      double *f);
/// Places of held unknowns at time t; others untouched.
LitheStatus lth_system_prescribe(const LthSystem *system, double t, double *x);

/// y = 0 at held unknowns.
void lth_system_zero_held(const LthSystem *system, double *y);

/// Rows and columns of held unknowns become those of the identity. What they carry to the right-hand side is
/// the caller's business, before.
void lth_system_hold(LitheCtx *ctx, const LthSystem *system, LthBlockMatrix *A);
