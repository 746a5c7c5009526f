/// The small interface of a discretisation: all that embedding, stepping and output know of dg and cg.
#pragma once

#include "base/archive.h"
#include "la/krylov.h"
#include "mesh/selection.h"

#define LTH_DISC_MAX_FUNCS 48 ///< functions that are not zero somewhere in one cell

/// What an unknown is. Absent ones carry no stiffness and no mass: they stay where they are.
typedef enum LthHeld { LTH_NOT_HELD, LTH_HELD, LTH_ABSENT } LthHeld;

/// A load on the boundary or in the volume.
typedef enum LthLoadKind {
  LTH_LOAD_TRACTION,    ///< value [Pa], force per rest area
  LTH_LOAD_TOTAL_FORCE, ///< value [N], spread evenly over the selection
  LTH_LOAD_PRESSURE,    ///< value[0] [Pa] along the inward normal
  LTH_LOAD_STRESS,      ///< stress [Pa] row-major; traction = stress n
  LTH_LOAD_BODY_FORCE,  ///< value [N/m^3]
  LTH_LOAD_POINT_FORCE  ///< value [N] at each of `places`
} LthLoadKind;

/// Places in a body and the cells that touch each of them.
typedef struct LthPlaces {
  LitheIndex n;
  double *at;           ///< at rest [m]                                (n x 3)
  LitheIndex *cell_off; ///< (n + 1) into cell; each place has one at least
  LitheIndex *cell;
} LthPlaces;

void lth_places_destroy(LitheCtx *ctx, LthPlaces **places);

typedef struct LthLoad {
  LthLoadKind kind;
  const LthPatches
      *patches; ///< borrowed for life; NULL for body and point forces and staggered bodies
  const LthPlaces *places; ///< borrowed for life; of point forces only
  /// Staggered bodies have no patches: true for boundary at a point with an outward unit normal that is loaded;
  /// thread-safe; NULL: all of it.
  bool (*selects)(const void *self, const double point[3], const double normal[3]);
  const void *select_self; ///< borrowed for life
  LthValue value[3];
  LthValue stress[9];
  bool follower;       ///< pressure that turns and stretches with the surface
  bool blocked[3];     ///< components that the boundary holds there: the support takes their force
  bool blocked_normal; ///< so it does along the normal (a roller)
  double area;         ///< what a total force is spread over [m^2]; 0: the patches
} LthLoad;

/// The force depends on the position.
static inline bool lth_load_follows(const LthLoad *load) {
  return load->kind == LTH_LOAD_PRESSURE && load->follower;
}

/// Take the blocked directions out of a force on boundary with unit normal n.
void lth_load_release(const LthLoad *load, const double n[3], double force[3]);

/// A weakly imposed displacement on part of the boundary.
typedef struct LthWeakConstraint {
  const LthPatches *patches; ///< borrowed for life
  bool fixed[3];             ///< components that are prescribed
  bool normal_only;          ///< a roller: only the normal component, value[0]
  bool is_position;          ///< value is the deformed place, not the displacement
  LthValue value[3];         ///< [m]
  bool moves;                ///< some value varies with time
} LthWeakConstraint;

typedef struct LthDisc LthDisc;

/// Solves of a discretisation that needs no matrix for them. Vectors are of its own unknowns; what is held or dead
/// has rows and columns of the identity, and right-hand sides are zero there.
typedef struct LthDiscSolver {
  /// f = internal force at a position x: K (x - rest) where the body is linear.
  void (*force)(const LthDisc *disc, int threads, const double *x, double *f);
  /// Diagonal of cm M + ck K, 0 at what is held or missing.
  void (*diagonal)(const LthDisc *disc, double cm, double ck, double *d);
  /// y = (cm M + ck K) x with K as linearised last; held unknowns of x count, y is zero there.
  void (*apply)(const LthDisc *disc, int threads, double cm, double ck, const double *x, double *y);
  /// Make ready for cm M + ck K as linearised last; allocates at the first call alone.
  LitheStatus (*prepare)(LitheCtx *ctx, LthDisc *disc, double cm, double ck);
  /// Solve (cm M + ck K + extra) w = rhs from the w given until |r| <= tolerance |rhs|. `extra` (may be NULL) is
  /// symmetric and positive semi-definite. `reach`: positions move by so much times w (1, or a time step).
  LitheStatus (*solve)(LitheCtx *ctx, LthDisc *disc, const LthOperator *extra, double reach,
                       const double *rhs, double *w, double tolerance, LitheIndex max_iterations,
                       LthSolveReport *report);
  /// Displacements for w = 0 (n_dofs), held unknowns where they will be: constraints on positions start from there.
  /// NULL: the discretisation has none. Before every solve() whose w moves the body; u is read at once.
  /// Where they cannot hold: LITHE_BAD_INPUT.
  LitheStatus (*aim)(LitheCtx *ctx, LthDisc *disc, const double *u);
  /// Diagonal of the `extra` of solves to come (n_dofs), NULL: there is none. Before those whose extra is large next to
  /// K: preconditioners know of it then. Allocates at the first diagonal alone. NULL: makes no use of it.
  LitheStatus (*stiffen)(LitheCtx *ctx, LthDisc *disc, const double *diagonal);
  /// Free what prepare() has made: force(), diagonal() and apply() go on without it. NULL: nothing to speak of.
  void (*release)(LitheCtx *ctx, LthDisc *disc);
  LitheCount (*bytes)(const LthDisc *disc); ///< that solves hold
} LthDiscSolver;

