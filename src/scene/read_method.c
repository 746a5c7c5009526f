/// Method and material of a body.
#include "scene/reader.h"

#include "base/tensor.h"

/// Density of bodies whose mass does not count [kg/m^3].
#define ANY_DENSITY 1000.0

static void read_cells(const LthNode *cells, LitheIndex n[3]) {
  if (!cells) return;
  if (cells->kind == LTH_NODE_SCALAR) {
    n[0] = (LitheIndex)cells->value.constant;
    return;
  }
  LitheIndex i = 0;
  for (const LthNode *item = cells->first; item && i < 3; item = item->next)
    n[i++] = item->has_value ? (LitheIndex)item->value.constant : 1;
}

static void read_grid(LthReader *r, const LthNode *node, LthGrid *grid) {
  lth_read_vector(node, "min", grid->min);
  lth_read_vector(node, "max", grid->max);
  read_cells(lth_node_get(node, "cells"), grid->cells);
  int dim = r->scene->dimension;
  for (int i = 0; i < dim && lth_node_get(node, "min") && lth_node_get(node, "max"); i++) {
    if (grid->min[i] < grid->max[i]) continue;
    lth_report(r->report, lth_node_find(node, "max"),
               "an empty grid, got %g..%g along %c; expected max > min", grid->min[i], grid->max[i],
               "xyz"[i]);
    return;
  }
  if (dim == 2) grid->min[2] = -0.5, grid->max[2] = 0.5; // one cell of 1 m, as LthSparseGrid has it
}

static void read_penalty(const LthNode *node, LthSceneBody *body) {
  static const char *const scales[] = {"material", "none", NULL};
  body->penalty = LTH_PENALTY_AUTO;
  if (!node || lth_node_is_text(node, "auto")) return;
  bool is_plain = node->kind == LTH_NODE_MAP && lth_read_word(node, "scale", scales) == 1;
  body->penalty = is_plain ? LTH_PENALTY_ETA_PLAIN : LTH_PENALTY_ETA;
  body->eta = node->kind == LTH_NODE_MAP ? lth_read_number(node, "eta", 1) : node->value.constant;
}

/// A staggered body made from an image has its voxels.
static bool has_voxels(const LthReader *r, const LthNode *node) {
  return (r->image || r->image_is_missing) &&
         lth_node_is_text(lth_node_find(node, "kind"), "staggered");
}

/// Exactly one of these, but none where the mesh is a file's.
static void check_resolution(LthReader *r, const LthNode *node) {
  static const char *const keys[] = {"cells", "cell_size", "grid"};
  LthNode *found = NULL;
  bool has_bad_key = false;
  if (!node || node->kind != LTH_NODE_MAP) return;
  for (int i = 0; i < 3; i++) {
    LthNode *child = lth_node_find(node, keys[i]);
    if (child && lth_method_has_file(node)) {
      lth_report_key(r->report, child,
                     "the mesh is a file's, which has its own cells, got %s too; leave it out",
                     keys[i]);
      return;
    }
    if (child && found) {
      lth_report_key(r->report, child->index > found->index ? child : found,
                     "%s and %s exclude each other, got both; expected exactly one of cells, "
                     "cell_size, grid",
                     found->key, child->key);
      return;
    }
    if (child) found = child;
  }
  for (const LthNode *child = node->first; child; child = child->next)
    has_bad_key = has_bad_key || child->bad;
  if (found || has_bad_key || lth_method_has_file(node) || has_voxels(r, node)) return;
  lth_report(r->report, node, "incomplete, got %s; expected exactly one of cells, cell_size, grid",
             node->n_children ? "none of the keys it needs" : "an empty mapping");
}

static bool is_given(const LthNode *map, const char *key) {
  const LthNode *node = lth_node_find(map, key);
  return node && !node->is_default && !node->bad;
}

