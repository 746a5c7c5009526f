/// Section `topology` of result.json: what has changed of the bodies' elements.
#include "scene/result.h"

static void put_note(LthJson *json, const LthWorld *world, const LthChangeNote *n) {
  static const char *const kinds[] = {"plane", "blade", "carve", "adapt"};
  bool has_missed = n->n_split + n->n_separated + n->n_removed + n->n_merged == 0;
  lth_json_begin_object(json, NULL);
  lth_json_string(json, "kind", kinds[n->kind]);
  if (n->cut >= 0) lth_json_integer(json, "cut", n->cut);
  lth_json_number(json, "time", n->t);
  lth_json_string(json, "body", world->bodies[n->body]->def->name);
  if (n->cut >= 0) lth_json_bool(json, "missed", has_missed);
  lth_json_integer(json, "split", n->n_split);
  lth_json_integer(json, "separated", n->n_separated);
  lth_json_integer(json, "merged", n->n_merged);
  lth_json_integer(json, "removed", n->n_removed);
  lth_json_number(json, "area", n->area);
  lth_json_integer(json, "elements", n->elements);
  lth_json_integer(json, "dofs", n->unknowns);
  lth_json_integer(json, "pieces", n->pieces);
  lth_json_number(json, "volume", n->volume);
  lth_json_vector(json, "strain_energy", 2, n->strain);
  lth_json_vector(json, "kinetic_energy", 2, n->kinetic);
  lth_json_end_object(json);
}

void lth_result_put_changes(LthJson *json, const LthWorld *world) {
  if (world->n_notes == 0) return;
  lth_json_begin_array(json, "topology");
  for (LitheIndex i = 0; i < world->n_notes; i++) put_note(json, world, world->notes + i);
  lth_json_end_array(json);
}
