/// A tree of triangles with the moments of every node: solid angles of near triangles exactly, of far
/// groups by the kernel's Taylor polynomial of degree two about the group's centre.
#include "geometry/winding.h"

#include "base/tensor.h"
#include "geometry/bvh.h"

#define STACK_MAX 96
#define OPENING_FIRST 2.0
#define OPENING_LAST 16.0
#define NEAR_OPENING 4.0 ///< of groups, seen from any place of a box
#define NEAR_SMOOTH                                                                                \
  5.0 ///< of half a box's diagonal: what is farther from its middle is smooth all over it
#define DECIDED 1e-3 ///< an error that is not worth opening more groups for

/// What a group of triangles looks like from afar; n dA is an area vector, r the place from the centre.
typedef struct Group {
  double center[3];
  double radius; ///< of a ball about the centre that holds all triangles [m]
  double cube;   ///< bound on int |r|^3 dA [m^5]
  double n[3];   ///< int n dA
  double m[6];   ///< int sym(n r) dA: xx xy xz yy yz zz
  double s[10];  ///< int sym(n r r) dA: xxx xxy xxz xyy xyz xzz yyy yyz yzz zzz
} Group;

struct LthWinding {
  LitheIndex n_tris;
  double *corners;           ///< in the order of the leaves      (n_tris x 9)
  LitheIndex *first, *count; ///< triangles of each node          (n_nodes)
  Group *group;              ///< of each node                    (n_nodes)
  LthBvh *bvh;
};

static const double *corner(const LthWinding *w, LitheIndex tri, int k) {
  return w->corners + 9 * (size_t)tri + 3 * (size_t)k;
}

/// --- building ---

/// Area vector n A of a triangle.
static void area_vector(const LthWinding *w, LitheIndex tri, double v[3]) {
  double e[3], f[3];
  lth_v3_sub(corner(w, tri, 1), corner(w, tri, 0), e);
  lth_v3_sub(corner(w, tri, 2), corner(w, tri, 0), f);
  lth_v3_cross(e, f, v);
  lth_v3_scale(0.5, v);
}

/// The centre of a node's area, and a ball around it.
static void find_ball(const LthWinding *w, LitheIndex node, Group *g) {
  LitheIndex first = w->first[node], end = first + w->count[node];
  const double *box = w->bvh->box + 6 * (size_t)node;
  double middle[3], sum[3] = {0, 0, 0}, v[3], d[3], area_all = 0;
  for (int i = 0; i < 3; i++) middle[i] = 0.5 * (box[i] + box[3 + i]);
  for (LitheIndex t = first; t < end; t++) {
    area_vector(w, t, v);
    double area = lth_v3_norm(v);
    area_all += area;
    for (int k = 0; k < 3; k++) {
      lth_v3_sub(corner(w, t, k), middle, d);
      lth_v3_axpy(area / 3, d, sum);
    }
  }
  lth_v3_copy(middle, g->center);
  if (area_all > 0) lth_v3_axpy(1 / area_all, sum, g->center);
  for (LitheIndex t = first; t < end; t++)
    for (int k = 0; k < 3; k++)
      g->radius = fmax(g->radius, lth_v3_distance(corner(w, t, k), g->center));
}

/// Add int n, int sym(n r) and int sym(n r r) of a triangle: its first and second moments are
/// A s / 3 and A (s s + a a + b b + c c) / 12 with s = a + b + c.
static void add_moments(const LthWinding *w, LitheIndex tri, Group *g) {
  double v[3], r[3][3], s[3] = {0, 0, 0}, q[3][3];
  area_vector(w, tri, v);
  for (int k = 0; k < 3; k++) {
    lth_v3_sub(corner(w, tri, k), g->center, r[k]);
    lth_v3_add(s, r[k], s);
  }
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      q[i][j] = (s[i] * s[j] + r[0][i] * r[0][j] + r[1][i] * r[1][j] + r[2][i] * r[2][j]) / 12;
  // |r|^3 is convex: its mean over a triangle is at most that over the corners
  double area = lth_v3_norm(v);
  for (int k = 0; k < 3; k++) g->cube += area / 3 * pow(lth_v3_norm(r[k]), 3);
  lth_v3_add(g->n, v, g->n);
  for (int i = 0, p = 0, t = 0; i < 3; i++)
    for (int j = i; j < 3; j++) {
      g->m[p++] += (v[i] * s[j] + v[j] * s[i]) / 6;
      for (int k = j; k < 3; k++)
        g->s[t++] += (v[i] * q[j][k] + v[j] * q[i][k] + v[k] * q[i][j]) / 3;
    }
}

