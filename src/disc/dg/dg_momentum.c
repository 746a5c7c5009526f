/// Momentum and angular momentum of elements that were projected: what the projections of place and velocity take away is given back
/// as a rigid motion of each of them.
#include "disc/dg/dg_transfer.h"

#include "base/tensor.h"

#define FLAT                                                                                       \
  1e-10 ///< of the cube of its trace: an inertia with less is that of a line, which no turn tells from rest

/// Motion of one element, or of what it is made of: momentum, and angular momentum about the centre of mass [SI].
typedef struct Motion {
  double mass, momentum[3], angular[3];
  double twice_energy;
} Motion;

/// Sums over the atoms of a new cell.
typedef struct Sum {
  const LthDgSpace *from;
  LitheIndex cell; ///< of `from`
  double density;
  const double *x, *v;
  double about[3], place[3]; ///< angular momentum is summed up about the first; int rho (x - about)
  Motion motion;
} Sum;

static void add_point(void *self, const double at[3], double weight) {
  Sum *s = self;
  double x[3], v[3], L[3];
  lth_dg_sample(s->from, s->cell, s->x, at, x);
  lth_dg_sample(s->from, s->cell, s->v, at, v);
  lth_v3_sub(x, s->about, x);
  lth_v3_cross(x, v, L);
  weight *= s->density;
  s->motion.mass += weight;
  lth_v3_axpy(weight, x, s->place);
  lth_v3_axpy(weight, v, s->motion.momentum);
  lth_v3_axpy(weight, L, s->motion.angular);
  s->motion.twice_energy += weight * lth_v3_dot(v, v);
}

static LitheStatus add_atom(LitheCtx *ctx, const LthDgTransfer *t, LitheIndex i,
                            const double *density, Sum *sum) {
  LthSimplexRule rule;
  const LitheIndex at = t->atom ? t->atom[i] : i;
  sum->cell = t->from_cell[i];
  sum->density = density[sum->cell];
  LITHE_TRY(lth_simplex_rule(ctx, 3, 2 * t->from->degree[sum->cell], &rule));
  lth_dg_visit_cell(&rule, at < 0 ? t->from->mesh : t->atoms, at < 0 ? sum->cell : at, add_point,
                    sum);
  return LITHE_OK;
}

/// About the centre of mass. Where densities differ it lies elsewhere than that of the new cell, which has one density: a body that
/// flies straight must not turn for that.
static void move_to_center(Sum *s) {
  double L[3];
  lth_v3_cross(s->place, s->motion.momentum, L);
  lth_v3_axpy(-1 / s->motion.mass, L, s->motion.angular);
}

/// The same of a cell with n orthogonal functions, the first of which is 1, about its centre of mass; and its inertia.
static Motion motion_of(int n, double mass, const double *x, const double *v, double inertia[9]) {
  Motion m = {.mass = mass, .twice_energy = mass * lth_v3_dot(v, v)};
  memset(inertia, 0, 9 * sizeof *inertia);
  lth_v3_axpy(mass, v, m.momentum);
  for (int i = 1; i < n; i++) {
    const double *p = x + 3 * i, square = lth_v3_dot(p, p);
    double L[3];
    lth_v3_cross(p, v + 3 * i, L);
    lth_v3_axpy(mass, L, m.angular);
    m.twice_energy += mass * lth_v3_dot(v + 3 * i, v + 3 * i);
    for (int a = 0; a < 3; a++)
      for (int b = 0; b < 3; b++) inertia[3 * a + b] += mass * ((a == b) * square - p[a] * p[b]);
  }
  return m;
}

/// v = mean + turn x place + share x (what else there is).
static void set_velocity(int n, const double *x, const double mean[3], const double was[3],
                         const double turn[3], double share, double *v) {
  lth_v3_copy(mean, v);
  for (int i = 1; i < n; i++) {
    double rigid[3];
    lth_v3_cross(was, x + 3 * i, rigid);
    for (int a = 0; a < 3; a++) v[3 * i + a] = share * (v[3 * i + a] - rigid[a]);
    lth_v3_cross(turn, x + 3 * i, rigid);
    lth_v3_add(v + 3 * i, rigid, v + 3 * i);
  }
}

/// Give a cell the motion that what it is made of had. Its deformation is slowed down where energy would grow.
static void correct(int n, double mass, const Motion *want, const double *x, double *v) {
  double inertia[9], inverse[9], mean[3] = {0}, was[3], turn[3];
  const Motion have = motion_of(n, mass, x, v, inertia);
  const double trace = inertia[0] + inertia[4] + inertia[8];
  if (!(lth_m3_det(inertia) > FLAT * trace * trace * trace)) return;
  lth_m3_inverse(inertia, inverse);
  lth_m3_apply(inverse, have.angular, was);
  lth_m3_apply(inverse, want->angular, turn);
  lth_v3_axpy(1 / mass, want->momentum, mean);
  const double rigid = mass * lth_v3_dot(mean, mean) + lth_v3_dot(turn, want->angular),
               rest = have.twice_energy - mass * lth_v3_dot(v, v) - lth_v3_dot(was, have.angular),
               room = fmax(want->twice_energy - rigid, 0);
  set_velocity(n, x, mean, was, turn, rest > room ? sqrt(room / rest) : 1, v);
}

static LitheStatus keep_cell(LitheCtx *ctx, const LthDgMotion *m, LitheIndex cell,
                             const LitheIndex *atom, LitheIndex n) {
  const LthDgTransfer *t = m->transfer;
  const LitheCount first = 3 * (LitheCount)t->to->func_off[cell];
  const bool is_projected =
      n > 1 || (n == 1 && t->from->degree[t->from_cell[atom[0]]] > t->to->degree[cell]);
  if (!is_projected) return LITHE_OK;
  Sum sum = {.from = t->from, .x = m->x_from, .v = m->v_from};
  lth_v3_copy(m->x_to + first, sum.about);
  for (LitheIndex i = 0; i < n; i++) LITHE_TRY(add_atom(ctx, t, atom[i], m->density_from, &sum));
  move_to_center(&sum);
  correct(lth_dg_funcs(t->to, cell), sum.motion.mass, &sum.motion, m->x_to + first,
          m->v_to + first);
  return LITHE_OK;
}

LitheStatus lth_dg_keep_motion(LitheCtx *ctx, const LthDgMotion *m) {
  LitheStatus status = LITHE_OK;
  LitheIndex *off = NULL, *atom = NULL;
  LITHE_TRY_OR(done, lth_dg_sort_atoms(ctx, m->transfer, &off, &atom));
  for (LitheIndex c = 0; c < m->transfer->to->n_cells; c++)
    LITHE_TRY_OR(done, keep_cell(ctx, m, c, atom + off[c], off[c + 1] - off[c]));
done:
  lth_free(ctx, off);
  lth_free(ctx, atom);
  return status;
}
