/// The open operator, shared by the dg_*.c files of this folder.
#pragma once

#include "base/tensor.h"
#include "disc/dg/dg_operator.h"

#define LTH_DG_MAX_LOWER 20  ///< lth_monomials3(LTH_DG_MAX_DEGREE - 1)
#define LTH_DG_MAX_TRACE 15  ///< lth_monomials2(LTH_DG_MAX_DEGREE)
#define LTH_DG_MAX_LOW 10    ///< lth_monomials2(LTH_DG_MAX_DEGREE - 1)
#define LTH_DG_MAX_TRACE2 45 ///< lth_monomials2(2 LTH_DG_MAX_DEGREE)

/// A penalty density on a jump J of a face: q(J) = iso |J|^2 + sum_s normal[s] (J . R_s n)^2, on the whole
/// jump (`full`) and once more on its part of degree k - 1 in the face, for either side's k (`low`; where
/// both have the same only the first is used; on held faces for k = 1 only, where it is the mean).
/// Units [Pa/m].
typedef struct LthDgPenalty {
  double full_iso, full_normal[2];
  double low_iso[2], low_normal[2][2];
} LthDgPenalty;

/// An inner face. Faces are ordered by (cell[0], cell[1]), so that the faces of a pair are neighbours.
/// Tables, one after the other, n_s = functions of cell[s]:
///   mass[0]  (n_0 x n_0)      int phi+_i phi+_j
///   mass[1]  (n_1 x n_1)      int phi-_i phi-_j
///   mixed    (n_0 x n_1)      -int phi+_i phi-_j           (a product of two jumps)
///   low[0]: the same three of the traces' parts of degree k_0 - 1 in the face
///   low[1]: of degree k_1 - 1, where that differs
///   slope[1] (3 x n_0 x n_1)   int [phi+_i] d_b phi-_j     IP only
///   slope[0] (3 x n_0 x n_1)   int [phi-_j] d_b phi+_i     IP only
typedef struct LthDgFace {
  LitheIndex face;    ///< of the mesh
  LitheIndex cell[2]; ///< owner (+), neighbour (-)
  double normal[3];   ///< out of the owner
  double area;
  double weight[2]; ///< of the sides' tractions, with sum 1
  LthDgPenalty penalty;
  double *table;
} LthDgFace;

/// Where an inner face meets a cell.
typedef struct LthDgSide {
  LitheIndex face; ///< index into LthDgOperator.faces
  int side;        ///< 0: the cell is the owner
} LthDgSide;

/// Coplanar pieces of one hold. Tables in group_data: mass (nb x nb), int phi_i phi_j over the pieces,
/// and rest (nb x 3), int phi_i X. Points of varying data in point_data: x, weight, phi (4 + nb each).
typedef struct LthDgGroup {
  double normal[3], area;
  LthDgPenalty penalty; ///< normal[1] unused
  LitheCount table;
  LitheCount first_point; ///< in doubles
  LitheIndex n_points;
} LthDgGroup;

/// All of one constraint on one cell with the same projector P on the prescribed components. `table` in
/// hold_data starts the sums over its groups, flux (nb x 3 x 3 x nb) and penalty (nb x 3 x 3 x nb), laid
/// out as LthDgOperator.cell_data, unrotated and before the projector. Rollers, of which a curved surface
/// may have one a facet, have none: their matrices are made anew from the one group.
typedef struct LthDgHold {
  LitheIndex cell, constraint;
  LitheIndex first_group, n_groups;
  double P[9];
  bool whole;   ///< P = I: its matrices are part of the cell's, too
  bool roller;  ///< P = n n^T
  bool varying; ///< the data are callbacks
  LitheCount table;
} LthDgHold;

struct LthDgOperator {
  LitheCtx *ctx;
  const LthDgSpace *space;
  LthFlux flux;
  LthPenaltyKind kind;
  double eta;
  const uint8_t *held;
  bool warped, faces_only;
  double *lambda, *mu, *young; ///< per cell [Pa]
  double *rotation;            ///< (n_cells x 9)
  double *rest;                ///< X0 (n_dofs)

