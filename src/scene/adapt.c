/// A look at the elements, and what follows from it: divisions first, then merges, then the world is renewed.
#include "scene/adapt.h"

#include <math.h>
#include <string.h>

static bool adapts(const LthScene *scene) { return scene->adapt_h.is_on || scene->adapt_p.is_on; }

LitheStatus lth_adapt_begin_body(LitheCtx *ctx, const LthScene *scene, LthBody *body) {
  if (!adapts(scene) || body->def->method_kind != LTH_METHOD_DG) return LITHE_OK;
  if (!body->change) LITHE_TRY(lth_body_change_begin(ctx, body));
  LTH_NEW(ctx, body->change->refinement, 1);
  return LITHE_OK;
}

LitheStatus lth_adapt_begin(LitheCtx *ctx, LthWorld *world) {
  if (!adapts(world->scene)) return LITHE_OK;
  LTH_NEW(ctx, world->adapt, 1);
  LTH_NEW(ctx, world->adapt->bodies, world->n_bodies);
  for (LitheIndex b = 0; b < world->n_bodies; b++) {
    LthBody *body = world->bodies[b];
    LthAdaptBody *state = world->adapt->bodies + b;
    if (!body->change || !body->change->refinement) continue;
    state->n_first = state->n_most = lth_body_elements(body);
    LTH_NEW(ctx, state->first_degree, body->change->first->n_cells);
    LITHE_TRY(lth_build_degrees_of(ctx, body, body->change->first, state->first_degree));
  }
  return LITHE_OK;
}

void lth_adapt_end(LitheCtx *ctx, LthWorld *world) {
  LthAdapt *a = world->adapt;
  if (!a) return;
  for (LitheIndex b = 0; a->bodies && b < world->n_bodies; b++)
    lth_free(ctx, a->bodies[b].first_degree);
  lth_free(ctx, a->bodies);
  lth_free(ctx, a->velocity);
  lth_free(ctx, a);
  world->adapt = NULL;
}

static LitheStatus make_room(LitheCtx *ctx, LthAdapt *a, LitheCount n) {
  LTH_RESERVE(ctx, a->velocity, a->cap_velocity, n);
  a->n_velocity = n;
  return LITHE_OK;
}

/// Is a rule looked at after the step that is number n?
static bool rule_is_due(const LthScene *scene, const LthSceneAdapt *rule, LitheCount n) {
  return rule->is_on && (n % rule->every == 0 || scene->time_kind == LTH_TIME_STATIC);
}

static bool is_due(const LthScene *scene, LitheCount n) {
  return rule_is_due(scene, &scene->adapt_h, n) || rule_is_due(scene, &scene->adapt_p, n);
}

LitheStatus lth_adapt_before_step(LitheCtx *ctx, LthWorld *world) {
  LthAdapt *a = world->adapt;
  if (!a || world->scene->time_kind != LTH_TIME_DYNAMIC || !is_due(world->scene, a->n_steps + 1))
    return LITHE_OK;
  LITHE_TRY(make_room(ctx, a, world->system->n));
  memcpy(a->velocity, lth_simulation_velocity(world->sim),
         sizeof *a->velocity * (size_t)a->n_velocity);
  return LITHE_OK;
}

// --- one body ---

/// A body at a look: what is marked, and the families that are to be merged.
typedef struct Look {
  LthBody *body;
  LthMark *mark;
  LitheIndex *family_off, *family_list, n_families;
  LitheCount n_divided, n_merged, n_degrees;
} Look;

/// A part that this look made: its level and degree.
static LitheStatus set_parts(LitheCtx *ctx, LthBody *body, LitheIndex first, uint8_t level) {
  const LthTopology *t = body->change->topology;
  LITHE_TRY(lth_body_change_inherit(ctx, body));
  for (LitheIndex i = first; i < t->log.n_births; i++)
    body->change->level[t->log.births[i].cell] = level;
  return LITHE_OK;
}

/// Elements that the scene's limit still allows.
static LitheIndex room_for(const LthWorld *world) {
  LitheCount n = 0;
  for (LitheIndex b = 0; b < world->n_bodies; b++)
    n += world->bodies[b]->change ? world->bodies[b]->change->topology->n_live_cells
                                  : lth_body_elements(world->bodies[b]);
  return n < world->scene->adapt_elements ? (LitheIndex)(world->scene->adapt_elements - n) : 0;
}

