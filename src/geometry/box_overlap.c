/// Overlaps of boxes with quadrics between planes: areas of sections in closed form, integrated along an axis between
/// the places where they are not smooth (docs/theory/fractions.md).
#include "geometry/box_overlap.h"

#include "base/tensor.h"

#define CORNERS_MAX 12
#define BREAKS_MAX 64
#define N_POINTS 10
#define PIECE 0.25 ///< of a radius: as far as that number of points is enough
#define PIECES_MAX 64
#define LEVEL 1e-4 ///< of a box's width along a normal: its sides are taken as along the plane

/// --- sections ---

typedef struct Polygon {
  int n;
  double p[CORNERS_MAX][2];
} Polygon;

static double cross(const double p[2], const double q[2]) { return p[0] * q[1] - p[1] * q[0]; }
static double dot(const double p[2], const double q[2]) { return p[0] * q[0] + p[1] * q[1]; }

/// Twice the area between the edge pq, the origin and the circle of radius r around it.
static double edge_area(const double p[2], const double q[2], double r2) {
  double d[2] = {q[0] - p[0], q[1] - p[1]};
  double a = dot(d, d), b = dot(p, d), c = dot(p, p) - r2, disc = b * b - a * c;
  if (c <= 0 && dot(q, q) <= r2) return cross(p, q);
  if (!(disc > 0) || !(a > 0)) return r2 * atan2(cross(p, q), dot(p, q));

  // enters at t0, leaves at t1
  double root = sqrt(disc), t0 = (-b - root) / a, t1 = (-b + root) / a, sum = 0;
  if (t0 >= 1 || t1 <= 0) return r2 * atan2(cross(p, q), dot(p, q));
  double in[2] = {p[0], p[1]}, out[2] = {q[0], q[1]};
  if (t0 > 0) {
    for (int i = 0; i < 2; i++) in[i] = p[i] + t0 * d[i];
    sum += r2 * atan2(cross(p, in), dot(p, in));
  }
  if (t1 < 1) {
    for (int i = 0; i < 2; i++) out[i] = p[i] + t1 * d[i];
    sum += r2 * atan2(cross(out, q), dot(out, q));
  }
  return sum + cross(in, out);
}

static double circle_area(const Polygon *g, double r2) {
  double sum = 0;
  for (int i = 0; i < g->n; i++) sum += edge_area(g->p[i], g->p[(i + 1) % g->n], r2);
  return 0.5 * fabs(sum);
}

static void set_rectangle(const double low[2], const double high[2], Polygon *g) {
  g->n = 4;
  for (int i = 0; i < 4; i++) {
    g->p[i][0] = i == 1 || i == 2 ? high[0] : low[0];
    g->p[i][1] = i >= 2 ? high[1] : low[1];
  }
}

/// Keep what lies where a x + b y <= c.
static void clip(Polygon *g, double a, double b, double c) {
  Polygon to = {.n = 0};
  for (int i = 0; i < g->n; i++) {
    const double *p = g->p[i], *q = g->p[(i + 1) % g->n];
    double at_p = a * p[0] + b * p[1] - c, at_q = a * q[0] + b * q[1] - c;
    if (at_p <= 0) memcpy(to.p[to.n++], p, sizeof to.p[0]);
    if ((at_p < 0 && at_q > 0) || (at_p > 0 && at_q < 0)) {
      double t = at_p / (at_p - at_q);
      for (int k = 0; k < 2; k++) to.p[to.n][k] = p[k] + t * (q[k] - p[k]);
      to.n++;
    }
  }
  *g = to;
}

/// --- quadrics ---

/// The ball (is_round = 0) or endless cylinder along d (1) of radius r at c, where normal . x <= offset for all
/// planes; axes in an order that makes sections across axis 2 ellipses.
typedef struct Region {
  double c[3], d[3], r;
  int is_long;
  int n_planes;
  double normal[2][3], offset[2];
  double low[3], high[3]; ///< of the box
} Region;