/// Volumes that a body keeps, where nu = 0.5: besides K x - f0 (docs/theory/staggered-mixed.md, (3)) its cells have
/// pressures, which solutions find. With c = C u the volumetric strains of such cells and W their volumes, pressures q
/// act as C^T W q, and K contains C^T W lambda C.
typedef struct LthDiscVolume {
  LitheCount (*count)(const LthDisc *disc); ///< of such cells
  /// W [m^3] and lambda [Pa]                                                              (count each)
  void (*scales)(const LthDisc *disc, double *volume, double *lambda);
  void (*strain)(const LthDisc *disc, int threads, const double *u, double *c); ///< c = C u
  /// From c = C u of displacements u take what no solution can: the change of volume of parts that are held on all sides,
  /// which has to be that of rounding or of a curved motion on the grid. LITHE_BAD_INPUT where it is more.
  LitheStatus (*admit)(LitheCtx *ctx, const LthDisc *disc, const double *u, double *c);
  /// f += C^T W q [N]; q NULL: the pressures that f0 contains.
  void (*push)(const LthDisc *disc, const double *q, double *f);
  /// f += C^T W (pressures as solved last less those in f0).
  void (*push_change)(const LthDisc *disc, double *f);
  /// Pressures of the next linearisation: those in f0 and q.
  void (*keep)(LthDisc *disc, const double *q);
} LthDiscVolume;

