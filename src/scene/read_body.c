/// Bodies: name, placed shape, state at the start, embedded surface.
#include "scene/reader.h"

#include "base/tensor.h"

#include <math.h>
#include <string.h>

/// Sizes that a body hardly has; then a unit is probably wrong [m].
#define BODY_SMALL 1e-3
#define BODY_LARGE 10.0

/// Powers of lengths beyond these leave the range of numbers [m].
#define LENGTH_MIN 1e-12
#define LENGTH_MAX 1e12

static void check_size(LthReader *r, LthNode *shape, const LthSceneBody *body) {
  double min[3], max[3], largest = 0;
  if (body->elements) {
    lth_v3_copy(body->elements_box, min);
    lth_v3_copy(body->elements_box + 3, max);
  } else {
    lth_shape_bounds(&body->shape, min, max);
  }
  for (int i = 0; i < 3; i++) largest = fmax(largest, fmax(fabs(min[i]), fabs(max[i])));
  double size = fmax(max[0] - min[0], fmax(max[1] - min[1], max[2] - min[2]));
  if (!(size >= LENGTH_MIN && largest <= LENGTH_MAX)) {
    lth_report(r->report, shape,
               "no size that can be computed with, got %g m at up to %g m from the origin; "
               "expected a body "
               "from %g m on within %g m",
               size, largest, LENGTH_MIN, LENGTH_MAX);
    return;
  }
  if (size > BODY_LARGE)
    lth_warn(r->ctx,
             "%s: body %s is %.4g m long: if its file is in millimetres, write `unit: mm` in mesh",
             body->path, body->name, size);
  else if (size < BODY_SMALL && size > 0)
    lth_warn(r->ctx, "%s: body %s is only %.4g mm long: is the unit of its shape right?",
             body->path, body->name, 1e3 * size);
}

/// What a body's mesh file knows beyond its triangles.
static void keep_mesh(LthReader *r, LthSceneBody *body) {
  for (int i = 0; i < 3; i++) {
    for (int j = 0; j < 3; j++) body->file_to_scene[4 * i + j] = body->place_rotation[3 * i + j];
    body->file_to_scene[4 * i + 3] = body->place_translation[i];
  }
  if (!body->shape.soup) return;
  memcpy(body->file_to_scene, r->mesh_to_scene, sizeof body->file_to_scene);
  LthSceneOwned *owned = r->owned;
  for (LitheCount i = 0; i < owned->n_soups; i++)
    if (owned->soups[i] == body->shape.soup) body->soup = owned->soups[i];
  for (LitheCount i = 0; i < owned->n_surfaces; i++)
    if (owned->surfaces[i] == body->shape.surface) body->surface = owned->surfaces[i];
}

static LitheStatus read_body_shape(LthReader *r, const LthNode *node, const LthPlacement *place,
                                   LthSceneBody *body) {
  const LthNode *shape = lth_node_get(node, "shape");
  double search[6];
  const LthNode *grid = lth_node_get(lth_node_get(node, "method"), "grid");
  bool has_grid = lth_read_vector(grid, "min", search) && lth_read_vector(grid, "max", search + 3);
  LITHE_TRY(lth_read_shape(r, shape, place, has_grid ? search : NULL, false, &body->shape));
  body->shape_resolution = lth_read_number(shape, "resolution", 0);
  keep_mesh(r, body);
  r->image = body->shape.kind == LTH_SHAPE_IMAGE ? body->shape.image : NULL;
  r->image_is_missing = !r->image && lth_node_find(shape, "image");
  body->has_shape = shape != NULL;
  bool is_sound = shape && lth_node_is_sound(shape);
  if (is_sound) check_size(r, lth_node_find(node, "shape"), body);
  if (!lth_node_find(node, "shape") && !lth_method_has_file(lth_node_find(node, "method")))
    lth_report_missing(r->report, node, "shape",
                       "missing; expected a shape such as {mesh: {file: part.obj}} or {box: {min, "
                       "max}}");
  return LITHE_OK;
}

/// The mesh of a file, and what `where` may name of it.
static LitheStatus read_body_elements(LthReader *r, const LthNode *method,
                                      const LthPlacement *place, LthSceneBody *body) {
  r->labels = LTH_LABELS_NONE;
  r->elements = NULL;
  if (!lth_method_has_file(method)) return LITHE_OK;
  LthNode *mesh = lth_node_find(method, "mesh");
  r->labels = LTH_LABELS_UNKNOWN;
  LITHE_TRY(lth_read_elements(r, mesh, place, body));
  if (!body->elements) return LITHE_OK;
  check_size(r, mesh, body);
  r->labels = LTH_LABELS_OF_FILE;
  r->elements = body->elements;
  return LITHE_OK;
}

