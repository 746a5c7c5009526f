/// The open conforming discretisation, shared by the cg_*.c files of this folder.
#pragma once

#include "base/tensor.h"
#include "disc/cg/cg_disc.h"
#include "disc/cg/cg_shape.h"

#define LTH_CG_MAX LTH_ELEMENT_MAX_NODES

/// Integrals of one shape of element, in its tables one after the other (n nodes):
///   stiffness (n x 9 x n)  [i][a][b][j]: int d_a phi_i d_b phi_j
///   mean      (n x 3)      int grad phi_i, by the same rule
///   mass      (n x n)      int phi_i phi_j
///   load      (n)          int phi_i
///   lumped    (n)          the diagonal of the mass, scaled to the whole of it
/// Elements that differ by a translation share them.
typedef struct LthCgClass {
  LitheIndex element; ///< the first of its kind
  LitheCount table;
  double volume;       ///< by the rule of the stiffness [m^3]
  double volume_exact; ///< by that of the mass [m^3]
  bool affine;         ///< the map from the reference element is
  double origin[3];    ///< image of the reference centre less node 0, where affine
  double inverse[9];   ///< of the map's gradient, where affine
} LthCgClass;

/// Where a boundary face of the mesh lies in its element: corners of one of its faces.
typedef struct LthCgFace {
  int8_t n_corners; ///< 0: it is no face of an element
  int8_t corner[4];
  int8_t face;
} LthCgFace;

/// A place on the boundary with all that integrals there need.
typedef struct LthCgPoint {
  LitheIndex element, cell, patch;
  double at[3];
  double normal[3], weight; ///< outward; [m^2], negative on some parts of non-convex pieces
  double phi[LTH_CG_MAX], dphi[3 * LTH_CG_MAX]; ///< by local node
} LthCgPoint;

/// A weakly held place: phi (n), grad phi (n x 3) stand in hold_data.
typedef struct LthCgHold {
  LitheIndex constraint;
  double at[3], normal[3], weight; ///< weight [m^2]
  double lambda, mu;               ///< of the cell [Pa]
  double iso, stiff;               ///< penalty iso I + stiff R n (R n)^T [Pa/m]
  double P[9];                     ///< projector on what is held
  LitheCount table;
} LthCgHold;

typedef struct LthCgDisc {
  LthDisc disc;
  LitheCtx *ctx;
  const LthElementMesh *elements;
  const LitheIndex *cell_element; ///< or NULL
  bool warped;
  LthCgKind kind[LTH_ELEMENT_KINDS];
  LthCgPlaneRule plane[2][2];    ///< by degree - 1; triangle, square
  LthCgPlaneRule small[2];       ///< of triangles much smaller than their element: 1 and 4 points
  double *cell_lambda, *cell_mu; ///< (n_cells)
  double *lambda, *mu, *density; ///< what an element counts with           (n_elements)
  double *fill;                  ///< filled fraction                       (n_elements)
  double extent;                 ///< diagonal of the body's box [m]
  double *rotation;              ///< (n_elements x 9)

  LthCgClass *classes;
  LitheIndex n_classes;
  LitheIndex *class_of; ///< (n_elements)
  uint8_t *exact;       ///< stiffness by the rule of the mass              (n_elements)
  double *tables;

  // rows: the elements of a node, in ascending order, and its place in each
  LitheIndex *node_off, *node_element; ///< (n_nodes + 1)
  uint8_t *node_local;
  LitheCount *block_off; ///< pattern of the matrix                         (n_nodes + 1)
  LitheIndex *block_col;
  LitheCount *slot_off; ///< (n_elements + 1)
  uint16_t *slot;       ///< place of column j in row i, [i][j] per element

  uint8_t *order;  ///< local nodes of an element by ascending node          (element_off[n])
  LthCgFace *face; ///< (mesh->n_faces)
  LitheIndex *row_func;
  uint8_t *degree;
  LthWeakConstraint *weak;
  LitheIndex *hold_off; ///< (n_elements + 1)
  LthCgHold *holds;
  LitheIndex n_holds;
  double *hold_data;
  LitheCount *hold_matrix_off; ///< (n_elements + 1) into hold_matrix
  double *hold_matrix;         ///< scratch: rows [i][a][b][j] of all holds of an element
  double *hold_load;           ///< scratch: [i][a] per element, where element_node has i
  double *partial;             ///< (n_elements)
} LthCgDisc;

static inline const LthCgDisc *lth_cg_of(const LthDisc *disc) { return disc->self; }

static inline LitheIndex lth_cg_element(const LthCgDisc *d, LitheIndex cell) {
  return d->cell_element ? d->cell_element[cell] : cell;
}

static inline const LthCgKind *lth_cg_kind(const LthCgDisc *d, LitheIndex e) {
  return &d->kind[d->elements->kind[e]];
}

static inline const LitheIndex *lth_cg_nodes(const LthCgDisc *d, LitheIndex e) {
  return d->elements->element_node + d->elements->element_off[e];
}

static inline const double *lth_cg_node(const LthCgDisc *d, LitheIndex node) {
  return d->elements->nodes + 3 * (LitheCount)node;
}

