/// After a solve: the active set and Coulomb's limit, and what both make of each point's equations.
#include "base/tensor.h"
#include "embed/contact_priv.h"

#define ROUNDS_MAX 6          ///< solves of one step
#define FRICTION_ROUNDS_MAX 3 ///< of them for friction alone
#define FORCE_CHANGE 0.02     ///< of all normal forces: smaller changes need no new solve
#define FRICTION_CHANGE 0.1   ///< of all friction limits

static void add_outer(double s, const double a[3], double D[9]) {
  for (int i = 0; i < 9; i++) D[i] += s * a[i / 3] * a[i % 3];
}

/// The tangent of a spring at its limit, which keeps its force and turns: near an equilibrium the secant of (3) would
/// hold back what slides, far from one it keeps steps from going too far.
static void linearize_sliding(LthTouch *touch, double acts, double dt) {
  double along[3], gone[3];
  if (!(touch->spring < touch->stiffness)) return;
  lth_v3_copy(touch->trial, along);
  lth_v3_normalize(along);
  lth_v3_sub(touch->trial, touch->offset, gone);
  add_outer(-acts * dt * touch->spring, along, touch->D);
  lth_v3_axpy(-acts * touch->spring * lth_v3_dot(along, gone), along, touch->r);
}

void lth_touch_linearize(const LthContact *c, LthTouch *touch) {
  const double dt = c->dt, acts = c->weight * dt, k = touch->stiffness, damping = c->damping * k;
  const double *n = touch->normal;
  memset(touch->D, 0, sizeof touch->D);
  memset(touch->r, 0, sizeof touch->r);
  add_outer(acts * (dt * k + damping), n, touch->D);
  lth_v3_axpy(acts * (damping * lth_v3_dot(n, touch->velocity) - k * touch->gap), n, touch->r);
  if (!(c->friction > 0)) return;

  for (int i = 0; i < 3; i++) touch->D[4 * i] += acts * dt * touch->spring;
  add_outer(-acts * dt * touch->spring, n, touch->D);
  lth_v3_axpy(-acts * touch->spring, touch->offset, touch->r);
  if (c->look == LTH_LOOK_NEAR) linearize_sliding(touch, acts, dt);
}

void lth_touch_stretch(const LthContact *c, LthTouch *touch, const double v[3]) {
  lth_v3_copy(touch->offset, touch->trial);
  lth_v3_axpy(c->dt, v, touch->trial);
  lth_v3_axpy(-c->dt * lth_v3_dot(v, touch->normal), touch->normal, touch->trial);
  double stretch = lth_v3_norm(touch->trial);
  touch->spring = touch->stiffness;
  if (touch->stiffness * stretch > touch->limit) touch->spring = touch->limit / stretch;
}

/// Normal force that the last solve means at a point, equation (1).
static double normal_force(const LthContact *c, LthTouch *touch, const double v[3]) {
  double closing = lth_v3_dot(touch->normal, v) - lth_v3_dot(touch->normal, touch->velocity);
  touch->gap_end = touch->gap + c->dt * lth_v3_dot(touch->normal, v);
  return -touch->stiffness * touch->gap_end - c->damping * touch->stiffness * closing;
}

/// Revise one point; returns by how much its normal force and its friction in the last solve missed what
/// they should be [N].
static void revise_touch(const LthContact *c, LthTouch *touch, double missed[2]) {
  double v[3], force, spring = touch->spring;
  lth_touch_value(c, touch, v);
  force = normal_force(c, touch, v);
  bool was_active = touch->active;
  touch->active = force > 0 && (was_active || !c->drops);
  touch->force_n = fmax(force, 0);
  touch->limit = c->friction * touch->force_n;
  lth_touch_stretch(c, touch, v);
  lth_touch_account(c, was_active, spring, touch);
  missed[0] = was_active != touch->active ? fabs(force) : 0;
  missed[1] =
      was_active && touch->active ? fabs(touch->spring - spring) * lth_v3_norm(touch->trial) : 0;
  lth_touch_linearize(c, touch);
}

// A step is solved again where the forces that were missed are worth it as a whole: a few points at the
// rim of a resting patch always come and go.
bool lth_contact_revise(LthContact *c, const double *v1) {
  double missed[2] = {0, 0};
  const LitheIndex n_before = c->n_active;
  c->n_acted = n_before;
  c->penetration = 0, c->force = 0;
  for (int s = 0; s < c->n_sides; s++)
    lth_embedding_sample(c->side[s].points, 1, v1 + c->side[s].first_dof, c->side[s].sample_value);
  for (LitheIndex i = 0; i < c->n_touch; i++) {
    LthTouch *touch = &c->touch[i];
    double of_touch[2];
    revise_touch(c, touch, of_touch);
    missed[0] += of_touch[0];
    missed[1] += of_touch[1];
    if (touch->active || touch->slack > 0)
      c->penetration = fmax(c->penetration, touch->slack - touch->gap_end);
    if (touch->active) c->force += touch->force_n;
  }
  lth_contact_index(c);
  bool again = missed[0] > FORCE_CHANGE * c->force || (n_before == 0 && c->n_active > 0);
  if (!again && missed[1] > FRICTION_CHANGE * c->friction * c->force)
    again = ++c->friction_round < FRICTION_ROUNDS_MAX;
  return again && ++c->round < ROUNDS_MAX;
}
