/// Moments of polyhedra and planar faces by Euler's theorem on homogeneous functions.
/// Kaufmann et al. 2009, section 5; Mirtich 1996 for the reduction volume -> face -> edge; Chin, Lasserre,
/// Sukumar 2015 for the recursion.
///
/// A monomial m of degree d obeys (x - x0) . grad m = d m - x0 . grad m, so that the divergence theorem
/// turns its integral over a cell, a face and an edge into integrals one dimension lower and of one
/// degree less: docs/theory/integration.md, eqs. (3) to (6). One pass in graded order over the monomials
/// gives all of them, ten operations each. Everything runs in xi = (x - center) / scale, which is where
/// the far-away polyhedron loses its offset, and with triple products instead of normals, which are
/// right under any scale and sum to zero over a closed cell even where faces are planar only to rounding.
#include "geometry/moments.h"

#include "base/tensor.h"

#define MAX_P LTH_MOMENT_MAX_DEGREE
#define N3 ((MAX_P + 1) * (MAX_P + 2) * (MAX_P + 3) / 6)
#define N2 ((MAX_P + 1) * (MAX_P + 2) / 2)

/// One step of the recursion: monomial q from those of one degree less. Where an exponent is 0 its
/// weight is 0 and its place is 0, so that loops need no branch.
typedef struct Step {
  double weight[3]; // exponents alpha_i
  double inv[3];    // 1 / (k + 1 + |alpha|): an edge, a face, a cell
  short lower[3];   // places of alpha - 1_i
  short axis;       // an axis with alpha_axis > 0
} Step;

static int exponents3[N3][3], exponents2[N2][2];
static Step steps3[N3], steps2[N2];

const int (*lth_monomial3_exponents(void))[3] { return (const int(*)[3])exponents3; }
const int (*lth_monomial2_exponents(void))[2] { return (const int(*)[2])exponents2; }

int lth_monomial3_index(int a, int b, int c) {
  int rest = b + c;
  return lth_monomials3(a + rest - 1) + rest * (rest + 1) / 2 + c;
}

int lth_monomial2_index(int a, int b) { return lth_monomials2(a + b - 1) + b; }

static void set_step(Step *step, const int e[3]) {
  int degree = e[0] + e[1] + e[2];
  for (int i = 0; i < 3; i++) {
    step->weight[i] = e[i];
    step->inv[i] = 1.0 / (i + 1 + degree);
    if (e[i] > 0) step->axis = (short)i;
  }
}

/// Fills the tables before main(), so that no caller and no thread has to care.
__attribute__((constructor)) static void build_tables(void) {
  for (int d = 0, q = 0; d <= MAX_P; d++)
    for (int rest = 0; rest <= d; rest++)
      for (int c = 0; c <= rest; c++, q++) {
        int e[3] = {d - rest, rest - c, c};
        memcpy(exponents3[q], e, sizeof e);
        set_step(&steps3[q], e);
        if (e[0]) steps3[q].lower[0] = (short)lth_monomial3_index(e[0] - 1, e[1], e[2]);
        if (e[1]) steps3[q].lower[1] = (short)lth_monomial3_index(e[0], e[1] - 1, e[2]);
        if (e[2]) steps3[q].lower[2] = (short)lth_monomial3_index(e[0], e[1], e[2] - 1);
      }
  for (int d = 0, q = 0; d <= MAX_P; d++)
    for (int b = 0; b <= d; b++, q++) {
      int e[3] = {d - b, b, 0};
      memcpy(exponents2[q], e, sizeof exponents2[q]);
      set_step(&steps2[q], e);
      if (e[0]) steps2[q].lower[0] = (short)lth_monomial2_index(e[0] - 1, e[1]);
      if (e[1]) steps2[q].lower[1] = (short)lth_monomial2_index(e[0], e[1] - 1);
    }
}

void lth_monomials3_eval(int p, const double xi[3], double *values) {
  int n = lth_monomials3(p);
  values[0] = 1;
  for (int q = 1; q < n; q++)
    values[q] = xi[steps3[q].axis] * values[steps3[q].lower[steps3[q].axis]];
}

