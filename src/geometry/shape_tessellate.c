/// Triangle surfaces of shapes: primitives with points on the true surface, combinations with their sharp edges, the
/// rest by an isosurface.
#include "geometry/isosurface.h"
#include "geometry/shape.h"
#include "geometry/sharp_surface.h"
#include "geometry/surface_shells.h"

#include "base/tensor.h"

#define TRIS_MAX 2e8 ///< triangles of a primitive that are worth waiting for

/// Points and triangles while they are made.
typedef struct Builder {
  LitheCtx *ctx;
  double *points;
  LitheIndex *tris;
  LitheIndex n_points, n_tris;
  LitheCount points_cap, tris_cap;
} Builder;

static LitheStatus add_point(Builder *b, const double x[3]) {
  LTH_RESERVE(b->ctx, b->points, b->points_cap, 3 * ((LitheCount)b->n_points + 1));
  lth_v3_copy(x, b->points + 3 * (size_t)b->n_points++);
  return LITHE_OK;
}

static LitheStatus add_tri(Builder *b, LitheIndex p, LitheIndex q, LitheIndex r) {
  LTH_RESERVE(b->ctx, b->tris, b->tris_cap, 3 * ((LitheCount)b->n_tris + 1));
  LitheIndex *t = b->tris + 3 * (size_t)b->n_tris++;
  t[0] = p, t[1] = q, t[2] = r;
  return LITHE_OK;
}

