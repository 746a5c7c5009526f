/// Cuts of bodies.
#include "scene/reader.h"

/// Bodies on other methods have no elements that could be cut.
static void check_method(LthReader *r, const LthNode *node, LitheIndex body) {
  const LthScene *scene = r->scene;
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

static void read_cut(LthReader *r, const LthNode *node, LthSceneCut *cut) {
  static const char *const spaces[] = {"deformed", "rest", NULL};
  LthNode *name = lth_node_find(node, "body");
  const LthNode *plane = lth_node_get(node, "plane");
  cut->place = lth_report_place(r->report, node);
  cut->at = lth_read_number(node, "at", 0);
  cut->body = name ? lth_find_body(r, name) : -1;
  cut->at_rest = lth_read_word(node, "space", spaces) == 1;
  if (!name || cut->body >= 0) check_method(r, node, cut->body);
  check_time(r, node, cut);
  if (!plane) return;
  cut->kind = LTH_CUT_PLANE;
  lth_read_vector(plane, "point", cut->plane.point);
  lth_read_direction(r, plane, "normal", cut->plane.normal);
}

LitheStatus lth_read_cuts(LthReader *r) {
  const LthNode *list = lth_node_get(r->root, "cuts");
  LthScene *scene = r->scene;
  scene->cuts = lth_read_array(r, list, sizeof *scene->cuts);
  if (!scene->cuts) LITHE_FAIL(r->ctx, LITHE_NO_MEMORY, "out of memory while reading the scene");
  for (const LthNode *node = list ? list->first : NULL; node; node = node->next)
    read_cut(r, node, &scene->cuts[scene->n_cuts++]);
  return LITHE_OK;
}
