/// Points of a sharp surface from where linear functions are zero to where the true ones are.
#include "geometry/sharp_priv.h"

#include "base/tensor.h"
#include "geometry/tri_tri.h"

#define BISECTIONS 48
#define END_DISTANCE 1e-4 ///< of an edge: how near a point is brought to its ends
#define DIFFERENCE 1e-4   ///< of a simplex: derivatives are right to its square
#define TURNED 0.5        ///< cosine of the angle that a triangle may turn by
#define STEPS 12
#define SETTLED 1e-13 ///< of a simplex

typedef struct Simplex {
  const LthField *field[3];
  int n;
  double from[3], side[3][3]; ///< lowest corner, ways to the others
} Simplex;

static Simplex simplex_of(const LthSharp *s, const LthSharpPoint *p) {
  Simplex x = {.n = p->n};
  lth_sharp_place(s, p->corner, x.from);
  for (int k = 0; k < p->n; k++) {
    x.field[k] = &s->solid->field[p->field[k]];
    for (int a = 0; a < 3; a++) x.side[k][a] = s->h * (p->step[k] >> a & 1);
  }
  return x;
}

static void at_parts(const Simplex *s, const double *t, double x[3]) {
  lth_v3_copy(s->from, x);
  for (int k = 0; k < s->n; k++) lth_v3_axpy(t[k], s->side[k], x);
}

/// Along an edge, by signs alone.
static void bisect(const Simplex *s, double t[1]) {
  double low = 0, high = 1, x[3];
  bool starts = lth_field_value(s->field[0], s->from) < 0;
  for (int i = 0; i < BISECTIONS; i++) {
    t[0] = 0.5 * (low + high);
    at_parts(s, t, x);
    if ((lth_field_value(s->field[0], x) < 0) == starts)
      low = t[0];
    else
      high = t[0];
  }
  t[0] = fmin(fmax(0.5 * (low + high), END_DISTANCE), 1 - END_DISTANCE);
}

/// Values of the fields, and 3x3 derivatives along the sides; beyond s->n those of the identity.
static void linearise(const Simplex *s, const double t[3], double value[3], double slope[9]) {
  lth_m3_identity(slope);
  value[0] = value[1] = value[2] = 0;
  for (int i = 0; i < s->n; i++) {
    double x[3], low[3], high[3];
    at_parts(s, t, x);
    value[i] = lth_field_value(s->field[i], x);
    for (int k = 0; k < s->n; k++) {
      lth_v3_copy(x, low);
      lth_v3_copy(x, high);
      lth_v3_axpy(-DIFFERENCE, s->side[k], low);
      lth_v3_axpy(DIFFERENCE, s->side[k], high);
      slope[3 * i + k] = (lth_field_value(s->field[i], high) - lth_field_value(s->field[i], low)) /
                         (2 * DIFFERENCE);
    }
  }
}

static bool is_within(int n, const double *t) {
  double rest = 1;
  for (int k = 0; k < n; k++) {
    if (!(t[k] >= 0)) return false;
    rest -= t[k];
  }
  return rest >= 0;
}

/// Newton's iteration; false where it leaves the simplex or does not settle.
static bool find_zero(const Simplex *s, double t[3]) {
  for (int i = 0; i < STEPS; i++) {
    double value[3], slope[9], inverse[9], step[3];
    linearise(s, t, value, slope);
    lth_m3_inverse(slope, inverse);
    lth_m3_apply(inverse, value, step);
    for (int k = 0; k < s->n; k++) t[k] -= step[k];
    double size = lth_v3_norm(step);
    if (!(size < 1)) return false;
    if (size < SETTLED) return is_within(s->n, t);
  }
  return false;
}

static bool is_flat(const Simplex *s) {
  for (int k = 0; k < s->n; k++)
    if (s->field[k]->kind != LTH_FIELD_PLANE) return false;
  return true;
}

/// Parts of the sides where a place lies: sides are sums of axes in the order of nested masks.
static void parts_of(const LthSharp *s, const LthSharpPoint *p, const double x[3], double t[3]) {
  double from[3], of_axis[3];
  lth_sharp_place(s, p->corner, from);
  for (int a = 0; a < 3; a++) of_axis[a] = (x[a] - from[a]) / s->h;
  // the axis that a side adds to the one before carries its part and those of all later ones
  for (int k = 0; k < p->n; k++) {
    int added = p->step[k] & ~(k > 0 ? p->step[k - 1] : 0);
    t[k] = of_axis[added & 1 ? 0 : added & 2 ? 1 : 2];
  }
  for (int k = 0; k + 1 < p->n; k++) t[k] -= t[k + 1];
}

