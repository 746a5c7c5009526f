/// Loops that cross or touch, and holes in the wrong place: all by exact signs.
#include "geometry/loops_check.h"

#include "geometry/predicates.h"

#include <math.h>

typedef struct Crossing {
  const LthLoops *loops;
  LitheIndex edge, other; ///< other: -1, none found
} Crossing;

static const double *corner(const LthLoops *l, LitheIndex i) { return l->points + 2 * (size_t)i; }

static bool boxes_overlap(const double *p, const double *q, const double *r, const double *s) {
  for (int a = 0; a < 2; a++)
    if (fmax(p[a], q[a]) < fmin(r[a], s[a]) || fmax(r[a], s[a]) < fmin(p[a], q[a])) return false;
  return true;
}

/// Do the closed segments pq and rs have a point in common?
static bool touch(const double *p, const double *q, const double *r, const double *s) {
  if (!boxes_overlap(p, q, r, s)) return false;
  return lth_orient2d(p, q, r) * lth_orient2d(p, q, s) <= 0 &&
         lth_orient2d(r, s, p) * lth_orient2d(r, s, q) <= 0;
}

/// Does the path pqr turn back onto itself at q?
static bool turns_back(const double *p, const double *q, const double *r) {
  if (lth_orient2d(p, q, r) != 0) return false;
  return (p[0] - q[0]) * (r[0] - q[0]) + (p[1] - q[1]) * (r[1] - q[1]) > 0;
}

static bool visit(void *self, LitheIndex j) {
  Crossing *c = self;
  const LthLoops *l = c->loops;
  LitheIndex i = c->edge;
  const double *p = corner(l, i), *q = corner(l, l->next[i]), *r = corner(l, j),
               *s = corner(l, l->next[j]);
  if (j <= i) return true; // found from the other side
  bool is_bad;
  if (l->next[i] == j)
    is_bad = turns_back(p, q, s);
  else if (l->next[j] == i)
    is_bad = turns_back(r, s, q);
  else
    is_bad = touch(p, q, r, s);
  if (is_bad) c->other = j;
  return !is_bad;
}

static LitheIndex loop_of(const LthLoops *l, LitheIndex point) {
  LitheIndex k = 0;
  while (l->first[k + 1] <= point) k++;
  return k;
}

/// About where two edges meet: where their lines cross, or else an end of one that lies on the other.
static void meeting_place(const double *p, const double *q, const double *r, const double *s,
                          double x[2]) {
  double d[2] = {q[0] - p[0], q[1] - p[1]}, e[2] = {s[0] - r[0], s[1] - r[1]};
  double below = d[0] * e[1] - d[1] * e[0], above = (r[0] - p[0]) * e[1] - (r[1] - p[1]) * e[0];
  bool is_in = boxes_overlap(r, r, p, q);
  for (int a = 0; a < 2; a++) x[a] = is_in ? r[a] : s[a];
  if (below == 0) return;
  double t = fmin(fmax(above / below, 0), 1);
  for (int a = 0; a < 2; a++) x[a] = p[a] + t * d[a];
}

static LitheStatus check_crossings(LitheCtx *ctx, const LthLoops *l) {
  for (LitheIndex i = 0; i < l->n_points; i++) {
    const double *p = corner(l, i), *q = corner(l, l->next[i]);
    double centre[3] = {p[0] + (q[0] - p[0]) / 2, p[1] + (q[1] - p[1]) / 2, 0};
    Crossing c = {l, i, -1};
    // a little further than half an edge, for rounding
    lth_bvh_visit(l->bvh, centre, hypot(q[0] - p[0], q[1] - p[1]) * (0.5 + 1e-9), visit, &c);
    if (c.other < 0) continue;
    const double *r = corner(l, c.other);
    double x[2];
    meeting_place(p, q, r, corner(l, l->next[c.other]), x);
    LITHE_FAIL(ctx, LITHE_BAD_INPUT,
               "the polygon touches or crosses itself at about (%g, %g): an edge of loop %d from "
               "(%g, %g) on meets one of loop %d from (%g, %g) on; expected loops without common "
               "points",
               x[0], x[1], loop_of(l, i) + 1, p[0], p[1], loop_of(l, c.other) + 1, r[0], r[1]);
  }
  return LITHE_OK;
}