/// Starts of an element's tables.
typedef struct LthCgTables {
  double *stiffness, *mean, *mass, *load, *lumped;
} LthCgTables;

static inline LitheCount lth_cg_table_doubles(LitheCount n) { return 10 * n * n + 5 * n; }

static inline LthCgTables lth_cg_tables(const LthCgDisc *d, LitheIndex class_index) {
  const LthCgClass *c = &d->classes[class_index];
  LitheCount n = lth_cg_kind(d, c->element)->n;
  LthCgTables t = {.stiffness = d->tables + c->table};
  t.mean = t.stiffness + 9 * n * n;
  t.mass = t.mean + 3 * n;
  t.load = t.mass + n * n;
  t.lumped = t.load + n;
  return t;
}

/// Threads of a loop over elements in a step: one where the body is so small that it is done before another
/// wakes.
static inline int lth_cg_threads(const LthCgDisc *d) {
  return d->elements->n_elements > 500 ? lth_threads(d->ctx) : 1;
}

// cg_class.c

/// Find the classes and fill their tables. LITHE_BAD_INPUT names an inverted element.
LitheStatus lth_cg_build_classes(LitheCtx *ctx, LthCgDisc *d);

// cg_place.c

/// Place X, its gradient J[a][b] = dX_a / dxi_b, and the functions at xi.
void lth_cg_map(const LthCgDisc *d, LitheIndex element, const double xi[3], double X[3],
                double J[9], double *phi, double *dphi);

/// dphi: from gradients in xi to gradients in space, by J; returns det J.
double lth_cg_space_gradients(int n, const double J[9], double *dphi);

/// Functions and gradients by local node at x: those of the nearest place of the element, carried on linearly.
void lth_cg_eval_local(const LthCgDisc *d, LitheIndex element, const double x[3], double *phi,
                       double *dphi);

int lth_cg_eval(const LthDisc *disc, LitheIndex cell, const double x[3], LitheIndex *func,
                double *phi);
int lth_cg_eval_gradient(const LthDisc *disc, LitheIndex cell, const double x[3], LitheIndex *func,
                         double *dphi);
int lth_cg_mean_gradient(const LthDisc *disc, LitheIndex cell, LitheIndex *func, double *dphi);

// cg_rows.c

/// Who is at a node, the pattern, and the places of blocks in it.
LitheStatus lth_cg_build_rows(LitheCtx *ctx, LthCgDisc *d);
LitheStatus lth_cg_matrix_create(LitheCtx *ctx, const LthDisc *disc, LthBlockMatrix **K);

// cg_assemble.c

void lth_cg_update_rotations(LthDisc *disc, const double *x);
void lth_cg_assemble(LthDisc *disc, double t, LthBlockMatrix *K, double *f0);
void lth_cg_assemble_load(LthDisc *disc, double t, double *f0);
void lth_cg_add_mass(const LthDisc *disc, double c, LthBlockMatrix *K);
void lth_cg_apply_mass(const LthDisc *disc, const double *v, double *y);
void lth_cg_mass_diagonal(const LthDisc *disc, double *mass);

// cg_energy.c

double lth_cg_energy(LthDisc *disc, double t, const double *x);
void lth_cg_reactions(LthDisc *disc, double t, const double *x, double *reaction);
void lth_cg_stress(const LthDisc *disc, LitheIndex cell, const double *x, const double at[3],
                   double stress[6]);

// cg_boundary.c

/// Measure the body, and find the element face behind every boundary face of the mesh.
LitheStatus lth_cg_build_faces(LitheCtx *ctx, LthCgDisc *d);

/// True where piece i is a whole boundary face that is one, or half of one, of an element.
bool lth_cg_patch_is_whole(const LthCgDisc *d, const LthPatches *patches, LitheIndex i);

/// Visit the points of a rule on piece i: on the curved face of the element where the piece is a whole one,
/// else on the planar piece.
void lth_cg_visit_patch(const LthCgDisc *d, const LthPatches *patches, LitheIndex i,
                        void (*visit)(void *self, const LthCgPoint *point), void *self);

// cg_load.c

LitheStatus lth_cg_add_load(LitheCtx *ctx, const LthDisc *disc, const LthLoad *load, double t,
                            const double *x, double *f);
void lth_cg_add_gravity(const LthDisc *disc, const double gravity[3], double *f);

// cg_hold.c

/// Mark elements that a weak constraint touches: their stiffness takes the rule of the mass, which the
/// penalty relies on.
void lth_cg_find_held(LthCgDisc *d);

/// Points of all weak constraints, by element, and their penalties.
LitheStatus lth_cg_build_holds(LitheCtx *ctx, LthCgDisc *d);

/// Sum up the terms of all holds in hold_load and, where `matrix`, in hold_matrix, with the rotations as they stand
/// and values of time t.
void lth_cg_sum_holds(const LthCgDisc *d, double t, bool matrix);

/// What the constraint prescribes at a hold: displacement.
void lth_cg_hold_data(const LthCgDisc *d, const LthCgHold *hold, double t, double value[3]);