/// A mesh that the other method has.
static void check_mesh_of(LthReader *r, const LthNode *node, const LthSceneBody *body) {
  LthNode *mesh = lth_node_find(node, "mesh");
  bool is_cg = body->method_kind == LTH_METHOD_CG;
  if (is_cg && body->mesh_kind == LTH_MESH_SLICE)
    lth_report(r->report, mesh,
               "slices are of dg, got %s; expected hexahedra, tetrahedra, voxels or embedded",
               lth_show(r->arena, mesh));
  if (!is_cg && (body->mesh_kind == LTH_MESH_VOXELS || body->mesh_kind == LTH_MESH_EMBEDDED))
    lth_report(r->report, mesh,
               "it is of `kind: cg`, got %s; expected slice, hexahedra or tetrahedra",
               lth_show(r->arena, mesh));
}

/// What conforming elements take of the method.
static void read_cg(LthReader *r, const LthNode *node, LthSceneBody *body) {
  static const char *const elements[] = {"hex27", "hex20", "hex20r", NULL};
  LthNode *degree = lth_node_find(node, "degree"), *element = lth_node_find(node, "element");
  body->hexahedron = (LthHexahedron)lth_read_word(node, "element", elements);
  if (!lth_method_has_file(node) && !is_given(node, "mesh"))
    body->mesh_kind = body->shape.kind == LTH_SHAPE_BOX ? LTH_MESH_HEXAHEDRA : LTH_MESH_VOXELS;
  if (is_given(node, "degree") && (body->degree < 1 || body->degree > 2))
    lth_report(r->report, degree, "cg has elements of degree 1 and 2, got %s; expected 1 or 2",
               lth_show(r->arena, degree));
  bool has_hexahedra = body->mesh_kind != LTH_MESH_TETRAHEDRA && !lth_method_has_file(node);
  if (is_given(node, "element") && (body->degree != 2 || !has_hexahedra))
    lth_report(r->report, element,
               "it says which hexahedra of degree 2, got %s with %s; expected them, or no element",
               lth_show(r->arena, element), has_hexahedra ? "another degree" : "another mesh");
}

/// What the staggered grid takes of the method.
static void read_staggered(LthReader *r, const LthNode *node, LthSceneBody *body) {
  static const char *const formulations[] = {"auto", "displacement", "mixed", NULL};
  const LthNode *fractions = lth_node_get(node, "fractions");
  LthNode *mesh = lth_node_find(node, "mesh");
  body->formulation = (LthSceneFormulation)lth_read_word(node, "formulation", formulations);
  body->has_fractions = is_given(node, "fractions");
  body->fractions = (LthFractionDef){.method = LTH_FRACTIONS_EXACT};
  if (lth_node_is_text(fractions, "smooth")) body->fractions.method = LTH_FRACTIONS_SMOOTH;
  if (lth_node_get(fractions, "smooth")) {
    body->fractions.method = LTH_FRACTIONS_SMOOTH;
    body->fractions.half_width = lth_read_number(fractions, "smooth", 0);
  } else if (fractions && fractions->kind == LTH_NODE_MAP) {
    body->fractions.method = LTH_FRACTIONS_SAMPLES;
    body->fractions.samples = lth_read_integer(fractions, "samples", 2);
    if (body->fractions.samples % 2 != 0)
      lth_report(r->report, lth_node_find(fractions, "samples"),
                 "control volumes share halves of cells, got %d samples; expected an even number",
                 body->fractions.samples);
  }
  if (is_given(node, "mesh"))
    lth_report_key(r->report, mesh,
                   "a staggered grid has no mesh, got %s; expected cells, cell_size or grid alone",
                   lth_show(r->arena, mesh));
  static const char *const others[] = {"degree", "flux", "penalty", "sliver", "element"};
  for (size_t i = 0; i < sizeof others / sizeof *others; i++)
    if (is_given(node, others[i]))
      lth_report_key(r->report, lth_node_find(node, others[i]),
                     "it is of elements, got %s with `kind: staggered`; leave it out", others[i]);
}

