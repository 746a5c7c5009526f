/// Cuts of bodies.
#include "scene/reader.h"

#include "base/tensor.h"

#include <math.h>

/// Lengths beyond any body's, whose squares have no double.
#define FAR 1e100

/// Bodies on other methods have no elements that could be cut.
static void check_method(LthReader *r, const LthNode *node, LitheIndex body) {
  const LthScene *scene = r->scene;
  if (scene->dimension == 2) {
    lth_report(
        r->report, node,
        "cuts need method dg, which bodies in the plane do not have; leave `cuts` out, or take "
        "`dimension: 3`");
    return;
  }
  for (LitheIndex b = 0; b < scene->n_bodies; b++) {
    if ((body >= 0 && b != body) || scene->bodies[b].method_kind == LTH_METHOD_DG) continue;
    lth_report(r->report, node,
               "cuts need method dg, and body `%s` has another; expected `body` with the name of a "
               "dg body, or `method: {kind: dg}`",
               scene->bodies[b].name);
  }
}

static void check_time(LthReader *r, const LthNode *node, const LthSceneCut *cut) {
  const LthScene *scene = r->scene;
  if (cut->at > 0 && cut->at >= scene->duration)
    lth_report(r->report, lth_node_find(node, "at"),
               "the run ends before it, got %g s; expected less than the duration, %g s", cut->at,
               scene->duration);
}

/// A key of one kind of cut beside another kind.
static void refuse_beside(LthReader *r, const LthNode *node, const char *key, const char *of) {
  LthNode *given = lth_node_find(node, key);
  if (given && !lth_node_find(node, of))
    lth_report_key(r->report, given, "it belongs to %s, got no %s; leave it out", of, of);
}

static LitheStatus read_plane(LthReader *r, const LthNode *node, LthSceneCut *cut) {
  static const LthPlacement in_place = {.rotation = {1, 0, 0, 0, 1, 0, 0, 0, 1}};
  const LthNode *plane = lth_node_get(node, "plane"), *within = lth_node_get(node, "within");
  if (!plane) return LITHE_OK;
  cut->kind = LTH_CUT_PLANE;
  lth_read_vector(plane, "point", cut->plane.point);
  lth_read_direction(r, plane, "normal", cut->plane.normal);
  if (!within) return LITHE_OK;
  cut->has_within = true;
  LITHE_TRY(lth_read_shape(r, within, &in_place, NULL, true, &cut->within));
  return lth_shape_prepare(r->ctx, &cut->within);
}

static bool is_near(const double x[3]) {
  return fabs(x[0]) < FAR && fabs(x[1]) < FAR && fabs(x[2]) < FAR;
}

/// Places that follow each other, none twice, and a depth that leads away from each edge.
static void check_blade(LthReader *r, const LthNode *blade, const LthSceneCut *cut) {
  for (LitheIndex i = 0; i + 1 < cut->n_path; i++) {
    double edge[3], across[3];
    if (!is_near(cut->path[i]) || !is_near(cut->path[i + 1]) || !is_near(cut->depth)) {
      lth_report(r->report, blade, "its places are too far away; expected less than 1e100 m");
      return;
    }
    lth_v3_sub(cut->path[i + 1], cut->path[i], edge);
    lth_v3_cross(edge, cut->depth, across);
    if (lth_v3_norm(across) > 1e-9 * lth_v3_norm(edge) * lth_v3_norm(cut->depth)) continue;
    lth_report(r->report, blade,
               "edge %d of its path does not sweep a surface: its ends are the same place, or the "
               "depth runs along it; expected different places, and a depth across them",
               (int)i);
    return;
  }
}

static LitheStatus read_blade(LthReader *r, const LthNode *node, LthSceneCut *cut) {
  const LthNode *blade = lth_node_get(node, "blade"), *path = lth_node_get(blade, "path");
  if (!blade) return LITHE_OK;
  cut->kind = LTH_CUT_BLADE;
  lth_read_vector(blade, "depth", cut->depth);
  if (!path || !lth_node_is_sound(path)) return LITHE_OK;
  cut->path = lth_read_array(r, path, sizeof *cut->path);
  if (!cut->path) LITHE_FAIL(r->ctx, LITHE_NO_MEMORY, "out of memory while reading the scene");
  for (const LthNode *point = path->first; point; point = point->next, cut->n_path++) {
    int a = 0;
    for (const LthNode *x = point->first; x && a < 3; x = x->next)
      cut->path[cut->n_path][a++] = x->value.constant;
  }
  check_blade(r, blade, cut);
  return LITHE_OK;
}

static LitheStatus read_carve(LthReader *r, const LthNode *node, LthSceneCut *cut) {
  static const LthPlacement in_place = {.rotation = {1, 0, 0, 0, 1, 0, 0, 0, 1}};
  static const char *const keeps[] = {"inside", "outside", "both", NULL};
  const LthNode *carve = lth_node_get(node, "carve");
  if (!carve) return LITHE_OK;
  cut->kind = LTH_CUT_CARVE;
  if (!lth_node_find(node, "keep"))
    lth_report_missing(r->report, node, "keep", "missing; expected inside, outside or both");
  cut->keep = (LthKeep)lth_read_word(node, "keep", keeps);
  return lth_read_shape(r, carve, &in_place, NULL, false, &cut->carve);
}

static LitheStatus read_cut(LthReader *r, const LthNode *node, LthSceneCut *cut) {
  static const char *const spaces[] = {"deformed", "rest", NULL};
  LthNode *name = lth_node_find(node, "body");
  cut->place = lth_report_place(r->report, node);
  cut->at = lth_read_number(node, "at", 0);
  cut->body = name ? lth_find_body(r, name) : -1;
  cut->at_rest = lth_read_word(node, "space", spaces) == 1;
  if (!name || cut->body >= 0) check_method(r, node, cut->body);
  check_time(r, node, cut);
  refuse_beside(r, node, "within", "plane");
  refuse_beside(r, node, "keep", "carve");
  LITHE_TRY(read_plane(r, node, cut));
  LITHE_TRY(read_blade(r, node, cut));
  return read_carve(r, node, cut);
}

LitheStatus lth_read_cuts(LthReader *r) {
  const LthNode *list = lth_node_get(r->root, "cuts");
  LthScene *scene = r->scene;
  scene->cuts = lth_read_array(r, list, sizeof *scene->cuts);
  if (!scene->cuts) LITHE_FAIL(r->ctx, LITHE_NO_MEMORY, "out of memory while reading the scene");
  for (const LthNode *node = list ? list->first : NULL; node; node = node->next)
    LITHE_TRY(read_cut(r, node, &scene->cuts[scene->n_cuts++]));
  return LITHE_OK;
}