static void make_groups(LitheCtx *ctx, LthWinding *w) {
  const LthBvh *t = w->bvh;
  for (LitheIndex node = t->n_nodes - 1; node >= 0; node--) { // children come behind their parents
    bool is_leaf = t->right[node] < 0;
    w->first[node] = is_leaf ? t->first[node] : w->first[node + 1];
    w->count[node] = is_leaf ? t->count[node] : w->count[node + 1] + w->count[t->right[node]];
  }
#pragma omp parallel for schedule(dynamic, 64) num_threads(lth_threads(ctx))
  for (LitheIndex node = 0; node < t->n_nodes; node++) {
    Group *g = &w->group[node];
    find_ball(w, node, g);
    for (LitheIndex i = w->first[node]; i < w->first[node] + w->count[node]; i++)
      add_moments(w, i, g);
  }
}

static LitheStatus copy_corners(LitheCtx *ctx, LthWinding *w, const double *points,
                                const LitheIndex *tris) {
  LitheStatus status = LITHE_OK;
  double *boxes = NULL;
  LTH_NEW(ctx, boxes, 6 * (LitheCount)w->n_tris);
  for (LitheIndex t = 0; t < w->n_tris; t++)
    for (int i = 0; i < 3; i++) {
      const LitheIndex *p = tris + 3 * (size_t)t;
      double a = points[3 * (size_t)p[0] + (size_t)i], b = points[3 * (size_t)p[1] + (size_t)i],
             c = points[3 * (size_t)p[2] + (size_t)i];
      boxes[6 * (size_t)t + (size_t)i] = fmin(a, fmin(b, c));
      boxes[6 * (size_t)t + 3 + (size_t)i] = fmax(a, fmax(b, c));
    }
  LITHE_TRY_OR(done, lth_bvh_create_boxes(ctx, w->n_tris, boxes, &w->bvh));
  LTH_NEW_OR(done, ctx, w->corners, 9 * (LitheCount)w->n_tris);
  for (LitheIndex t = 0; t < w->n_tris; t++)
    for (int k = 0; k < 3; k++)
      lth_v3_copy(points + 3 * (size_t)tris[3 * (size_t)w->bvh->item[t] + (size_t)k],
                  w->corners + 9 * (size_t)t + 3 * (size_t)k);
done:
  lth_free(ctx, boxes);
  return status;
}

LitheStatus lth_winding_create(LitheCtx *ctx, LitheIndex n_tris, const double *points,
                               const LitheIndex *tris, LthWinding **winding) {
  LitheStatus status = LITHE_OK;
  LthWinding *w = NULL;
  *winding = NULL;
  LTH_NEW(ctx, w, 1);
  w->n_tris = n_tris;
  LITHE_TRY_OR(done, copy_corners(ctx, w, points, tris));
  LTH_NEW_OR(done, ctx, w->first, w->bvh->n_nodes);
  LTH_NEW_OR(done, ctx, w->count, w->bvh->n_nodes);
  LTH_NEW_OR(done, ctx, w->group, w->bvh->n_nodes);
  make_groups(ctx, w);
done:
  if (status != LITHE_OK) lth_winding_destroy(ctx, &w);
  *winding = w;
  return status;
}

void lth_winding_destroy(LitheCtx *ctx, LthWinding **winding) {
  if (!winding || !*winding) return;
  LthWinding *w = *winding;
  lth_bvh_destroy(ctx, &w->bvh);
  lth_free(ctx, w->corners);
  lth_free(ctx, w->first);
  lth_free(ctx, w->count);
  lth_free(ctx, w->group);
  lth_free(ctx, w);
  *winding = NULL;
}

/// --- asking ---

/// Solid angle of a group seen from its centre - d, inv = 1 / |d|: winding.md, equation (4).
static double far_angle(const Group *g, const double d[3], double inv) {
  const double *m = g->m, *s = g->s;
  double x = d[0], y = d[1], z = d[2];
  double n_d = lth_v3_dot(g->n, d);
  double trace = m[0] + m[3] + m[5];
  double m_dd =
      m[0] * x * x + m[3] * y * y + m[5] * z * z + 2 * (m[1] * x * y + m[2] * x * z + m[4] * y * z);
  double s_d = (s[0] + s[3] + s[5]) * x + (s[1] + s[6] + s[8]) * y + (s[2] + s[7] + s[9]) * z;
  double s_ddd = s[0] * x * x * x + s[6] * y * y * y + s[9] * z * z * z +
                 3 * (s[1] * x * x * y + s[2] * x * x * z + s[3] * x * y * y + s[5] * x * z * z +
                      s[7] * y * y * z + s[8] * y * z * z) +
                 6 * s[4] * x * y * z;
  double inv2 = inv * inv;
  return inv2 * inv * (n_d + trace + inv2 * (-3 * m_dd - 4.5 * s_d + 7.5 * inv2 * s_ddd));
}

static double near_angle(const LthWinding *w, LitheIndex first, LitheIndex count,
                         const double x[3]) {
  double sum = 0;
  for (LitheIndex t = first; t < first + count; t++)
    sum += lth_solid_angle(corner(w, t, 0), corner(w, t, 1), corner(w, t, 2), x);
  return sum;
}

