/// Rules by which elements are divided and change their degree.
#include "scene/reader.h"

static bool has_body_to_adapt(const LthScene *scene) {
  for (LitheIndex b = 0; b < scene->n_bodies; b++)
    if (scene->bodies[b].method_kind == LTH_METHOD_DG) return true;
  return false;
}

static void read_rule(const LthNode *node, const char *limit, LthSceneAdapt *rule) {
  static const char *const criteria[] = {"principal-stress", "rotation", "error-estimate", NULL};
  static const char *const divisions[] = {"eight", "two", NULL};
  if (!node) return;
  rule->is_on = true;
  rule->criterion = (LthCriterion)lth_read_word(node, "criterion", criteria);
  rule->threshold = lth_read_number(node, "threshold", 0);
  rule->coarsen = lth_read_number(node, "coarsen", 0.5);
  rule->limit = lth_read_integer(node, limit, 3);
  rule->every = lth_read_integer(node, "every", 1);
  rule->division = (LthDivision)lth_read_word(node, "split", divisions);
}

void lth_read_adapt(LthReader *r) {
  LthScene *scene = r->scene;
  LthNode *adapt = lth_node_find(r->root, "adapt");
  if (!adapt || adapt->bad) return;
  read_rule(lth_node_get(adapt, "h"), "max_level", &scene->adapt_h);
  read_rule(lth_node_get(adapt, "p"), "max_degree", &scene->adapt_p);
  scene->adapt_blend = lth_read_number(adapt, "blend", 5 * scene->step);
  scene->adapt_elements = lth_read_integer(adapt, "max_elements", 100000);
  if ((scene->adapt_h.is_on || scene->adapt_p.is_on) && !has_body_to_adapt(scene))
    lth_report(
        r->report, adapt,
        "elements of other methods do not adapt, got no body of `kind: dg`; expected one, or "
        "leave adapt out");
}
