/// Penalty coefficients of faces: the sharp local bound, its projected form for linear functions, and
/// eq. (20). Derivations: docs/theory/dg.md, section 3.
#include "disc/dg/dg_priv.h"

/// The bound makes the form positive for any factor above 1.
#define STABILITY 2.0
/// Springs of the BZ form over the stiffness of the material between two centroids: 1 / 51 softer.
#define BZ_STIFFNESS 50.0
/// How much rather the traction is taken from linear functions than from higher ones beside them.
#define LINEAR_PREFERENCE 100.0
/// Smallest distance of a centroid from a face, over 1 / C_K (three times that on a cube).
#define MIN_DISTANCE 0.1

/// Distance from the centroid of a cell to a face's plane, bounded from below; n out of the cell.
static double centroid_distance(const LthDgSpace *space, LitheIndex cell, const double at[3],
                                const double n[3], double sign) {
  const double *c = space->center + 3 * (LitheCount)cell;
  double d = sign * (n[0] * (at[0] - c[0]) + n[1] * (at[1] - c[1]) + n[2] * (at[2] - c[2]));
  return fmax(d, MIN_DISTANCE / space->trace_constant[cell]);
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

/// Put springs on all of the jump but its mean, which is part q.
static void add_springs(LthDgPenalty *p, int q, double along, double across,
                        const double share[2]) {
  p->full_iso += across;
  p->low_iso[q] -= across;
  for (int s = 0; s < 2; s++) {
    p->full_normal[s] += share[s] * (along - across);
    p->low_normal[q][s] -= share[s] * (along - across);
  }
}

static double eta_modulus(const LthDgOperator *op, LitheIndex cell) {
  return op->kind == LTH_PENALTY_ETA ? op->lambda[cell] + 2 * op->mu[cell] : 1;
}

/// Eq. (20) of the paper.
static void set_eta(const LthDgOperator *op, LthDgFace *face) {
  double eta = 0;
  for (int s = 0; s < 2; s++)
    eta += op->eta * face->area * eta_modulus(op, face->cell[s]) /
           op->space->mesh->cell_volume[face->cell[s]];
  face->penalty = (LthDgPenalty){.full_iso = eta};
}

/// BZ: springs much stiffer than the material, on the mean jump of linear functions, else on all of it.
static void set_stiff_springs(const LthDgOperator *op, const LitheIndex cell[2], const double d[2],
                              bool linear, const double share[2], LthDgPenalty *p) {
  double along, across;
  series_springs(op, cell, d, true, &along, &across);
  double iso = BZ_STIFFNESS * across, normal = BZ_STIFFNESS * (along - across);
  if (linear) {
    p->low_iso[0] = iso;
    for (int s = 0; s < 2; s++) p->low_normal[0][s] = share[s] * normal;
  } else {
    p->full_iso = iso;
    for (int s = 0; s < 2; s++) p->full_normal[s] = share[s] * normal;
  }
}

/// The bound of one side where its stress needs it: on the mean jump for k = 1; for higher degrees lambda,
/// which would make the rest rigid near nu = 1/2, on the part of degree k - 1 and mu on all of the jump.
static void add_side(const LthDgOperator *op, const LthDgFace *face, int s, int q,
                     LthDgPenalty *p) {
  LitheIndex cell = face->cell[s];
  double C = STABILITY * face->weight[s] * face->weight[s] * op->space->trace_constant[cell];
  double mu = C * op->mu[cell], lambda = C * op->lambda[cell];
  bool linear = op->space->degree[cell] == 1;
  *(linear ? &p->low_iso[q] : &p->full_iso) += mu;
  *(linear ? &p->low_normal[q][s] : &p->full_normal[s]) += mu;
  p->low_normal[q][s] += lambda;
}

static bool is_linear(const LthDgOperator *op, const LthDgFace *face, int s) {
  return op->space->degree[face->cell[s]] == 1;
}

bool lth_dg_is_rigid(const LthDgOperator *op, LitheIndex cell) {
  const uint8_t *held = op->held ? op->held + 3 * (LitheCount)op->space->func_off[cell] : NULL;
  return held && held[0] && held[1] && held[2];
}

/// The side that alone carries the traction, as at a boundary: its neighbour is held and has no stress to share. Or -1.
static int free_side(const LthDgOperator *op, const LthDgFace *face) {
  bool rigid[2] = {lth_dg_is_rigid(op, face->cell[0]), lth_dg_is_rigid(op, face->cell[1])};
  return rigid[0] == rigid[1] ? -1 : rigid[0];
}

/// Weights of the tractions: more for the side whose bound is lower, so that a thin or stiff element does not
/// make the face rigid. Beside higher degrees linear functions carry nearly all of it: the bound of the other
/// side would hold more than their mean jump, and they could not hinge.
static void set_weights(const LthDgOperator *op, LthDgFace *face) {
  double D[2];
  face->weight[0] = face->weight[1] = 0.5;
  if (op->kind != LTH_PENALTY_AUTO || op->flux == LTH_FLUX_BZ) return;
  int only = free_side(op, face);
  for (int s = 0; s < 2 && only >= 0; s++) face->weight[s] = s == only;
  if (only >= 0) return;
  for (int s = 0; s < 2; s++) {
    LitheIndex cell = face->cell[s];
    D[s] = op->space->trace_constant[cell] * (op->lambda[cell] + 2 * op->mu[cell]);
    if (!is_linear(op, face, s) && is_linear(op, face, 1 - s)) D[s] *= LINEAR_PREFERENCE;
  }
  for (int s = 0; s < 2; s++) face->weight[s] = D[1 - s] / (D[0] + D[1]);
}

/// Springs of a face whose side s alone is linear: half of (10), in series with the other side's bound.
static void hinge_springs(const LthDgOperator *op, const LthDgFace *face, int s, double d,
                          double *along, double *across) {
  LitheIndex linear = face->cell[s], other = face->cell[1 - s];
  double bound = STABILITY * op->space->trace_constant[other] * op->mu[other];
  *along = 1 / (d / op->young[linear] + 0.5 / bound);
  *across = 1 / (d / op->mu[linear] + 1 / bound);
}

static void set_bound(const LthDgOperator *op, const double d[2], LthDgFace *face) {
  static const double half[2] = {0.5, 0.5};
  double along, across;
  bool linear[2] = {is_linear(op, face, 0), is_linear(op, face, 1)};
  bool same = op->space->degree[face->cell[0]] == op->space->degree[face->cell[1]];
  int only = free_side(op, face);
  for (int s = 0; s < 2; s++) add_side(op, face, s, same ? 0 : s, &face->penalty);
  if (only >= 0 ? !linear[only] : !linear[0] && !linear[1]) return;
  if (only >= 0) {
    const double own[2] = {only == 0 ? d[0] : 0, only == 1 ? d[1] : 0};
    series_springs(op, face->cell, own, false, &along, &across);
    add_springs(&face->penalty, same ? 0 : only, along, across, half);
    return;
  }
  if (linear[0] && linear[1])
    series_springs(op, face->cell, d, false, &along, &across);
  else
    hinge_springs(op, face, linear[1], d[linear[1]], &along, &across);
  add_springs(&face->penalty, linear[0] ? 0 : 1, along, across, half);
}

void lth_dg_inner_penalty(const LthDgOperator *op, LthDgFace *face) {
  const double *at = op->space->mesh->face_centroid + 3 * (LitheCount)face->face;
  static const double half[2] = {0.5, 0.5};
  LthDgPenalty *p = &face->penalty;
  *p = (LthDgPenalty){0};
  set_weights(op, face);
  if (op->kind != LTH_PENALTY_AUTO) {
    set_eta(op, face);
    return;
  }
  double d[2], along, across;
  for (int s = 0; s < 2; s++)
    d[s] = centroid_distance(op->space, face->cell[s], at, face->normal, s == 0 ? 1 : -1);
  if (op->flux == LTH_FLUX_IP) {
    set_bound(op, d, face);
    return;
  }
  bool linear = is_linear(op, face, 0) && is_linear(op, face, 1);
  set_stiff_springs(op, face->cell, d, linear, half, p);
  if (!linear) return;
  series_springs(op, face->cell, d, false, &along, &across);
  add_springs(p, 0, along, across, half);
}

void lth_dg_boundary_penalty(const LthDgOperator *op, LitheIndex cell, const double centroid[3],
                             double hold_area, LthDgGroup *group) {
  const LthDgSpace *space = op->space;
  static const double one[2] = {1, 0};
  LthDgPenalty *p = &group->penalty;
  *p = (LthDgPenalty){0};
  if (op->kind != LTH_PENALTY_AUTO) {
    p->full_iso = op->eta * hold_area * eta_modulus(op, cell) * 4 / space->mesh->cell_volume[cell];
    return;
  }
  double d[2] = {centroid_distance(space, cell, centroid, group->normal, 1), 0};
  LitheIndex cells[2] = {cell, cell};
  bool linear = space->degree[cell] == 1;
  double along, across, C = STABILITY * space->trace_constant[cell];
  if (op->flux == LTH_FLUX_BZ) {
    set_stiff_springs(op, cells, d, linear, one, p);
  } else {
    *(linear ? &p->low_iso[0] : &p->full_iso) = C * op->mu[cell];
    *(linear ? &p->low_normal[0][0] : &p->full_normal[0]) = C * (op->lambda[cell] + op->mu[cell]);
  }
  if (!linear) return;
  series_springs(op, cells, d, false, &along, &across);
  add_springs(p, 0, along, across, one);
}

/// Stiffness against a normal jump, over (lambda + 2 mu) / h.
static double normal_scale(const LthDgOperator *op, const LthDgPenalty *p, LitheIndex cell,
                           double h) {
  double stiffness = p->full_iso + p->full_normal[0] + p->full_normal[1];
  for (int q = 0; q < 2; q++)
    stiffness += p->low_iso[q] + p->low_normal[q][0] + p->low_normal[q][1];
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