  // of each cell, in blocks of the operator or in rooms of a store
  double **slope; ///< d_b phi_j = sum_l slope[b][j][l] phi_l, l below lth_monomials3(k - 1)
  double *
      *cell_data; ///< [i][a][b][j]: element, own flux and whole holds, unrotated; NULL: of the rim
  double *slope_block, *cell_block, *face_block; ///< NULL where a store has them
  double *cell_load;                             ///< own part of f0, unrotated (n_dofs)

  LitheIndex n_faces;
  LthDgFace *faces;
  LitheIndex *own_face_off; ///< (n_cells + 1) faces whose owner is the cell
  LitheIndex *side_off;     ///< (n_cells + 1)
  LthDgSide *sides;

  LthWeakConstraint *weak;
  LitheIndex n_weak, n_holds, n_groups;
  LitheIndex *hold_off; ///< (n_cells + 1)
  LthDgHold *holds;
  LthDgGroup *groups;
  double *hold_data, *group_data, *point_data;

  double *partial; ///< one sum per cell (n_cells)
  double penalty_min, penalty_max;
};

/// Threads of a loop over cells in a step: one where the body is so small that it is done before another wakes
/// (which takes microseconds, and on a busy machine much longer).
static inline int lth_dg_threads(const LthDgOperator *op) {
  return op->space->n_dofs > 3000 ? lth_threads(op->ctx) : 1;
}

static inline int lth_dg_lower(const LthDgSpace *s, LitheIndex cell) {
  return lth_monomials3(s->degree[cell] - 1);
}

static inline const double *lth_dg_slope(const LthDgOperator *op, LitheIndex cell) {
  return op->slope[cell];
}

/// Products of jumps: of the owner's functions, the neighbour's, and one with the other.
typedef struct LthDgJump {
  double *mass[2], *mixed;
} LthDgJump;

/// A face's tables.
typedef struct LthDgFaceTables {
  LthDgJump full, low[2];
  int n_low;
  double *slope[2];
} LthDgFaceTables;

static inline LitheCount lth_dg_face_doubles(const LthDgOperator *op, const LthDgFace *face) {
  LitheCount n0 = lth_dg_funcs(op->space, face->cell[0]),
             n1 = lth_dg_funcs(op->space, face->cell[1]);
  return (n0 == n1 ? 2 : 3) * (n0 * n0 + n1 * n1 + n0 * n1) +
         n0 * n1 * (op->flux == LTH_FLUX_IP ? 6 : 0);
}

static inline LthDgJump lth_dg_jump_tables(int n0, int n1, double *start) {
  return (LthDgJump){{start, start + n0 * n0}, start + n0 * n0 + n1 * n1};
}

static inline LthDgFaceTables lth_dg_face_tables(const LthDgOperator *op, const LthDgFace *face) {
  int n0 = lth_dg_funcs(op->space, face->cell[0]), n1 = lth_dg_funcs(op->space, face->cell[1]);
  int size = n0 * n0 + n1 * n1 + n0 * n1;
  double *start = face->table;
  LthDgFaceTables t = {.n_low = n0 == n1 ? 1 : 2, .full = lth_dg_jump_tables(n0, n1, start)};
  for (int p = 0; p < t.n_low; p++) t.low[p] = lth_dg_jump_tables(n0, n1, start += size);
  t.slope[1] = start + size;
  t.slope[0] = t.slope[1] + 3 * n0 * n1;
  return t;
}

/// M = iso I + sum_s normal[s] n_s n_s^T, n_s = R_s n already rotated.
static inline void lth_dg_penalty_matrix(double iso, const double normal[2], const double n0[3],
                                         const double n1[3], double M[9]) {
  for (int a = 0; a < 3; a++)
    for (int b = 0; b < 3; b++)
      M[3 * a + b] = (a == b ? iso : 0) + normal[0] * n0[a] * n0[b] + normal[1] * n1[a] * n1[b];
}

// dg_element.c

/// Fill op->slope[cell].
void lth_dg_cell_slope(LthDgOperator *op, LitheIndex cell);