/// What elements do not take of the method.
static void check_grid_keys(LthReader *r, const LthNode *node) {
  static const char *const keys[] = {"fractions", "formulation"};
  for (size_t i = 0; i < sizeof keys / sizeof *keys; i++)
    if (is_given(node, keys[i]))
      lth_report_key(r->report, lth_node_find(node, keys[i]),
                     "it is of a staggered grid, got %s with elements; leave it out, or write "
                     "`kind: staggered`",
                     keys[i]);
}

static void check_dimension(LthReader *r, const LthNode *node, const LthSceneBody *body) {
  LthNode *kind = lth_node_find(node, "kind");
  if (r->scene->dimension == 3 || body->method_kind == LTH_METHOD_STAGGERED || !kind || kind->bad)
    return;
  if (kind->is_default)
    lth_report_missing(r->report, node, "kind",
                       "missing, and scenes of two dimensions have one method alone; expected "
                       "staggered");
  else
    lth_report(r->report, kind, "it works in three dimensions alone, got %s; expected staggered",
               lth_show(r->arena, kind));
}

void lth_read_method(LthReader *r, const LthNode *node, LthSceneBody *body) {
  static const char *const kinds[] = {"dg", "cg", "staggered", NULL};
  static const char *const meshes[] = {"slice",  "hexahedra", "tetrahedra",
                                       "voxels", "embedded",  NULL};
  static const char *const fluxes[] = {"ip", "bz", NULL};
  const LthNode *grid = lth_node_get(node, "grid");
  body->method_kind = (LthMethodKind)lth_read_word(node, "kind", kinds);
  check_dimension(r, node, body);
  check_resolution(r, node);
  body->mesh_kind =
      lth_method_has_file(node) ? LTH_MESH_FILE : (LthMeshKind)lth_read_word(node, "mesh", meshes);
  body->flux = (LthFlux)lth_read_word(node, "flux", fluxes);
  body->degree_at = lth_read_value(node, "degree");
  body->degree = body->degree_at.eval ? 0 : lth_read_integer(node, "degree", 1);
  body->sliver = lth_read_number(node, "sliver", 0.05);
  read_cells(lth_node_get(node, "cells"), body->resolution.cells);
  body->resolution.cell_size = lth_read_number(node, "cell_size", 0);
  body->resolution.has_grid = grid != NULL;
  if (grid) read_grid(r, grid, &body->resolution.grid);
  read_penalty(lth_node_get(node, "penalty"), body);
  if (body->method_kind == LTH_METHOD_STAGGERED) {
    read_staggered(r, node, body);
    return;
  }
  check_grid_keys(r, node);
  if (!lth_method_has_file(node) && is_given(node, "mesh")) check_mesh_of(r, node, body);
  if (body->method_kind == LTH_METHOD_CG) read_cg(r, node, body);
}

/// Why the mass of bodies counts in this scene; NULL where it does not.
static const char *why_mass(const LthReader *r) {
  const LthNode *time = lth_node_find(r->root, "time");
  bool is_dynamic = lth_node_is_text(time, "dynamic") || lth_node_find(time, "dynamic") ||
                    lth_node_is_text(lth_node_find(time, "kind"), "dynamic");
  if (is_dynamic) return "time is dynamic";
  double gravity[3];
  lth_read_vector(r->root, "gravity", gravity);
  return lth_v3_norm(gravity) > 0 ? "gravity acts" : NULL;
}

/// What keeps its volume needs a pressure of its own.
static void check_poisson(LthReader *r, const LthNode *node, const LthSceneBody *body,
                          LthMaterialModel model) {
  if (lth_read_number(node, "poisson_ratio", 0) < 0.5) return;
  bool is_staggered = body->method_kind == LTH_METHOD_STAGGERED;
  bool may_be_mixed = is_staggered && body->formulation != LTH_FORMULATION_DISPLACEMENT;
  if (may_be_mixed && model != LTH_MATERIAL_LINEAR) {
    lth_report(r->report, lth_node_find(node, "poisson_ratio"),
               "only the mixed formulation keeps volumes, and it is of linear bodies, got 0.5 with "
               "model %s; expected a number < 0.5, or `model: linear`",
               model == LTH_MATERIAL_COROTATED ? "corotated" : "neo-hookean");
    return;
  }
  if (may_be_mixed) return;
  lth_report(r->report, lth_node_find(node, "poisson_ratio"),
             "only the mixed formulation keeps volumes, got 0.5 with %s; expected a number < 0.5, "
             "or `kind: staggered` with `formulation: mixed`",
             is_staggered                         ? "formulation displacement"
             : body->method_kind == LTH_METHOD_CG ? "kind cg"
                                                  : "kind dg");
}

