/// Sections `topology` and `adapt` of result.json: what has changed of the bodies' elements.
#include "scene/adapt.h"
#include "scene/result.h"

static void put_cost(LthJson *json, const double *seconds) {
  double sum = 0;
  for (int i = 0; i < LTH_COST_COUNT; i++) sum += seconds[i];
  if (sum == 0) return; // before the first step everything is made for the first time
  lth_json_begin_object(json, "processor_seconds");
  for (int i = 0; i < LTH_COST_COUNT; i++)
    lth_json_number(json, lth_cost_name((LthCostPart)i), seconds[i]);
  lth_json_end_object(json);
}

static void put_note(LthJson *json, const LthWorld *world, const LthChangeNote *n) {
  static const char *const kinds[] = {"plane", "blade", "carve", "adapt"};
  bool is_idle = n->n_split + n->n_separated + n->n_removed + n->n_merged == 0;
  lth_json_begin_object(json, NULL);
  lth_json_string(json, "kind", kinds[n->kind]);
  if (n->cut >= 0) lth_json_integer(json, "cut", n->cut);
  lth_json_number(json, "time", n->t);
  lth_json_string(json, "body", world->bodies[n->body]->def->name);
  if (n->cut >= 0) lth_json_bool(json, "missed", is_idle && !n->is_refused);
  if (n->is_refused) lth_json_bool(json, "refused", true);
  lth_json_integer(json, "split", n->n_split);
  lth_json_integer(json, "separated", n->n_separated);
  lth_json_integer(json, "merged", n->n_merged);
  lth_json_integer(json, "removed", n->n_removed);
  lth_json_number(json, "area", n->area);
  lth_json_integer(json, "elements", n->elements);
  lth_json_integer(json, "dofs", n->unknowns);
  lth_json_integer(json, "pieces", n->pieces);
  lth_json_number(json, "volume", n->volume);
  if (!is_idle) lth_json_vector(json, "strain_energy", 2, n->strain);
  if (!is_idle) lth_json_vector(json, "jump_energy", 2, n->jump);
  if (!is_idle) lth_json_vector(json, "kinetic_energy", 2, n->kinetic);
  put_cost(json, n->seconds);
  lth_json_end_object(json);
}

/// Constraints, loads and ties that act on nothing any more.
static void put_losses(LthJson *json, const LthWorld *world) {
  LitheIndex n = 0;
  for (LitheIndex b = 0; b < world->n_bodies; b++)
    if (world->bodies[b]->change) n += world->bodies[b]->change->n_losses;
  if (n == 0) return;
  lth_json_begin_array(json, "lost");
  for (LitheIndex b = 0; b < world->n_bodies; b++) {
    const LthBody *body = world->bodies[b];
    for (LitheIndex i = 0; body->change && i < body->change->n_losses; i++) {
      const LthLoss *loss = body->change->losses + i;
      char name[80];
      lth_json_begin_object(json, NULL);
      lth_json_string(json, "what", lth_loss_name(body, loss, name, sizeof name));
      lth_json_string(json, "body", body->def->name);
      lth_json_number(json, "time", loss->t);
      lth_json_end_object(json);
    }
  }
  lth_json_end_array(json);
}

void lth_result_put_changes(LthJson *json, const LthWorld *world) {
  if (world->n_notes == 0) return;
  lth_json_begin_array(json, "topology");
  for (LitheIndex i = 0; i < world->n_notes; i++) put_note(json, world, world->notes + i);
  lth_json_end_array(json);
  put_losses(json, world);
}

/// Levels and degrees that cells have now.
static void put_range(LthJson *json, const char *key, const LthBody *body,
                      const uint8_t *by_record) {
  double range[2] = {255, 0};
  for (LitheIndex c = 0; c < body->mesh->n_cells; c++) {
    uint8_t value = by_record[body->change->cell_record[c]];
    if (value < range[0]) range[0] = value;
    if (value > range[1]) range[1] = value;
  }
  lth_json_vector(json, key, 2, range);
}

static void put_adapted(LthJson *json, const LthBody *body, const LthAdaptBody *state) {
  lth_json_begin_object(json, NULL);
  lth_json_string(json, "body", body->def->name);
  lth_json_integer(json, "elements_first", state->n_first);
  lth_json_integer(json, "elements_most", state->n_most);
  lth_json_integer(json, "divided", state->n_divided);
  lth_json_integer(json, "merged", state->n_merged);
  lth_json_integer(json, "raised", state->n_raised);
  lth_json_integer(json, "lowered", state->n_lowered);
  put_range(json, "level", body, body->change->level);
  put_range(json, "degree", body, body->change->degree);
  lth_json_end_object(json);
}

void lth_result_put_adapt(LthJson *json, const LthWorld *world) {
  const LthAdapt *a = world->adapt;
  if (!a) return;
  lth_json_begin_object(json, "adapt");
  lth_json_integer(json, "looks", a->n_looks);
  lth_json_integer(json, "changes", a->n_changes);
  lth_json_number(json, "largest_change_of_strain_energy", a->jump[0]);
  lth_json_number(json, "largest_change_of_kinetic_energy", a->jump[1]);
  if (world->scene->time_kind == LTH_TIME_DYNAMIC)
    lth_json_number(json, "largest_release", a->released);
  lth_json_begin_array(json, "bodies");
  for (LitheIndex b = 0; b < world->n_bodies; b++)
    if (a->bodies[b].first_degree) put_adapted(json, world->bodies[b], a->bodies + b);
  lth_json_end_array(json);
  lth_json_end_object(json);
}
