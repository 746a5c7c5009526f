/// The thesis' test problem: the annulus 0.325 < r < 0.8 in [-1, 1]^2 with a solution that is known; exact fractions of
/// discs; errors at the unknowns.
#pragma once

#include "staggered_body.h"

#define RING_INNER 0.325
#define RING_OUTER 0.8
#define RING_POISSON 0.25

/// Area of the part of the disc |x| < R with x < a and y < b, both from 0 to R: by the antiderivative of the arc.
static inline double disc_quadrant(double R, double a, double b) {
  a = fmin(fmax(a, 0), R), b = fmin(fmax(b, 0), R);
  double bend = sqrt(fmax(0, R * R - b * b)); // up to here the height is b
  if (a <= bend) return a * b;
  double arc = 0.5 * (a * sqrt(R * R - a * a) - bend * b + R * R * (asin(a / R) - asin(bend / R)));
  return bend * b + arc;
}

/// The same with signs for any a and b: odd in each.
static inline double disc_corner(double R, double a, double b) {
  double area = disc_quadrant(R, fabs(a), fabs(b));
  return (a < 0) != (b < 0) ? -area : area;
}

/// Area of the disc of radius R about the origin in a rectangle.
static inline double disc_area(double R, const double low[2], const double size[2]) {
  double x = low[0] + size[0], y = low[1] + size[1];
  return disc_corner(R, x, y) - disc_corner(R, low[0], y) - disc_corner(R, x, low[1]) +
         disc_corner(R, low[0], low[1]);
}

static inline double ring_outer_part(const void *self, const double low[3], const double size[3]) {
  (void)self;
  return fmin(1, disc_area(RING_OUTER, low, size) / (size[0] * size[1]));
}

static inline double ring_x(const void *self, const double x[3], double t) {
  (void)self, (void)t;
  return cos(2 * M_PI * x[0]) * cos(2 * M_PI * x[1]);
}

static inline double ring_y(const void *self, const double x[3], double t) {
  (void)self, (void)t;
  return sin(2 * M_PI * x[0]) * sin(2 * M_PI * x[1]);
}

/// The deformed place that is the solution.
static inline void ring_solution(const void *self, const double x[3], double value[3]) {
  value[0] = ring_x(self, x, 0);
  value[1] = ring_y(self, x, 0);
  value[2] = 0;
}

static inline bool ring_is_inner(const void *self, const double x[3]) {
  (void)self;
  return x[0] * x[0] + x[1] * x[1] <= RING_INNER * RING_INNER;
}

static inline bool ring_is_outside(const void *self, const double x[3]) {
  return ring_is_inner(self, x) || x[0] * x[0] + x[1] * x[1] >= RING_OUTER * RING_OUTER;
}

/// Some unknown of the other component that the unknown at x meets in a sample is outside of the annulus.
static inline bool ring_box_is_outside(const void *self, const double x[3]) {
  const double h = *(const double *)self;
  for (int k = 0; k < 4; k++) {
    double at[3] = {x[0] + (k & 1 ? h : -h) / 2, x[1] + (k & 2 ? h : -h) / 2, 0};
    if (ring_is_outside(NULL, at)) return true;
  }
  return false;
}

static inline LthStaggeredHold ring_hold(bool (*selects)(const void *self, const double x[3]),
                                         const void *self) {
  return (LthStaggeredHold){.selects = selects,
                            .self = self,
                            .fixed = {true, true, false},
                            .is_position = true,
                            .value = {{.eval = ring_x}, {.eval = ring_y}}};
}

static inline SgDef ring_def(int N, LthPartFunction part, const LthStaggeredHold *hold) {
  return (SgDef){.dim = 2,
                 .low = {-1, -1, 0},
                 .high = {1, 1, 0},
                 .n = {N, N, 1},
                 .part = part,
                 .young = 1000,
                 .poisson = RING_POISSON,
                 .holds = hold,
                 .n_holds = 1};
}

/// Force per volume that keeps the solution: 8 pi^2 mu phi.
static inline double ring_force_x(const void *self, const double x[3], double t) {
  return 8 * M_PI * M_PI * *(const double *)self * ring_x(NULL, x, t);
}
static inline double ring_force_y(const void *self, const double x[3], double t) {
  return 8 * M_PI * M_PI * *(const double *)self * ring_y(NULL, x, t);
}

/// The solution on a grid that is full, held as `hold` says. b keeps its place; sg_free() it.
static inline void ring_solve_full(int N, const LthStaggeredHold *hold, SgBody *b) {
  double lambda, mu;
  SgDef def = ring_def(N, sg_full, hold);
  lth_lame(def.young, def.poisson, &lambda, &mu);
  LthLoad load = {
      .kind = LTH_LOAD_BODY_FORCE,
      .value = {{.eval = ring_force_x, .self = &mu}, {.eval = ring_force_y, .self = &mu}}};
  sg_create(b, &def);
  sg_assemble(b);
  CHECK_OK(b->ctx, lth_disc_add_load(b->ctx, b->disc, &load, 0, NULL, b->f));
  CHECK_OK(b->ctx, sg_solve(b));
}

typedef struct RingError {
  double l1, linf;
} RingError;

/// At the free unknowns inside: sum of |e| h^2, and the largest.
static inline RingError ring_error(const SgBody *b) {
  RingError error = {0};
  double cell = b->s->grid->h[0] * b->s->grid->h[1];
  for (LitheCount k = 0; k < b->disc->n_dofs; k++) {
    double at[3], phi[3];
    if (k % 3 == 2 || !sg_is_free(b, k)) continue;
    lth_staggered_place(b->s, (LitheIndex)(k / 3), (int)(k % 3), at);
    if (hypot(at[0], at[1]) > RING_OUTER) continue;
    ring_solution(NULL, at, phi);
    double e = fabs(b->x[k] - phi[k % 3]);
    error.l1 += e * cell;
    error.linf = fmax(error.linf, e);
  }
  return error;
}
