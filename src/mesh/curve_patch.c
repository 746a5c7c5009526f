/// Boundary curves of plane shapes, found on the edges of a lattice, and patches that grow along them.
#include "mesh/curve_patch.h"

#include "base/tensor.h"
#include "geometry/shape_foot.h"

#define SHIFT 0.381966011250105 // of the lattice, so that straight sides do not run along it
#define EDGES_MAX 1e10
#define HALVINGS 40
#define REACH 2 // cells of the lattice
#define UNLIKE                                                                                     \
  4 // steps that a difference of normals by 1 counts for: a step of the same side is less

typedef struct Tracer {
  LitheCtx *ctx;
  const LthShape *shape;
  LthCurve *curve;
  int64_t rows;
  uint8_t *is_in; ///< of a row's places and of the next row's (2 x columns)
} Tracer;

static void place_of(const LthCurve *c, int64_t row, int64_t column, double x[3]) {
  x[0] = c->origin[0] + c->step * (double)column;
  x[1] = c->origin[1] + c->step * (double)row;
  x[2] = 0;
}

static bool is_inside(const LthShape *shape, const double x[3]) {
  return lth_shape_value(shape, x) <= 0;
}

static void mark_row(const Tracer *t, int64_t row, uint8_t *is_in) {
#pragma omp parallel for schedule(static) num_threads(lth_threads(t->ctx))
  for (int64_t i = 0; i < t->curve->columns; i++) {
    double x[3];
    place_of(t->curve, row, i, x);
    is_in[i] = is_inside(t->shape, x);
  }
}

/// The crossing between a place inside and one outside, by halving.
static void find_crossing(const LthShape *shape, const double in[3], const double out[3],
                          double x[3]) {
  double low = 0, high = 1;
  for (int k = 0; k < HALVINGS; k++) {
    double middle = (low + high) / 2;
    for (int a = 0; a < 3; a++) x[a] = in[a] + middle * (out[a] - in[a]);
    *(is_inside(shape, x) ? &low : &high) = middle;
  }
}

static LitheStatus add_crossing(Tracer *t, int64_t row, int64_t column, int axis, bool first_in) {
  LthCurve *c = t->curve;
  double first[3], second[3], x[3];
  LthFoot foot;
  place_of(c, row, column, first);
  place_of(c, row + (axis == 1), column + (axis == 0), second);
  find_crossing(t->shape, first_in ? first : second, first_in ? second : first, x);
  if (!lth_shape_foot(t->shape, x, c->step, &foot)) return LITHE_OK;
  LTH_RESERVE(t->ctx, c->edge, c->cap_edge, c->n + 1);
  LTH_RESERVE(t->ctx, c->point, c->cap_point, 2 * ((LitheCount)c->n + 1));
  LTH_RESERVE(t->ctx, c->normal, c->cap_normal, 2 * ((LitheCount)c->n + 1));
  c->edge[c->n] = 2 * (row * c->columns + column) + axis;
  for (int a = 0; a < 2; a++) {
    c->point[2 * (LitheCount)c->n + a] = x[a];
    c->normal[2 * (LitheCount)c->n + a] = foot.normal[a];
  }
  c->n++;
  return LITHE_OK;
}

static LitheStatus trace(Tracer *t) {
  int64_t n = t->curve->columns;
  mark_row(t, 0, t->is_in);
  for (int64_t j = 0; j < t->rows; j++) {
    const uint8_t *here = t->is_in + (j % 2) * n;
    uint8_t *above = t->is_in + ((j + 1) % 2) * n;
    mark_row(t, j + 1, above);
    for (int64_t i = 0; i < n; i++) {
      if (i + 1 < n && here[i] != here[i + 1]) LITHE_TRY(add_crossing(t, j, i, 0, here[i]));
      if (here[i] != above[i]) LITHE_TRY(add_crossing(t, j, i, 1, here[i]));
    }
  }
  return LITHE_OK;
}

LitheStatus lth_curve_create(LitheCtx *ctx, const LthShape *shape, double step, LthCurve **curve) {
  double low[3], high[3];
  LthCurve *c = NULL;
  LitheStatus status = LITHE_OK;
  Tracer t = {.ctx = ctx, .shape = shape};
  *curve = NULL;
  lth_shape_bounds(shape, low, high);
  double wide = (high[0] - low[0]) / step + 3, tall = (high[1] - low[1]) / step + 3;
  if (!(wide * tall < EDGES_MAX))
    LITHE_FAIL(ctx, LITHE_BAD_INPUT,
               "the boundary cannot be followed in steps of %g m; expected a bounded shape and "
               "coarser steps",
               step);
  LTH_NEW(ctx, c, 1);
  for (int a = 0; a < 2; a++) c->origin[a] = low[a] - (1 - SHIFT / (1 + a)) * step;
  c->step = step;
  c->columns = (int64_t)wide + 1;
  t.curve = c;
  t.rows = (int64_t)tall;
  LTH_NEW_OR(done, ctx, t.is_in, 2 * c->columns);
  LITHE_TRY_OR(done, trace(&t));
  if (c->n == 0)
    LITHE_TRY_OR(done,
                 lth_fail(ctx, LITHE_BAD_INPUT,
                          "no boundary found in steps of %g m; use a finer resolution", step));
done:
  lth_free(ctx, t.is_in);
  if (status != LITHE_OK) lth_curve_destroy(ctx, &c);
  *curve = c;
  return status;
}

