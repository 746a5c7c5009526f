/// What is measured in every element: stress, turn, error.
#include "scene/adapt.h"

#include "base/eigen.h"
#include "base/tensor.h"
#include "material/rotation.h"

#include <math.h>

/// Principal stresses of a cell at its centroid, ascending, and their directions (columns).
static void principal(const LthBody *body, LitheIndex cell, double value[3], double vector[9]) {
  double s[6];
  body->disc->table->stress(body->disc, cell, lth_body_position(body),
                            body->mesh->cell_centroid + 3 * (LitheCount)cell, s);
  double A[9] = {s[0], s[5], s[4], s[5], s[1], s[3], s[4], s[3], s[2]};
  lth_symmetric_eigen(3, A, value, vector);
}

/// Nearest rotation to the mean gradient, also of bodies that are not warped.
static void turn_of(const LthBody *body, LitheIndex cell, double R[9]) {
  double F[9];
  lth_dg_mean_gradient(body->space, cell, lth_body_position(body), F);
  lth_rotation_nearest(F, R);
}

void lth_adapt_normal(const LthBody *body, LitheIndex cell, double normal[3]) {
  double value[3], vector[9], R[9], d[3] = {0};
  principal(body, cell, value, vector);
  int k = fabs(value[0]) > fabs(value[2]) ? 0 : 2;
  if (fabs(value[k]) > 0) {
    for (int a = 0; a < 3; a++) d[a] = vector[3 * a + k];
    turn_of(body, cell, R); // stress is that of the deformed state
    lth_m3_apply_t(R, d, normal);
    lth_v3_normalize(normal);
    return;
  }
  const double *box = body->mesh->cell_box + 6 * (LitheCount)cell;
  double edge[3] = {box[3] - box[0], box[4] - box[1], box[5] - box[2]};
  d[edge[1] > edge[0] ? (edge[2] > edge[1] ? 2 : 1) : edge[2] > edge[0] ? 2 : 0] = 1;
  lth_v3_copy(d, normal);
}

static void measure_stress(LitheCtx *ctx, const LthBody *body, double *value) {
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheIndex c = 0; c < body->mesh->n_cells; c++) {
    double s[3], vector[9];
    principal(body, c, s, vector);
    value[c] = fmax(fabs(s[0]), fabs(s[2]));
  }
}

/// Angle of A^T B [rad]: |A - B|^2 = 8 sin^2(angle / 2), which keeps small angles.
static double angle_between(const double A[9], const double B[9]) {
  double sum = 0;
  for (int i = 0; i < 9; i++) sum += (A[i] - B[i]) * (A[i] - B[i]);
  return 2 * asin(fmin(sqrt(sum / 8), 1));
}

static LitheStatus measure_turn(LitheCtx *ctx, const LthBody *body, double *value) {
  const LthMesh *mesh = body->mesh;
  double *R;
  LTH_NEW(ctx, R, 9 * (LitheCount)mesh->n_cells);
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheIndex c = 0; c < mesh->n_cells; c++) turn_of(body, c, R + 9 * (LitheCount)c);
  for (LitheIndex c = 0; c < mesh->n_cells; c++) value[c] = 0;
  for (LitheIndex f = 0; f < mesh->n_faces; f++) {
    LitheIndex a = mesh->face_cell[2 * f], b = mesh->face_cell[2 * f + 1];
    if (b < 0) continue;
    double angle = angle_between(R + 9 * (LitheCount)a, R + 9 * (LitheCount)b);
    value[a] = fmax(value[a], angle);
    value[b] = fmax(value[b], angle);
  }
  lth_free(ctx, R);
  return LITHE_OK;
}

/// eta_K sqrt(N) over the energy norm: an element with value e has its share of a relative error e.
static LitheStatus measure_error(LitheCtx *ctx, LthBody *body, LthAdaptBody *state,
                                 const double *acceleration, double *value) {
  LitheIndex n = body->mesh->n_cells;
  double t = lth_simulation_time(body->sim), *parts, sum = 0;
  const double *x = lth_body_position(body);
  LthDgEstimateDef def = {.op = body->op,
                          .x = x,
                          .t = t,
                          .loads = body->loads,
                          .n_loads = body->n_loads,
                          .density = body->density,
                          .acceleration = acceleration};
  lth_v3_copy(body->scene->gravity, def.gravity);
  LTH_NEW(ctx, parts, LTH_ESTIMATE_PARTS * (LitheCount)n);
  LitheStatus status = lth_dg_estimate(ctx, &def, parts);
  for (LitheIndex c = 0; c < n; c++) sum += value[c] = lth_dg_estimate_sum(parts, c);
  lth_free(ctx, parts);
  LITHE_TRY(status);
  state->scale = fmax(state->scale, 2 * lth_dg_energy(body->op, t, x));
  double whole = state->scale + sum;
  for (LitheIndex c = 0; c < n; c++) value[c] = whole > 0 ? sqrt(value[c] * n / whole) : 0;
  return LITHE_OK;
}

LitheStatus lth_adapt_measure(LitheCtx *ctx, LthBody *body, LthAdaptBody *state,
                              LthCriterion criterion, const double *acceleration, double *value) {
  switch (criterion) {
  case LTH_BY_STRESS:
    measure_stress(ctx, body, value);
    return LITHE_OK;
  case LTH_BY_TURN:
    return measure_turn(ctx, body, value);
  case LTH_BY_ERROR:
    return measure_error(ctx, body, state, acceleration, value);
  }
  return LITHE_OK;
}
