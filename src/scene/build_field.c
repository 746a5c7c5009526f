/// Materials of staggered bodies as a field: the first entry whose `where` holds a place.
#include "scene/staggered_body.h"

#include "base/tensor.h"
#include "scene/expression.h"

#include <math.h>

#define SEARCHED 8 // places along an edge of a cell

/// What the material list says at a place.
typedef struct Constants {
  LitheIndex entry; ///< -1 where none holds it
  double young, poisson, density;
} Constants;

static LitheIndex entry_at(const LthBody *body, const double x[3]) {
  const LthSceneBody *def = body->def;
  LthPlace place = {.x = {x[0], x[1], x[2]}};
  for (LitheIndex i = 0; i < def->n_materials; i++)
    if (!def->materials[i].has_where ||
        lth_where_solid_contains(body->staggered->material_where + i, &place))
      return i;
  return -1;
}

/// True where all constants can be computed with.
static bool read_constants(const LthBody *body, const double x[3], Constants *c) {
  *c = (Constants){entry_at(body, x), NAN, NAN, NAN};
  if (c->entry < 0) return false;
  const LthMaterial *m = &body->def->materials[c->entry].material;
  c->young = lth_value_at(&m->young, x, 0);
  c->poisson = lth_value_at(&m->poisson, x, 0);
  c->density = lth_value_at(&m->density, x, 0);
  double lowest = body->staggered->formulation == LTH_FORM_MIXED ? 0 : -1;
  return c->young > 0 && isfinite(c->young) && c->poisson > lowest && c->poisson <= 0.5 &&
         c->density > 0 && isfinite(c->density);
}

/// The nearest place of the body among some within `reach` cells along each axis around that of x; false where they all are outside.
static bool search_cells(const LthBody *body, const double x[3], int reach, double y[3]) {
  const LthSparseGrid *g = body->staggered->fractions->grid;
  double nearest = INFINITY;
  for (LitheIndex p = 0; p < SEARCHED * SEARCHED * (g->dim == 3 ? SEARCHED : 1); p++) {
    LitheIndex place[3] = {p % SEARCHED, p / SEARCHED % SEARCHED, p / (SEARCHED * SEARCHED)};
    double z[3] = {x[0], x[1], x[2]};
    for (int a = 0; a < g->dim; a++)
      z[a] = g->origin[a] + g->h[a] * (floor((x[a] - g->origin[a]) / g->h[a]) - reach +
                                       (1 + 2 * reach) * (place[a] + 0.5) / SEARCHED);
    double distance = lth_v3_distance(x, z);
    if (!(distance < nearest) || !(lth_shape_value(&body->def->shape, z) < 0)) continue;
    nearest = distance;
    lth_v3_copy(z, y);
  }
  return isfinite(nearest);
}

/// Where the material of a place outside of the body is taken: at the boundary point nearest to it, or as deep below that as the
/// middle of a part of a cell is. False where x is inside.
static bool find_inner(const LthBody *body, const double x[3], double deep[3], double rim[3]) {
  const LthStaggeredBody *s = body->staggered;
  const LthShape *shape = &body->def->shape;
  LthFoot foot;
  if (lth_staggered_is_deep(s, x)) return false;
  if (!lth_shape_foot(shape, x, s->h, &foot)) { // as in an image that is even around x
    if (lth_shape_value(shape, x) < 0) return false;
    if (!search_cells(body, x, 0, rim) && !search_cells(body, x, 1, rim)) return false;
    lth_v3_copy(rim, deep);
    return true;
  }
  if (!(foot.distance > 0)) return false;
  lth_v3_copy(foot.point, rim);
  for (int a = 0; a < 3; a++) deep[a] = foot.point[a] - s->h / 4 * foot.normal[a];
  return true;
}

/// Constants, and what varies with the label alone, which is that of the nearest voxel of the body everywhere.
static bool is_even(const LthValue *v) {
  return !v->eval ||
         (v->eval == lth_expression_eval && !(lth_expression_uses(v->self) & ~LTH_USES_LABEL));
}

/// Cells at the boundary and sides that are held reach beyond the body, where a material need not say anything.
static bool find_constants(const LthBody *body, const double x[3], Constants *c) {
  double deep[3], rim[3];
  const LthMaterial *m = &body->def->materials[0].material;
  bool is_known = !body->def->materials[0].has_where && is_even(&m->young) &&
                  is_even(&m->poisson) && is_even(&m->density);
  if (is_known || !find_inner(body, x, deep, rim)) return read_constants(body, x, c);
  return read_constants(body, deep, c) || read_constants(body, rim, c);
}

LitheIndex lth_field_entry(const LthBody *body, const double x[3]) {
  double deep[3], rim[3];
  if (!body->def->materials[0].has_where) return 0;
  if (!find_inner(body, x, deep, rim)) return entry_at(body, x);
  LitheIndex entry = entry_at(body, deep);
  return entry < 0 ? entry_at(body, rim) : entry;
}

double lth_field_density(const LthBody *body, const double x[3]) {
  const LthValue *first = &body->def->materials[0].material.density;
  Constants c;
  if (!body->def->materials[0].has_where && !first->eval) return first->constant;
  find_constants(body, x, &c);
  return c.density;
}

static void eval(const void *self, const double x[3], double *young, double *poisson,
                 double *density) {
  Constants c;
  find_constants(self, x, &c);
  *young = c.young;
  *poisson = c.poisson;
  *density = c.density;
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
  s->formulation = lth_body_formulation(body);
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
    Constants c;
    if (!(s->filled[slot] > 0)) continue;
    lth_sparse_grid_cell(g, slot, at);
    lth_sparse_grid_place(g, at, middle, x);
    if (find_constants(body, x, &c)) continue;
    if (c.entry < 0)
      LITHE_FAIL(ctx, LITHE_BAD_INPUT,
                 "%s.material: no entry holds the cell at (%g, %g, %g); end the list with one that "
                 "has no `where`",
                 body->def->place, x[0], x[1], x[2]);
    LITHE_TRY(lth_check_constants(ctx, body, x, c.young, c.poisson, c.density));
  }
  return LITHE_OK;
}
