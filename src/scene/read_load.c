/// Constraints and loads of a body.
#include "scene/reader.h"

#include <string.h>

static LitheStatus copy_path(LthReader *r, const LthNode *node, char **path) {
  const char *text = lth_node_path(r->arena, node, NULL);
  *path = text ? lth_arena_text(r->arena, text, strlen(text)) : NULL;
  if (!*path) LITHE_FAIL(r->ctx, LITHE_NO_MEMORY, "out of memory while reading the scene");
  return LITHE_OK;
}

static void read_prescribed(LthReader *r, const LthNode *node, const char *key,
                            LthSceneConstraint *c) {
  const LthNode *value = lth_node_get(node, key);
  if (!value) return;
  if (value->kind == LTH_NODE_MAP) {
    c->normal_only = true;
    c->value[0] = lth_read_value(value, "normal");
    return;
  }
  int i = 0, n_fixed = 0;
  for (const LthNode *item = value->first; item && i < 3; item = item->next, i++) {
    c->fixed[i] = item->has_value;
    c->value[i] = item->has_value ? item->value : (LthValue){0};
    n_fixed += item->has_value || item->bad;
  }
  if (n_fixed == 0)
    lth_report(r->report, lth_node_find(node, key),
               "it holds nothing, got only null; expected at least one number or expression");
}

/// What cg does where nothing is said: it holds nodes, but rollers in the mean, and all where elements reach
/// beyond the body.
static bool is_strong_unsaid(const LthNode *node, const LthSceneBody *body,
                             const LthSceneConstraint *c) {
  const LthNode *enforce = lth_node_find(node, "enforce");
  return (!enforce || enforce->is_default) && body->method_kind == LTH_METHOD_CG &&
         body->mesh_kind != LTH_MESH_EMBEDDED && !c->normal_only;
}

static LitheStatus read_constraint(LthReader *r, const LthNode *node, const LthSceneBody *body,
                                   LthSceneConstraint *c) {
  static const char *const enforcements[] = {"weak", "strong", NULL};
  LITHE_TRY(copy_path(r, node, &c->path));
  c->place = lth_report_place(r->report, node);
  c->is_position = lth_node_find(node, "position") != NULL;
  read_prescribed(r, node, c->is_position ? "position" : "displacement", c);
  c->strong = lth_read_word(node, "enforce", enforcements) == 1 || is_strong_unsaid(node, body, c);
  c->interior = lth_read_flag(node, "interior");
  LthNode *enforce = lth_node_find(node, "enforce");
  if (enforce && !enforce->is_default && body->method_kind == LTH_METHOD_STAGGERED)
    lth_report_key(r->report, enforce,
                   "it is of elements, got it with `kind: staggered`, which holds unknowns; leave "
                   "it out");
  if (c->interior && c->normal_only)
    lth_report(r->report, lth_node_find(node, "interior"),
               "a roller is of the boundary, got true; expected false, or components beside it");
  return lth_read_where(r, lth_node_get(node, "where"), &c->where);
}

LitheStatus lth_read_constraints(LthReader *r, const LthNode *list, LthSceneBody *body) {
  body->constraints = lth_read_array(r, list, sizeof *body->constraints);
  if (!body->constraints)
    LITHE_FAIL(r->ctx, LITHE_NO_MEMORY, "out of memory while reading the scene");
  for (const LthNode *node = list ? list->first : NULL; node; node = node->next)
    LITHE_TRY(read_constraint(r, node, body, &body->constraints[body->n_constraints++]));
  return LITHE_OK;
}

static void check_load(LthReader *r, const LthNode *node, const LthSceneLoad *load) {
  LthNode *where = lth_node_find(node, "where"), *follower = lth_node_find(node, "follower");
  bool is_body_force = lth_node_find(node, "body_force") != NULL;
  if (is_body_force && where && !lth_node_is_text(where, "all"))
    lth_report_key(r->report, where,
                   "a body force with a selection is known but not available in this "
                   "version, got one; expected all, or no where");
  if (!is_body_force && !where)
    lth_report_missing(
        r->report, node, "where",
        "missing; expected all, or a mapping with one shape, plane, normal, face, not, and, or");
  if (load->follower && !lth_node_find(node, "pressure"))
    lth_report_key(r->report, follower,
                   "only a pressure follows the surface, got true; expected pressure "
                   "beside it");
}

static LitheStatus read_load(LthReader *r, const LthNode *node, LthSceneLoad *load) {
  static const char *const kinds[] = {"traction", "total_force", "pressure",
                                      "stress",   "body_force",  "point_force"};
  load->place = lth_report_place(r->report, node);
  for (int kind = 0; kind < 6; kind++)
    if (lth_node_find(node, kinds[kind])) load->kind = (LthLoadKind)kind;
  const char *key = kinds[load->kind];
  if (load->kind == LTH_LOAD_PRESSURE)
    load->value[0] = lth_read_value(node, key);
  else if (load->kind == LTH_LOAD_STRESS)
    lth_read_tensor(node, key, load->stress);
  else
    lth_read_values(node, key, load->value);
  load->follower = lth_read_flag(node, "follower");
  if (node->kind == LTH_NODE_MAP) check_load(r, node, load);
  return lth_read_where(r, lth_node_get(node, "where"), &load->where);
}

LitheStatus lth_read_loads(LthReader *r, const LthNode *list, LthSceneBody *body) {
  body->loads = lth_read_array(r, list, sizeof *body->loads);
  if (!body->loads) LITHE_FAIL(r->ctx, LITHE_NO_MEMORY, "out of memory while reading the scene");
  for (const LthNode *node = list ? list->first : NULL; node; node = node->next)
    LITHE_TRY(read_load(r, node, &body->loads[body->n_loads++]));
  return LITHE_OK;
}
