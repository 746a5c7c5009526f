/// Materials of staggered bodies as a field: the first entry whose `where` holds a place.
#include "scene/staggered_body.h"

#include <math.h>

LitheIndex lth_field_entry(const LthBody *body, const double x[3]) {
  const LthSceneBody *def = body->def;
  LthPlace place = {.x = {x[0], x[1], x[2]}};
  for (LitheIndex i = 0; i < def->n_materials; i++)
    if (!def->materials[i].has_where ||
        lth_where_solid_contains(body->staggered->material_where + i, &place))
      return i;
  return -1;
}

static void eval(const void *self, const double x[3], double *young, double *poisson,
                 double *density) {
  const LthBody *body = self;
  LitheIndex entry = lth_field_entry(body, x);
  *young = *poisson = *density = NAN;
  if (entry < 0) return;
  const LthMaterial *m = &body->def->materials[entry].material;
  *young = lth_value_at(&m->young, x, 0);
  *poisson = lth_value_at(&m->poisson, x, 0);
  *density = lth_value_at(&m->density, x, 0);
}

LitheStatus lth_build_field(LitheCtx *ctx, LthBody *body, LthMaterialField *field) {
  const LthSceneBody *def = body->def;
  LthStaggeredBody *s = body->staggered;
  const LthMaterial *first = &def->materials[0].material;
  LITHE_TRY(lth_check_materials(ctx, def));
  LTH_NEW(ctx, s->material_where, def->n_materials);
  for (LitheIndex i = 0; i < def->n_materials; i++) {
    if (!def->materials[i].has_where) continue;
    s->n_materials = i + 1;
    LITHE_TRY(
        lth_staggered_where(ctx, body, &def->materials[i].where, true, s->material_where + i));
  }
  body->warped = first->model != LTH_MATERIAL_LINEAR;
  body->damping_mass = first->damping_mass;
  body->damping_stiffness = first->damping_stiffness;
  bool varies = first->young.eval || first->poisson.eval || first->density.eval;
  *field = (LthMaterialField){
      .eval = eval, .self = body, .is_uniform = !def->materials[0].has_where && !varies};
  return LITHE_OK;
}

/// Every cell has an entry, and its constants are in range.
LitheStatus lth_staggered_check_field(LitheCtx *ctx, const LthBody *body) {
  static const double middle[3] = {0.5, 0.5, 0.5};
  const LthStaggeredBody *s = body->staggered;
  const LthSparseGrid *g = s->fractions->grid;
  for (LitheCount slot = 0; slot < g->n_slots; slot++) {
    LitheIndex at[3];
    double x[3];
    if (!(s->filled[slot] > 0)) continue;
    lth_sparse_grid_cell(g, slot, at);
    lth_sparse_grid_place(g, at, middle, x);
    LitheIndex entry = lth_field_entry(body, x);
    if (entry < 0)
      LITHE_FAIL(ctx, LITHE_BAD_INPUT,
                 "%s.material: no entry holds the cell at (%g, %g, %g); end the list with one that "
                 "has no `where`",
                 body->def->place, x[0], x[1], x[2]);
    double young, poisson, density;
    eval(body, x, &young, &poisson, &density);
    LITHE_TRY(lth_check_constants(ctx, body, x, young, poisson, density));
  }
  return LITHE_OK;
}
