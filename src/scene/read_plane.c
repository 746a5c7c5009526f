/// Shapes of scenes in two dimensions: disks, annuli, polygons and boxes.
#include "scene/reader.h"

#include "base/tensor.h"

#include <math.h>
#include <string.h>

void lth_open_box(const LthReader *r, double min[3], double max[3]) {
  if (r->scene->dimension == 2) min[2] = -INFINITY, max[2] = INFINITY;
}

void lth_read_disk(LthReader *r, const LthNode *node, const LthPlacement *place, LthShape *shape) {
  bool is_annulus = shape->kind == LTH_SHAPE_ANNULUS;
  double center[3];
  lth_read_vector(node, "center", center);
  lth_place_point(place, center, shape->a);
  shape->radius = lth_read_number(node, is_annulus ? "outer" : "radius", 1);
  shape->inner = is_annulus ? lth_read_number(node, "inner", 0) : 0;
  if (shape->inner >= shape->radius && lth_node_get(node, "outer"))
    lth_report(r->report, lth_node_find(node, "inner"),
               "not inside the outer radius, got %g and %g; expected inner < outer", shape->inner,
               shape->radius);
}

static LitheStatus own_loops(LthReader *r, LthLoops *loops) {
  LthSceneOwned *owned = r->owned;
  LitheStatus status = lth_reserve_(r->ctx, (void **)&owned->loops, &owned->cap_loops,
                                    owned->n_loops + 1, sizeof *owned->loops);
  if (status == LITHE_OK)
    owned->loops[owned->n_loops++] = loops;
  else
    lth_loops_destroy(r->ctx, &loops);
  return status;
}

/// Loops of placed corners; what is wrong with them is reported at `node`.
static LitheStatus make_polygon(LthReader *r, const LthNode *node, LitheIndex n_loops,
                                const LitheIndex *first, const double *points, LthShape *shape) {
  LthLoops *loops = NULL;
  LitheStatus status = lth_loops_create(r->ctx, n_loops, first, points, &loops);
  if (status == LITHE_BAD_INPUT && node) {
    lth_report(r->report, node, "%s", lithe_ctx_message(r->ctx));
    return LITHE_OK;
  }
  if (status != LITHE_OK) return status;
  LITHE_TRY(own_loops(r, loops));
  *shape = (LthShape){.kind = LTH_SHAPE_POLYGON, .loops = loops};
  return LITHE_OK;
}

LitheStatus lth_read_plane_box(LthReader *r, const double min[3], const double max[3],
                               const LthPlacement *place, LthShape *shape) {
  if (!place->rotates) {
    lth_place_point(place, min, shape->a);
    lth_place_point(place, max, shape->b);
    lth_open_box(r, shape->a, shape->b);
    return LITHE_OK;
  }
  const LitheIndex first[2] = {0, 4};
  double points[8];
  for (int c = 0; c < 4; c++) {
    double x[3] = {c == 1 || c == 2 ? max[0] : min[0], c >= 2 ? max[1] : min[1], 0}, placed[3];
    lth_place_point(place, x, placed);
    points[2 * c] = placed[0], points[2 * c + 1] = placed[1];
  }
  return make_polygon(r, NULL, 1, first, points, shape);
}

/// Is it a corner, a list of two numbers?
static bool is_corner(const LthNode *node) {
  return node->n_children == 2 && node->first->kind == LTH_NODE_SCALAR &&
         node->last->kind == LTH_NODE_SCALAR;
}

static LitheIndex count_corners(const LthNode *node) {
  if (is_corner(node->first)) return node->n_children;
  LitheIndex n = 0;
  for (const LthNode *loop = node->first; loop; loop = loop->next) n += loop->n_children;
  return n;
}

/// Append the corners of a list; false where one is not a corner, which has been reported.
static bool read_loop(LthReader *r, const LthNode *loop, const LthPlacement *place,
                      LitheIndex *n_points, double *points) {
  for (const LthNode *node = loop->first; node; node = node->next) {
    if (node->bad) return false;
    if (node->kind != LTH_NODE_LIST || !is_corner(node)) {
      lth_report(r->report, node, "no corner, got %s; expected [x, y]", lth_show(r->arena, node));
      return false;
    }
    if (!node->first->has_value || !node->last->has_value) return false;
    double x[3] = {node->first->value.constant, node->last->value.constant, 0}, placed[3];
    lth_place_point(place, x, placed);
    points[2 * (size_t)*n_points] = placed[0];
    points[2 * (size_t)*n_points + 1] = placed[1];
    ++*n_points;
  }
  return true;
}

LitheStatus lth_read_polygon(LthReader *r, const LthNode *node, const LthPlacement *place,
                             LthShape *shape) {
  *shape = (LthShape){.kind = LTH_SHAPE_DISK, .radius = 1};
  if (node->kind != LTH_NODE_LIST || !lth_node_is_sound(node)) return LITHE_OK;
  bool is_one = is_corner(node->first);
  LitheIndex n_points = 0, n_loops = 0;
  double *points = lth_arena_take(r->arena, 2 * sizeof *points * (size_t)count_corners(node));
  LitheIndex *first = lth_read_array(r, node, sizeof *first);
  if (!points || !first)
    LITHE_FAIL(r->ctx, LITHE_NO_MEMORY, "out of memory while reading the scene");
  if (is_one) {
    if (!read_loop(r, node, place, &n_points, points)) return LITHE_OK;
    first[++n_loops] = n_points;
  }
  for (const LthNode *loop = node->first; loop && !is_one; loop = loop->next) {
    if (!read_loop(r, loop, place, &n_points, points)) return LITHE_OK;
    first[++n_loops] = n_points;
  }
  return make_polygon(r, node, n_loops, first, points, shape);
}
