/// All bodies of a scene, and the one simulation that moves them.
#include "scene/world.h"

#include "base/tensor.h"
#include "scene/adapt.h"
#include "scene/cut.h"
#include "system/free_motion.h"

#include <math.h>
#include <stdio.h>

/// True where another part, or another body, is so near that contact with it may hold this one.
static bool leans(const LthWorld *world, LitheIndex body) {
  const LthBody *a = world->bodies[body];
  if (!world->scene->contact_bodies) return false;
  if (a->n_parts > 1) return true;
  for (LitheIndex b = 0; b < world->n_bodies; b++) {
    const LthBody *other = world->bodies[b];
    double gap = 0;
    for (int i = 0; i < 3; i++)
      gap = fmax(gap, fmax(a->box[i] - other->box[3 + i], other->box[i] - a->box[3 + i]));
    if (b != body && gap <= 0.1 * a->size) return true;
  }
  return false;
}

/// In static runs every part of the bodies has to be held, by constraints or perhaps by contact.
static LitheStatus check_held(LitheCtx *ctx, const LthWorld *world) {
  const LthScene *scene = world->scene;
  LthFreeMotions free;
  if (scene->time_kind == LTH_TIME_DYNAMIC || scene->n_colliders > 0) return LITHE_OK;
  LITHE_TRY(lth_free_motions(ctx, world->system, &free));
  if (free.body < 0 || leans(world, free.body)) return LITHE_OK;
  char part[120] = "the body";
  if (free.n_components > world->n_bodies)
    snprintf(part, sizeof part, "the part around (%g, %g, %g), one of %d,", free.at[0], free.at[1],
             free.at[2], free.n_components);
  LITHE_FAIL(ctx, LITHE_BAD_INPUT,
             "%s.constraints: nothing holds %s against %s; a %s run needs constraints that do",
             world->bodies[free.body]->def->place, part, free.text,
             scene->time_kind == LTH_TIME_STATIC ? "static" : "quasistatic");
}

/// A static run is one equilibrium, unless elements change on the way; it starts at rest, unless the scene says otherwise.
static LthStepUse use_of(const LthScene *scene) {
  if (scene->time_kind == LTH_TIME_DYNAMIC) return LTH_USE_STEPS;
  if (scene->time_kind == LTH_TIME_QUASISTATIC) return LTH_USE_EQUILIBRIA;
  for (LitheIndex b = 0; b < scene->n_bodies; b++)
    for (int a = 0; a < 3; a++) {
      const LthValue *u = &scene->bodies[b].initial_displacement[a];
      if (u->eval || u->constant != 0) return LTH_USE_EQUILIBRIA;
    }
  return LTH_USE_ONE_EQUILIBRIUM;
}

static LthStepOptions step_options(const LthScene *scene) {
  LthStepOptions options = lth_step_options_default();
  options.integrator = scene->integrator;
  options.linear = scene->linear;
  options.use = use_of(scene);
  options.needs_matrix = scene->condition || scene->export_path;
  if (scene->tolerance > 0) options.tolerance = scene->tolerance;
  if (scene->newton_tolerance > 0) options.newton_tolerance = scene->newton_tolerance;
  if (scene->newton_iterations > 0) options.newton_iterations = scene->newton_iterations;
  return options;
}

/// Contacts and couplings as the system takes them, with room for all.
typedef struct Parts {
  LthSystemBody *bodies;
  LthSystemContact *contacts;
  LthCoupling *couplings;
  LitheIndex n_contacts, n_couplings;
} Parts;

static void list_parts(const LthWorld *w, Parts *p) {
  for (LitheIndex b = 0; b < w->n_bodies; b++) {
    p->bodies[b] = lth_body_as_part(w->bodies[b]);
    if (w->bodies[b]->contact)
      p->contacts[p->n_contacts++] = (LthSystemContact){w->bodies[b]->contact, {b, -1}};
  }
  for (LitheIndex i = 0; i < w->n_pairs; i++)
    p->contacts[p->n_contacts++] =
        (LthSystemContact){w->pairs[i].contact, {w->pairs[i].body[0], w->pairs[i].body[1]}};
  for (LitheIndex i = 0; i < w->n_ties; i++)
    for (LitheIndex k = 0; k < w->ties[i].tie->n_couplings; k++)
      p->couplings[p->n_couplings++] = w->ties[i].tie->coupling[k];
}

