/// Welding points by hashing them on a fine grid, and cutting polygons into triangles.
#include "base/tensor.h"
#include "geometry/polygon.h"
#include "geometry/surface_clean.h"

#define WELD_TOLERANCE 1e-9 // of the diagonal of the box
#define SNAP_TO_ZERO 1e-30 // of the diagonal: smaller coordinates would underflow in exact products
#define BODY_MIN 1e-30     // [m]
#define BODY_MAX 1e30      // [m]

/// Points by grid cell: a hash table of lists.
typedef struct Grid {
  double min[3], inv_cell, reach; ///< reach in cells
  LitheCount n_slots;
  LitheIndex *head; ///< first point of a slot + 1, 0 none      (n_slots)
  LitheIndex *next; ///< next point of the list + 1, 0 none     (n_points)
  double tolerance;
} Grid;

static LitheStatus mark_used(LthCleaner *c) {
  const LthSoup *soup = c->soup;
  for (LitheIndex i = 0; i < soup->n_points; i++) c->soup_point[i] = -1;
  for (LitheIndex i = 0; i < soup->poly_off[soup->n_polys]; i++)
    c->soup_point[soup->poly_point[i]] = 0;
  return LITHE_OK;
}

static LitheStatus measure(LthCleaner *c) {
  double size = 0, largest = 0;
  for (int i = 0; i < 3; i++) c->min[i] = INFINITY, c->max[i] = -INFINITY;
  for (LitheIndex p = 0; p < c->soup->n_points; p++)
    for (int i = 0; c->soup_point[p] == 0 && i < 3; i++) {
      double x = c->soup->points[3 * (size_t)p + (size_t)i];
      c->min[i] = fmin(c->min[i], x);
      c->max[i] = fmax(c->max[i], x);
      largest = fmax(largest, fabs(x));
    }
  for (int i = 0; i < 3; i++) size = hypot(size, c->max[i] - c->min[i]);
  c->size = size;
  if (!(size >= BODY_MIN && size <= BODY_MAX && largest <= 1e15 * BODY_MAX))
    LITHE_FAIL(c->ctx, LITHE_BAD_INPUT,
               "%s: the surface's box has a diagonal of %g, expected a body between %g and %g; is "
               "the file's unit right?",
               c->name, size, BODY_MIN, BODY_MAX);
  return LITHE_OK;
}

static uint64_t mix(uint64_t h) {
  h ^= h >> 33, h *= 0xff51afd7ed558ccdu;
  h ^= h >> 33, h *= 0xc4ceb9fe1a85ec53u;
  return h ^ h >> 33;
}

static LitheCount slot_of(const Grid *g, const int64_t cell[3]) {
  uint64_t h = mix((uint64_t)cell[0] + 0x9e3779b97f4a7c15u * (uint64_t)cell[1]);
  return (LitheCount)(mix(h + (uint64_t)cell[2]) & (uint64_t)(g->n_slots - 1));
}

/// The cells that the point's surroundings touch: at most two along each axis.
static void cell_range(const Grid *g, const double x[3], double reach, int64_t low[3],
                       int64_t high[3]) {
  for (int i = 0; i < 3; i++) {
    double at = (x[i] - g->min[i]) * g->inv_cell;
    low[i] = (int64_t)floor(at - reach);
    high[i] = (int64_t)floor(at + reach);
  }
}

/// The first point of a slot within `tolerance`, -1 if none; of several the one with the lowest number.
static LitheIndex find_in_slot(const LthCleaner *c, const Grid *g, LitheCount slot,
                               const double x[3], double tolerance) {
  LitheIndex found = -1;
  for (LitheIndex p = g->head[slot] - 1; p >= 0; p = g->next[p] - 1)
    if (lth_v3_distance(x, lth_clean_point(c, p)) <= tolerance && (found < 0 || p < found))
      found = p;
  return found;
}

static LitheIndex find_near(const LthCleaner *c, const Grid *g, const double x[3]) {
  int64_t low[3], high[3], cell[3];
  LitheIndex found = -1;
  cell_range(g, x, g->reach, low, high);
  for (cell[0] = low[0]; cell[0] <= high[0]; cell[0]++)
    for (cell[1] = low[1]; cell[1] <= high[1]; cell[1]++)
      for (cell[2] = low[2]; cell[2] <= high[2]; cell[2]++) {
        LitheIndex p = find_in_slot(c, g, slot_of(g, cell), x, g->tolerance);
        if (p >= 0 && (found < 0 || p < found)) found = p;
      }
  return found;
}

/// The welded point of a place, made if there is none yet.
static LitheIndex weld_point(LthCleaner *c, Grid *g, const double x[3]) {
  int64_t cell[3], same[3];
  cell_range(g, x, 0, cell, same);
  LitheCount slot = slot_of(g, cell);
  // most copies are equal to the last bit, which needs one look only
  LitheIndex p = find_in_slot(c, g, slot, x, 0);
  if (p < 0) p = find_near(c, g, x);
  if (p >= 0) return p;
  p = c->n_points++;
  lth_v3_copy(x, c->points + 3 * (size_t)p);
  g->next[p] = g->head[slot];
  g->head[slot] = p + 1;
  return p;
}