/// Is x inside a loop that it does not lie on? By the edges that a ray along x crosses.
static bool is_inside(const LthLoops *l, LitheIndex loop, const double *x) {
  bool inside = false;
  for (LitheIndex i = l->first[loop]; i < l->first[loop + 1]; i++) {
    const double *p = corner(l, i), *q = corner(l, l->next[i]);
    if ((p[1] > x[1]) == (q[1] > x[1])) continue;
    const double *low = p[1] < q[1] ? p : q, *high = p[1] < q[1] ? q : p;
    if (lth_orient2d(low, high, x) > 0) inside = !inside;
  }
  return inside;
}

static void loop_box(const LthLoops *l, LitheIndex loop, double box[4]) {
  for (int a = 0; a < 2; a++) box[a] = INFINITY, box[2 + a] = -INFINITY;
  for (LitheIndex i = l->first[loop]; i < l->first[loop + 1]; i++)
    for (int a = 0; a < 2; a++) {
      box[a] = fmin(box[a], corner(l, i)[a]);
      box[2 + a] = fmax(box[2 + a], corner(l, i)[a]);
    }
}

static LitheStatus check_holes(LitheCtx *ctx, const LthLoops *l) {
  double *boxes = NULL;
  LitheStatus status = LITHE_OK;
  LTH_NEW(ctx, boxes, 4 * (LitheCount)l->n_loops);
  for (LitheIndex k = 0; k < l->n_loops; k++) loop_box(l, k, boxes + 4 * (size_t)k);
  for (LitheIndex k = 1; k < l->n_loops && status == LITHE_OK; k++) {
    const double *x = corner(l, l->first[k]);
    if (!is_inside(l, 0, x))
      status = lth_fail(ctx, LITHE_BAD_INPUT,
                        "loop %d of the polygon is not inside the first; expected holes behind the "
                        "first loop, or a union of polygons",
                        k + 1);
    for (LitheIndex j = 1; j < l->n_loops && status == LITHE_OK; j++) {
      const double *box = boxes + 4 * (size_t)j;
      bool is_near = x[0] >= box[0] && x[0] <= box[2] && x[1] >= box[1] && x[1] <= box[3];
      if (j != k && is_near && is_inside(l, j, x))
        status = lth_fail(ctx, LITHE_BAD_INPUT,
                          "loop %d of the polygon is inside loop %d, which is a hole; expected "
                          "holes beside each other, or a union of polygons",
                          k + 1, j + 1);
    }
  }
  lth_free(ctx, boxes);
  return status;
}

static bool is_straight(const LthLoops *l, LitheIndex loop) {
  const double *p = corner(l, l->first[loop]), *q = corner(l, l->first[loop] + 1);
  for (LitheIndex i = l->first[loop] + 2; i < l->first[loop + 1]; i++)
    if (lth_orient2d(p, q, corner(l, i)) != 0) return false;
  return true;
}

/// Loops without area lie on a line, or cross themselves.
static LitheStatus check_areas(LitheCtx *ctx, const LthLoops *l) {
  for (LitheIndex k = 0; k < l->n_loops; k++)
    if (lth_loop_area2(l, k) == 0 && is_straight(l, k))
      LITHE_FAIL(ctx, LITHE_BAD_INPUT,
                 "loop %d of the polygon has no area; expected corners in their order around it, "
                 "not all on one line",
                 k + 1);
  return LITHE_OK;
}

LitheStatus lth_loops_check(LitheCtx *ctx, const LthLoops *l) {
  if (l->n_loops > LTH_LOOPS_MAX)
    LITHE_FAIL(ctx, LITHE_BAD_INPUT, "the polygon has %d loops; expected at most %d, or an image",
               l->n_loops, LTH_LOOPS_MAX);
  LITHE_TRY(check_areas(ctx, l));
  LITHE_TRY(check_crossings(ctx, l));
  return check_holes(ctx, l);
}