/// What a discretisation does. Every vector of coefficients is of its own unknowns (n_dofs), function i and
/// component a at 3 i + a; every matrix has its block rows. `x` is the position, `u` = x - rest.
typedef struct LthDiscTable {
  const char *name;            ///< "dg", "cg", "staggered"
  const LthDiscSolver *solver; ///< or NULL
  const LthDiscVolume *volume; ///< or NULL

  /// Functions that are not zero in a cell (func, ascending) and their values at x, which may lie
  /// outside; returns how many. Component a of function i has the value phi[3 i + a]: the components' functions
  /// differ only where `is_split` says so.
  int (*eval)(const LthDisc *disc, LitheIndex cell, const double x[3], LitheIndex *func,
              double *phi);
  /// The same with gradients: d/dx_b of component a's function i at dphi[9 i + 3 a + b] [1/m].
  int (*eval_gradient)(const LthDisc *disc, LitheIndex cell, const double x[3], LitheIndex *func,
                       double *dphi);
  /// Volume mean of the gradients over a cell.
  int (*mean_gradient)(const LthDisc *disc, LitheIndex cell, LitheIndex *func, double *dphi);
  /// The cell that holds x, or one near it; `inside` may be NULL. NULL: as the mesh says.
  LitheIndex (*find_cell)(const LthDisc *disc, const double x[3], bool *inside);
  /// Coefficients of the field e_axis x (field of x): a rigid rotation. NULL: function by function.
  void (*turn)(const LthDisc *disc, int axis, const double *x, double *y);
  /// Number of connected parts, and that of each block row (n_rows). NULL: as the blocks of the matrix couple them.
  LitheIndex (*parts)(const LthDisc *disc, LitheIndex *part_of);

  /// Coefficients of the map x -> x (n_dofs) and of the function 1 (n_funcs).
  void (*rest)(const LthDisc *disc, double *x0);
  void (*one)(const LthDisc *disc, double *one);
  /// Closest coefficients to a field: L2 projection (dg), interpolation (cg). Thread-safe fields only.
  LitheStatus (*project)(LitheCtx *ctx, const LthDisc *disc,
                         void (*field)(const void *self, const double x[3], double value[3]),
                         const void *self, double *coef);

  /// An empty matrix with the pattern of assemble().
  LitheStatus (*matrix_create)(LitheCtx *ctx, const LthDisc *disc, LthBlockMatrix **K);
  /// Rotations of corotated elements from x; the identity where x is NULL or the body is linear.
  void (*update_rotations)(LthDisc *disc, const double *x);
  /// K and f0 such that the internal force is K x - f0 with the rotations as they stand, at time t. K may be a
  /// part of a larger matrix: its blocks lie at value_off[e], with others between them.
  void (*assemble)(LthDisc *disc, double t, LthBlockMatrix *K, double *f0);
  void (*assemble_load)(LthDisc *disc, double t, double *f0); ///< f0 alone
  double (*energy)(LthDisc *disc, double t, const double *x);

  /// Of bodies with a tangent: root mean square over cells of the change of the deformation gradient between states.
  double (*gradient_change)(const LthDisc *disc, const double *from, const double *to);

  /// K += c M with the (consistent) mass; y = M v. `diagonal` (n_dofs): exact where the mass is diagonal,
  /// else lumped, for scales and preconditioners.
  void (*add_mass)(const LthDisc *disc, double c, LthBlockMatrix *K);
  void (*apply_mass)(const LthDisc *disc, const double *v, double *y);
  void (*mass_diagonal)(const LthDisc *disc, double *mass);

  /// f += forces at time t, of all kinds but point forces; x is read for followers only. [N]
  LitheStatus (*add_load)(LitheCtx *ctx, const LthDisc *disc, const LthLoad *load, double t,
                          const double *x, double *f);
  void (*add_gravity)(const LthDisc *disc, const double gravity[3], double *f);

  /// Force of each weak constraint on the body (n_weak x 3) [N].
  void (*reactions)(LthDisc *disc, double t, const double *x, double *reaction);
  /// Cauchy stress at a place of a cell: xx yy zz yz zx xy [Pa].
  void (*stress)(const LthDisc *disc, LitheIndex cell, const double *x, const double at[3],
                 double stress[6]);
  /// Memory from step to step (pressures at nu = 0.5); NULL: it has none.
  void (*archive)(LthDisc *disc, LthArchive *archive);
  /// Free the discretisation itself; what it borrows stays.
  void (*destroy)(LitheCtx *ctx, LthDisc *disc);
} LthDiscTable;

struct LthDisc {
  const LthDiscTable *table;
  const LthMesh *
      mesh; ///< polyhedra: the body's geometry, and whose cells the calls above mean; NULL: it has cells
            ///< of its own
  bool is_split; ///< the three components have functions of their own
  /// Not linear, and no fixed point of rotations either: K x - f0 is the slope of energy() where update_rotations() was
  /// last, and K its tangent with negative modes left out, or, where `is_exact` is set by who asks, all of it.
  bool has_tangent, is_exact;
  LitheIndex n_cells;
  LitheIndex n_funcs, n_rows; ///< functions; block rows of the matrix
  LitheCount n_dofs;          ///< 3 n_funcs
  const LitheIndex *row_func; ///< first function of a block row            (n_rows + 1)
  const uint8_t *cell_degree; ///< polynomial degree                        (n_cells)
  LitheIndex n_weak;
  const LthWeakConstraint *weak;
  void *self; ///< of the implementation
};

void lth_disc_destroy(LitheCtx *ctx, LthDisc **disc);

/// Give each component its own copy of n rows of `width` values, in place: row i to 3 i, 3 i + 1, 3 i + 2.
void lth_disc_spread(int n, int width, double *values);

/// f += forces of a load of any kind at time t; x is read for followers only. [N] A point force is shared evenly
/// by the cells that touch its place: on a node of conforming elements it acts on that node alone.
LitheStatus lth_disc_add_load(LitheCtx *ctx, const LthDisc *disc, const LthLoad *load, double t,
                              const double *x, double *f);

/// y = coefficients of e_axis x (the field of x).
void lth_disc_turn(const LthDisc *disc, int axis, const double *x, double *y);

/// Value and gradient (d value_a / d x_b, row-major) of a vector field at a place of a cell.
void lth_disc_sample(const LthDisc *disc, LitheIndex cell, const double *coef, const double x[3],
                     double value[3]);
void lth_disc_sample_gradient(const LthDisc *disc, LitheIndex cell, const double *coef,
                              const double x[3], double gradient[9]);
void lth_disc_mean_gradient(const LthDisc *disc, LitheIndex cell, const double *coef,
                            double gradient[9]);
