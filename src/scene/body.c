/// Building a body from its scene: each arrow of the way from shape to simulation is one call here.
#include "scene/change.h"
#include "scene/staggered_body.h"

#include <string.h>

static LitheStatus build_operator(LitheCtx *ctx, LthBody *body) {
  const LthSceneBody *def = body->def;
  LthDgRecords records = {0};
  if (body->change) records = lth_body_records(body);
  LthDgOperatorDef op = {.space = body->space,
                         .young = body->young,
                         .poisson = body->poisson,
                         .flux = def->flux,
                         .penalty = def->penalty,
                         .eta = def->eta,
                         .warped = body->warped,
                         .held = body->strong ? lth_dg_strong_held(body->strong) : NULL,
                         .weak = body->weak,
                         .n_weak = body->n_weak,
                         .records = body->change ? &records : NULL};
  return lth_dg_operator_create(ctx, &op, &body->op);
}

LthSystemBody lth_body_as_part(const LthBody *body) {
  LthSystemBody part = {.disc = body->disc,
                        .damping_mass = body->damping_mass,
                        .damping_stiffness = body->damping_stiffness,
                        .loads = body->loads,
                        .n_loads = body->n_loads,
                        .warped = body->warped};
  if (body->strong) {
    part.held = lth_dg_strong_held(body->strong);
    part.prescribe = lth_dg_strong_prescribe;
    part.prescribe_self = body->strong;
  } else if (body->held_nodes) {
    part.held = lth_cg_strong_held(body->held_nodes);
    part.prescribe = lth_cg_strong_prescribe;
    part.prescribe_self = body->held_nodes;
  } else if (body->staggered) {
    part.held = lth_staggered_held(body->disc);
    part.prescribe = lth_staggered_prescribe;
    part.prescribe_self = body->disc;
  }
  return part;
}

const double *lth_body_displacement(const LthBody *body) {
  return lth_simulation_displacement(body->sim) + body->first;
}
double *lth_body_position(const LthBody *body) {
  return lth_simulation_position(body->sim) + body->first;
}
double *lth_body_velocity(const LthBody *body) {
  double *v = lth_simulation_velocity(body->sim);
  return v ? v + body->first : NULL;
}

double lth_body_cell_volume(const LthBody *body, LitheIndex cell) {
  double center[3], volume, fraction;
  if (!body->staggered) return body->mesh->cell_volume[cell];
  lth_staggered_cell(body, cell, center, &volume, &fraction);
  return volume;
}

void lth_body_cell_center(const LthBody *body, LitheIndex cell, double x[3]) {
  double volume, fraction;
  if (body->staggered)
    lth_staggered_cell(body, cell, x, &volume, &fraction);
  else
    memcpy(x, body->mesh->cell_centroid + 3 * (LitheCount)cell, 3 * sizeof *x);
}

double lth_body_volume(const LthBody *body) {
  double sum = 0;
  if (body->staggered) return body->staggered->volume;
  for (LitheIndex c = 0; c < body->mesh->n_cells; c++) sum += body->mesh->cell_volume[c];
  return sum;
}

LitheIndex lth_body_elements(const LthBody *body) {
  LitheIndex n = 0;
  if (!body->staggered) return body->disc->n_cells;
  for (LitheIndex c = 0; c < body->disc->n_cells; c++) n += lth_body_cell_volume(body, c) > 0;
  return n;
}

LitheCount lth_body_unknowns(const LthBody *body) {
  LitheCount n = 0;
  const uint8_t *held = body->staggered ? lth_staggered_held(body->disc) : NULL;
  for (LitheCount k = 0; k < body->disc->n_dofs; k++) n += !held || held[k] != LTH_ABSENT;
  return n;
}

LitheIndex lth_body_entry(const LthBody *body, LitheIndex cell) {
  double x[3];
  if (!body->staggered) return body->label[cell];
  lth_body_cell_center(body, cell, x);
  return lth_field_entry(body, x);
}

double lth_body_yield(const LthBody *body, LitheIndex cell) {
  if (!body->staggered) return body->yield[cell];
  LitheIndex entry = lth_body_entry(body, cell);
  return entry < 0 ? 0 : body->def->materials[entry].material.yield_strength;
}

void lth_body_elastic(const LthBody *body, LitheIndex cell, double *young, double *poisson) {
  double x[3];
  *young = *poisson = 0;
  if (!body->staggered) {
    *young = body->young[cell];
    *poisson = body->poisson[cell];
    return;
  }
  LitheIndex entry = lth_body_entry(body, cell);
  if (entry < 0) return;
  lth_body_cell_center(body, cell, x);
  *young = lth_value_at(&body->def->materials[entry].material.young, x, 0);
  *poisson = lth_value_at(&body->def->materials[entry].material.poisson, x, 0);
}

/// A space whose elements change, with the bases that are known.
static LitheStatus build_kept_space(LitheCtx *ctx, LthBody *body, uint8_t *degree) {
  LthDgRecords records = lth_body_records(body);
  for (LitheIndex c = 0; c < body->mesh->n_cells; c++)
    degree[c] = body->change->degree[records.cell[c]];
  return lth_dg_space_create_kept(ctx, body->mesh, 0, degree, &records, &body->space);
}