static LitheStatus divide_all(LitheCtx *ctx, LthWorld *world, Look *look) {
  LthBody *body = look->body;
  LthBodyChange *c = body->change;
  const LthSceneAdapt *h = &world->scene->adapt_h;
  for (LitheIndex cell = 0; cell < body->mesh->n_cells; cell++) {
    LitheIndex record = c->cell_record[cell];
    double normal[3] = {0};
    LthSplit split;
    if (look->mark[cell] != LTH_DIVIDE) continue;
    if (room_for(world) < 7) {
      if (!world->adapt->is_full)
        lth_warn(ctx,
                 "adapt: %d elements are reached, and none is divided any more; raise "
                 "adapt.max_elements or the threshold",
                 world->scene->adapt_elements);
      world->adapt->is_full = true;
      break;
    }
    if (h->division == LTH_DIVIDE_TWO) lth_adapt_normal(body, cell, normal);
    uint8_t level = c->level[record];
    LITHE_TRY(lth_refinement_divide(ctx, c->refinement, c->topology, record, level, h->division,
                                    normal, &split));
    if (split.n == 0) continue;
    LITHE_TRY(set_parts(ctx, body, split.first, (uint8_t)(level + 1)));
    look->n_divided++;
  }
  return LITHE_OK;
}

static LitheStatus list_merges(LitheCtx *ctx, Look *look) {
  const LthBodyChange *c = look->body->change;
  look->n_families = c->refinement->n_families;
  return lth_refinement_list(ctx, c->refinement, c->topology, &look->family_off,
                             &look->family_list);
}

static bool is_merged(const Look *look, LitheIndex f) {
  if (look->family_off[f] == look->family_off[f + 1]) return false;
  LitheIndex record = look->family_list[look->family_off[f]];
  return look->mark[look->body->change->record_cell[record]] == LTH_MERGE;
}

/// The whole has the highest degree of its parts and their parent's level.
static LitheStatus merge_family(LitheCtx *ctx, Look *look, LitheIndex f) {
  LthBodyChange *c = look->body->change;
  const LitheIndex *records = look->family_list + look->family_off[f];
  LitheIndex n = look->family_off[f + 1] - look->family_off[f], merged;
  uint8_t degree = 1, level = c->refinement->families[f].level;
  for (LitheIndex i = 0; i < n; i++)
    if (c->degree[records[i]] > degree) degree = c->degree[records[i]];
  LITHE_TRY(lth_refinement_merge(ctx, c->refinement, c->topology, f, records, &merged));
  LITHE_TRY(lth_body_change_inherit(ctx, look->body));
  c->degree[merged] = degree;
  c->level[merged] = level;
  look->n_merged += n - 1;
  return LITHE_OK;
}

static LitheStatus merge_all(LitheCtx *ctx, const LthWorld *world, Look *look) {
  LthBodyChange *c = look->body->change;
  LitheIndex n_slivers = 0;
  LITHE_TRY(lth_body_change_hold(ctx, look->body));
  LITHE_TRY(lth_refinement_merge_slivers(ctx, c->refinement, c->topology, 0,
                                         world->scene->adapt_h.division, look->body->def->sliver,
                                         &n_slivers));
  look->n_merged += n_slivers;
  for (LitheIndex f = 0; f < look->n_families; f++)
    if (is_merged(look, f)) LITHE_TRY(merge_family(ctx, look, f));
  return LITHE_OK;
}

static void set_degrees(Look *look, LthAdaptBody *state) {
  LthBodyChange *c = look->body->change;
  for (LitheIndex cell = 0; cell < look->body->mesh->n_cells; cell++) {
    uint8_t *degree = c->degree + c->cell_record[cell];
    if (look->mark[cell] == LTH_RAISE) ++*degree, state->n_raised++, look->n_degrees++;
    if (look->mark[cell] == LTH_LOWER) --*degree, state->n_lowered++, look->n_degrees++;
  }
}

static LitheStatus change_body(LitheCtx *ctx, LthWorld *world, LitheIndex b, Look *look) {
  LthAdaptBody *state = world->adapt->bodies + b;
  bool merges = false;
  LITHE_TRY(list_merges(ctx, look));
  for (LitheIndex f = 0; f < look->n_families; f++) merges = merges || is_merged(look, f);
  set_degrees(look, state);
  LITHE_TRY(divide_all(ctx, world, look));
  if (merges || look->n_divided > 0) LITHE_TRY(merge_all(ctx, world, look));
  state->n_divided += look->n_divided;
  state->n_merged += look->n_merged;
  return LITHE_OK;
}

