/// Ties between bodies.
#include "scene/reader.h"

#include <string.h>

LitheIndex lth_find_body(LthReader *r, LthNode *name) {
  const LthScene *scene = r->scene;
  if (name->bad || name->kind != LTH_NODE_SCALAR) return -1;
  for (LitheIndex b = 0; b < scene->n_bodies; b++)
    if (lth_node_is_text(name, scene->bodies[b].name)) return b;
  lth_report(r->report, name,
             "no body has this name, got %s; expected the name of one of the bodies",
             lth_show(r->arena, name));
  return -1;
}

static LitheStatus read_tie(LthReader *r, const LthNode *node, LthSceneTie *tie) {
  const LthNode *names = lth_node_get(node, "bodies");
  int i = 0;
  tie->place = lth_report_place(r->report, node);
  tie->body[0] = tie->body[1] = -1;
  for (LthNode *name = names ? names->first : NULL; name && i < 2; name = name->next, i++)
    tie->body[i] = lth_find_body(r, name);
  if (tie->body[0] >= 0 && tie->body[0] == tie->body[1])
    lth_report(r->report, names->first->next,
               "a body cannot be tied to itself, got %s twice; expected two bodies",
               lth_show(r->arena, names->first));
  return lth_read_where(r, lth_node_get(node, "where"), &tie->where);
}

LitheStatus lth_read_ties(LthReader *r) {
  const LthNode *list = lth_node_get(r->root, "tie");
  r->scene->ties = lth_read_array(r, list, sizeof *r->scene->ties);
  if (!r->scene->ties) LITHE_FAIL(r->ctx, LITHE_NO_MEMORY, "out of memory while reading the scene");
  for (const LthNode *node = list ? list->first : NULL; node; node = node->next)
    LITHE_TRY(read_tie(r, node, &r->scene->ties[r->scene->n_ties++]));
  return LITHE_OK;
}
