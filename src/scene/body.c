/// Building a body from its scene: each arrow of the way from shape to simulation is one call here.
#include "scene/body.h"

#include "base/tensor.h"
#include "step/free_motion.h"

#include <stdio.h>

static LitheStatus build_operator(LitheCtx *ctx, LthBody *body) {
  const LthSceneBody *def = body->def;
  LthDgOperatorDef op = {.space = body->space,
                         .young = body->young,
                         .poisson = body->poisson,
                         .flux = def->flux,
                         .penalty = def->penalty,
                         .eta = def->eta,
                         .warped = body->warped,
                         .weak = body->weak,
                         .n_weak = body->n_weak};
  return lth_dg_operator_create(ctx, &op, &body->op);
}

/// In a static run every part of the body has to be held, by constraints or perhaps by contact.
static LitheStatus check_held(LitheCtx *ctx, const LthBody *body) {
  const LthScene *scene = body->scene;
  LthFreeMotions free;
  if (scene->time_kind == LTH_TIME_DYNAMIC || scene->n_colliders > 0) return LITHE_OK;
  const uint8_t *strong = body->strong ? lth_dg_strong_cells(body->strong) : NULL;
  LITHE_TRY(lth_free_motions(ctx, body->op, body->space, strong, &free));
  if (free.first < 0) return LITHE_OK;
  const double *at = body->mesh->cell_centroid + 3 * (LitheCount)free.first;
  char part[120] = "the body";
  if (free.n_components > 1)
    snprintf(part, sizeof part, "the part around (%g, %g, %g), one of %d,", at[0], at[1], at[2],
             free.n_components);
  LITHE_FAIL(ctx, LITHE_BAD_INPUT,
             "%s.constraints: nothing holds %s against %s; a %s run needs constraints that do",
             body->def->place, part, free.text,
             scene->time_kind == LTH_TIME_STATIC ? "static" : "quasistatic");
}

static LthStepOptions step_options(const LthScene *scene) {
  LthStepOptions options = lth_step_options_default();
  options.linear = scene->linear;
  if (scene->tolerance > 0) options.tolerance = scene->tolerance;
  if (scene->newton_tolerance > 0) options.newton_tolerance = scene->newton_tolerance;
  if (scene->newton_iterations > 0) options.newton_iterations = scene->newton_iterations;
  return options;
}

static LitheStatus build_simulation(LitheCtx *ctx, LthBody *body) {
  LthStepOptions options = step_options(body->scene);
  LthBodyDef def = {.space = body->space,
                    .op = body->op,
                    .density = body->density,
                    .damping_mass = body->damping_mass,
                    .damping_stiffness = body->damping_stiffness,
                    .loads = body->loads,
                    .n_loads = body->n_loads,
                    .strong = body->strong ? lth_dg_strong_cells(body->strong) : NULL,
                    .prescribe = body->strong ? lth_dg_strong_prescribe : NULL,
                    .prescribe_self = body->strong,
                    .contact = body->contact,
                    .warped = body->warped};
  lth_v3_copy(body->scene->gravity, def.gravity);
  return lth_simulation_create(ctx, &def, &options, &body->sim);
}

/// Material, constraints and loads on the space of the mesh.
static LitheStatus build_conditions(LitheCtx *ctx, LthBody *body) {
  LITHE_TRY(lth_dg_space_create(ctx, body->mesh, body->def->degree, NULL, &body->space));
  LITHE_TRY(lth_build_material(ctx, body));
  LITHE_TRY(lth_build_constraints(ctx, body));
  return lth_build_loads(ctx, body);
}

LitheStatus lth_body_check(LitheCtx *ctx, LthBody *body) {
  LITHE_TRY(build_conditions(ctx, body));
  if (body->scene->time_kind == LTH_TIME_DYNAMIC) return LITHE_OK;
  LITHE_TRY(build_operator(ctx, body));
  return check_held(ctx, body);
}

static LitheStatus build_all(LitheCtx *ctx, LthBody *body, double *times) {
  double start = lth_now();
  LITHE_TRY(lth_build_mesh(ctx, body));
  double meshed = lth_now();
  lth_progress(ctx, "integrating", -1);
  LITHE_TRY(build_conditions(ctx, body));
  LITHE_TRY(build_operator(ctx, body));
  LITHE_TRY(check_held(ctx, body));
  LITHE_TRY(lth_build_embedding(ctx, body));
  LITHE_TRY(lth_build_contact(ctx, body));
  LITHE_TRY(build_simulation(ctx, body));
  LITHE_TRY(lth_build_initial(ctx, body));
  times[0] = meshed - start;
  times[1] = lth_now() - meshed;
  return LITHE_OK;
}

LitheStatus lth_body_create(LitheCtx *ctx, const LthScene *scene, double *times, LthBody **body) {
  LTH_NEW(ctx, *body, 1);
  (*body)->scene = scene;
  (*body)->def = scene->bodies;
  LitheStatus status = build_all(ctx, *body, times);
  if (status != LITHE_OK) lth_body_destroy(ctx, body);
  return status;
}

static void free_patches(LitheCtx *ctx, LthBody *b) {
  LitheIndex n = b->def->n_constraints + b->def->n_loads;
  for (LitheIndex i = 0; b->patches && i < n; i++) lth_patches_destroy(ctx, b->patches + i);
  lth_free(ctx, b->patches);
}

void lth_body_destroy(LitheCtx *ctx, LthBody **body) {
  LthBody *b = *body;
  if (!b) return;
  lth_simulation_destroy(ctx, &b->sim);
  lth_contact_destroy(ctx, &b->contact);
  lth_embedding_destroy(ctx, &b->nodes);
  lth_embedding_destroy(ctx, &b->embedding);
  lth_soup_destroy(ctx, &b->own_soup);
  lth_dg_operator_destroy(ctx, &b->op);
  lth_free(ctx, b->loads);
  lth_dg_strong_destroy(ctx, &b->strong);
  lth_free(ctx, b->weak);
  lth_free(ctx, b->weak_of);
  free_patches(ctx, b);
  lth_free(ctx, b->label);
  lth_free(ctx, b->young);
  lth_free(ctx, b->poisson);
  lth_free(ctx, b->density);
  lth_free(ctx, b->yield);
  lth_dg_space_destroy(ctx, &b->space);
  lth_mesh_destroy(ctx, &b->mesh);
  lth_surface_destroy(ctx, &b->surface);
  lth_free(ctx, b);
  *body = NULL;
}