/// sum += d * e, e(alpha) = int_0^1 (a + t (b - a))^alpha dt by eq. (5).
static inline void add_edge3(int n, const double a[3], const double b[3], double d,
                             double *restrict sum) {
  double e[N3], power[N3]; // power: b^alpha
  e[0] = power[0] = 1;
  sum[0] += d;
  for (int q = 1; q < n; q++) {
    const Step *s = &steps3[q];
    power[q] = b[s->axis] * power[s->lower[s->axis]];
    e[q] = (power[q] + s->weight[0] * a[0] * e[s->lower[0]] + s->weight[1] * a[1] * e[s->lower[1]] +
            s->weight[2] * a[2] * e[s->lower[2]]) *
           s->inv[0];
    sum[q] += d * e[q];
  }
}

static inline void add_edge2(int n, const double a[2], const double b[2], double d,
                             double *restrict sum) {
  double e[N2], power[N2];
  e[0] = power[0] = 1;
  sum[0] += d;
  for (int q = 1; q < n; q++) {
    const Step *s = &steps2[q];
    power[q] = b[s->axis] * power[s->lower[s->axis]];
    e[q] =
        (power[q] + s->weight[0] * a[0] * e[s->lower[0]] + s->weight[1] * a[1] * e[s->lower[1]]) *
        s->inv[0];
    sum[q] += d * e[q];
  }
}

static inline void to_local3(const double *point, const double center[3], const double inv_scale[3],
                             double xi[3]) {
  for (int i = 0; i < 3; i++) xi[i] = (point[i] - center[i]) * inv_scale[i];
}

/// x0 . ((a - x0) x (b - x0)): six times the signed tetrahedron of the origin, x0, a, b.
static inline double triple(const double x0[3], const double a[3], const double b[3]) {
  double u[3], v[3], w[3];
  lth_v3_sub(a, x0, u);
  lth_v3_sub(b, x0, v);
  lth_v3_cross(u, v, w);
  return lth_v3_dot(x0, w);
}

/// Twice the area of the triangle x0, a, b about the face's normal, from scaled coordinates.
static inline double twice_area(const double x0[3], const double a[3], const double b[3],
                                const double scale[3], const double normal[3]) {
  double u[3], v[3], w[3];
  for (int i = 0; i < 3; i++) u[i] = (a[i] - x0[i]) * scale[i], v[i] = (b[i] - x0[i]) * scale[i];
  lth_v3_cross(u, v, w);
  return lth_v3_dot(w, normal);
}

/// sums(alpha) = int_f xi^alpha over a face with the density d of each triangle of its fan (twice its area,
/// or six times the volume below it), by eq. (4).
static inline void face_sums(int n, const double center[3], const double scale[3],
                             const LthFaceView *face, bool volume, double *restrict sums) {
  double inv_scale[3] = {1 / scale[0], 1 / scale[1], 1 / scale[2]};
  LitheIndex base = face->loop_point[face->loop_off[0]];
  double x0[3];
  memset(sums, 0, (size_t)n * sizeof *sums);
  to_local3(face->points + 3 * base, center, inv_scale, x0);

  // edges; those that touch the base point have no triangle
  for (LitheIndex l = 0; l < face->n_loops; l++) {
    LitheIndex begin = face->loop_off[l], end = face->loop_off[l + 1];
    if (begin == end) continue;
    LitheIndex last = face->loop_point[end - 1];
    double a[3], b[3];
    to_local3(face->points + 3 * last, center, inv_scale, a);
    for (LitheIndex k = begin; k < end; k++) {
      LitheIndex next = face->loop_point[k];
      to_local3(face->points + 3 * next, center, inv_scale, b);
      if (last != base && next != base)
        add_edge3(n, a, b, volume ? triple(x0, a, b) : twice_area(x0, a, b, scale, face->normal),
                  sums);
      lth_v3_copy(b, a);
      last = next;
    }
  }
  sums[0] *= 0.5;
  for (int q = 1; q < n; q++) {
    const Step *s = &steps3[q];
    sums[q] =
        (sums[q] + s->weight[0] * x0[0] * sums[s->lower[0]] +
         s->weight[1] * x0[1] * sums[s->lower[1]] + s->weight[2] * x0[2] * sums[s->lower[2]]) *
        s->inv[1];
  }
}

