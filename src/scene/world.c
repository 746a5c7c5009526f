/// All bodies of a scene, and the one simulation that moves them.
#include "scene/world.h"

#include "base/tensor.h"
#include "system/free_motion.h"

#include <stdio.h>

/// In static runs every part of the bodies has to be held, by constraints or perhaps by contact.
static LitheStatus check_held(LitheCtx *ctx, const LthWorld *world) {
  const LthScene *scene = world->scene;
  LthFreeMotions free;
  if (scene->time_kind == LTH_TIME_DYNAMIC || scene->n_colliders > 0) return LITHE_OK;
  LITHE_TRY(lth_free_motions(ctx, world->system, &free));
  if (free.body < 0) return LITHE_OK;
  char part[120] = "the body";
  if (free.n_components > world->n_bodies)
    snprintf(part, sizeof part, "the part around (%g, %g, %g), one of %d,", free.at[0], free.at[1],
             free.at[2], free.n_components);
  LITHE_FAIL(ctx, LITHE_BAD_INPUT,
             "%s.constraints: nothing holds %s against %s; a %s run needs constraints that do",
             world->bodies[free.body]->def->place, part, free.text,
             scene->time_kind == LTH_TIME_STATIC ? "static" : "quasistatic");
}

static LthStepOptions step_options(const LthScene *scene) {
  LthStepOptions options = lth_step_options_default();
  options.integrator = scene->integrator;
  options.linear = scene->linear;
  if (scene->tolerance > 0) options.tolerance = scene->tolerance;
  if (scene->newton_tolerance > 0) options.newton_tolerance = scene->newton_tolerance;
  if (scene->newton_iterations > 0) options.newton_iterations = scene->newton_iterations;
  return options;
}

static LitheStatus build_system(LitheCtx *ctx, LthWorld *world) {
  LitheStatus status = LITHE_OK;
  LthSystemBody *parts = NULL;
  LthSystemContact *contacts = NULL;
  LTH_NEW_OR(done, ctx, parts, world->n_bodies);
  LTH_NEW_OR(done, ctx, contacts, world->n_bodies);
  LthSystemDef def = {.bodies = parts, .n_bodies = world->n_bodies, .contacts = contacts};
  for (LitheIndex b = 0; b < world->n_bodies; b++) {
    parts[b] = lth_body_as_part(world->bodies[b]);
    if (world->bodies[b]->contact)
      contacts[def.n_contacts++] =
          (LthSystemContact){.contact = world->bodies[b]->contact, .body = {b}};
  }
  lth_v3_copy(world->scene->gravity, def.gravity);
  LITHE_TRY_OR(done, lth_system_create(ctx, &def, &world->system));
done:
  lth_free(ctx, parts);
  lth_free(ctx, contacts);
  return status;
}

static LitheStatus allocate(LitheCtx *ctx, const LthScene *scene, LthWorld **world) {
  LTH_NEW(ctx, *world, 1);
  (*world)->scene = scene;
  LTH_NEW(ctx, (*world)->bodies, scene->n_bodies);
  return LITHE_OK;
}

LitheStatus lth_world_create_meshes(LitheCtx *ctx, const LthScene *scene, LthWorld **world) {
  LITHE_TRY(allocate(ctx, scene, world));
  LthWorld *w = *world;
  for (; w->n_bodies < scene->n_bodies; w->n_bodies++)
    LITHE_TRY(
        lth_body_create_mesh(ctx, scene, scene->bodies + w->n_bodies, w->bodies + w->n_bodies));
  return LITHE_OK;
}

LitheStatus lth_world_check(LitheCtx *ctx, LthWorld *world) {
  for (LitheIndex b = 0; b < world->n_bodies; b++)
    LITHE_TRY(lth_body_build_conditions(ctx, world->bodies[b]));
  if (world->scene->time_kind == LTH_TIME_DYNAMIC) return LITHE_OK;
  LITHE_TRY(build_system(ctx, world));
  return check_held(ctx, world);
}

static LitheStatus build_simulation(LitheCtx *ctx, LthWorld *w) {
  LthStepOptions options = step_options(w->scene);
  LITHE_TRY(lth_simulation_create(ctx, w->system, &options, &w->sim));
  for (LitheIndex b = 0; b < w->n_bodies; b++) {
    w->bodies[b]->sim = w->sim;
    w->bodies[b]->first = w->system->dof_first[b];
    LITHE_TRY(lth_build_initial(ctx, w->bodies[b]));
  }
  return LITHE_OK;
}

LitheStatus lth_world_create(LitheCtx *ctx, const LthScene *scene, double *times,
                             LthWorld **world) {
  times[0] = times[1] = 0;
  LITHE_TRY(allocate(ctx, scene, world));
  LthWorld *w = *world;
  for (; w->n_bodies < scene->n_bodies; w->n_bodies++)
    LITHE_TRY(
        lth_body_create(ctx, scene, scene->bodies + w->n_bodies, times, w->bodies + w->n_bodies));
  double start = lth_now();
  LITHE_TRY(build_system(ctx, w));
  LITHE_TRY(check_held(ctx, w));
  LITHE_TRY(build_simulation(ctx, w));
  times[1] += lth_now() - start;
  return LITHE_OK;
}

void lth_world_destroy(LitheCtx *ctx, LthWorld **world) {
  LthWorld *w = *world;
  if (!w) return;
  lth_simulation_destroy(ctx, &w->sim);
  lth_system_destroy(ctx, &w->system);
  for (LitheIndex b = 0; w->bodies && b < w->n_bodies; b++) lth_body_destroy(ctx, w->bodies + b);
  lth_free(ctx, w->bodies);
  lth_free(ctx, w);
  *world = NULL;
}