static LitheStatus build_box(Builder *b, const double min[3], const double max[3]) {
  // two triangles to a side, counter-clockwise from outside; corner bits are x, y, z
  static const LitheIndex side[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                        {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
  for (int i = 0; i < 3; i++)
    if (!(max[i] > min[i]))
      LITHE_FAIL(b->ctx, LITHE_BAD_INPUT,
                 "box: max must be greater than min along every axis, got %g and %g along %c",
                 max[i], min[i], "xyz"[i]);
  for (int corner = 0; corner < 8; corner++) {
    double x[3];
    for (int i = 0; i < 3; i++) x[i] = corner >> i & 1 ? max[i] : min[i];
    LITHE_TRY(add_point(b, x));
  }
  for (int s = 0; s < 6; s++) {
    LITHE_TRY(add_tri(b, side[s][0], side[s][1], side[s][2]));
    LITHE_TRY(add_tri(b, side[s][0], side[s][2], side[s][3]));
  }
  return LITHE_OK;
}

/// Number of pieces of about `resolution` along a length, at least `least`; fails where triangles of that
/// size would be too many.
static LitheStatus count_pieces(Builder *b, double length, double resolution, LitheIndex least,
                                LitheIndex *n) {
  double pieces = ceil(length / resolution - 1e-9);
  if (!(length > 0))
    LITHE_FAIL(b->ctx, LITHE_BAD_INPUT,
               "a shape has no size (radius or length of %g m); give a positive one", length);
  if (!(resolution > 0) || !(20 * pieces * pieces < TRIS_MAX))
    LITHE_FAIL(b->ctx, LITHE_BAD_INPUT,
               "a shape of size %g m cannot be tessellated at a resolution of %g m; give a coarser "
               "resolution",
               length, resolution);
  *n = pieces > least ? (LitheIndex)pieces : least;
  return LITHE_OK;
}

#define GOLDEN 1.6180339887498949

static const double ico_point[12][3] = {{-1, GOLDEN, 0},  {1, GOLDEN, 0},   {-1, -GOLDEN, 0},
                                        {1, -GOLDEN, 0},  {0, -1, GOLDEN},  {0, 1, GOLDEN},
                                        {0, -1, -GOLDEN}, {0, 1, -GOLDEN},  {GOLDEN, 0, -1},
                                        {GOLDEN, 0, 1},   {-GOLDEN, 0, -1}, {-GOLDEN, 0, 1}};

static const int ico_tri[20][3] = {{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                                   {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                                   {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                                   {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};

/// A sphere under construction: icosahedron of edge frequency n.
typedef struct Ico {
  Builder *b;
  const double *center;
  double radius;
  LitheIndex n, base;
  LitheIndex edge[12]
                 [12]; ///< first point inside the edge from the lower to the higher corner, or -1
} Ico;

/// Point at weights (i, j, k)/n of three corners, pushed onto the sphere.
static LitheStatus add_sphere_point(Ico *o, const double *a, const double *b, const double *c,
                                    LitheIndex i, LitheIndex j, LitheIndex k) {
  double x[3] = {0, 0, 0};
  lth_v3_axpy(i, a, x);
  lth_v3_axpy(j, b, x);
  lth_v3_axpy(k, c, x);
  lth_v3_normalize(x);
  lth_v3_scale(o->radius, x);
  lth_v3_add(x, o->center, x);
  return add_point(o->b, x);
}

/// Points inside all edges of the icosahedron, shared by the two triangles at each.
static LitheStatus add_ico_edges(Ico *o) {
  for (int t = 0; t < 20; t++)
    for (int e = 0; e < 3; e++) {
      int p = ico_tri[t][e], q = ico_tri[t][(e + 1) % 3];
      if (p > q) continue; // every edge is met once in rising order
      o->edge[p][q] = o->b->n_points;
      for (LitheIndex i = 1; i < o->n; i++)
        LITHE_TRY(add_sphere_point(o, ico_point[p], ico_point[q], ico_point[p], o->n - i, i, 0));
    }
  return LITHE_OK;
}

/// Point i along the edge p -> q, in either direction.
static LitheIndex edge_point(const Ico *o, int p, int q, LitheIndex i) {
  return p < q ? o->edge[p][q] + i - 1 : o->edge[q][p] + o->n - i - 1;
}

/// Number of the point with weights (n - i - j, i, j) of triangle t; `inner`: its first inside point.
static LitheIndex ico_index(const Ico *o, int t, LitheIndex inner, LitheIndex i, LitheIndex j) {
  const int *v = ico_tri[t];
  LitheIndex n = o->n, k = n - i - j;
  if (k == n) return o->base + v[0];
  if (i == n) return o->base + v[1];
  if (j == n) return o->base + v[2];
  if (j == 0) return edge_point(o, v[0], v[1], i);
  if (k == 0) return edge_point(o, v[1], v[2], j);
  if (i == 0) return edge_point(o, v[2], v[0], k);
  // rows j = 1 .. n - 2 hold n - 1 - j inside points each
  return inner + (j - 1) * (n - 1) - (j - 1) * j / 2 + i - 1;
}

static LitheStatus add_ico_tri(Ico *o, int t, bool flip) {
  const int *v = ico_tri[t];
  LitheIndex inner = o->b->n_points, n = o->n;
  for (LitheIndex j = 1; j < n; j++)
    for (LitheIndex i = 1; i < n - j; i++)
      LITHE_TRY(
          add_sphere_point(o, ico_point[v[0]], ico_point[v[1]], ico_point[v[2]], n - i - j, i, j));
  for (LitheIndex j = 0; j < n; j++)
    for (LitheIndex i = 0; i < n - j; i++) {
      LitheIndex p = ico_index(o, t, inner, i, j), q = ico_index(o, t, inner, i + 1, j),
                 r = ico_index(o, t, inner, i, j + 1);
      LITHE_TRY(flip ? add_tri(o->b, p, r, q) : add_tri(o->b, p, q, r));
      if (i + j + 1 >= n) continue;
      LitheIndex s = ico_index(o, t, inner, i + 1, j + 1);
      LITHE_TRY(flip ? add_tri(o->b, q, r, s) : add_tri(o->b, q, s, r));
    }
  return LITHE_OK;
}

static LitheStatus build_sphere(Builder *b, const double center[3], double radius,
                                double resolution, bool flip) {
  Ico o = {.b = b, .center = center, .radius = radius, .base = b->n_points};
  // an edge of the icosahedron spans an arc of 1.107 radii
  LITHE_TRY(count_pieces(b, 1.107 * radius, resolution, 2, &o.n));
  for (int p = 0; p < 12; p++)
    LITHE_TRY(add_sphere_point(&o, ico_point[p], ico_point[p], ico_point[p], 1, 0, 0));
  LITHE_TRY(add_ico_edges(&o));
  for (int t = 0; t < 20; t++) LITHE_TRY(add_ico_tri(&o, t, flip));
  return LITHE_OK;
}

/// A solid of revolution while its rings are added, from `from` along d.
typedef struct Rings {
  Builder *b;
  double from[3], d[3], t1[3], t2[3];
  LitheIndex first, count; ///< points of the last ring; one: a pole
} Rings;

/// Triangles between the last ring and one of `count` points that starts at `first`: at every corner the
/// next point is that of the smaller angle.
static LitheStatus zip_rings(Rings *r, LitheIndex first, LitheIndex count) {
  LitheIndex i = 0, j = 0;
  LitheIndex steps_i = r->count > 1 ? r->count : 0, steps_j = count > 1 ? count : 0;
  while (i < steps_i || j < steps_j) {
    bool take_i = j == steps_j ||
                  (i < steps_i && (LitheCount)(i + 1) * count <= (LitheCount)(j + 1) * r->count);
    LitheIndex p = r->first + (steps_i ? i % steps_i : 0), q = first + (steps_j ? j % steps_j : 0);
    if (take_i) {
      LITHE_TRY(add_tri(r->b, p, r->first + (i + 1) % steps_i, q));
      i++;
    } else {
      LITHE_TRY(add_tri(r->b, p, first + (j + 1) % steps_j, q));
      j++;
    }
  }
  return LITHE_OK;
}

/// Add the ring of a radius (0: a pole) at a place along the axis.
static LitheStatus add_ring(Rings *r, double along, double radius, LitheIndex count) {
  LitheIndex first = r->b->n_points;
  if (!(radius > 0)) count = 1;
  for (LitheIndex i = 0; i < count; i++) {
    double x[3], angle = 2 * M_PI * i / count;
    lth_v3_copy(r->from, x);
    lth_v3_axpy(along, r->d, x);
    lth_v3_axpy(radius * cos(angle), r->t1, x);
    lth_v3_axpy(radius * sin(angle), r->t2, x);
    LITHE_TRY(add_point(r->b, x));
  }
  if (r->count > 0) LITHE_TRY(zip_rings(r, first, count));
  r->first = first, r->count = count;
  return LITHE_OK;
}

/// Points of a ring that shrinks from the full radius' n: a multiple of four, never fewer than four.
static LitheIndex ring_count(LitheIndex n, double fraction) {
  LitheIndex quarters = (LitheIndex)lround(0.25 * n * fraction);
  return 4 * (quarters > 1 ? quarters : 1);
}

/// Rings of a flat cap or of a half ball at one end: k of them between pole and rim.
static LitheStatus add_end(Rings *r, const LthShape *s, double along, bool start, LitheIndex n,
                           LitheIndex k) {
  for (LitheIndex step = 0; step < k; step++) {
    LitheIndex ring = start ? step : k - 1 - step;
    double f = (double)ring / k, radius = s->radius * f, offset = 0;
    if (s->kind == LTH_SHAPE_CAPSULE) {
      radius = ring == 0 ? 0 : s->radius * sin(0.5 * M_PI * f);
      offset = (start ? -1 : 1) * s->radius * cos(0.5 * M_PI * f);
    }
    LITHE_TRY(add_ring(r, along + offset, radius, ring_count(n, radius / s->radius)));
  }
  return LITHE_OK;
}

static LitheStatus build_round_bar(Builder *b, const LthShape *s, double resolution) {
  Rings r = {.b = b};
  LitheIndex around = 0, rows = 0, k = 0;
  lth_v3_copy(s->a, r.from);
  lth_v3_sub(s->b, s->a, r.d);
  double length = lth_v3_normalize(r.d);
  if (s->kind == LTH_SHAPE_CAPSULE && !(length > 0))
    return build_sphere(b, s->a, s->radius, resolution, false);
  int least = fabs(r.d[0]) <= fabs(r.d[1]) && fabs(r.d[0]) <= fabs(r.d[2]) ? 0
              : fabs(r.d[1]) <= fabs(r.d[2])                               ? 1
                                                                           : 2;
  double axis[3] = {least == 0, least == 1, least == 2};
  lth_v3_cross(r.d, axis, r.t1);
  lth_v3_normalize(r.t1);
  lth_v3_cross(r.d, r.t1, r.t2);

  LITHE_TRY(count_pieces(b, 2 * M_PI * s->radius, resolution, 8, &around));
  LITHE_TRY(count_pieces(b, length, resolution, 1, &rows));
  LITHE_TRY(count_pieces(b, s->kind == LTH_SHAPE_CAPSULE ? 0.5 * M_PI * s->radius : s->radius,
                         resolution, s->kind == LTH_SHAPE_CAPSULE ? 2 : 1, &k));
  around = (around + 3) / 4 * 4;
  LITHE_TRY(add_end(&r, s, 0, true, around, k));
  for (LitheIndex row = 0; row <= rows; row++)
    LITHE_TRY(add_ring(&r, length * row / rows, s->radius, around));
  return add_end(&r, s, length, false, around, k);
}

static LitheStatus build_shell(Builder *b, const LthShape *s, double resolution) {
  if (!(s->inner >= 0 && s->inner < s->radius))
    LITHE_FAIL(b->ctx, LITHE_BAD_INPUT,
               "shell: the inner radius must be at least 0 and below the outer one, got %g and %g",
               s->inner, s->radius);
  LITHE_TRY(build_sphere(b, s->a, s->radius, resolution, false));
  if (!(s->inner > 0)) return LITHE_OK;
  // as fine in angle as the outside, so that a thin wall's sides do not cross
  return build_sphere(b, s->a, s->inner, resolution * fmin(1, s->inner / s->radius), true);
}

static double value_of(const void *self, const double x[3]) { return lth_shape_value(self, x); }

/// Only the sign matters, and it costs.
static double inside_wrap(const void *self, const double x[3]) {
  return lth_wrap_map_inside(self, x) ? -1 : 1;
}

static double cross_wrap(const void *self, const double a[3], const double b[3],
                         bool starts_inside) {
  return lth_wrap_map_crossing(self, a, b, starts_inside);
}

static LitheStatus trace_wrap(Builder *b, const LthWrap *wrap, double resolution) {
  LthWrapMap *map = NULL;
  LITHE_TRY(lth_wrap_map_create(b->ctx, wrap, 2 * resolution, &map));
  LitheStatus status =
      lth_isosurface(b->ctx, inside_wrap, cross_wrap, map, wrap->box, wrap->box + 3, resolution,
                     &b->n_points, &b->points, &b->n_tris, &b->tris);
  lth_wrap_map_destroy(b->ctx, &map);
  return status;
}

/// With sharp edges; where that fails, the isosurface of its value, which has none.
static LitheStatus trace_solid(Builder *b, const LthShape *s, const double min[3],
                               const double max[3], double resolution) {
  LthSolid *solid = NULL;
  bool is_sharp = false;
  LITHE_TRY(lth_solid_create(b->ctx, s, &solid));
  LitheStatus status = lth_sharp_surface(b->ctx, solid, min, max, resolution, &is_sharp,
                                         &b->n_points, &b->points, &b->n_tris, &b->tris);
  lth_solid_destroy(b->ctx, &solid);
  if (status != LITHE_OK || is_sharp) return status;
  lth_warn(b->ctx,
           "a combined shape's edges are chamfered at its resolution of %.3g m: its parts meet in "
           "ways that "
           "rounding cannot tell apart; move one of them slightly",
           resolution);
  return lth_isosurface(b->ctx, value_of, NULL, s, min, max, resolution, &b->n_points, &b->points,
                        &b->n_tris, &b->tris);
}

static LitheStatus build_isosurface(Builder *b, const LthShape *s, double resolution) {
  double min[3], max[3];
  lth_shape_bounds(s, min, max);
  if (!(resolution > 0))
    LITHE_FAIL(b->ctx, LITHE_BAD_INPUT, "the resolution of a shape must be positive, got %g m",
               resolution);
  if (s->kind == LTH_SHAPE_WRAP)
    LITHE_TRY(trace_wrap(b, s->wrap, resolution));
  else if (s->kind == LTH_SHAPE_IMAGE)
    LITHE_TRY(lth_isosurface(b->ctx, value_of, NULL, s, min, max, resolution, &b->n_points,
                             &b->points, &b->n_tris, &b->tris));
  else
    LITHE_TRY(trace_solid(b, s, min, max, resolution));
  if (b->n_tris == 0)
    LITHE_FAIL(
        b->ctx, LITHE_BAD_INPUT,
        "no surface found between (%g, %g, %g) and (%g, %g, %g) m at a resolution of %g m: the "
        "shape is empty there, or thinner than the resolution; move it, or give a finer resolution",
        min[0], min[1], min[2], max[0], max[1], max[2], resolution);
  return LITHE_OK;
}

/// A copy of `n` elements of `size`, *copy is NULL where memory is out.
static LitheStatus copy_array(LitheCtx *ctx, const void *from, LitheCount n, size_t size,
                              void **copy) {
  LITHE_TRY(lth_new_(ctx, copy, n, size));
  if (from) memcpy(*copy, from, (size_t)n * size);
  return LITHE_OK;
}

static LitheStatus copy_surface(LitheCtx *ctx, const LthSurface *from, LthSurface **copy) {
  LitheStatus status = LITHE_OK;
  LthSurface *s = NULL;
  LTH_NEW(ctx, s, 1);
  *s = (LthSurface){.n_points = from->n_points,
                    .n_tris = from->n_tris,
                    .n_shells = from->n_shells,
                    .n_soup_points = from->n_soup_points};
  LITHE_TRY_OR(done, copy_array(ctx, from->points, 3 * (LitheCount)s->n_points, sizeof(double),
                                (void **)&s->points));
  size_t size = sizeof(LitheIndex);
  LITHE_TRY_OR(done,
               copy_array(ctx, from->tris, 3 * (LitheCount)s->n_tris, size, (void **)&s->tris));
  LITHE_TRY_OR(done, copy_array(ctx, from->tri_shell, s->n_tris, size, (void **)&s->tri_shell));
  LITHE_TRY_OR(done, copy_array(ctx, from->tri_poly, s->n_tris, size, (void **)&s->tri_poly));
  LITHE_TRY_OR(done,
               copy_array(ctx, from->soup_point, s->n_soup_points, size, (void **)&s->soup_point));
done:
  if (status != LITHE_OK) lth_surface_destroy(ctx, &s);
  *copy = s;
  return status;
}

static LitheStatus build(Builder *b, const LthShape *s, double resolution) {
  switch (s->kind) {
  case LTH_SHAPE_BOX:
    return build_box(b, s->a, s->b);
  case LTH_SHAPE_SPHERE:
    return build_sphere(b, s->a, s->radius, resolution, false);
  case LTH_SHAPE_CYLINDER:
  case LTH_SHAPE_CAPSULE:
    return build_round_bar(b, s, resolution);
  case LTH_SHAPE_SHELL:
    return build_shell(b, s, resolution);
  case LTH_SHAPE_MESH:
  case LTH_SHAPE_IMPLICIT:
  case LTH_SHAPE_UNION:
  case LTH_SHAPE_INTERSECTION:
  case LTH_SHAPE_DIFFERENCE:
  case LTH_SHAPE_IMAGE:
  case LTH_SHAPE_WRAP:
    break;
  case LTH_SHAPE_DISK:
  case LTH_SHAPE_ANNULUS:
  case LTH_SHAPE_POLYGON:
    LITHE_FAIL(b->ctx, LITHE_BAD_INPUT, "a shape of two dimensions has no surface in space");
  }
  return build_isosurface(b, s, resolution);
}

/// Leave out shells, also cavities, that are smaller than a lattice cell: noise around crossings.
static LitheStatus drop_crumbs(LitheCtx *ctx, double resolution, LthSurface **surface) {
  LitheIndex before = (*surface)->n_shells;
  double smallest = resolution * resolution * resolution;
  LITHE_TRY(lth_surface_drop_small(ctx, *surface, smallest));
  LitheIndex n_dropped = before - (*surface)->n_shells;
  if (n_dropped > 0)
    lth_warn(ctx, "%d pieces smaller than the cube of the resolution of %.3g m left out", n_dropped,
             resolution);
  if ((*surface)->n_shells > 0) return LITHE_OK;
  LITHE_FAIL(ctx, LITHE_BAD_INPUT,
             "nothing is left at a resolution of %g m: the shape encloses no volume of that size; "
             "give a finer resolution",
             resolution);
}

LitheStatus lth_shape_tessellate(LitheCtx *ctx, const LthShape *shape, double resolution,
                                 LthSurface **surface) {
  LitheStatus status = LITHE_OK;
  Builder b = {.ctx = ctx};
  *surface = NULL;
  if (shape->kind == LTH_SHAPE_MESH) return copy_surface(ctx, shape->surface, surface);
  if (shape->kind == LTH_SHAPE_WRAP && shape->resolution > 0) resolution = shape->resolution;
  LITHE_TRY_OR(done, build(&b, shape, resolution));
  LITHE_TRY_OR(done,
               lth_surface_from_triangles(ctx, b.n_points, &b.points, b.n_tris, &b.tris, surface));
  if (shape->kind == LTH_SHAPE_WRAP || shape->kind == LTH_SHAPE_IMAGE)
    LITHE_TRY_OR(done, drop_crumbs(ctx, resolution, surface));
done:
  lth_free(ctx, b.points);
  lth_free(ctx, b.tris);
  if (status != LITHE_OK) lth_surface_destroy(ctx, surface);
  return status;
}