static void check_box_mesh(LthReader *r, const LthNode *node, const LthSceneBody *body) {
  LthNode *mesh = lth_node_find(lth_node_find(node, "method"), "mesh");
  bool needs_box = body->mesh_kind == LTH_MESH_HEXAHEDRA || body->mesh_kind == LTH_MESH_TETRAHEDRA;
  if (!mesh || mesh->bad || !needs_box) return;
  LthNode *shape = lth_node_find(node, "shape");
  if (body->shape.kind == LTH_SHAPE_BOX || !shape || shape->bad) return;
  bool is_turned = lth_node_find(shape, "box") != NULL;
  lth_report(r->report, mesh, "%s, got %s; expected %s",
             is_turned ? "it needs a box along the axes and "
                         "this one is rotated"
                       : "it needs a box and the shape is another",
             lth_show(r->arena, mesh),
             body->method_kind == LTH_METHOD_CG ? "voxels or embedded" : "slice");
}

LitheStatus lth_read_embed(LthReader *r, const LthNode *node, const LthPlacement *place,
                           LthSceneBody *body) {
  static const char *const interpolations[] = {"mls", "stitched", NULL};
  static const char *const samples[] = {"nodes", "edges", "faces", "cells", NULL};
  if (!node || lth_node_is_null(node)) return LITHE_OK;
  if (r->scene->dimension == 2) {
    lth_report(r->report, node,
               "a surface has no place in the plane, got %s; expected no `embed` (fields show "
               "the deformed shape)",
               lth_show(r->arena, node));
    return LITHE_OK;
  }
  body->has_embed = true;
  body->interpolation = (LthInterpolation)lth_read_word(node, "interpolation", interpolations);
  body->samples = (LthSamples)lth_read_word(node, "samples", samples);
  const LthNode *surface = lth_node_get(node, "surface");
  if (!surface || lth_node_is_text(surface, "shape")) return LITHE_OK;
  LthMeshFile mesh;
  if (surface->kind == LTH_NODE_MAP)
    LITHE_TRY(lth_read_mesh(r, surface, place, false, &mesh));
  else
    LITHE_TRY(lth_read_mesh_as(r, surface, body->file_to_scene, &mesh));
  body->embed_soup = mesh.soup;
  return LITHE_OK;
}

static LitheStatus read_body(LthReader *r, const LthNode *node, LthSceneBody *body) {
  const char *path = lth_node_path(r->arena, node, NULL), *name = lth_read_text(node, "name");
  const char *given = name ? name : "body";
  body->path = lth_arena_text(r->arena, path ? path : "", path ? strlen(path) : 0);
  body->place = lth_report_place(r->report, node);
  body->name = lth_arena_text(r->arena, given, strlen(given));
  if (!body->path || !body->name)
    LITHE_FAIL(r->ctx, LITHE_NO_MEMORY, "out of memory while reading the scene");

  LthPlacement place;
  lth_read_placement(r, lth_node_get(node, "place"), &place);
  memcpy(body->place_rotation, place.rotation, sizeof place.rotation);
  lth_v3_copy(place.translation, body->place_translation);
  LITHE_TRY(read_body_shape(r, node, &place, body));
  lth_read_method(r, lth_node_get(node, "method"), body);
  check_box_mesh(r, node, body);
  LITHE_TRY(read_body_elements(r, lth_node_get(node, "method"), &place, body));
  LITHE_TRY(lth_read_material(r, lth_node_get(node, "material"), body));
  LITHE_TRY(lth_read_constraints(r, lth_node_get(node, "constraints"), body));
  LITHE_TRY(lth_read_islands(r, lth_node_find(node, "shape"), body));
  LITHE_TRY(lth_read_loads(r, lth_node_get(node, "loads"), body));
  const LthNode *initial = lth_node_get(node, "initial");
  lth_read_values(initial, "velocity", body->initial_velocity);
  lth_read_values(initial, "displacement", body->initial_displacement);
  r->image = NULL;
  r->image_is_missing = false;
  r->labels = LTH_LABELS_UNKNOWN; // selections of others are checked where their bodies are known
  return lth_read_embed(r, lth_node_get(node, "embed"), &place, body);
}

static void check_names(LthReader *r, const LthNode *bodies) {
  for (const LthNode *a = bodies->first; a; a = a->next)
    for (const LthNode *b = bodies->first; b != a; b = b->next) {
      LthNode *name = lth_node_find(a, "name");
      const LthNode *other = lth_node_find(b, "name");
      if (!name || name->bad || name->kind != LTH_NODE_SCALAR ||
          !lth_node_is_text(other, name->text))
        continue;
      lth_report(r->report, name, "the name is taken, got %s twice; expected names that differ",
                 lth_show(r->arena, name));
      break;
    }
}

LitheStatus lth_read_bodies(LthReader *r) {
  // a list that is longer than this version takes is still checked
  const LthNode *bodies = lth_node_find(r->root, "bodies");
  if (!bodies || bodies->kind != LTH_NODE_LIST) return LITHE_OK;
  r->scene->bodies = lth_read_array(r, bodies, sizeof *r->scene->bodies);
  if (!r->scene->bodies)
    LITHE_FAIL(r->ctx, LITHE_NO_MEMORY, "out of memory while reading the scene");
  check_names(r, bodies);
  for (const LthNode *node = bodies->first; node; node = node->next) {
    LthSceneBody *body = &r->scene->bodies[r->scene->n_bodies++];
    body->shape = (LthShape){.kind = LTH_SHAPE_SPHERE, .radius = 1};
    LITHE_TRY(read_body(r, node, body));
  }
  return LITHE_OK;
}