/// The scene's criteria in every cell.
static LitheStatus measure(LitheCtx *ctx, LthWorld *world, LitheIndex b, const double *acceleration,
                           LthAdaptValues *values) {
  const LthScene *scene = world->scene;
  LthBody *body = world->bodies[b];
  LthAdaptBody *state = world->adapt->bodies + b;
  const LthSceneAdapt *rule[2] = {&scene->adapt_h, &scene->adapt_p};
  double **value[2] = {&values->h, &values->p};
  const double *a = acceleration ? acceleration + body->first : NULL;
  for (int i = 0; i < 2; i++) {
    if (!rule_is_due(scene, rule[i], world->adapt->n_steps)) continue;
    LTH_NEW(ctx, *value[i], body->mesh->n_cells);
    if (i == 1 && values->h && rule[0]->criterion == rule[1]->criterion)
      memcpy(values->p, values->h, sizeof *values->p * (size_t)body->mesh->n_cells);
    else
      LITHE_TRY(lth_adapt_measure(ctx, body, state, rule[i]->criterion, a, *value[i]));
  }
  return LITHE_OK;
}

static LitheStatus look_at(LitheCtx *ctx, LthWorld *world, LitheIndex b, const double *acceleration,
                           bool may_undo) {
  LitheStatus status = LITHE_OK;
  LthBody *body = world->bodies[b];
  LthAdaptValues values = {0};
  Look look = {.body = body};
  LTH_NEW_OR(done, ctx, look.mark, body->mesh->n_cells);
  LITHE_TRY_OR(done, measure(ctx, world, b, acceleration, &values));
  LITHE_TRY_OR(done,
               lth_adapt_mark(ctx, body, world->adapt->bodies + b, &values, may_undo, look.mark));
  LITHE_TRY_OR(done, change_body(ctx, world, b, &look));
done:
  lth_free(ctx, values.h);
  lth_free(ctx, values.p);
  lth_free(ctx, look.mark);
  lth_free(ctx, look.family_off);
  lth_free(ctx, look.family_list);
  return status;
}

/// Mean acceleration of the step, in the place of the velocity before it; NULL in equilibria.
static double *acceleration(LthWorld *world, double dt) {
  LthAdapt *a = world->adapt;
  const double *v = lth_simulation_velocity(world->sim);
  if (!(dt > 0)) return NULL;
  for (LitheCount i = 0; i < a->n_velocity; i++) a->velocity[i] = (v[i] - a->velocity[i]) / dt;
  return a->velocity;
}

// --- renewal ---

/// Records of a body whose functions are new at this look, 1 each; the caller frees them.
static LitheStatus list_new(LitheCtx *ctx, const LthBody *body, uint8_t **is_new) {
  const LthBodyChange *c = body->change;
  const LthTopology *t = c->topology;
  LTH_NEW(ctx, *is_new, t->n_cells);
  for (LitheIndex i = 0; i < t->log.n_births; i++) (*is_new)[t->log.births[i].cell] = 1;
  for (LitheIndex i = 0; i < body->mesh->n_cells; i++)
    if (body->space->degree[i] != c->degree[c->cell_record[i]]) (*is_new)[c->cell_record[i]] = 1;
  return LITHE_OK;
}

/// Block rows of cells with new functions, and of their neighbours.
static void mark_rows(const LthBody *body, const uint8_t *is_new, uint8_t *rows) {
  const LthMesh *mesh = body->mesh;
  const LitheIndex *record = body->change->cell_record;
  for (LitheIndex c = 0; c < mesh->n_cells; c++)
    if (is_new[record[c]]) rows[c] = 1;
  for (LitheIndex f = 0; f < mesh->n_faces; f++) {
    LitheIndex a = mesh->face_cell[2 * f], b = mesh->face_cell[2 * f + 1];
    if (b >= 0 && (is_new[record[a]] || is_new[record[b]])) rows[a] = rows[b] = 1;
  }
}