double lth_winding_number(const LthWinding *w, const double x[3], double opening, double *bound) {
  LitheIndex stack[STACK_MAX];
  double sum = 0, error = 0, opening2 = opening * opening;

  // (4 - 3 q) / (1 - q)^2 of equation (5) lies below its chord from q = 0 to the largest, 1 / opening
  double largest = 1 / opening;
  double slope = ((4 - 3 * largest) / ((1 - largest) * (1 - largest)) - 4) / largest;
  int top = 0;
  stack[top++] = 0;
  while (top > 0) {
    LitheIndex node = stack[--top];
    const Group *g = &w->group[node];
    double d[3];
    lth_v3_sub(g->center, x, d);
    double d2 = lth_v3_dot(d, d);
    if (d2 > opening2 * g->radius * g->radius) {
      double inv = 1 / sqrt(d2), inv2 = inv * inv;
      sum += far_angle(g, d, inv);
      error += g->cube * inv2 * inv2 * inv * (4 + slope * g->radius * inv);
    } else if (w->bvh->right[node] < 0) {
      sum += near_angle(w, w->first[node], w->count[node], x);
    } else {
      LITHE_ASSERT(top + 2 <= STACK_MAX);
      stack[top++] = w->bvh->right[node];
      stack[top++] = node + 1;
    }
  }
  if (bound) *bound = error / (4 * M_PI);
  return sum / (4 * M_PI);
}

double lth_winding_direct(const LthWinding *w, const double x[3]) {
  return near_angle(w, 0, w->n_tris, x) / (4 * M_PI);
}

bool lth_winding_inside(const LthWinding *w, const double x[3]) {
  double number = 0, bound = 0;
  for (double opening = OPENING_FIRST; opening <= OPENING_LAST; opening *= 2) {
    number = lth_winding_number(w, x, opening, &bound);
    if (fabs(number - 0.5) > bound || bound < DECIDED) break;
  }
  return number > 0.5;
}

/// --- many places in a box ---

/// Weights of three equally spaced places for one at t in [-1, 1].
static void parabola(double t, double w[3]) {
  w[0] = 0.5 * t * (t - 1);
  w[1] = 1 - t * t;
  w[2] = 0.5 * t * (t + 1);
}

static double far_number(const LthWindingNear *near, const double x[3]) {
  double w[3][3], sum = 0;
  for (int a = 0; a < 3; a++) parabola((x[a] - near->center[a]) / near->half[a], w[a]);
  for (int k = 0; k < 27; k++) sum += w[0][k % 3] * w[1][k / 3 % 3] * w[2][k / 9] * near->far[k];
  return sum;
}

static void far_place(const LthWindingNear *near, int k, double x[3]) {
  int at[3] = {k % 3, k / 3 % 3, k / 9};
  for (int a = 0; a < 3; a++) x[a] = near->center[a] + (at[a] - 1) * near->half[a];
}

static void add_far(const Group *g, LthWindingNear *near) {
  for (int k = 0; k < 27; k++) {
    double x[3], d[3];
    far_place(near, k, x);
    lth_v3_sub(g->center, x, d);
    near->far[k] += far_angle(g, d, 1 / lth_v3_norm(d)) / (4 * M_PI);
  }
}

/// Below one node; false where there is no room for what is near.
static bool sort_node(LitheIndex root, double radius, LthWindingNear *near) {
  const LthWinding *w = near->winding;
  LitheIndex stack[STACK_MAX];
  int top = 0;
  stack[top++] = root;
  while (top > 0) {
    LitheIndex node = stack[--top];
    const Group *g = &w->group[node];
    double d = lth_v3_distance(g->center, near->center);
    if (d - radius > NEAR_OPENING * g->radius && d > NEAR_SMOOTH * radius) {
      add_far(g, near);
    } else if (w->bvh->right[node] < 0) {
      if (near->n == LTH_WINDING_NEAR) return false;
      near->leaf[near->n++] = node;
    } else {
      LITHE_ASSERT(top + 2 <= STACK_MAX);
      stack[top++] = w->bvh->right[node];
      stack[top++] = node + 1;
    }
  }
  return true;
}

bool lth_winding_near(const LthWinding *w, const LthWindingNear *larger, const double center[3],
                      const double half[3], LthWindingNear *near) {
  double radius = lth_v3_norm(half), x[3];
  near->winding = w;
  near->n = 0;
  lth_v3_copy(center, near->center);
  lth_v3_copy(half, near->half);
  for (int k = 0; k < 27; k++) {
    near->far[k] = 0;
    far_place(near, k, x);
    if (larger) near->far[k] = far_number(larger, x);
  }
  if (!larger) return sort_node(0, radius, near);
  for (int i = 0; i < larger->n; i++)
    if (!sort_node(larger->leaf[i], radius, near)) return false;
  return true;
}

double lth_winding_near_number(const LthWindingNear *near, const double x[3]) {
  const LthWinding *w = near->winding;
  double sum = 0;
  for (int i = 0; i < near->n; i++)
    sum += near_angle(w, w->first[near->leaf[i]], w->count[near->leaf[i]], x);
  return far_number(near, x) + sum / (4 * M_PI);
}