static void move_point(const LthSharp *s, const LthSharpPoint *p, double x[3]) {
  Simplex simplex = simplex_of(s, p);
  double t[3] = {0};
  if (is_flat(&simplex)) return;
  parts_of(s, p, x, t);
  if (p->n == 1)
    bisect(&simplex, t);
  else if (!find_zero(&simplex, t))
    return;
  at_parts(&simplex, t, x);
  for (int k = 0; k < p->n; k++) {
    const LthField *f = simplex.field[k];
    if (f->kind == LTH_FIELD_PLANE && f->axis >= 0) x[f->axis] = f->at[f->axis];
  }
}

// ------------------------------------------------------------------ what must not come of it

/// Points before and after; what is wrong goes back.
typedef struct Moves {
  const LthSharp *s;
  double *to;
  bool *goes_back;
  LitheIndex n_bad; ///< triangles that are wrong where they were
} Moves;

static const double *corner_at(const LthSharp *s, const double *points, LitheIndex tri, int k) {
  return points + 3 * (size_t)s->tris[3 * (size_t)tri + (size_t)k];
}

static void normal_of(const LthSharp *s, const double *points, LitheIndex tri, double normal[3]) {
  double e[3], f[3];
  lth_v3_sub(corner_at(s, points, tri, 1), corner_at(s, points, tri, 0), e);
  lth_v3_sub(corner_at(s, points, tri, 2), corner_at(s, points, tri, 0), f);
  lth_v3_cross(e, f, normal);
}

/// Has a triangle turned far, or have corners of it come together?
static bool is_spoilt(const LthSharp *s, const double *to, LitheIndex tri) {
  double before[3], after[3];
  normal_of(s, s->points, tri, before);
  normal_of(s, to, tri, after);
  if (lth_v3_dot(before, after) <= TURNED * lth_v3_norm(before) * lth_v3_norm(after)) return true;
  for (int k = 0; k < 3; k++)
    if (lth_v3_distance(corner_at(s, to, tri, k), corner_at(s, to, tri, (k + 1) % 3)) <
        END_DISTANCE * s->h)
      return true;
  return false;
}

static bool mark_triangle(Moves *m, LitheIndex tri) {
  bool moved = false;
  for (int k = 0; k < 3; k++) {
    LitheIndex p = m->s->tris[3 * (size_t)tri + (size_t)k];
    if (memcmp(m->to + 3 * (size_t)p, m->s->points + 3 * (size_t)p, 3 * sizeof *m->to) == 0)
      continue;
    m->goes_back[p] = moved = true;
  }
  return moved;
}

static void check_group(Moves *m, LitheIndex first, LitheIndex end) {
  for (LitheIndex t = first; t < end; t++) {
    if (is_spoilt(m->s, m->to, t)) mark_triangle(m, t);
    for (LitheIndex u = first; u < t; u++) {
      if (!lth_triangles_cross(m->to, m->s->tris + 3 * (size_t)t, m->s->tris + 3 * (size_t)u))
        continue;
      bool moved = mark_triangle(m, t);
      m->n_bad += !mark_triangle(m, u) && !moved;
    }
  }
}

/// Returns the number of points that went back.
static LitheIndex go_back(Moves *m) {
  LitheIndex n = 0;
  m->n_bad = 0;
  for (LitheIndex g = 0; g < m->s->n_groups; g++)
    check_group(m, m->s->group[2 * g], m->s->group[2 * g + 1]);
  for (LitheIndex p = 0; p < m->s->n_points; p++) {
    if (!m->goes_back[p]) continue;
    lth_v3_copy(m->s->points + 3 * (size_t)p, m->to + 3 * (size_t)p);
    m->goes_back[p] = false;
    n++;
  }
  return n;
}

LitheStatus lth_sharp_move(LthSharp *s, bool *is_good) {
  LitheStatus status = LITHE_OK;
  Moves m = {.s = s};
  LTH_NEW_OR(done, s->ctx, m.to, 3 * (LitheCount)s->n_points);
  LTH_NEW_OR(done, s->ctx, m.goes_back, s->n_points);
  memcpy(m.to, s->points, 3 * (size_t)s->n_points * sizeof *m.to);
#pragma omp parallel for schedule(static) num_threads(lth_threads(s->ctx))
  for (LitheIndex p = 0; p < s->n_points; p++) move_point(s, &s->source[p], m.to + 3 * (size_t)p);
  while (go_back(&m) > 0) {
  }
  *is_good = m.n_bad == 0;
  memcpy(s->points, m.to, 3 * (size_t)s->n_points * sizeof *m.to);
done:
  lth_free(s->ctx, m.to);
  lth_free(s->ctx, m.goes_back);
  return status;
}