/// Renew the world; in motion hold back what the new functions release: what is out of balance with the acceleration that
/// the forces of now give the old ones. `rate`, of now's size, is overwritten with it; NULL in equilibria.
static LitheStatus renew_softly(LitheCtx *ctx, LthWorld *world, double *rate) {
  LitheStatus status = LITHE_OK;
  LthAdapt *a = world->adapt;
  uint8_t **is_new = NULL, *rows = NULL;
  double released = 0;
  if (!rate) return lth_world_renew(ctx, world);
  LTH_NEW_OR(done, ctx, is_new, world->n_bodies);
  for (LitheIndex b = 0; b < world->n_bodies; b++)
    if (lth_body_has_changed(world->bodies[b]))
      LITHE_TRY_OR(done, list_new(ctx, world->bodies[b], is_new + b));
  LITHE_TRY_OR(done, lth_simulation_find_rate(ctx, world->sim, rate));
  LITHE_TRY_OR(done, lth_simulation_keep_rate(ctx, world->sim, rate));
  LITHE_TRY_OR(done, lth_world_renew(ctx, world));
  LTH_NEW_OR(done, ctx, rows, world->system->n_rows);
  for (LitheIndex b = 0; b < world->n_bodies; b++)
    if (is_new[b]) mark_rows(world->bodies[b], is_new[b], rows + world->system->row_first[b]);
  LITHE_TRY_OR(
      done, lth_simulation_hold_back(ctx, world->sim, rows, world->scene->adapt_blend, &released));
  a->released = fmax(a->released, released);
done:
  for (LitheIndex b = 0; is_new && b < world->n_bodies; b++) lth_free(ctx, is_new[b]);
  lth_free(ctx, is_new);
  lth_free(ctx, rows);
  return status;
}

/// Renew the world, and keep what that did to its energies.
static LitheStatus renew(LitheCtx *ctx, LthWorld *world, double *rate) {
  LthAdapt *a = world->adapt;
  const LthStepReport *r = lth_simulation_report(world->sim);
  double strain = r->strain_energy, kinetic = r->kinetic_energy;
  LITHE_TRY(renew_softly(ctx, world, rate));
  lth_simulation_measure(ctx, world->sim);
  r = lth_simulation_report(world->sim);
  a->n_changes++;
  a->jump[0] = fmax(a->jump[0], fabs(r->strain_energy - strain));
  a->jump[1] = fmax(a->jump[1], fabs(r->kinetic_energy - kinetic));
  for (LitheIndex b = 0; b < world->n_bodies; b++) {
    LitheIndex n = lth_body_elements(world->bodies[b]);
    if (n > a->bodies[b].n_most) a->bodies[b].n_most = n;
  }
  return LITHE_OK;
}

LitheStatus lth_adapt_look(LitheCtx *ctx, LthWorld *world, double dt, int round, bool *changed) {
  LthAdapt *a = world->adapt;
  *changed = false;
  if (!a) return LITHE_OK;
  if (round == 0) a->n_steps++;
  if (!is_due(world->scene, a->n_steps)) return LITHE_OK;
  if (round == 0) a->n_looks++;
  lth_simulation_measure(ctx, world->sim); // rotations are those of the state
  double *rate = acceleration(world, dt);
  lth_world_cost_begin(world);
  for (LitheIndex b = 0; b < world->n_bodies; b++) {
    LthBody *body = world->bodies[b];
    if (!body->change || !body->change->refinement) continue;
    LITHE_TRY(look_at(ctx, world, b, rate, round == 0));
    *changed = *changed || lth_body_has_changed(body);
  }
  return *changed ? renew(ctx, world, rate) : LITHE_OK;
}

void lth_adapt_archive(LthWorld *world, LthArchive *archive) {
  LthAdapt *a = world->adapt;
  if (!a) return;
  lth_archive_mark(archive, "adapt");
  LTH_ARCHIVE(archive, a->n_steps);
  LTH_ARCHIVE(archive, a->n_looks);
  LTH_ARCHIVE(archive, a->n_changes);
  LTH_ARCHIVE_ARRAY(archive, a->jump, 2);
  LTH_ARCHIVE(archive, a->released);
  LTH_ARCHIVE(archive, a->is_full);
  for (LitheIndex b = 0; b < world->n_bodies; b++) {
    LthAdaptBody *state = a->bodies + b;
    LthBodyChange *c = world->bodies[b]->change;
    LTH_ARCHIVE(archive, state->scale);
    LTH_ARCHIVE(archive, state->n_divided);
    LTH_ARCHIVE(archive, state->n_merged);
    LTH_ARCHIVE(archive, state->n_raised);
    LTH_ARCHIVE(archive, state->n_lowered);
    LTH_ARCHIVE(archive, state->n_most);
    if (c && c->refinement) lth_refinement_archive(archive->ctx, c->refinement, archive);
  }
}
