/// Convex polygons of few corners.
#include "geometry/convex_cell.h"

#include <math.h>

LthConvex lth_convex_box(const double min[2], const double max[2]) {
  return (LthConvex){.n = 4,
                     .x = {{min[0], min[1]}, {max[0], min[1]}, {max[0], max[1]}, {min[0], max[1]}}};
}

static double cross(const double a[2], const double b[2]) { return a[0] * b[1] - a[1] * b[0]; }
static double dot(const double a[2], const double b[2]) { return a[0] * b[0] + a[1] * b[1]; }

/// From a to b.
static void between(const double a[2], const double b[2], double d[2]) {
  d[0] = b[0] - a[0];
  d[1] = b[1] - a[1];
}

double lth_convex_area(const LthConvex *c) {
  double sum = 0, a[2], b[2];
  for (int i = 1; i + 1 < c->n; i++) {
    between(c->x[0], c->x[i], a);
    between(c->x[0], c->x[i + 1], b);
    sum += cross(a, b) / 2;
  }
  return fmax(sum, 0);
}

void lth_convex_middle(const LthConvex *c, double middle[2]) {
  for (int a = 0; a < 2; a++) {
    double sum = 0;
    for (int i = 1; i < c->n; i++) sum += c->x[i][a] - c->x[0][a];
    middle[a] = c->x[0][a] + sum / c->n;
  }
}

void lth_convex_bounds(const LthConvex *c, double min[2], double max[2]) {
  for (int a = 0; a < 2; a++) {
    min[a] = max[a] = c->x[0][a];
    for (int i = 1; i < c->n; i++) {
      min[a] = fmin(min[a], c->x[i][a]);
      max[a] = fmax(max[a], c->x[i][a]);
    }
  }
}

void lth_convex_range(const LthConvex *c, const LthLine *line, double *low, double *high) {
  *low = INFINITY, *high = -INFINITY;
  for (int i = 0; i < c->n; i++) {
    double d = dot(line->normal, c->x[i]) - line->offset;
    *low = fmin(*low, d), *high = fmax(*high, d);
  }
}

static void append(LthConvex *c, const double x[2]) {
  LITHE_ASSERT(c->n < LTH_CONVEX_MAX);
  c->x[c->n][0] = x[0], c->x[c->n][1] = x[1];
  c->n++;
}

void lth_convex_cut(const LthConvex *c, const LthLine *line, LthConvex *behind, LthConvex *before) {
  behind->n = before->n = 0;
  for (int i = 0; i < c->n; i++) {
    const double *p = c->x[i], *q = c->x[(i + 1) % c->n];
    double dp = dot(line->normal, p) - line->offset, dq = dot(line->normal, q) - line->offset;
    if (dp <= 0) append(behind, p);
    if (dp >= 0) append(before, p);
    if (!((dp < 0 && dq > 0) || (dp > 0 && dq < 0))) continue;
    double s = dp / (dp - dq), x[2];
    for (int a = 0; a < 2; a++) x[a] = p[a] + s * (q[a] - p[a]);
    append(behind, x);
    append(before, x);
  }
  if (behind->n < 3) behind->n = 0;
  if (before->n < 3) before->n = 0;
}

void lth_convex_distances(const LthConvex *c, const double place[2], double *low, double *high) {
  bool is_in = true;
  *low = INFINITY, *high = 0;
  for (int i = 0; i < c->n; i++) {
    double p[2], q[2], d[2];
    between(place, c->x[i], p);
    between(place, c->x[(i + 1) % c->n], q);
    between(p, q, d);
    double length2 = dot(d, d), s = length2 > 0 ? fmin(fmax(-dot(p, d) / length2, 0), 1) : 0;
    *low = fmin(*low, hypot(p[0] + s * d[0], p[1] + s * d[1]));
    *high = fmax(*high, hypot(p[0], p[1]));
    if (cross(p, q) < 0) is_in = false;
  }
  if (is_in) *low = 0;
}

double lth_convex_chord(const LthConvex *c, const double p[2], const double q[2]) {
  double t0 = 0, t1 = 1, d[2];
  between(p, q, d);
  for (int i = 0; i < c->n && t0 < t1; i++) {
    double side[2], to[2];
    between(c->x[i], c->x[(i + 1) % c->n], side);
    between(c->x[i], p, to);
    double at = cross(side, to), slope = cross(side, d); // inside where at + t slope >= 0
    if (slope == 0) {
      if (at < 0) return 0;
    } else if (slope > 0) {
      t0 = fmax(t0, -at / slope);
    } else {
      t1 = fmin(t1, -at / slope);
    }
  }
  return t0 < t1 ? (t1 - t0) * hypot(d[0], d[1]) : 0;
}

/// Area between the centre (origin) and the part of the circle that is seen under the edge from a to b.
static double sector(const double a[2], const double b[2], double radius) {
  return 0.5 * radius * radius * atan2(cross(a, b), dot(a, b));
}

/// Area between the centre (origin) and the edge from p to q, as far as it is inside the circle.
static double edge_share(const double p[2], const double q[2], double radius) {
  double d[2];
  between(p, q, d);
  double length2 = dot(d, d), along = dot(p, d), size = hypot(p[0], p[1]);
  double root = along * along - length2 * (size - radius) * (size + radius);
  if (!(root > 0) || length2 == 0) return sector(p, q, radius);
  root = sqrt(root);
  double t0 = (-along - root) / length2, t1 = (-along + root) / length2;
  if (t0 >= 1 || t1 <= 0) return sector(p, q, radius);
  t0 = fmax(t0, 0), t1 = fmin(t1, 1);
  double a[2], b[2], area = 0;
  for (int k = 0; k < 2; k++) a[k] = p[k] + t0 * d[k], b[k] = p[k] + t1 * d[k];
  if (t0 > 0) area += sector(p, a, radius);
  if (t1 < 1) area += sector(b, q, radius);
  return area + cross(a, b) / 2;
}

double lth_convex_disk(const LthConvex *c, const double center[2], double radius) {
  double low, high, area = 0, whole = lth_convex_area(c);
  lth_convex_distances(c, center, &low, &high);
  if (low >= radius) return 0;
  if (high <= radius) return whole;
  for (int i = 0; i < c->n; i++) {
    double p[2], q[2];
    between(center, c->x[i], p);
    between(center, c->x[(i + 1) % c->n], q);
    area += edge_share(p, q, radius);
  }
  return fmin(fmax(area, 0), whole);
}
