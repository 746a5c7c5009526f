/// After a solve: the active set and Coulomb's limit, and what both make of each point's equations.
#include "base/tensor.h"
#include "embed/contact_priv.h"

#define ROUNDS_MAX 6      ///< solves of one step
#define SWITCHES_MAX 3    ///< of friction's state, then it is a drag
#define FORCE_CHANGE 0.02 ///< of the largest friction: smaller changes need no new solve

static void add_outer(double s, const double a[3], double D[9]) {
  for (int i = 0; i < 9; i++) D[i] += s * a[i / 3] * a[i % 3];
}

/// D += s times the projection onto the tangential plane.
static void add_tangential(double s, const double n[3], double D[9]) {
  for (int i = 0; i < 3; i++) D[4 * i] += s;
  add_outer(-s, n, D);
}

/// Tangential part of a - b.
static void tangential(const double a[3], const double b[3], const double n[3], double t[3]) {
  lth_v3_sub(a, b, t);
  lth_v3_axpy(-lth_v3_dot(t, n), n, t);
}

/// Slope of friction against speed where it is a drag, never above that of the spring.
static double drag(const LthContact *c, const LthTouch *touch) {
  double most = c->dt * touch->stiffness;
  return touch->limit < most * touch->speed ? touch->limit / touch->speed : most;
}

static void linearize_friction(const LthContact *c, LthTouch *touch) {
  const double dt = c->dt, k = touch->stiffness, *n = touch->normal;
  double zero[3] = {0, 0, 0}, vt[3];
  tangential(touch->velocity, zero, n, vt);
  switch (touch->friction) {
  case LTH_FRICTION_STICK: // f = -k (offset + dt v)
    add_tangential(dt * dt * k, n, touch->D);
    lth_v3_axpy(-dt * k, touch->offset, touch->r);
    return;
  case LTH_FRICTION_SLIDE: { // f = -limit (s + (1 - n n - s s)(v - vc) / speed)
    double across = touch->speed > 0 ? touch->limit / touch->speed : 0;
    across = fmin(across, dt * k);
    add_tangential(dt * across, n, touch->D);
    add_outer(-dt * across, touch->slide, touch->D);
    lth_v3_axpy(-dt * touch->limit, touch->slide, touch->r);
    lth_v3_axpy(-lth_v3_dot(vt, touch->slide), touch->slide, vt);
    lth_v3_axpy(dt * across, vt, touch->r);
    return;
  }
  case LTH_FRICTION_DRAG: // f = -drag (v - vc)
    add_tangential(dt * drag(c, touch), n, touch->D);
    lth_v3_axpy(dt * drag(c, touch), vt, touch->r);
    return;
  }
}

void lth_touch_linearize(const LthContact *c, LthTouch *touch) {
  const double dt = c->dt, k = touch->stiffness, damping = c->def.damping * k;
  memset(touch->D, 0, sizeof touch->D);
  memset(touch->r, 0, sizeof touch->r);
  add_outer(dt * (dt * k + damping), touch->normal, touch->D);
  double push = -k * touch->gap + damping * lth_v3_dot(touch->normal, touch->velocity);
  lth_v3_axpy(dt * push, touch->normal, touch->r);
  if (c->def.friction > 0) linearize_friction(c, touch);
}

/// Normal force that the last solve means at a point, equation (2).
static double normal_force(const LthContact *c, LthTouch *touch, const double v[3]) {
  double closing = lth_v3_dot(touch->normal, v) - lth_v3_dot(touch->normal, touch->velocity);
  touch->gap_end = touch->gap + c->dt * lth_v3_dot(touch->normal, v);
  return -touch->stiffness * touch->gap_end - c->def.damping * touch->stiffness * closing;
}