LitheStatus lth_body_build_space(LitheCtx *ctx, LthBody *body) {
  uint8_t *degree = NULL;
  LitheStatus status = LITHE_OK;
  LTH_NEW(ctx, degree, body->mesh->n_cells);
  if (body->change) {
    status = build_kept_space(ctx, body, degree);
  } else {
    status = lth_build_degrees(ctx, body, degree);
    if (status == LITHE_OK) status = lth_dg_space_create(ctx, body->mesh, 0, degree, &body->space);
  }
  lth_free(ctx, degree);
  return status;
}

static LitheStatus build_conditions(LitheCtx *ctx, LthBody *body) {
  if (body->staggered) return lth_build_staggered(ctx, body);
  if (body->def->method_kind == LTH_METHOD_CG) {
    LITHE_TRY(lth_build_material(ctx, body));
    LITHE_TRY(lth_build_nodes(ctx, body));
    return lth_build_loads(ctx, body);
  }
  if (!body->space) LITHE_TRY(lth_body_build_space(ctx, body));
  if (!body->label) LITHE_TRY(lth_build_material(ctx, body));
  LITHE_TRY(lth_build_constraints(ctx, body));
  LITHE_TRY(lth_build_loads(ctx, body));
  LITHE_TRY(build_operator(ctx, body));
  LthDgDiscDef disc = {.space = body->space,
                       .op = body->op,
                       .density = body->density,
                       .weak = body->weak,
                       .n_weak = body->n_weak};
  if (body->change && !body->warped) {
    if (!body->change->kept) LITHE_TRY(lth_dg_kept_create(ctx, &body->change->kept));
    disc.kept = body->change->kept;
    disc.cell_record = body->change->cell_record;
  }
  return lth_dg_disc_create(ctx, &disc, &body->disc);
}

LitheStatus lth_body_build_conditions(LitheCtx *ctx, LthBody *body) {
  LITHE_TRY(build_conditions(ctx, body));
  return lth_body_count_parts(ctx, body);
}

LitheStatus lth_body_create_mesh(LitheCtx *ctx, const LthScene *scene, const LthSceneBody *def,
                                 LthBody **body) {
  LTH_NEW(ctx, *body, 1);
  (*body)->scene = scene;
  (*body)->def = def;
  LitheStatus status = lth_build_mesh(ctx, *body);
  if (status != LITHE_OK) lth_body_destroy(ctx, body);
  return status;
}

LitheStatus lth_body_keep_matrix(LitheCtx *ctx, LthBody *body) {
  LthBodyChange *c = body->change;
  if (!c || !c->kept) return LITHE_OK;
  LthDgRecords records = lth_body_records(body);
  return lth_dg_kept_follow(ctx, c->kept, c->topology, &records, body->op, NULL);
}

LitheStatus lth_body_build_on_mesh(LitheCtx *ctx, LthBody *body) {
  LITHE_TRY(lth_body_build_conditions(ctx, body));
  LITHE_TRY(lth_body_keep_matrix(ctx, body));
  LITHE_TRY(lth_build_embedding(ctx, body));
  return lth_build_contact(ctx, body);
}

static void free_patches(LitheCtx *ctx, LthBody *b) {
  for (LitheCount i = 0; i < b->n_patches; i++) lth_patches_destroy(ctx, b->patches + i);
  lth_free(ctx, b->patches);
  for (LitheIndex i = 0; b->places && i < b->def->n_loads; i++)
    lth_places_destroy(ctx, b->places + i);
  lth_free(ctx, b->places);
}

void lth_body_free_touch(LitheCtx *ctx, LthBody *b) {
  lth_body_parts_destroy(ctx, &b->parts);
  lth_free(ctx, b->touch_point);
  b->touch_point = NULL;
  lth_embedding_destroy(ctx, &b->touch_embedding);
  lth_surface_destroy(ctx, &b->touch);
}

void lth_body_free_on_mesh(LitheCtx *ctx, LthBody *b) {
  lth_contact_destroy(ctx, &b->contact);
  lth_body_free_touch(ctx, b);
  lth_embedding_destroy(ctx, &b->nodes);
  lth_embedding_destroy(ctx, &b->embedding);
  lth_disc_destroy(ctx, &b->disc);
  lth_dg_operator_destroy(ctx, &b->op);
  lth_dg_strong_destroy(ctx, &b->strong);
  lth_cg_strong_destroy(ctx, &b->held_nodes);
  free_patches(ctx, b);
  void *blocks[] = {b->loads, b->weak,    b->weak_of, b->label,
                    b->young, b->poisson, b->density, b->yield};
  for (size_t i = 0; i < sizeof blocks / sizeof blocks[0]; i++) lth_free(ctx, blocks[i]);
  lth_dg_space_destroy(ctx, &b->space);
}

void lth_body_destroy(LitheCtx *ctx, LthBody **body) {
  LthBody *b = *body;
  if (!b) return;
  lth_body_free_on_mesh(ctx, b);
  lth_soup_destroy(ctx, &b->own_soup);
  lth_staggered_body_destroy(ctx, &b->staggered);
  lth_body_change_end(ctx, b);
  lth_mesh_destroy(ctx, &b->mesh);
  if (b->elements != b->def->elements) lth_element_mesh_destroy(ctx, &b->elements);
  lth_free(ctx, b->cell_element);
  lth_surface_destroy(ctx, &b->surface);
  lth_free(ctx, b);
  *body = NULL;
}