/// Fill the matrices of a cell's holds.
void lth_dg_cell_holds(LthDgOperator *op, LitheIndex cell);

/// Fill op->cell_data and op->cell_load of a cell: element, own flux terms and whole holds (filled before).
void lth_dg_cell_matrix(LthDgOperator *op, LitheIndex cell);

/// block[i][a][b][j] += -w (lambda n_a g_b + mu (g_a n_b + delta_ab n.g)), g_ij = int phi_i grad phi_j from
/// the face mass of the cell; n out of the cell (eq. 21, own side).
void lth_dg_add_own_flux(const LthDgOperator *op, LitheIndex cell, double w, const double n[3],
                         const double *mass, double *block);

/// Stress coefficients S[l] (3x3 each) of sigma = sum_l S[l] phi_l for y = R^T x - X0.
void lth_dg_stress_coefficients(const LthDgOperator *op, LitheIndex cell, const double *x,
                                double *S);

// dg_energy.c

/// What the penalty on the jumps of an inner face, and on a hold's distance from its data, holds of the energy [J].
double lth_dg_face_penalty_energy(const LthDgOperator *op, const LthDgFace *face, const double *x);
double lth_dg_hold_penalty_energy(const LthDgOperator *op, const LthDgHold *hold, double t,
                                  const double *x);

// dg_face.c

/// mass += int_piece phi_i phi_j of a cell.
void lth_dg_add_face_mass(const LthDgSpace *space, LitheIndex cell, const LthFaceView *piece,
                          const double centroid[3], double *mass);

/// mean += int_piece phi_i (nb).
void lth_dg_add_face_mean(const LthDgSpace *space, LitheIndex cell, const LthFaceView *piece,
                          const double centroid[3], double *mean);

/// Inner faces in their order and who meets them.
LitheStatus lth_dg_list_faces(LitheCtx *ctx, const LthDgRecords *records, LthDgOperator *op);

/// Tables and penalty of a face; `table` is zero before.
void lth_dg_integrate_face(LthDgOperator *op, LthDgFace *face);

// dg_assemble.c

/// The diagonal block of a cell (3 nb x 3 nb).
void lth_dg_assemble_diagonal(const LthDgOperator *op, LitheIndex cell, double *block);

/// The block of a cell and the neighbour beyond its own face f, with all faces that they share, and its transpose.
/// Returns the first own face with another neighbour.
LitheIndex lth_dg_assemble_pair(const LthDgOperator *op, LitheIndex f, double *block,
                                double *mirror);

/// f0 of a cell (3 nb).
void lth_dg_assemble_cell_load(const LthDgOperator *op, LitheIndex cell, double t, double *f0);

// dg_penalty.c

/// All components of the element move as prescribed.
bool lth_dg_is_rigid(const LthDgOperator *op, LitheIndex cell);

void lth_dg_inner_penalty(const LthDgOperator *op, LthDgFace *face);

/// `hold_area`: all pieces of the hold. `centroid`: of the group.
void lth_dg_boundary_penalty(const LthDgOperator *op, LitheIndex cell, const double centroid[3],
                             double hold_area, LthDgGroup *group);

/// Find the smallest and largest penalty over (lambda + 2 mu) / h.
void lth_dg_measure_penalty(LthDgOperator *op);

// dg_constraint.c

LitheStatus lth_dg_build_holds(LitheCtx *ctx, const LthDgRecords *records, LthDgOperator *op);
void lth_dg_free_holds(LitheCtx *ctx, LthDgOperator *op);

/// int phi_i d over a group (nb x 3) at time t; d is the prescribed displacement, or the prescribed
/// position where `absolute`. `square` (3x3, may be NULL): int d d^T of the displacement.
void lth_dg_group_data(const LthDgOperator *op, const LthDgHold *hold, const LthDgGroup *group,
                       double t, bool absolute, double *moments, double *square);

/// f0 += the part of a hold (nb x 3).
void lth_dg_hold_load(const LthDgOperator *op, const LthDgHold *hold, double t, double *f0);
