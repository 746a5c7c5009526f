/// What springs of contact may give: what they were given, and no more.
///
/// Within a step every spring is a convex function of places, of which an implicit step loses energy. What would make some is a spring
/// that finds itself more compressed at the start of a step than the last one left it: where another facet is the nearest, a normal has
/// turned, a part is new. So the start of each step is put where the spring holds what it held (docs/theory/contact.md, section 8).
#include "base/tensor.h"
#include "embed/contact_priv.h"

#define RELAX 1e-3 ///< of a cell: what a spring may take up of its slack in a step
#define OWED 1e-3  ///< of the energy that springs move in a step: what pulls may make

/// Energy of a spring; none where it is not pressed.
static double energy_of(double pressed, double stiffness) {
  return pressed > 0 ? 0.5 * stiffness * pressed * pressed : 0;
}

/// Compression of a spring that holds an energy.
static double compression(double energy, double stiffness) {
  return stiffness > 0 ? sqrt(2 * energy / stiffness) : 0;
}

static bool keeps(const LthContact *c) { return c->look == LTH_LOOK_STEP && c->kind->keeps_energy; }

void lth_touch_begin(const LthContact *c, const LthTouch *old, const LthHit *hit, LthTouch *touch) {
  touch->pressed = c->ahead * lth_v3_dot(touch->normal, touch->start) - hit->gap;
  if (keeps(c) && touch->pressed > 0) {
    const double held = old ? compression(old->stored, touch->stiffness) : 0;
    touch->slack = fmax(touch->pressed - held, 0);
    touch->pressed -= touch->slack;
  }
  touch->gap = hit->gap + touch->slack;
}

void lth_touch_limit_stretch(const LthContact *c, const LthTouch *old, LthTouch *touch) {
  double at_start[3];
  if (!keeps(c)) return;
  lth_v3_copy(touch->offset, at_start);
  lth_v3_axpy(-c->ahead, touch->start, at_start);
  lth_v3_axpy(c->ahead * lth_v3_dot(touch->start, touch->normal), touch->normal, at_start);
  const double stretch = lth_v3_norm(at_start);
  const double held = old && touch->anchored ? compression(old->drawn, touch->stiffness) : 0;
  if (stretch > held) lth_v3_axpy(held / stretch - 1, at_start, touch->offset);
}

void lth_touch_account(const LthContact *c, bool acted, double spring, LthTouch *touch) {
  const double k = touch->stiffness, before = touch->pressed, after = -touch->gap_end;
  const double held = energy_of(before, k);
  const double work = acted ? k * after * (before - after) : 0; // of the force on the bodies
  touch->acted = acted;
  touch->stored = acted ? energy_of(after, k) : 0;
  touch->lost = held - work - touch->stored;
  touch->drawn = 0;
  if (!(c->friction > 0) || !acted || !(k > 0)) return;
  touch->drawn = fmin(0.5 * spring * lth_v3_dot(touch->trial, touch->trial),
                      0.5 * touch->limit * touch->limit / k);
}

/// What springs have lost in the step, less what slacks took.
static double spare_now(const LthContact *c) {
  double spare = c->spare - c->spent;
  if (!c->kind->keeps_energy) return 0;
  for (LitheIndex i = 0; i < c->n_touch; i++) spare += c->touch[i].lost;
  return spare;
}

void lth_contact_end_account(LthContact *c) {
  c->spare = spare_now(c);
  c->spent = 0;
}

/// Energy that a spring takes where it is pressed by `more`.
static double cost(const LthTouch *touch, double more) {
  return touch->stiffness * more * (touch->pressed + 0.5 * more);
}

/// Press a spring by what `energy` is enough for.
static void press(const LthContact *c, LthTouch *touch, double energy) {
  const double p = touch->pressed, now = sqrt(p * p + 2 * energy / touch->stiffness);
  const double more = fmin(now - p, touch->slack);
  touch->slack -= more;
  touch->gap -= more;
  touch->pressed = p + more;
  const double end = touch->gap + c->dt * lth_v3_dot(touch->normal, touch->start);
  touch->active = touch->active || end < 0;
  if (!touch->anchored) touch->limit = c->friction * touch->stiffness * fmax(-end, 0);
  lth_touch_linearize(c, touch);
}

void lth_contact_relax(LthContact *c) {
  const double way = RELAX * c->cell_size;
  double wanted = 0;
  c->spent = 0;
  if (!keeps(c) || !(c->spare > 0)) return;
  for (LitheIndex i = 0; i < c->n_touch; i++)
    wanted += cost(c->touch + i, fmin(c->touch[i].slack, way));
  if (!(wanted > 0)) return;
  c->spent = fmin(wanted, c->spare);
  for (LitheIndex i = 0; i < c->n_touch; i++) {
    LthTouch *touch = &c->touch[i];
    if (!(touch->slack > 0) || !(touch->stiffness > 0)) continue;
    press(c, touch, c->spent / wanted * cost(touch, fmin(touch->slack, way)));
  }
}

bool lth_contact_drop_pulls(LthContact *c) {
  double lost = 0, moved = 0;
  if (!keeps(c)) return false;
  for (LitheIndex i = 0; i < c->n_touch; i++) {
    lost += c->touch[i].lost;
    moved += fabs(c->touch[i].lost) + c->touch[i].stored;
  }
  if (!(lost < 0) || !(fmax(spare_now(c), lost) < -OWED * moved)) return false;
  for (LitheIndex i = 0; i < c->n_touch; i++)
    c->touch[i].active = c->touch[i].active && c->touch[i].acted;
  c->drops = true;
  lth_contact_index(c);
  return c->n_active < c->n_acted;
}

double lth_contact_start_energy(const LthContact *c) {
  double energy = 0;
  for (LitheIndex i = 0; i < c->n_touch; i++)
    energy += energy_of(c->touch[i].pressed, c->touch[i].stiffness);
  return energy;
}

void lth_contact_energy(const LthContact *c, double *stored, double *spare) {
  *stored = 0;
  for (LitheIndex i = 0; i < c->n_touch; i++) *stored += c->touch[i].stored + c->touch[i].drawn;
  *spare = spare_now(c);
}