void lth_curve_destroy(LitheCtx *ctx, LthCurve **curve) {
  if (!*curve) return;
  lth_free(ctx, (*curve)->edge);
  lth_free(ctx, (*curve)->point);
  lth_free(ctx, (*curve)->normal);
  lth_free(ctx, *curve);
  *curve = NULL;
}

/// The first crossing of edge `key` or a later one.
static LitheIndex find_edge(const LthCurve *c, int64_t key) {
  LitheIndex low = 0, high = c->n;
  while (low < high) {
    LitheIndex middle = low + (high - low) / 2;
    if (c->edge[middle] < key)
      low = middle + 1;
    else
      high = middle;
  }
  return low;
}

LitheIndex lth_curve_nearest(const LthCurve *c, const double point[3], const double normal[3]) {
  double least = INFINITY;
  LitheIndex nearest = -1;
  const double u = (point[0] - c->origin[0]) / c->step, v = (point[1] - c->origin[1]) / c->step;
  if (!(fabs(u) < 1e9) || !(fabs(v) < 1e9)) return -1;
  int64_t column = (int64_t)floor(u), row = (int64_t)floor(v);
  for (int64_t j = row - REACH; j <= row + REACH; j++) {
    int64_t begin = j * c->columns + column - REACH;
    for (LitheIndex k = find_edge(c, 2 * begin);
         k < c->n && c->edge[k] <= 2 * (begin + 2 * REACH) + 1; k++) {
      const double *p = c->point + 2 * (LitheCount)k, *m = c->normal + 2 * (LitheCount)k;
      double off = hypot(p[0] - point[0], p[1] - point[1]) / c->step;
      double unlike = UNLIKE * hypot(m[0] - normal[0], m[1] - normal[1]);
      double cost = off * off + unlike * unlike;
      if (cost < least) least = cost, nearest = k;
    }
  }
  return nearest;
}

static bool bends(const LthCurve *c, LitheIndex i, LitheIndex j, double angle) {
  const double *n = c->normal + 2 * (LitheCount)i, *m = c->normal + 2 * (LitheCount)j;
  return fabs(atan2(n[0] * m[1] - n[1] * m[0], n[0] * m[0] + n[1] * m[1])) > angle + 1e-9;
}

/// The crossing of an edge, or -1.
static LitheIndex crossing_of(const LthCurve *c, int64_t key) {
  LitheIndex k = find_edge(c, key);
  return k < c->n && c->edge[k] == key ? k : -1;
}

/// Crossings on the edges of both lattice cells that have this crossing's edge in common.
static int neighbours(const LthCurve *c, LitheIndex i, LitheIndex found[8]) {
  int n = 0;
  int axis = (int)(c->edge[i] % 2);
  int64_t cell = c->edge[i] / 2, other = cell - (axis == 0 ? c->columns : 1);
  for (int k = 0; k < 2; k++) {
    int64_t at = k ? other : cell;
    const int64_t around[4] = {2 * at, 2 * at + 1, 2 * (at + 1) + 1, 2 * (at + c->columns)};
    for (int e = 0; e < 4; e++) {
      LitheIndex j = crossing_of(c, around[e]);
      if (j >= 0 && j != i) found[n++] = j;
    }
  }
  return n;
}

LitheStatus lth_curve_grow(LitheCtx *ctx, const LthCurve *c, LitheIndex from, double angle,
                           uint8_t *member) {
  LitheIndex depth = 0, *stack = NULL;
  if (from < 0) return LITHE_OK;
  LTH_NEW(ctx, stack, c->n);
  member[from] = 1;
  stack[depth++] = from;
  while (depth > 0) {
    LitheIndex i = stack[--depth], found[8];
    int n = neighbours(c, i, found);
    for (int k = 0; k < n; k++) {
      if (member[found[k]] || bends(c, i, found[k], angle)) continue;
      member[found[k]] = 1;
      stack[depth++] = found[k];
    }
  }
  lth_free(ctx, stack);
  return LITHE_OK;
}