/// Area of the section at w inside the box.
static double section(const Region *g, double w) {
  Polygon p;
  double s = w - g->c[2], r2 = g->r * g->r;
  set_rectangle(g->low, g->high, &p);
  for (int m = 0; m < g->n_planes && p.n > 0; m++)
    clip(&p, g->normal[m][0], g->normal[m][1], g->offset[m] - g->normal[m][2] * w);
  if (!g->is_long) {
    r2 -= s * s;
    if (!(r2 > 0)) return 0;
    for (int i = 0; i < p.n; i++)
      for (int k = 0; k < 2; k++) p.p[i][k] -= g->c[k];
    return circle_area(&p, r2);
  }

  // an ellipse: shorten it along the axis' shadow to a circle
  double along = hypot(g->d[0], g->d[1]), e[2] = {1, 0}, tilt = fabs(g->d[2]);
  if (along > 0) e[0] = g->d[0] / along, e[1] = g->d[1] / along;
  for (int i = 0; i < p.n; i++) {
    double x = p.p[i][0] - g->c[0] - g->d[0] / g->d[2] * s;
    double y = p.p[i][1] - g->c[1] - g->d[1] / g->d[2] * s;
    p.p[i][0] = (e[0] * x + e[1] * y) * tilt;
    p.p[i][1] = e[0] * y - e[1] * x;
  }
  return circle_area(&p, r2) / tilt;
}

/// Places along axis 2 where the section is not smooth.
typedef struct Breaks {
  int n;
  double w[BREAKS_MAX];
  double low, high; ///< of the box
} Breaks;

static void add_break(Breaks *b, double w) {
  double size = b->high - b->low;
  if (!(w > b->low - size && w < b->high + size) || b->n == BREAKS_MAX) return;
  int i = b->n++;
  for (; i > 0 && b->w[i - 1] > w; i--) b->w[i] = b->w[i - 1];
  b->w[i] = w;
}

/// Roots of A s^2 + 2 B s + C behind `from`.
static void add_roots(Breaks *b, double from, double A, double B, double C) {
  double disc = B * B - A * C;
  if (!(disc >= 0)) return;
  double q = B >= 0 ? -B - sqrt(disc) : -B + sqrt(disc);
  if (A != 0) add_break(b, from + q / A);
  if (q != 0) add_break(b, from + C / q);
}

/// Where the quadric meets the box's edges along axis 2, or touches its sides.
static void add_sides(const Region *g, Breaks *b) {
  double k = g->is_long, r2 = g->r * g->r;
  const double *d = g->d;
  for (int side = 0; side < 4; side++) {
    double x = (side & 1 ? g->high[0] : g->low[0]) - g->c[0];
    double y = (side & 2 ? g->high[1] : g->low[1]) - g->c[1], t = x * d[0] + y * d[1];
    add_roots(b, g->c[2], 1 - k * d[2] * d[2], -k * d[2] * t, x * x + y * y - k * t * t - r2);
  }
  for (int side = 0; side < 4; side++) {
    int i = side & 1; // across axis i; the section's extreme along the other
    double x = (side & 2 ? g->high[i] : g->low[i]) - g->c[i];
    double below = 1 - k * d[1 - i] * d[1 - i], f = k / below;
    add_roots(b, g->c[2], 1 - f * d[2] * d[2], -f * x * d[i] * d[2],
              x * x * (1 - f * d[i] * d[i]) - r2);
  }
  if (!g->is_long) {
    add_break(b, g->c[2] - g->r);
    add_break(b, g->c[2] + g->r);
  }
}