static LitheStatus build_system(LitheCtx *ctx, LthWorld *world) {
  LitheStatus status = LITHE_OK;
  Parts parts = {0};
  LTH_NEW_OR(done, ctx, parts.bodies, world->n_bodies);
  LTH_NEW_OR(done, ctx, parts.contacts, (LitheCount)world->n_bodies + world->n_pairs);
  LTH_NEW_OR(done, ctx, parts.couplings, 2 * (LitheCount)world->n_ties);
  list_parts(world, &parts);
  LthSystemDef def = {.bodies = parts.bodies,
                      .n_bodies = world->n_bodies,
                      .couplings = parts.couplings,
                      .n_couplings = parts.n_couplings,
                      .contacts = parts.contacts,
                      .n_contacts = parts.n_contacts};
  lth_v3_copy(world->scene->gravity, def.gravity);
  LITHE_TRY_OR(done, lth_system_create(ctx, &def, &world->system));
done:
  lth_free(ctx, parts.bodies);
  lth_free(ctx, parts.contacts);
  lth_free(ctx, parts.couplings);
  return status;
}

static LitheStatus allocate(LitheCtx *ctx, const LthScene *scene, LthWorld **world) {
  LTH_NEW(ctx, *world, 1);
  (*world)->scene = scene;
  LTH_NEW(ctx, (*world)->bodies, scene->n_bodies);
  LTH_NEW(ctx, (*world)->cut_done, scene->n_cuts);
  return LITHE_OK;
}

LitheStatus lth_world_create_meshes(LitheCtx *ctx, const LthScene *scene, LthWorld **world) {
  LITHE_TRY(allocate(ctx, scene, world));
  LthWorld *w = *world;
  for (; w->n_bodies < scene->n_bodies; w->n_bodies++)
    LITHE_TRY(
        lth_body_create_mesh(ctx, scene, scene->bodies + w->n_bodies, w->bodies + w->n_bodies));
  for (LitheIndex b = 0; b < w->n_bodies; b++)
    LITHE_TRY(lth_adapt_begin_body(ctx, scene, w->bodies[b]));
  return lth_world_cut_first(ctx, w);
}

LitheStatus lth_world_check(LitheCtx *ctx, LthWorld *world) {
  for (LitheIndex b = 0; b < world->n_bodies; b++)
    LITHE_TRY(lth_body_build_conditions(ctx, world->bodies[b]));
  LITHE_TRY(lth_world_build_ties(ctx, world));
  if (world->scene->time_kind == LTH_TIME_DYNAMIC) return LITHE_OK;
  return lth_world_build_system(ctx, world);
}

LitheStatus lth_world_build_system(LitheCtx *ctx, LthWorld *w) {
  LITHE_TRY(build_system(ctx, w));
  return check_held(ctx, w);
}

LitheStatus lth_world_create_simulation(LitheCtx *ctx, LthWorld *w) {
  LthStepOptions options = step_options(w->scene);
  LITHE_TRY(lth_simulation_create(ctx, w->system, &options, &w->sim));
  for (LitheIndex b = 0; b < w->n_bodies; b++) {
    w->bodies[b]->sim = w->sim;
    w->bodies[b]->first = w->system->dof_first[b];
  }
  return LITHE_OK;
}

LitheStatus lth_world_create(LitheCtx *ctx, const LthScene *scene, double *times,
                             LthWorld **world) {
  double start = lth_now();
  if (scene->n_cuts > 0 || scene->adapt_h.is_on || scene->adapt_p.is_on)
    lth_keep_spares(ctx, true); // for renewals
  LITHE_TRY(lth_world_create_meshes(ctx, scene, world));
  LthWorld *w = *world;
  times[0] = lth_now() - start;
  lth_progress(ctx, "integrating", -1);
  for (LitheIndex b = 0; b < w->n_bodies; b++) LITHE_TRY(lth_body_build_on_mesh(ctx, w->bodies[b]));
  LITHE_TRY(lth_world_build_ties(ctx, w));
  LITHE_TRY(lth_world_build_pairs(ctx, w));
  LITHE_TRY(lth_world_build_system(ctx, w));
  LITHE_TRY(lth_world_create_simulation(ctx, w));
  for (LitheIndex b = 0; b < w->n_bodies; b++) LITHE_TRY(lth_build_initial(ctx, w->bodies[b]));
  LITHE_TRY(lth_adapt_begin(ctx, w));
  for (int i = 0; i < 2; i++) lth_age_spares(ctx); // none is kept of what making it took
  times[1] = lth_now() - start - times[0];
  return lth_world_settle_notes(ctx, w);
}

void lth_world_destroy(LitheCtx *ctx, LthWorld **world) {
  LthWorld *w = *world;
  if (!w) return;
  lth_simulation_destroy(ctx, &w->sim);
  lth_system_destroy(ctx, &w->system);
  lth_world_free_pairs(ctx, w);
  lth_world_free_ties(ctx, w);
  lth_adapt_end(ctx, w);
  for (LitheIndex b = 0; w->bodies && b < w->n_bodies; b++) lth_body_destroy(ctx, w->bodies + b);
  lth_free(ctx, w->bodies);
  lth_free(ctx, w->cut_done);
  lth_free(ctx, w->notes);
  lth_free(ctx, w);
  *world = NULL;
  lth_keep_spares(ctx, false);
}