void lth_moments_add_face(int p, const double center[3], const double scale[3],
                          const LthFaceView *face, double sign, double *moments) {
  LITHE_ASSERT(p >= 0 && p <= MAX_P);
  int n = lth_monomials3(p);
  double flux[N3], factor = sign * scale[0] * scale[1] * scale[2];
  face_sums(n, center, scale, face, true, flux);
  for (int q = 0; q < n; q++) moments[q] += factor * flux[q] * steps3[q].inv[2]; // eq. (3)
}

void lth_moments_add_face_area(int p, const double center[3], const double scale[3],
                               const LthFaceView *face, double *moments) {
  LITHE_ASSERT(p >= 0 && p <= MAX_P);
  int n = lth_monomials3(p);
  double sums[N3];
  face_sums(n, center, scale, face, false, sums);
  for (int q = 0; q < n; q++) moments[q] += sums[q];
}

void lth_face_frame(const double normal[3], double t1[3], double t2[3]) {
  // the axis that is farthest from the normal gives the best first tangent
  int axis = 0;
  for (int i = 1; i < 3; i++)
    if (fabs(normal[i]) < fabs(normal[axis])) axis = i;
  double unit[3] = {axis == 0, axis == 1, axis == 2};
  lth_v3_cross(unit, normal, t1);
  lth_v3_normalize(t1);
  lth_v3_cross(normal, t1, t2);
}

double lth_face_area_centroid(const LthFaceView *face, double centroid[3]) {
  const double *x0 = face->points + 3 * face->loop_point[face->loop_off[0]];
  double area = 0, shift[3] = {0};
  LitheIndex t[3];
  for (LthFan fan = lth_fan(face); lth_fan_next(&fan, t);) {
    double u[3], v[3], w[3];
    lth_v3_sub(face->points + 3 * (LitheCount)t[1], x0, u);
    lth_v3_sub(face->points + 3 * (LitheCount)t[2], x0, v);
    lth_v3_cross(u, v, w);
    double part = 0.5 * lth_v3_dot(w, face->normal);
    area += part;
    for (int i = 0; i < 3; i++) shift[i] += part * (u[i] + v[i]) / 3;
  }
  for (int i = 0; i < 3; i++) centroid[i] = x0[i] + (area != 0 ? shift[i] / area : 0);
  return area;
}

static inline void to_local2(const double *point, const double origin[3], const double t1[3],
                             const double t2[3], double inv_h, double st[2]) {
  double d[3];
  lth_v3_sub(point, origin, d);
  st[0] = lth_v3_dot(d, t1) * inv_h;
  st[1] = lth_v3_dot(d, t2) * inv_h;
}

void lth_face_moments(int p, const double origin[3], const double t1[3], const double t2[3],
                      double h, const LthFaceView *face, double *moments) {
  LITHE_ASSERT(p >= 0 && p <= MAX_P);
  int n = lth_monomials2(p);
  double inv_h = 1 / h, sum[N2] = {0};
  for (LitheIndex l = 0; l < face->n_loops; l++) {
    LitheIndex begin = face->loop_off[l], end = face->loop_off[l + 1];
    if (begin == end) continue;
    double a[2], b[2];
    to_local2(face->points + 3 * face->loop_point[end - 1], origin, t1, t2, inv_h, a);
    for (LitheIndex k = begin; k < end; k++) {
      to_local2(face->points + 3 * face->loop_point[k], origin, t1, t2, inv_h, b);
      add_edge2(n, a, b, a[0] * b[1] - a[1] * b[0], sum); // eq. (8)
      memcpy(a, b, sizeof a);
    }
  }
  for (int q = 0; q < n; q++)
    moments[q] = h * h * sum[q] / (2 + exponents2[q][0] + exponents2[q][1]); // eq. (7)
}