static LitheStatus read_one(LthReader *r, const LthNode *node, const LthSceneBody *body,
                            LthSceneMaterial *out) {
  static const char *const models[] = {"linear", "corotated", "neo-hookean", NULL};
  LthMaterial *m = &out->material;
  m->model = lth_node_get(node, "model") ? (LthMaterialModel)lth_read_word(node, "model", models)
                                         : LTH_MATERIAL_COROTATED;
  m->young = lth_read_value(node, "young_modulus");
  m->poisson = lth_read_value(node, "poisson_ratio");
  m->density = lth_read_value(node, "density");
  check_poisson(r, node, body, m->model);
  const char *why = why_mass(r);
  if (node->kind == LTH_NODE_MAP && !node->bad && !lth_node_find(node, "density")) {
    m->density = lth_value_constant(ANY_DENSITY);
    if (why)
      lth_report_missing(r->report, node, "density",
                         "missing, but %s; expected a number > 0 [kg/m^3]", why);
  }
  const LthNode *damping = lth_node_get(node, "damping");
  m->damping_mass = lth_read_number(damping, "mass", 0);
  m->damping_stiffness = lth_read_number(damping, "stiffness", 0);
  m->yield_strength = lth_read_number(node, "yield_strength", 0);
  const LthNode *where = lth_node_get(node, "where");
  out->has_where = where != NULL;
  return lth_read_where(r, where, &out->where);
}

static void check_list(LthReader *r, const LthNode *list, const LthSceneBody *body) {
  LitheIndex i = 0;
  for (LthNode *node = list->first; node; node = node->next, i++) {
    const LthMaterial *m = &body->materials[i].material, *first = &body->materials[0].material;
    if (node->bad || node->kind != LTH_NODE_MAP) continue;
    if (!body->materials[i].has_where && node->next && !lth_node_find(node, "where"))
      lth_report_missing(r->report, node, "where",
                         "missing, and the materials behind would have no place; "
                         "expected a selection, or the material at the end of the list");
    if (m->model != first->model)
      lth_report(r->report, lth_node_find(node, "model"),
                 "materials of one body differ in their model, got "
                 "%s; expected the first one's",
                 lth_show(r->arena, lth_node_find(node, "model")));
  }
}

/// `value` and `label` in the numbers of a material.
static void bind_numbers(LthReader *r, const LthNode *node) {
  static const char *const keys[] = {"young_modulus", "poisson_ratio", "density"};
  for (int i = 0; i < 3; i++) lth_bind_image(r, node, keys[i]);
}

LitheStatus lth_read_material(LthReader *r, const LthNode *node, LthSceneBody *body) {
  bool is_list = node && node->kind == LTH_NODE_LIST;
  body->materials = lth_read_array(r, is_list ? node : NULL, sizeof *body->materials);
  if (!body->materials)
    LITHE_FAIL(r->ctx, LITHE_NO_MEMORY, "out of memory while reading the scene");
  if (!node) return LITHE_OK;
  if (!is_list) {
    body->n_materials = 1;
    bind_numbers(r, node);
    return read_one(r, node, body, &body->materials[0]);
  }
  for (const LthNode *item = node->first; item; item = item->next) {
    bind_numbers(r, item);
    LITHE_TRY(read_one(r, item, body, &body->materials[body->n_materials++]));
  }
  check_list(r, node, body);
  return LITHE_OK;
}