/// Where a plane meets the box's edges, and the curve on it the box's sides; the ends of that curve.
static void add_plane(const Region *g, const double n[3], double offset, Breaks *b) {
  double k = g->is_long, r2 = g->r * g->r, from_c = offset - lth_v3_dot(n, g->c);
  const double *d = g->d;
  for (int side = 0; side < 4; side++) {
    double u = side & 1 ? g->high[0] : g->low[0], v = side & 2 ? g->high[1] : g->low[1];
    if (n[2] != 0) add_break(b, (offset - n[0] * u - n[1] * v) / n[2]);
  }
  for (int side = 0; side < 4; side++) {
    int i = side & 1, j = 1 - i;
    double x = (side & 2 ? g->high[i] : g->low[i]) - g->c[i];
    if (!(fabs(n[j]) > 1e-12)) continue;
    double y0 = (from_c - n[i] * x) / n[j], y1 = -n[2] / n[j]; // y = y0 + y1 s on the plane
    double t0 = x * d[i] + y0 * d[j], t1 = y1 * d[j] + d[2];
    add_roots(b, g->c[2], 1 + y1 * y1 - k * t1 * t1, y0 * y1 - k * t0 * t1,
              x * x + y0 * y0 - k * t0 * t0 - r2);
  }
  double radius2 = r2 - (1 - k) * from_c * from_c;
  if (!(radius2 > 0)) return;
  double reach = sqrt(radius2 * fmax(0, 1 - n[2] * n[2])), middle = g->c[2] + from_c * n[2];
  add_break(b, middle - reach);
  add_break(b, middle + reach);
}

/// Points and weights of Gauss' rule on [0, 1].
static const double gauss_point[N_POINTS] = {
    0.013046735741414128, 0.067468316655507732, 0.160295215850487796, 0.283302302935376405,
    0.425562830509184394, 0.574437169490815606, 0.716697697064623595, 0.839704784149512204,
    0.932531683344492268, 0.986953264258585872};
static const double gauss_weight[N_POINTS] = {
    0.033335672154344069, 0.074725674575290296, 0.109543181257991022, 0.134633359654998178,
    0.147762112357376435, 0.147762112357376435, 0.134633359654998178, 0.109543181257991022,
    0.074725674575290296, 0.033335672154344069};

/// From low to high between two breaks, with w = middle - half cos(theta) there, which makes roots at the breaks
/// smooth, also of those that are just beyond the box.
static double integrate(const Region *g, const double breaks[2], double low, double high) {
  double sum = 0, half = 0.5 * (breaks[1] - breaks[0]), middle = 0.5 * (breaks[0] + breaks[1]);
  double first = acos(fmin(fmax((middle - low) / half, -1), 1));
  double last = acos(fmin(fmax((middle - high) / half, -1), 1));
  for (int i = 0; i < N_POINTS; i++) {
    double angle = first + (last - first) * gauss_point[i];
    sum += gauss_weight[i] * sin(angle) * section(g, middle - half * cos(angle));
  }
  return (last - first) * half * sum;
}

static double region_volume(const Region *g) {
  Breaks b = {.low = g->low[2], .high = g->high[2]};
  double sum = 0, size = b.high - b.low, ends[2] = {b.low - size, 0};
  add_sides(g, &b);
  for (int m = 0; m < g->n_planes; m++) add_plane(g, g->normal[m], g->offset[m], &b);
  for (int i = 0; i <= b.n; i++, ends[0] = ends[1]) {
    ends[1] = i < b.n ? b.w[i] : b.high + size;
    double from = fmax(ends[0], b.low), to = fmin(ends[1], b.high);
    if (!(to > from)) continue;
    int n = (int)fmin(ceil((to - from) / (PIECE * g->r)), PIECES_MAX);
    for (int k = 0; k < n; k++)
      sum += integrate(g, ends, from + (to - from) * k / n, from + (to - from) * (k + 1) / n);
  }
  return sum;
}

/// --- shapes ---

static int largest_axis(const double d[3]) {
  int axis = fabs(d[1]) > fabs(d[0]) ? 1 : 0;
  return fabs(d[2]) > fabs(d[axis]) ? 2 : axis;
}

