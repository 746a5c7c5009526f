/// Triangle against triangle by exact signs, after Guigue and Devillers (2003) in spirit: everything is
/// reduced to whether a segment meets a triangle.
#include "geometry/tri_tri.h"

#include "base/tensor.h"
#include "geometry/predicates.h"

typedef struct Triangle {
  const double *p[3];
} Triangle;

// ------------------------------------------------------------------ in a common plane

/// The two coordinates in which a triangle with area keeps an area.
static void pick_plane(const Triangle *t, int *u, int *v) {
  double e[3], f[3], normal[3];
  lth_v3_sub(t->p[1], t->p[0], e);
  lth_v3_sub(t->p[2], t->p[0], f);
  lth_v3_cross(e, f, normal);
  int axis = 0;
  for (int i = 1; i < 3; i++)
    if (fabs(normal[i]) > fabs(normal[axis])) axis = i;
  for (int tries = 0; tries < 3; tries++, axis = (axis + 1) % 3) {
    *u = (axis + 1) % 3;
    *v = (axis + 2) % 3;
    double a[2] = {t->p[0][*u], t->p[0][*v]}, b[2] = {t->p[1][*u], t->p[1][*v]},
           c[2] = {t->p[2][*u], t->p[2][*v]};
    if (lth_orient2d(a, b, c) != 0) return;
  }
}

static bool between(double x, double a, double b) {
  return a <= b ? a <= x && x <= b : b <= x && x <= a;
}

/// c lies on the closed segment ab, given that the three are collinear.
static bool on_segment(const double a[2], const double b[2], const double c[2]) {
  return between(c[0], a[0], b[0]) && between(c[1], a[1], b[1]);
}

static bool segments_meet(const double a[2], const double b[2], const double c[2],
                          const double d[2]) {
  int abc = lth_orient2d(a, b, c), abd = lth_orient2d(a, b, d);
  int cda = lth_orient2d(c, d, a), cdb = lth_orient2d(c, d, b);
  if (abc == 0 && abd == 0 && cda == 0 && cdb == 0)
    return on_segment(a, b, c) || on_segment(a, b, d) || on_segment(c, d, a) || on_segment(c, d, b);
  return abc * abd <= 0 && cda * cdb <= 0;
}

static bool in_triangle2(const double x[2], double corner[3][2]) {
  int n_left = 0, n_right = 0;
  for (int i = 0; i < 3; i++) {
    int side = lth_orient2d(corner[i], corner[(i + 1) % 3], x);
    n_left += side > 0;
    n_right += side < 0;
  }
  return n_left == 0 || n_right == 0;
}

/// Segment pq and triangle t lie in one plane.
static bool segment_meets_coplanar(const double p[3], const double q[3], const Triangle *t) {
  int u = 0, v = 1;
  double corner[3][2];
  pick_plane(t, &u, &v);
  double a[2] = {p[u], p[v]}, b[2] = {q[u], q[v]};
  for (int i = 0; i < 3; i++) corner[i][0] = t->p[i][u], corner[i][1] = t->p[i][v];
  if (in_triangle2(a, corner) || in_triangle2(b, corner)) return true;
  for (int i = 0; i < 3; i++)
    if (segments_meet(a, b, corner[i], corner[(i + 1) % 3])) return true;
  return false;
}

// ------------------------------------------------------------------ in space

static int side(const Triangle *t, const double x[3]) {
  return lth_orient3d(t->p[0], t->p[1], t->p[2], x);
}

/// The closed segment pq meets the closed triangle; side_p and side_q are those of its plane.
static bool segment_meets(const double p[3], const double q[3], int side_p, int side_q,
                          const Triangle *t) {
  if (side_p == 0 && side_q == 0) return segment_meets_coplanar(p, q, t);
  if (side_p * side_q > 0) return false;
  int n_left = 0, n_right = 0;
  for (int i = 0; i < 3; i++) {
    int turn = lth_orient3d(p, q, t->p[i], t->p[(i + 1) % 3]);
    n_left += turn > 0;
    n_right += turn < 0;
  }
  return n_left == 0 || n_right == 0;
}

/// All three on the same side of a plane, not on it.
static bool apart(const int side_of[3]) {
  return (side_of[0] > 0 && side_of[1] > 0 && side_of[2] > 0) ||
         (side_of[0] < 0 && side_of[1] < 0 && side_of[2] < 0);
}

static bool cross_unshared(const Triangle *s, const Triangle *t) {
  int s_side[3], t_side[3];
  for (int i = 0; i < 3; i++) t_side[i] = side(s, t->p[i]);
  if (apart(t_side)) return false;
  for (int i = 0; i < 3; i++) s_side[i] = side(t, s->p[i]);
  if (apart(s_side)) return false;
  for (int i = 0; i < 3; i++) {
    int j = (i + 1) % 3;
    if (segment_meets(t->p[i], t->p[j], t_side[i], t_side[j], s)) return true;
    if (segment_meets(s->p[i], s->p[j], s_side[i], s_side[j], t)) return true;
  }
  return false;
}