static void weld_all(LthCleaner *c, Grid *g) {
  LitheIndex used = 0;
  for (LitheIndex i = 0; i < c->soup->n_points; i++) {
    if (c->soup_point[i] < 0) continue;
    double x[3];
    for (int k = 0; k < 3; k++) {
      double given = c->soup->points[3 * (size_t)i + (size_t)k];
      x[k] = fabs(given) < SNAP_TO_ZERO * c->size ? 0 : given;
    }
    c->soup_point[i] = weld_point(c, g, x);
    used++;
  }
  if (used < c->soup->n_points)
    lth_warn(c->ctx, "%s: %d points that no polygon uses left out", c->name,
             c->soup->n_points - used);
  if (c->n_points < used)
    lth_warn(c->ctx, "%s: %d points welded to %d", c->name, used, c->n_points);
}

LitheStatus lth_clean_weld(LthCleaner *c) {
  LitheStatus status = LITHE_OK;
  LitheCount n = c->soup->n_points;
  Grid grid = {.n_slots = 16};
  LTH_NEW(c->ctx, c->soup_point, n);
  LTH_NEW(c->ctx, c->points, 3 * n);
  LITHE_TRY(mark_used(c));
  LITHE_TRY(measure(c));

  // cells a little over two tolerances wide, so that rounding of the cell's place does not matter
  while (grid.n_slots < 2 * n) grid.n_slots *= 2;
  grid.tolerance = WELD_TOLERANCE * c->size;
  grid.inv_cell = 1 / (2.1 * grid.tolerance);
  grid.reach = 0.49;
  lth_v3_copy(c->min, grid.min);
  LTH_NEW_OR(done, c->ctx, grid.head, grid.n_slots);
  LTH_NEW_OR(done, c->ctx, grid.next, n);
  weld_all(c, &grid);
done:
  lth_free(c->ctx, grid.head);
  lth_free(c->ctx, grid.next);
  return status;
}

/// Corners of a polygon as welded points, repeated neighbours left out; returns their number.
static LitheIndex welded_corners(const LthCleaner *c, LitheIndex poly, LitheIndex *corner) {
  const LthSoup *soup = c->soup;
  LitheIndex n = 0;
  for (LitheIndex i = soup->poly_off[poly]; i < soup->poly_off[poly + 1]; i++) {
    LitheIndex p = c->soup_point[soup->poly_point[i]];
    if (n == 0 || corner[n - 1] != p) corner[n++] = p;
  }
  while (n > 1 && corner[n - 1] == corner[0]) n--;
  return n;
}

/// Upper bounds of triangles and of corners of one polygon.
static LitheStatus count_triangles(const LthCleaner *c, LitheCount *n_tris, LitheIndex *n_corners) {
  *n_tris = 0;
  *n_corners = 0;
  for (LitheIndex p = 0; p < c->soup->n_polys; p++) {
    LitheIndex n = c->soup->poly_off[p + 1] - c->soup->poly_off[p];
    if (n > LTH_POLYGON_MAX)
      LITHE_FAIL(
          c->ctx, LITHE_BAD_INPUT,
          "%s: polygon %d has %d corners, at most %d can be used; divide it, in Blender with "
          "Face > Triangulate Faces",
          c->name, p, n, LTH_POLYGON_MAX);
    if (n >= 3) *n_tris += n - 2;
    if (n > *n_corners) *n_corners = n;
  }
  if (3 * *n_tris > INT32_MAX)
    LITHE_FAIL(c->ctx, LITHE_BAD_INPUT, "%s: has %lld triangles, at most %d can be used", c->name,
               (long long)*n_tris, INT32_MAX / 3);
  return LITHE_OK;
}

/// Keep the triangles of one polygon that have three different points; returns the number dropped.
static LitheIndex keep_triangles(LthCleaner *c, LitheIndex poly, LitheIndex n) {
  LitheIndex dropped = 0;
  for (LitheIndex i = 0; i < n; i++) {
    const LitheIndex *t = c->tris + 3 * (size_t)(c->n_tris + i);
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) {
      dropped++;
      continue;
    }
    LitheIndex *kept = c->tris + 3 * (size_t)(c->n_tris + i - dropped);
    for (int k = 0; k < 3; k++) kept[k] = t[k];
    c->tri_poly[c->n_tris + i - dropped] = poly;
  }
  c->n_tris += n - dropped;
  return dropped;
}

LitheStatus lth_clean_triangulate(LthCleaner *c) {
  LitheStatus status = LITHE_OK;
  LthPolygonWork work = {0};
  LitheIndex *corner = NULL, n_corners = 0, dropped = 0;
  LitheCount cap = 0;
  LITHE_TRY(count_triangles(c, &cap, &n_corners));
  LTH_NEW(c->ctx, c->tris, 3 * cap);
  LTH_NEW(c->ctx, c->tri_poly, cap);
  LTH_NEW(c->ctx, corner, n_corners);
  for (LitheIndex p = 0; p < c->soup->n_polys; p++) {
    LitheIndex n = welded_corners(c, p, corner);
    if (n < 3) {
      dropped++;
      continue;
    }
    LITHE_TRY_OR(done, lth_polygon_triangulate(c->ctx, &work, c->points, n, corner,
                                               c->tris + 3 * (size_t)c->n_tris));
    dropped += keep_triangles(c, p, n - 2);
  }
  if (dropped) lth_warn(c->ctx, "%s: %d triangles with repeated points dropped", c->name, dropped);
done:
  lth_polygon_work_free(c->ctx, &work);
  lth_free(c->ctx, corner);
  return status;
}