/// Overlap with a ball or an endless cylinder at c along d between places `from` and `to` along d behind c.
static double between(const double c[3], const double d[3], double r, int is_long, double from,
                      double to, const double low[3], const double high[3]) {
  Region g = {.r = r, .is_long = is_long};
  int last = largest_axis(d);
  for (int i = 0; i < 3; i++) {
    int axis = (last + 1 + i) % 3;
    g.c[i] = c[axis], g.d[i] = d[axis];
    g.low[i] = low[axis], g.high[i] = high[axis];
  }
  double at_c = lth_v3_dot(g.c, g.d);
  for (int m = 0; m < 2; m++) {
    double place = m ? to : -from, sign = m ? 1 : -1;
    if (isinf(place)) continue;
    for (int i = 0; i < 3; i++) g.normal[g.n_planes][i] = sign * g.d[i];
    g.offset[g.n_planes++] = place + sign * at_c;
  }
  return region_volume(&g);
}

static double ball_volume(const double c[3], double r, const double low[3], const double high[3]) {
  static const double d[3] = {0, 0, 1};
  return between(c, d, r, 0, -INFINITY, INFINITY, low, high);
}

static double long_volume(const LthShape *s, const double low[3], const double high[3]) {
  double d[3];
  lth_v3_sub(s->b, s->a, d);
  double length = lth_v3_normalize(d), sum = between(s->a, d, s->radius, 1, 0, length, low, high);
  if (s->kind == LTH_SHAPE_CYLINDER) return sum;
  sum += between(s->a, d, s->radius, 0, -INFINITY, 0, low, high);
  return sum + between(s->b, d, s->radius, 0, 0, INFINITY, low, high);
}

static double box_volume(const LthShape *s, const double low[3], const double high[3]) {
  double volume = 1;
  for (int a = 0; a < 3; a++) volume *= fmax(0, fmin(high[a], s->b[a]) - fmax(low[a], s->a[a]));
  return volume;
}

bool lth_box_overlap(const LthShape *s, const double low[3], const double high[3], double *volume) {
  switch (s->kind) {
  case LTH_SHAPE_BOX:
    *volume = box_volume(s, low, high);
    return true;
  case LTH_SHAPE_SPHERE:
    *volume = ball_volume(s->a, s->radius, low, high);
    return true;
  case LTH_SHAPE_SHELL:
    *volume = ball_volume(s->a, s->radius, low, high) - ball_volume(s->a, s->inner, low, high);
    return true;
  case LTH_SHAPE_CYLINDER:
  case LTH_SHAPE_CAPSULE:
    *volume = long_volume(s, low, high);
    return true;
  default:
    return false;
  }
}

/// --- planes ---

double lth_box_overlap_plane(const double half[3], const double n[3], double d) {
  double m[3], reach = 0, sum = 0, below = 1;
  int k = 0;
  for (int a = 0; a < 3; a++) reach += fabs(n[a]) * half[a];
  if (d >= reach) return 0;
  if (d <= -reach) return 1;

  // depth of the deepest corner, over the widths of the box along the normal but for what is next to nothing
  double depth = -d;
  for (int a = 0; a < 3; a++) {
    double width = 2 * fabs(n[a]) * half[a];
    if (width > LEVEL * reach) m[k++] = width, depth += 0.5 * width;
  }

  // the corner simplices beyond the corners, in and out
  for (int corner = 0; corner < 1 << k; corner++) {
    double t = depth, sign = 1;
    for (int a = 0; a < k; a++)
      if (corner >> a & 1) t -= m[a], sign = -sign;
    if (t > 0) sum += sign * (k == 3 ? t * t * t : k == 2 ? t * t : t);
  }
  for (int a = 0; a < k; a++) below *= m[a] * (a + 1);
  return fmin(fmax(sum / below, 0), 1);
}