/// Corner 0 of both is the same point. What they have in common beyond it reaches out to a point that
/// lies on the opposite edge of one of them.
static bool cross_at_corner(const Triangle *s, const Triangle *t) {
  int t1 = side(s, t->p[1]), t2 = side(s, t->p[2]);
  if (t1 * t2 > 0) return false;
  int s1 = side(t, s->p[1]), s2 = side(t, s->p[2]);
  if (s1 * s2 > 0) return false;
  return segment_meets(t->p[1], t->p[2], t1, t2, s) || segment_meets(s->p[1], s->p[2], s1, s2, t);
}

/// Corners 0 and 1 of both are the same: they can only be folded onto each other.
static bool cross_at_edge(const Triangle *s, const Triangle *t) {
  if (side(s, t->p[2]) != 0) return false;
  int u = 0, v = 1;
  pick_plane(s, &u, &v);
  double a[2] = {s->p[0][u], s->p[0][v]}, b[2] = {s->p[1][u], s->p[1][v]},
         c[2] = {s->p[2][u], s->p[2][v]}, d[2] = {t->p[2][u], t->p[2][v]};
  return lth_orient2d(a, b, c) == lth_orient2d(a, b, d);
}

/// Corners with shared points first and in the same order; returns their number.
static int align(const double *points, const LitheIndex s[3], const LitheIndex t[3], Triangle *a,
                 Triangle *b) {
  int n = 0, n_a = 0, n_b = 0;
  bool a_used[3] = {false}, b_used[3] = {false};
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      if (s[i] == t[j]) {
        a->p[n] = b->p[n] = points + 3 * (size_t)s[i];
        a_used[i] = b_used[j] = true;
        n++;
      }
  n_a = n_b = n;
  for (int i = 0; i < 3; i++) {
    if (!a_used[i]) a->p[n_a++] = points + 3 * (size_t)s[i];
    if (!b_used[i]) b->p[n_b++] = points + 3 * (size_t)t[i];
  }
  return n;
}

bool lth_triangles_cross(const double *points, const LitheIndex s[3], const LitheIndex t[3]) {
  Triangle a, b;
  switch (align(points, s, t, &a, &b)) {
  case 0:
    return cross_unshared(&a, &b);
  case 1:
    return cross_at_corner(&a, &b);
  case 2:
    return cross_at_edge(&a, &b);
  default:
    return false;
  }
}

// ------------------------------------------------------------------ where, for showing only

typedef struct Spread {
  int n;
  double at[32][3];
} Spread;

static void add_point(Spread *spread, const double x[3]) {
  if (spread->n < 32) lth_v3_copy(x, spread->at[spread->n++]);
}

/// Where edges of `s` pass through `t`, and corners of `s` that lie in it.
static void collect(const Triangle *s, const Triangle *t, Spread *spread) {
  int side_of[3];
  for (int i = 0; i < 3; i++) side_of[i] = side(t, s->p[i]);
  for (int i = 0; i < 3; i++) {
    const double *p = s->p[i], *q = s->p[(i + 1) % 3];
    int sp = side_of[i], sq = side_of[(i + 1) % 3];
    if (!segment_meets(p, q, sp, sq, t)) continue;
    if (sp == 0 && segment_meets(p, p, 0, 0, t)) add_point(spread, p);
    if (sq == 0 && segment_meets(q, q, 0, 0, t)) add_point(spread, q);
    if (sp == 0 || sq == 0) continue;
    double e[3], f[3], normal[3], x[3], to_p[3], to_q[3];
    lth_v3_sub(t->p[1], t->p[0], e);
    lth_v3_sub(t->p[2], t->p[0], f);
    lth_v3_cross(e, f, normal);
    lth_v3_sub(p, t->p[0], to_p);
    lth_v3_sub(q, t->p[0], to_q);
    double hp = fabs(lth_v3_dot(normal, to_p)), hq = fabs(lth_v3_dot(normal, to_q));
    double share = hp + hq > 0 ? hp / (hp + hq) : 0.5;
    for (int k = 0; k < 3; k++) x[k] = p[k] + share * (q[k] - p[k]);
    add_point(spread, x);
  }
}

void lth_triangles_crossing(const double *points, const LitheIndex s[3], const LitheIndex t[3],
                            double segment[6]) {
  Triangle a, b;
  Spread spread = {0};
  double longest = -1;
  align(points, s, t, &a, &b);
  collect(&a, &b, &spread);
  collect(&b, &a, &spread);
  // coplanar edges that only cross each other give no point of their own: an edge stands for them
  if (spread.n == 0) add_point(&spread, a.p[2]), add_point(&spread, b.p[2]);
  for (int i = 0; i < spread.n; i++)
    for (int j = i; j < spread.n; j++) {
      double length = lth_v3_distance(spread.at[i], spread.at[j]);
      if (length <= longest) continue;
      longest = length;
      lth_v3_copy(spread.at[i], segment);
      lth_v3_copy(spread.at[j], segment + 3);
    }
}
