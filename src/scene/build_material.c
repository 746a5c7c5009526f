/// Materials of a scene -> constants per cell: the first entry whose `where` holds the cell's centroid,
/// values that vary as their mean over the cell.
#include "scene/body.h"

#include "mesh/where.h"

#include <math.h>

/// Quadrature of one cell, or none where all values are constant.
typedef struct Rule {
  LitheIndex n;
  double *points, *weights;
} Rule;

static double mean(const LthValue *value, const Rule *rule, const double centroid[3]) {
  if (!value->eval) return value->constant;
  if (rule->n == 0) return lth_value_at(value, centroid, 0);
  double sum = 0, volume = 0;
  for (LitheIndex q = 0; q < rule->n; q++) {
    sum += rule->weights[q] * lth_value_at(value, rule->points + 3 * (LitheCount)q, 0);
    volume += rule->weights[q];
  }
  return sum / volume;
}

/// Fill body->label with the first entry that holds each cell's centroid, -1 where none does.
static LitheStatus choose_entries(LitheCtx *ctx, LthBody *body) {
  const LthMesh *mesh = body->mesh;
  for (LitheIndex c = 0; c < mesh->n_cells; c++) body->label[c] = -1;
  for (LitheIndex i = 0; i < body->def->n_materials; i++) {
    const LthSceneMaterial *entry = body->def->materials + i;
    LthWhereReady ready = {0};
    if (entry->has_where) {
      LitheStatus status = lth_where_prepare(ctx, mesh, &entry->where, &ready);
      if (status != LITHE_OK) {
        lth_where_ready_free(ctx, &ready);
        return status;
      }
    }
    for (LitheIndex c = 0; c < mesh->n_cells; c++)
      if (body->label[c] < 0 && (!entry->has_where || lth_where_contains_cell(&ready, c)))
        body->label[c] = i;
    lth_where_ready_free(ctx, &ready);
  }
  return LITHE_OK;
}

LitheStatus lth_check_constants(LitheCtx *ctx, const LthBody *body, const double at[3],
                                double young, double poisson, double density) {
  bool is_closed = body->staggered; // which then is the mixed formulation's, or refused
  const char *key = NULL, *rule = NULL;
  double got = 0;
  if (!(young > 0 && isfinite(young)))
    key = "young_modulus", rule = "> 0 Pa", got = young;
  else if (!(poisson > -1 && (poisson < 0.5 || (is_closed && poisson == 0.5))))
    key = "poisson_ratio", rule = "between -1 and 0.5", got = poisson;
  else if (!(density > 0 && isfinite(density)))
    key = "density", rule = "> 0 kg/m^3", got = density;
  if (!key) return LITHE_OK;
  LITHE_TRY(lth_scene_check_values(ctx, body->scene));
  LITHE_FAIL(ctx, LITHE_BAD_INPUT,
             "%s.material.%s: must be %s, is %g in the element at (%g, %g, %g)", body->def->place,
             key, rule, got, at[0], at[1], at[2]);
}

static LitheStatus set_cell(LitheCtx *ctx, LthBody *body, LitheIndex cell) {
  const double *centroid = body->mesh->cell_centroid + 3 * (LitheCount)cell;
  LitheIndex entry = body->label[cell];
  if (entry < 0)
    LITHE_FAIL(
        ctx, LITHE_BAD_INPUT,
        "%s.material: no entry holds the element at (%g, %g, %g); end the list with one that has "
        "no `where`",
        body->def->place, centroid[0], centroid[1], centroid[2]);
  const LthMaterial *m = &body->def->materials[entry].material;
  Rule rule = {0};
  if (m->young.eval || m->poisson.eval || m->density.eval)
    LITHE_TRY(
        lth_dg_cell_quadrature(ctx, body->mesh, cell, 3, &rule.n, &rule.points, &rule.weights));
  body->young[cell] = mean(&m->young, &rule, centroid);
  body->poisson[cell] = mean(&m->poisson, &rule, centroid);
  body->density[cell] = mean(&m->density, &rule, centroid);
  body->yield[cell] = m->yield_strength;
  lth_free(ctx, rule.points);
  lth_free(ctx, rule.weights);
  return lth_check_constants(ctx, body, centroid, body->young[cell], body->poisson[cell],
                             body->density[cell]);
}

/// Model and damping belong to the body as a whole.
LitheStatus lth_check_materials(LitheCtx *ctx, const LthSceneBody *def) {
  const LthMaterial *first = &def->materials[0].material;
  for (LitheIndex i = 1; i < def->n_materials; i++) {
    const LthMaterial *m = &def->materials[i].material;
    if (m->model == first->model && m->damping_mass == first->damping_mass &&
        m->damping_stiffness == first->damping_stiffness)
      continue;
    LITHE_FAIL(
        ctx, LITHE_UNSUPPORTED,
        "%s.material.%d: all entries of a body need the same `model` and `damping` in this version",
        def->place, i);
  }
  if (first->model == LTH_MATERIAL_NEO_HOOKEAN && def->method_kind != LTH_METHOD_STAGGERED)
    LITHE_FAIL(ctx, LITHE_UNSUPPORTED,
               "%s.material.model: neo-hookean needs method staggered; use corotated or linear",
               def->place);
  return LITHE_OK;
}

LitheStatus lth_build_material(LitheCtx *ctx, LthBody *body) {
  LitheIndex n = body->mesh->n_cells;
  const LthMaterial *first = &body->def->materials[0].material;
  LITHE_TRY(lth_check_materials(ctx, body->def));
  LTH_NEW(ctx, body->label, n);
  LTH_NEW(ctx, body->young, n);
  LTH_NEW(ctx, body->poisson, n);
  LTH_NEW(ctx, body->density, n);
  LTH_NEW(ctx, body->yield, n);
  body->warped = first->model == LTH_MATERIAL_COROTATED;
  body->damping_mass = first->damping_mass;
  body->damping_stiffness = first->damping_stiffness;
  LITHE_TRY(choose_entries(ctx, body));
  for (LitheIndex c = 0; c < n; c++) {
    LITHE_TRY(set_cell(ctx, body, c));
    body->mass += body->density[c] * body->mesh->cell_volume[c];
  }
  return LITHE_OK;
}