/// Friction that the last solve meant, in the state it was made with.
static void friction_force(const LthContact *c, LthTouch *touch, const double v[3]) {
  double vt[3];
  tangential(v, touch->velocity, touch->normal, vt);
  memset(touch->force_t, 0, sizeof touch->force_t);
  if (touch->friction == LTH_FRICTION_STICK) {
    double zero[3] = {0, 0, 0}, moved[3];
    tangential(v, zero, touch->normal, moved);
    lth_v3_axpy(-touch->stiffness, touch->offset, touch->force_t);
    lth_v3_axpy(-touch->stiffness * c->dt, moved, touch->force_t);
  } else if (touch->friction == LTH_FRICTION_SLIDE) {
    lth_v3_axpy(-touch->limit, touch->slide, touch->force_t);
  } else {
    lth_v3_axpy(-drag(c, touch), vt, touch->force_t);
  }
}

/// Put a point into the state that Coulomb's law asks for after a solve with velocity v; returns by how
/// much its friction changes [N].
static double revise_friction(const LthContact *c, LthTouch *touch, const double v[3]) {
  double vt[3], zero[3] = {0, 0, 0}, trial[3], old_limit = touch->limit, old_slide[3];
  LthFriction old = touch->friction;
  friction_force(c, touch, v);
  lth_v3_copy(touch->slide, old_slide);
  tangential(v, touch->velocity, touch->normal, vt);
  tangential(v, zero, touch->normal, trial);
  lth_v3_scale(c->dt, trial);
  lth_v3_axpy(1, touch->offset, trial); // stretch of the spring, were it held
  touch->limit = c->def.friction * fmax(touch->force_n, 0);
  double stretch = lth_v3_norm(trial), speed = lth_v3_norm(vt);
  bool holds = touch->stiffness * stretch <= touch->limit;

  if (old == LTH_FRICTION_SLIDE)
    holds = lth_v3_dot(vt, old_slide) <= 0; // it came to rest, or turned
  if (old == LTH_FRICTION_DRAG) holds = false;
  touch->friction = holds ? LTH_FRICTION_STICK
                    : touch->switches >= SWITCHES_MAX || old == LTH_FRICTION_DRAG
                        ? LTH_FRICTION_DRAG
                        : LTH_FRICTION_SLIDE;
  touch->speed = speed;
  if (!holds) { // away from the anchor where the point hardly moves
    lth_v3_copy(touch->stiffness * c->dt * speed > 1e-3 * touch->limit ? vt : trial, touch->slide);
    lth_v3_normalize(touch->slide);
  }
  if (touch->friction != old) {
    touch->switches++;
    return fmax(touch->limit, old_limit);
  }
  if (touch->friction == LTH_FRICTION_STICK) return 0;
  return fabs(touch->limit - old_limit) + touch->limit * lth_v3_distance(touch->slide, old_slide);
}

/// Revise one point; returns whether it came or went, and the change of its friction.
static bool revise_touch(const LthContact *c, LthTouch *touch, double *friction_change) {
  double v[3];
  lth_embedding_from_samples(c->def.points, touch->point, c->sample_value, v);
  double force = normal_force(c, touch, v);
  bool was_active = touch->active;
  *friction_change = 0;
  touch->active = force > 0;
  touch->force_n = fmax(force, 0);
  memset(touch->force_t, 0, sizeof touch->force_t);
  if (c->def.friction > 0 && was_active && touch->active)
    *friction_change = revise_friction(c, touch, v);
  else if (c->def.friction > 0)
    touch->limit = c->def.friction * touch->force_n;
  lth_touch_linearize(c, touch);
  return was_active != touch->active;
}

bool lth_contact_revise(LthContact *c, const double *u, const double *v1) {
  (void)u;
  bool changed = false;
  double change = 0, largest = 0;
  c->n_active = 0, c->penetration = 0, c->force = 0;
  lth_contact_sample(c, v1);
  for (LitheIndex i = 0; i < c->n_touch; i++) {
    LthTouch *touch = &c->touch[i];
    double friction_change;
    changed |= revise_touch(c, touch, &friction_change);
    change = fmax(change, friction_change);
    if (!touch->active) continue;
    c->n_active++;
    c->force += touch->force_n;
    c->penetration = fmax(c->penetration, -touch->gap_end);
    largest = fmax(largest, touch->limit);
  }
  return (changed || change > FORCE_CHANGE * largest) && ++c->round < ROUNDS_MAX;
}
