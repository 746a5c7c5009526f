/// Penalty coefficients of faces: the sharp local bound, its projected form for linear functions, and
/// eq. (20). Derivations: docs/theory/dg.md, section 3.
#include "disc/dg/dg_priv.h"

/// The bound makes the form positive for any factor above 1.
#define STABILITY 2.0
/// Springs of the BZ form over the stiffness of the material between two centroids: 1 / 51 softer.
#define BZ_STIFFNESS 50.0
/// Smallest distance of a centroid from a face, over 1 / C_K (three times that on a cube).
#define MIN_DISTANCE 0.1

/// Distance from the centroid of a cell to a face's plane, bounded from below; n out of the cell.
static double centroid_distance(const LthDgSpace *space, LitheIndex cell, const double at[3],
                                const double n[3], double sign) {
  const double *c = space->center + 3 * (LitheCount)cell;
  double d = sign * (n[0] * (at[0] - c[0]) + n[1] * (at[1] - c[1]) + n[2] * (at[2] - c[2]));
  return fmax(d, MIN_DISTANCE / space->trace_constant[cell]);
}

/// The stability bound of one side with a trace constant C: by Cauchy-Schwarz in the energy's own inner
/// product the work of the traction on a jump J is held by the energy of the cell and C J.A J, where A =
/// mu I + (lambda + mu) n n^T is the acoustic tensor. Any Poisson's ratio; lambda meets J.n alone.
static void add_bound(const LthDgOperator *op, LitheIndex cell, double C, double *iso,
                      double *normal) {
  *iso += STABILITY * C * op->mu[cell];
  *normal += STABILITY * C * (op->lambda[cell] + op->mu[cell]);
}

/// Springs in series between two centroids (d[1] = 0: one side only): E along n, mu across it; or
/// lambda + 2 mu along n where `confined`.
static void series_springs(const LthDgOperator *op, const LitheIndex cell[2], const double d[2],
                           bool confined, double *along, double *across) {
  double soft_along = 0, soft_across = 0;
  for (int s = 0; s < 2; s++) {
    if (!(d[s] > 0)) continue;
    double mu = op->mu[cell[s]], lambda = op->lambda[cell[s]];
    soft_along += d[s] / (confined ? lambda + 2 * mu : op->young[cell[s]]);
    soft_across += d[s] / mu;
  }
  *along = 1 / soft_along;
  *across = 1 / soft_across;
}

/// Put `iso`, `normal` on the mean jump and springs on the rest where `projected`, else on all of it.
static void set_penalty(LthDgPenalty *p, bool projected, double iso, const double normal[2],
                        double along, double across, const double share[2]) {
  if (!projected) {
    *p = (LthDgPenalty){.full_iso = iso, .full_normal = {normal[0], normal[1]}};
    return;
  }
  p->full_iso = across;
  p->low_iso = iso - across;
  for (int s = 0; s < 2; s++) {
    p->full_normal[s] = share[s] * (along - across);
    p->low_normal[s] = normal[s] - p->full_normal[s];
  }
}

/// Higher degrees: the stress meets the part of degree k - 1 of the jump only, so that lambda, which
/// would make the rest rigid near nu = 1/2, is spent on that part alone.
static void relax_normal(const LthDgOperator *op, LthDgFace *face, double iso,
                         const double normal[2]) {
  face->penalty = (LthDgPenalty){.full_iso = iso};
  for (int s = 0; s < 2; s++) {
    double lambda = op->lambda[face->cell[s]], mu = op->mu[face->cell[s]];
    face->penalty.full_normal[s] = normal[s] * mu / (lambda + mu);
    face->penalty.low_normal[s] = normal[s] - face->penalty.full_normal[s];
  }
}

static double eta_modulus(const LthDgOperator *op, LitheIndex cell) {
  return op->kind == LTH_PENALTY_ETA ? op->lambda[cell] + 2 * op->mu[cell] : 1;
}

