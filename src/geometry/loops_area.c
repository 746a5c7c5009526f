/// Area of a polygon inside a box, edge by edge (docs/theory/fractions-plane.md).
///
/// With s the inside state of the low corner, the length of {y in [y0, y1]: (x, y) inside} is s (y1 - y0), changed by
/// (y1 - y0) at every edge that crosses the low side left of x and by y1 - y at every edge that passes over x in
/// the box. All states are taken just above and right of the low corner, all signs are exact.
#include "geometry/loops.h"

#include "geometry/predicates.h"

#include <math.h>

typedef struct BoxArea {
  const LthLoops *loops;
  double min[2], max[2];
  double foot[2];      ///< below the reference, on the low side
  double reference[2]; ///< a place in the box whose state is known
  int state;           ///< of the low corner minus that of the reference
  bool is_crossed;     ///< an edge passes through the box
  double area;         ///< beyond that of the low corner's state
} BoxArea;

/// Part of the segment pq in the box; false where there is none.
static bool clip(const double *p, const double *q, const double *min, const double *max,
                 double piece[4]) {
  double t0 = 0, t1 = 1;
  for (int a = 0; a < 2; a++) {
    double d = q[a] - p[a];
    if (d == 0) {
      if (p[a] < min[a] || p[a] > max[a]) return false;
      continue;
    }
    double to_min = (min[a] - p[a]) / d, to_max = (max[a] - p[a]) / d;
    t0 = fmax(t0, fmin(to_min, to_max));
    t1 = fmin(t1, fmax(to_min, to_max));
  }
  if (!(t0 < t1)) return false;
  for (int a = 0; a < 2; a++) {
    double d = q[a] - p[a];
    piece[a] = t0 == 0 ? p[a] : fmin(fmax(p[a] + t0 * d, min[a]), max[a]);
    piece[2 + a] = t1 == 1 ? q[a] : fmin(fmax(p[a] + t1 * d, min[a]), max[a]);
  }
  return true;
}

/// Does x, moved right by nothing and then up by less, lie right of an edge that is not level?
static bool is_right_of(const double *p, const double *q, const double *x) {
  const double *low = p[1] < q[1] ? p : q, *high = low == p ? q : p;
  return lth_orient2d(low, high, x) <= 0;
}

/// Does it lie above an edge that is not upright?
static bool is_above(const double *p, const double *q, const double *x) {
  const double *left = p[0] < q[0] ? p : q, *right = left == p ? q : p;
  int side = lth_orient2d(left, right, x);
  return side > 0 || (side == 0 && right[1] <= left[1]);
}

/// Where the edge pq crosses the line y = y0, rounded into its own range.
static double crossing(const double *p, const double *q, double y0) {
  double x = p[0] + (y0 - p[1]) / (q[1] - p[1]) * (q[0] - p[0]);
  return fmin(fmax(x, fmin(p[0], q[0])), fmax(p[0], q[0]));
}

/// The edge's share: what it changes at the low side, between the low corner and the reference, and within the box.
static bool visit(void *self, LitheIndex i) {
  BoxArea *b = self;
  const LthLoops *l = b->loops;
  const double *p = l->points + 2 * (size_t)i, *q = l->points + 2 * (size_t)l->next[i];
  double height = b->max[1] - b->min[1], piece[4];
  bool p_is_below = p[1] <= b->min[1], q_is_below = q[1] <= b->min[1];
  bool p_is_left = p[0] <= b->reference[0], q_is_left = q[0] <= b->reference[0];
  // moving right over an edge that runs down enters the body, moving up over one that runs right too
  if (p_is_below != q_is_below && !is_right_of(p, q, b->min)) {
    int enters = q_is_below ? 1 : -1;
    double x = crossing(p, q, b->min[1]);
    if (is_right_of(p, q, b->foot)) b->state -= enters;
    if (x < b->max[0]) b->area += enters * height * (b->max[0] - fmax(x, b->min[0]));
  }
  if (p_is_left != q_is_left && !is_above(p, q, b->foot) && is_above(p, q, b->reference))
    b->state -= p_is_left ? 1 : -1;
  if ((p_is_below && q_is_below) || !clip(p, q, b->min, b->max, piece)) return true;
  b->is_crossed = true;
  b->area += (piece[2] - piece[0]) * (b->max[1] - (piece[1] + piece[3]) / 2);
  return true;
}

double lth_loops_area(const LthLoops *l, const double min[2], const double max[2]) {
  BoxArea b = {.loops = l, .min = {min[0], min[1]}, .max = {max[0], max[1]}};
  double width = max[0] - min[0], height = max[1] - min[1], whole = width * height;
  double middle[3] = {min[0] + width / 2, min[1] + height / 2, 0}, distance;
  // places that edges of drawn things seldom pass through
  static const double places[4][2] = {{0.4142135, 0.5772156},
                                      {0.6180339, 0.3678794},
                                      {0.2718281, 0.7320508},
                                      {0.5641895, 0.1415926}};
  int k = 0;
  do {
    b.reference[0] = min[0] + places[k][0] * width;
    b.reference[1] = min[1] + places[k][1] * height;
    distance = lth_loops_distance(l, b.reference, NULL, NULL);
  } while (distance == 0 && ++k < 4);
  double diagonal = hypot(width, height);
  if (fabs(distance) > diagonal) return distance < 0 ? whole : 0;
  b.foot[0] = b.reference[0], b.foot[1] = min[1];
  // a little further than half the diagonal, for rounding
  lth_bvh_visit(l->bvh, middle, diagonal * (0.5 + 1e-9), visit, &b);
  b.state += distance <= 0;
  if (!b.is_crossed) return b.state > 0 ? whole : 0;
  return fmin(fmax(b.state * whole + b.area, 0), whole);
}