void lth_dg_inner_penalty(const LthDgOperator *op, LthDgFace *face) {
  const LthDgSpace *space = op->space;
  const double *at = space->mesh->face_centroid + 3 * (LitheCount)face->face;
  static const double half[2] = {0.5, 0.5};
  if (op->kind != LTH_PENALTY_AUTO) {
    double eta = 0;
    for (int s = 0; s < 2; s++)
      eta += op->eta * face->area * eta_modulus(op, face->cell[s]) /
             space->mesh->cell_volume[face->cell[s]];
    face->penalty = (LthDgPenalty){.full_iso = eta};
    return;
  }

  double d[2], along, across, iso = 0, normal[2] = {0, 0};
  for (int s = 0; s < 2; s++)
    d[s] = centroid_distance(space, face->cell[s], at, face->normal, s == 0 ? 1 : -1);
  bool linear = space->degree[face->cell[0]] == 1 && space->degree[face->cell[1]] == 1;
  if (op->flux == LTH_FLUX_IP) {
    for (int s = 0; s < 2; s++)
      add_bound(op, face->cell[s], space->trace_constant[face->cell[s]] / 4, &iso, &normal[s]);
  } else {
    series_springs(op, face->cell, d, true, &along, &across);
    iso = BZ_STIFFNESS * across;
    for (int s = 0; s < 2; s++) normal[s] = 0.5 * BZ_STIFFNESS * (along - across);
  }
  if (op->flux == LTH_FLUX_IP && !linear) {
    relax_normal(op, face, iso, normal);
    return;
  }
  series_springs(op, face->cell, d, false, &along, &across);
  set_penalty(&face->penalty, linear, iso, normal, along, across, half);
}

void lth_dg_boundary_penalty(const LthDgOperator *op, LitheIndex cell, const double centroid[3],
                             double hold_area, LthDgGroup *group) {
  const LthDgSpace *space = op->space;
  static const double one[2] = {1, 0};
  if (op->kind != LTH_PENALTY_AUTO) {
    group->penalty = (LthDgPenalty){.full_iso = op->eta * hold_area * eta_modulus(op, cell) * 4 /
                                                space->mesh->cell_volume[cell]};
    return;
  }
  double d[2] = {centroid_distance(space, cell, centroid, group->normal, 1), 0};
  LitheIndex cells[2] = {cell, cell};
  double along, across, iso = 0, normal[2] = {0, 0};
  if (op->flux == LTH_FLUX_IP) {
    add_bound(op, cell, space->trace_constant[cell], &iso, &normal[0]);
  } else {
    series_springs(op, cells, d, true, &along, &across);
    iso = BZ_STIFFNESS * across;
    normal[0] = BZ_STIFFNESS * (along - across);
  }
  series_springs(op, cells, d, false, &along, &across);
  set_penalty(&group->penalty, space->degree[cell] == 1, iso, normal, along, across, one);
}

/// Stiffness against a normal jump, over (lambda + 2 mu) / h.
static double normal_scale(const LthDgOperator *op, const LthDgPenalty *p, LitheIndex cell,
                           double h) {
  double stiffness = p->full_iso + p->full_normal[0] + p->full_normal[1] + p->low_iso +
                     p->low_normal[0] + p->low_normal[1];
  return stiffness * h / (op->lambda[cell] + 2 * op->mu[cell]);
}

static void widen(LthDgOperator *op, double scale) {
  op->penalty_min = fmin(op->penalty_min, scale);
  op->penalty_max = fmax(op->penalty_max, scale);
}

void lth_dg_measure_penalty(LthDgOperator *op) {
  const LthDgSpace *space = op->space;
  op->penalty_min = INFINITY, op->penalty_max = 0;
  for (LitheIndex f = 0; f < op->n_faces; f++) {
    const LthDgFace *face = &op->faces[f];
    const double *at = space->mesh->face_centroid + 3 * (LitheCount)face->face;
    double h = centroid_distance(space, face->cell[0], at, face->normal, 1) +
               centroid_distance(space, face->cell[1], at, face->normal, -1);
    for (int s = 0; s < 2; s++) widen(op, normal_scale(op, &face->penalty, face->cell[s], h));
  }
  for (LitheIndex i = 0; i < op->n_holds; i++) {
    const LthDgHold *hold = &op->holds[i];
    for (LitheIndex g = 0; g < hold->n_groups; g++) {
      const LthDgGroup *group = &op->groups[hold->first_group + g];
      // twice the mean distance of the centroid is 6 / C on a cube
      double h = 6 / space->trace_constant[hold->cell];
      widen(op, normal_scale(op, &group->penalty, hold->cell, h));
    }
  }
  if (op->penalty_max == 0) op->penalty_min = 0;
}

void lth_dg_penalty_range(const LthDgOperator *op, double *min, double *max) {
  *min = op->penalty_min;
  *max = op->penalty_max;
}
